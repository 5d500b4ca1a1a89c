"""What somebody or something does to a line while it runs."""

from __future__ import annotations

from dataclasses import dataclass

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError

SWITCHED = {
    "brake": ("brake", 1.0),
    "release": ("brake", 0.0),
    "pressure lost": ("pressure_lost", 1.0),
    "pressure back": ("pressure_lost", 0.0),
}
"""Actions that set a discrete variable of a component, and its value."""
ACTIONS = (*SWITCHED, "emergency stop")


@checked
@dataclass(frozen=True, slots=True)
class Intervention:
    """An action at a time [s].

    "brake" holds the sheave `component`, "release" lets it go; "pressure lost" takes the force from its
    hydraulic drive, "pressure back" returns it. "emergency stop" brings every drive of the line from its
    present speed to rest at `deceleration` [m/s2] and ends all responses; it takes no component. Raises
    InputError.
    """

    time: float
    action: str
    component: str | None = None
    deceleration: float = 1.0

    def __post_init__(self) -> None:
        check.not_negative(self.time, f"Intervention {self.action!r}", "time", "s")
        check.positive(self.deceleration, f"Intervention {self.action!r}", "deceleration", "m/s2")
        if self.action not in ACTIONS:
            raise InputError(f"action is {self.action!r}", f"Choose from {', '.join(map(repr, ACTIONS))}")
        if (self.component is None) != (self.action == "emergency stop"):
            raise InputError(
                f"Intervention {self.action!r} on {self.component!r}",
                "An emergency stop is for the whole line, all else for one control sheave",
            )

    @property
    def entry(self) -> tuple[str, float]:
        """The discrete variable that the action sets, and its value."""
        variable, value = SWITCHED[self.action]
        return f"{self.component}.{variable}", value
