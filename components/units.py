"""Units: what a symbol such as `kN`, `m/s2` or `L/min` measures, and how to convert it.

Symbols are read as in FMI, Modelica and data sheets. A unit is a factor times a product of the SI base units. The angle
`rad` counts as a base unit, so that a frequency and an angular velocity differ.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from ropeway.components.errors import InputError

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""The SI base units and the angle, in the order of `Unit.exponents`."""


@dataclass(frozen=True)
class Unit:
    """A unit: x of it equals `factor * x + offset` of the product of the `BASE` units to their `exponents`."""

    factor: float
    exponents: tuple[int, ...]
    offset: float = 0.0

    def base(self) -> dict[str, int]:
        """Nonzero exponents by base unit."""
        return {symbol: n for symbol, n in zip(BASE, self.exponents, strict=True) if n}

    def fits(self, other: Unit) -> bool:
        """Whether both measure the same quantity.

        An angle counts as a pure number (N.m/rad is N.m), but not in a rate: 1 Hz may be one turn or one radian per
        second.
        """
        if self.exponents[:-1] != other.exponents[:-1]:
            return False
        return self.exponents == other.exponents or set(self.base()) | set(other.base()) != {"s", "rad"}


class Conversion(NamedTuple):
    """x of one unit equals `factor * x + offset` of another."""

    factor: float
    offset: float


def from_base(exponents: Mapping[str, int], factor: float = 1.0, offset: float = 0.0) -> Unit:
    """A unit from its exponents by base unit."""
    return Unit(factor, tuple(exponents.get(symbol, 0) for symbol in BASE), offset)


_PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "h": 1e2, "da": 1e1, "d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "µ": 1e-6}
_PREFIXES |= {"μ": 1e-6, "n": 1e-9}
_GRAVITY = 9.80665
_POUND, _FOOT = 0.45359237, 0.3048

_PREFIXED: dict[str, Unit] = {
    **{symbol: from_base({symbol: 1}) for symbol in BASE if symbol != "kg"},
    "g": from_base({"kg": 1}, 1e-3),
    "N": from_base({"kg": 1, "m": 1, "s": -2}),
    "Nm": from_base({"kg": 1, "m": 2, "s": -2}),
    "Pa": from_base({"kg": 1, "m": -1, "s": -2}),
    "bar": from_base({"kg": 1, "m": -1, "s": -2}, 1e5),
    "J": from_base({"kg": 1, "m": 2, "s": -2}),
    "Wh": from_base({"kg": 1, "m": 2, "s": -2}, 3600.0),
    "W": from_base({"kg": 1, "m": 2, "s": -3}),
    "Hz": from_base({"s": -1}),
    "l": from_base({"m": 3}, 1e-3),
    "L": from_base({"m": 3}, 1e-3),
    "C": from_base({"A": 1, "s": 1}),
    "V": from_base({"kg": 1, "m": 2, "s": -3, "A": -1}),
    "Ohm": from_base({"kg": 1, "m": 2, "s": -3, "A": -2}),
    "ohm": from_base({"kg": 1, "m": 2, "s": -3, "A": -2}),
    "Ω": from_base({"kg": 1, "m": 2, "s": -3, "A": -2}),
    "S": from_base({"kg": -1, "m": -2, "s": 3, "A": 2}),
    "F": from_base({"kg": -1, "m": -2, "s": 4, "A": 2}),
    "H": from_base({"kg": 1, "m": 2, "s": -2, "A": -2}),
    "Wb": from_base({"kg": 1, "m": 2, "s": -2, "A": -1}),
    "T": from_base({"kg": 1, "s": -2, "A": -1}),
}
"""Symbols with prefixes."""


def _force(newtons: float) -> Unit:
    return from_base({"kg": 1, "m": 1, "s": -2}, newtons)


def _pressure(pascals: float) -> Unit:
    return from_base({"kg": 1, "m": -1, "s": -2}, pascals)


