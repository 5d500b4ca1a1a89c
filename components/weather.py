"""The weather in equations: written once for symbols and numbers, for ropes and for loads.

Every system has these quantities in common; components read them as `v.weather`. Wind on a rope is normal to its chord,
in the plane of wind and chord: c_d q (d + 2 t) sin(angle)^2 on each unstretched metre. That the rope's own slope is
taken as that of its chord is the one approximation; with it the force is uniform, and the closed form stays exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from ropeway.components.catenary import Uniform, Vector, namespace
from ropeway.components.check import NOT_NEGATIVE, POSITIVE, Range
from ropeway.components.environment import TEMPERATURES, Environment
from ropeway.components.schedule import Schedule
from ropeway.components.variable import Kind, Site, Variable

_NO_WIND = 1e-300
"""Square of a negligible sine, which keeps the derivatives of a wind along the chord finite."""


AIR_DENSITY = 1.25
"""Density of air, by which the velocity of a wind follows from its pressure [kg/m3]."""


class Weather(NamedTuple):
    """Weather in equations: how much warmer the ropes are than when they were strung [K], thickness [m] and density
    [kg/m3] of their ice, and the wind: dynamic pressure [Pa], and the direction (x, y) that it blows."""

    warming: Any
    ice_thickness: Any
    ice_density: Any
    pressure: Any
    wind_x: Any
    wind_y: Any

    @classmethod
    def of(cls, values: Sequence[Any]) -> Weather:
        """From the values of `SHARED`."""
        temperature, pressure, coming, strung, thickness, density, north = values
        towards = (coming - north) * (math.pi / 180.0)
        xp = namespace(towards)
        return cls(temperature - strung, thickness, density, pressure, -xp.sin(towards), -xp.cos(towards))

    def rope(self, mass_per_length: Any, gravity: Any, diameter: Any, drag_coefficient: Any, chord: Vector) -> Uniform:
        """Weight with ice, and wind, of a rope whose span has this chord."""
        ice = self.ice_density * math.pi * self.ice_thickness * (diameter + self.ice_thickness)
        weight = (mass_per_length + ice) * gravity
        along = (self.wind_x * chord[0] + self.wind_y * chord[1]) / sum(c * c for c in chord)
        across = (self.wind_x - along * chord[0], self.wind_y - along * chord[1], -along * chord[2])
        sine = namespace(*across).sqrt(sum(a * a for a in across) + _NO_WIND)
        share = self.pressure * drag_coefficient * (diameter + 2 * self.ice_thickness) * sine
        return Uniform.of((share * across[0], share * across[1], share * across[2] - weight))

    def expansion(self, thermal_expansion: Any) -> Any:
        """Length of a rope without tension over that at which it was strung."""
        return 1 + thermal_expansion * self.warming

    def drag(self, area: Any) -> Vector:
        """Force of the wind on a body with a drag area [m2]: coefficient times area."""
        force = area * self.pressure
        return (force * self.wind_x, force * self.wind_y, 0.0)

    def relative(self, velocity: Vector, along: Vector | None = None) -> Vector:
        """Dynamic pressure of the air on a body with a velocity [m/s], less that on a body at rest, as a vector [Pa];
        `along`: unit vector of a rope, of which only what is across it counts."""
        xp = namespace(self.pressure, *velocity)
        # Integrators look a little before the time at which a wind rises from nothing.
        speed = xp.sqrt(2 * xp.fmax(self.pressure, 0) / AIR_DENSITY + _NO_WIND)
        wind = _across((speed * self.wind_x, speed * self.wind_y, 0.0), along)
        seen = _across((wind[0] - velocity[0], wind[1] - velocity[1], wind[2] - velocity[2]), along)
        moving, still = (xp.sqrt(sum(c * c for c in w) + _NO_WIND) for w in (seen, wind))
        x, y, z = (AIR_DENSITY / 2 * (moving * seen[i] - still * wind[i]) for i in range(3))
        return (x, y, z)


def _across(vector: Vector, along: Vector | None) -> Vector:
    """The part of a vector across a unit vector."""
    if along is None:
        return vector
    part = vector[0] * along[0] + vector[1] * along[1] + vector[2] * along[2]
    return (vector[0] - part * along[0], vector[1] - part * along[1], vector[2] - part * along[2])


INPUTS = ("temperature", "wind_pressure", "wind_from")
"""Quantities of the weather that may change during a run."""
SHARED = (*INPUTS, "strung_temperature", "ice_thickness", "ice_density", "north")
"""Quantities that `Weather.of` takes."""


def shared_variables(
    environment: Environment | None, gravity: float, strung: float, north: float, thin: Sequence[str]
) -> tuple[Variable, ...]:
    """Quantities that all components of a system have in common: gravity; with an environment also the values of the
    weather. `strung`: temperature at which the ropes were strung; `north`: direction of the y axis, clockwise from
    grid north; `thin`: names of ropes without a diameter, which bear neither ice nor wind."""
    par, inp = Kind.PARAMETER, Kind.INPUT
    own = Variable("gravity", par, "m/s2", "gravity", gravity, gravity, range=POSITIVE)
    if environment is None:
        return (own,)
    values = {name: _first(signal) for name, signal in zip(INPUTS, signals_of(environment, strung), strict=True)}
    bare = Range(0.0, 0.0, named=f"zero, or rope {thin[0]!r} a diameter") if thin else NOT_NEGATIVE
    return (
        own,
        Variable("temperature", inp, "degC", "temperature", values["temperature"], 10.0, range=TEMPERATURES),
        Variable("wind_pressure", inp, "Pa", "wind pressure", values["wind_pressure"], 100.0, range=bare),
        Variable("wind_from", inp, "deg", "direction of the wind, clockwise from north", values["wind_from"], 90.0),
        Variable("strung_temperature", par, "degC", "temperature of stringing", strung, 10.0, range=TEMPERATURES),
        Variable("ice_thickness", par, "m", "thickness of ice on ropes", environment.ice_thickness, 0.01, range=bare),
        Variable("ice_density", par, "kg/m3", "density of ice", environment.ice_density, 900.0, range=POSITIVE),
        Variable("north", par, "deg", "direction of the y axis, clockwise from north", north, 90.0),
    )


def signals_of(environment: Environment, strung: float) -> tuple[float | Schedule, ...]:
    """Values over time of `INPUTS`."""
    temperature = strung if environment.temperature is None else environment.temperature
    return (temperature, environment.pressure, environment.wind_from)


def values_of(environment: Environment, strung: float) -> dict[str, float]:
    """Values at rest of all quantities that an environment sets, by their names in a model."""
    found = {name: _first(s) for name, s in zip(INPUTS, signals_of(environment, strung), strict=True)}
    return found | {"ice_thickness": environment.ice_thickness, "ice_density": environment.ice_density}


def _first(signal: float | Schedule) -> float:
    return signal.at(0.0) if isinstance(signal, Schedule) else signal


def drag_variables(site: Site, area: float) -> tuple[Variable, ...]:
    """The variables of a body in the wind; none without weather."""
    if not site.weather:
        return ()
    return (Variable("drag_area", Kind.PARAMETER, "m2", "drag coefficient times area", area, 1.0, range=NOT_NEGATIVE),)
