"""A sweep on disk: its finished table as Parquet, and until then a journal of the rows there are."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

import pandas as pd

from ropeway.components.errors import InputError

Row = dict[str, float | str | bool | None]
"""What a case came to, by name."""


class Journal:
    """Rows written down as they come in, beside the table that they will make: `NAME.parquet.journal`, one line
    of JSON for each chunk. A line that was cut off when the program was killed does not count."""

    def __init__(self, path: str | Path, study: bytes, cases: pd.DataFrame) -> None:
        """study: what tells this study from others. Raises InputError when the files are those of another."""
        if find_spec("pyarrow") is None:
            raise InputError("Parquet files need pyarrow", 'Install it: pip install "ropeway[parquet]"')
        self.path = Path(path)
        if self.path.is_dir() or not self.path.parent.is_dir():
            raise InputError(f"{self.path} cannot be written", "Name a file in a folder that is there")
        self._lines = self.path.with_name(f"{self.path.name}.journal")
        try:
            values = json.dumps(cases.to_dict("split")).encode()
        except TypeError as error:
            raise InputError(
                f"A file keeps numbers and text: {error}", "Sweep over names, or leave path out"
            ) from error
        self._mark = sha256(study + values).hexdigest()

    def finished(self) -> pd.DataFrame | None:
        """The table, if it is there. Raises InputError."""
        if not self.path.exists():
            return None
        table = pd.read_parquet(self.path)
        if table.attrs.get("sweep") != self._mark:
            raise InputError(f"{self.path} holds another table", "Give another path, or remove the file")
        return table

    def rows(self) -> dict[int, Row]:
        """The rows there are, by the number of their case; begins a journal if there is none. Raises InputError."""
        text = self._lines.read_bytes() if self._lines.exists() else b""
        whole = text[: text.rfind(b"\n") + 1]
        if whole != text:
            os.truncate(self._lines, len(whole))
        if not whole:
            self._write(self._mark)
            return {}
        mark, *chunks = [json.loads(line) for line in whole.splitlines()]
        if mark != self._mark:
            raise InputError(f"{self._lines} belongs to another sweep", "Give another path, or remove the file")
        return {case: row for chunk in chunks for case, row in chunk}

    def add(self, rows: Mapping[int, Row]) -> None:
        """Writes the rows of some cases down."""
        self._write(list(rows.items()))

    def finish(self, table: pd.DataFrame) -> pd.DataFrame:
        """Writes the whole table in place of the journal; returns it as it can be read again."""
        for name, column in table.items():
            if column.dtype == object and len({isinstance(value, str) for value in column.dropna()}) > 1:
                raise InputError(
                    f"{name} is a number in some cases and text in others", f"Return one kind, and remove {self._lines}"
                )
        table.attrs["sweep"] = self._mark
        partial = self.path.with_name(f"{self.path.name}.partial")
        table.to_parquet(partial)
        partial.replace(self.path)
        self._lines.unlink()
        return pd.read_parquet(self.path)

    def _write(self, value: object) -> None:
        with self._lines.open("ab") as file:
            file.write(json.dumps(value).encode() + b"\n")
