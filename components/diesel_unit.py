"""A diesel engine with a hydraulic pump: the flow and pressure available to drives, and the engine's response."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import namespace
from ropeway.components.check import NOT_NEGATIVE, POSITIVE, SHARE
from ropeway.components.component import Component, Port
from ropeway.components.errors import InputError
from ropeway.components.smooth import clip, clip_above
from ropeway.components.variable import Equations, Kind, Limit, Site, Variable

PEAK = 0.6
"""Speed of the peak torque over rated speed."""
OVERSPEED = 1.2
"""Speed over rated speed above which an engine that the line drives may be damaged."""
LUGGED, STALLING = 0.8, 0.6
"""Speeds over rated speed: below the first the pump reduces its pressure; at the second only charge pressure is left.
"""


@checked
@dataclass(frozen=True)
class DieselHydraulicUnit(Component):
    """A diesel engine with a droop governor that drives a variable pump in closed circuits.

    It supplies a `flow` [m3/s] at a `pressure` [Pa]. The input `load_power` [W] is the demand of the drives, negative
    when they return power; they receive at full_load flow times pressure. The flow falls with the engine speed. Below
    0.8 of rated speed the pump reduces its pressure, down to the charge pressure at 0.6. The torque curve is a parabola
    and the governor is proportional: textbook relations, combined here.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    rated_power : float
        Rated power of the engine [W].
    rated_speed : float
        Rated speed of the engine [rad/s].
    inertia : float
        Moment of inertia of all rotating parts [kg m2].
    displacement : float
        Displacement of the pump [m3/rad].
    relief_pressure : float
        Opening pressure of the relief valve [Pa].
    charge_pressure : float, default 20e5
        Charge pressure [Pa], below the relief pressure.
    droop : float, default 0.08
        Speed increase from full load to no load, over rated speed.
    torque_rise : float, default 0.2
        Peak torque over rated torque, minus 1.
    drag : float, default 0.15
        Torque that turns the engine without fuel, over rated torque.
    governor_time : float, default 0.2
        Time constant of the fuel rack [s].
    pressure_time : float, default 0.1
        Time constant of the pressure [s].
    efficiency : float, default 0.88
        Total efficiency of the pump, 0 to 1.
    volumetric_efficiency : float, default 0.95
        Volumetric efficiency of the pump, 0 to 1.

    Raises
    ------
    InputError
        A value out of its range, or a charge pressure above the relief pressure.

    Examples
    --------
    >>> rw.DieselHydraulicUnit(
    ...     "unit", rated_power=90e3, rated_speed=230.0, inertia=4.0, displacement=1e-4, relief_pressure=30e6
    ... ).rated_power
    90000.0
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
                "Give a charge pressure below the relief pressure",
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
        rack = self.drag * idle / (_torque(idle, self.torque_rise) + self.drag * idle)  # close to no load
        speed = self.rated_speed * (1.0 + self.droop * (1.0 - rack))
        return (
            Variable("rated_power", par, "W", "rated power of the engine", self.rated_power, 1e5, range=POSITIVE),
            Variable("rated_speed", par, "rad/s", "rated speed of the engine", self.rated_speed, 1e2, range=POSITIVE),
            Variable("inertia", par, "kg.m2", "moment of inertia of all rotating parts", self.inertia, range=POSITIVE),
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
            Variable("charge_pressure", par, "Pa", "charge pressure", self.charge_pressure, 1e6, range=POSITIVE),
            Variable(
                "droop",
                par,
                "1",
                "speed increase from full load to no load, over rated speed",
                self.droop,
                0.1,
                range=POSITIVE,
            ),
            Variable(
                "torque_rise", par, "1", "peak torque over rated torque, minus 1", self.torque_rise, range=NOT_NEGATIVE
            ),
            Variable(
                "drag",
                par,
                "1",
                "torque that turns the engine without fuel, over rated torque",
                self.drag,
                range=NOT_NEGATIVE,
            ),
            Variable("governor_time", par, "s", "time constant of the fuel rack", self.governor_time, range=POSITIVE),
            Variable("pressure_time", par, "s", "time constant of the pressure", self.pressure_time, range=POSITIVE),
            Variable("efficiency", par, "1", "efficiency of the pump", self.efficiency, range=SHARE),
            Variable(
                "volumetric_efficiency",
                par,
                "1",
                "volumetric efficiency of the pump",
                self.volumetric_efficiency,
                range=SHARE,
            ),
            Variable("load_power", Kind.INPUT, "W", "power demand of the drives", nominal=1e4),
            Variable("speed", state, "rad/s", "speed of the engine", speed, 1e2, kept_at_rest=True),
            Variable("rack", state, "1", "fuel rack, 0 to 1", rack, kept_at_rest=True),
            Variable("pressure", state, "Pa", "available pressure", self.relief_pressure, 1e7, kept_at_rest=True),
            Variable("flow", out, "m3/s", "available flow", nominal=1e-2),
            Variable("given_power", out, "W", "power delivered to the drives", nominal=1e4),
            Variable("torque", out, "N.m", "torque of the engine", nominal=torque),
            Variable("power", out, "W", "power of the engine", nominal=self.rated_power),
            Variable("speed_ratio", out, "1", "speed of the engine over its rated speed"),
        )

    def equations(self, v: Any) -> Equations:
        xp = namespace(v.speed)
        ratio, rated = v.speed / v.rated_speed, v.rated_power / v.rated_speed
        full_load = rated * _torque(ratio, v.torque_rise)
        drag = v.drag * rated * ratio
        torque = v.rack * (full_load + drag) - drag
        flow = v.displacement * v.speed * v.volumetric_efficiency
        delivered = clip_above(v.load_power, xp.fmax(v.pressure * flow, 1e-6 * v.rated_power))
        # Pump losses add to a driving load, and reduce the power that braking returns.
        load = xp.if_else(delivered > 0.0, delivered / v.efficiency, delivered * v.efficiency) / v.speed
        rack = _within((1.0 + v.droop - ratio) / v.droop)
        available = v.charge_pressure + (v.relief_pressure - v.charge_pressure) * _within(
            (ratio - STALLING) / (LUGGED - STALLING)
        )
        return Equations(
            rates={
                "speed": (torque - load) / v.inertia,
                "rack": (rack - v.rack) / v.governor_time,
                "pressure": (available - v.pressure) / v.pressure_time,
            },
            outputs={
                "flow": flow,
                "given_power": delivered,
                "torque": torque,
                "power": torque * v.speed,
                "speed_ratio": ratio,
            },
        )


def _torque(ratio: Any, rise: Any) -> Any:
    """Full-load torque over rated torque, at a speed over rated speed."""
    return 1.0 + rise * (1.0 - ((ratio - PEAK) / (1.0 - PEAK)) ** 2)


def _within(share: Any) -> Any:
    """A ratio limited to 0 to 1."""
    return 0.5 + clip(share - 0.5, 0.5, 0.5)
