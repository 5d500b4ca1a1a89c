"""A resumed run continues the run it starts from: clocks, queued decisions, brakes, an emergency stop."""

from __future__ import annotations

import pickle
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

import ropeway as rw
from support.drives import hydraulic_drive

ROPE = rw.Rope(mass_per_length=3.2, axial_stiffness=31e6, breaking_load=540e3)
LINE = Path(__file__).resolve().parents[3] / "examples" / "line.csv"
UNTIL = 24.0
STEADY = {"low": 43e3, "high": 58e3, "increment": 0.012}
RESPONSES = {
    "threshold that waits": rw.ThresholdResponse(**STEADY, period=0.8, delay=1.9, hold=1.6),
    "threshold that goes back": rw.ThresholdResponse(**STEADY, period=1.5, hold=0.0),
    "proportional with a target": rw.ProportionalResponse(gain=1.5e-6, target=50e3, period=0.6, delay=0.9),
    "proportional": rw.ProportionalResponse(gain=2.5e-6, period=1.1, rate=0.01),
}
DRIVE = hydraulic_drive(displacement=1.1e-4, relief_pressure=240e5, pump_flow=8e-3, engine_power=40e3, inertia=900.0)


def line(response: rw.Response | None = None, drive: rw.Drive | None = None, **more: object) -> rw.System:
    settings = {"load_mass": (280.0, 190.0, 400.0), "load_spacing": 42.0, **more}
    return rw.monocable(ROPE, LINE, tension=48e3, response=response, drive=drive, **settings)


@lru_cache(maxsize=16)
def whole(rule: str, *, hydraulic: bool = False) -> rw.Result:
    return rw.simulate(line(RESPONSES[rule], DRIVE if hydraulic else None), UNTIL)


def tensions(result: rw.Result) -> np.ndarray:
    return result.frame.filter(regex=r"\.tension_(in|out)$").iloc[-1].to_numpy()


def rest(start: rw.Equilibrium, time: float, **more: object) -> rw.Result:
    return rw.simulate(start.model, UNTIL - time, start=start, **more)


@pytest.mark.parametrize("rule", RESPONSES)
@pytest.mark.parametrize("time", [4.0, 9.37])
def test_a_resumed_run_ends_like_the_whole_run(rule: str, time: float) -> None:
    result = whole(rule)
    resumed = rest(result.at(time), time)
    assert tensions(resumed) == pytest.approx(tensions(result), rel=1e-9)
    ours = [(e.time + time, e.component, e.event) for e in resumed.noted]
    theirs = [(e.time, e.component, e.event) for e in result.noted if e.time > time]
    assert [e[1:] for e in ours] == [e[1:] for e in theirs]
    assert [e[0] for e in ours] == pytest.approx([e[0] for e in theirs], abs=1e-6)


def test_drives_with_inertia_are_resumed() -> None:
    result = whole("threshold that waits", hydraulic=True)
    for time in (7.0, 11.13):
        assert tensions(rest(result.at(time), time)) == pytest.approx(tensions(result), rel=1e-6)


def test_a_resumed_run_can_be_resumed_and_pickled() -> None:
    result = whole("threshold that waits")
    first = rest(result.at(6.21), 6.21)
    start = pickle.loads(pickle.dumps(first.at(5.4).pending))
    assert start == first.at(5.4).pending
    second = rest(first.at(5.4), 6.21 + 5.4)
    assert tensions(second) == pytest.approx(tensions(result), rel=1e-9)


def test_a_tick_between_records_is_kept() -> None:
    """No response acts: only the queue and the time without need change."""
    calm = rw.ThresholdResponse(low=1.0, high=500e3, increment=0.01, period=0.7, delay=0.4)
    result = rw.simulate(line(calm), 5.0, every=5.0)
    assert result.at(2.2)["c1.response_calm"] == pytest.approx(2.1)
    assert result.at(0.6)["c1.response_calm"] == 0.0
    assert dict(result.at(2.2).pending.ticks) == pytest.approx({(0.7, 0.7): 0.6, (0.7, 1.1): 0.3})


