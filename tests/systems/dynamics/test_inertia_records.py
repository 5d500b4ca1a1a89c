"""What runs with inertia write down: peaks between the rows, and states of spans that come to hold more loads."""

from __future__ import annotations

import numpy as np
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24.026e6, breaking_load=450e3, diameter=0.0254)


def line(speed: float, last: rw.Drum, spacing: float) -> rw.System:
    """Three spans of 90 m."""
    s = rw.System("line")
    idlers = [rw.Sheave(f"s{k}", at=(90.0 * k, 2.0), inertia=100.0) for k in (1, 2)]
    rope = s.string(ROPE, rw.Drum("d", at=(0.0, 0.0), speed=speed), *idlers, last, length=270.1)
    s.feed(rope, spacing=spacing, masses=(300.0, 420.0))
    return s


@pytest.mark.parametrize("compiled", [False, True])
def test_peaks_do_not_depend_on_the_interval(compiled: bool) -> None:
    """Of a stop and of a load that is lost."""
    system = line(2.0, rw.Drum("e", at=(270.0, 0.0), tension=90e3, inertia=100.0), 38.0)
    acts = [rw.Intervention(1.3, "emergency stop", deceleration=4.0), rw.Intervention(2.71, "load lost", "l2")]
    fine, coarse = (
        rw.simulate(
            system, 6.0, every=every, inertia=rw.Inertia(), interventions=acts, tolerance=1e-5, compiled=compiled
        )
        for every in (0.004, 3.0)
    )
    peaks, exact = coarse.dynamic_factor(), fine.dynamic_factor()
    ropes = exact["kind"] == "rope"
    rows = coarse.frame.filter(regex=r"utilisation$").max().max() * ROPE.breaking_load
    assert rows < 0.97 * exact.loc[ropes, "highest"].max()
    assert peaks.loc[ropes, "highest"].to_numpy() == pytest.approx(exact.loc[ropes, "highest"].to_numpy(), rel=1e-3)
    assert peaks["highest"].to_numpy() == pytest.approx(exact["highest"].to_numpy(), rel=1e-2)
    assert peaks.loc[ropes, "at"].to_numpy() == pytest.approx(exact.loc[ropes, "at"].to_numpy(), abs=0.02)
    tautness = [result.full_frame.filter(regex=r"tautness$").min().to_numpy() for result in (coarse, fine)]
    assert tautness[0] == pytest.approx(tautness[1], rel=2e-3)
    assert np.all(np.diff(coarse.times) >= 0.0)
    assert coarse.frame.index.tolist() == [0.0, 3.0, 6.0]
    assert coarse.certificate["holds"].all()


@pytest.mark.parametrize("compiled", [False, True])
def test_a_span_comes_to_hold_more_loads(compiled: bool) -> None:
    """One drum pays out more than the other takes in: a span has a place more for loads than at the start."""
    system = line(2.0, rw.Drum("e", at=(270.0, 0.0), speed=1.0), 30.2)
    result = rw.simulate(system, 12.0, every=0.5, inertia=rw.Inertia(), tolerance=1e-5, compiled=compiled)
    at_start = rw.simulate(system, 0.1, every=0.1, inertia=rw.Inertia(), tolerance=1e-5, compiled=compiled)
    assert len(result.records[0].x) > len(at_start.records[0].x)
    assert result.certificate["holds"].all()
    first, same = result.at(0.0), at_start.at(0.0)
    assert first["d_s1.tension_a"] == pytest.approx(same["d_s1.tension_a"], rel=1e-9)
    rest = rw.simulate(system, 2.0, every=0.5, start=result.at(10.0), inertia=rw.Inertia(), tolerance=1e-5)
    ends = [r.frame.filter(regex=r"\.tension_[ab]$").iloc[-1].to_numpy() for r in (result, rest)]
    assert ends[0] == pytest.approx(ends[1], rel=2e-3)
