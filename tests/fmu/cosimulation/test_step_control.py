"""Step-size control of the master, against the closed form of two masses coupled by a spring and a damper."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.fmu import FmuRunError, StepControl
from ropeway.fmu.cosimulation.step_control import Method
from support.masses import exact_pair, mass_fmu, pair


def error(frame: pd.DataFrame) -> float:
    return float(np.abs(frame[["one.x", "one.v", "two.x", "two.v"]] - exact_pair(frame.index)).to_numpy().max())


@pytest.mark.parametrize("master", ["Jacobi", "Gauss-Seidel"])
@pytest.mark.parametrize(("iterated", "order"), [(False, 1), (True, 2)])
def test_fixed_steps_have_their_order(mass: Path, master: str, iterated: bool, order: int) -> None:
    coarse, fine = (error(pair(mass, h, master=master, iterated=iterated).run(5.0)) for h in (0.01, 0.005))
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("method", ["Richardson", "coupling error"])
def test_fewer_steps_than_fixed_ones(mass: Path, method: Method) -> None:
    controlled = pair(mass, 0.01, iterated=True, control=StepControl(method, tolerance=1e-3)).run(20.0)
    reached, steps = error(controlled), len(controlled) - 1
    assert reached < 3e-3
    assert error(pair(mass, 20.0 / steps, iterated=True).run(20.0)) > 2.0 * reached
    assert np.diff(controlled.index).max() > 20.0 * np.diff(controlled.index).min()


@pytest.mark.parametrize("method", ["Richardson", "coupling error"])
@pytest.mark.parametrize("iterated", [False, True])
def test_error_follows_the_tolerance(mass: Path, method: Method, iterated: bool) -> None:
    loose, strict = (
        error(pair(mass, 0.01, iterated=iterated, control=StepControl(method, tolerance=t)).run(2.0))
        for t in (1e-2, 2e-3)
    )
    assert 2.0 < loose / strict < 20.0


def test_a_line_that_starts_up(driven: Path, line2: Path) -> None:
    """The drive's speed settles within a second: steps grow from then on, but for the crossings."""
    frames = []
    for step, control in ((0.01, None), (0.01, StepControl("coupling error", tolerance=1e-4, most=1.0))):
        together = rw.fmu.CoSimulation(step, iterated=True, control=control)
        together.add("first", driven, start={"c1.speed": 1.02})
        together.add("second", line2)
        together.connect("first.c1.rope_speed", "second.c1.speed")
        frames.append(together.run(10.0))
    fixed, controlled = frames
    assert len(controlled) < 0.3 * len(fixed)
    assert controlled["second.c1.travel"].iloc[-1] == pytest.approx(fixed["second.c1.travel"].iloc[-1], abs=1e-3)


def test_first_steps_are_repeated_and_the_last_ends_in_time(mass: Path) -> None:
    frame = pair(mass, 1.0, iterated=True, control=StepControl("Richardson", tolerance=1e-3)).run(3.7)
    assert frame.index[-1] == 3.7
    assert frame.attrs["repeated"] > 2
    assert frame.attrs["inexact"] == []


def test_smallest_steps_that_miss_the_tolerance_are_recorded(mass: Path) -> None:
    control = StepControl("Richardson", tolerance=1e-6, least=0.1)
    assert len(pair(mass, 0.1, control=control).run(1.0).attrs["inexact"]) == 10


def test_a_rejected_step_is_repeated_with_a_smaller_size(mass: Path) -> None:
    control = StepControl("coupling error", tolerance=1e-1)
    frame = pair(mass, 0.1, start={"longest_step": 0.013}, iterated=True, control=control).run(0.5)
    assert np.diff(frame.index).max() <= 0.013
    assert frame.attrs["repeated"] > 0
    with pytest.raises(FmuRunError, match=r"'one' \(mass\.fmu\) rejected a step of 0\.1 s.*the step is too long"):
        pair(mass, 0.1, start={"longest_step": 0.013}).run(0.5)
    with pytest.raises(FmuRunError, match="the step is too long"):
        pair(mass, 0.1, start={"longest_step": 0.013}, control=StepControl("Richardson", least=0.02)).run(0.5)


def test_slaves_without_restorable_state(tmp_path: Path) -> None:
    path = mass_fmu(tmp_path / "mass.fmu", keeps_states=False)
    with pytest.raises(rw.InputError, match="cannot restore its state"):
        pair(path, 0.1, control=StepControl("Richardson")).run(1.0)
    frames = [
        pair(path, 0.001, control=StepControl("coupling error", tolerance=t, most=0.1)).run(2.0) for t in (3e-2, 1e-2)
    ]
    assert [f.attrs["repeated"] for f in frames] == [0, 0]
    assert np.diff(frames[1].index).max() > 5.0 * np.diff(frames[1].index).min()
    assert error(frames[1]) < 0.5 * error(frames[0])


@pytest.mark.parametrize(
    "wrong", [{"tolerance": 0.0}, {"least": -1.0}, {"most": 0.0}, {"least": 2.0, "most": 1.0}, {"method": "guess"}]
)
def test_bad_controls(wrong: dict[str, object]) -> None:
    with pytest.raises(rw.InputError):
        StepControl(**{"method": "Richardson", **wrong})  # type: ignore[arg-type]
