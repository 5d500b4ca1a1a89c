"""How a report writes: words of a language, values in metric or imperial units, limits rounded to the safe side."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np

from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.rounding import at_least, at_most
from ropeway.components.units import factor
from ropeway.systems.reporting.labels import ENGLISH

Units = Literal["metric", "imperial"]
Side = Literal["near", "down", "up"]


class Shown(NamedTuple):
    """How a quantity is shown: its unit, the size of that in SI units, and the digits behind the point."""

    unit: str
    size: float
    places: int


_METRIC = {
    "length": Shown("m", 1.0, 1),
    "short_length": Shown("m", 1.0, 2),
    "diameter": Shown("mm", 1e-3, 1),
    "mass": Shown("kg", 1.0, 0),
    "mass_per_length": Shown("kg/m", 1.0, 3),
    "force": Shown("kN", 1e3, 1),
    "stiffness": Shown("MN", 1e6, 1),
    "speed": Shown("m/s", 1.0, 3),
    "power": Shown("kW", 1e3, 1),
    "energy": Shown("kWh", 3.6e6, 2),
    "acceleration": Shown("m/s²", 1.0, 5),
    "time": Shown("s", 1.0, 1),
    "angle": Shown("°", math.pi / 180.0, 1),
    "degrees": Shown("°", 1.0, 2),
    "percent": Shown("%", 0.01, 0),
    "deflection": Shown("%", 1.0, 1),
    "number": Shown("", 1.0, 2),
    "temperature": Shown("°C", 1.0, 1),
    "pressure": Shown("Pa", 1.0, 0),
}
_IMPERIAL = _METRIC | {
    "length": Shown("ft", factor("ft", "m"), 1),
    "short_length": Shown("ft", factor("ft", "m"), 2),
    "diameter": Shown("in", factor("in", "m"), 3),
    "mass": Shown("lb", factor("lb", "kg"), 0),
    "mass_per_length": Shown("lb/ft", factor("lb/ft", "kg/m"), 3),
    "force": Shown("kip", factor("kip", "N"), 2),
    "stiffness": Shown("kip", factor("kip", "N"), 0),
    "speed": Shown("ft/s", factor("ft", "m"), 3),
    "power": Shown("hp", factor("hp", "W"), 1),
    "acceleration": Shown("ft/s²", factor("ft", "m"), 4),
}
_SHOWN: Mapping[str, Mapping[str, Shown]] = {"metric": _METRIC, "imperial": _IMPERIAL}


@dataclass(frozen=True)
class Style:
    """Words and units of a report; `labels` replace single words of `ENGLISH`. Raises InputError."""

    units: Units = "metric"
    labels: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.units not in _SHOWN:
            raise InputError(f"Units of the report are {self.units!r}", 'Choose "metric" or "imperial"')
        if unknown := set(self.labels) - set(ENGLISH):
            raise UnknownNameError(f"Reports have no label {min(unknown)!r}", "The labels are in reporting/labels.py")

    def text(self, key: str, **values: Any) -> str:
        """A label, with values in its braces."""
        label = self.labels.get(key, ENGLISH[key])
        return label.format(**values) if values else label

    def shown(self, quantity: str) -> Shown:
        """How a quantity is shown."""
        return _SHOWN[self.units][quantity]

    def number(self, value: Any, quantity: str, side: Side = "near") -> str:
        """A value in SI units as text, without its unit; a dash where there is none."""
        if value is None or not math.isfinite(float(value)):
            return "-" if value is None or math.isnan(float(value)) else "∞"
        unit = self.shown(quantity)
        scaled = float(value) / unit.size
        if side == "near":
            return f"{round(scaled, unit.places) + 0.0:.{unit.places}f}"
        return (at_most if side == "down" else at_least)(scaled, unit.places)

    def value(self, value: Any, quantity: str, side: Side = "near") -> str:
        """A value in SI units as text with its unit."""
        unit = self.shown(quantity).unit
        space = "" if unit in ("", "°") else " "
        return f"{self.number(value, quantity, side)}{space}{unit}"

    def head(self, key: str, quantity: str | None = None) -> str:
        """The head of a column or axis, with the unit in brackets."""
        unit = "" if quantity is None else self.shown(quantity).unit
        return f"{self.text(key)} [{unit}]" if unit else self.text(key)

    def scaled(self, values: Any, quantity: str) -> np.ndarray:
        """Values in SI units as they are drawn."""
        return np.asarray(values, dtype=float) / self.shown(quantity).size
