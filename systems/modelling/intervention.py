"""Interventions in a running line: brakes, losses of pressure, emergency stops."""

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
"""Discrete variable of a component that each action sets, and its value."""
INERTIAL = {"payload dropped": ("dropped", 1.0), "rope breaks": ("broken", 1.0)}
"""As `SWITCHED`, of components with inertia."""
LOAD_LOST, STOP, EMERGENCY_STOP = "load lost", "stop", "emergency stop"
ACTIONS = (*SWITCHED, STOP, EMERGENCY_STOP, *INERTIAL, LOAD_LOST)


@checked
@dataclass(frozen=True, slots=True)
class Intervention:
    """An intervention at a time.

    Parameters
    ----------
    time : float
        Time [s].
    action : {"brake", "release", "pressure lost", "pressure back", "stop", "emergency stop", "load lost", \
"payload dropped", "rope breaks"}
        "brake" applies the brake of a control sheave, "release" releases it. "pressure lost" removes the force of its
        hydraulic drive, "pressure back" restores it. "stop" decelerates the drive of one control sheave or drum to rest
        and ends its response, "emergency stop" all drives of the line and all responses. With inertia, "load lost"
        takes a load off its rope, "payload dropped" takes the payload off a carriage, "rope breaks" cuts the rope of a
        span.
    component : str, optional
        Name of the control sheave, drum, load, carriage or span; None for an emergency stop.
    deceleration : float, default 1
        Deceleration of a stop or an emergency stop [m/s2].

    Raises
    ------
    InputError
        An unknown action, a negative time, a deceleration that is not positive, or a missing or superfluous component.

    Examples
    --------
    >>> result = rw.simulate(line, 4.0, interventions=[rw.Intervention(2.0, "brake", "c1")])
    >>> "brake" in set(result.events["event"])
    True
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
        if (self.component is None) != (self.action == EMERGENCY_STOP):
            raise InputError(
                f"Intervention {self.action!r} on {self.component!r}",
                "An emergency stop applies to the whole line, any other action to one component or load",
            )

    @property
    def inertial(self) -> bool:
        """Whether it needs a run with inertia."""
        return self.action in INERTIAL or self.action == LOAD_LOST

    @property
    def entry(self) -> tuple[str, float]:
        """Discrete variable that the action sets, and its value."""
        variable, value = {**SWITCHED, **INERTIAL}[self.action]
        return f"{self.component}.{variable}", value
