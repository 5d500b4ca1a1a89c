"""A control sheave: it drives the rope and so controls the tensions of the spans on its two sides."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any, ClassVar

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import namespace
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Component, Seat
from ropeway.components.drive import Drive, IdealDrive
from ropeway.components.form import form_of, remade
from ropeway.components.inertia import Inertia
from ropeway.components.response import Response
from ropeway.components.schedule import Schedule
from ropeway.components.sheave import Wheel
from ropeway.components.variable import Energies, Equations, Kind, Limit, Site, Variable

Speed = float | Schedule | None
"""A constant [m/s], a schedule, or None: an input of the model."""


def check_speed(speed: Speed, owner: str) -> None:
    """Raises InputError unless the speed is a number, a Schedule or None."""
    if speed is not None and not isinstance(speed, Schedule):
        check.number(speed, owner, "speed", "m/s")


def first_speed(speed: Speed) -> float:
    """Speed at the start of a run [m/s]."""
    return speed.at(0.0) if isinstance(speed, Schedule) else (speed or 0.0)


@checked
@dataclass(frozen=True)
class ControlSheave(Wheel):
    """A driven sheave. Positive speed moves the rope from a to b.

    The inertia of the drive follows inertia dv/dt = force + tension_out - tension_in - losses. The grip margin is
    exp(mu wrap) - T_tight/T_slack.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float
        Position, (x, z) or (x, y, z) [m].
    hold_down : bool, default False
        Whether the rope runs below the sheave, which presses it down. Otherwise lift-off is reported where the support
        pulls the rope down.
    speed : float, Schedule or None, default 0
        Commanded speed [m/s]; None: an input of the model. A response adds its correction.
    drive : Drive, optional
        By default an `IdealDrive`, which follows the command exactly.
    response : Response, optional
        How it responds to the tensions on its two sides.
    grip_friction : float, default 0.2
        Friction coefficient between rope and lining.
    turns : float, default 1
        Turns of the rope around the sheave, in addition to the wrap angle of the line's geometry.
    label : str, optional
        Text in pictures and messages; by default the name.

    Raises
    ------
    InputError
        An invalid name, position, speed, friction or number of turns.

    Examples
    --------
    >>> drive = rw.IdealDrive()
    >>> rw.ControlSheave("c1", at=(180.0, 14.0), speed=1.0, drive=drive, grip_friction=0.25).grip_friction
    0.25
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

    def with_inertia(self, inertia: Inertia) -> Component:
        return remade(self, MovingControlSheave) if type(self) is ControlSheave else self

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
            Variable("travel", Kind.STATE, "m", "unstretched length of rope that has run over", kept_at_rest=True),
            Variable("correction", Kind.DISCRETE, "m/s", "correction of the commanded speed by the response"),
            Variable("brake", Kind.DISCRETE, "1", "1: the brake holds the sheave"),
            *(() if self.response is None else self.response.variables()),
            *self.wheel_outputs(site),
            Variable("drive_force", out, "N", "force of the drive on the rope, in its direction", nominal=site.force),
            Variable("power", out, "W", "power of the drive into the rope", nominal=1e3),
            Variable("grip_margin", out, "1", "exp(mu wrap) minus tight over slack tension"),
            *self.drive.variables(site.force, first_speed(self.speed)),
        )

    def equations(self, v: Any) -> Equations:
        outputs = self.wheel_equations(v)
        t_in, t_out = outputs["tension_in"], outputs["tension_out"]
        xp = namespace(t_in)
        tight, slack = xp.fmax(t_in, t_out), xp.fmin(t_in, t_out)
        outputs["grip_margin"] = grip_margin(v.grip_friction, outputs["wrap"], v.turns, tight, slack)
        motion = self.drive.motion(_seen_by_drive(v, outputs))
        # Power into the rope: v0 {(T + T^2/2EA)_in - (..)_out}.
        power = motion.speed * (v.a.carried - v.b.carried)
        return Equations(
            rates={"travel": motion.speed, **motion.rates},
            outputs={**outputs, **motion.outputs, "drive_force": motion.force, "power": power},
        )

    def energies(self, read: Callable[[str], Any]) -> Energies:
        return self.drive.energies(read)

    def demand(self, v: Any) -> Mapping[str, Any]:
        """Demand of the drive on a power unit."""
        return self.drive.demand(_seen_by_drive(v, self.wheel_equations(v)))


