"""Where the parts of a large study run: in this process, in processes of this computer, or on a Dask cluster."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import Any, Protocol

from ropeway.components.errors import InputError, RopewayError


class DaskClient(Protocol):
    """What is asked of a `dask.distributed.Client`."""

    def get_executor(self, **settings: Any) -> Executor:
        """The cluster as an executor."""


Workers = int | DaskClient | None
"""A number of local processes, 1: this process alone; None: one for each core; or a Dask client."""

Crew = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[tuple[int, Any]]]
"""Calls a function for each task; gives the number of a task and what was found, as they come in."""


@contextmanager
def crew(workers: Workers) -> Iterator[Crew]:
    """Workers for as long as they are needed; what is not begun then is dropped.

    Raises InputError, and RopewayError when a process dies.
    """
    known = workers is None or hasattr(workers, "get_executor")
    if not known and not (isinstance(workers, int) and workers >= 1):
        raise InputError(f"workers is {workers!r}", "Give the number of processes, or a Dask client")
    count = (os.cpu_count() or 1) if workers is None else workers
    if count == 1:
        yield _here
        return
    executor = (
        ProcessPoolExecutor(count, get_context("spawn"), _end_with_parent)
        if isinstance(count, int)
        else count.get_executor(pure=False)
    )
    begun: list[Future[Any]] = []

    def share_out(function: Callable[[Any], Any], tasks: Iterable[Any]) -> Iterator[tuple[int, Any]]:
        if isinstance(count, int):
            _require_sendable(function)
        try:
            begun[:] = [executor.submit(function, task) for task in tasks]
            number = {future: i for i, future in enumerate(begun)}
            for future in as_completed(begun):
                yield number[future], future.result()
        except BrokenExecutor as error:
            raise RopewayError(
                "A worker process has died",
                "Call it under `if __name__ == '__main__':`, define functions in a module that a new process can "
                "import, use fewer workers if memory is short",
            ) from error

    try:
        yield share_out
    finally:
        for future in begun:
            future.cancel()
        executor.shutdown()


def _end_with_parent() -> None:
    """Processes whose parent is killed would wait for work for ever."""

    def wait() -> None:
        parent = parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    Thread(target=wait, daemon=True).start()


def _here(function: Callable[[Any], Any], tasks: Iterable[Any]) -> Iterator[tuple[int, Any]]:
    for i, task in enumerate(tasks):
        yield i, function(task)


def _require_sendable(function: Callable[[Any], Any]) -> None:
    """Raises InputError for a function that another process could not find."""
    try:
        pickle.dumps(function)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise InputError(
            f"A worker process cannot be given this study: {error}",
            "Define its function at the top of a module, or use workers=1",
        ) from error
