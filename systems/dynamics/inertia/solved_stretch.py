"""A stretch of time that IDAS has integrated, and the line at any time in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from ropeway.systems.dynamics.inertia.peaks import Path
from ropeway.systems.dynamics.inertia.zone_bounds import Bounds
from ropeway.systems.solvers.points import Point

_NODES = 6
"""Points through which a polynomial interpolates."""
_CHECKS = 8
"""Points at which the interpolation is checked."""


@dataclass(frozen=True, eq=False)
class SolvedStretch:
    """The states `x` (parts + 1, nx) and algebraic variables `z` (parts + 1, nz) at the ends of equal parts of the `h`
    seconds after a point."""

    start: Point
    h: float
    x: np.ndarray
    z: np.ndarray

    @property
    def parts(self) -> int:
        """Number of its parts."""
        return len(self.x) - 1

    @property
    def end(self) -> float:
        """Its last time [s]."""
        return self.start.t + self.h

    def at(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """States and algebraic variables at a time in the stretch [s]."""
        own, weights = self._nodes(t)
        return weights @ self.x[own], weights @ self.z[own]

    def path(self, begin: float, end: float) -> Path:
        """How the line moves between two times in the stretch [s]."""
        times = self.start.t + self.h * np.arange(self.parts + 1) / self.parts
        inside = (times > begin + 1e-9) & (times < end - 1e-9)
        z = np.vstack([self.at(begin)[1], self.z[inside], self.at(end)[1]])
        return Path(np.concatenate([[begin], times[inside], [end]]), z, self.at)

    def continues(self, point: Point) -> bool:
        """Whether a point is in the stretch, before its end, and nothing else than time has changed it."""
        if not self.start.t <= point.t < self.end - 1e-9 or len(point.x) != self.x.shape[1]:
            return False
        own, weights = self._nodes(point.t)
        known = ((point.x, weights @ self.x[own]), (point.p, self.start.p), (point.d, self.start.d))
        return all(np.array_equal(a, b) for a, b in known)

    def time_of_event(self, t: float, bounds: Bounds) -> float:
        """The first time after `t` at which a state comes to one of its bounds [s]; infinite without one."""
        before = bounds.excess(self.at(t)[0])
        later = np.arange(int(np.floor((t - self.start.t) / self.h * self.parts + 1e-6)) + 1, self.parts + 1)
        beyond = (bounds.excess(self.x[later]) > 0.0) & (before <= 0.0)
        if not beyond.any():
            return np.inf
        i = int(np.argmax(beyond.any(axis=1)))
        times = self.start.t + self.h * (later[i] + np.array([-1.0, 0.0])) / self.parts
        span = (max(t, float(times[0])), min(float(times[1]), self.end))
        return min(self._root(int(k), span, bounds) for k in np.flatnonzero(beyond[i]))

    @property
    def error(self) -> np.ndarray:
        """Estimated error of the interpolation of each state, from that with every second point."""
        apart = np.arange(1 - _NODES, _NODES, 2)
        at = np.linspace(_NODES, self.parts - _NODES, _CHECKS).astype(int)
        found = np.tensordot(_weights((_NODES - 1) / 2.0), self.x[at[None, :] + apart[:, None]], 1)
        return np.asarray(np.abs(found - self.x[at]).max(axis=0) / 2.0**_NODES)

    def _root(self, k: int, span: tuple[float, float], bounds: Bounds) -> float:
        """The time in a span at which watched state number k comes to a bound [s]."""
        column = bounds.watched[k]

        def excess(t: float) -> float:
            own, weights = self._nodes(t)
            value = float(weights @ self.x[own, column])
            return max(value - float(bounds.high[k]), float(bounds.low[k]) - value)

        if excess(span[0]) > 0.0:
            return span[0]
        return float(brentq(excess, *span, xtol=1e-10)) if excess(span[1]) > 0.0 else span[1]

    def _nodes(self, t: float) -> tuple[slice, np.ndarray]:
        """The points next to a time, and how much each of them counts there."""
        at = np.clip((t - self.start.t) / self.h * self.parts, 0.0, self.parts)
        at = np.round(at) if abs(at - np.round(at)) < 1e-9 else at
        first = int(np.clip(np.floor(at) - (_NODES - 2) // 2, 0, self.parts + 1 - _NODES))
        return slice(first, first + _NODES), _weights(float(at) - first)


def _weights(at: float) -> np.ndarray:
    """How much the values at 0, 1, ... count at a place, for the polynomial through them."""
    nodes = np.arange(_NODES)
    away, apart = at - nodes, nodes[:, None] - nodes
    np.fill_diagonal(apart, 1)
    others = np.where(np.eye(_NODES, dtype=bool), 1.0, away[None, :])
    return np.asarray(np.prod(others, axis=1) / np.prod(apart, axis=1))
