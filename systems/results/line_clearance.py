"""Heights over the ground along a run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np
import pandas as pd

from ropeway.components.errors import InputError
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.solvers.newton import Point
from ropeway.systems.statics.equilibrium import Equilibrium

_POINTS = 25
"""Points of a span at every record: the chords between them are about 1 cm above its rope. The lowest record of each
span is measured again by more."""


def heights(model: Model, runs: tuple[Run, ...], states: Iterable[tuple[Point, Sequence[np.ndarray]]]) -> np.ndarray:
    """Smallest height of each span with its loads above the ground, at states with the loads that have passed.

    Returns
    -------
    ndarray, shape (states, spans)
        Heights [m].

    Raises
    ------
    InputError
        The system has no ground.
    """
    if model.system.ground is None:
        raise InputError(f"{model.name!r} has no ground", "Give its line a terrain")
    lines = (Equilibrium(model, point, runs, tuple(passed), ()) for point, passed in states)
    return np.array([[low.height for low in line.heights_over_ground(_POINTS)] for line in lines])


def clearance(
    names: Sequence[str], heights: np.ndarray, line_at: Callable[[int], Equilibrium], times: np.ndarray
) -> pd.DataFrame:
    """As `Equilibrium.clearance`, each span at the record in which it is lowest, with its time [s].

    Parameters
    ----------
    names : sequence of str
        Of the spans.
    heights : ndarray, shape (records, spans)
        As from `heights`.
    line_at : callable
        The line at a record.
    times : ndarray, shape (records,)
        Of the records [s].
    """
    lowest = np.argmin(heights, axis=0)
    rows: dict[str, pd.Series[float]] = {}
    for i in sorted(set(lowest.tolist())):
        frame = line_at(i).clearance.assign(time=times[i])
        rows |= {name: frame.loc[name] for name, own in zip(names, lowest, strict=True) if own == i}
    found = pd.DataFrame([rows[name] for name in names]).rename_axis("span")
    found.attrs["units"] = {**dict.fromkeys(found.columns, "m"), "time": "s"}
    return found
