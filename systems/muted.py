"""Calls of compiled solvers that write to the terminal whatever their options are."""

from __future__ import annotations

import io
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO


class _Muted(io.TextIOBase):
    """A stream without what the thread that made it writes, until it is `over`."""

    def __init__(self, stream: TextIO | None) -> None:
        self.stream, self.over, self._own = stream, False, threading.get_ident()

    def write(self, text: str) -> int:
        if self.stream is not None and (self.over or threading.get_ident() != self._own):
            return self.stream.write(text)
        return len(text)

    def flush(self) -> None:
        if self.stream is not None:
            self.stream.flush()


@contextmanager
def muted() -> Iterator[None]:
    """Drops what this thread writes to standard error. CasADi passes on the messages of Sundials that way, also with
    `disable_internal_warnings`: a step that is tried again is no matter for the user, and one that fails for good
    raises an error."""
    own = _Muted(sys.stderr)
    sys.stderr = own
    try:
        yield
    finally:
        own.over = True
        # Another thread may have begun later: then the last one to end restores the stream.
        while isinstance(sys.stderr, _Muted) and sys.stderr.over:
            sys.stderr = sys.stderr.stream
