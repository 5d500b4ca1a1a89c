"""Supports of a line from a table: name, x, y, z, kind."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import TypeVar

import pandas as pd

from ropeway.components.drive import HydraulicDrive
from ropeway.components.errors import InputError
from ropeway.components.response import ProportionalResponse, ThresholdResponse

_Part = TypeVar("_Part", bound=HydraulicDrive | ThresholdResponse | ProportionalResponse)

KINDS = ("anchor", "drum", "idler", "control", "return")
"""Kinds of support of a mono-cable line. A return is the wheel at which the rope turns back."""

_COLUMNS = ("name", "x", "y", "z", "kind")


def read_supports(source: str | Path | pd.DataFrame, *, endless: bool = False) -> pd.DataFrame:
    """The table of supports, checked: name, x, y, z [m], kind, in the order of the rope; an endless rope begins
    and ends at the first one, a control sheave. Columns drive.* and response.* are kept.

    Raises InputError that names file and line.
    """
    if isinstance(source, pd.DataFrame):
        table, where, first = source.reset_index(drop=True), "supports", 0
    else:
        where, first = str(source), 2
        try:
            table = pd.read_csv(source, skipinitialspace=True, comment="#")
        except FileNotFoundError as error:
            raise InputError(f"There is no file {where}", "Give the path of a CSV with name,x,y,z,kind") from error
        except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
            raise InputError(f"{where} is not a CSV table: {error}", "Its first line is name,x,y,z,kind") from error
    if missing := [c for c in _COLUMNS if c not in table.columns]:
        raise InputError(
            f"{where}, line 1: column {', '.join(missing)} is missing", f"The columns are {', '.join(_COLUMNS)}"
        )
    if len(table) < 2:
        raise InputError(f"{where} has {len(table)} supports", "A line has at least two")
    for i, row in enumerate(table.itertuples(index=False)):
        line = f"{where}, line {first + i}" if first else f"{where}, row {i}"
        for axis in "xyz":
            value = pd.to_numeric(getattr(row, axis), errors="coerce")
            if not pd.notna(value) or abs(value) == float("inf"):
                raise InputError(f"{line}: {axis} of {row.name!r} is {getattr(row, axis)!r}", "Give metres")
        if row.kind not in KINDS:
            raise InputError(f"{line}: kind of {row.name!r} is {row.kind!r}", f"Kinds are {', '.join(KINDS)}")
        end = i in (0, len(table) - 1) and not endless
        wrong = end != (row.kind in ("anchor", "drum")) or (endless and i == 0 and row.kind != "control")
        if wrong:
            remedy = "The first and the last are an anchor or a drum, those between an idler, a control or a return"
            if endless:
                remedy = "An endless rope begins at a control, the others are idlers, controls or returns"
            raise InputError(f"{line}: {row.name!r} is {row.kind} at place {i + 1} of {len(table)}", remedy)
    own = [c for c in table.columns if str(c).startswith(("drive.", "response."))]
    return table[[*_COLUMNS, *own]]


def with_own(part: _Part, row: pd.Series, prefix: str) -> _Part:
    """A drive or response with the values that the row of its support gives in columns `prefix.field`; blank
    ones leave it as it is. Raises InputError for a field that it does not have."""
    given = {
        str(column).removeprefix(f"{prefix}."): value
        for column, value in row.items()
        if str(column).startswith(f"{prefix}.") and pd.notna(value)
    }
    known = {f.name for f in fields(part)}
    if unknown := sorted(set(given) - known):
        raise InputError(
            f"Support {row['name']!r}: a {prefix} has no {unknown[0]!r}", f"It has {', '.join(sorted(known))}"
        )
    return replace(part, **given)
