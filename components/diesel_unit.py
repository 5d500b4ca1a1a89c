"""A diesel engine with its hydraulic pump: what a line's drives can draw, and how the engine bears it."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import namespace
from ropeway.components.check import NOT_NEGATIVE, POSITIVE, SHARE
from ropeway.components.component import Component, Equations, Kind, Limit, Port, Site, Variable
from ropeway.components.errors import InputError
from ropeway.components.smooth import clip, clip_above

PEAK = 0.6
"""Speed of the highest torque, of the rated speed."""
OVERSPEED = 1.2
"""Speed at which an engine that the line drives is in danger, of the rated speed."""
LUGGED, STALLING = 0.8, 0.6
"""Speeds, of the rated speed, at which the pump begins to give way and at which it gives charge pressure only."""


@checked
@dataclass(frozen=True)
class DieselHydraulicUnit(Component):
    """A diesel engine with a droop governor that turns a variable pump in closed circuits.

    rated_power [W] at rated_speed [rad/s]; droop: gain of speed from full load to none, of the rated speed;
    torque_rise: peak torque over rated torque, less 1; drag: torque that turns the engine without fuel, of the
    rated torque; inertia of all that turns [kg m2]; governor_time: time constant of the fuel rack [s];
    displacement of the pump [m3/rad]; relief_pressure, charge_pressure [Pa]; pressure_time: time constant of the
    pressure [s]; efficiency of the pump, volumetric_efficiency: its part in it.

    It offers a `flow` [m3/s] and a `pressure` [Pa]; the input `load_power` [W] is what the drives take of both,
    below zero what they return; they get no more than flow times pressure. An engine that is lugged down gives
    less flow, and below 0.8 of its rated speed the pump gives way: the pressure falls, to the charge pressure at
    0.6. The torque curve is a parabola, the governor is proportional: textbook relations, put together here.
    Raises InputError.
    """

    rated_power: float
    rated_speed: float
    inertia: float
    displacement: float
    relief_pressure: float
    charge_pressure: float = 20e5
    droop: float = 0.08
    torque_rise: float = 0.2
    drag: float = 0.15
    governor_time: float = 0.2
    pressure_time: float = 0.1
    efficiency: float = 0.88
    volumetric_efficiency: float = 0.95

    def __post_init__(self) -> None:
        super().__post_init__()
        owner = f"DieselHydraulicUnit {self.name!r}"
        for name, unit in (
            ("rated_power", "W"),
            ("rated_speed", "rad/s"),
            ("inertia", "kg m2"),
            ("displacement", "m3/rad"),
            ("relief_pressure", "Pa"),
            ("charge_pressure", "Pa"),
            ("droop", ""),
            ("governor_time", "s"),
            ("pressure_time", "s"),
        ):
            check.positive(getattr(self, name), owner, name, unit)
        for name in ("torque_rise", "drag"):
            check.not_negative(getattr(self, name), owner, name)
        for name in ("efficiency", "volumetric_efficiency"):
            check.share(getattr(self, name), owner, name)
        if self.charge_pressure >= self.relief_pressure:
            raise InputError(
                f"{owner}: charge_pressure is {self.charge_pressure:g} Pa, relief_pressure {self.relief_pressure:g} Pa",
                "The charge pressure is the lower one",
            )

    @property
    def ports(self) -> tuple[Port, ...]:
        return ()

    def limits(self) -> tuple[Limit, ...]:
        return (
            Limit("speed_ratio", "engine lugged down", low=LUGGED),
            Limit("speed_ratio", "engine overspeed", high=OVERSPEED),
        )

    def structure(self, site: Site) -> Hashable:
        return ()

    def variables(self, site: Site) -> tuple[Variable, ...]:
        par, state, out = Kind.PARAMETER, Kind.STATE, Kind.OUTPUT
        torque = self.rated_power / self.rated_speed
        idle = 1.0 + self.droop
        rack = self.drag * idle / (_torque(idle, self.torque_rise) + self.drag * idle)  # without a load, nearly
        speed = self.rated_speed * (1.0 + self.droop * (1.0 - rack))
        return (
            Variable("rated_power", par, "W", "rated power of the engine", self.rated_power, 1e5, range=POSITIVE),
            Variable("rated_speed", par, "rad/s", "rated speed of the engine", self.rated_speed, 1e2, range=POSITIVE),
            Variable("inertia", par, "kg.m2", "inertia of all that turns", self.inertia, range=POSITIVE),
            Variable(
                "displacement", par, "m3/rad", "displacement of the pump", self.displacement, 1e-4, range=POSITIVE
            ),
            Variable(
                "relief_pressure",
                par,
                "Pa",
                "opening pressure of the relief valve",
                self.relief_pressure,
                1e7,
                range=POSITIVE,
            ),
            Variable(
                "charge_pressure", par, "Pa", "pressure that is always there", self.charge_pressure, 1e6, range=POSITIVE
            ),
            Variable("droop", par, "1", "gain of speed from full load to none", self.droop, 0.1, range=POSITIVE),
            Variable(
                "torque_rise", par, "1", "peak torque over rated torque, less 1", self.torque_rise, range=NOT_NEGATIVE
            ),
            Variable("drag", par, "1", "torque that turns the engine without fuel", self.drag, range=NOT_NEGATIVE),
            Variable("governor_time", par, "s", "time constant of the fuel rack", self.governor_time, range=POSITIVE),
            Variable("pressure_time", par, "s", "time constant of the pressure", self.pressure_time, range=POSITIVE),
            Variable("efficiency", par, "1", "efficiency of the pump", self.efficiency, range=SHARE),
            Variable(
                "volumetric_efficiency", par, "1", "volumetric part of it", self.volumetric_efficiency, range=SHARE
            ),
            Variable("load_power", Kind.INPUT, "W", "power that the drives take", nominal=1e4),
            Variable("speed", state, "rad/s", "speed of the engine", speed, 1e2, kept_at_rest=True),
            Variable("rack", state, "1", "fuel rack, 0 to 1", rack, kept_at_rest=True),
            Variable(
                "pressure", state, "Pa", "pressure that the pump can hold", self.relief_pressure, 1e7, kept_at_rest=True
            ),
            Variable("flow", out, "m3/s", "flow that the pump can give", nominal=1e-2),
            Variable("given_power", out, "W", "power that the drives get", nominal=1e4),
            Variable("torque", out, "N.m", "torque of the engine", nominal=torque),
            Variable("power", out, "W", "power of the engine", nominal=self.rated_power),
            Variable("speed_ratio", out, "1", "speed of the engine over its rated speed"),
        )

    def equations(self, v: Any) -> Equations:
        xp = namespace(v.speed)
        ratio, rated = v.speed / v.rated_speed, v.rated_power / v.rated_speed
        most = rated * _torque(ratio, v.torque_rise)
        drag = v.drag * rated * ratio
        torque = v.rack * (most + drag) - drag
        flow = v.displacement * v.speed * v.volumetric_efficiency
        given = clip_above(v.load_power, xp.fmax(v.pressure * flow, 1e-6 * v.rated_power))
        # Driving, the pump's losses add to the load; braking, they take from what comes back.
        load = xp.if_else(given > 0.0, given / v.efficiency, given * v.efficiency) / v.speed
        rack = _within((1.0 + v.droop - ratio) / v.droop)
        held = v.charge_pressure + (v.relief_pressure - v.charge_pressure) * _within(
            (ratio - STALLING) / (LUGGED - STALLING)
        )
        return Equations(
            rates={
                "speed": (torque - load) / v.inertia,
                "rack": (rack - v.rack) / v.governor_time,
                "pressure": (held - v.pressure) / v.pressure_time,
            },
            outputs={
                "flow": flow,
                "given_power": given,
                "torque": torque,
                "power": torque * v.speed,
                "speed_ratio": ratio,
            },
        )


def _torque(ratio: Any, rise: Any) -> Any:
    """Full-load torque over rated torque, at a speed over rated speed."""
    return 1.0 + rise * (1.0 - ((ratio - PEAK) / (1.0 - PEAK)) ** 2)


def _within(share: Any) -> Any:
    """A share between 0 and 1."""
    return 0.5 + clip(share - 0.5, 0.5, 0.5)
