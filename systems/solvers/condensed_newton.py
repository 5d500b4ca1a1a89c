"""Newton's method for many cases of a line at once, in NumPy: forces eliminated span by span, then the travels of
idlers by one tridiagonal system a case (see `line_sections`).

Each case is solved as if it were alone: the numbers do not depend on the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.solvers.array_function import ArrayFunction
from ropeway.systems.solvers.line_sections import (
    SPAN_RESULTS,
    SUPPORT_RESULTS,
    LineSections,
    SpanForm,
    SupportForm,
    line_sections,
)
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.points import Point, Vectors

_ITERATIONS = 30
_CLOSE = 1e-12
"""Scaled step that the next iteration would make at a root."""
_FEW = 8
"""Points that are solved one by one."""
_BATCH = 12_000
"""Spans of all cases that are solved together, about: their arrays stay in the processor's cache."""


class Cases(Vectors):
    """Points of a model as columns: vectors of shape (variables, cases)."""

    def part(self, columns: slice) -> Cases:
        """Some of the cases; views."""
        return Cases(*(v[:, columns] for v in self.vectors))


class CondensedNewton:
    """The solver of a line with at most `used` loads in each span (spans,), in its first slots."""

    def __init__(self, sections: LineSections, used: np.ndarray) -> None:
        self.sections = sections
        self._spans = [
            (np.flatnonzero((sections.form == form) & (used == slots)), sections.forms[form], int(slots))
            for form, slots in sorted({*zip(sections.form.tolist(), used.tolist(), strict=True)})
        ]
        self._supports = [
            (np.flatnonzero((sections.balance >= 0) & (sections.support_form == number)), form)
            for number, form in enumerate(sections.support_forms)
        ]
        self.free = np.flatnonzero(sections.travel >= 0)
        m = sections.model
        self._nominal = m.z.nominals[:, None]
        self._closure = m.r.nominals[sections.closure[:, None] + np.arange(3)].T[:, :, None]
        self._balance = m.r.nominals[sections.balance[self.free]][:, None]

    def solve(self, cases: Cases) -> np.ndarray:
        """Solves for `cases.z` in place; returns which cases have converged, (cases,): the others are unchanged."""
        count = cases.z.shape[1]
        size = max(1, _BATCH // len(self.sections.form))
        with np.errstate(all="ignore"):  # a case that leaves its domain does not converge
            found = [self._solve(cases.part(slice(i, i + size))) for i in range(0, count, size)]
        return np.concatenate([np.zeros(0, dtype=bool), *found])

    def _solve(self, cases: Cases) -> np.ndarray:
        known = _Known(self, cases)
        z = np.ascontiguousarray(cases.z)
        good, active = np.zeros(z.shape[1], dtype=bool), np.arange(z.shape[1])
        last, before = np.full(len(active), np.inf), np.full(len(active), np.inf)
        for _ in range(_ITERATIONS):
            residual, move = self._step(z, known)
            size = np.abs(move / self._nominal).max(axis=0, initial=0.0)
            falls = (residual <= 0.9 * before) | (last < 1e-6)
            sound = np.isfinite(size) & np.isfinite(residual) & falls
            z = z + move
            # Convergence is quadratic: the next step would be about size * (size / last)^2.
            coming = np.where(np.isfinite(last), size * (size / last) ** 2, np.inf)
            done = sound & ((size <= _CLOSE) | ((size <= 1e-3) & (coming <= _CLOSE)))
            cases.z[:, active[done]] = z[:, done]
            good[active[done]] = True
            on = sound & ~done
            if not on.any():
                break
            last, before = size, residual
            if not on.all():
                active, last, before, z = active[on], last[on], before[on], np.ascontiguousarray(z[:, on])
                known = known.some(on)
        return good

    def _step(self, z: np.ndarray, known: _Known) -> tuple[np.ndarray, np.ndarray]:
        """Largest scaled residual of each case (cases,), and the step of Newton's method (nz, cases)."""
        s, count = self.sections, z.shape[1]
        q = known.travels(z)
        spans = np.empty((SPAN_RESULTS, len(s.form), count))
        for (which, _, _), function, before, after in known.spans:
            force = [z[s.force[which] + i] for i in range(3)]
            a, b = s.start[which], s.start[which] + 1
            for i, result in enumerate(function([*known.shared, *force, *before, q[a], *after, q[b]])):
                spans[i, which] = result
        supports = np.zeros((SUPPORT_RESULTS, len(s.travel), count))
        for (which, _), function, before, speed in known.supports:
            inputs = [*known.shared, *before, q[which], *spans[3:6, known.coming[which]], *self._going(z, which), speed]
            for i, result in enumerate(function(inputs)):
                supports[i, which] = result
        dq = self._travels(spans, supports, known.coming)
        a, b = s.start, s.start + 1
        move = np.empty_like(z)
        for i in range(3):
            move[s.force + i] = spans[6 + i] + spans[9 + i] * dq[a] + spans[12 + i] * dq[b]
        move[s.travel[self.free]] = dq[self.free]
        worst = np.abs(spans[:3] / self._closure).max(axis=(0, 1))
        if len(self.free):
            worst = np.maximum(worst, np.abs(supports[0, self.free] / self._balance).max(axis=0))
        return worst, move

    def _going(self, z: np.ndarray, supports: np.ndarray) -> list[np.ndarray]:
        """Tension vectors of the spans that start at supports; of any other where the rope ends."""
        spans = np.minimum(np.searchsorted(self.sections.start, supports), len(self.sections.start) - 1)
        return [z[self.sections.force[spans] + i] for i in range(3)]

    def _travels(self, spans: np.ndarray, supports: np.ndarray, coming: np.ndarray) -> np.ndarray:
        """Moves of the travels over all supports (supports, cases): a tridiagonal system."""
        s = self.sections
        going = np.minimum(np.searchsorted(s.start, np.arange(len(s.travel))), len(s.start) - 1)
        dq = np.zeros(supports.shape[1:])
        upper = np.zeros(supports.shape[1:])
        by_in, by_out = supports[2:5], supports[5:8]
        for k in self.free.tolist():
            before, after = spans[:, coming[k]], spans[:, going[k]]
            lower = _dot(by_in[:, k], before[18:21])
            diagonal = supports[1, k] + _dot(by_in[:, k], before[21:24]) + _dot(by_out[:, k], after[9:12])
            right = -(supports[0, k] + _dot(by_in[:, k], before[15:18]) + _dot(by_out[:, k], after[6:9]))
            if k:
                diagonal = diagonal - lower * upper[k - 1]
                right = right - lower * dq[k - 1]
            upper[k] = _dot(by_out[:, k], after[12:15]) / diagonal
            dq[k] = right / diagonal
        for k in self.free[::-1].tolist():
            if k + 1 < len(dq):
                dq[k] -= upper[k] * dq[k + 1]
        return dq


class _Known:
    """What does not change while a batch of cases is solved, as the kernels' inputs; what is the same in all cases
    has one column."""

    def __init__(self, solver: CondensedNewton, cases: Cases) -> None:
        s = solver.sections
        self._travel = s.travel
        self.coming = np.maximum(np.searchsorted(s.start, np.arange(len(s.travel))) - 1, 0)
        self.fixed = np.zeros((len(s.travel), cases.z.shape[1]))
        driven = np.flatnonzero(s.state >= 0)
        self.fixed[driven] = cases.x[s.state[driven]]
        common = np.vstack([cases.p, cases.u])
        self.shared = [_even(common[i : i + 1]) for i in s.shared.tolist()]
        speeds = np.vstack([cases.x, cases.u, np.zeros((1, cases.z.shape[1]))])
        self.spans = []
        for group in solver._spans:
            which, form, slots = group
            slotted = (s.mass, s.at, s.ride, *((s.drag,) if form.weather else ()))
            loads = [_even(cases.d[first[which] + j]) for first in slotted for j in range(slots)]
            for j in range(slots):
                empty = _even(cases.d[s.empty[which] + j])
                if empty.any():  # a point of the rope without mass: where it is, does not matter
                    travel = self.travels(cases.z)
                    length = cases.p[s.length_start[which]] + travel[s.start[which]] - travel[s.start[which] + 1]
                    loads[slots + j] = loads[slots + j] + empty * length
            own = [_even(cases.p[s.parameters[which] + i]) for i in range(form.parameters)]
            ends = [[_even(cases.p[s.point[s.start[which] + e, axis]]) for axis in range(3)] for e in (0, 1)]
            kernel = _span_function(form, slots)
            self.spans.append((group, kernel, [*own, *loads, *ends[0]], ends[1]))
        self.supports = []
        for which, form in solver._supports:
            own = [_even(cases.p[s.support_parameters[which] + i]) for i in range(form.parameters)]
            own += [_even(cases.d[s.support_discrete[which] + i]) for i in range(form.discrete)]
            speed = _even(speeds[s.speed[which]])
            self.supports.append(((which, form), _support_function(form), own, speed))

    def travels(self, z: np.ndarray) -> np.ndarray:
        """Travels over all supports, (supports, cases)."""
        q = self.fixed.copy()
        free = self._travel >= 0
        q[free] = z[self._travel[free]]
        return q

    def some(self, on: np.ndarray) -> _Known:
        """Of some cases only."""
        found = object.__new__(_Known)
        found._travel, found.coming, found.fixed = self._travel, self.coming, self.fixed[:, on]
        found.shared = _of(self.shared, on)
        found.spans = [(g, f, _of(before, on), _of(after, on)) for g, f, before, after in self.spans]
        found.supports = [(g, f, _of(before, on), _of([speed], on)[0]) for g, f, before, speed in self.supports]
        return found


def _even(rows: np.ndarray) -> np.ndarray:
    """Rows with one column where all columns are the same."""
    return np.ascontiguousarray(rows[:, :1] if (rows == rows[:, :1]).all() else rows)


def _of(arrays: Sequence[np.ndarray], on: np.ndarray) -> list[np.ndarray]:
    return [a if a.shape[1] == 1 else np.ascontiguousarray(a[:, on]) for a in arrays]


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@lru_cache(maxsize=64)
def _span_function(form: SpanForm, slots: int) -> ArrayFunction:
    return ArrayFunction(form.kernel(slots))


@lru_cache(maxsize=64)
def _support_function(form: SupportForm) -> ArrayFunction:
    return ArrayFunction(form.kernel)


def solve_points(model: Model, points: Sequence[Point]) -> None:
    """Solves many points of a model in place. Raises EquilibriumError."""
    sections, left = line_sections(model), list(points)
    if not isinstance(sections, str) and len(points) >= _FEW:
        cases = Cases(*(np.array(rows).T for rows in zip(*(point.vectors for point in points), strict=True)))
        counts = np.concatenate([layout.slots.count for layout in model.layouts])
        slots = sections.empty[:, None] + np.minimum(np.arange(counts.max(initial=0)), counts[:, None] - 1)
        full = (cases.d[slots] == 0.0) & (np.arange(slots.shape[1]) < counts[:, None])[:, :, None]
        used = full.sum(axis=1).max(axis=1, initial=0)
        good = CondensedNewton(sections, used).solve(cases)
        for i in np.flatnonzero(good).tolist():
            points[i].z[:] = cases.z[:, i]
        left = [points[i] for i in np.flatnonzero(~good).tolist()]
    for point in left:
        newton_of(model).solve(point)
