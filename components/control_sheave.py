"""A control sheave: it drives the rope and so coordinates the tensions of the spans on its two sides."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

from ropeway.components import check
from ropeway.components.component import Equations, Kind, Site, Variable
from ropeway.components.schedule import Schedule
from ropeway.components.sheave import Wheel

Speed = float | Schedule | None
"""A constant [m/s], a schedule, or None: left open as an input of the model."""


def check_speed(speed: Speed, owner: str) -> None:
    """Raises InputError unless the speed is a number, a Schedule or None."""
    if speed is not None and not isinstance(speed, Schedule):
        check.number(speed, owner, "speed", "m/s")


@dataclass(frozen=True)
class ControlSheave(Wheel):
    """A sheave whose rope speed is commanded: a constant [m/s], a `Schedule`, or None for a model input.

    Positive from a to b. Its travel is a state. Raises InputError.
    """

    speed: Speed = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check_speed(self.speed, self.label)

    @property
    def drive_speed(self) -> str:
        return "speed"

    def structure(self, site: Site) -> Hashable:
        return ControlSheave

    def variables(self, site: Site) -> tuple[Variable, ...]:
        return (
            *self.place(),
            Variable("speed", Kind.INPUT, "m/s", "commanded speed of the unstretched rope"),
            Variable("travel", Kind.STATE, "m", "unstretched rope that has run over"),
            *self.wheel_outputs(site),
        )

    def equations(self, v: Any) -> Equations:
        return Equations(rates={"travel": v.speed}, outputs=self.wheel_equations(v))
