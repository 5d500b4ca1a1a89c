"""Successive plans, and the line that follows them."""

import numpy as np
import pytest

import ropeway as rw
from support import schedule_lines

UNTIL = 60.0


@pytest.fixture(scope="module")
def driven() -> rw.RecedingHorizon:
    line = schedule_lines.line()
    limits = rw.ScheduleLimits(force=3e3, power=3e3)
    return rw.receding_horizon(
        line, UNTIL, horizon=40.0, every=20.0, intervals=20, limits=limits, start=rw.balanced(line)
    )


@pytest.mark.slow
def test_each_plan_begins_at_the_state_of_the_line(driven: rw.RecedingHorizon) -> None:
    assert driven.begins == (0.0, 20.0, 40.0)
    for begin, plan in zip(driven.begins, driven.plans, strict=True):
        for name, schedule in driven.schedules.items():
            assert schedule.at(begin) == pytest.approx(plan.schedules[name].speeds[0])
            assert schedule.at(begin + 7.0) == pytest.approx(plan.schedules[name].at(7.0))
        for travel in ("c2.travel", "s3.travel", "s5.travel"):
            planned = plan.result.full_frame[travel].iloc[0]
            assert driven.result.at(begin)[travel] == pytest.approx(planned, abs=1e-5)


@pytest.mark.slow
def test_the_line_keeps_its_limits_throughout(driven: rw.RecedingHorizon) -> None:
    frame = driven.result.full_frame.loc[10.0:]
    for name in ("c1", "c2", "c3"):
        assert frame[f"{name}.drive_force"].abs().max() < 1.02 * 3e3
    low = driven.plans[0].tension[0]
    assert frame.filter(regex=r"\.tension_[ab]$").min(axis=None) > low - 20.0
    assert len(driven.history) == 3


@pytest.mark.slow
def test_it_is_better_than_constant_speed(driven: rw.RecedingHorizon) -> None:
    constant = rw.simulate(schedule_lines.line(), UNTIL, every=0.5, start=rw.balanced(schedule_lines.line()))
    found, other = (rw.objectives(r, settle=10.0) for r in (driven.result, constant))
    assert found["peak tension"] < other["peak tension"]
    assert np.isfinite(driven.result.outputs).all()


def test_the_lead_keeps_the_lines_own_schedule() -> None:
    line = schedule_lines.line(4, 1, speed=rw.Schedule((0.0, 20.0, 25.0), (1.0, 1.1, 1.1)))
    limits = rw.ScheduleLimits(speed=(0.8, 1.2), acceleration=0.1)
    driven = rw.receding_horizon(line, 20.0, horizon=10.0, every=10.0, intervals=5, settle=2.0, limits=limits)
    assert [driven.schedules["c1"].at(t) for t in (0.0, 6.0, 10.0, 14.0, 20.0)] == pytest.approx(
        [1.0, 1.03, 1.05, 1.07, 1.1]
    )
    assert repr(driven) == "<RecedingHorizon of 'mono-cable line' over 20 s: 2 plans>"


def test_a_schedule_that_ends_before_the_run_is_an_error() -> None:
    line = schedule_lines.line(speed=rw.Schedule((0.0, 30.0), (1.0, 1.1)))
    with pytest.raises(rw.InputError, match="ends at 30 s"):
        rw.receding_horizon(line, 60.0, horizon=20.0, every=20.0)


def test_wrong_times_are_errors() -> None:
    line = schedule_lines.line()
    with pytest.raises(rw.InputError, match="whole number of intervals"):
        rw.receding_horizon(line, 60.0, horizon=40.0, every=15.0, intervals=20)
    with pytest.raises(rw.InputError, match="whole number of intervals"):
        rw.receding_horizon(line, 60.0, horizon=40.0, every=50.0, intervals=20)
    with pytest.raises(rw.InputError, match="horizon"):
        rw.receding_horizon(line, 60.0, horizon=0.0, every=10.0)
    with pytest.raises(rw.InputError, match="intervals is 0"):
        rw.receding_horizon(line, 60.0, horizon=40.0, every=10.0, intervals=0)