def _turns(rate: float) -> Unit:
    return from_base({"rad": 1, "s": -1}, 2.0 * math.pi * rate)


_PLAIN: dict[str, Unit] = {
    "1": from_base({}),
    "-": from_base({}),
    "%": from_base({}, 0.01),
    "‰": from_base({}, 1e-3),
    "ppm": from_base({}, 1e-6),
    "kg": from_base({"kg": 1}),
    "t": from_base({"kg": 1}, 1e3),
    "lb": from_base({"kg": 1}, _POUND),
    "lbm": from_base({"kg": 1}, _POUND),
    "oz": from_base({"kg": 1}, _POUND / 16.0),
    "in": from_base({"m": 1}, _FOOT / 12.0),
    "ft": from_base({"m": 1}, _FOOT),
    "ftUS": from_base({"m": 1}, 1200.0 / 3937.0),
    "yd": from_base({"m": 1}, 3.0 * _FOOT),
    "mi": from_base({"m": 1}, 5280.0 * _FOOT),
    "mile": from_base({"m": 1}, 5280.0 * _FOOT),
    "ha": from_base({"m": 2}, 1e4),
    "sec": from_base({"s": 1}),
    "min": from_base({"s": 1}, 60.0),
    "h": from_base({"s": 1}, 3600.0),
    "hr": from_base({"s": 1}, 3600.0),
    "d": from_base({"s": 1}, 86400.0),
    "kgf": _force(_GRAVITY),
    "kp": _force(_GRAVITY),
    "tf": _force(1e3 * _GRAVITY),
    "lbf": _force(_POUND * _GRAVITY),
    "kip": _force(1e3 * _POUND * _GRAVITY),
    "kph": from_base({"m": 1, "s": -1}, 1.0 / 3.6),
    "kmh": from_base({"m": 1, "s": -1}, 1.0 / 3.6),
    "mph": from_base({"m": 1, "s": -1}, 5280.0 * _FOOT / 3600.0),
    "fpm": from_base({"m": 1, "s": -1}, _FOOT / 60.0),
    "lpm": from_base({"m": 3, "s": -1}, 1e-3 / 60.0),
    "psi": _pressure(_POUND * _GRAVITY / (_FOOT / 12.0) ** 2),
    "ksi": _pressure(1e3 * _POUND * _GRAVITY / (_FOOT / 12.0) ** 2),
    "at": _pressure(1e4 * _GRAVITY),
    "atm": _pressure(101325.0),
    "hp": from_base({"kg": 1, "m": 2, "s": -3}, 550.0 * _FOOT * _POUND * _GRAVITY),
    "PS": from_base({"kg": 1, "m": 2, "s": -3}, 75.0 * _GRAVITY),
    "deg": from_base({"rad": 1}, math.pi / 180.0),
    "°": from_base({"rad": 1}, math.pi / 180.0),
    "gon": from_base({"rad": 1}, math.pi / 200.0),
    "rev": from_base({"rad": 1}, 2.0 * math.pi),
    "rpm": _turns(1.0 / 60.0),
    "rps": _turns(1.0),
    "degC": from_base({"K": 1}, 1.0, 273.15),
    "°C": from_base({"K": 1}, 1.0, 273.15),
    "degF": from_base({"K": 1}, 5.0 / 9.0, 459.67 * 5.0 / 9.0),
    "°F": from_base({"K": 1}, 5.0 / 9.0, 459.67 * 5.0 / 9.0),
}
"""Symbols without prefixes."""

_WORDS = {
    **dict.fromkeys(("metre", "metres", "meter", "meters"), "m"),
    **dict.fromkeys(("centimetre", "centimetres", "centimeter", "centimeters"), "cm"),
    **dict.fromkeys(("foot", "feet", "international foot", "international feet"), "ft"),
    **dict.fromkeys(("us survey foot", "us survey feet", "us foot", "us feet", "us-ft", "us_ft", "foot_us"), "ftUS"),
    **dict.fromkeys(("ft us", "ft_us", "survey foot", "survey feet", "us_survey_foot", "sft"), "ftUS"),
    **dict.fromkeys(("u/min", "tr/min", "r/min"), "rpm"),
}
"""Words for symbols, in lower case."""

