"""FMUs of OpenModelica from the gemseo-fmu wheel (LGPL; downloaded as test data, not part of this project)."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ropeway.fmu import CoSimulation, StepControl

pytestmark = pytest.mark.importers
Deviation = Callable[..., tuple[int, float]]


@pytest.fixture(scope="module")
def deviation(foreign: Path) -> Deviation:
    """Steps that two masses on springs take in co-simulation, and how far they are from their monolith."""
    whole = CoSimulation(0.001)
    whole.add("both", foreign / "MassSpringSystem.fmu", kind="ModelExchange")
    both = whole.run(2.0)["both.x1"]

    def of(step: float, **more: object) -> tuple[int, float]:
        parts = CoSimulation(step, **more)  # type: ignore[arg-type]
        for i, name in ((1, "one"), (2, "two")):
            parts.add(name, foreign / f"MassSpringSubSystem{i}.fmu", kind="ModelExchange")
        parts.connect("one.x1", "two.x1")
        parts.connect("two.x2", "one.x2")
        found: pd.Series = parts.run(2.0)["one.x1"]
        wanted = both if found.index.isin(both.index).all() else _between(both, found.index)
        return len(found) - 1, float(np.abs(found - wanted.loc[found.index]).max())

    return of


def _between(values: pd.Series, times: pd.Index) -> pd.Series:
    """A smooth curve at other times, to far below what is measured."""
    from scipy.interpolate import CubicSpline

    return pd.Series(CubicSpline(values.index, values)(times), times)


def test_explicit_coupling_is_of_first_order(deviation: Deviation) -> None:
    errors = [deviation(h)[1] for h in (0.02, 0.01, 0.005)]
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.1)
    assert errors[1] / errors[2] == pytest.approx(2.0, abs=0.1)


def test_iterated_coupling_matches_the_monolith(deviation: Deviation) -> None:
    assert deviation(0.004, iterated=True)[1] < 1e-6


@pytest.mark.parametrize("method", ["Richardson", "coupling error"])
def test_controlled_steps_reach_their_tolerance(deviation: Deviation, method: str) -> None:
    control = StepControl(method, tolerance=1e-5)  # type: ignore[arg-type]
    steps, error = deviation(0.001, iterated=True, control=control)
    assert error < 1e-4
    assert steps < 1000, "no fewer than by the half of the first step"


@pytest.mark.parametrize("kind", ["ModelExchange", "CoSimulation"])
def test_a_ramp_ends_at_an_event(foreign: Path, kind: str) -> None:
    """No state at all, two event indicators."""
    together = CoSimulation(0.3)
    together.add("ramp", foreign / "ramp.fmu", kind=kind)  # type: ignore[arg-type]
    found = together.run(3.0)["ramp.out"]
    assert found.to_numpy() == pytest.approx(np.minimum(found.index, 1.0), abs=1e-9)
