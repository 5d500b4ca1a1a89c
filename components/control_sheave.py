"""A control sheave: it drives the rope and so coordinates the tensions of the spans on its two sides."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import namespace
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Energies, Equations, Kind, Limit, Site, Variable, form_of
from ropeway.components.drive import Drive, IdealDrive
from ropeway.components.response import Response
from ropeway.components.schedule import Schedule
from ropeway.components.sheave import Wheel

Speed = float | Schedule | None
"""A constant [m/s], a schedule, or None: left open as an input of the model."""


def check_speed(speed: Speed, owner: str) -> None:
    """Raises InputError unless the speed is a number, a Schedule or None."""
    if speed is not None and not isinstance(speed, Schedule):
        check.number(speed, owner, "speed", "m/s")


def first_speed(speed: Speed) -> float:
    """The speed at the start of a run [m/s]."""
    return speed.at(0.0) if isinstance(speed, Schedule) else (speed or 0.0)


@checked
@dataclass(frozen=True)
class ControlSheave(Wheel):
    """A driven sheave. Positive speed runs the rope from a to b.

    speed: commanded, a constant [m/s], a `Schedule`, or None for a model input; a `response` adds its
    correction. drive: `IdealDrive`, which follows the command exactly, or a `HydraulicDrive` with its limits:
    inertia dv/dt = force + tension_out - tension_in - losses. turns: of the rope around the sheave, beyond the
    wrap that the line's geometry gives; grip_friction: between rope and lining; together they set the grip
    margin exp(mu wrap) - T_tight/T_slack. Raises InputError.
    """

    role: ClassVar[str] = "control sheave"

    speed: Speed = 0.0
    drive: Drive = field(default_factory=IdealDrive)
    response: Response | None = None
    grip_friction: float = 0.2
    turns: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check_speed(self.speed, self.described)
        check.positive(self.grip_friction, self.described, "grip_friction")
        check.not_negative(self.turns, self.described, "turns")

    @property
    def drive_speed(self) -> str:
        return self.drive.rope_speed

    @property
    def drive_power(self) -> str:
        return "power"

    @property
    def shares(self) -> tuple[str, ...]:
        return self.drive.shares

    def limits(self) -> tuple[Limit, ...]:
        return (*super().limits(), Limit("grip_margin", "grip lost", low=0.0), *self.drive.limits())

    def structure(self, site: Site) -> Hashable:
        return (form_of(self.drive), form_of(self.response))

    def variables(self, site: Site) -> tuple[Variable, ...]:
        par, out = Kind.PARAMETER, Kind.OUTPUT
        return (
            *self.place(),
            Variable("grip_friction", par, "1", "friction between rope and lining", self.grip_friction, range=POSITIVE),
            Variable("turns", par, "1", "turns of the rope around the sheave", self.turns, range=NOT_NEGATIVE),
            Variable("speed", Kind.INPUT, "m/s", "commanded speed of the unstretched rope"),
            Variable("travel", Kind.STATE, "m", "unstretched rope that has run over", kept_at_rest=True),
            Variable("correction", Kind.DISCRETE, "m/s", "what the response adds to the commanded speed"),
            Variable("brake", Kind.DISCRETE, "1", "1: the brake holds the sheave"),
            *(() if self.response is None else self.response.variables()),
            *self.wheel_outputs(site),
            Variable("drive_force", out, "N", "force of the drive on the rope, in its direction", nominal=site.force),
            Variable("power", out, "W", "power of the drive into the rope", nominal=1e3),
            Variable("grip_margin", out, "1", "exp(mu wrap) less tight over slack tension"),
            *self.drive.variables(site.force, first_speed(self.speed)),
        )

    def equations(self, v: Any) -> Equations:
        outputs = self.wheel_equations(v)
        t_in, t_out = outputs["tension_in"], outputs["tension_out"]
        xp = namespace(t_in)
        tight, slack = xp.fmax(t_in, t_out), xp.fmin(t_in, t_out)
        outputs["grip_margin"] = grip_margin(v.grip_friction, outputs["wrap"], v.turns, tight, slack)
        v.tension_in, v.tension_out, v.bearing_load = t_in, t_out, outputs["bearing_load"]
        motion = self.drive.motion(v)
        # Energy per metre of rope: v0 {(T + T^2/2EA)_in - (..)_out} is what the drive gives.
        power = motion.speed * (v.a.carried - v.b.carried)
        return Equations(
            rates={"travel": motion.speed, **motion.rates},
            outputs={**outputs, **motion.outputs, "drive_force": motion.force, "power": power},
        )

    def energies(self, read: Callable[[str], Any]) -> Energies:
        return self.drive.energies(read)

    def demand(self, v: Any) -> Mapping[str, Any]:
        """What the drive asks of a power unit."""
        outputs = self.wheel_equations(v)
        v.tension_in, v.tension_out = outputs["tension_in"], outputs["tension_out"]
        v.bearing_load = outputs["bearing_load"]
        return self.drive.demand(v)


def grip_margin(friction: Any, wrap: Any, turns: Any, tight: Any, slack: Any) -> Any:
    """What is left of a rope's grip on a sheave: exp(mu wrap) less tight over slack tension."""
    return namespace(tight).exp(friction * (wrap + 2.0 * math.pi * turns)) - tight / slack
