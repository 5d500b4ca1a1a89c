"""Ctrl-C in long calls: it ends them between two steps, with what they have found so far.

CasADi asks Python for signals inside its functions and drops a `KeyboardInterrupt` raised there: IDAS takes it for
a failed evaluation and tries a smaller step. In an interruptible call the handler only notes the signal, and the
solvers look at the note where they can stop.
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
"""Longest wait for something else before signals are looked at [s]."""


class _Watch:
    """Of the main thread while an interruptible call runs: the `handler` that was there before, the signal that has
    been `noted`, if any, and whether a signal acts `at_once` now."""

    def __init__(self) -> None:
        self.handler: Callable[[int, FrameType | None], Any] | None = None
        self.noted: tuple[int, FrameType | None] | None = None
        self.at_once = False

    def note(self, number: int, frame: FrameType | None) -> None:
        """The signal handler. A second signal does not wait; it stays noted, as CasADi may drop what is raised."""
        if self.handler is not None and (self.at_once or self.noted is not None):
            self.handler(number, frame)
        else:
            self.noted = (number, frame)

    def act(self) -> None:
        """Does what the handler that was there before does, now that it is safe. Raises Interrupted."""
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
    """Whether a Ctrl-C waits for the call in this thread to stop."""
    return _watch.noted is not None and threading.current_thread() is threading.main_thread()


def stop_if_interrupted() -> None:
    """A place where an interruptible call can stop. Raises Interrupted after a Ctrl-C."""
    if _watch.noted is not None and interrupted():  # asked at every evaluation of a function
        _watch.act()


@contextmanager
def _watched() -> Iterator[None]:
    """Notes Ctrl-C; signals reach the main thread only, and where nobody handles them in Python they keep their way."""
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
        stop_if_interrupted()  # what the call stopped with is then the context of the interrupt
        raise
    finally:
        _watch.handler = _watch.noted = None
        signal.signal(signal.SIGINT, before)


def interruptible(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Lets Ctrl-C end a function where what it calls can stop, as Interrupted, and never inside CasADi.

    A Python handler that was there before is called at that place: what it raises ends the function.
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
            with keeping(lambda: found):  # a signal in the very last step
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
    """Around a function of the user's own: it knows no place to stop, so that Ctrl-C ends it at once."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    stop_if_interrupted()
    with _acting(at_once=True):
        yield


@contextmanager
def keeping(result: Callable[[], object]) -> Iterator[None]:
    """Gives an interrupt on its way out what the call has found so far."""
    try:
        yield
    except Interrupted as stop:
        stop.result = result()
        raise
    except KeyboardInterrupt as error:
        raise Interrupted(result=result()) from error


def next_of(queue: SimpleQueue[_R]) -> _R:
    """The next of a queue that other threads fill. Raises Interrupted."""
    while True:
        stop_if_interrupted()
        try:
            return queue.get(timeout=WAIT)
        except Empty:
            continue
