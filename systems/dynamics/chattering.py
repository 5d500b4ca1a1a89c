"""Chattering: the number of events and failed steps in a short time is limited."""

from __future__ import annotations

from ropeway.components.errors import SimulationError

_WINDOW = 0.1
"""Time over which they are counted [s]."""
_TRIALS, _EVENTS = 300, 20
"""Largest number in that time: of failed steps, and of events of each support."""


class FinalError(SimulationError):
    """A run cannot go on, not by shorter steps either."""


class ChatterGuard:
    """Counts the events and failed steps of a run in a short time; `where` is the support of the last event."""

    def __init__(self, supports: int) -> None:
        self.most = _TRIALS + _EVENTS * supports
        self.since = 0.0
        self.count = 0
        self.where = ""

    def require(self, time: float, where: str = "") -> None:
        """Counts one event or failed step, at a time [s]. Raises FinalError when there are too many."""
        self.where = where or self.where
        if time >= self.since + _WINDOW:
            self.since, self.count = time, 0
        self.count += 1
        if self.count > self.most:
            at = f" at {self.where!r}" if self.where else ""
            raise FinalError(
                f"The run makes no progress: {self.count} events and failed steps{at} within {_WINDOW:g} s",
                "The events of the result so far show what repeats: move loads or supports there, or change the "
                "tension or the drives",
                time,
            )
