"""The coming stops of a run: those that the compiled core goes through, and how far it has come."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ropeway.systems.statics.pending_events import Pending

TOGETHER = 600
"""Times of the grid that the compiled core goes through in one call: a bar moves between two calls."""


@dataclass(frozen=True)
class Agenda:
    """Times of the `grid`, and of what ends them, `last`, inf for nothing [s]. `first`: first tick of each clock [s],
    `ticks`: how often it has ticked; both are empty where none ticks. `pending`: what is pending after so many ticks of
    each clock."""

    grid: Sequence[float]
    last: float
    first: Sequence[float]
    ticks: Sequence[int]
    pending: Callable[[Sequence[int]], Pending]


class Progress(NamedTuple):
    """Stops of the grid that have been reached, and how often each clock has ticked."""

    grid: int
    ticks: tuple[int, ...]


def grid_times(count: int, every: float, until: float, before: float) -> list[float]:
    """Times of the grid [s] from its number `count` on, all earlier than `before`, of a run to `until`."""
    last = min(round(until / every), int(min(before, until) / every)) + 2
    times = np.minimum(np.arange(count, last) * every, until)
    times = times[: int(np.searchsorted(times, until)) + 1]
    return [t for t in times.tolist() if t < before - 1e-9]
