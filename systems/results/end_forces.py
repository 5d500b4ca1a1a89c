"""Forces at the ends of all spans in many states of a model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.certificate.certify import shape_of
from ropeway.systems.statics.certificate.spans import hung, pulls, read_spans
from ropeway.systems.statics.certificate_layout import layout_of


class EndForces(NamedTuple):
    """Pulls of all spans on what their ends sit at, (3, states, 2 spans + 1): of ends a, of ends b, and none [N]; and
    their chord vectors, (states, 3, spans) [m]."""

    pulls: np.ndarray
    chord: np.ndarray


def end_forces(
    model: Model,
    points: Sequence[Point],
    runs: Sequence[Run],
    passed: Sequence[np.ndarray],
    masses: Sequence[np.ndarray] | None = None,
) -> EndForces:
    """Forces at the ends of all spans, by the closed form of the certificate, which shares no code with the residuals.

    Parameters
    ----------
    model : Model
        The model of the states.
    points : sequence of Point
        The solved points.
    runs : sequence of Run
        The ropes with their loads.
    passed : sequence of ndarray
        For each run the loads that have passed each support, (supports,), the same in all states.
    masses : sequence of ndarray, optional
        For each run the masses of its loads in each state, (states, loads); by default those of `runs`.

    Returns
    -------
    EndForces
    """
    layout = layout_of(model)
    places = layout.spans
    values = np.array([np.concatenate((q.x, q.z, q.u, q.p, q.d, (0.0,))) for q in points])
    gravity = values[:, places.gravity, None]
    beyond = [np.repeat(counts[None], len(points), axis=0) for counts in passed]
    with np.errstate(all="ignore"):  # slots without a load
        spans = read_spans(places, values, gravity)
        loads = hung(places, values, spans, runs, beyond, masses, weather=layout.weather is not None)
        found, ends = shape_of(layout, values, spans, loads, gravity)
        return EndForces(pulls(spans, found, ends), spans.way)
