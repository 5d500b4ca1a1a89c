"""Equilibria of many variants of a line at once: other parameters, the same loads in the same spans.

What a variant needs beside Newton's method from the rest of the line, as loads that change spans, slack ropes or
another start, is done case by case by `equilibrium`: here such a case is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ropeway.components.check import Range
from ropeway.components.variable import Kind
from ropeway.systems.solvers.compiled_line import CompiledCases, compiled_line
from ropeway.systems.solvers.condensed_newton import Cases, CondensedNewton
from ropeway.systems.solvers.line_sections import line_sections
from ropeway.systems.solvers.state_rows import StateRows
from ropeway.systems.statics.certificate.certify import certified_variants, stacked
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.stability import SLACK


@dataclass(frozen=True)
class _Entry:
    """What a parameter changes: an entry of a vector, or the masses of `loads` (run, load) where there are any."""

    kind: Kind
    place: int
    range: Range
    loads: tuple[tuple[int, int], ...] = ()
    fed: bool = False


class LineVariants:
    """Variants of a line from its state at rest, with other values of the parameters `names`."""

    def __init__(self, state: LineState, names: Sequence[str], solver: CondensedNewton | CompiledCases) -> None:
        self._state, self._solver = state, solver
        self._entries = [_entry(state, name) for name in names]

    def solve(self, values: np.ndarray) -> tuple[np.ndarray, StateRows]:
        """Equilibria for values (cases, parameters): which are solved and certified, (cases,), and all cases, travels
        counted from their rest."""
        state, count = self._state, len(values)
        every = StateRows(state.model, np.repeat(stacked(state.point)[None], count, axis=0))
        cases = Cases(*every.columns.vectors)
        masses = [np.repeat(run.loads.mass[None], count, axis=0) for run in state.runs]
        good = self._set(values, cases, masses)
        self._write_slots(cases, masses)
        tried = np.flatnonzero(good)
        if len(tried) < count:
            part = Cases(*every.some(tried).columns.vectors)
            good[tried] = self._solver.solve(part)
            cases.z[:, tried] = part.z
        else:
            good = self._solver.solve(cases)
        for r in range(len(state.runs)):
            good &= self._settled(r, cases)
        which = np.flatnonzero(good)
        solved = every if len(which) == count else every.some(which)
        good[which] = certified_variants(state.model, state.runs, solved, state.passed, [m[which] for m in masses])
        self._rezero(cases)
        return good, every

    def _set(self, values: np.ndarray, cases: Cases, masses: Sequence[np.ndarray]) -> np.ndarray:
        """Writes the values; which cases have none that is refused."""
        good = np.isfinite(values).all(axis=1)
        vectors = {Kind.STATE: cases.x, Kind.INPUT: cases.u, Kind.PARAMETER: cases.p}
        for entry, column in zip(self._entries, values.T, strict=True):
            if entry.loads:
                good &= (column > 0.0) | ((column == 0.0) & entry.fed)
                for r, load in entry.loads:
                    masses[r][:, load] = column
                continue
            within = entry.range
            good &= (column > within.least if within.above else column >= within.least) & (column <= within.most)
            vectors[entry.kind][entry.place] = column
        return good

    def _write_slots(self, cases: Cases, masses: Sequence[np.ndarray]) -> None:
        """Masses of all loads on the line, and the places of those clamped to the rope."""
        for run, layout, beyond, mass in zip(
            self._state.runs, self._state.model.layouts, self._state.passed, masses, strict=True
        ):
            start = _starts(cases.p[layout.length_start])
            for k in range(len(run.spans)):
                for slot, load in enumerate(range(beyond[k] - 1, beyond[k + 1] - 1, -1)):
                    cases.d[layout.slots.mass[k] + slot] = mass[:, load]
                    if run.loads.pinned[load] < 0:
                        cases.d[layout.slots.at[k] + slot] = run.loads.place[load] - start[k]

    def _rope(self, r: int, cases: Cases) -> np.ndarray:
        """The rope at each support of a run, (supports, cases) [m]."""
        layout = self._state.model.layouts[r]
        rope = _starts(cases.p[layout.length_start])
        for places, vector in ((layout.travel.state, cases.x), (layout.travel.algebraic, cases.z)):
            rope[places >= 0] -= vector[places[places >= 0]]
        return rope

    def _settled(self, r: int, cases: Cases) -> np.ndarray:
        """In which cases all loads of a run are in their spans, and no rope on idlers is slack."""
        run, beyond, rope = self._state.runs[r], self._state.passed[r], self._rope(r, cases)
        loads, near, length = run.loads, 1e-10 * (1.0 + np.abs(rope)), np.diff(rope, axis=0)
        place = np.repeat(loads.place[:, None], rope.shape[1], axis=1)
        pinned = np.flatnonzero(loads.pinned >= 0)
        span, at = loads.pinned[pinned], loads.at[pinned, None]
        place[pinned] = np.minimum(rope[span] + at, np.maximum(rope[span], rope[span + 1]))
        good = ((at <= 0.0) | (at <= length[span] * (1.0 + 1e-9))).all(axis=0)
        if len(pinned):
            good &= (np.diff(place, axis=0) <= 0.0).all(axis=0)
        inner = range(len(beyond)) if run.feed is not None else range(1, len(beyond) - 1)
        for k in inner:
            n = int(beyond[k])
            if n > 0 and loads.pinned[n - 1] < 0:
                good &= place[n - 1] > rope[k] - near[k]
            if n < len(place) and loads.pinned[n] < 0:
                good &= place[n] <= rope[k] + near[k]
        if run.feed is not None:
            good &= place[-1] <= rope[0]
        if any(node.balance is not None for node in run.nodes):
            places = self._solver.sections.point[self._supports(r)]
            chord = np.sqrt(sum(np.diff(cases.p[places[:, axis]], axis=0) ** 2 for axis in range(3)))
            good &= (length <= SLACK * chord).all(axis=0)
        return np.asarray(good)

    def _supports(self, r: int) -> slice:
        """The supports of a run, numbered through."""
        first = sum(len(run.nodes) for run in self._state.runs[:r])
        return slice(first, first + len(self._state.runs[r].nodes))

    def _rezero(self, cases: Cases) -> None:
        """Makes the present travel of the supports the zero, as `LineState.rezero`."""
        for r, layout in enumerate(self._state.model.layouts):
            rope, run, beyond = self._rope(r, cases), self._state.runs[r], self._state.passed[r]
            cases.p[layout.length_start] = np.diff(rope, axis=0)
            for k in range(len(run.spans)):
                for slot, load in enumerate(range(beyond[k] - 1, beyond[k + 1] - 1, -1)):
                    if run.loads.pinned[load] < 0:
                        cases.d[layout.slots.at[k] + slot] = run.loads.place[load] - rope[k]
            for places, vector in ((layout.travel.state, cases.x), (layout.travel.algebraic, cases.z)):
                vector[places[places >= 0]] = 0.0


def line_variants(state: LineState, names: Sequence[str], *, compiled: bool = False) -> LineVariants | None:
    """The solver of variants of a line from its state at rest, in the compiled core or not; None where they must be
    solved one by one."""
    sections = line_sections(state.model)
    if isinstance(sections, str) or state.model.free_states or state.standing():
        return None
    if any(run.around for run in state.runs):
        return None
    try:
        used = sections.used(state.passed)
        core = CompiledCases(compiled_line(state.model), used) if compiled else CondensedNewton(sections, used)
        return LineVariants(state, names, core)
    except _OneByOneError:
        return None


class _OneByOneError(Exception):
    """A parameter changes more than an entry."""


def _entry(state: LineState, name: str) -> _Entry:
    owner, _, quantity = name.rpartition(".")
    loads = tuple((r, i) for r, run in enumerate(state.runs) for i, load in enumerate(run.loads.names) if load == owner)
    if quantity == "mass" and loads:
        return _Entry(Kind.DISCRETE, -1, Range(), loads, state.runs[loads[0][0]].feed is not None)
    kind, place = state.find(state.model.swaps.get(name, name))
    if kind not in (Kind.STATE, Kind.INPUT, Kind.PARAMETER):
        raise _OneByOneError
    return _Entry(kind, place, state.model.tables[kind].ranges[place])


def _starts(lengths: np.ndarray) -> np.ndarray:
    """The rope at each support at zero travel, (supports, cases) [m], from the lengths of the spans."""
    return np.concatenate([np.zeros((1, lengths.shape[1])), np.cumsum(lengths, axis=0)])
