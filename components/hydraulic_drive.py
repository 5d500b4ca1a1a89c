"""A hydraulic drive: a motor fed by a pump, with relief valve, losses and the limits of flow and power."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import namespace
from ropeway.components.check import NOT_NEGATIVE, POSITIVE, SHARE, Range
from ropeway.components.drive import STANDSTILL, Drive, DriveMotion
from ropeway.components.errors import InputError
from ropeway.components.smooth import clip, clip_above, sign
from ropeway.components.variable import Energies, Kind, Limit, Variable


@checked
@dataclass(frozen=True, slots=True)
class HydraulicDrive(Drive):
    """A hydraulic motor on a sheave, in a closed circuit with its pump.

    The drive exerts the force that its speed control demands, limited by the relief valve (force), the pump flow
    (speed) and the engine (force times speed).

    Parameters
    ----------
    displacement : float
        Displacement of the motor [m3/rad].
    gear_ratio : float
        Turns of the motor per turn of the sheave.
    sheave_radius : float
        Radius of the sheave [m].
    relief_pressure : float or None
        Opening pressure of the relief valve [Pa]; None: an input of the model, for a power unit.
    pump_flow : float or None
        Largest flow of the pump [m3/s]; None: an input of the model, for a power unit.
    engine_power : float
        Largest power of the engine [W].
    inertia : float
        Inertia of all rotating parts, referred to the rope [kg].
    mechanical_efficiency : float, default 0.92
        Of the motor, 0 to 1.
    volumetric_efficiency : float, default 0.95
        Of motor and pump, 0 to 1.
    command_lag : float, default 0.3
        Time constant from command to pump [s]; 0: no lag.
    response_time : float, default 0.2
        Time constant of the speed control [s].
    recovers : bool, default True
        Whether braking returns energy to the engine, whose power then limits it; otherwise the energy is dissipated.
    friction : float, default 0
        Friction of the sheave's bearing, referred to the rope.
    drag : float, default 0
        Viscous loss at the rope [N s/m].
    brake_force : float, optional
        Largest force of the brake [N]; by default ten times the force at which the relief valve opens.

    Raises
    ------
    InputError
        A value out of its range, or neither brake_force nor relief_pressure.

    Examples
    --------
    >>> drive = rw.HydraulicDrive(
    ...     displacement=1e-4, gear_ratio=10.0, sheave_radius=0.5, relief_pressure=30e6, pump_flow=5e-3,
    ...     engine_power=60e3, inertia=2000.0,
    ... )
    >>> print(f"{drive.relief_force / 1e3:.1f} kN, {drive.top_speed:.1f} m/s")
    55.2 kN, 2.4 m/s
    """

    rope_speed: ClassVar[str] = "rope_speed"
    shares: ClassVar[tuple[str, ...]] = ("flow_share", "power_share")

    displacement: float
    gear_ratio: float
    sheave_radius: float
    relief_pressure: float | None
    pump_flow: float | None
    engine_power: float
    inertia: float
    mechanical_efficiency: float = 0.92
    volumetric_efficiency: float = 0.95
    command_lag: float = 0.3
    response_time: float = 0.2
    recovers: bool = True
    friction: float = 0.0
    drag: float = 0.0
    brake_force: float | None = None

    def __post_init__(self) -> None:
        owner = "HydraulicDrive"
        for name, unit in (
            ("displacement", "m3/rad"),
            ("gear_ratio", ""),
            ("sheave_radius", "m"),
            ("relief_pressure", "Pa"),
            ("pump_flow", "m3/s"),
            ("engine_power", "W"),
            ("inertia", "kg"),
            ("response_time", "s"),
        ):
            if getattr(self, name) is not None or name not in ("relief_pressure", "pump_flow"):
                check.positive(getattr(self, name), owner, name, unit)
        for name in ("mechanical_efficiency", "volumetric_efficiency"):
            check.share(getattr(self, name), owner, name)
        for name, unit in (("command_lag", "s"), ("friction", ""), ("drag", "N s/m")):
            check.not_negative(getattr(self, name), owner, name, unit)
        if self.brake_force is not None:
            check.positive(self.brake_force, owner, "brake_force", "N")
        elif self.relief_pressure is None:
            raise InputError(f"{owner}: brake_force and relief_pressure are None", "Give brake_force [N]")

    @property
    def volume_per_metre(self) -> float:
        """Volume through the motor per metre of rope [m3/m]."""
        return self.displacement * self.gear_ratio / self.sheave_radius

    @property
    def relief_force(self) -> float:
        """Force at the rope at which the relief valve opens when driving [N]; nan if the pressure is an input."""
        pressure = math.nan if self.relief_pressure is None else self.relief_pressure
        return pressure * self.volume_per_metre * self.mechanical_efficiency

    @property
    def top_speed(self) -> float:
        """Rope speed at full pump flow [m/s]; nan if the flow is an input."""
        flow = math.nan if self.pump_flow is None else self.pump_flow
        return flow * self.volumetric_efficiency / self.volume_per_metre

    @property
    def structure(self) -> Hashable:
        """What determines the form of the equations; see `form_of`."""
        return (self.command_lag > 0.0, self.recovers, self.relief_pressure is None, self.pump_flow is None)

    def variables(self, force: float, speed: float) -> tuple[Variable, ...]:
        par, dis, out = Kind.PARAMETER, Kind.DISCRETE, Kind.OUTPUT
        limit = 10.0 * self.relief_force if self.brake_force is None else self.brake_force
        lag = Variable("command", Kind.STATE, "m/s", "command after its lag", speed, kept_at_rest=True)
        delayed = (lag, _parameter_or_input("command_lag", "s", "time constant of the command", self.command_lag))
        return (
            Variable("rope_speed", Kind.STATE, "m/s", "speed of the unstretched rope", speed, kept_at_rest=True),
            *(delayed if self.command_lag > 0.0 else ()),
            _parameter_or_input(
                "volume_per_metre", "m3/m", "motor volume per metre of rope", self.volume_per_metre, 1e-3
            ),
            _parameter_or_input(
                "relief_pressure", "Pa", "opening pressure of the relief valve", self.relief_pressure, 1e7
            ),
            _parameter_or_input("pump_flow", "m3/s", "largest flow of the pump", self.pump_flow, 1e-3),
            _parameter_or_input("engine_power", "W", "largest power of the engine", self.engine_power, 1e4),
            _parameter_or_input("inertia", "kg", "rotating inertia referred to the rope", self.inertia, 1e3),
            _parameter_or_input(
                "mechanical_efficiency", "1", "mechanical efficiency", self.mechanical_efficiency, within=SHARE
            ),
            _parameter_or_input(
                "volumetric_efficiency", "1", "volumetric efficiency", self.volumetric_efficiency, within=SHARE
            ),
            _parameter_or_input("response_time", "s", "time constant of the speed control", self.response_time),
            Variable(
                "bearing_friction", par, "1", "bearing friction referred to the rope", self.friction, range=NOT_NEGATIVE
            ),
            Variable("drag", par, "N.s/m", "viscous loss at the rope", self.drag, range=NOT_NEGATIVE),
            _parameter_or_input("brake_force", "N", "largest force of the brake", limit, force),
            Variable("pressure_lost", dis, "1", "1: the drive has lost its pressure"),
            Variable("pressure", out, "Pa", "pressure difference over the motor", nominal=1e7),
            Variable("flow", out, "m3/s", "flow of the pump", nominal=1e-3),
            Variable(
                "hydraulic_power", out, "W", "power in the circuit, positive from the pump to the motor", nominal=1e4
            ),
            Variable("loss", out, "W", "power lost in bearing and drag", nominal=1e3),
            Variable("relief_open", out, "1", "1: the relief valve is open"),
            Variable("flow_limited", out, "1", "1: the pump flow limits the speed"),
            Variable("power_limited", out, "1", "1: the engine's power limits the force"),
        )

    def limits(self) -> tuple[Limit, ...]:
        return (Limit("relief_open", "relief valve open", high=0.5),)

    def energies(self, read: Callable[[str], Any]) -> Energies:
        return Energies(kinetic=self.inertia / 2.0 * read("rope_speed") ** 2, loss=read("loss"))

    def demand(self, v: Any) -> Mapping[str, Any]:
        demanded = self._demanded_speed(v)
        flow = namespace(demanded).fabs(demanded) * v.volume_per_metre / v.volumetric_efficiency
        power = self._control_force(v, demanded) * v.rope_speed / (v.mechanical_efficiency * v.volumetric_efficiency)
        return {"flow": flow, "power": clip_above(namespace(power).fmax(power, 0.0), v.engine_power)}

    def _demanded_speed(self, v: Any) -> Any:
        """Speed that the pump is set to."""
        return v.command if self.command_lag > 0.0 else v.speed + v.correction

    def _control_force(self, v: Any, reference: Any) -> Any:
        """Force that the speed control demands."""
        pull = v.tension_out - v.tension_in
        return v.inertia * (reference - v.rope_speed) / v.response_time - pull + self._loss(v)

    def _loss(self, v: Any) -> Any:
        return v.bearing_friction * v.bearing_load * sign(v.rope_speed, STANDSTILL) + v.drag * v.rope_speed

    def motion(self, v: Any) -> DriveMotion:
        xp = namespace(v.rope_speed)
        speed, volume = v.rope_speed, v.volume_per_metre
        demanded = self._demanded_speed(v)
        top = v.pump_flow * v.volumetric_efficiency / volume
        reference = clip(demanded * v.flow_share, top, top)
        control_force = self._control_force(v, reference)
        eta_m, eta = v.mechanical_efficiency, v.mechanical_efficiency * v.volumetric_efficiency
        # Motor losses reduce the force at the relief pressure when driving, and increase it when braking.
        driving, braking = v.relief_pressure * volume * eta_m, v.relief_pressure * volume / eta_m
        power = v.engine_power
        fast = xp.sqrt(speed * speed + (0.1 * STANDSTILL) ** 2)
        drive_limit = clip_above(power * eta / fast, driving)
        brake_limit = clip_above(power / (eta * fast), braking) if self.recovers else braking
        forward = (1.0 + sign(speed, STANDSTILL)) / 2.0
        alive = 1.0 - v.pressure_lost + 1e-9
        high = alive * (forward * drive_limit + (1.0 - forward) * brake_limit)
        low = alive * (forward * brake_limit + (1.0 - forward) * drive_limit)
        force = clip(control_force, low, high)
        # A shared power unit limits the power of driving drives; braking is not limited by it.
        force = force * xp.if_else(force * speed > 0.0, v.power_share, 1.0)
        loss = self._loss(v)
        pull = v.tension_out - v.tension_in
        brake = clip(-v.inertia * speed / v.response_time - pull + loss, v.brake_force, v.brake_force)
        total = (1.0 - v.brake) * force + v.brake * brake
        drive = (1.0 - v.brake) * force
        is_driving = drive * speed >= 0.0
        assisting = xp.if_else(drive >= 0.0, forward, 1.0 - forward)  # 1: the drive pulls in the direction of travel
        relief = assisting * driving + (1.0 - assisting) * braking
        pressure = v.relief_pressure * xp.fabs(drive) / relief
        motor_flow = xp.fabs(speed) * volume
        eta_v = v.volumetric_efficiency
        flow = xp.fmin(motor_flow * xp.if_else(is_driving, 1.0 / eta_v, eta_v), v.pump_flow)
        limit = xp.if_else(is_driving, power * eta / fast, power / (eta * fast) if self.recovers else 1e30)
        rates = {"rope_speed": (total + pull - loss) / v.inertia}
        if self.command_lag > 0.0:
            rates["command"] = (v.speed + v.correction - v.command) / v.command_lag
        return DriveMotion(
            speed=speed,
            force=total,
            rates=rates,
            outputs={
                "pressure": pressure,
                "flow": flow,
                "hydraulic_power": pressure * flow * xp.if_else(is_driving, 1.0, -1.0),
                "loss": loss * speed,
                "relief_open": xp.fabs(drive) >= 0.999 * relief,
                "flow_limited": xp.fabs(demanded * v.flow_share) > top,
                "power_limited": xp.fabs(drive) >= 0.999 * limit,
            },
        )


def _parameter_or_input(
    name: str, unit: str, description: str, value: float | None, nominal: float = 1.0, within: Range = POSITIVE
) -> Variable:
    """A parameter, or an input where it has no value."""
    if value is None:
        return Variable(name, Kind.INPUT, unit, description, nominal, nominal)
    return Variable(name, Kind.PARAMETER, unit, description, value, nominal, range=within)
