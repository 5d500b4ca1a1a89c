"""Progress of long work, on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import parent_process
from threading import Lock

_SHOWN = Lock()
"""Held while a bar is shown: a terminal has room for one."""


@contextmanager
def bar(label: str, total: float, show: bool | None = None) -> Iterator[Callable[[float], None]]:
    """Gives a function that takes how much of `total` is done. Quiet unless `show`, or on a terminal; and as a part
    of longer work that has a bar, or in its worker processes."""
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
