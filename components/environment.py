"""The weather that a system stands in: temperature, ice on the ropes, wind."""

from __future__ import annotations

from dataclasses import dataclass, field

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.check import NOT_NEGATIVE, POSITIVE, Range
from ropeway.components.errors import InputError
from ropeway.components.schedule import Schedule

Changing = float | Schedule
"""A value that may change during a run."""

ABSOLUTE_ZERO = -273.15
TEMPERATURES = Range(ABSOLUTE_ZERO, 1000.0, above=True, named="a temperature above -273.15, at most 1000")


@checked
@dataclass(frozen=True)
class Environment:
    """Temperature, ice and wind, the same at all places of a system.

    Temperature, wind pressure and direction may be a `Schedule` of their values over a simulation; at rest the first
    one counts. A calm environment at the temperature of stringing gives what a system without environment gives, bit
    for bit. Assumptions: `docs/weather.md`.

    Parameters
    ----------
    name : str
        Any text; it names the case in tables.
    temperature : float or Schedule, optional
        Temperature of the ropes [degrees C]; by default that at which they were strung.
    ice_thickness : float, default 0
        Thickness of the ice around the ropes [m].
    ice_density : float, default 900
        Density of the ice [kg/m3].
    wind_pressure : float or Schedule, optional
        Dynamic pressure of the wind, 1/2 density speed^2 [Pa]; give either this or `wind_speed`. By default no wind.
    wind_speed : float, optional
        Speed of the wind [m/s].
    wind_from : float or Schedule, default 0
        Direction that the wind comes from [degrees, clockwise]: from grid north where the system has a map, else from
        +y, so that a wind from 270 blows along +x.
    air_density : float, default 1.25
        Density of the air, for `wind_speed` [kg/m3].

    Raises
    ------
    InputError
        A value that no weather has, or both pressure and speed of the wind.

    Examples
    --------
    >>> rw.Environment("iced", temperature=-20.0, ice_thickness=0.01, wind_pressure=250.0).ice_thickness
    0.01
    """

    name: str
    temperature: Changing | None = field(default=None, kw_only=True)
    ice_thickness: float = field(default=0.0, kw_only=True)
    ice_density: float = field(default=900.0, kw_only=True)
    wind_pressure: Changing | None = field(default=None, kw_only=True)
    wind_speed: float | None = field(default=None, kw_only=True)
    wind_from: Changing = field(default=0.0, kw_only=True)
    air_density: float = field(default=1.25, kw_only=True)

    def __post_init__(self) -> None:
        owner = f"Environment {self.name!r}"
        for name, unit, within in (
            ("temperature", "degrees C", TEMPERATURES),
            ("ice_thickness", "m", NOT_NEGATIVE),
            ("ice_density", "kg/m3", POSITIVE),
            ("wind_pressure", "Pa", NOT_NEGATIVE),
            ("wind_speed", "m/s", NOT_NEGATIVE),
            ("wind_from", "degrees", Range()),
            ("air_density", "kg/m3", POSITIVE),
        ):
            value = getattr(self, name)
            for one in value.speeds if isinstance(value, Schedule) else () if value is None else (value,):
                check.number(one, owner, name, unit, within)
        if self.wind_pressure is not None and self.wind_speed is not None:
            raise InputError(f"{owner} has wind_pressure and wind_speed", "Give one of them")

    @property
    def pressure(self) -> Changing:
        """Dynamic pressure of the wind [Pa]."""
        if self.wind_pressure is not None:
            return self.wind_pressure
        return 0.5 * self.air_density * (self.wind_speed or 0.0) ** 2

    @property
    def needs_diameter(self) -> bool:
        """Whether there is wind or ice, whose forces follow from the ropes' diameters."""
        pressure = self.pressure
        most = max(pressure.speeds) if isinstance(pressure, Schedule) else pressure
        return most > 0.0 or self.ice_thickness > 0.0

    @property
    def words(self) -> str:
        """Its name and values, for reports."""

        def value(quantity: Changing) -> str:
            if isinstance(quantity, Schedule):
                return f"{min(quantity.speeds):g} to {max(quantity.speeds):g}"
            return f"{quantity:g}"

        parts = [] if self.temperature is None else [f"{value(self.temperature)} °C"]
        if self.ice_thickness > 0.0:
            parts.append(f"{1e3 * self.ice_thickness:g} mm of ice of {self.ice_density:g} kg/m³")
        if self.pressure != 0.0:
            parts.append(f"wind of {value(self.pressure)} Pa from {value(self.wind_from)}°")
        return f"{self.name}: {', '.join(parts)}" if parts else self.name

    def is_calm(self, strung: float) -> bool:
        """Whether there is neither wind nor ice, and ropes are as warm as when they were strung.

        Parameters
        ----------
        strung : float
            Temperature of stringing [degrees C].

        Returns
        -------
        bool
            False also where a value changes over time.
        """
        return self.temperature in (None, strung) and self.pressure == 0.0 and self.ice_thickness == 0.0


CALM = Environment("calm")
