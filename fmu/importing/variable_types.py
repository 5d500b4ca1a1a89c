"""Types of FMU variables: values are checked before they reach the FMU."""

from __future__ import annotations

import numbers
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import SupportsFloat, TypeAlias, TypeGuard

from ropeway.fmu.errors import FmuVariableError

Value = float | int | bool | str | bytes
Mapped: TypeAlias = bool | int | str
"""A value in a table of values: a Boolean, an integer, or an item of an enumeration by its number or name."""

_BOUNDS = {
    f"{sign}Int{n}": (0, 2**n - 1) if sign else (-(2 ** (n - 1)), 2 ** (n - 1) - 1)
    for sign in ("", "U")
    for n in (8, 16, 32, 64)
}
_BOUNDS["Integer"] = _BOUNDS["Int32"]
_KINDS = {"Float32": "Real", "Float64": "Real", **dict.fromkeys(_BOUNDS, "Integer")}
_DTYPES = {"Real": "float64", "Boolean": "bool", "Integer": "int64", "Enumeration": "int64", "UInt64": "uint64"}


@dataclass(frozen=True, slots=True)
class Entry:
    """A scalar variable of an FMU, or an element of an array: the one at `place` of `size`.

    `kind`: Real, Integer, Boolean, Enumeration, String, Binary or Clock; `type`: that of the FMI version, such as
    Int16; `items`: names and values of an enumeration; `clocked`: it has a value only while one of its clocks ticks.
    """

    kind: str
    type: str
    causality: str
    variability: str
    reference: int
    place: int = 0
    size: int = 1
    items: Mapping[str, int] = field(default_factory=dict)
    clocked: bool = False

    @property
    def continuous(self) -> bool:
        """Whether it may change between events: a real variable that is neither discrete nor a parameter."""
        return self.kind == "Real" and self.variability == "continuous"

    @property
    def dtype(self) -> str:
        """NumPy type of a column of its values."""
        return _DTYPES.get(self.type) or _DTYPES.get(self.kind, "object")


def kind_of(fmi_type: str) -> str:
    """The kind of an FMI type: Float32 is Real, UInt8 is Integer."""
    return _KINDS.get(fmi_type, fmi_type)


def taken_by(entry: Entry, name: str, file: str, value: object) -> Value:
    """A value converted to the type of a variable. Raises FmuVariableError."""
    converted, remedy = _TAKE[entry.kind](entry, value)
    if converted is None:
        raise FmuVariableError(f"{name!r} of {file} is {_named(entry)}: it cannot be {value!r}", remedy, name)
    return converted


def from_text(entry: Entry, text: str) -> object:
    """A text as the value of a variable; an invalid text is returned for `taken_by` to reject."""
    if entry.kind == "String":
        return text
    try:
        if entry.kind == "Binary":
            return bytes.fromhex(text)
        return int(text) if entry.kind == "Integer" else float(text)
    except ValueError:
        return text


def _named(entry: Entry) -> str:
    article = "an" if entry.type[0] in "EI" else "a"
    return f"{article} {entry.type}"


def _is_number(value: object) -> TypeGuard[SupportsFloat]:
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def _real(entry: Entry, value: object) -> tuple[Value | None, str]:
    return float(value) if _is_number(value) else None, "Give a number"


def _boolean(entry: Entry, value: object) -> tuple[Value | None, str]:
    if isinstance(value, numbers.Real) and value in (0, 1):
        return bool(value), ""
    return _WORDS.get(str(value).lower()), "Give 0 or 1, or True or False"


_WORDS = {"true": True, "false": False}


def _whole(entry: Entry, value: object) -> int | None:
    if not _is_number(value):
        return None
    if isinstance(value, numbers.Integral):
        return int(value)
    return int(float(value)) if float(value).is_integer() else None


def _integer(entry: Entry, value: object) -> tuple[Value | None, str]:
    low, high = _BOUNDS[entry.type]
    whole = _whole(entry, value)
    return whole if whole is not None and low <= whole <= high else None, f"Give a whole number from {low} to {high}"


def _enumeration(entry: Entry, value: object) -> tuple[Value | None, str]:
    whole = entry.items.get(value) if isinstance(value, str) else _whole(entry, value)
    known = not entry.items or whole in entry.items.values()
    choices = ", ".join(f"{number} ({name})" for name, number in entry.items.items())
    return whole if known else None, f"Give one of {choices}" if choices else "Give a whole number"


def _text(entry: Entry, value: object) -> tuple[Value | None, str]:
    return value if isinstance(value, str) else None, "Give a text"


def _binary(entry: Entry, value: object) -> tuple[Value | None, str]:
    return bytes(value) if isinstance(value, bytes | bytearray) else None, "Give bytes"


def _clock(entry: Entry, value: object) -> tuple[Value | None, str]:
    return None, "Clocks tick by themselves: omit its value"


_TAKE = {
    "Real": _real,
    "Boolean": _boolean,
    "Integer": _integer,
    "Enumeration": _enumeration,
    "String": _text,
    "Binary": _binary,
    "Clock": _clock,
}


def fits(source: Entry, target: Entry) -> bool:
    """Whether an output can drive an input.

    Both are of one kind, or a Boolean or integer drives a number; every item of one enumeration must be an item of the
    other.
    """
    if source.kind == target.kind == "Enumeration":
        return not target.items or set(source.items.values()) <= set(target.items.values())
    wider = {"Boolean": ("Integer", "Real"), "Integer": ("Real",), "Enumeration": ("Integer",)}
    return source.kind == target.kind or target.kind in wider.get(source.kind, ())
