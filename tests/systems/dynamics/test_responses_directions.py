"""Direction of the effects of increment, initiation, period, delay and precedence of responses on a line.

The line is that of examples/turk_responses.py: 24 spans, loads of unequal mass, outside its tension range at the start.
"""

from collections import defaultdict
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from support.drives import hydraulic_drive

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
LINE = Path(__file__).resolve().parents[3] / "examples" / "line.csv"
MASSES = (300.0, 100.0, 500.0, 200.0, 600.0, 0.0, 450.0)
LOW, HIGH, SETTLED = 44e3, 66e3, 100.0
BASE = {"increment": 0.005, "period": 1.0, "delay": 0.0, "initiation": -2e3, "hold": 3.0}
FOREVER = 1e3
"""A hold so long that no sheave returns by itself: every response is then a granted action."""
DRIVE = hydraulic_drive(displacement=45e-6, pump_flow=2.4e-3, engine_power=30e3)
SHEAVES = ("c1", "c2", "c3", "c4")


def simulate(until: float, **settings: Any) -> rw.Result:
    line = rw.monocable(ROPE, LINE, tension=45e3, load_mass=MASSES, load_spacing=50.0, **settings)
    return rw.simulate(line, until=until)


@lru_cache(maxsize=64)
def run(until: float, precedence: str = "all at once", *, hydraulic: bool = False, **change: float) -> rw.Result:
    response = rw.ThresholdResponse(low=LOW, high=HIGH, **{**BASE, **change})
    return simulate(until, response=response, precedence=precedence, drive=DRIVE if hydraulic else None)


def tensions(result: rw.Result, since: float = 0.0, until: float = np.inf) -> pd.DataFrame:
    """Tensions at the control sheaves, on both sides of every event."""
    frame = result.full_frame.filter(regex=r"^c\d\.tension_(in|out)$")
    return frame[(frame.index >= since) & (frame.index <= until)]


def outside(result: rw.Result, until: float = np.inf) -> float:
    """Time with a tension outside the range [s]."""
    frame = tensions(result, until=until)
    return float(np.trapezoid(((frame > HIGH) | (frame < LOW)).any(axis=1).astype(float), frame.index))


def actions(result: rw.Result) -> dict[float, list[str]]:
    """The sheaves that acted at each sample."""
    found = defaultdict(list)
    for event in result.events.query("event == 'response'").itertuples():
        found[event.time].append(event.component)
    return dict(found)


def rises(values: list[float], by: float) -> bool:
    """Whether each value exceeds the previous one by a factor."""
    return all(b > by * a for a, b in pairwise(values))


@pytest.mark.parametrize("hydraulic", [False, True])
def test_responses_keep_the_line_in_its_range(hydraulic: bool) -> None:
    without = simulate(300.0)
    assert tensions(without, SETTLED).max(axis=None) > HIGH + 10e3
    assert outside(without) > 290.0
    result = run(300.0, hydraulic=hydraulic)
    assert tensions(result).max(axis=None) > HIGH + 10e3
    settled = tensions(result, SETTLED)
    assert settled.max(axis=None) < HIGH
    assert settled.min(axis=None) > LOW
    rows = result.summary().supports.loc[list(SHEAVES), "time_outside_range"]
    assert rows.max() - 1e-6 <= outside(result) <= rows.sum() + 1e-6


def test_a_larger_increment_acts_faster() -> None:
    times = [outside(run(60.0, increment=i), until=60.0) for i in (0.02, 0.01, 0.005, 0.002)]
    assert rises(times, 1.2)


def test_a_later_initiation_lets_tension_rise_higher() -> None:
    peaks = [tensions(run(300.0, initiation=i), SETTLED).max(axis=None) for i in (-2e3, 0.0, 2e3)]
    assert np.diff(peaks).min() > 1e3
    for initiation, peak in zip((-2e3, 0.0, 2e3), peaks, strict=True):
        assert peak == pytest.approx(HIGH + initiation, abs=1e3)


def test_a_longer_period_is_slower() -> None:
    for increment in (0.005, 0.01):
        times = [outside(run(60.0, increment=increment, period=p), until=60.0) for p in (1.0, 2.0, 4.0)]
        assert rises(times, 1.2)


