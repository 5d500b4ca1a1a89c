"""Tables of numbers and names from text files, Excel files and DataFrames."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pandas as pd

from ropeway.components import table_numbers, units
from ropeway.components.errors import InputError
from ropeway.components.table_file import RawTable, name_and_unit, read_file
from ropeway.components.table_numbers import Cell

Source: TypeAlias = str | Path | pd.DataFrame
"""Source of a table."""


HEADER = -1
"""Row number of the header in errors."""


@dataclass(frozen=True)
class TableLayout:
    """Required columns of a table.

    `columns`: their names, with the unit of numeric columns ("" for any) and None for text; `example`: the first lines,
    for error messages; `differences`: columns whose values are differences, without the zero of a temperature scale.
    """

    columns: Mapping[str, str | None]
    example: str
    differences: frozenset[str] = frozenset()

    def missing(self, names: Iterable[str]) -> list[str]:
        """Columns that are not among the names."""
        return [column for column in self.columns if column not in names]


@dataclass(frozen=True)
class Table:
    """A table with unique column names and rows as long as its header.

    `source`: its name in errors; `columns`: as written; `keys`: as named in the layout; `units`: from the header ("" if
    absent); `rows`: the cells; `lines`: the location of each row; `first`: that of the header ("" in a DataFrame);
    `layout`: the one that it follows; `separator`: of a text file.
    """

    source: str
    columns: tuple[str, ...]
    keys: tuple[str, ...]
    units: tuple[str, ...]
    rows: Sequence[Sequence[Cell]]
    lines: Sequence[str]
    first: str
    layout: TableLayout
    separator: str

    def __len__(self) -> int:
        return len(self.rows)

    def error(self, cause: str, remedy: str, row: int | None = None, key: str | None = None) -> InputError:
        """An error with the location of a row, or of the `HEADER`, and an example of the format."""
        line = "" if row is None else self.first if row == HEADER else self.lines[row]
        place = f"{self.source}, {line}" if line else self.source
        if key is not None:
            place += f", column {self.columns[self.keys.index(key)]}"
        return InputError(f"{place}: {cause}", _with_example(remedy, self.layout))

    def texts(self, key: str) -> list[str]:
        """Cells of a column as text, "" if blank."""
        column = self.keys.index(key)
        return [table_numbers.text(row[column]) for row in self.rows]

    def numbers(self, *keys: str, optional: Sequence[str] = ()) -> np.ndarray:
        """Numbers of columns, in the units of the layout, else in SI units.

        Parameters
        ----------
        keys : str
            All numeric columns, as they share one decimal mark.
        optional : sequence of str
            Further columns, whose cells may be blank (NaN).

        Returns
        -------
        ndarray, shape (rows, columns)

        Raises
        ------
        InputError
            A cell is not a finite number, or is ambiguous; the message has line and column.
        """
        names = [*keys, *optional]
        at = [self.keys.index(name) for name in names]
        cells = [row[column] for row in self.rows for column in at]
        may_be_blank = [i >= len(keys) for i in range(len(names))] * len(self.rows)
        try:
            values = table_numbers.numbers(cells, may_be_blank, points=self.separator == ",")
        except table_numbers.NumberError as error:
            row, column = divmod(error.index, len(names))
            raise self.error(error.cause, error.remedy, row, names[column]) from error
        found = values.reshape(len(self.rows), len(names))
        for i, name in enumerate(names):
            found[:, i] = self._converted(found[:, i], name)
        return found

    def require_increase(self, values: np.ndarray, key: str, unit: str) -> None:
        """Raises InputError if values, one a row, do not increase."""
        falls = np.flatnonzero(np.diff(values) <= 0.0)
        if len(falls):
            k = int(falls[0]) + 1
            cause = f"{values[k]:g} {unit} after {values[k - 1]:g} {unit}"
            raise self.error(f"{key} does not increase: {cause}", "Sort the rows, and give each value once", k)

    def _converted(self, values: np.ndarray, key: str) -> np.ndarray:
        """Values of a column in the unit of the layout, else in SI units."""
        given, wanted = self.units[self.keys.index(key)], self.layout.columns.get(key) or ""
        difference = key in self.layout.differences
        try:
            factor, offset = units.conversion(
                given, wanted or units.to_si(given)[0], differences=(difference, difference)
            )
        except InputError as error:
            raise self.error(error.cause, error.remedy, HEADER, key) from error
        return values if (factor, offset) == (1.0, 0.0) else factor * values + offset


def read(source: Source, *layouts: TableLayout) -> Table:
    """A table from a file or a DataFrame.

    Parameters
    ----------
    source : str, Path or DataFrame
        A text file (separated by commas, semicolons, tabs or bars; UTF-8, UTF-16 or Windows-1252; lines that begin
        with # are comments), an Excel file (.xlsx, needs the extra `excel`), or a DataFrame.
    layouts : TableLayout
        Required columns; those of one layout suffice. Other columns are ignored.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        The table is invalid; the message has file, line and an example.
    """
    if isinstance(source, pd.DataFrame):
        raw = RawTable("the DataFrame", *_of_frame(source))
    elif isinstance(source, str | Path):
        try:
            raw = read_file(Path(source), [list(layout.columns) for layout in layouts])
        except InputError as error:
            raise InputError(error.cause, _with_example(error.remedy, layouts[0])) from error
    else:
        raise InputError(f"The table is a {type(source).__name__}", "Give the path of a file, or a DataFrame")
    return _checked(raw, layouts)


def _checked(raw: RawTable, layouts: Sequence[TableLayout]) -> Table:
    """A table that matches its header and one of the layouts. Raises InputError."""
    wanted = {column.casefold(): column for layout in layouts for column in layout.columns}
    keys, given = list(raw.header), [""] * len(raw.header)
    for i, column in enumerate(raw.header):  # other columns keep their case
        name, unit = name_and_unit(column)
        if name.casefold() in wanted:
            keys[i], given[i] = wanted[name.casefold()], unit
        elif name.casefold().startswith(("drive.", "response.")):
            keys[i] = column.casefold()
    layout = min(layouts, key=lambda layout: len(layout.missing(keys)))
    columns = tuple(raw.header)
    table = Table(raw.source, columns, tuple(keys), tuple(given), raw.rows, raw.lines, raw.first, layout, raw.separator)
    for i, column in enumerate(raw.header):
        if not column:
            raise table.error(f"column {i + 1} has no name", "Name the column, or remove its separator", HEADER)
        if keys.index(keys[i]) != i:
            raise table.error(f"two columns are named {column!r}", "Remove one, or rename it", HEADER)
    if missing := layout.missing(keys):
        raise table.error(f"no column {', '.join(missing)}", _hint(missing[0], raw), HEADER)
    for i, row in enumerate(raw.rows):
        if len(row) != len(columns):
            raise table.error(f"{len(row)} values in a table of {len(columns)} columns", _length_hint(row, raw), row=i)
    if not raw.rows:
        raise table.error("it has no rows below its header", "Add them")
    return table


def _hint(missing: str, raw: RawTable) -> str:
    """Remedy for a header."""
    if raw.header and all(table_numbers.is_number(name) for name in raw.header):
        return "Its first line holds numbers: name the columns there"
    near = difflib.get_close_matches(missing, [name.casefold() for name in raw.header], n=1, cutoff=0.7)
    return f"Is it the column {near[0]!r}?" if near else "Name the columns in its first line"


def _length_hint(row: Sequence[Cell], raw: RawTable) -> str:
    """Remedy for a row of a different length than the header."""
    if len(row) > len(raw.header) and raw.separator == ",":
        return "With decimal commas, separate the columns by semicolons"
    return "Give each row a value, or a blank, for each column"


def _with_example(remedy: str, layout: TableLayout) -> str:
    end = "" if remedy.endswith("?") else "."
    return f"{remedy}{end} An example: {' / '.join(layout.example.splitlines())}"


def _of_frame(frame: pd.DataFrame) -> tuple[list[str], list[list[Cell]], list[str], str, str]:
    """Header, rows, row locations, location of the header, separator of a DataFrame."""
    cells = frame.astype(object).where(frame.notna(), "")
    header = [str(name).strip() for name in frame.columns]
    return header, cells.to_numpy().tolist(), [f"row {i}" for i in range(len(frame))], "", ""
