"""Newton's method for one point of a long line: forces eliminated span by span, then the travels of idlers by a
tridiagonal system (see `line_sections`).

The kernels are evaluated by CasADi for all spans of a form in one call, which takes a third of the time of the
equations of the whole line with their Jacobian.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

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


class SectionNewton:
    """The solver of a line with `used` loads in each span (spans,), in its first slots."""

    def __init__(self, sections: LineSections, used: np.ndarray) -> None:
        self._sections, m = sections, sections.model
        self._sizes = np.array([len(vector) for vector in (m.x, m.z, m.u, m.p, m.d)])
        places = _Places(sections, self._sizes)
        self._z = slice(len(m.x), len(m.x) + len(m.z))
        self._room = int(self._sizes.sum()) + 1
        pairs = sorted({*zip(sections.form.tolist(), used.tolist(), strict=True)})
        self._spans = []
        for form, slots in pairs:
            which = np.flatnonzero((sections.form == form) & (used == slots))
            inputs = places.of_spans(which, sections.forms[form], slots)
            self._spans.append((which, _of_spans(sections.forms[form], slots, len(which)), inputs))
        self._supports = []
        for number, support_form in enumerate(sections.support_forms):
            which = np.flatnonzero((sections.balance >= 0) & (sections.support_form == number))
            inputs = places.of_supports(which, support_form, self._room)
            self._supports.append((which, _of_supports(support_form, len(which)), inputs))
        self._free, starts = np.flatnonzero(sections.travel >= 0), sections.start
        self._coming = np.maximum(np.searchsorted(starts, self._free) - 1, 0)
        self._going = np.minimum(np.searchsorted(starts, self._free), len(starts) - 1)
        self._closure, self._force = (first[:, None] + np.arange(3) for first in (sections.closure, sections.force))

    def solve(self, point: Point) -> None:
        """Solves in place. Raises EquilibriumError; the point is unchanged then."""
        m = self._sections.model
        every = np.zeros(self._room + SPAN_RESULTS * len(self._sections.form))
        np.concatenate(point.vectors, out=every[: self._room - 1])
        inputs = [np.empty(places.shape) for _, _, places in (*self._spans, *self._supports)]
        scale, weight = m.z.nominals, 1.0 / m.r.nominals

        def residual(v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            np.multiply(v, scale, out=every[self._z])
            spans, supports = self._kernels(every, inputs)
            found = np.empty(len(m.r))
            found[self._closure] = spans[:, :3]
            found[self._sections.balance[self._free]] = supports[self._free, 0]
            found *= weight
            return found, spans, supports

        def step(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            found, spans, supports = residual(v)
            return found, -self._move(spans, supports) / scale

        v, _ = damped(point.z / scale, step, lambda v: residual(v)[0], m.r.names)
        point.z[:] = v * scale

    def _kernels(self, every: np.ndarray, inputs: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Results of the kernels of all spans and supports, for all vectors with room for the former behind them;
        `inputs`: room for what the kernels read."""
        spans = every[self._room :].reshape(-1, SPAN_RESULTS)
        supports = np.zeros((len(self._sections.travel), SUPPORT_RESULTS))
        kernels = [(spans, *group) for group in self._spans] + [(supports, *group) for group in self._supports]
        for (results, which, function, places), read in zip(kernels, inputs, strict=True):
            every.take(places, out=read, mode="clip")
            results[which] = function(read)[0].reshape(-1, results.shape[1])
        return spans, supports

    def _move(self, spans: np.ndarray, supports: np.ndarray) -> np.ndarray:
        """The step of Newton's method (nz,). Raises RuntimeError where the equations are singular."""
        s, free = self._sections, self._free
        own, count = supports[free], len(s.travel)
        # By closure, by the travel at end a and at end b: how the forces move that pull at the supports.
        coming = (spans[self._coming, 15:].reshape(-1, 3, 3) @ own[:, 2:5, None])[:, :, 0]
        going = (spans[self._going, 6:15].reshape(-1, 3, 3) @ own[:, 5:8, None])[:, :, 0]
        lower, diagonal, upper, right = np.zeros(count), np.ones(count), np.zeros(count), np.zeros(count)
        lower[free], upper[free] = coming[:, 1], going[:, 2]
        diagonal[free] = own[:, 1] + coming[:, 2] + going[:, 1]
        right[free] = -(own[:, 0] + coming[:, 0] + going[:, 0])
        *_, travel, failed = dgtsv(lower[1:], diagonal, upper[:-1], right)
        if failed:
            raise RuntimeError("singular")
        move = np.empty(self._z.stop - self._z.start)
        a, b = travel[s.start, None], travel[s.start + 1, None]
        move[self._force] = spans[:, 6:9] + spans[:, 9:12] * a + spans[:, 12:15] * b
        move[s.travel[free]] = travel[free]
        return move


class _Places:
    """Where kernels find their inputs: in all vectors of a point one after the other, a zero, and the results of the
    spans' kernels."""

    def __init__(self, sections: LineSections, sizes: np.ndarray) -> None:
        self._s = sections
        self._x, self._z, self._u, self._p, self._d = np.concatenate([[0], np.cumsum(sizes)[:-1]]).tolist()
        self._zero, parameters = int(sizes.sum()), sizes[3]
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

    def of_supports(self, which: np.ndarray, form: SupportForm, room: int) -> np.ndarray:
        """Of supports of a form, (supports, inputs); `room`: where the results of the spans begin."""
        s = self._s
        coming = np.maximum(np.searchsorted(s.start, which) - 1, 0)
        going = np.minimum(np.searchsorted(s.start, which), len(s.start) - 1)
        speed = np.where(s.speed[which] < len(s.model.x), self._x, self._u - len(s.model.x)) + s.speed[which]
        columns = [
            *self._common(which),
            *(self._p + s.support_parameters[which] + i for i in range(form.parameters)),
            *(self._d + s.support_discrete[which] + i for i in range(form.discrete)),
            self._travel[which],
            *(room + SPAN_RESULTS * coming + 3 + i for i in range(3)),
            *(self._z + s.force[going] + i for i in range(3)),
            np.where(s.speed[which] < 0, self._zero, speed),
        ]
        return np.array(columns).T.copy()

    def _common(self, which: np.ndarray) -> list[np.ndarray]:
        return [np.full(len(which), place) for place in self._shared.tolist()]


@lru_cache(maxsize=256)
def _of_spans(form: SpanForm, slots: int, count: int) -> Buffered:
    return Buffered(form.kernel(slots).map(count))


@lru_cache(maxsize=256)
def _of_supports(form: SupportForm, count: int) -> Buffered:
    return Buffered(form.kernel.map(max(count, 1)))


@kept_with_model
def _solvers(model: Model) -> dict[bytes, SectionNewton]:
    """The solvers of a model by the loads in its spans."""
    return {}


def solve_line(model: Model, point: Point, passed: Sequence[np.ndarray]) -> None:
    """Solves a point of a model in place, by sections where that is faster; `passed`: for each run the loads that have
    passed each support. Raises EquilibriumError; the point is unchanged then."""
    sections = line_sections(model) if sum(len(run.spans) for run in model.runs) >= _SPANS else ""
    if isinstance(sections, str):
        newton_of(model).solve(point)
        return
    used, known = sections.used(passed), _solvers(model)
    key = used.tobytes()
    if key not in known:
        while len(known) >= 8:
            known.pop(next(iter(known)), None)
        known[key] = SectionNewton(sections, used)
    known[key].solve(point)