def test_a_longer_delay_overshoots() -> None:
    # A response makes tension control the second derivative of tension: two integrations, damped only by the return.
    # The delay reduces that damping; the smallest increment shows it before every line oscillates.
    results = [run(300.0, increment=0.002, delay=d) for d in (0.0, 3.0, 6.0)]
    swings = [np.ptp(tensions(r, SETTLED).to_numpy()) for r in results]
    assert rises(swings, 1.2)
    assert rises([outside(r) for r in results], 1.2)
    assert tensions(results[0], SETTLED).max(axis=None) < HIGH < tensions(results[1], SETTLED).max(axis=None)


def test_the_delay_is_from_sample_to_effect() -> None:
    prompt, late = (actions(run(60.0, increment=0.002, delay=d)) for d in (0.0, 3.0))
    assert min(prompt) == pytest.approx(1.0)
    assert min(late) == pytest.approx(4.0)
    assert sorted(prompt[min(prompt)]) == sorted(late[min(late)])


def needs(result: rw.Result, time: float, initiation: float) -> dict[str, float]:
    """Excess over the initiation of each sheave that wants to act at a sample, before any acts [N]."""
    row = result.full_frame.loc[[time]].iloc[0]
    found = {}
    for name in SHEAVES:
        both = row[[f"{name}.tension_in", f"{name}.tension_out"]]
        found[name] = max(both.max() - HIGH, LOW - both.min()) - initiation
    return {name: need for name, need in found.items() if need > 0.0}


def expected(precedence: str, need: dict[str, float]) -> set[str]:
    """Sheaves with permission to act."""
    want = list(need)
    if precedence == "all at once" or not want:
        return set(want)
    if precedence == "neighbours locked out":
        places = {name: SHEAVES.index(name) for name in want}
        return {a for a in want if all(need[a] >= need[b] for b in want if abs(places[a] - places[b]) == 1)}
    chosen = {"upstream first": want[0], "downstream first": want[-1], "worst first": max(want, key=need.__getitem__)}
    return {chosen[precedence]}


@pytest.mark.parametrize(
    "precedence", ["all at once", "upstream first", "downstream first", "worst first", "neighbours locked out"]
)
def test_precedence_selects_the_sheaves_that_act(precedence: str) -> None:
    # At 35 s no sheave is at the limit of its correction, where an action has no effect.
    result = run(35.0, precedence, hold=FOREVER)
    acted = actions(result)
    for time in np.arange(1.0, 35.5):
        assert set(acted.get(time, [])) == expected(precedence, needs(result, time, BASE["initiation"])), time
    counts = {len(names) for names in acted.values()}
    if precedence == "all at once":
        assert max(counts) >= 3
    elif precedence == "neighbours locked out":
        assert max(counts) == 2
    else:
        assert counts == {1}


def test_worst_first_acts_with_fewer_sheaves_and_takes_longer() -> None:
    rules = {"increment": 0.01, "period": 2.0, "hold": FOREVER}
    once, worst = (run(20.0, p, **rules) for p in ("all at once", "worst first"))
    assert sum(map(len, actions(once).values())) > 1.5 * sum(map(len, actions(worst).values()))
    rules["hold"] = BASE["hold"]
    once, worst = (run(60.0, p, **rules) for p in ("all at once", "worst first"))
    assert outside(worst, until=60.0) > 1.5 * outside(once, until=60.0)


def test_neighbours_never_act_together_when_locked_out() -> None:
    for period in (1.0, 2.0):
        acted = actions(run(100.0, "neighbours locked out", period=period, hold=FOREVER))
        assert len(acted) > 20
        for names in acted.values():
            places = sorted(SHEAVES.index(name) for name in names)
            assert min(np.diff(places), default=2) > 1


def test_downstream_first_may_never_reach_the_first_sheave() -> None:
    # With an increment and period that suit all four at once, the sheaves after c1 keep requesting: each overshoots
    # while it waits, and then requests the reverse. So c1 behaves as without a response.
    result, without = run(100.0, "downstream first", increment=0.01, period=2.0), simulate(100.0)
    assert "c1" not in {name for names in actions(result).values() for name in names}
    assert tensions(result)["c1.tension_out"].max() == pytest.approx(
        tensions(without)["c1.tension_out"].max(), rel=1e-6
    )
