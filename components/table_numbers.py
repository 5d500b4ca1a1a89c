"""Numbers as people write them in tables: with a decimal point or comma, and with thousands set apart."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

from ropeway.components.errors import InputError

Cell = str | float | int | bool | object
"""What a cell of a table holds: text, or a number from an Excel file or a DataFrame."""

Reading = tuple[float | None, float | None]
"""A cell's number with a decimal point, and with a decimal comma; None where it is none."""

_SPACES = re.compile(r"\s")
_SIMPLE = re.compile(r"[-+]?[0-9]+(?:([.,])(?:[0-9]{1,2}|[0-9]{4,}))?")
_PATTERNS = {
    mark: re.compile(
        rf"(?P<sign>[-+]?)(?:(?P<plain>(?:[0-9]+{m}?[0-9]*|{m}[0-9]+)(?:[eE][-+]?[0-9]{{1,3}})?)|"
        rf"(?P<groups>[1-9][0-9]{{0,2}}(?P<by>[{g}'\u2019 ])[0-9]{{3}}(?:(?P=by)[0-9]{{3}})*(?:{m}[0-9]*)?))"
    )
    for mark, m, g in ((".", r"\.", ","), (",", ",", r"\."))
}
"""By decimal mark: a plain number, or one whose thousands are set apart in threes."""
WHOLE = re.compile(r"[-+]?[0-9]{1,15}")
"""A whole number without anything else."""
_NOT_FINITE = {"nan": math.nan, "inf": math.inf, "+inf": math.inf, "-inf": -math.inf}


class NumberError(InputError):
    """A cell that is no number; `index`: which of the cells."""

    def __init__(self, cause: str, remedy: str, index: int = 0) -> None:
        self.index = index
        super().__init__(cause, remedy)


def text(cell: Cell) -> str:
    """A cell as text: whole numbers without a decimal point."""
    if isinstance(cell, float) and cell.is_integer():
        return str(int(cell))
    return str(cell).strip()


def is_number(cell: Cell) -> bool:
    """Whether a cell can be read as a number in some way."""
    return cell != "" and _readings(cell) != (None, None)


def numbers(cells: Sequence[Cell], may_be_blank: Sequence[bool], *, points: bool) -> np.ndarray:
    """The numbers in cells that share one decimal mark: the one with which all of them can be read.

    Parameters
    ----------
    cells : sequence of str or number
    may_be_blank : sequence of bool
        Whether a cell may be blank; it is NaN then.
    points : bool
        Whether a number that can be read in two ways, such as 1.234, has a decimal point.

    Raises
    ------
    NumberError
        With the index of a cell that is no finite number, or where the mark cannot be known.
    """
    only: dict[str, int] = {}
    readings = [_readings(cell) for cell in cells]
    for i, (point, comma) in enumerate(readings):
        if point is None and comma is None:
            raise NumberError(f"{cells[i]!r} is not a number", "Give a number, without its unit", i)
        if point is None or comma is None:
            only.setdefault("," if point is None else ".", i)
    if len(only) == 2:
        first, last = sorted(only.values())
        cause = f"{cells[last]!r} and {cells[first]!r} have different decimal marks"
        raise NumberError(cause, "Use one decimal mark in a file", last)
    if not only:
        _require_clear(cells, readings, points)
    values = np.array([pair[1 if "," in only else 0] for pair in readings], dtype=float)
    for i in np.flatnonzero(~np.isfinite(values)).tolist():
        if cells[i] != "":
            raise NumberError(f"{cells[i]!r} is not a finite number", "Give a number", i)
        if not may_be_blank[i]:
            raise NumberError("the cell is blank", "Give a number", i)
    return values


def _require_clear(cells: Sequence[Cell], readings: Sequence[Reading], points: bool) -> None:
    """Raises NumberError for a cell that is one number with a decimal point, and another with a comma."""
    for i, (one, other) in enumerate(readings):
        if one != other and math.isfinite(one or 0.0) and not (points and "," not in str(cells[i])):
            raise NumberError(
                f"{cells[i]!r} is {one:g} with a decimal point and {other:g} with a decimal comma",
                f"Write {max(one or 0.0, other or 0.0, key=abs):.0f} without setting thousands apart, "
                f"or {str(cells[i]).strip()}0 for a decimal",
                i,
            )


def _readings(cell: Cell) -> Reading:
    """The two readings of a cell."""
    if cell == "":
        return math.nan, math.nan
    if not isinstance(cell, str):
        value = _value(cell)
        return value, value
    simple = _SIMPLE.fullmatch(cell)  # most cells: no thousands, and no three decimals that could be some
    if simple is not None:
        value = float(cell.replace(",", "."))
        return (None if simple[1] == "," else value), (None if simple[1] == "." else value)
    word = _SPACES.sub(" ", cell.strip()).replace("\u2212", "-")
    return _written(word, "."), _written(word, ",")


def _value(cell: Cell) -> float | None:
    """The number that an Excel file or a DataFrame holds; a truth value is none."""
    if isinstance(cell, bool | np.bool_):
        return None
    try:
        return float(cell)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None


def _written(word: str, mark: str) -> float | None:
    """The number of a word with a decimal mark."""
    if word.lower() in _NOT_FINITE:
        return _NOT_FINITE[word.lower()]
    match = _PATTERNS[mark].fullmatch(word)
    if match is None:
        return None
    digits = match["plain"] or match["groups"].replace(match["by"], "")
    return float(match["sign"] + digits.replace(mark, "."))
