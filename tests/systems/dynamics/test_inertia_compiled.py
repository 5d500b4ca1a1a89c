"""Runs with inertia in compiled code are the runs with IDAS."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.dynamics.result import Result
from support.drives import hydraulic_drive
from support.fmus import corridor
from support.held_carriage import held_carriage

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24.026e6, breaking_load=450e3, diameter=0.0254)
TIGHT: dict[str, Any] = {"tolerance": 1e-7, "inertia": rw.Inertia()}


def fed_line(speed: float | rw.Schedule, spans: int = 3) -> rw.System:
    """Spans of 90 m with loads every 38 m over rough idlers, and a tension kept at the end."""
    points = [(90.0 * k, 3.0 * k, -0.04 * (k - spans / 2) ** 2) for k in range(spans + 1)]
    s = rw.System("fed")
    idlers = [rw.Sheave(f"s{k}", at=points[k], inertia=100.0, friction=0.01) for k in range(1, spans)]
    ends = rw.Drum("d", at=points[0], speed=speed), rw.Drum("e", at=points[-1], tension=90e3, inertia=100.0)
    rope = s.string(ROPE, ends[0], *idlers, ends[1], length=90.0 * spans * 0.9995)
    s.feed(rope, spacing=38.0, masses=(300.0, 420.0, 350.0))
    return s


def windy_span() -> rw.System:
    """A span with two loads, which the wind sees."""
    s = rw.System("windy")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(240.0, 0.0)), length=240.55)
    for name, at in (("turn", 120.0), ("log", 100.0)):
        s.hang(rw.Load(name, mass=500.0, drag_area=4.0), span, at=at)
    return s


def endless_line() -> rw.System:
    rows = {"name": ["d", "s1", "r", "s2"], "x": [0, 100, 200, 100], "y": [0, 2, 0, -2], "z": [0.0, 6.0, 0.0, 6.0]}
    table = pd.DataFrame({**rows, "kind": ["control", "idler", "return", "idler"]})
    return rw.endless(ROPE, table, tension=40e3, speed=1.5, load_mass=200.0, load_spacing=40.0)


def hydraulic_line() -> rw.System:
    """A line with hydraulic drives that respond to the tensions beside them."""
    s, points = rw.System("hydraulic"), [(90.0 * k, -0.04 * (k - 2) ** 2) for k in range(5)]
    response = rw.ProportionalResponse(gain=1e-5, limit=0.1)
    middle = [
        rw.ControlSheave(f"c{k}", at=points[k], speed=1.0, drive=hydraulic_drive(friction=0.01), response=response)
        for k in (1, 2, 3)
    ]
    ends = rw.Drum("d", at=points[0], speed=1.0), rw.Drum("e", at=points[-1], tension=45e3, inertia=100.0)
    chords = sum(float(np.hypot(90.0, b[1] - a[1])) for a, b in pairwise(points))
    rope = s.string(ROPE, ends[0], *middle, ends[1], length=chords)
    s.feed(rope, spacing=38.0, masses=(300.0,))
    return s


def both(system: rw.System, until: float, **more: Any) -> tuple[Result, Result]:
    """The same run with IDAS and in compiled code."""
    found = [rw.simulate(system, until, compiled=compiled, **{**TIGHT, **more}) for compiled in (False, True)]
    return found[0], found[1]


def apart(runs: tuple[Result, Result]) -> float:
    """Largest difference of tensions, relative to the highest one."""
    one, other = (run.frame.filter(like="tension").to_numpy() for run in runs)
    return float(np.abs(one - other).max() / np.abs(one).max())


def test_loads_cross_supports_as_with_idas() -> None:
    there_and_back = rw.Schedule((0.0, 8.0, 9.0, 30.0), (2.0, 2.0, -2.0, -2.0))
    runs = both(fed_line(there_and_back), 13.0)
    assert apart(runs) < 5e-6
    one, other = (run.events for run in runs)
    assert one[["component", "event", "load"]].equals(other[["component", "event", "load"]])
    assert one["event"].tolist() == ["crossing forward", "crossing backward"]
    assert np.abs(one["time"] - other["time"]).max() < 1e-6
    kept, other_kept = (run.energy() for run in runs)
    assert other_kept["residual"] == pytest.approx(kept["residual"], abs=1e-3 * abs(kept["ends"]))


@pytest.mark.slow
def test_a_load_lost_with_rope_nodes_is_that_of_idas() -> None:
    lost = [rw.Intervention(0.2, "load lost", "log")]
    wind = rw.Environment("wind", wind_pressure=300.0, wind_from=0.0)
    inertia = rw.Inertia(nodes=1, damping=0.0)
    assert apart(both(windy_span(), 2.0, every=0.25, interventions=lost, inertia=inertia, environment=wind)) < 1e-5


def test_an_endless_line_is_that_of_idas() -> None:
    assert apart(both(endless_line(), 6.0)) < 1e-5


def test_hydraulic_drives_stop_as_with_idas() -> None:
    stop = [rw.Intervention(0.5, "emergency stop", deceleration=1.0)]
    runs = both(hydraulic_line(), 2.0, every=0.5, interventions=stop, tolerance=1e-6)
    assert apart(runs) < 1e-4
    assert runs[1].frame["c2.rope_speed"].iloc[-1] < 0.5


def test_a_payload_dropped_from_a_carriage_is_that_of_idas() -> None:
    system, rest = held_carriage(ROPE)
    drop = [rw.Intervention(0.5, "payload dropped", "carriage")]
    assert apart(both(system, 2.0, every=0.25, start=rest, interventions=drop)) < 1e-6


def test_a_carriage_on_a_shoe_is_that_of_idas() -> None:
    """Its ropes leave beside its place."""
    ramp = rw.Schedule((0.0, 0.2, 0.4, 1.0), (0.0, 0.0, 0.3, 0.3))
    runs = both(corridor().system(0, on=0, payload=1500.0), 0.6, every=0.2, inputs={"mainline.speed": ramp})
    assert apart(runs) < 1e-6
    x = runs[1].frame["carriage.x"].to_numpy()
    assert x == pytest.approx(runs[0].frame["carriage.x"].to_numpy(), abs=1e-6)
    assert x[-1] > x[0] + 0.05


def test_the_result_depends_neither_on_the_interval_nor_on_the_tolerance() -> None:
    line = fed_line(rw.Schedule((0.0, 1.0, 1.5, 20.0), (1.5, 1.5, 0.0, 0.0)))
    start = rw.equilibrium(line)

    def run(every: float, tolerance: float) -> np.ndarray:
        result = rw.simulate(
            line, 3.0, every=every, start=start, inertia=rw.Inertia(), tolerance=tolerance, compiled=True
        )
        return result.frame["s1_s2.tension_a"].loc[[0.0, 1.0, 2.0, 3.0]].to_numpy()

    best = run(1.0, 1e-9)
    assert run(0.05, 1e-9) == pytest.approx(best, rel=1e-6)
    errors = [np.abs(run(1.0, tolerance) - best).max() for tolerance in (1e-3, 1e-5)]
    assert errors[1] < min(errors[0] / 50.0, 2.0)


def test_a_run_continues_from_any_time() -> None:
    line = fed_line(1.5)
    whole = rw.simulate(line, 6.0, compiled=True, **TIGHT)
    rest = rw.simulate(line, 3.0, start=whole.at(3.0), compiled=True, **TIGHT)
    assert rest.frame["d_s1.tension_a"].iloc[-1] == pytest.approx(whole.frame["d_s1.tension_a"].iloc[-1], abs=5.0)


def test_a_gust_is_that_of_idas() -> None:
    pressure = rw.Schedule((0.0, 0.5, 1.0, 9.0), (0.0, 300.0, 0.0, 0.0))  # it rises from nothing
    gust = rw.Environment("gust", wind_pressure=pressure, wind_from=0.0)
    runs = both(windy_span(), 2.0, every=0.25, environment=gust, inertia=rw.Inertia(nodes=1, damping=0.0))
    assert apart(runs) < 1e-5
    aside = [run.at(2.0)["turn.velocity_y"] for run in runs]
    assert aside[1] == pytest.approx(aside[0], rel=1e-4)
    assert abs(aside[0]) > 0.1


def test_drives_that_share_a_power_unit_are_refused() -> None:
    line = hydraulic_line()
    unit = line.add(rw.HydraulicPowerUnit("unit", pump_flow=12e-3, engine_power=80e3))
    line.connect(line.components["c1"].supply, unit.outlet)
    with pytest.raises(rw.CompiledError, match="share a power unit"):
        rw.simulate(line, 1.0, inertia=rw.Inertia(), compiled=True)
