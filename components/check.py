"""Checks of a component's values: finite, positive, a valid name, a point."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from ropeway.components import accepted_values
from ropeway.components.errors import InputError

Point = tuple[float, float, float]

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


class Range(NamedTuple):
    """Values that a variable may have: from `least` (or only above it) to `most`; `named`: in words."""

    least: float = -math.inf
    most: float = math.inf
    above: bool = False
    named: str = ""

    @property
    def words(self) -> str:
        """The range in words."""
        if self.named:
            return self.named
        low = "zero" if self.least == 0.0 else f"{self.least:g}"
        least = f"above {low}" if self.above else "" if self.least == -math.inf else f"of {low} or more"
        most = "" if self.most == math.inf else f"at most {self.most:g}"
        return f"a number {', '.join(filter(None, (least, most)))}".rstrip()

    def refuses(self, value: float) -> str | None:
        """The allowed range in words if a value is outside it."""
        inside = self.least <= value <= self.most and not (self.above and value == self.least)
        return None if inside else self.words


ANY, POSITIVE, NOT_NEGATIVE, SHARE = Range(), Range(0.0, above=True), Range(0.0), Range(0.0, 1.0, above=True)


class PartName(str):
    """Dotted name of a component in a subsystem; only `System.add` makes one."""

    __slots__ = ()


def name(value: str, what: str) -> None:
    """A component's name is an identifier, so that `name.variable` is a legal structured name."""
    if isinstance(value, PartName):
        return
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise InputError(f"{what} name {value!r} is not an identifier", "Use letters, digits and underscores only")


def number(value: object, owner: str, field: str, unit: str = "", within: Range = ANY) -> None:
    """A finite number within a range."""
    try:
        refusal_text = within.refuses(accepted_values.real(value))
    except accepted_values.RefusedError as refusal:
        refusal_text = refusal.expected
    if refusal_text:
        of_unit = f" [{unit}]" if unit else ""
        raise InputError(f"{owner}: {field} is {accepted_values.short(value)}", f"Give {refusal_text}{of_unit}")


def positive(value: float, owner: str, field: str, unit: str = "", *, infinite: bool = False) -> None:
    """A number above zero; `inf` only if `infinite`."""
    if not (infinite and value == math.inf):
        number(value, owner, field, unit, POSITIVE)


def not_negative(value: float, owner: str, field: str, unit: str = "") -> None:
    """A number of zero or more."""
    number(value, owner, field, unit, NOT_NEGATIVE)


def index(value: int, count: int, owner: str, field: str) -> None:
    """Number of one of `count` items, counted from 0."""
    if not 0 <= value < count:
        raise InputError(f"{owner}: {field} is {value}", f"Give 0 to {count - 1}" if count else "There is none")


MOST = 50_000_000
"""Largest number of stations, cases or records of one call."""


def count(value: float, owner: str, what: str, most: int = MOST) -> None:
    """A number of items that fits into memory."""
    if not value <= most:
        raise InputError(f"{owner} would make {value:.3g} {what}", f"The limit is {most:,}")


def share(value: float, owner: str, field: str) -> None:
    """A number above zero and at most one."""
    number(value, owner, field, "", SHARE)


def point(value: Sequence[float], owner: str) -> Point:
    """(x, z) or (x, y, z) [m] as (x, y, z)."""
    values = tuple(value)
    if len(values) not in (2, 3):
        raise InputError(f"{owner}: at has {len(values)} coordinates", "Give (x, z) or (x, y, z) in metres")
    for v in values:
        number(v, owner, "a coordinate of at", "m")
    x, *rest = (float(v) for v in values)
    return (x, rest[0], rest[1]) if len(rest) == 2 else (x, 0.0, rest[0])


def pair(value: Sequence[float], owner: str, field: str) -> tuple[float, float]:
    """Two coordinates."""
    if not hasattr(value, "__len__") or len(value) != 2:
        raise InputError(f"{owner}: {field} is {value!r}", "Give two coordinates, easting and northing")
    for v in value:
        number(v, owner, f"a coordinate of {field}")
    return float(value[0]), float(value[1])
