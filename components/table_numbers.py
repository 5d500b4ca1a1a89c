"""Numbers in tables: with a decimal point or comma, and with thousands separators."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

from ropeway.components.errors import InputError

Cell = str | float | int | bool | object
"""Content of a cell: text, or a number from an Excel file or a DataFrame."""

Reading = tuple[float | None, float | None]
"""Value of a cell read with a decimal point, and with a decimal comma; None if it is not a number."""

_SPACES = re.compile(r"\s")
_SIMPLE = re.compile(r"[-+]?[0-9]+(?:([.,])(?:[0-9]{1,2}|[0-9]{4,}))?")
_PATTERNS = {
    mark: re.compile(
        rf"(?P<sign>[-+]?)(?:(?P<plain>(?:[0-9]+{m}?[0-9]*|{m}[0-9]+)(?:[eE][-+]?[0-9]{{1,3}})?)|"
        rf"(?P<groups>[1-9][0-9]{{0,2}}(?P<by>[{g}'\u2019 ])[0-9]{{3}}(?:(?P=by)[0-9]{{3}})*(?:{m}[0-9]*)?))"
    )
    for mark, m, g in ((".", r"\.", ","), (",", ",", r"\."))
}
"""By decimal mark: a plain number, or one with thousands separators."""
WHOLE = re.compile(r"[-+]?[0-9]{1,15}")
"""An integer."""
_NOT_FINITE = {"nan": math.nan, "inf": math.inf, "+inf": math.inf, "-inf": -math.inf}


class NumberError(InputError):
    """A cell that is not a number; `index`: its position."""

    def __init__(self, cause: str, remedy: str, index: int = 0) -> None:
        self.index = index
        super().__init__(cause, remedy)


def text(cell: Cell) -> str:
    """A cell as text, integers without a decimal point."""
    if isinstance(cell, float) and cell.is_integer():
        return str(int(cell))
    return str(cell).strip()


def is_number(cell: Cell) -> bool:
    """Whether a cell can be read as a number."""
    return cell != "" and _readings(cell) != (None, None)


def numbers(cells: Sequence[Cell], may_be_blank: Sequence[bool], *, points: bool) -> np.ndarray:
    """Numbers of cells that share one decimal mark: the one with which all can be read.

    Parameters
    ----------
    cells : sequence of str or number
        The cells.
    may_be_blank : sequence of bool
        Whether a cell may be blank (NaN).
    points : bool
        Whether an ambiguous number, such as 1.234, has a decimal point.

    Raises
    ------
    NumberError
        A cell is not a finite number, or the decimal mark is ambiguous.
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
    """Raises NumberError for a cell with two different readings."""
    for i, (one, other) in enumerate(readings):
        if one != other and math.isfinite(one or 0.0) and not (points and "," not in str(cells[i])):
            raise NumberError(
                f"{cells[i]!r} is {one:g} with a decimal point and {other:g} with a decimal comma",
                f"Write {max(one or 0.0, other or 0.0, key=abs):.0f} without a thousands separator, "
                f"or {str(cells[i]).strip()}0 for a decimal",
                i,
            )


def _readings(cell: Cell) -> Reading:
    """Both readings of a cell."""
    if cell == "":
        return math.nan, math.nan
    if not isinstance(cell, str):
        value = _value(cell)
        return value, value
    simple = _SIMPLE.fullmatch(cell)  # most cells: no thousands, and not three decimals, which would be ambiguous
    if simple is not None:
        value = float(cell.replace(",", "."))
        return (None if simple[1] == "," else value), (None if simple[1] == "." else value)
    word = _SPACES.sub(" ", cell.strip()).replace("\u2212", "-")
    return _written(word, "."), _written(word, ",")


def _value(cell: Cell) -> float | None:
    """A number from an Excel file or a DataFrame; None for a Boolean."""
    if isinstance(cell, bool | np.bool_):
        return None
    try:
        return float(cell)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None


def _written(word: str, mark: str) -> float | None:
    """Value of a text with a decimal mark."""
    if word.lower() in _NOT_FINITE:
        return _NOT_FINITE[word.lower()]
    match = _PATTERNS[mark].fullmatch(word)
    if match is None:
        return None
    digits = match["plain"] or match["groups"].replace(match["by"], "")
    return float(match["sign"] + digits.replace(mark, "."))
