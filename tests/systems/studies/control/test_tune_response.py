"""A tuned response improves on its initial response in reproducible simulations."""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.components.response import PRECEDENCES
from ropeway.systems.studies.control.control_sheaves import with_responses

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
KINDS = ("drum", "idler", "control", "idler", "control", "idler", "drum")
SUPPORTS = pd.DataFrame(
    [(f"s{k}", 90.0 * k, 0.0, 3.0 * (k % 2), kind) for k, kind in enumerate(KINDS)],
    columns=["name", "x", "y", "z", "kind"],
)
COARSE = rw.ThresholdResponse(low=44e3, high=48e3, increment=0.05, delay=2.0)
OVER: dict[str, Any] = {"increment": (0.002, 0.05), "initiation": (-1500.0, 1000.0), "precedence": PRECEDENCES}


def line(speed: float | rw.Schedule = 1.0) -> rw.System:
    masses = (500.0, 100.0, 300.0, 0.0, 450.0)
    return rw.monocable(ROPE, SUPPORTS, tension=45e3, speed=speed, load_mass=masses, load_spacing=60.0)


def tune(**settings: Any) -> rw.TunedResponse:
    request: dict[str, Any] = {"over": OVER, "minimise": "tension deviation", "target": 46e3, "until": 40.0}
    return rw.tune_response(line(), COARSE, **{**request, "generations": 2, "population": 3, "workers": 1, **settings})


@pytest.fixture(scope="module")
def tuned() -> rw.TunedResponse:
    return tune()


def test_it_improves_on_the_initial_response(tuned: rw.TunedResponse) -> None:
    assert tuned.objective < 0.8 * tuned.baseline
    assert tuned.objective == tuned.history["objective"].min()
    assert tuned.history["objective"][0] == tuned.baseline
    assert tuned.history["error"].eq("").all()
    assert isinstance(tuned.response, rw.ThresholdResponse)
    assert 0.002 <= tuned.response.increment <= 0.05
    assert tuned.response.delay == 2.0
    assert set(tuned.history["precedence"]) == set(PRECEDENCES)


def test_its_objective_is_that_of_its_line(tuned: rw.TunedResponse) -> None:
    for system, expected in (
        (tuned.line, tuned.objective),
        (with_responses(line(), {"s2": COARSE, "s4": COARSE}), tuned.baseline),
    ):
        again = rw.objectives(rw.simulate(system, 40.0), target=46e3)
        assert again["tension deviation"] == pytest.approx(expected, rel=1e-12)
    assert tuned.line.precedence == tuned.precedence


def test_the_sheaves_that_respond_and_the_start_can_be_chosen() -> None:
    start = rw.balanced(tune(generations=0, over={"hold": (1.0, 2.0)}).line)  # with its own response
    found = tune(generations=0, sheaves=("s4",), start=start, over={"increment": (0.002, 0.01)}, workers=2)
    assert found.line.components["s2"].response is None
    assert found.line.components["s4"].response == found.response
    by_hand = with_responses(line(), {"s4": found.response})
    rest = rw.balanced(by_hand)
    again = rw.objectives(rw.simulate(rest.model, 40.0, start=rest), target=46e3)
    assert again["tension deviation"] == pytest.approx(found.objective, rel=1e-6)
    assert found.objective != pytest.approx(found.baseline, rel=1e-3)


def test_the_result_does_not_depend_on_processes(tuned: rw.TunedResponse) -> None:
    pd.testing.assert_frame_equal(tune(workers=2).history, tuned.history, check_exact=True)
    first = tune(seed=1, generations=0).history
    assert not first.equals(tuned.history.head(len(first)))


def test_runs_that_fail_count_as_infinite() -> None:
    found = tune(over={"initiation": (-4000.0, 1000.0)}, generations=1, population=8)
    failed = found.history["error"].ne("")
    assert 0 < failed.sum() < len(found.history)
    assert np.isinf(found.history.loc[failed, "objective"]).all()
    assert found.history.loc[failed, "message"].str.contains("is larger than the range").all()
    assert np.isfinite(found.objective)


def test_an_initial_response_outside_the_ranges_counts() -> None:
    good = replace(COARSE, increment=0.005, delay=0.0, initiation=-500.0)
    found = rw.tune_response(
        line(),
        good,
        over={"delay": (4.0, 5.0), "precedence": PRECEDENCES[:2]},
        minimise="tension deviation",
        target=46e3,
        until=20.0,
        generations=1,
        population=3,
        workers=1,
    )
    assert found.response == good
    assert found.objective == found.baseline == found.history["objective"].min()


def test_a_line_that_cannot_run_is_an_error_with_its_cause() -> None:
    heavy = rw.monocable(ROPE, SUPPORTS, tension=45e3, load_mass=8e3, load_spacing=30.0)
    with pytest.raises(rw.SimulationError, match=r"The message of the first: The loads .* are too heavy"):
        rw.tune_response(
            heavy,
            COARSE,
            over={"hold": (1.0, 9.0)},
            minimise="energy",
            until=20.0,
            generations=1,
            population=2,
            workers=1,
        )


def test_wrong_input() -> None:
    for over, message in (
        ({}, "nothing to tune"),
        ({"gain": (0.1, 0.2)}, "has no 'gain'"),
        ({"increment": (0.2, 0.1)}, "increment is tuned over"),
        ({"increment": (0.1, 0.1)}, "increment is tuned over"),
        ({"increment": (0.1, np.inf)}, "finite number"),
        ({"precedence": ("all at once",)}, "precedence is tuned over"),
        ({"precedence": "all at once"}, "Give 2 values or a sequence of texts"),
        ({"increment": 0.05}, r"over\['increment'\] is 0.05"),
        ({"precedence": ("all at once", "loudest first")}, "loudest first"),
    ):
        with pytest.raises(rw.InputError, match=message):
            tune(over=over)
    for settings, message in (
        ({"minimise": "sag"}, "minimise is 'sag'"),
        ({"target": None}, "no target"),
        ({"settle": 40.0}, "settle is 40.0"),
        ({"until": 0.0}, "until"),
        ({"seed": -1}, "seed"),
        ({"sheaves": ()}, "nothing to tune"),
    ):
        with pytest.raises(rw.InputError, match=message):
            tune(**settings)
    with pytest.raises(rw.UnknownNameError, match="'s3' is not a control sheave"):
        tune(sheaves=("s3",))
    with pytest.raises(rw.InputError, match="start is of another system"):
        tune(start=rw.equilibrium(rw.monocable(ROPE, SUPPORTS.drop(3), tension=45e3)))
    with pytest.raises(rw.InputError, match="no control sheave"):
        rw.tune_response(rw.System("empty"), COARSE, over=OVER, minimise="energy", until=10.0)
    short = line(rw.Schedule((0.0, 5.0), (1.0, 1.0)))
    with pytest.raises(rw.InputError, match="ends at 5 s"):
        rw.tune_response(short, COARSE, over=OVER, minimise="energy", until=10.0)
