"""Stable equilibria of random lines from a cold start.

`lines.py` builds the lines backwards, so their equilibrium is known from direct integration.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest

import ropeway as rw
from support.lines import Case, random_line, unknown_line
from support.oracle import Line, solve_line, taut_branch

CHUNK = 25


def chunks(quick: int, count: int) -> list[object]:
    """First seeds of all chunks; those from `quick` on are slow."""
    return [pytest.param(k, marks=[pytest.mark.slow] if k >= quick else []) for k in range(0, count, CHUNK)]


pytestmark = pytest.mark.filterwarnings(
    "ignore::ropeway.components.errors.RopewayWarning"
)  # drawn without regard to their strength


def forces(eq: rw.Equilibrium) -> np.ndarray:
    """Tension vectors at the spans' ends a (n, 3) [N]."""
    spans = [s.name for run in eq.runs for s in run.spans]
    return np.array([[eq[f"{name}.force_{axis}"] for axis in "xyz"] for name in spans])


def rope(eq: rw.Equilibrium) -> np.ndarray:
    """Rope before each support of the only run (n + 1,) [m]."""
    return np.concatenate([[0.0], np.cumsum([eq[f"{s.name}.length"] for s in eq.runs[0].spans])])


def check(case: Case, eq: rw.Equilibrium) -> None:
    """The equilibrium is the known one: forces to 1e-9, positions to 1e-7 m, each load in its span."""
    note = f"seed {case.seed}"
    scale = np.linalg.norm(case.start, axis=1)
    assert np.all(np.abs(forces(eq) - case.start) <= 1e-9 * scale.max()), note
    tension = [eq[f"{s.name}.tension_b"] for run in eq.runs for s in run.spans]
    np.testing.assert_allclose(tension, np.linalg.norm(case.end, axis=1), rtol=1e-9, err_msg=note)
    assert eq.held == (), note
    assert len(eq.loads) == len(case.loads), note
    table = eq.loads.set_index("load")
    at = np.array([[table.at[f"l{i}", axis] for axis in "xyz"] for i in range(len(case.loads))]).reshape(-1, 3)
    np.testing.assert_allclose(at, case.loads, rtol=0.0, atol=1e-7, err_msg=note)
    assert np.all(table["distance"] >= 0.0), note
    for span, own in eq.loads.groupby("span"):
        assert own["distance"].max() <= eq[f"{span}.length"], note


def failures(first: int, count: int) -> int:
    """Solves lines from `first` on and counts errors; any solution must be correct."""
    failed = 0
    for seed in range(first, first + count):
        case = random_line(seed)
        try:
            eq = rw.equilibrium(case.system())
        except rw.EquilibriumError:
            failed += 1
        else:
            check(case.taut(forces(eq)), eq)
    return failed


@pytest.mark.parametrize("first", chunks(25, 200))
def test_stable_lines_from_a_cold_start(first: int) -> None:
    assert failures(first, CHUNK) == 0


@pytest.mark.slow
def test_a_thousand_stable_lines_from_a_cold_start() -> None:
    assert failures(1000, 1000) <= 1


def test_the_lines_cover_all_cases() -> None:
    cases = [random_line(seed) for seed in range(200)]
    spans = [len(c.points) - 1 for c in cases]
    assert (min(spans), max(spans)) == (1, 20)
    assert min(c.sag for c in cases) < 2e-3
    assert 0.19 < max(c.sag for c in cases) <= 0.2
    slopes = [s[:, 2] / np.hypot(s[:, 0], s[:, 1]) for s in (np.diff(c.points, axis=0) for c in cases)]
    assert max(s.max() for s in slopes) > 0.9
    assert min(s.min() for s in slopes) < -0.9
    assert any(np.any(s > 0.0) and np.any(s < 0.0) for s in slopes)
    assert any(np.ptp(c.points[:, 1]) > 1.0 for c in cases)
    alone = [len(c.sections) == 1 for c in cases]
    assert 0 < sum(alone) < len(cases)
    counts = {n for c in cases for s in c.sections for n in np.bincount(s.line.spans(s.solved.rope), minlength=1)}
    assert counts == {0, 1, 2, 3, 4}
    assert min(c.stiffness for c in cases) < 1e-4


def test_the_known_equilibrium_is_the_taut_branch() -> None:
    sections = [s for seed in range(30) for s in random_line(seed).sections if len(s.line.points) > 2]
    for section in sections:
        tension = float(np.linalg.norm(section.solved.start, axis=1).max())
        drawn = taut_branch(section.line, tension)
        np.testing.assert_allclose(drawn.start, section.solved.start, rtol=0.0, atol=1e-9 * tension)


def confirmed(line: Line, eq: rw.Equilibrium, note: str) -> None:
    """An independent Newton step does not move the equilibrium of a line over idlers, and its check shows it stable."""
    found = forces(eq)
    solved = solve_line(line, found, rope(eq))
    np.testing.assert_allclose(found, solved.start, rtol=0.0, atol=1e-9 * np.abs(found).max(), err_msg=note)
    np.testing.assert_allclose(rope(eq), solved.rope, rtol=0.0, atol=1e-7, err_msg=note)
    assert solved.stiffness > 0.0, note
    assert solved.inside, note


@pytest.mark.parametrize("first", chunks(50, 100))
def test_a_line_of_unknown_equilibrium_is_solved_or_rejected(first: int) -> None:
    solved = 0
    for seed in range(first, first + CHUNK):
        system, line = unknown_line(seed)
        with suppress(rw.EquilibriumError):
            eq = rw.equilibrium(system)
            solved += 1
            if not eq.held:
                confirmed(line, eq, f"seed {seed}")
    assert solved >= 0.9 * CHUNK
