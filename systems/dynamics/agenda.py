"""The coming stops of a run that the compiled core goes through, and how far it has come."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ropeway.systems.statics.pending_events import Pending


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
