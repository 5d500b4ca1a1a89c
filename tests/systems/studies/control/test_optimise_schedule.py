"""Optimal schedules: better than constant speed in simulation, within limits, from any start."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from support import schedule_lines

UNTIL = 40.0
LIMITS = rw.ScheduleLimits(force=2.5e3, power=2.5e3)
FLAT = pd.DataFrame(
    [("a", 0.0, 0.0, 0.0, "drum"), ("c1", 90.0, 0.0, 0.0, "control"), ("c2", 180.0, 0.0, 0.0, "control"),
     ("b", 270.0, 0.0, 0.0, "drum")],
    columns=["name", "x", "y", "z", "kind"],
)  # fmt: skip


def plan_of(minimise: str | Mapping[str, float], **given: object) -> rw.SchedulePlan:
    settings = {"limits": LIMITS, "intervals": 20, "settle": 10.0, **given}
    return rw.optimise_schedule(schedule_lines.line(), UNTIL, minimise=minimise, **settings)


@pytest.fixture(scope="module")
def plans() -> dict[str, rw.SchedulePlan]:
    return {name: plan_of(name) for name in ("peak tension", "tension deviation", "energy")}


def ends(result: rw.Result, settle: float) -> np.ndarray:
    frame = result.full_frame
    return frame[frame.index >= settle].filter(regex=r"\.tension_[ab]$").to_numpy()


def test_each_objective_is_best_by_its_own_plan_and_better_than_constant_speed(
    plans: dict[str, rw.SchedulePlan],
) -> None:
    constant = rw.simulate(schedule_lines.line(), UNTIL, every=0.5)
    assert ends(plans["peak tension"].result, 10.0).max() < ends(constant, 10.0).max()
    for name, plan in plans.items():
        assert plan.objectives[name] < plan.balanced[name]
        for other in plans.values():
            assert plan.objectives[name] <= 1.005 * other.objectives[name]


@pytest.fixture(scope="module")
def from_balance() -> dict[str, rw.SchedulePlan]:
    """Plans of a line that starts in balance, with the default `settle`."""
    line = schedule_lines.line(6, 2, tension=46e3)
    start, limits = rw.balanced(line), rw.ScheduleLimits(force=1.8e3, power=1.9e3)
    return {
        name: rw.optimise_schedule(line, 36.0, minimise=name, intervals=18, start=start, limits=limits)
        for name in ("energy", "peak tension")
    }


def test_an_energy_plan_counts_the_whole_run(from_balance: dict[str, rw.SchedulePlan]) -> None:
    """Against constant speed and the work of the drives, both over the whole run."""
    plan = from_balance["energy"]
    constant = rw.simulate(plan.line, 36.0, every=0.25, start=plan.start)
    assert plan.settle == 9.0
    assert plan.objectives["energy"] == pytest.approx(plan.result.power().loc[["c1", "c2"], "pulled"].sum(), rel=1e-12)
    assert plan.constant["energy"] == pytest.approx(constant.power().loc[["c1", "c2"], "pulled"].sum(), rel=1e-3)
    assert plan.objective < plan.constant["energy"]
    assert plan.objective < from_balance["peak tension"].objectives["energy"]


def test_plans_of_a_line_in_balance_are_better_than_constant_speed_over_the_whole_run(
    from_balance: dict[str, rw.SchedulePlan],
) -> None:
    for name, plan in from_balance.items():
        constant = rw.simulate(plan.line, 36.0, every=0.25, start=plan.start)
        assert rw.objectives(plan.result)[name] <= rw.objectives(constant)[name]
        assert ends(plan.result, 0.0).max() < ends(constant, 0.0).max()


def test_limits_hold_from_the_beginning_of_a_line_in_balance(from_balance: dict[str, rw.SchedulePlan]) -> None:
    for plan in from_balance.values():
        frame = plan.result.full_frame
        assert frame.filter(regex=r"c\d\.drive_force$").abs().max(axis=None) < 1.006 * 1.8e3
        assert frame.filter(regex=r"c\d\.power$").abs().max(axis=None) < 1.006 * 1.9e3
        assert ends(plan.result, 0.0).min() > plan.tension[0] - 45.0


def test_tensions_before_settle_stay_below_those_with_balanced_sheaves(
    plans: dict[str, rw.SchedulePlan],
) -> None:
    """A line that starts out of balance: its highest tension is at the start."""
    for plan in plans.values():
        assert ends(plan.result, 0.0).max() == pytest.approx(ends(plan.result, 0.0)[0].max(), abs=50.0)
        early = plan.result.full_frame.loc[:10.0].filter(regex=r"c\d\.drive_force$").abs()
        assert early.max(axis=None) < 1.01 * early.iloc[0].max()


def test_constant_speed_is_the_plan_if_it_is_optimal() -> None:
    """Two equal level spans without loads, at rest: any change of speed raises the tension."""
    line = rw.monocable(schedule_lines.ROPE, FLAT, tension=42e3, speed=0.0)
    plan = rw.optimise_schedule(line, 16.0, intervals=8)
    assert plan.objective <= plan.constant["peak tension"]
    assert plan.objective == pytest.approx(plan.constant["peak tension"], abs=20.0)


def test_objectives_are_those_of_the_simulation(plans: dict[str, rw.SchedulePlan]) -> None:
    plan = plans["energy"]
    whole = plan.result.full_frame
    frame = whole[whole.index >= 10.0]
    pulled = sum(np.trapezoid(whole[f"{c}.power"].clip(lower=0.0), whole.index) for c in plan.schedules)
    sides = frame[[f"{c}.tension_{s}" for c in plan.schedules for s in ("in", "out")]]
    square = np.trapezoid(((sides - plan.target) ** 2).mean(axis=1), frame.index) / (UNTIL - 10.0)
    assert plan.objectives["energy"] == pytest.approx(pulled)
    assert plan.objectives["tension deviation"] == pytest.approx(np.sqrt(square))
    assert plan.objectives["peak tension"] == ends(plan.result, 10.0).max()


def test_plan_and_simulation_agree(plans: dict[str, rw.SchedulePlan]) -> None:
    for plan in plans.values():
        assert plan.gap.crossing_time < 5e-3
        assert plan.gap.peak_tension < 20.0
        assert plan.gap.crossings_in_one_only == 0
        grid = [t for t in plan.schedules["c1"].times if t > 10.0]
        columns = ["c2.tension_in", "c2_s5.tension_a", "s5.travel", "c2.drive_force", "c2.travel"]
        simulated = plan.result.frame.loc[[t in grid for t in plan.result.frame.index], columns]
        planned = plan.predicted[plan.predicted.index.isin(simulated.index)][columns].groupby(level=0).last()
        assert np.abs(planned - simulated).max().max() < 1.0


def test_settle_may_lie_between_the_times_of_the_grid() -> None:
    plan = plan_of("tension deviation", settle=11.1)
    assert plan.history.rounds[-1].planned == pytest.approx(plan.objective, rel=2e-3)


def test_limits_hold_in_the_simulation(plans: dict[str, rw.SchedulePlan]) -> None:
    for plan in plans.values():
        frame = plan.result.full_frame
        frame = frame[frame.index >= 10.0]
        tensions = ends(plan.result, 10.0)
        assert plan.tension[0] - 20.0 < tensions.min()
        assert tensions.max() < plan.tension[1]
        for name, schedule in plan.schedules.items():
            assert frame[f"{name}.drive_force"].abs().max() < 1.02 * 2.5e3
            assert frame[f"{name}.power"].abs().max() < 1.02 * 2.5e3
            speeds = np.array(schedule.speeds)
            assert speeds.min() > 0.85 - 1e-6
            assert speeds.max() < 1.15 + 1e-6
            assert np.abs(np.diff(speeds) / np.diff(schedule.times)).max() < 0.05 + 1e-6


def test_the_first_sheave_keeps_the_speed_of_the_line(plans: dict[str, rw.SchedulePlan]) -> None:
    for plan in plans.values():
        assert plan.schedules["c1"].speeds == pytest.approx([1.0] * 21)
        assert plan.schedules["c2"].speeds[0] == 1.0


def test_the_lead_keeps_its_schedule_from_any_start() -> None:
    line = schedule_lines.line(speed=rw.Schedule((0.0, 10.0, 20.0), (1.0, 1.1, 1.1)))
    constant = {name: rw.Schedule((0.0, 20.0), (1.0, 1.0)) for name in ("c1", "c2", "c3")}
    plans = [rw.optimise_schedule(line, 20.0, intervals=10, warm_start=given) for given in (None, constant)]
    for plan in plans:
        assert [plan.schedules["c1"].at(t) for t in (0.0, 6.0, 10.0, 20.0)] == pytest.approx([1.0, 1.06, 1.1, 1.1])
    assert plans[0].objective == pytest.approx(plans[1].objective, rel=1e-3)


@pytest.mark.slow
def test_three_starts_give_the_same_objective(plans: dict[str, rw.SchedulePlan]) -> None:
    times = plans["energy"].schedules["c1"].times
    waves = np.random.default_rng(3).uniform(-0.03, 0.03, 3)
    starts = (
        {name: rw.Schedule((0.0, UNTIL), (1.0, 1.0)) for name in ("c1", "c2", "c3")},
        {
            name: rw.Schedule(times, [1.0 + wave * np.sin(t / 5.0) for t in times])
            for name, wave in zip(("c1", "c2", "c3"), (0.0, *waves[:2]), strict=True)
        },
    )
    for start in starts:
        assert plan_of("energy", warm_start=start).objective == pytest.approx(plans["energy"].objective, rel=5e-3)


def test_an_earlier_plan_starts_the_next(plans: dict[str, rw.SchedulePlan]) -> None:
    again = plan_of("peak tension", warm_start=plans["peak tension"])
    assert len(again.history.rounds) == 1
    assert again.objective == pytest.approx(plans["peak tension"].objective, rel=1e-4)


def test_the_multiplier_of_a_limit_is_its_cost(plans: dict[str, rw.SchedulePlan]) -> None:
    """A tension limit just below the highest tension of the plan with least energy."""
    high = plans["energy"].objectives["peak tension"] - 150.0
    tight, less = (
        plan_of("energy", limits=rw.ScheduleLimits(force=2.5e3, power=2.5e3, tension_high=high + more))
        for more in (0.0, 4.0)
    )
    saved = (tight.history.rounds[-1].planned - less.history.rounds[-1].planned) / 4.0
    cost = tight.active.loc["tension_high", "cost"].sum()
    assert saved > 0.0
    assert cost == pytest.approx(saved, rel=0.05)


@pytest.mark.slow
def test_the_multiplier_of_a_force_limit_is_its_cost() -> None:
    """Against the central difference of simulated objectives."""
    tight, plan, wide = (
        plan_of("tension deviation", limits=rw.ScheduleLimits(force=force)) for force in (1180.0, 1200.0, 1220.0)
    )
    assert len(plan.history.rounds) <= 4
    assert plan.active.loc["force", "cost"].sum() == pytest.approx((tight.objective - wide.objective) / 40.0, rel=0.05)


def test_a_deviation_is_reached_as_planned(plans: dict[str, rw.SchedulePlan]) -> None:
    for plan in (plans["tension deviation"], plan_of("tension deviation", limits=rw.ScheduleLimits())):
        last = plan.history.rounds[-1]
        assert last.planned == pytest.approx(last.simulated, rel=0.01)
        assert len(plan.history.rounds) <= 4


def test_a_plan_has_a_one_line_representation(plans: dict[str, rw.SchedulePlan]) -> None:
    for name, plan in plans.items():
        since = "0 to 40 s" if name == "energy" else "10 to 40 s"
        unit = "kJ" if name == "energy" else "kN"
        assert repr(plan).endswith(f"over 40 s: {name} {plan.objective / 1e3:.6g} {unit} from {since}>")
        assert len(repr(plan)) < 120


def test_weights_mix_objectives(plans: dict[str, rw.SchedulePlan]) -> None:
    mixed = plan_of({"peak tension": 1.0, "energy": 0.05})
    for name in ("peak tension", "energy"):
        assert plans[name].objectives[name] <= 1.002 * mixed.objectives[name]
    assert mixed.objective == pytest.approx(mixed.objectives["peak tension"] + 0.05 * mixed.objectives["energy"])
    assert mixed.objective <= 1.002 * min(
        p.objectives["peak tension"] + 0.05 * p.objectives["energy"] for p in plans.values()
    )


def test_the_frame_holds_the_schedules(plans: dict[str, rw.SchedulePlan]) -> None:
    plan = plans["peak tension"]
    assert list(plan.frame.columns) == ["c1.speed", "c2.speed", "c3.speed"]
    assert plan.frame["c2.speed"].to_numpy() == pytest.approx(plan.schedules["c2"].speeds)
    assert plan.at(5.0)["c2"] == plan.schedules["c2"].at(5.0)
    repeated = rw.simulate(schedule_lines.line(), UNTIL, every=0.5, inputs=plan.inputs)
    assert ends(repeated, 10.0).max() == pytest.approx(plan.objectives["peak tension"], abs=1e-3)


def test_schedules_are_written_and_read_as_csv(plans: dict[str, rw.SchedulePlan], tmp_path: object) -> None:
    plan = plans["peak tension"]
    path = plan.to_csv(f"{tmp_path}/plan.csv")
    assert rw.Schedule.from_csv(path, column="c2.speed") == plan.schedules["c2"]


def test_the_figure_of_a_plan(plans: dict[str, rw.SchedulePlan]) -> None:
    plan = plans["peak tension"]
    figure = plan.plot()
    speeds, tensions, forces = figure.axes
    for axis in (speeds, forces):
        assert {"c1", "c2", "c3"} <= {text.get_text() for text in axis.get_legend().get_texts()}
    assert "limit 2.50 kN" in {line.get_label() for line in forces.lines}
    assert f"peak tension {plan.objective / 1e3:.6g} kN from 10 to 40 s" in figure.get_suptitle()
    red = [line for axis in figure.axes for line in axis.lines if line.get_color() == "tab:red" and axis is tensions]
    assert red
    for line in red:
        value = plan.tension["allowed" in line.get_label() and line.get_label().startswith("most")] / 1e3
        assert line.get_ydata() == pytest.approx([value, value])
        assert line.get_label().startswith(("least allowed", "most allowed"))
