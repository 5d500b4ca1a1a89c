"""Points on the rope of a span, as a laser scanner or a total station measures them: its height at places in plan."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components import catenary
from ropeway.components.errors import EquilibriumError, UnknownNameError
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.studies.sensitivity.reading import Reading

ROPE_X, ROPE_Y, ROPE_Z = "rope_x", "rope_y", "rope_z"
"""Quantities of a span for points on its rope: place x, y in plan (given) and height z (measured) [m]."""
_NEAR = 1e-12
"""Accuracy of a point along the rope, relative to the span."""


def rope_points(model: Model, runs: Sequence[Run], span: str, at: np.ndarray) -> Reading:
    """The heights of a span's rope at places (n, 2) in plan [m]; an unknown y is NaN. Raises UnknownNameError."""
    for r, run in enumerate(runs):
        for k, one in enumerate(run.spans):
            if one.name == span:
                return _reading(model, run, k, int(model.layouts[r].slots.count[k]), at)
    raise UnknownNameError(f"No span {span!r}", f"Spans are {', '.join(s.name for run in runs for s in run.spans)}")


def _reading(model: Model, run: Run, k: int, slots: int, at: np.ndarray) -> Reading:
    name, read = run.spans[k].name, list[str]()

    def noted(quantity: str) -> float:
        read.append(quantity)
        return 0.0

    run.start(k, noted)  # the names that the start of the span is made of, with a shoe's offset
    start = tuple(read)
    constructional = f"{name}.construction" in model.p.index
    own = ["force_x", "force_y", "force_z", "mass_per_length", "compliance", "length"]
    names = [f"{name}.{quantity}" for quantity in own]
    loads = [f"{name}.slot_{what}[{j + 1}]" for what in ("distance", "mass") for j in range(slots)]
    more = [f"{name}.construction"] if constructional else []
    first = len(names) + 1
    order = [*names, "gravity", *more, *loads, *start]

    def heights(values: np.ndarray) -> np.ndarray:
        known = dict(zip(start, values[len(order) - len(start) :], strict=True))
        place = run.start(k, known.__getitem__)
        cuts = values[first + len(more) : first + len(more) + 2 * slots].reshape(2, slots)
        strain = catenary.Strain(values[4], values[first] if constructional else 0.0)
        return _heights(values[:3], values[3] * values[6], strain, values[5], cuts, values[6], place, at)

    return Reading(tuple(order), heights)


def _heights(
    force: np.ndarray,
    weight: complex,
    strain: catenary.Strain,
    length: complex,
    loads: np.ndarray,
    gravity: complex,
    start: np.ndarray,
    at: np.ndarray,
) -> np.ndarray:
    """Heights z (n,) of the rope. `loads` (2, slots): distance along the rope and mass of each. Complex numbers carry
    derivatives."""
    fx, fy = force[0], force[1]
    across = np.sqrt(fx * fx + fy * fy)
    ahead_x, ahead_y = at[:, 0] - start[0], at[:, 1] - start[1]
    flat = np.where(np.isnan(at[:, 1]), ahead_x * across / fx, (ahead_x * fx + ahead_y * fy) / across)
    found = np.full(len(at), np.nan + 0j)
    reach, height, here, vertical = 0.0 + 0j, start[2] + 0j, 0.0 + 0j, force[2] + 0j
    stations = [(distance, mass * gravity) for distance, mass in loads.T] + [(length, 0.0)]
    left = np.ones(len(at), dtype=bool)
    for i, (cut, load) in enumerate(stations):
        piece = catenary.segment((across + 0j, 0.0, vertical), weight, cut - here, strain)
        end = reach + piece.reach[0]
        inside = left & ((flat.real <= end.real) | (i == len(stations) - 1))
        if inside.any():
            wanted = flat[inside] - reach
            found[inside] = height + _rise(across, vertical, weight, strain, wanted, piece.reach[0].real)
        left &= ~inside
        reach, height, here = end, height + piece.reach[2], cut
        vertical = piece.force[2] + load
    return found if np.iscomplexobj(force) else found.real


def _rise(
    across: complex, vertical: complex, weight: complex, strain: catenary.Strain, flat: np.ndarray, whole: float
) -> np.ndarray:
    """Rise of a load-free piece at horizontal distances (n,) from its start. Raises EquilibriumError."""

    def reach(s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        part = catenary.segment((across + 0j, 0.0, vertical), weight, s, strain)
        tension = np.sqrt(across * across + part.force[2] ** 2)
        return part.reach[0], part.reach[2], across / tension * (1.0 + strain.at(tension))

    s = flat.real.astype(complex)
    for _ in range(40):
        gone, _, slope = reach(s)
        step = (flat - gone) / slope
        s = s + step
        if np.all(np.abs(step) <= _NEAR * (abs(whole) + np.abs(s))):
            return reach(s)[1]
    raise EquilibriumError("A point cannot be found on the rope", "Check that the points lie on this span")
