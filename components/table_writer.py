"""Tables written for others: CSV, Excel and Parquet, with units in one header row and without numerical noise."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.notebook_table import html_of
from ropeway.components.whole_files import whole

NOISE = 1e-12
"""Values below this part of the largest one in their column are rounding errors of a zero."""

_EXCEL_ROWS, _EXCEL_COLUMNS = 1_048_576, 16_384
_INDEX_UNITS = {"time": "s", "station": "m"}


@runtime_checkable
class HasFrame(Protocol):
    """A result or a study with its numbers in a `frame`."""

    @property
    def frame(self) -> pd.DataFrame:
        """The numbers; their units are in its `attrs["units"]`."""
        ...


def plain(frame: pd.DataFrame, *, units: bool = True) -> pd.DataFrame:
    """A frame as a flat table: named indices as columns, one header row, with units in brackets, no noise."""
    known = dict(frame.attrs.get("units", {}))
    table = frame.copy()
    table.attrs = {}
    if any(name is not None for name in table.index.names):
        table.index = table.index.set_names([name or f"level {i}" for i, name in enumerate(table.index.names, 1)])
        table = table.reset_index(allow_duplicates=True)
        known = {**{n: u for n, u in _INDEX_UNITS.items() if n in frame.index.names}, **known}
    table.columns = [_header(column, known if units else {}) for column in table.columns]
    for i, dtype in enumerate(table.dtypes):
        if dtype.kind == "f":
            values = table.iloc[:, i].to_numpy(copy=True)
            largest = np.abs(values[np.isfinite(values)]).max(initial=0.0)
            values[np.abs(values) < max(NOISE * largest, 1e-300)] = 0.0
            table.isetitem(i, values + 0.0)  # no -0.0
    return table


def _header(column: Any, units: dict[Any, str]) -> str:
    name = ": ".join(str(part) for part in column if part != "") if isinstance(column, tuple) else str(column)
    unit = units.get(column, "")
    return f"{name} [{unit}]" if unit not in ("", "1") else name


@checked
def write_table(table: pd.DataFrame | HasFrame, path: str | Path) -> Path:
    """Write a table, or the `frame` of a result or study, for other programs.

    Parameters
    ----------
    table : DataFrame, or an object with a `frame`
        Units are taken from its `attrs["units"]`.
    path : str or Path
        What it ends with says the format: .csv, .xlsx (extra `excel`) or .parquet (extra `parquet`). CSV and Excel have
        one header row with the units in brackets; Parquet keeps plain names, the units in its metadata.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        An unknown format, a table too large for Excel, a package that is not installed.
    WriteError
        The file could not be written.

    Examples
    --------
    >>> import tempfile
    >>> print(rw.write_table(rw.ropes().iloc[:1, :2], f"{tempfile.mkdtemp()}/rw.ropes.csv").read_text())
    name,diameter [m],mass_per_length [kg/m]
    compacted skyline 20,0.02,1.98
    <BLANKLINE>
    """
    frame = table.frame if isinstance(table, HasFrame) else table
    suffix = Path(path).suffix.lower()
    if suffix not in (".csv", ".xlsx", ".parquet"):
        raise InputError(f"{path} has no known format", "Let it end with .csv, .xlsx or .parquet")
    with whole(path) as file:
        if suffix == ".csv":
            plain(frame).to_csv(file, index=_has_labels(frame), lineterminator="\n")
        elif suffix == ".xlsx":
            _require_sheet(frame)
            _write_excel(plain(frame), file, _has_labels(frame))
        else:
            _write_parquet(frame, file)
    return Path(path)


def _has_labels(frame: pd.DataFrame) -> bool:
    """Whether rows have labels without a name for them."""
    return frame.index.names == [None] and frame.index.dtype.kind not in "iu"


def _require_sheet(table: pd.DataFrame) -> None:
    """Raises InputError for a table that is too large for an Excel sheet."""
    rows, columns = table.shape
    if rows >= _EXCEL_ROWS or columns >= _EXCEL_COLUMNS:
        raise InputError(f"{rows} rows and {columns} columns do not fit on an Excel sheet", "Write CSV or Parquet")


def _write_excel(table: pd.DataFrame, file: Path, labels: bool) -> None:
    try:
        import openpyxl
        from openpyxl.cell import WriteOnlyCell
        from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE
        from openpyxl.utils import get_column_letter
    except ImportError as error:
        raise InputError("Writing Excel files needs openpyxl", "pip install ropeway[excel]") from error
    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet("table")
    sheet.freeze_panes = "A2"
    header = [*([""] if labels else []), *table.columns]
    for i, name in enumerate(header, 1):
        sheet.column_dimensions[get_column_letter(i)].width = min(max(len(name) + 2, 11), 40)

    def cell(value: Any) -> Any:
        found = _cell(value)
        if not isinstance(found, str):
            return found
        text = WriteOnlyCell(sheet, ILLEGAL_CHARACTERS_RE.sub("", found))
        text.data_type = "s"  # also of a name such as =1+1, which would be a formula
        return text

    sheet.append([cell(name) for name in header])
    for label, row in zip(table.index, table.itertuples(index=False, name=None), strict=True):
        sheet.append([*([cell(str(label))] if labels else []), *map(cell, row)])
    book.save(file)


def _cell(value: Any) -> Any:
    """What a cell of Excel can hold: it has no NaN and no infinity."""
    if isinstance(value, float):
        return value if np.isfinite(value) else None if np.isnan(value) else str(value)
    if isinstance(value, np.generic):
        return _cell(value.item())
    return value if value is None or isinstance(value, (str, int)) else str(value)


def _write_parquet(frame: pd.DataFrame, file: Path) -> None:
    try:
        import pyarrow  # noqa: F401
    except ImportError as error:
        raise InputError("Writing Parquet needs pyarrow", "pip install ropeway[parquet]") from error
    frame.to_parquet(file)


class Tabular:
    """A result or study whose `frame` can be written, and shown in a notebook."""

    def _repr_html_(self) -> str:
        """Its name and the beginning of its frame, for notebooks."""
        frame: Any = getattr(self, "frame")  # noqa: B009 each subclass has one
        return html_of(repr(self), plain(frame))

    def to_csv(self, path: str | Path) -> Path:
        """Write the frame, units in its header; returns the path. Raises WriteError."""
        return _written(self, path, ".csv")

    def to_excel(self, path: str | Path) -> Path:
        """Write the frame, units in its header (extra `excel`); returns the path. Raises InputError, WriteError."""
        return _written(self, path, ".xlsx")

    def to_parquet(self, path: str | Path) -> Path:
        """Write the frame with its units (extra `parquet`); returns the path. Raises InputError, WriteError."""
        return _written(self, path, ".parquet")


def _written(of: Any, path: str | Path, suffix: str) -> Path:
    if Path(path).suffix.lower() != suffix:
        raise InputError(f"{path} does not end with {suffix}", "Name it so, or use rw.write_table")
    return write_table(of, path)
