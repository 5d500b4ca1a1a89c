"""Messages of compiled solvers are dropped for the thread that calls them, and for no other."""

from __future__ import annotations

import io
import sys
import threading

import pytest

from ropeway.systems.muted import muted


def test_a_thread_is_muted_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    with muted():
        sys.stderr.write("dropped")
        other = threading.Thread(target=lambda: sys.stderr.write("kept"))
        other.start()
        other.join()
    sys.stderr.write(" too")
    assert stream.getvalue() == "kept too"
    assert sys.stderr is stream


def test_threads_may_begin_and_end_in_any_order(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    first, second = muted(), muted()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    sys.stderr.write("dropped by the second")
    second.__exit__(None, None, None)
    assert sys.stderr is stream
    assert stream.getvalue() == ""