_SI = (
    *("1", "m", "s", "kg", "rad", "K", "N", "Pa", "J", "W", "m/s", "m/s2", "m2", "m3", "m3/s", "rad/s", "kg/m"),
    *("kg.m2", "N.m", "N/m", "N.s/m", "m3/rad", "Hz"),
)
"""Symbols used by this library; the first one of a quantity is its default."""

_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_BRACKET = re.compile(r"\(([^()]*)\)")
_TERM = re.compile(r"([^\d^+()-]+)(?:\^?([-+]?[1-9]\d?))?")


@lru_cache(maxsize=1024)
def parse(symbol: str) -> Unit | None:
    """The unit of a symbol.

    Parameters
    ----------
    symbol : str
        Such as `kg/m`, `1/N2`, `m/s^2`, `N.m/(rad/s)`, `daN`, `L/min`, `degC`. A dot, an asterisk or a blank
        multiplies; everything after a slash divides.

    Returns
    -------
    Unit or None
        None if a part of the symbol is unknown, or the symbol is empty.
    """
    text = symbol.strip()
    text = _WORDS.get(text.lower(), text)
    known = _PLAIN.get(text)
    if known is not None:
        return known
    text = text.translate(_RAISED).replace("**", "^")
    inner: dict[str, Unit] = {}
    while (bracket := _BRACKET.search(text)) is not None:  # innermost first; a private letter replaces it
        unit = _quotient(bracket[1], inner)
        if unit is None:
            return None
        stand_in = chr(0xE000 + len(inner))
        inner[stand_in] = unit
        text = f"{text[: bracket.start()]}.{stand_in}{text[bracket.end() :]}".replace("/.", "/").lstrip(".")
    return _quotient(text, inner)


def read(symbol: str, defined: Mapping[str, Unit] | None = None) -> Unit | None:
    """The unit of a symbol by its definition, else by the symbol itself; None if both are unknown.

    A definition without the angle takes it from the symbol: rad/s and rpm are often defined as 1/s.
    """
    given, known = (defined or {}).get(symbol), parse(symbol)
    if given is None or known is None or given.exponents[:-1] != known.exponents[:-1] or given.exponents[-1]:
        return known if given is None else given
    return Unit(given.factor, known.exponents, given.offset)


def conversion(
    source: str,
    target: str,
    source_units: Mapping[str, Unit] | None = None,
    target_units: Mapping[str, Unit] | None = None,
    *,
    differences: tuple[bool, bool] = (False, False),
) -> Conversion:
    """Conversion of values from one unit to another.

    Parameters
    ----------
    source, target : str
        Symbols; if one is empty, the values are not converted.
    source_units, target_units : mapping of str to Unit, optional
        Definitions on either side, which take precedence over the symbol.
    differences : (bool, bool), default (False, False)
        Whether the values of the source and of the target are differences, without the zero of a scale: a difference of
        10 degC is 10 K.

    Raises
    ------
    InputError
        The units measure different quantities, or one is unknown; or only one side is a difference on a scale with its
        own zero. Two equal symbols that neither side defines count as one unit.
    """
    one, other = read(source, source_units), read(target, target_units)
    if not source or not target or (one is None and other is None and source == target):
        return Conversion(1.0, 0.0)
    for symbol, unit in ((source, one), (target, other)):
        if unit is None:
            raise InputError(
                f"The unit {symbol!r} is unknown, so it cannot be converted ({source!r} to {target!r})",
                "Use symbols such as kN, m/s2, L/min, or define the unit by its SI base units",
            )
    if one is None or other is None:  # for the type checker: the loop has raised
        raise InputError(f"No conversion from {source!r} to {target!r}")
    if not one.fits(other):
        raise InputError(f"{source!r} and {target!r} measure different quantities", _mismatch(one, other))
    if any(differences):
        if not all(differences) and (other if differences[0] else one).offset:
            raise InputError(
                f"A difference cannot become a value on the scale of {(target if differences[0] else source)!r}",
                "Use two differences (relativeQuantity in an FMU), or two values",
            )
        return Conversion(one.factor / other.factor, 0.0)
    return Conversion(one.factor / other.factor, (one.offset - other.offset) / other.factor)


