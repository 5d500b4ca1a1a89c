"""Every example runs and leaves its pictures."""

import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


NETWORK = {"fmu_foreign.py"}
"""Examples that download something."""
SMALLER = {"sweep.py": ["500"]}
"""Arguments that make an example's work less."""


@pytest.mark.parametrize(
    "script",
    [
        pytest.param(p.name, marks=[pytest.mark.importers] if p.name in NETWORK else [])
        for p in sorted(EXAMPLES.glob("[!_]*.py"))
    ],
)
def test_example(script: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", [script, str(tmp_path / "new"), *SMALLER.get(script, [])])
    runpy.run_path(str(EXAMPLES / script), run_name="__main__")
    pictures = list((tmp_path / "new").glob("*.png"))
    assert pictures
    assert all(p.stat().st_size > 5000 for p in pictures)
