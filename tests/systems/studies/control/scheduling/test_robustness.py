"""Feed-forward with trim maintains the plan's objective under disturbances; open loop does not."""

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.studies.control.control_sheaves import with_responses
from support import schedule_lines

UNTIL = 40.0


@pytest.fixture(scope="module")
def plan() -> rw.SchedulePlan:
    line = schedule_lines.line(response=rw.ThresholdResponse(low=40e3, high=50e3, increment=0.01))
    sheaves = ("c1", "c2", "c3")
    start = rw.equilibrium(
        line,
        given={f"{c}.differential_tension": 0.0 for c in sheaves},
        solve_for=[f"{c}.travel" for c in sheaves],
    )
    return rw.optimise_schedule(line, UNTIL, intervals=20, start=start)


def test_trim_limits_the_peak_and_open_loop_does_not(plan: rw.SchedulePlan) -> None:
    table = plan.robustness()
    assert len(table) == 7  # as planned, masses, speed, a missing load, a late drive
    assert table["trimmed", "over plan"].max() < 0.02
    assert table["open loop", "over plan"].max() > 0.02
    assert table.loc["as planned", ("open loop", "over plan")] == pytest.approx(0.0, abs=1e-3)


def test_trim_is_inactive_without_a_disturbance(plan: rw.SchedulePlan) -> None:
    row = plan.robustness([rw.Disturbance("as planned")]).loc["as planned"]
    for name in ("peak tension", "tension deviation", "energy"):
        assert row["trimmed", name] == pytest.approx(plan.objectives[name], rel=1e-4)


def test_the_trimmed_line_runs_from_the_start_of_the_plan(plan: rw.SchedulePlan) -> None:
    faster = {**plan.inputs, "c2.speed": rw.Disturbance("", sheave="c2", speed=1.001).schedules(plan.schedules)["c2"]}
    table = plan.robustness([rw.Disturbance("fast", sheave="c2", speed=1.001)])
    for kind, line in (("trimmed", plan.trimmed), ("open loop", plan.line)):
        system = line if kind == "trimmed" else with_responses(line, dict.fromkeys(plan.schedules))
        run = rw.simulate(system, UNTIL, every=0.5, inputs=faster, start=plan.start)
        found = rw.objectives(run, settle=plan.settle, target=plan.target)
        for name in ("peak tension", "tension deviation"):
            assert found[name] == pytest.approx(table.loc["fast", (kind, name)], rel=1e-9)


def test_a_start_adds_no_responses(plan: rw.SchedulePlan) -> None:
    coarse, fine = (rw.ThresholdResponse(low=40e3, high=50e3, increment=step) for step in (0.01, 0.002))
    start = rw.balanced(with_responses(plan.line, dict.fromkeys(plan.schedules, coarse)))
    run = rw.simulate(with_responses(plan.line, dict.fromkeys(plan.schedules, fine)), 1.0, start=start)
    assert run.record(0)["c1.response_increment"] == 0.002


def test_the_sheave_that_keeps_the_speed_has_no_trim(plan: rw.SchedulePlan) -> None:
    assert plan.free == ["c2", "c3"]
    assert plan.trimmed.components["c1"].response is None
    assert plan.trimmed.components["c2"].response.gain == plan.trim.gain


def test_delay_of_a_late_drive(plan: rw.SchedulePlan) -> None:
    late = rw.Disturbance("late", sheave="c2", delay=1.5).schedules(plan.schedules)
    assert late["c2"].at(11.5) == pytest.approx(plan.schedules["c2"].at(10.0))
    assert late["c2"].at(1.0) == plan.schedules["c2"].speeds[0]
    assert late["c3"] == plan.schedules["c3"]


def test_a_missing_load_and_other_masses_change_the_start_but_not_the_rope(plan: rw.SchedulePlan) -> None:
    heavy = rw.Disturbance("heavy", mass=1.1).start(plan.start)
    light = rw.Disturbance("one less", missing=0.5).start(plan.start)
    assert heavy.runs[0].loads.mass == pytest.approx(1.1 * plan.start.runs[0].loads.mass)
    assert np.count_nonzero(light.runs[0].loads.mass == 0.0) == 1
    for other in (heavy, light):
        assert other.point.p == pytest.approx(plan.start.point.p)
    assert heavy["c1_s3.tension_a"] > plan.start["c1_s3.tension_a"]


def test_disturbances_that_do_not_match_a_plan_are_errors(plan: rw.SchedulePlan) -> None:
    with pytest.raises(rw.UnknownNameError, match="'c9' is not a control sheave"):
        plan.robustness([rw.Disturbance("fast", speed=1.1, sheave="c9")])
    with pytest.raises(rw.InputError, match="Two disturbances are named 'heavy'"):
        plan.robustness([rw.Disturbance("heavy", mass=1.1), rw.Disturbance("heavy", mass=1.2)])


def test_wrong_disturbances_are_errors() -> None:
    with pytest.raises(rw.InputError, match="has no sheave"):
        rw.Disturbance("fast", speed=1.1)
    with pytest.raises(rw.InputError, match="missing is 2"):
        rw.Disturbance("missing", missing=2.0)
    with pytest.raises(rw.InputError, match="missing is 'c1'"):
        rw.Disturbance("missing", missing="c1")
    with pytest.raises(rw.InputError, match="mass"):
        rw.Disturbance("light", mass=0.0)
