"""Whether a run gets on: events and trials may repeat only so often while hardly any time passes."""

from __future__ import annotations

from ropeway.components.errors import SimulationError

_WINDOW = 0.1
"""Time [s] in which they are counted."""
_TRIALS, _EVENTS = 300, 20
"""How many there may be then: trials, and events of each support."""


class FinalError(SimulationError):
    """A run cannot go on, by shorter steps neither."""


class ChatterGuard:
    """The events and failed trials of a run since it last got on, and the support `where` the last event was."""

    def __init__(self, supports: int) -> None:
        self.most = _TRIALS + _EVENTS * supports
        self.since = 0.0
        self.count = 0
        self.where = ""

    def require(self, time: float, where: str = "") -> None:
        """Counts one more, at a time [s]. Raises FinalError when there are too many."""
        self.where = where or self.where
        if time >= self.since + _WINDOW:
            self.since, self.count = time, 0
        self.count += 1
        if self.count > self.most:
            at = f" at {self.where!r}" if self.where else ""
            raise FinalError(
                f"The line makes no headway: {self.count} events and trials{at} within {_WINDOW:g} s",
                "The events of the result so far show what repeats: move loads or supports there, or change the "
                "tension or the drives",
                time,
            )
