"""A quantity over time, given in advance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ropeway.components.errors import InputError


@dataclass(frozen=True)
class Schedule:
    """Piecewise linear over time: `times` [s], strictly increasing, and as many `speeds` [m/s].

    Before its first time it keeps the first speed; a run beyond its last time is an InputError. A steep
    pair of times stands for a step. Raises InputError.
    """

    times: tuple[float, ...]
    speeds: tuple[float, ...]

    def __init__(self, times: Sequence[float], speeds: Sequence[float]) -> None:
        object.__setattr__(self, "times", tuple(float(t) for t in times))
        object.__setattr__(self, "speeds", tuple(float(s) for s in speeds))
        if not self.times or len(self.times) != len(self.speeds):
            raise InputError(
                f"Schedule has {len(self.times)} times and {len(self.speeds)} speeds",
                "Give as many speeds as times, at least one",
            )
        if not np.all(np.isfinite(self.times + self.speeds)):
            raise InputError("Schedule holds a value that is not finite", "Remove NaN and inf")
        if np.any(np.diff(self.times) <= 0.0):
            k = int(np.argmax(np.diff(self.times) <= 0.0))
            raise InputError(
                f"Schedule times do not increase: {self.times[k + 1]} s after {self.times[k]} s", "Sort them"
            )

    def at(self, time: float) -> float:
        """Speed at a time [s]."""
        return float(np.interp(time, self.times, self.speeds))

    def breaks(self) -> np.ndarray:
        """Times where it bends, and where it passes through zero [s]."""
        t, v = np.array(self.times), np.array(self.speeds)
        turn = np.flatnonzero(v[:-1] * v[1:] < 0.0)
        zeros = t[turn] - v[turn] * (t[turn + 1] - t[turn]) / (v[turn + 1] - v[turn])
        return np.unique(np.concatenate([t, zeros]))
