"""Checks of what a user gives a component: finite, positive, a legal name, a point."""

from __future__ import annotations

import math
import numbers
import re
from collections.abc import Sequence

from ropeway.components.errors import InputError

Point = tuple[float, float, float]

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def name(value: str, what: str) -> None:
    """A component's name is an identifier, so that `name.variable` is a legal structured name."""
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise InputError(f"{what} name {value!r} is not an identifier", "Use letters, digits and underscores only")


def number(value: object, owner: str, field: str, unit: str = "") -> None:
    """A finite number."""
    if not isinstance(value, numbers.Real) or not math.isfinite(float(value)):
        raise InputError(f"{owner}: {field} is {value!r}", f"Give a finite number{f' [{unit}]' if unit else ''}")


def positive(value: float, owner: str, field: str, unit: str = "", *, infinite: bool = False) -> None:
    """A number above zero; `inf` only where it is allowed."""
    if infinite and value == math.inf:
        return
    number(value, owner, field, unit)
    if value <= 0.0:
        raise InputError(f"{owner}: {field} is {value!r} {unit}".rstrip(), "It must be above zero")


def not_negative(value: float, owner: str, field: str, unit: str = "") -> None:
    """A number of zero or more."""
    number(value, owner, field, unit)
    if value < 0.0:
        raise InputError(f"{owner}: {field} is {value!r} {unit}".rstrip(), "It must not be negative")


def point(value: Sequence[float], owner: str) -> Point:
    """(x, z) or (x, y, z) [m] as (x, y, z)."""
    values = tuple(value)
    if len(values) not in (2, 3):
        raise InputError(f"{owner}: at has {len(values)} coordinates", "Give (x, z) or (x, y, z) in metres")
    for v in values:
        number(v, owner, "a coordinate of at", "m")
    x, *rest = (float(v) for v in values)
    return (x, rest[0], rest[1]) if len(rest) == 2 else (x, 0.0, rest[0])
