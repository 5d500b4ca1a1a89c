"""Inputs that are linear within a communication step: input derivatives (FMI 2.0), intermediate updates (FMI 3.0)."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.fmu import CoSimulation, Slave, load
from support.fmus import HYDRAULIC, short_line

RAMP = rw.Schedule((0.0, 2.0, 4.0), (1.0, 1.2, 0.9))


@pytest.fixture(scope="module")
def simulated() -> pd.DataFrame:
    line = short_line(drive=HYDRAULIC)
    return rw.simulate(line, 4.0, every=0.1, inputs={"c1.speed": RAMP}, tolerance=1e-9).frame


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_a_ramped_speed_at_coarse_steps(make: Any, simulated: pd.DataFrame, fmi: str) -> None:
    """The master interpolates, and so does the FMU; with the mean of each step the speed is off by 3e-4."""
    path = make(f"ramped{fmi[0]}", short_line(drive=HYDRAULIC), fmi, tolerance=1e-8)
    together = CoSimulation(0.1)
    together.add("line", path)
    frame = together.run(4.0, inputs={"line.c1.speed": RAMP})
    for name in ("c1.rope_speed", "c1.travel", "c1.tension_in"):
        right = simulated[name].to_numpy()
        assert frame[f"line.{name}"].to_numpy() == pytest.approx(right, abs=1e-6 * np.abs(right).max()), name


@pytest.mark.parametrize("name", ["line2", "line3"])
def test_the_ramp_ends_with_the_step(name: str, request: pytest.FixtureRequest) -> None:
    path: Path = request.getfixturevalue(name)
    with Slave(load(path)) as slave:
        assert slave.can_interpolate
        slave.enter(0.0, {"c1.speed": 0.5})
        slave.leave()
        slave.step(1.0, {"c1.speed": 0.5}, {"c1.speed": 1.0})
        slave.step(1.0, {"c1.speed": 1.0}, {"c1.speed": 1.0})
        assert slave.get(["c1.travel"])[0] == pytest.approx(0.75 + 1.0, abs=1e-9)
        state = slave.save()
        for _ in range(2):
            slave.step(1.0, {"c1.speed": 1.0}, {"c1.speed": 0.5})
            assert slave.get(["c1.travel"])[0] == pytest.approx(2.5, abs=1e-9)
            slave.restore(state)
        slave.forget(state)
