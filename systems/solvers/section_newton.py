"""Newton's method for one point of a long line: forces eliminated span by span, then the travels of idlers by a
tridiagonal system (see `line_sections`).

The kernels are evaluated by CasADi for all spans of a form in one call, which takes a third of the time of the
equations of the whole line with their Jacobian.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache

import casadi as ca
import numpy as np
from scipy.linalg.lapack import dgtsv

from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.solvers.damped_newton import damped
from ropeway.systems.solvers.line_sections import (
    SPAN_RESULTS,
    SUPPORT_RESULTS,
    LineSections,
    SpanForm,
    SupportForm,
    line_sections,
)
from ropeway.systems.solvers.model_functions import Buffered
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.points import Point

_SPANS = 16
"""Spans from which this is faster than Newton's method on the equations as a whole."""
_Kernel = Callable[[np.ndarray], np.ndarray]
"""A function of what many spans or supports read, which gives their results (results, components)."""
_Group = tuple[np.ndarray, _Kernel, np.ndarray]
"""Spans or supports of a form, their kernel, and the places of its inputs."""


class SectionNewton:
    """The solver of a line with `used` loads in each span (spans,), in its first slots."""

    def __init__(self, sections: LineSections, used: np.ndarray) -> None:
        self._sections, m = sections, sections.model
        places = _Places(sections, np.array([len(vector) for vector in (m.x, m.z, m.u, m.p, m.d)]))
        self._z = slice(len(m.x), len(m.x) + len(m.z))
        self._room, self._size = places.pulls, places.pulls + 3 * len(sections.form)
        self._spans = list(_span_groups(sections, used, places))
        self._supports = list(_support_groups(sections, places))
        self._free = np.concatenate([np.zeros(0, dtype=int), *(which for which, _, _ in self._supports)])
        starts = sections.start
        self._coming = np.maximum(np.searchsorted(starts, self._free) - 1, 0)
        self._going = np.minimum(np.searchsorted(starts, self._free), len(starts) - 1)
        self._closure, self._force = (first + np.arange(3)[:, None] for first in (sections.closure, sections.force))
        self._balance, self._travel, self._end = sections.balance[self._free], sections.travel[self._free], starts + 1

    def solve(self, point: Point) -> None:
        """Solves in place. Raises EquilibriumError; the point is unchanged then."""
        m = self._sections.model
        every = np.empty(self._size)
        np.concatenate((*point.vectors, (0.0,)), out=every[: self._room])
        inputs = [np.empty(places.shape) for _, _, places in (*self._spans, *self._supports)]
        scale, weight = m.z.nominals, 1.0 / m.r.nominals

        def residual(v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            np.multiply(v, scale, out=every[self._z])
            spans, supports = self._kernels(every, inputs)
            found = np.empty(len(weight))
            found[self._closure] = spans[:3]
            found[self._balance] = supports[0]
            found *= weight
            return found, spans, supports

        def step(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            found, spans, supports = residual(v)
            return found, -self._move(spans, supports) / scale

        with np.errstate(all="ignore"):  # what is not a number is no root
            v, _ = damped(point.z / scale, step, lambda v: residual(v)[0], m.r.names)
        point.z[:] = v * scale

    def _kernels(self, every: np.ndarray, inputs: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Results of the kernels of all spans and of the free supports, (results, components), for all vectors with
        room for the pulls of the former behind them; `inputs`: room for what the kernels read."""
        spans = np.empty((SPAN_RESULTS, len(self._sections.form)))
        for (which, kernel, places), read in zip(self._spans, inputs, strict=False):
            every.take(places, out=read, mode="clip")
            if len(self._spans) == 1:
                spans = kernel(read)
            else:
                spans[:, which] = kernel(read)
        every[self._room :] = spans[3:6].ravel()
        supports = [np.zeros((SUPPORT_RESULTS, 0))]
        for (_, kernel, places), read in zip(self._supports, inputs[len(self._spans) :], strict=True):
            every.take(places, out=read, mode="clip")
            supports.append(kernel(read))
        return spans, supports[-1] if len(supports) == 2 else np.concatenate(supports, axis=1)

    def _move(self, spans: np.ndarray, supports: np.ndarray) -> np.ndarray:
        """The step of Newton's method (nz,). Raises RuntimeError where the equations are singular."""
        free, count = self._free, len(self._sections.travel)
        # By closure, by the travel at end a and at end b: how the forces move that pull at the supports.
        coming = np.add.reduce(spans[15:].reshape(3, 3, -1).take(self._coming, axis=2) * supports[2:5], axis=1)
        going = np.add.reduce(spans[6:15].reshape(3, 3, -1).take(self._going, axis=2) * supports[5:8], axis=1)
        lower, diagonal, upper, right = np.zeros(count), np.ones(count), np.zeros(count), np.zeros(count)
        lower[free], upper[free] = coming[1], going[2]
        diagonal[free] = supports[1] + coming[2] + going[1]
        right[free] = -(supports[0] + coming[0] + going[0])
        *_, travel, failed = dgtsv(lower[1:], diagonal, upper[:-1], right)
        if failed:
            raise RuntimeError("singular")
        move = np.empty(self._z.stop - self._z.start)
        at_a, at_b = travel.take(self._sections.start), travel.take(self._end)
        move[self._force] = spans[6:9] + spans[9:12] * at_a + spans[12:15] * at_b
        move[self._travel] = travel.take(free)
        return move


def _span_groups(sections: LineSections, used: np.ndarray, places: _Places) -> Iterator[_Group]:
    """The spans by their form and the number of their loads."""
    for number, slots in sorted({*zip(sections.form.tolist(), used.tolist(), strict=True)}):
        which = np.flatnonzero((sections.form == number) & (used == slots))
        form = sections.forms[number]
        yield which, _of_spans(form, slots, len(which)), places.of_spans(which, form, slots)


def _support_groups(sections: LineSections, places: _Places) -> Iterator[_Group]:
    """The supports whose travel is an unknown, by their form."""
    for number, form in enumerate(sections.support_forms):
        which = np.flatnonzero((sections.balance >= 0) & (sections.support_form == number))
        if len(which):
            yield which, _of_supports(form, len(which)), places.of_supports(which, form)


class _Places:
    """Where kernels find their inputs: in all vectors of a point one after the other, a zero, and the `pulls` of the
    spans at their ends b, (3, spans)."""

    def __init__(self, sections: LineSections, sizes: np.ndarray) -> None:
        self._s = sections
        self._x, self._z, self._u, self._p, self._d = np.concatenate([[0], np.cumsum(sizes)[:-1]]).tolist()
        self._zero, parameters = int(sizes.sum()), sizes[3]
        self.pulls = self._zero + 1
        in_p = sections.shared < parameters
        self._shared = np.where(in_p, self._p + sections.shared, self._u + sections.shared - parameters)
        state, free = sections.state >= 0, sections.travel >= 0
        travel = np.where(state, self._x + sections.state, self._zero)
        self._travel = np.where(free, self._z + sections.travel, travel)

    def of_spans(self, which: np.ndarray, form: SpanForm, slots: int) -> np.ndarray:
        """Of spans of a form, (spans, inputs)."""
        s, slotted = self._s, [self._s.mass, self._s.at, self._s.ride, *([self._s.drag] if form.weather else [])]
        columns = [
            *self._common(which),
            *(self._z + s.force[which] + i for i in range(3)),
            *(self._p + s.parameters[which] + i for i in range(form.parameters)),
            *(self._d + first[which] + j for first in slotted for j in range(slots)),
        ]
        for end in (s.start[which], s.start[which] + 1):
            columns += [*(self._p + s.point[end, axis] for axis in range(3)), self._travel[end]]
        return np.array(columns).T.copy()

    def of_supports(self, which: np.ndarray, form: SupportForm) -> np.ndarray:
        """Of supports of a form, (supports, inputs)."""
        s = self._s
        coming = np.maximum(np.searchsorted(s.start, which) - 1, 0)
        going = np.minimum(np.searchsorted(s.start, which), len(s.start) - 1)
        speed = np.where(s.speed[which] < len(s.model.x), self._x, self._u - len(s.model.x)) + s.speed[which]
        columns = [
            *self._common(which),
            *(self._p + s.support_parameters[which] + i for i in range(form.parameters)),
            *(self._d + s.support_discrete[which] + i for i in range(form.discrete)),
            self._travel[which],
            *(self.pulls + len(s.form) * i + coming for i in range(3)),
            *(self._z + s.force[going] + i for i in range(3)),
            np.where(s.speed[which] < 0, self._zero, speed),
        ]
        return np.array(columns).T.copy()

    def _common(self, which: np.ndarray) -> list[np.ndarray]:
        return [np.full(len(which), place) for place in self._shared.tolist()]


def _each(kernel: ca.Function, count: int, results: int) -> _Kernel:
    """A kernel for so many components at once, one after the other."""
    function = Buffered(kernel.map(count))
    return lambda read: function(read)[0].reshape(count, results).T


@lru_cache(maxsize=256)
def _of_spans(form: SpanForm, slots: int, count: int) -> _Kernel:
    return _each(form.kernel(slots), count, SPAN_RESULTS)


@lru_cache(maxsize=256)
def _of_supports(form: SupportForm, count: int) -> _Kernel:
    return _each(form.kernel, count, SUPPORT_RESULTS)


@kept_with_model
def _solver_of(model: Model) -> Callable[[bytes], SectionNewton | None]:
    """Gives the solver of a model for the loads in its spans, None where it is not solved by sections; it remembers the
    last few."""
    sections = line_sections(model) if sum(len(run.spans) for run in model.runs) >= _SPANS else ""
    if isinstance(sections, str):
        return lambda used: None
    return lru_cache(maxsize=8)(lambda used: SectionNewton(sections, np.frombuffer(used, dtype=int)))


def solve_line(model: Model, point: Point, passed: Sequence[np.ndarray]) -> None:
    """Solves a point of a model in place, by sections where that is faster; `passed`: for each run the loads that have
    passed each support. Raises EquilibriumError; the point is unchanged then."""
    used = [np.zeros(0, dtype=int), *(beyond[:-1] - beyond[1:] for beyond in passed)]
    solver = _solver_of(model)(np.concatenate(used).tobytes())
    if solver is None:
        newton_of(model).solve(point)
    else:
        solver.solve(point)
