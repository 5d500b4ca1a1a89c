"""Workers for the cases of a study: this process, processes of this computer, or a Dask cluster."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import parent_process
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import Any, Protocol

from ropeway.components.errors import InputError, WorkerError
from ropeway.systems.interrupts import next_of, stop_if_interrupted


class DaskClient(Protocol):
    """The part of a `dask.distributed.Client` that is used."""

    def get_executor(self, **settings: Any) -> Executor:
        """The cluster as an executor."""


Workers = int | DaskClient | None
"""A number of local processes, 1: this process alone; None: one for each core; or a Dask client."""

WorkerPool = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[tuple[int, Any]]]
"""Calls a function for each task; yields the number of a task and its result, in the order in which they are done."""


@contextmanager
def worker_pool(workers: Workers) -> Iterator[WorkerPool]:
    """Workers for the time of a `with` block; tasks that have not begun at its end are dropped.

    Raises InputError, WorkerError when a worker is lost, and Interrupted.
    """
    known = workers is None or hasattr(workers, "get_executor")
    if not known and not (isinstance(workers, int) and workers >= 1):
        raise InputError(f"workers is {workers!r}", "Give the number of processes, or a Dask client")
    count = (os.cpu_count() or 1) if workers is None else workers
    if count == 1:
        yield _here
    elif isinstance(count, int):
        with _processes(count) as executor:
            yield lambda function, tasks: _map(executor, _sendable(function), tasks)
    else:
        executor = count.get_executor(pure=False)
        try:
            yield lambda function, tasks: _map(executor, function, tasks)
        finally:
            executor.shutdown(wait=False)


def _here(function: Callable[[Any], Any], tasks: Iterable[Any]) -> Iterator[tuple[int, Any]]:
    for i, task in enumerate(tasks):
        stop_if_interrupted()
        yield i, function(task)


def _map(executor: Executor, function: Callable[[Any], Any], tasks: Iterable[Any]) -> Iterator[tuple[int, Any]]:
    """The number and result of each task, in the order in which they are done. Raises WorkerError, Interrupted."""
    done: SimpleQueue[Future[Any]] = SimpleQueue()
    number: dict[Future[Any], int] = {}
    try:
        for i, task in enumerate(tasks):
            number[executor.submit(function, task)] = i
        for future in number:
            future.add_done_callback(done.put)
        for _ in range(len(number)):
            future = next_of(done)
            yield number[future], future.result()
    except BrokenExecutor as error:
        raise WorkerError(
            "A worker process has died",
            "Call it under `if __name__ == '__main__':`, define functions in a module that a new process can "
            "import, use fewer workers if memory is short, or workers=1",
        ) from error
    except Exception as error:  # any failure of a cluster; errors of a study are results
        raise WorkerError(
            f"A worker was lost: {type(error).__name__}: {error}",
            "Look at the workers' own messages; give them more memory, or use fewer of them",
        ) from error
    finally:
        for future in number:
            future.cancel()


class _Processes(SpawnContext):
    """Starts processes, and keeps them in `started`."""

    def __init__(self) -> None:
        super().__init__()
        self.started: list[SpawnProcess] = []

    def Process(self, *args: Any, **settings: Any) -> SpawnProcess:  # type: ignore[override]  # noqa: N802
        """As the executor calls it."""
        self.started.append(SpawnProcess(*args, **settings))
        return self.started[-1]


@contextmanager
def _processes(count: int) -> Iterator[Executor]:
    """Local processes. They end at once after an error, after Ctrl-C, or with this process."""
    context = _Processes()
    executor = ProcessPoolExecutor(count, context, _begin)
    try:
        yield executor
    except BaseException:
        for process in context.started:
            if process.is_alive():
                process.terminate()
        raise
    finally:
        executor.shutdown(cancel_futures=True)


def _begin() -> None:
    """Initialises a worker process. Ctrl-C reaches all processes of a terminal: the parent ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def end_with_parent() -> None:
        parent = parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    Thread(target=end_with_parent, daemon=True).start()


def _sendable(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """The function. Raises InputError where another process cannot import it."""
    try:
        sent = pickle.dumps(function)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise InputError(
            f"This study cannot be sent to a worker process: {error}",
            "Define its function at the top of a module, or use workers=1",
        ) from error
    script = getattr(sys.modules["__main__"], "__file__", None)
    if b"__main__" in sent and (script is None or not Path(script).is_file()):
        raise InputError(
            "This study cannot be sent to a worker process: it is defined in a notebook or at a prompt",
            "Use workers=1, or move the function to a module and import it",
        )
    return function
