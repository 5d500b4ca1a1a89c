"""Progress bars: one at a time, and only on a terminal."""

import sys

import pytest

from ropeway.systems.progress_bar import bar


def test_a_part_of_longer_work_shows_no_bar(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")  # rich then takes the captured stream for a terminal
    with bar("whole", 3.0, show=True) as whole, bar("part", 2.0, show=True) as part:
        part(1.0)
        whole(1.0)
    text = capsys.readouterr().err
    assert "whole" in text
    assert "part" not in text
    with bar("later", 1.0, show=True) as later:
        later(1.0)
    assert "later" in capsys.readouterr().err


def test_no_bar_without_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert not sys.stderr.isatty()
    with bar("whole", 1.0) as advance:
        advance(1.0)
    assert capsys.readouterr().err == ""
