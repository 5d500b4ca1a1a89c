"""Measurements of the rope of a span: its height at places in plan, as a laser scanner or a total station finds it, and
the time in which a blow on it returns, as a rigger takes it with a stopwatch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ropeway.components import catenary
from ropeway.components.errors import EquilibriumError, UnknownNameError
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.statics.line_state import load_force, span_rope
from ropeway.systems.studies.sensitivity.reading import Reading

ROPE_X, ROPE_Y, ROPE_Z = "rope_x", "rope_y", "rope_z"
"""Quantities of a span for points on its rope: place x, y in plan (given) and height z (measured) [m]."""
RETURN_TIME = "return_time"
"""Quantity of a span: time [s] in which a blow on the rope at end a returns from the nearest load, or from end b."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_NEAR = 1e-12
"""Accuracy of a point along the rope, relative to the span."""
_MOST = 40
"""Largest number of Newton steps to a point."""

Read = Callable[[str], Any]
"""The value of a quantity by its name, also a complex one."""


def rope_points(model: Model, runs: Sequence[Run], span: str, at: np.ndarray) -> Reading:
    """The heights of a span's rope at places (n, 2) in plan [m]; an unknown y is NaN. Raises UnknownNameError."""
    rope = _rope_of(model, runs, span)
    return rope.reading(lambda read: rope.heights(read, at))


def return_time(model: Model, runs: Sequence[Run], span: str) -> Reading:
    """The time [s] in which a transverse wave returns to end a of a span. Raises UnknownNameError."""
    rope = _rope_of(model, runs, span)
    return rope.reading(rope.return_time)


def _rope_of(model: Model, runs: Sequence[Run], span: str) -> _SpanRope:
    """The rope of a span by its name. Raises UnknownNameError."""
    for r, run in enumerate(runs):
        for k, one in enumerate(run.spans):
            if one.name == span:
                return _SpanRope(model, run, k, int(model.layouts[r].slots.count[k]))
    raise UnknownNameError(f"No span {span!r}", f"Spans are {', '.join(s.name for run in runs for s in run.spans)}")


@dataclass(frozen=True)
class _SpanRope:
    """The rope of span `k` of a run, whose loads are in so many `slots`."""

    model: Model
    run: Run
    k: int
    slots: int

    def reading(self, of: Callable[[Read], np.ndarray]) -> Reading:
        """A function of all that the span's rope depends on, as a reading."""
        names = list[str]()

        def noted(name: str) -> float:
            if name not in names:
                names.append(name)
            return 1.0

        self._parts(noted)
        return Reading(tuple(names), lambda values: of(dict(zip(names, values, strict=True)).__getitem__))

    def _parts(self, read: Read) -> tuple[Any, ...]:
        """Tension vector at the start, rope, length, distances and forces of loads, start and end of the span."""
        name, model = self.run.spans[self.k].name, self.model
        force = tuple(read(f"{name}.force_{axis}") for axis in "xyz")
        distances = [read(f"{name}.slot_distance[{j + 1}]") for j in range(self.slots)]
        drag = [read(f"{name}.slot_drag[{j + 1}]") if model.weather else 0.0 for j in range(self.slots)]
        masses = [read(f"{name}.slot_mass[{j + 1}]") for j in range(self.slots)]
        loads = [load_force(model, mass, area, read) for mass, area in zip(masses, drag, strict=True)]
        read(f"{name}.mass_per_length")
        rope, length = span_rope(model, self.run, self.k, read), read(f"{name}.length")
        return force, rope, length, distances, loads, self.run.start(self.k, read), self.run.end(self.k, read)

    def return_time(self, read: Read) -> np.ndarray:
        """Time of a transverse wave from end a to the nearest load, or to end b, and back [s], (1,). A metre as strung
        takes sqrt(mass per metre as strung * stretched length / T)."""
        force, rope, length, distances, _, _, _ = self._parts(read)
        name = self.run.spans[self.k].name
        loaded = [j for j in range(self.slots) if read(f"{name}.slot_mass[{j + 1}]").real > 0.0]
        way = distances[loaded[0]] if loaded else length
        tension = catenary.norm(catenary.end_of(force, rope.weight, 0.5 * (1.0 + _NODES) * way))
        stretched = rope.strain.expansion + rope.strain.at(tension)
        slowness = np.sqrt(read(f"{name}.mass_per_length") * stretched / tension)
        return np.array([(_WEIGHTS @ slowness) * way])

    def heights(self, read: Read, places: np.ndarray) -> np.ndarray:
        """Heights z (n,) of the rope at places (n, 2) in plan; complex numbers carry derivatives. Raises
        EquilibriumError."""
        force, rope, length, distances, loads, start, end = self._parts(read)
        along = (end - start)[:2] / np.sqrt(((end - start)[:2] ** 2).sum())
        without_y = np.isnan(places[:, 1])

        def place(x: Any, y: Any, of: Any = slice(None)) -> Any:
            """Distance in plan from the start, along the chord, of some of the points."""
            return np.where(without_y[of], x / along[0], x * along[0] + y * along[1])

        wanted = place(places[:, 0] - start[0], np.nan_to_num(places[:, 1]) - start[1])
        found, left = np.zeros(len(places), dtype=complex), np.ones(len(places), dtype=bool)
        reach: Any = np.zeros(3, dtype=complex)
        here: Any = 0.0
        for i, cut in enumerate([*distances, length]):
            piece = catenary.segment(force, rope.weight, cut - here, rope.strain)
            beyond = reach + np.array(piece.reach)
            inside = left & ((wanted.real <= place(beyond[0], beyond[1]).real) | (i == self.slots))
            if inside.any():
                inner = partial(place, of=inside)
                found[inside] = start[2] + _rise(force, rope, wanted[inside], reach, inner, cut - here)
            left &= ~inside
            reach, here = beyond, cut
            force = piece.force if i == self.slots else catenary.after(piece.force, loads[i])
        return found if np.iscomplexobj(np.array(force)) else found.real


def _rise(
    force: catenary.Vector,
    rope: Any,
    wanted: np.ndarray,
    before: np.ndarray,
    place: Callable[[Any, Any], Any],
    length: Any,
) -> np.ndarray:
    """Heights (n,) above the span's start of points in plan on a load-free piece that begins at `before` (3,). Raises
    EquilibriumError."""
    s = np.full(len(wanted), 0.5 * length, dtype=complex)
    for _ in range(_MOST):
        part = catenary.segment(force, rope.weight, s, rope.strain)
        pull = catenary.norm(part.force)
        longer = (rope.strain.expansion + rope.strain.at(pull)) / pull
        off = wanted - place(before[0] + part.reach[0], before[1] + part.reach[1])
        step = off / place(part.force[0] * longer, part.force[1] * longer)
        s = s + step
        if np.all(np.abs(step) <= _NEAR * (np.abs(length) + np.abs(s))):
            return np.asarray(before[2] + catenary.segment(force, rope.weight, s, rope.strain).reach[2])
    raise EquilibriumError("A point cannot be found on the rope", "Check that the points lie on this span")
