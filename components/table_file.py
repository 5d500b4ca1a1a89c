"""Table files: encoding, separator and comments are recognised; Excel files."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ropeway.components.errors import InputError
from ropeway.components.table_numbers import Cell, text
from ropeway.components.text_encoding import decoded

_SEPARATORS = (";", "\t", "|", ",")
_HINT = re.compile(r"\s*sep=(.)\s*", re.IGNORECASE)
_WITH_UNIT = re.compile(r"(.*?)\s*(?:\[([^\]]+)\]|\(([^()]+)\))")
_COMMENT = re.compile(r"\s*#(?!(?:N/A|NV|[A-ZÄÖÜÉ][A-ZÄÖÜÉ_/0]*[!?])\s*(?:[;,\t|]|$))")
"""Start of a comment: a # that does not begin an error of a spreadsheet, such as #N/A, #REF! or #BEZUG!."""
_OTHERS = (
    (b"\xd0\xcf\x11\xe0", "an Excel file from before 2007", "Save it as .xlsx or CSV"),
    (b"\x1f\x8b", "compressed", "Unpack it"),
    (b"%PDF", "a PDF", "Save the table as CSV"),
)
"""First bytes of files that are not text."""


@dataclass(frozen=True)
class RawTable:
    """Cells of a table as in its file.

    `lines`: location of each row; `first`: that of the header; `separator`: of a text file, else "".
    """

    source: str
    header: list[str]
    rows: list[list[Cell]]
    lines: list[str]
    first: str
    separator: str


def read_file(path: Path, layouts: Sequence[Sequence[str]]) -> RawTable:
    """The table in a file. Raises InputError.

    `layouts`: names of possible columns, which determine the separator, or the sheet of an Excel file.
    """
    data = _bytes(path)
    for mark, what, remedy in _OTHERS:
        if data.startswith(mark):
            raise InputError(f"{path} is {what}", remedy)
    if data.startswith(b"PK\x03\x04"):
        return _excel(path, data, layouts)
    return _text(str(path), decoded(path, data), layouts)


def _bytes(path: Path) -> bytes:
    """Content of a file. Raises InputError if there is none."""
    try:
        if path.is_dir():
            raise InputError(f"{path} is a folder", "Give the path of a file with a table")
        if not path.exists():
            raise InputError(f"There is no file {path}", "Check the path")
        if not (path.is_file() or path.is_fifo()):
            raise InputError(f"{path} is not a file", "Give the path of a file with a table")
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path} cannot be read: {reason}", "Check its path and its permissions") from error
    if not data.strip():
        raise InputError(f"{path} is empty", "Write a header and rows into it")
    return data


def _text(source: str, content: str, layouts: Sequence[Sequence[str]]) -> RawTable:
    """The table in a text."""
    lines = io.StringIO(content, newline=None).readlines()
    declared = None
    start = next((i for i, line in enumerate(lines) if not _skipped(line)), None)
    if start is not None and (hint := _HINT.fullmatch(lines[start])):
        declared, lines[start] = hint[1], "\n"  # Excel's separator hint
        start = next((i for i, line in enumerate(lines) if not _skipped(line)), None)
    if start is None:
        raise InputError(f"{source} has no rows", "Write a header and rows into it")
    fields = {mark: lines[start].strip("\r\n").split(mark) for mark in _SEPARATORS}
    separator = declared or max(fields, key=lambda mark: (_found(fields[mark], layouts), len(fields[mark])))
    rows: list[list[Cell]] = []
    places: list[str] = []
    reader = csv.reader(_cleaned(lines, separator), delimiter=separator, skipinitialspace=True, strict=True)
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells):
                rows.append(list(cells))
                places.append(f"line {reader.line_num}")
    except csv.Error as error:
        raise InputError(
            f"{source}, line {reader.line_num}: {error}", "Close the quotes, and double a quote inside quotes"
        ) from error
    return RawTable(source, [str(name) for name in rows[0]], rows[1:], places[1:], places[0], separator)


def _skipped(line: str) -> bool:
    """Whether a line is blank or a comment."""
    return not line.strip() or _COMMENT.match(line) is not None


def _cleaned(lines: Sequence[str], separator: str) -> Iterator[str]:
    """Lines without comments, and without blanks between a closing quote and a separator."""
    padded = re.compile(rf'"[ \xa0]+(?={re.escape(separator)}|\r?\n|$)')
    for line in lines:
        yield "\n" if _COMMENT.match(line) else padded.sub('"', line)


def name_and_unit(column: str) -> tuple[str, str]:
    """Name and unit in a header: "Elevation [ft]" and "Elevation (ft)" give Elevation and ft."""
    match = _WITH_UNIT.fullmatch(column.strip())
    return (column.strip(), "") if match is None else (match[1], match[2] or match[3])


def _found(names: Sequence[str], layouts: Sequence[Sequence[str]]) -> int:
    """Largest number of columns of a layout among the names in a header."""
    keys = {name_and_unit(name.strip().strip('"'))[0].casefold() for name in names}
    return max(sum(column.casefold() in keys for column in layout) for layout in layouts)


def _excel(path: Path, data: bytes, layouts: Sequence[Sequence[str]]) -> RawTable:
    """The table in an Excel file: the sheet with the columns, or the only sheet that is not empty."""
    try:
        import openpyxl
    except ImportError as error:
        raise InputError(
            f"{path} is an Excel file, and reading one needs openpyxl",
            "pip install ropeway[excel], or save the table as CSV",
        ) from error
    try:
        book = openpyxl.load_workbook(io.BytesIO(data), read_only=True, data_only=True)
        sheets = {sheet.title: [list(row) for row in sheet.iter_rows(values_only=True)] for sheet in book.worksheets}
    except Exception as error:
        raise InputError(f"{path} cannot be read as an Excel file: {error}", "Save it again, or as CSV") from error
    found = [t for title, rows in sheets.items() if (t := _sheet(f"{path}, sheet {title}", rows)) is not None]
    if not found:
        raise InputError(f"{path} is empty", "Write a header and rows into its first sheet")
    fitting = [t for t in found if any(_found(t.header, [columns]) == len(columns) for columns in layouts)]
    if len(found) > 1 and len(fitting) != 1:
        names = ", ".join(repr(t.source.rpartition(", sheet ")[2]) for t in fitting or found)
        raise InputError(f"{path} has several sheets that may contain the table: {names}", "Keep one sheet")
    return found[0] if len(found) == 1 else fitting[0]


def _sheet(source: str, rows: list[list[object]]) -> RawTable | None:
    """The table in the cells of a sheet; None if it is blank."""
    cells: list[list[Cell]] = [["" if value is None else _stripped(value) for value in row] for row in rows]
    filled = [i for i, row in enumerate(cells) if any(v != "" for v in row) and not _COMMENT.match(text(row[0]))]
    if not filled:
        return None
    width = max(k + 1 for i in filled for k, value in enumerate(cells[i]) if value != "")
    table = [(cells[i] + [""] * width)[:width] for i in filled]
    places = [f"row {i + 1}" for i in filled]
    return RawTable(source, [text(name) for name in table[0]], table[1:], places[1:], places[0], "")


def _stripped(value: object) -> Cell:
    return value.strip() if isinstance(value, str) else value
