"""Ctrl-C in long calls: they end between two steps, with the results up to then.

CasADi checks for signals inside its functions and drops a `KeyboardInterrupt` raised there: IDAS treats it as a failed
evaluation and reduces its step. In an interruptible call the handler only records the signal, and the solvers check the
record where they can stop.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from queue import Empty, SimpleQueue
from types import FrameType
from typing import Any, ParamSpec, TypeVar

from ropeway.components.errors import Interrupted

_P = ParamSpec("_P")
_R = TypeVar("_R")

WAIT = 0.1
"""Longest wait between two checks for signals [s]."""


class _Watch:
    """Signals of the main thread during an interruptible call.

    `handler`: the previous handler; `noted`: a recorded signal, or None; `at_once`: whether a signal acts immediately.
    """

    def __init__(self) -> None:
        self.handler: Callable[[int, FrameType | None], Any] | None = None
        self.noted: tuple[int, FrameType | None] | None = None
        self.at_once = False

    def note(self, number: int, frame: FrameType | None) -> None:
        """The signal handler. A second signal acts immediately, and stays recorded, as CasADi may drop an exception."""
        if self.handler is not None and (self.at_once or self.noted is not None):
            self.handler(number, frame)
        else:
            self.noted = (number, frame)

    def act(self) -> None:
        """Calls the previous handler, where it is safe. Raises Interrupted."""
        noted, self.noted = self.noted, None
        if noted is None or self.handler is None:
            return
        try:
            self.handler(*noted)
        except KeyboardInterrupt:
            pass
        else:
            return
        raise Interrupted


_watch = _Watch()


def interrupted() -> bool:
    """Whether a Ctrl-C is recorded for the call in this thread."""
    return _watch.noted is not None and threading.current_thread() is threading.main_thread()


def stop_if_interrupted() -> None:
    """Point where an interruptible call can stop. Raises Interrupted after a Ctrl-C."""
    if _watch.noted is not None and interrupted():  # checked at every evaluation of a function
        _watch.act()


@contextmanager
def _watched() -> Iterator[None]:
    """Records Ctrl-C in the main thread, unless the signal has no Python handler."""
    before = signal.getsignal(signal.SIGINT)
    if not callable(before) or _watch.handler is not None:
        yield
        return
    _watch.handler = before
    signal.signal(signal.SIGINT, _watch.note)
    try:
        yield
    except Interrupted:
        raise
    except KeyboardInterrupt as error:
        raise Interrupted from error
    except BaseException:
        stop_if_interrupted()  # the error of the call is then the context of the interrupt
        raise
    finally:
        _watch.handler = _watch.noted = None
        signal.signal(signal.SIGINT, before)


def interruptible(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Lets Ctrl-C end a function at points where it can stop, as Interrupted, and never inside CasADi.

    A previous Python handler is called at that point; its exception ends the function.
    """

    @wraps(function)
    def watched(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        if threading.current_thread() is not threading.main_thread():
            return function(*args, **kwargs)
        if _watch.handler is not None:
            with _acting(at_once=False):
                return function(*args, **kwargs)
        with _watched():
            found = function(*args, **kwargs)
            with keeping(lambda: found):  # a signal during the last step
                stop_if_interrupted()
            return found

    return watched


@contextmanager
def _acting(*, at_once: bool) -> Iterator[None]:
    before, _watch.at_once = _watch.at_once, at_once
    try:
        yield
    finally:
        _watch.at_once = before
    if before:
        stop_if_interrupted()


@contextmanager
def users_code() -> Iterator[None]:
    """Around a function of the user, which has no such points: Ctrl-C ends it immediately."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    stop_if_interrupted()
    with _acting(at_once=True):
        yield


@contextmanager
def keeping(result: Callable[[], object]) -> Iterator[None]:
    """Attaches the results up to now to an interrupt."""
    try:
        yield
    except Interrupted as stop:
        stop.result = result()
        raise
    except KeyboardInterrupt as error:
        raise Interrupted(result=result()) from error


def next_of(queue: SimpleQueue[_R]) -> _R:
    """Next element of a queue that other threads fill. Raises Interrupted."""
    while True:
        stop_if_interrupted()
        try:
            return queue.get(timeout=WAIT)
        except Empty:
            continue
