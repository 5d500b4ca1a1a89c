"""Invalid requests for a schedule, and limits that no schedule satisfies together."""

import re
from dataclasses import replace

import numpy as np
import pytest

import ropeway as rw
from support import schedule_lines
from support.drives import hydraulic_drive

UNTIL = 40.0


def plan_of(line: rw.System | None = None, **given: object) -> rw.SchedulePlan:
    settings = {"intervals": 20, "settle": 10.0, **given}
    return rw.optimise_schedule(line or schedule_lines.line(), UNTIL, **settings)


def test_conflicting_limits_are_named_with_the_smallest_relaxation() -> None:
    limits = rw.ScheduleLimits(tension_low=40.5e3, force=2.5e3)
    with pytest.raises(rw.InfeasibleScheduleError, match="tension_low by") as error:
        plan_of(limits=limits)
    # The drums keep 40 kN; no schedule changes the tension next to them.
    assert set(error.value.relaxation) == {"tension_low"}
    assert 500.0 - 1.0 < error.value.relaxation["tension_low"] < 1500.0
    assert "tension_low" in error.value.colliding.index.get_level_values("limit")


def test_the_relaxation_allows_the_best_peak() -> None:
    force = {"force": 1.0e3, "tension_low": 30e3}
    best = plan_of(limits=rw.ScheduleLimits(**force))
    high = best.objective - 100.0
    with pytest.raises(rw.InfeasibleScheduleError, match="tension_high") as error:
        plan_of(limits=rw.ScheduleLimits(**force, tension_high=high))
    given = error.value.relaxation
    assert {"force", "tension_high"} <= set(error.value.colliding.index.get_level_values("limit"))
    if set(given) == {"tension_high"}:
        assert given["tension_high"] == pytest.approx(100.0, abs=10.0)
    assert given["tension_high"] < 105.0


def test_the_error_names_a_relaxed_limit_on_each_sheave() -> None:
    words = r"No schedule satisfies all of these limits: .*force.*; the smallest sufficient change: .*force by"
    with pytest.raises(rw.InfeasibleScheduleError, match=words) as error:
        rw.optimise_schedule(schedule_lines.line(), 20.0, intervals=10, limits=rw.ScheduleLimits(force=1.0))
    assert set(error.value.relaxation) <= set(re.findall(r"\w+", str(error.value).split("limits: ")[1].split(".")[0]))


def test_a_lower_tension_bound_is_optional() -> None:
    limits = rw.ScheduleLimits(tension_low=0.0, tension_high=42e3)
    with pytest.raises(rw.InfeasibleScheduleError, match="tension_high by"):
        rw.optimise_schedule(schedule_lines.line(), 20.0, intervals=10, limits=limits)


def test_a_line_starts_from_rest() -> None:
    line = schedule_lines.line(speed=rw.Schedule((0.0, 8.0, 24.0), (0.0, 1.0, 1.0)))
    with pytest.raises(rw.InfeasibleScheduleError, match="acceleration by"):
        rw.optimise_schedule(line, 24.0, intervals=12)
    plan = rw.optimise_schedule(line, 24.0, intervals=12, limits=rw.ScheduleLimits(acceleration=0.2))
    speeds = plan.frame.to_numpy()
    assert plan.schedules["c1"].speeds[:5] == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0])
    assert speeds[-1].min() > 0.5
    assert speeds.min() > -0.15 - 1e-6
    assert speeds.max() < 1.15 + 1e-6


def test_a_stationary_line_takes_no_energy() -> None:
    plan = rw.optimise_schedule(schedule_lines.line(speed=0.0), 20.0, intervals=10, minimise="energy")
    assert plan.objective == pytest.approx(0.0, abs=1.0)


@pytest.mark.slow
def test_drives_stay_within_their_limits() -> None:
    drive = hydraulic_drive()
    free = plan_of(schedule_lines.line(drive=drive), minimise="tension deviation")
    assert free.gap.crossing_time < 5e-3
    used = free.result.full_frame.loc[10.0:, "c3.pressure"].max()
    limits = rw.ScheduleLimits(pressure={"c3": 0.8 * used})
    tight = plan_of(schedule_lines.line(drive=drive), minimise="tension deviation", limits=limits)
    assert tight.result.full_frame.loc[10.0:, "c3.pressure"].max() < 1.02 * 0.8 * used
    assert tight.objective > free.objective
    assert ("pressure", "c3") in tight.active.index


def slippery(friction: float) -> rw.System:
    line = schedule_lines.line()
    for name in ("c1", "c2", "c3"):
        line.components[name] = replace(line.components[name], grip_friction=friction)
    return line


@pytest.mark.slow
def test_the_multiplier_of_a_grip_limit_is_its_cost() -> None:
    """Against the central difference of simulated objectives."""
    tight, plan, wide = (
        plan_of(slippery(0.008), minimise="tension deviation", limits=rw.ScheduleLimits(grip=least))
        for least in (0.004, 0.0, -0.004)
    )
    assert plan.result.full_frame.loc[10.0:].filter(like="grip_margin").min(axis=None) > -0.005
    cost = plan.active.loc["grip", "cost"].sum()
    assert cost == pytest.approx((tight.objective - wide.objective) / 0.008, rel=0.05)


