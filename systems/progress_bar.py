"""Progress bars of long calls, on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import parent_process
from threading import Lock

_SHOWN = Lock()
"""Lock of the visible bar: only one is shown at a time."""


@contextmanager
def bar(label: str, total: float, show: bool | None = None) -> Iterator[Callable[[float], None]]:
    """Yields a function that takes the completed part of `total`.

    By default a bar is shown on a terminal only, and not within a longer call that has one, or in its worker processes.
    """
    wanted = sys.stderr.isatty() and parent_process() is None if show is None else show
    if not wanted or not _SHOWN.acquire(blocking=False):
        yield lambda done: None
        return
    from rich.console import Console
    from rich.progress import Progress

    try:
        with Progress(console=Console(stderr=True), transient=True) as progress:
            task = progress.add_task(label, total=total)
            yield lambda done: progress.update(task, completed=done)
    finally:
        _SHOWN.release()
