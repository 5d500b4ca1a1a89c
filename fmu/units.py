"""Units as FMI wants them: exponents of the SI base units and a factor, read from the unit's own symbol."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

_BASE = ("kg", "m", "s", "A", "K", "rad")
_SYMBOLS: dict[str, tuple[float, dict[str, int]]] = {
    "1": (1.0, {}),
    "%": (0.01, {}),
    **{symbol: (1.0, {symbol: 1}) for symbol in _BASE},
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "kN": (1e3, {"kg": 1, "m": 1, "s": -2}),
    "Nm": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "Pa": (1.0, {"kg": 1, "m": -1, "s": -2}),
    "bar": (1e5, {"kg": 1, "m": -1, "s": -2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "kJ": (1e3, {"kg": 1, "m": 2, "s": -2}),
    "W": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "kW": (1e3, {"kg": 1, "m": 2, "s": -3}),
    "Hz": (1.0, {"s": -1}),
    "mm": (1e-3, {"m": 1}),
    "km": (1e3, {"m": 1}),
    "g": (1e-3, {"kg": 1}),
    "t": (1e3, {"kg": 1}),
    "l": (1e-3, {"m": 3}),
    "min": (60.0, {"s": 1}),
    "h": (3600.0, {"s": 1}),
    "deg": (math.pi / 180.0, {"rad": 1}),
    "rev": (2.0 * math.pi, {"rad": 1}),
}
_SI = (
    *("1", "m", "s", "kg", "rad", "K", "N", "Pa", "J", "W", "m/s", "m/s2", "m2", "m3", "m3/s", "rad/s", "kg/m"),
    *("kg.m2", "N.m", "N/m", "N.s/m", "m3/rad", "Hz"),
)
"""Symbols that this library uses, one for each quantity."""
_TERM = re.compile(r"(%|[A-Za-z]+|1)(-?\d+)?")


@dataclass(frozen=True)
class Unit:
    """A unit: `factor` times the product of the SI base units to their `exponents` (kg, m, s, A, K, rad). The
    `offset` is added (degrees Celsius)."""

    factor: float
    exponents: tuple[int, ...]
    offset: float = 0.0

    def base(self) -> dict[str, int]:
        """Exponents other than zero, by base unit."""
        return {symbol: n for symbol, n in zip(_BASE, self.exponents, strict=True) if n}

    def fits(self, other: Unit) -> bool:
        """Whether both measure the same quantity; radians count as a pure number."""
        return self.exponents[:-1] == other.exponents[:-1]


def from_base(exponents: dict[str, int], factor: float = 1.0, offset: float = 0.0) -> Unit:
    """From exponents by base unit."""
    return Unit(factor, tuple(exponents.get(symbol, 0) for symbol in _BASE), offset)


def parse(symbol: str) -> Unit | None:
    """The unit of a symbol as `kg/m`, `1/N2`, `m/s2`; None when a part of it is not known.

    All that follows a slash divides; a dot, a star or a blank multiplies.
    """
    factor, exponents = 1.0, dict.fromkeys(_BASE, 0)
    for i, part in enumerate(symbol.strip("()").split("/")):
        for term in re.split(r"[.*· ()]+", part):
            if not term:
                continue
            match = _TERM.fullmatch(term)
            if match is None or match[1] not in _SYMBOLS:
                return None
            power = int(match[2] or 1) * (-1 if i else 1)
            one, base = _SYMBOLS[match[1]]
            factor *= one**power
            for name, n in base.items():
                exponents[name] += n * power
    return Unit(factor, tuple(exponents.values()))


def to_si(symbol: str, defined: Mapping[str, Unit]) -> tuple[str, float, float]:
    """The SI unit of a symbol, of those `defined` or by its parts, and the factor and offset to it. A symbol that is
    not known, or has none here, stays as it is."""
    unit = defined.get(symbol) or parse(symbol)
    if not symbol or unit is None:
        return symbol, 1.0, 0.0
    if unit == parse(symbol) and (unit.factor, unit.offset) == (1.0, 0.0) and symbol in _SI:
        return symbol, 1.0, 0.0
    for name in _SI:
        if (known := parse(name)) is not None and known.exponents == unit.exponents:
            return name, unit.factor, unit.offset
    return symbol, 1.0, 0.0
