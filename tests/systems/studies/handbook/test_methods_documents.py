"""Payload methods in docs/methods.md and in the benchmarks."""

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from ropeway.systems.studies.handbook.loaded_span import LoadedSpan
from ropeway.systems.studies.handbook.payload_exact import catenary_clamped
from ropeway.systems.studies.handbook.payload_methods import METHODS

ROOT = Path(__file__).parents[4]


def script(name: str) -> ModuleType:
    """A benchmark: a script outside the package."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "benchmarks" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def rows(text: str) -> dict[str, list[str]]:
    cells = [[c.strip() for c in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("| ")]
    return {c[0]: c[1:] for c in cells if c[0] in METHODS}


@pytest.mark.parametrize("span", [200.0, 600.0])
def test_error_table_of_the_docs(span: float) -> None:
    text = (ROOT / "docs" / "methods.md").read_text(encoding="utf-8")
    section = text.split(f"### Span {span:.0f} m")[1].split("\n#")[0].split("What to make")[0]
    printed, made = rows(section), rows(script("payload_errors").table(span))
    assert list(printed) == list(made) == list(METHODS)
    for name in METHODS:
        assert printed[name][0] == made[name][0]
        assert [float(v) for v in printed[name][1:4]] == pytest.approx([float(v) for v in made[name][1:4]], abs=2e-4)
    small = rows(script("payload_errors").table(span, (3, 3, 3)))
    for name in METHODS:
        low, high = (float(v) for v in printed[name][1:3])
        assert low - 2e-4 <= float(small[name][1]) <= float(small[name][2]) <= high + 2e-4


def test_hundred_thousand_exact_payloads_in_one_sweep() -> None:
    line = script("payload_speed").sweep()
    count = np.asarray(line.deflection).size
    assert count >= 100_000
    assert np.isfinite(catenary_clamped(line, 3.48, 19600.0)).all()


def test_a_sweep_equals_single_calls() -> None:
    line = script("payload_speed").sweep(125)
    gross = catenary_clamped(line, 3.48, 19600.0)
    one = [
        float(catenary_clamped(LoadedSpan(200.0, y, s, c), 3.48, 19600.0))
        for y, s, c in zip(line.deflection, line.chord_slope, line.carriage, strict=True)
    ]
    assert gross == pytest.approx(one, rel=1e-13)


def test_speed_benchmark_times_every_method_on_the_same_spans(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    benchmark, timed = script("payload_speed"), []
    spans = LoadedSpan(200.0, np.linspace(10.0, 30.0, 50))

    def best(function: Callable[[], object], repeat: int = 1) -> float:
        timed.append(function())
        return 1e-4

    monkeypatch.setattr(benchmark, "sweep", lambda: spans)
    monkeypatch.setattr(benchmark, "best", best)
    benchmark.main()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("50 spans at once")
    for name, method, line, found in zip(METHODS, METHODS.values(), lines[1:], timed, strict=False):
        assert line.split() == [*name.split(), "0.0001", "2.000", "16"]  # 32 us over 2 us
        assert found == pytest.approx(method(spans, 3.48, 19600.0), rel=1e-13)
    exact, piece, longest = timed[len(METHODS) :]
    assert exact == pytest.approx(catenary_clamped(LoadedSpan(200.0, 25.0, 0.1), 3.48, 19600.0), rel=1e-13)
    assert np.isfinite(piece).all()
    assert 300.0 < longest.length < 400.0
    assert "Harvey 0.5 s: 5000 times" in lines[-1]
