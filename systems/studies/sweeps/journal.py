"""A sweep on disk: its table as Parquet when it is finished, and a journal of the rows before."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping
from contextlib import suppress
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

import pandas as pd

from ropeway.components.errors import InputError, WriteError
from ropeway.components.whole_files import whole

JournalRow = dict[str, float | str | bool | None]
"""The results of a case, by name."""


class Journal:
    """Rows of finished cases beside the table: `NAME.parquet.journal`, one line of JSON for each chunk. An incomplete
    last line, of a program that was killed, is ignored. In the `with` block the file is locked: no other sweep can
    write to it."""

    def __init__(self, path: str | Path, study: bytes, cases: pd.DataFrame) -> None:
        """study: identifies the study. Raises InputError when the files are those of another."""
        if find_spec("pyarrow") is None:
            raise InputError("Parquet files need pyarrow", 'Install it: pip install "ropeway[parquet]"')
        self.path = Path(path)
        if self.path.is_dir() or not self.path.parent.is_dir():
            raise InputError(f"{self.path} cannot be written", "Name a file in a folder that exists")
        self._lines = self.path.with_name(f"{self.path.name}.journal")
        try:
            values = json.dumps(cases.to_dict("split")).encode()
        except TypeError as error:
            raise InputError(
                f"A file keeps numbers and text: {error}", "Sweep over names, or leave path out"
            ) from error
        self._mark = sha256(study + values).hexdigest()
        self._file: IO[bytes]
        self._done = False

    def __enter__(self) -> Journal:
        try:
            self._file = self._locked()
        except BlockingIOError as error:
            raise InputError(
                f"Another sweep writes to {self.path}", "Wait until it ends, or give another path"
            ) from error
        except OSError as error:
            raise _not_written(self._lines, error) from error
        return self

    def __exit__(self, *error: object) -> None:
        done = self._done or self._file.seek(0, os.SEEK_END) == 0
        with suppress(PermissionError):  # Windows removes no open file
            if done:
                self._lines.unlink(missing_ok=True)
        self._file.close()
        if done:
            self._lines.unlink(missing_ok=True)

    def _locked(self) -> IO[bytes]:
        """The journal's file, open and locked. Raises BlockingIOError while another has it."""
        while True:
            file = self._lines.open("ab+", buffering=0)
            try:
                _lock(file)
                # The sweep that had the lock may have removed the file.
                if self._lines.exists() and os.path.samestat(os.fstat(file.fileno()), self._lines.stat()):
                    return file
            except BlockingIOError:
                file.close()
                raise
            file.close()

    def finished(self) -> pd.DataFrame | None:
        """The table, if it is finished. Raises InputError."""
        if not self.path.exists():
            return None
        try:
            table = pd.read_parquet(self.path)
        except (OSError, ValueError) as error:  # pyarrow's own errors are of these types
            raise InputError(
                f"{self.path} is damaged, or no Parquet file: {error}", "Give another path, or remove the file"
            ) from error
        if table.attrs.get("sweep") != self._mark:
            raise InputError(f"{self.path} holds another table", "Give another path, or remove the file")
        self._done = True
        return table

    def rows(self) -> dict[int, JournalRow]:
        """The rows of the journal, by the number of their case; begins one if there is none. Raises InputError."""
        self._file.seek(0)
        text = self._file.read()
        complete = text[: text.rfind(b"\n") + 1]
        if complete != text:
            self._file.truncate(len(complete))
        if not complete:
            self._write(self._mark)
            return {}
        lines = [self._read(i, line) for i, line in enumerate(complete.splitlines(), 1)]
        if lines[0] != self._mark:
            raise InputError(f"{self._lines} belongs to another sweep", "Give another path, or remove the file")
        return {case: row for chunk in lines[1:] for case, row in chunk}

    def _read(self, number: int, line: bytes) -> Any:
        """A line of the journal: the mark in the first, rows in the others. Raises InputError."""
        try:
            value = json.loads(line)
            if number == 1 and isinstance(value, str):
                return value
            if number > 1 and all(isinstance(case, int) and isinstance(row, dict) for case, row in value):
                return value
        except (ValueError, TypeError):  # no JSON, or JSON of something else
            pass
        raise InputError(
            f"Line {number} of {self._lines} is damaged",
            "Remove that line to keep the others, or remove the file to begin anew",
        )

    def add(self, rows: Mapping[int, JournalRow]) -> None:
        """Writes the rows of some cases. Raises WriteError."""
        self._write(list(rows.items()))

    def finish(self, table: pd.DataFrame) -> pd.DataFrame:
        """Writes the whole table in place of the journal; returns it as read from the file. Raises InputError,
        WriteError."""
        for name, column in table.items():
            if column.dtype == object and len({isinstance(value, str) for value in column.dropna()}) > 1:
                raise InputError(
                    f"{name} is a number in some cases and text in others", f"Return one kind, and remove {self._lines}"
                )
        table.attrs["sweep"] = self._mark
        with whole(self.path) as file:
            table.to_parquet(file)
        self._done = True
        return pd.read_parquet(self.path)

    def _write(self, value: object) -> None:
        rest = memoryview(json.dumps(value).encode() + b"\n")
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            raise _not_written(self._lines, error) from error


def _lock(file: IO[bytes]) -> None:
    """Locks a file for as long as it is open. Raises BlockingIOError where another process or thread has done so.
    The lock goes with the process, however that ends; a file system without locks has none."""
    try:
        if sys.platform == "win32":
            import msvcrt

            file.seek(2**30)  # beyond what is read
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except PermissionError as error:  # on Windows
        raise BlockingIOError(*error.args) from error
    except OSError:
        return


def _not_written(path: Path, error: OSError) -> WriteError:
    return WriteError(
        f"{path} cannot be written: {error.strerror or error}", "Choose a folder with write permission and free space"
    )
