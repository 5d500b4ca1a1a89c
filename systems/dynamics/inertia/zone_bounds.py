"""What loads of a line with inertia come to as the line moves, as bounds of the travels of its rope."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.systems.dynamics.inertia import support_zones as zones
from ropeway.systems.statics.line_state import LineState

_BEHIND = 1e-4
"""Travel after which an event is due that was due before but for the direction of the rope [m]."""


class Bounds:
    """Until an event is due the `watched` states, travels of the rope, are between `low` and `high` [m]."""

    def __init__(self, state: LineState) -> None:
        self._thresholds, self._travels = zones.thresholds(state), self._read(state)
        travels = [layout.travel.state for layout in state.model.layouts]
        gaps = np.full((2, len(state.point.x)), np.inf)
        for t in self._thresholds:
            gap = np.where(t.gap > zones.NEAR, t.gap, _BEHIND)[t.on]
            np.minimum.at(gaps[int(t.side < 0.0)], travels[t.r][t.k[t.on]], gap)
        self.watched = np.flatnonzero(np.isfinite(gaps).any(axis=0)).astype(np.int32)
        self.high = state.point.x[self.watched] + gaps[0, self.watched]
        self.low = state.point.x[self.watched] - gaps[1, self.watched]

    @staticmethod
    def _read(state: LineState) -> list[np.ndarray]:
        return state.model.travels(state.point.x, state.point.z)

    def due(self, state: LineState, rates: Sequence[np.ndarray]) -> list[zones.ZoneEvent]:
        """The events that are due, one for each load, of a line that has moved without any; `rates` of travel of each
        run [m/s]."""
        moved = [now - then for now, then in zip(self._read(state), self._travels, strict=True)]
        now = [t._replace(gap=t.gap - t.side * moved[t.r][t.k]) for t in self._thresholds]
        return zones.due(zones.approached(now, rates, zones.NEAR))

    def excess(self, x: np.ndarray) -> np.ndarray:
        """By how much each watched state is beyond its bounds, of states (..., nx); negative between them [m]."""
        seen = x[..., self.watched]
        return np.maximum(seen - self.high, self.low - seen)

    def time_left(self, x: np.ndarray, x_rate: np.ndarray) -> float:
        """Time until the first of them comes to a bound, as the states move at their rates [s]."""
        seen, rate = x[self.watched], x_rate[self.watched]
        gap = np.where(rate > 0.0, self.high - seen, seen - self.low)
        return float(np.min(np.maximum(gap, 0.0) / np.maximum(np.abs(rate), 1e-12), initial=np.inf))
