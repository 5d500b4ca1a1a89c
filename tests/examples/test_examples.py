"""Every example runs and leaves its pictures."""

import runpy
import sys
from importlib import import_module
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NETWORK = {"fmu_foreign"}
"""Examples that download something."""
PRINTED = {
    "harvey_payload": "8837.6",
    "lyons_stretch": "1.004565",
    "turk_solvers": "1001 ft",
}
"""A result that an example prints."""
FEWER = {"sweep": ["200"]}
"""Arguments that make an example's work less."""
LONG = {
    "fit_tension_log",
    "fmu_cosimulation",
    "fmu_export",
    "load_cases",
    "optimise_schedule",
    "own_component",
    "standing_skyline",
    "sweep",
    "turk_responses",
}
"""Examples that run in the slow tests, and when the gallery is built."""
SMALLER = {
    "emergency_stop": {"DECELERATIONS": (2.0,), "SETTLE": 1.0},
    "saddle": {"SPACING": 0.5},
}
"""Examples that run by their constants too: with these in less time, with their own ones they are slow."""


def marked(name: str) -> object:
    marks = (name in NETWORK, pytest.mark.importers), (name in LONG | SMALLER.keys(), pytest.mark.slow)
    return pytest.param(name, marks=[mark for given, mark in marks if given])


def require_pictures(folder: Path) -> None:
    pictures = list(folder.glob("*.png"))
    assert pictures
    assert all(p.stat().st_size > 5000 for p in pictures)


@pytest.mark.parametrize("name", [marked(p.stem) for p in sorted(EXAMPLES.glob("[!_]*.py"))])
def test_example(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [f"{name}.py", str(tmp_path / "new"), *FEWER.get(name, [])])
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    require_pictures(tmp_path / "new")
    assert PRINTED.get(name, "") in capsys.readouterr().out


@pytest.mark.parametrize("name", SMALLER)
def test_example_in_less_time(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = import_module(f"ropeway.examples.{name}")
    for constant, value in SMALLER[name].items():
        monkeypatch.setattr(example, constant, value)
    example.main(tmp_path / "new")
    require_pictures(tmp_path / "new")
