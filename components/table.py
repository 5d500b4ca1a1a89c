"""Columns of numbers from a CSV file."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from io import StringIO
from pathlib import Path

from ropeway.components.errors import InputError


def numbers(path: str | Path, columns: Sequence[str]) -> Iterator[tuple[int, list[float]]]:
    """Line and values of each row of a CSV file in UTF-8, in the order of `columns`; others are left alone.

    Raises InputError that names file and line.
    """
    wanted = " and ".join(columns)
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (FileNotFoundError, IsADirectoryError) as error:
        raise InputError(f"There is no file {path}", f"Give the path of a CSV with the columns {wanted}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no text in UTF-8: {error.reason}", "Save it as CSV UTF-8") from error
    table = csv.DictReader(StringIO(text), skipinitialspace=True)
    if missing := [name for name in columns if name not in (table.fieldnames or ())]:
        raise InputError(f"{path}, line 1: no column {', '.join(missing)}", f"It needs the columns {wanted}")
    for row in table:
        try:
            yield table.line_num, [float(row[name]) for name in columns]
        except (TypeError, ValueError) as error:
            given = ", ".join(f"{name} {row[name]!r}" for name in columns)
            raise InputError(f"{path}, line {table.line_num}: {given}", "Give numbers") from error