def _seen_by_drive(v: Any, outputs: Mapping[str, Any]) -> SimpleNamespace:
    """Symbols for the equations of a drive: variables of the sheave, tensions and bearing load."""
    return SimpleNamespace(
        **{**vars(v), **{name: outputs[name] for name in ("tension_in", "tension_out", "bearing_load")}}
    )


def grip_margin(friction: Any, wrap: Any, turns: Any, tight: Any, slack: Any) -> Any:
    """Grip margin of a rope on a sheave: exp(mu wrap) minus tight over slack tension."""
    xp = namespace(tight)
    # Beyond this exponent no rope slips, and exp would be infinite.
    return xp.exp(xp.fmin(friction * (wrap + 2.0 * math.pi * turns), 100.0)) - tight / slack


@checked
@dataclass(frozen=True)
class MovingControlSheave(ControlSheave):
    """A driven sheave that the inertia of the rope loads; arguments as of a `ControlSheave`."""

    inertial: ClassVar[bool] = True

    @property
    def a(self) -> Seat:
        return self._moving(super().a)

    @property
    def b(self) -> Seat:
        return self._moving(super().b)

    def _moving(self, seat: Seat) -> Seat:
        return replace(seat, speed="rope_speed" if self._commanded else self.drive.rope_speed, acceleration=_RATE)

    @property
    def _commanded(self) -> bool:
        """Whether the drive has no speed of its own: the rope moves as it is commanded."""
        return self.drive.rope_speed == "speed"

    def structure(self, site: Site) -> Hashable:
        return super().structure(site)

    def driver(self, name: str) -> float | Schedule | None:
        return 0.0 if name == "speed_rate" else super().driver(name)

    def variables(self, site: Site) -> tuple[Variable, ...]:
        alg, res = Kind.ALGEBRAIC, Kind.RESIDUAL
        commanded = (
            Variable("speed_rate", Kind.INPUT, "m/s2", "rate of the commanded speed", rate_of="speed"),
            Variable("rope_speed", alg, "m/s", "speed of the unstretched rope", first_speed(self.speed)),
            Variable("commanded", res, "m/s", "speed of the rope"),
        )
        return (
            *super().variables(site),
            *(commanded if self._commanded else ()),
            Variable(_RATE, alg, "m/s2", "acceleration of the unstretched rope"),
            Variable("accelerated", res, "m/s2", "acceleration of the rope"),
            Variable("work", Kind.STATE, "J", "work of the drive on the rope", nominal=1e3),
        )

    def equations(self, v: Any) -> Equations:
        found, motion = super().equations(v), self.drive.motion(self._loaded(v))
        power = motion.speed * (v.a.carried + v.a.along - v.b.carried + v.b.along)
        if self._commanded:
            residuals = {"commanded": v.rope_speed - motion.speed}
            rate = v.speed_rate * (1 - v.brake)
        else:
            residuals, rate = {}, motion.rates[self.drive.rope_speed]
        return replace(
            found,
            rates={"travel": motion.speed, **motion.rates, "work": power},
            residuals={**residuals, "accelerated": v.rope_acceleration - rate},
            outputs={**found.outputs, **motion.outputs, "drive_force": motion.force, "power": power},
        )

    def _loaded(self, v: Any) -> SimpleNamespace:
        """What the drive sees: the force on the rope's travel on both sides, with the inertia of the rope."""
        seen = {
            **self.wheel_equations(v),
            "tension_in": v.a.carried + v.a.along,
            "tension_out": v.b.carried - v.b.along,
        }
        return _seen_by_drive(v, seen)

    def demand(self, v: Any) -> Mapping[str, Any]:
        return self.drive.demand(self._loaded(v))


_RATE = "rope_acceleration"