def test_the_error_names_an_infeasible_grip() -> None:
    with pytest.raises(rw.InfeasibleScheduleError, match=r"grip by 0\.0[0-9]+(,|$)") as error:
        rw.optimise_schedule(slippery(0.01), 20.0, intervals=10)
    assert "grip" in error.value.colliding.index.get_level_values("limit")


def test_wrong_requests_are_typed_errors() -> None:
    line = schedule_lines.line()
    with pytest.raises(rw.InputError, match="minimise is 'comfort'"):
        rw.optimise_schedule(line, UNTIL, minimise="comfort")
    with pytest.raises(rw.InputError, match="no weight above zero"):
        rw.optimise_schedule(line, UNTIL, minimise={"energy": 0.0})
    with pytest.raises(rw.InputError, match="intervals is 2"):
        rw.optimise_schedule(line, UNTIL, intervals=2)
    with pytest.raises(rw.InputError, match="settle is 50 s"):
        rw.optimise_schedule(line, UNTIL, settle=50.0)
    with pytest.raises(rw.InputError, match="until"):
        rw.optimise_schedule(line, -1.0)
    with pytest.raises(rw.UnknownNameError, match="'s1' is not a control sheave"):
        rw.optimise_schedule(line, UNTIL, lead="s1")
    with pytest.raises(rw.InputError, match="ends at 10 s"):
        rw.optimise_schedule(
            line, UNTIL, warm_start={c: rw.Schedule((0.0, 10.0), (1.0, 1.0)) for c in ("c1", "c2", "c3")}
        )
    with pytest.raises(rw.InputError, match="no schedule of 'c2'"):
        rw.optimise_schedule(line, UNTIL, warm_start={"c1": rw.Schedule((0.0, UNTIL), (1.0, 1.0))})
    with pytest.raises(rw.InputError, match=r"warm_start\['c1'\] is 1\.0"):
        rw.optimise_schedule(line, UNTIL, warm_start=dict.fromkeys(("c1", "c2", "c3"), 1.0))
    with pytest.raises(rw.InputError, match=r"warm_start is 1\.0"):
        rw.optimise_schedule(line, UNTIL, warm_start=1.0)
    for wrong in (None, ["energy"]):
        with pytest.raises(rw.InputError, match="minimise"):
            rw.optimise_schedule(line, UNTIL, minimise=wrong)
    with pytest.raises(rw.InputError, match="nothing to optimise"):
        rw.optimise_schedule(schedule_lines.line(4, 2), UNTIL)
    with pytest.raises(rw.UnknownNameError, match="'c9' is not a control sheave"):
        rw.optimise_schedule(line, UNTIL, limits=rw.ScheduleLimits(force={"c1": 1e3, "c9": 1e3}))
    with pytest.raises(rw.InputError, match=r"limits is"):
        rw.optimise_schedule(line, UNTIL, limits={})
    with pytest.raises(rw.InputError, match=r"another system .* another"):
        rw.optimise_schedule(line, UNTIL, start=rw.equilibrium(schedule_lines.line(10)))
    with pytest.raises(rw.InputError, match="trim is"):
        rw.optimise_schedule(line, UNTIL, trim=rw.ThresholdResponse(low=40e3, high=50e3, increment=0.01))
    with pytest.raises(rw.InputError, match="its drive is ideal"):
        rw.optimise_schedule(line, UNTIL, limits=rw.ScheduleLimits(pressure=1e7))


def test_limits_with_low_above_high_are_errors() -> None:
    with pytest.raises(rw.InputError, match="tension low is 50000, high is 40000"):
        rw.ScheduleLimits(tension_low=50e3, tension_high=40e3)
    with pytest.raises(rw.InputError, match=r"speed low is 1\.2"):
        rw.ScheduleLimits(speed=(1.2, 0.8))
    for speed in (1.2, (1.2,), "ab"):
        with pytest.raises(rw.InputError, match="speed is"):
            rw.ScheduleLimits(speed=speed)
    with pytest.raises(rw.InputError, match="limits of tension are 200000 N"):
        rw.optimise_schedule(schedule_lines.line(), UNTIL, limits=rw.ScheduleLimits(tension_low=200e3))
    for wrong in ({"force": -1.0}, {"acceleration": 0.0}, {"power": {"c1": np.nan}}, {"grip": np.inf}):
        with pytest.raises(rw.InputError):
            rw.ScheduleLimits(**wrong)


def test_a_plan_has_no_values_after_its_end() -> None:
    plan = plan_of(intervals=10)
    with pytest.raises(rw.InputError, match="outside the schedule"):
        plan.at(UNTIL + 1.0)
    with pytest.raises(rw.InputError, match="ends at 40 s"):
        rw.simulate(schedule_lines.line(), UNTIL + 1.0, inputs=plan.inputs)


def test_a_schedule_from_a_wrong_file_names_file_and_line(tmp_path: object) -> None:
    path = rw.Schedule((0.0, 1.5), (1.0, 1.25)).to_csv(f"{tmp_path}/one.csv")
    assert rw.Schedule.from_csv(path) == rw.Schedule((0.0, 1.5), (1.0, 1.25))
    with pytest.raises(rw.InputError, match="line 1: no column c1"):
        rw.Schedule.from_csv(path, column="c1.speed")
    path.write_text("time,speed\n0,1\n1,fast\n")
    with pytest.raises(rw.InputError, match="line 3"):
        rw.Schedule.from_csv(path)
    with pytest.raises(rw.InputError, match="no file"):
        rw.Schedule.from_csv(f"{tmp_path}/two.csv")
