"""Inputs that are linear within a communication step: input derivatives (FMI 2.0), intermediate updates (FMI 3.0)."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ropeway as rw
from ropeway.fmu import CoSimulation, Slave, load
from support.fmus import short_line

RAMP = rw.Schedule((0.0, 4.0, 8.0), (0.0, 1.2, 0.3))


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def ramped(request: pytest.FixtureRequest, make: Any) -> Path:
    path: Path = make(f"ramped{request.param[0]}", short_line(), request.param)
    return path


def test_a_ramped_speed_at_coarse_steps(ramped: Path) -> None:
    """The master interpolates, and so does the FMU: as a simulation with the same schedule."""
    line = short_line()
    wanted = rw.simulate(line, 8.0, every=0.1, inputs={"c1.speed": RAMP}).frame
    together = CoSimulation(0.1)
    together.add("line", ramped)
    frame = together.run(8.0, inputs={"line.c1.speed": RAMP})
    for name in ("c1.travel", "c1.speed", "c1.tension_in", "c1.power"):
        if f"line.{name}" in frame:
            found, right = frame[f"line.{name}"].to_numpy(), wanted[name].to_numpy()
            assert found == pytest.approx(right, rel=1e-6, abs=1e-6 * np.abs(right).max()), name


def test_the_ramp_ends_with_the_step(ramped: Path) -> None:
    fmu = load(ramped)
    with Slave(fmu) as slave:
        assert slave.can_interpolate
        slave.enter(0.0, {"c1.speed": 0.0})
        slave.leave()
        slave.step(1.0, {"c1.speed": 0.0}, {"c1.speed": 1.0})
        slave.step(1.0, {"c1.speed": 1.0}, {"c1.speed": 1.0})
        assert slave.get(["c1.travel"])[0] == pytest.approx(0.5 + 1.0, abs=1e-9)
        state = slave.save()
        for _ in range(2):
            slave.step(1.0, {"c1.speed": 1.0}, {"c1.speed": 0.0})
            assert slave.get(["c1.travel"])[0] == pytest.approx(2.0, abs=1e-9)
            slave.restore(state)
        slave.forget(state)