def test_brakes_and_an_emergency_stop_are_resumed() -> None:
    schedule = rw.Schedule((0.0, 30.0), (0.9, 1.4))
    acts = [rw.Intervention(3.0, "brake", "c2"), rw.Intervention(8.0, "emergency stop", deceleration=0.2)]
    system = line(RESPONSES["proportional"], speed=schedule)
    result = rw.simulate(system, 15.0, interventions=acts)
    for time in (5.5, 9.31, 14.0):
        left = 15.0 - time
        speeds = {f"{c}.speed": schedule.later(time, left) for c in ("c1", "c2", "c3", "c4")} if time < 8.0 else {}
        later = [rw.Intervention(8.0 - time, "emergency stop", deceleration=0.2)] if time < 8.0 else []
        resumed = rw.simulate(system, left, start=result.at(time), inputs=speeds, interventions=later)
        assert tensions(resumed) == pytest.approx(tensions(result), rel=1e-9)
        assert resumed.frame["c1.travel"].iloc[-1] == pytest.approx(result.frame["c1.travel"].iloc[-1], abs=1e-9)
    again = rw.simulate(
        system, 4.0, start=result.at(14.0), inputs=dict.fromkeys(("c1.speed", "c2.speed", "c3.speed", "c4.speed"), 1.0)
    )
    assert again.frame["c1.travel"].iloc[-1] > result.frame["c1.travel"].iloc[-1] + 3.0
    assert again.events["event"].eq("response").any()


@pytest.mark.parametrize("inertia", [None, rw.Inertia()])
def test_the_stop_of_one_drive_is_resumed(inertia: rw.Inertia | None) -> None:
    at = [(90.0 * k, -2.0 * abs(k - 2)) for k in range(5)]
    s, response = rw.System("line"), rw.ProportionalResponse(gain=2e-6, period=0.2)
    nodes = [
        rw.Drum("d", at=at[0], speed=1.0),
        rw.Sheave("s1", at=at[1], inertia=100.0),
        rw.ControlSheave("c", at=at[2], speed=1.0, response=response),
        rw.Sheave("s3", at=at[3], inertia=100.0),
        rw.Drum("e", at=at[4], tension=90e3, inertia=100.0),
    ]
    s.feed(s.string(ROPE, *nodes, tension=90e3), spacing=38.0, masses=(300.0,))
    stop = rw.Intervention(0.5, "stop", "c", deceleration=2.0)
    result = rw.simulate(s, 1.5, every=0.25, inertia=inertia, interventions=[stop])
    travel = result.frame["c.travel"]
    speed = (travel.loc[0.5] - travel.loc[0.25]) / 0.25
    # From its speed to rest at this deceleration, and no response any more; the other drive runs on.
    assert travel.loc[1.25] - travel.loc[0.5] == pytest.approx(speed**2 / 4.0, abs=0.02)
    assert travel.loc[1.5] == travel.loc[1.25]
    assert result.frame["d.travel"].loc[1.5] == pytest.approx(1.5)
    assert "response" not in set(result.events["event"][result.events["time"] > 0.5])
    again = rw.simulate(s, 0.75, every=0.25, start=result.at(0.75), inertia=inertia).frame
    for column in ("c.travel", "c.tension_in", "c.tension_out"):
        assert again[column].to_numpy() == pytest.approx(result.frame[column].loc[0.75:].to_numpy(), rel=1e-4)


def test_memory_of_results_is_released() -> None:
    result = whole("threshold that waits")
    here = result.at(13.3)
    assert here["c1.correction"] != 0.0
    calm = rw.equilibrium(here.model, start=here)
    assert calm["c1.correction"] == calm["c1.response_target"] == 0.0
    assert calm.pending == rw.equilibrium(here.model).pending
    # A different response begins anew; the same one continues.
    other = rw.simulate(line(RESPONSES["proportional"]), 1.0, start=here)
    assert other.at(0.0)["c1.correction"] == 0.0
    faster = line(RESPONSES["threshold that waits"], speed=1.2)
    same = rw.simulate(faster, 1.0, start=here)
    assert same.at(0.0)["c1.correction"] == here["c1.correction"]
    assert same.at(0.0).pending == here.pending
    without = rw.simulate(line(), 1.0, start=here).frame["c1.travel"]
    assert without.iloc[-1] == pytest.approx(here["c1.travel"] + 1.0, abs=1e-9)
