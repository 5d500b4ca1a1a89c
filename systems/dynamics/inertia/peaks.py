"""States of a run with inertia between its records: those at which a rope is tightest or slackest, or a support carries
most."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ropeway.systems.dynamics.inertia.inertial_state import slot_motions
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.statics.line_state import LineState

_MORE = 5e-4
"""By how much a state is beyond those written down before it, relative to these."""
_INSIDE = 1e-7
"""How far from the ends of a path a state is written down [s]: there others may have their records."""


class Path(NamedTuple):
    """How a line has moved without events: `times` (points,) [s] and algebraic variables `z` (points, nz) there; `at`
    gives states and algebraic variables at a time between."""

    times: np.ndarray
    z: np.ndarray
    at: Callable[[float], tuple[np.ndarray, np.ndarray]]


class Peaks:
    """What the states so far have shown of each span and support."""

    def __init__(self, state: LineState) -> None:
        self._highest = _pulls_of(state.model).quantities(state.point.z)
        self._before: tuple[float, np.ndarray] | None = None

    def written(self, state: LineState) -> None:
        """Declares that a state is written down, after which the line may have changed."""
        self._before = None
        self._highest = np.maximum(self._highest, _pulls_of(state.model).quantities(state.point.z))

    def along(self, model: Model, path: Path) -> dict[int, float]:
        """The time [s] within a path at which each quantity, by its number, is higher than ever before."""
        times, seen = path.times, _pulls_of(model).quantities(path.z)
        if self._before is not None:
            times, seen = np.append(self._before[0], times), np.vstack([self._before[1], seen])
        if len(times) < 3 or times[-1] <= times[-2]:
            return {}
        self._before = (float(times[-2]), seen[-2])
        a, b, c = seen[:-2], seen[1:-1], seen[2:]
        i, which = np.nonzero((b > a) & (b >= c))
        left, right = np.diff(times)[i], np.diff(times)[i + 1]
        # The parabola through three points, seen from the one in the middle.
        down, up = (b - a)[i, which] / left, (c - b)[i, which] / right
        slope, bend = (down * right + up * left) / (left + right), (down - up) / (left + right)
        peaks, at = b[i, which] + slope**2 / (4.0 * bend), times[i + 1] + slope / (2.0 * bend)
        beyond = peaks > self._highest[which] + _MORE * np.abs(self._highest[which])
        peaks, at, which = peaks[beyond], at[beyond], which[beyond]
        at = np.clip(at, path.times[0] + _INSIDE, path.times[-1] - _INSIDE)
        np.maximum.at(self._highest, which, peaks)
        return {int(which[k]): float(at[k]) for k in np.argsort(peaks)}  # of each the highest, which comes last


class _Pulls:
    """Places of the tension vectors behind the supports and load slots of all spans among the algebraic variables,
    `vectors` (count, 3): `first` of each span, and `beside` (2, supports) before and after each support."""

    def __init__(self, model: Model) -> None:
        vectors, beside, self.first = list[np.ndarray](), list[tuple[int, int]](), list[int]()
        for run, layout, motion in zip(model.runs, model.layouts, slot_motions(model), strict=True):
            begin = len(self.first)
            for k, count in enumerate(layout.slots.count):
                self.first.append(len(vectors))
                vectors += [layout.force[k] + np.arange(3), *(motion.pull[:, k] + j for j in range(int(count)))]
            beside += [(first - 1, first) for first in self.first[begin + 1 :]]
            beside += [(len(vectors) - 1, self.first[begin])] if run.closed else []
        self.vectors = np.array(vectors, dtype=int).reshape(-1, 3)
        self.beside = np.array(beside, dtype=int).reshape(-1, 2).T

    def quantities(self, z: np.ndarray) -> np.ndarray:
        """From algebraic variables (..., nz) what has peaks that count, (..., count) [N]: of each span the highest
        tension and, negative, the least horizontal one, of each support its load. The weight of the rope beside a
        support, and its inertia, are left out: they hardly change the time of a peak."""
        if not self.first:  # a system without ropes
            return np.zeros((*z.shape[:-1], 0))
        pull = z[..., self.vectors]
        level = np.hypot(pull[..., 0], pull[..., 1])
        tension = np.hypot(level, pull[..., 2])
        load = np.linalg.norm(pull[..., self.beside[1], :] - pull[..., self.beside[0], :], axis=-1)
        highest, lowest = (f.reduceat(v, self.first, axis=-1) for f, v in ((np.maximum, tension), (np.minimum, level)))
        return np.concatenate([highest, -lowest, load], axis=-1)


@kept_with_model
def _pulls_of(model: Model) -> _Pulls:
    return _Pulls(model)