def factor(source: str, target: str) -> float:
    """Factor that converts values in `source` to values in `target`.

    Raises InputError, also for scales with different zeros.
    """
    found = conversion(source, target)
    if found.offset:
        raise InputError(f"{source!r} and {target!r} have different zeros", "Convert by factor and offset")
    return found.factor


def same(one: str, other: str) -> bool:
    """Whether two symbols are the same unit, by text or by value (N.m, Nm)."""
    return one == other or (parse(one) is not None and parse(one) == parse(other))


def to_si(
    symbol: str, defined: Mapping[str, Unit] | None = None, *, difference: bool = False
) -> tuple[str, float, float]:
    """The SI unit of a symbol, and factor and offset to it; the offset of a `difference` is 0.

    An unknown symbol is returned unchanged.
    """
    unit = read(symbol, defined)
    if unit is None:
        return symbol, 1.0, 0.0
    if symbol in _SI and unit == parse(symbol):
        return symbol, 1.0, 0.0
    name = next((s for s in _SI if (known := parse(s)) is not None and known.exponents == unit.exponents), None)
    return name or _product(unit), unit.factor, 0.0 if difference else unit.offset


def _mismatch(one: Unit, other: Unit) -> str:
    if {"s", "rad"} == set(one.base()) | set(other.base()):
        return "Hz may be turns or radians per second: use rpm or rad/s"
    return f"Connect variables of the same quantity; these are {_product(one)} and {_product(other)} in SI base units"


def _product(unit: Unit) -> str:
    """The product of base units as a symbol."""
    over = [f"{s}{n if n > 1 else ''}" for s, n in unit.base().items() if n > 0]
    under = [f"{s}{-n if n < -1 else ''}" for s, n in unit.base().items() if n < 0]
    divisor = f"({'.'.join(under)})" if len(under) > 1 else "".join(under)
    return (".".join(over) or "1") + (f"/{divisor}" if divisor else "")


def _quotient(text: str, inner: Mapping[str, Unit]) -> Unit | None:
    """The unit of a symbol without brackets; `inner`: units of the letters that replace brackets."""
    value, exponents = 1.0, [0] * len(BASE)
    parts = [[term for term in re.split(r"[.*·⋅\s]+", part) if term] for part in text.split("/")]
    if not all(parts):
        return None
    for i, term in ((i, term) for i, terms in enumerate(parts) for term in terms):
        if term == "1":
            continue
        match = _TERM.fullmatch(term)
        unit = None if match is None else inner.get(match[1]) or _one(match[1])
        if match is None or unit is None:
            return None
        power = int(match[2] or 1) * (-1 if i else 1)
        value *= unit.factor**power  # a temperature in a product is a difference, without its zero
        exponents = [n + power * m for n, m in zip(exponents, unit.exponents, strict=True)]
    return Unit(value, tuple(exponents))


def _one(symbol: str) -> Unit | None:
    """The unit of a single symbol, with or without a prefix."""
    if symbol in _PLAIN:
        return _PLAIN[symbol]
    if symbol in _PREFIXED:
        return _PREFIXED[symbol]
    for prefix, size in _PREFIXES.items():
        unit = _PREFIXED.get(symbol.removeprefix(prefix)) if symbol.startswith(prefix) else None
        if unit is not None:
            return Unit(unit.factor * size, unit.exponents)
    return None
