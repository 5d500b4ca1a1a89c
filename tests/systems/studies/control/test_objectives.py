"""Objectives of a run against its reports, against a line at rest, and against their definitions."""

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.studies.control.objectives import objective_weights

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
SUPPORTS = pd.DataFrame(
    [
        ("start", 0.0, 0.0, 0.0, "drum"),
        ("s1", 100.0, 0.0, 4.0, "idler"),
        ("c1", 200.0, 0.0, 2.0, "control"),
        ("s2", 290.0, 0.0, 6.0, "idler"),
        ("end", 400.0, 0.0, 3.0, "drum"),
    ],
    columns=["name", "x", "y", "z", "kind"],
)


def run(speed: float, until: float = 40.0) -> rw.Result:
    line = rw.monocable(ROPE, SUPPORTS, tension=45e3, speed=speed, load_mass=(400.0, 150.0, 300.0), load_spacing=45.0)
    return rw.simulate(line, until)


@pytest.fixture(scope="module")
def moving() -> rw.Result:
    return run(1.0)


def test_peak_is_the_highest_of_the_safety_report(moving: rw.Result) -> None:
    assert rw.objectives(moving)["peak tension"] == moving.summary().spans["highest_tension"].max()


def test_energy_is_the_pulled_energy_of_the_drives(moving: rw.Result) -> None:
    assert rw.objectives(moving)["energy"] == pytest.approx(moving.power()["pulled"]["c1"], rel=1e-12)


def test_only_records_after_settle_count(moving: rw.Result) -> None:
    whole, late = (rw.objectives(moving, settle=settle, target=45e3) for settle in (0.0, 30.0))
    assert late["peak tension"] < whole["peak tension"]
    assert late["tension deviation"] != whole["tension deviation"]


def test_energy_always_counts_from_the_start(moving: rw.Result) -> None:
    assert {rw.objectives(moving, settle=s)["energy"] for s in (0.0, 12.5, 30.0)} == {moving.power()["pulled"]["c1"]}


def test_deviation_is_a_root_mean_square(moving: rw.Result) -> None:
    low, middle, high = (rw.objectives(moving, target=t)["tension deviation"] ** 2 for t in (40e3, 45e3, 50e3))
    assert low - 2.0 * middle + high == pytest.approx(2.0 * 5e3**2, rel=1e-9)


def test_deviation_of_a_line_at_rest() -> None:
    result = run(0.0, until=3.0)
    rest = rw.equilibrium(result.model)
    sides = np.array([rest["c1.tension_in"], rest["c1.tension_out"]])
    expected = np.sqrt(((sides - 44e3) ** 2).mean())
    assert rw.objectives(result, target=44e3)["tension deviation"] == pytest.approx(expected, rel=1e-9)
    assert rw.objectives(result)["energy"] == 0.0


def test_wrong_requests(moving: rw.Result) -> None:
    with pytest.raises(rw.InputError, match="Choose from 'peak tension', 'tension deviation', 'energy'"):
        objective_weights("sag")
    with pytest.raises(rw.InputError, match="no weight above zero"):
        objective_weights({"energy": 0.0})
    with pytest.raises(rw.InputError, match="ends at 40 s"):
        rw.objectives(moving, settle=40.0)
    idlers = SUPPORTS.assign(kind=SUPPORTS["kind"].replace("control", "idler"))
    still = rw.simulate(rw.monocable(ROPE, idlers, tension=45e3, speed=0.0), 1.0)
    with pytest.raises(rw.InputError, match=r"one record from 39\.9 s on"):
        rw.objectives(moving, settle=39.9)
    with pytest.raises(rw.InputError, match="no control sheave"):
        rw.objectives(still)["energy"]
