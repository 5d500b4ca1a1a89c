"""Runs with inertia against independent programs, closed forms and the quasi-static line.

Numbers of the dropped load are of MoorDyn 2.7 (80 segments) and of a chain of 400 springs, which agree to 1e-4; those
of the emergency stop are of a separate program with the same catenaries.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.special import ellipk

import ropeway as rw
from ropeway.components.node import Node
from ropeway.systems.dynamics.result import Result
from support.drives import hydraulic_drive
from support.held_carriage import held_carriage

LINE = Path(__file__).resolve().parents[3] / "examples" / "line.csv"

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24.026e6, breaking_load=450e3)
UNDAMPED = rw.Inertia(damping=0.0)


def level_span(masses: Sequence[float]) -> rw.System:
    """A level span of 240 m, with loads at its middle."""
    s = rw.System("level")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(240.0, 0.0)), length=240.55)
    for i, mass in enumerate(masses):
        s.hang(rw.Load(f"part{i}", mass=mass), span, at=120.275)
    return s


def stop_line(*, kept: bool, speed: float = 2.0) -> rw.System:
    """Five spans of 200 m with two loads each, driven at both ends or with a tension kept at the last one."""
    points = [(200.0 * k, -0.2 * (k - 2.5) ** 2) for k in range(6)]
    s = rw.System("stop")
    last = (
        rw.Drum("d5", at=points[5], tension=100e3, inertia=100.0) if kept else rw.Drum("d5", at=points[5], speed=speed)
    )
    idlers = [rw.Sheave(f"s{k}", at=points[k], inertia=100.0) for k in range(1, 5)]
    chords = sum(float(np.hypot(200.0, b[1] - a[1])) for a, b in pairwise(points))
    spans = s.string(ROPE, rw.Drum("d0", at=points[0], speed=speed), *idlers, last, length=0.999 * chords)
    for k in range(5):
        for j, x in enumerate((49.0, 149.0)):
            s.hang(rw.Load(f"l{k}{j}", mass=500.0), spans, at=200.0 * k + x)
    return s


def fed_line(speed: float | rw.Schedule, spans: int = 3) -> rw.System:
    """Spans of 90 m with loads every 38 m, and a tension kept at the end."""
    points = [(90.0 * k, 3.0 * k, -0.04 * (k - spans / 2) ** 2) for k in range(spans + 1)]
    s = rw.System("fed")
    idlers = [rw.Sheave(f"s{k}", at=points[k], inertia=100.0) for k in range(1, spans)]
    ends = rw.Drum("d", at=points[0], speed=speed), rw.Drum("e", at=points[-1], tension=90e3, inertia=100.0)
    rope = s.string(ROPE, ends[0], *idlers, ends[1], length=90.0 * spans * 0.9995)
    s.feed(rope, spacing=38.0, masses=(300.0, 420.0, 350.0))
    return s


def mechanical(result: Result) -> np.ndarray:
    """Energy of rope and loads at all records [J]."""
    energies = [
        result.full_frame.filter(regex=f"{kind}_energy$").sum(axis=1) for kind in ("elastic", "gravity", "kinetic")
    ]
    return np.asarray(sum(e.to_numpy() for e in energies))


def tensions(result: Result) -> np.ndarray:
    """Tensions at all span ends at all records [N]."""
    return result.full_frame.filter(regex="tension_[ab]$").to_numpy()


def period(times: np.ndarray, values: np.ndarray) -> float:
    """Mean time between upward passages of zero."""
    up = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    at = times[up] - values[up] * (times[up + 1] - times[up]) / (values[up + 1] - values[up])
    return float((at[-1] - at[0]) / (len(at) - 1))


@pytest.mark.parametrize("nodes", [0, 3])
def test_rest_is_the_equilibrium(nodes: int) -> None:
    system = level_span([2950.0])
    rest = rw.equilibrium(system)
    result = rw.simulate(system, 3.0, start=rest, inertia=rw.Inertia(nodes=nodes))
    assert result.frame["a_b.tension_a"].to_numpy() == pytest.approx(rest["a_b.tension_a"], rel=1e-9)
    assert result.at(3.0)["part0.z"] == pytest.approx(rest["part0.z"], abs=1e-9)
    assert result.at(3.0)["part0.velocity_z"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("nodes", "frequency", "peak", "least"), [(0, 0.27658, -12.0831, 68.16e3), (6, 0.27828, -12.0846, 67.7e3)]
)
def test_a_dropped_load_rebounds(nodes: int, frequency: float, peak: float, least: float) -> None:
    system = level_span([1950.0, 1000.0])
    lost = rw.Intervention(0.0, "load lost", "part1")
    inertia = rw.Inertia(nodes=nodes, damping=0.0)
    result = rw.simulate(system, 15.0, every=0.05, inertia=inertia, interventions=[lost], tolerance=1e-7)
    times = result.full_frame.index.to_numpy()[2:]
    heights = np.array([result.record(i)["part0.z"] for i in range(2, len(result.records))])
    assert 1.0 / period(times, heights - (heights.max() + heights.min()) / 2.0) == pytest.approx(frequency, rel=1e-3)
    assert heights.max() == pytest.approx(peak, abs=2e-3)
    assert tensions(result).min() == pytest.approx(least, abs=200.0)
    energy = mechanical(result)[2:]
    exchanged = np.ptp(result.full_frame["a_b.kinetic_energy"])
    assert np.ptp(energy) < 1e-4 * exchanged
    moving = result.at(1.0)
    # The load is at its place on the curve of the rope.
    curve = moving.profile("a_b", [moving["part0.distance"]])
    assert curve[["x", "z"]].to_numpy()[0] == pytest.approx([moving["part0.x"], moving["part0.z"]], abs=1e-6)


@pytest.mark.parametrize(("kept", "until", "peak"), [(False, 1.5, 126.9e3), (True, 12.0, 136.13e3)])
def test_an_emergency_stop_has_its_peak(kept: bool, until: float, peak: float) -> None:
    system = stop_line(kept=kept)
    more = {} if kept else {"given": {"s4_d5.tension_b": 100e3}, "solve_for": "s4_d5.length"}
    start = rw.equilibrium(system, **more)
    stop = rw.Intervention(0.0, "emergency stop", deceleration=4.0)
    result = rw.simulate(system, until, every=0.05, start=start, inertia=UNDAMPED, interventions=[stop], tolerance=1e-4)
    assert tensions(result).max() == pytest.approx(peak, rel=0.01)


@pytest.mark.parametrize("degrees", [2.0, 20.0, 85.0])
def test_a_pendulum_swings_when_its_tagline_breaks(degrees: float) -> None:
    angle, light = np.radians(degrees), rw.Rope(mass_per_length=1e-3, axial_stiffness=1e8, breaking_load=450e3)
    s, bob = rw.System("pendulum"), rw.Joint("m", at=(10 * np.sin(angle), -10 * np.cos(angle)), mass=1000.0)
    s.string(light, rw.Anchor("a", at=(0.0, 0.0)), bob, length=10.0)
    # The tagline pulls across the pendulum, whose tension is the same before and after.
    away = (10 * np.sin(angle) + 20 * np.cos(angle), -10 * np.cos(angle) + 20 * np.sin(angle))
    s.string(light, bob, rw.Anchor("b", at=away), length=20.0)
    rest = rw.equilibrium(s, given={"m.x": 10 * np.sin(angle)}, solve_for="m_b.length")
    cut = rw.Intervention(0.0, "rope breaks", "m_b")
    result = rw.simulate(s, 20.0, every=0.05, start=rest, inertia=UNDAMPED, interventions=[cut])
    swing = result.full_frame["m.x"].iloc[2:]
    length = float(np.hypot(rest["m.x"], rest["m.z"]))
    exact = 4.0 * np.sqrt(length / 9.80665) * ellipk(np.sin(angle / 2.0) ** 2)
    assert period(swing.index.to_numpy(), swing.to_numpy()) == pytest.approx(exact, rel=3e-4)
    # At the lowest point the tension is that of the circle.
    late = result.full_frame["a_m.tension_a"].loc[15.0:]
    assert late.max() == pytest.approx(9806.65 * (3 - 2 * np.cos(angle)), rel=5e-3)


def test_a_payload_dropped_from_a_skyline_keeps_the_energy() -> None:
    system, rest = held_carriage(ROPE)
    drop = rw.Intervention(1.0, "payload dropped", "carriage")
    result = rw.simulate(system, 12.0, every=0.5, start=rest, inertia=UNDAMPED, interventions=[drop])
    before = result.full_frame.loc[:1.0].iloc[:-1]
    assert before["head_carriage.tension_a"].to_numpy() == pytest.approx(rest["head_carriage.tension_a"], rel=1e-9)
    energy = result.energy()
    assert abs(energy["residual"]) < 1e-4 * result.full_frame["carriage.kinetic_energy"].max()
    # The payload takes its weight times its height with it; no support is crossed.
    taken = -9.80665 * system.components["carriage"].payload * rest["carriage.z"]
    assert energy["loads"] == pytest.approx(taken, rel=1e-6)
    assert abs(energy["crossings"]) < 1e-6 * abs(taken)
    assert result.frame["carriage.z"].max() > rest["carriage.z"] + 2.0


def test_loads_cross_supports_as_without_inertia() -> None:
    line = fed_line(1.5)
    start = rw.equilibrium(line)
    quasi = rw.simulate(line, 25.0, start=start)
    result = rw.simulate(line, 25.0, start=start, inertia=UNDAMPED, tolerance=1e-5)
    crossings = result.events[["component", "event", "load"]].value_counts()
    assert crossings.to_dict() == quasi.events[["component", "event", "load"]].value_counts().to_dict()
    assert len(crossings) >= 4
    end, other = result.at(25.0).loads.set_index("load"), quasi.at(25.0).loads.set_index("load")
    assert sorted(end.index) == sorted(other.index)
    assert np.abs(end["z"] - other["z"]).max() < 0.5
    energy = result.energy()
    work = abs(energy["ends"]) + abs(energy["gravity"])
    assert abs(energy["residual"]) < 1e-3 * work
    assert abs(energy["crossings"]) < 0.05 * work
    assert np.abs(result.frame.filter(like="tension").mean() - quasi.frame.filter(like="tension").mean()).max() < 300.0


def test_the_result_depends_neither_on_the_interval_nor_on_the_tolerance() -> None:
    line = fed_line(rw.Schedule((0.0, 2.0, 3.0, 20.0), (1.5, 1.5, 0.0, 0.0)))
    start = rw.equilibrium(line)

    def run(every: float, tolerance: float) -> np.ndarray:
        result = rw.simulate(line, 6.0, every=every, start=start, inertia=rw.Inertia(), tolerance=tolerance)
        return result.frame["s1_s2.tension_a"].loc[[0.0, 2.0, 4.0, 6.0]].to_numpy()

    best = run(2.0, 1e-8)
    assert run(0.5, 1e-8) == pytest.approx(best, abs=5.0)
    errors = [np.abs(run(2.0, tolerance) - best).max() for tolerance in (1e-4, 1e-6)]
    assert errors[1] < min(errors[0], 20.0)


def test_a_slow_stop_is_quasi_static() -> None:
    line = stop_line(kept=True, speed=0.1)
    start = rw.equilibrium(line)
    stop = [rw.Intervention(0.0, "emergency stop", deceleration=0.005)]
    quasi = rw.simulate(line, 22.0, every=2.0, start=start, interventions=stop)
    result = rw.simulate(line, 22.0, every=2.0, start=start, interventions=stop, inertia=rw.Inertia(), tolerance=1e-4)
    names = [c for c in quasi.frame if c.endswith(("tension_a", "tension_b"))]
    assert np.abs(result.frame[names] - quasi.frame[names]).to_numpy().max() < 1e-3 * 100e3


def test_a_run_continues_from_any_time() -> None:
    line = fed_line(1.5)
    whole = rw.simulate(line, 8.0, inertia=rw.Inertia(), tolerance=1e-7)
    rest = rw.simulate(line, 4.0, start=whole.at(4.0), inertia=rw.Inertia(), tolerance=1e-7)
    assert rest.frame["d_s1.tension_a"].iloc[-1] == pytest.approx(whole.frame["d_s1.tension_a"].iloc[-1], abs=5.0)


def test_an_endless_line_keeps_its_loads_and_its_energy() -> None:
    rows = {"name": ["d", "s1", "r", "s2"], "x": [0, 100, 200, 100], "y": [0, 2, 0, -2], "z": [0.0, 6.0, 0.0, 6.0]}
    table = pd.DataFrame({**rows, "kind": ["control", "idler", "return", "idler"]})
    line = rw.endless(ROPE, table, tension=40e3, speed=1.5, load_mass=200.0, load_spacing=40.0)
    result = rw.simulate(line, 20.0, every=4.0, inertia=rw.Inertia(), tolerance=1e-4)
    assert sorted(result.at(20.0).loads["load"]) == sorted(result.at(0.0).loads["load"])
    energy = result.energy()
    assert abs(energy["residual"]) < 1e-3 * (abs(energy["drives"]) + abs(energy["take_up"]))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: rw.Inertia(damping=-1e-3), "damping"),
        (lambda: rw.Inertia(zone=0.0), "zone"),
        (lambda: rw.Inertia(nodes=-1), "nodes"),
        (lambda: rw.simulate(fed_line(1.0), 5.0, inertia=rw.Inertia(nodes=2)), "cannot pass a support"),
        (lambda: rw.simulate(fed_line(1.0), 5.0, inertia=rw.Inertia(zone=60.0)), "more than half of span"),
        (
            lambda: rw.simulate(level_span([9.0]), 5.0, interventions=[rw.Intervention(1.0, "load lost", "part0")]),
            "inertia",
        ),
    ],
)
def test_invalid_inertia_is_refused(make: object, words: str) -> None:
    with pytest.raises(rw.InputError, match=words):
        make()  # type: ignore[operator]


def test_what_is_not_there_cannot_be_lost() -> None:
    lost = [rw.Intervention(1.0, "load lost", "part7")]
    with pytest.raises(rw.UnknownNameError, match="part7"):
        rw.simulate(level_span([900.0]), 5.0, inertia=rw.Inertia(), interventions=lost)


def test_a_model_with_inertia_is_not_used_where_it_does_not_fit() -> None:
    result = rw.simulate(level_span([900.0]), 1.0, inertia=rw.Inertia())
    for call in (lambda: rw.equilibrium(result.model), lambda: rw.simulate(result.model, 1.0)):
        with pytest.raises(rw.InputError, match="model with inertia"):
            call()
    with pytest.raises(rw.InputError, match="Inertia"):
        rw.simulate(level_span([900.0]), 1.0, start=result.at(1.0))


def test_a_result_names_what_has_no_inertia() -> None:
    s = rw.System("saddle")
    jack = rw.IntermediateSupport("jack", at=(100.0, 0.0))
    spans = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), jack, rw.Anchor("b", at=(200.0, 0.0)), length=200.2)
    with pytest.raises(rw.InputError, match="Nothing in 'saddle' can move"):
        rw.simulate(s, 0.1, inertia=rw.Inertia())
    s.hang(rw.Load("turn", mass=500.0), spans, at=50.0)
    result = rw.simulate(s, 0.1, every=0.1, inertia=rw.Inertia())
    assert result.in_balance == ("jack",)
    assert "in equilibrium at every time: jack" in str(result.summary())
    assert rw.simulate(s, 0.1, every=0.1).in_balance == ()
    assert rw.simulate(level_span([900.0]), 0.1, every=0.1, inertia=rw.Inertia()).in_balance == ()


def test_a_gust_lets_a_load_swing_and_the_air_damps_it() -> None:
    rope = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450e3, diameter=0.0254)
    s = rw.System("windy")
    (span,) = s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(240.0, 0.0)), length=240.55)
    s.hang(rw.Load("turn", mass=500.0, drag_area=4.0), span, at=120.0)
    steady = rw.equilibrium(s, environment=rw.Environment("wind", wind_pressure=300.0, wind_from=0.0))
    gust = rw.Environment(
        "gust", wind_pressure=rw.Schedule((0.0, 2.0, 2.5, 60.0), (300.0, 300.0, 0.0, 0.0)), wind_from=0.0
    )
    result = rw.simulate(s, 40.0, every=0.5, environment=gust, inertia=UNDAMPED)
    aside = np.array([result.record(int(i))["turn.y"] for i in np.flatnonzero(result.on_grid)])
    assert aside[:5] == pytest.approx(steady["turn.y"], abs=1e-9)
    assert aside[6:20].max() == pytest.approx(-steady["turn.y"], rel=0.3)
    assert np.abs(aside[-12:]).max() < 0.97 * np.abs(aside[6:18]).max()


def test_hydraulic_drives_and_responses_work_with_inertia() -> None:
    drive = hydraulic_drive(friction=0.01)
    line = rw.monocable(
        ROPE,
        LINE,
        tension=45e3,
        speed=1.0,
        load_mass=300.0,
        load_spacing=50.0,
        drive=drive,
        response=rw.ProportionalResponse(gain=1e-5, limit=0.1),
    )
    stop = [rw.Intervention(2.0, "emergency stop", deceleration=1.0)]
    result = rw.simulate(line, 4.0, every=1.0, inertia=UNDAMPED, interventions=stop, tolerance=1e-4)
    quasi = rw.simulate(line, 4.0, every=1.0, interventions=stop)
    assert "response" in set(result.events["event"])
    away = (result.frame - quasi.frame).filter(regex="tension_[ab]$").abs().max(axis=1)
    assert away.loc[1.0] < 100.0  # at its speed the line is quasi-static
    assert away.loc[3.0] > 500.0  # while it stops, its loads push on
    energy = result.energy()
    assert energy["friction"] > 0.0
    assert abs(energy["residual"]) < 1e-3 * (abs(energy["drives"]) + abs(energy["ends"]) + energy["friction"])


def test_a_line_far_from_the_origin_starts() -> None:
    line = fed_line(1.5, spans=4)
    far = rw.System("far")
    for component in line.components.values():
        if isinstance(component, Node):
            far.add(
                replace(component, at=tuple(x + d for x, d in zip(component.at, (6000.0, 2000.0, 1500.0), strict=True)))
            )
        else:
            far.add(component)
    for (name, end), (node, seat) in line.connections.items():
        span, other = far.components[name], far.components[node]
        far.connect(getattr(span, end), next(s for s in other.seats if s.name == seat))
    far.feed(
        tuple(c for c in far.components.values() if isinstance(c, rw.Span)), spacing=38.0, masses=(300.0, 420.0, 350.0)
    )
    near, away = (rw.simulate(s, 3.0, inertia=rw.Inertia(), tolerance=1e-6) for s in (line, far))
    assert away.frame["s1_s2.tension_a"].iloc[-1] == pytest.approx(near.frame["s1_s2.tension_a"].iloc[-1], abs=1.0)


def clamped(grip: float) -> rw.System:
    """A carriage clamped to an inclined skyline, and held by a tagline."""
    s = rw.System("clamp")
    carriage = rw.Carriage("car", at=(150.0, -40.0), mass=1500.0, clamped=True, grip=grip)
    s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), carriage, rw.Anchor("b", at=(300.0, -60.0)), length=307.5)
    light = rw.Rope(mass_per_length=0.5, axial_stiffness=8e6, breaking_load=120e3)
    s.string(light, carriage.mainline, rw.Anchor("w", at=(0.0, 10.0)), length=160.0)
    return s


def test_a_clamp_slips_beyond_its_grip() -> None:
    cut, grip = rw.Intervention(0.5, "rope breaks", "car_w"), 4e3
    results = {}
    for held in (grip, np.inf):
        s = clamped(held)
        start = rw.equilibrium(s, given={"car.mainline_pull": 4e3}, solve_for="car_w.length")
        results[held] = rw.simulate(s, 2.5, every=0.02, start=start, inertia=UNDAMPED, interventions=[cut])
    slips, holds = results[grip], results[np.inf]
    assert "clamp slips" in set(slips.events["event"])
    assert "clamp slips" not in set(holds.events["event"])
    slipped = slips.frame["car.travel"].iloc[-1]
    assert slipped < -0.01  # the rope runs down through the clamp: the carriage moves towards end b
    assert slips.frame["car.x"].iloc[-1] > holds.frame["car.x"].iloc[-1] + 0.01
    # The clamp takes its grip times the way that the rope slips.
    assert slips.energy()["friction"] == pytest.approx(grip * np.abs(np.diff(slips.frame["car.travel"])).sum(), rel=0.1)
    held = slips.frame["car.slip_speed"].abs() < 1e-4
    assert (slips.frame["car.clamp_force"][held].abs() < grip).all()


def test_a_grip_needs_a_clamp() -> None:
    with pytest.raises(rw.InputError, match="grip of 4000 N without a clamp"):
        rw.Carriage("car", mass=400.0, grip=4e3)
