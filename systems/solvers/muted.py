"""Calls of compiled solvers that write to the terminal whatever their options are."""

from __future__ import annotations

import io
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

_ONE_AT_A_TIME = threading.RLock()
"""Threads that exchange the same stream would restore each other's."""


class _Muted(io.TextIOBase):
    """A stream without what this thread writes."""

    def __init__(self, stream: TextIO | None) -> None:
        self._stream, self._own = stream, threading.get_ident()

    def write(self, text: str) -> int:
        if self._stream is not None and threading.get_ident() != self._own:
            return self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        if self._stream is not None:
            self._stream.flush()


@contextmanager
def muted() -> Iterator[None]:
    """Drops what this thread writes to standard error. CasADi passes on the messages of Sundials that way, also with
    `disable_internal_warnings`: a step that is tried again is no matter for the user, and one that fails for good
    raises an error."""
    with _ONE_AT_A_TIME:
        stream = sys.stderr
        sys.stderr = _Muted(stream)
        try:
            yield
        finally:
            sys.stderr = stream
