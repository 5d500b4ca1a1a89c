"""Endless ropes keep their loads in both directions; runs without progress are an error."""

from __future__ import annotations

import pickle

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.dynamics import load_crossings
from ropeway.systems.dynamics.chattering import ChatterGuard, FinalError
from ropeway.systems.dynamics.event_stepper import EventStepper
from ropeway.systems.statics.certificate.certify import certify
from ropeway.systems.statics.stability import free_balances

ROPE = rw.Rope(mass_per_length=2.9, axial_stiffness=28e6, breaking_load=480e3)
MASSES = (210.0, 150.0, 0.0, 330.0, 90.0)
TURNING = rw.Schedule((0.0, 25.0, 28.0, 110.0, 112.0, 200.0), (1.4, 1.4, -1.7, -1.7, 0.9, 0.9))


def loop(speed: float | rw.Schedule, **more: object) -> rw.System:
    rows = [("d", 0, 0, 0, "control"), ("o", 68, 0, 4, "idler"), ("r", 141, 1.5, 5, "return"), ("b", 72, 3, 4, "idler")]
    table = pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])
    settings = {"tension": 52e3, "load_mass": MASSES, "load_spacing": 28.0, **more}
    return rw.endless(ROPE, table, speed=speed, **settings)


@pytest.mark.parametrize("speed", [1.6, -1.6, TURNING])
def test_loads_stay_on_an_endless_rope(speed: float | rw.Schedule) -> None:
    line = loop(speed)
    result = rw.simulate(line, 200.0, every=20.0)
    first = result.at(0.0).loads.set_index("load")["mass"].sort_index()
    assert len(first) == 8
    for time in np.arange(0.0, 201.0, 10.0):
        loads = result.at(float(time)).loads.set_index("load")["mass"].sort_index()
        pd.testing.assert_series_equal(loads, first)
    # For a given travel of the drive the line is an equilibrium, solved from a cold start.
    for time in (100.0, 200.0):
        here = result.at(time)
        cold = rw.equilibrium(line, parameters={"d.travel": float(here["d.travel"])})
        for name in ("o_r.tension_a", "r.slide", "l4.z", "l1.x"):
            assert cold[name] == pytest.approx(here[name], rel=1e-9, abs=1e-9)


def test_forwards_and_backwards_on_an_endless_rope() -> None:
    way = rw.Schedule((0.0, 59.0, 61.0, 120.0), (-2.0, -2.0, 2.0, 2.0))
    result = rw.simulate(loop(way), 120.0, every=60.0)
    events = result.events["event"].value_counts()
    assert events["crossing forward"] == events["crossing backward"] > 10
    both = (result.at(t).loads.sort_values("load") for t in (0.0, 120.0))
    first, last = (b[["distance", "x", "z"]].to_numpy() for b in both)
    assert last == pytest.approx(first, abs=1e-7)


def test_a_rope_of_another_length_keeps_its_loads() -> None:
    """A loop spliced 2 m longer: loads return one rope length apart."""
    line = rw.equilibrium(loop(-1.2), parameters={"d_o.length": 70.5, "l2.mass": 260.0})
    result = rw.simulate(line.model, 260.0, start=line, every=20.0)
    assert result.records[0].x[0] - result.records[-1].x[0] > 282.0
    assert {result.at(t).loads["mass"].sum() for t in result.frame.index} == {line.loads["mass"].sum()}


def test_a_load_is_held_on_the_return_wheel_if_both_sides_push_it_back() -> None:
    x, kind = [0.0, 96.0, 190.0, 283.0, 190.0, 96.0], ["control", "idler", "idler", "return", "idler", "idler"]
    z = [0.0, -5.0, -13.0, -24.0, -13.0, -5.0]
    table = pd.DataFrame({"name": [f"n{k}" for k in range(6)], "x": x, "y": [0.0, 0, 0, 1, 2, 2], "z": z, "kind": kind})
    line = rw.endless(ROPE, table, tension=76e3, speed=1.1, load_mass=[350.0, 310.0], load_spacing=33.0)
    result = rw.simulate(line, 60.0)
    at_return = result.events[result.events["component"] == "n3"]["event"]
    assert set(at_return) <= {"load held", "load released forward", "crossing forward"}
    assert (at_return == "load held").sum() == (at_return == "load released forward").sum() > 0
    assert len(result.at(60.0).loads) == len(result.at(0.0).loads)


def test_a_monocable_carries_its_loads_in_both_directions() -> None:
    """Loads that leave at an end enter there again when the rope reverses; after them the rope enters empty."""
    table = pd.DataFrame({"name": list("abcd"), "x": [0.0, 70.0, 150.0, 215.0], "y": 0.0, "z": [0.0, 6.0, 9.0, 10.0]})
    table["kind"] = ["drum", "control", "idler", "drum"]
    turn = rw.Schedule((0.0, 39.0, 41.0, 120.0), (-1.5, -1.5, 1.5, 1.5))
    line = rw.monocable(ROPE, table, tension=50e3, speed=turn, load_mass=(200.0, 120.0), load_spacing=31.0)
    result = rw.simulate(line, 120.0)
    counts = [len(result.at(t).loads) for t in (0.0, 40.0, 80.0, 120.0)]
    assert counts[0] == counts[2] == counts[3] > counts[1] + 1
    left = [e.load for e in result.noted if e.event == "load taken off" and e.component == "a"]
    back = [e.load for e in result.noted if e.event == "load put on" and e.component == "a"]
    assert left[::-1] == back[: len(left)]


def test_a_lost_load_is_an_internal_error(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = load_crossings.apply

    def losing(state, which, **more):
        what = plain(state, which, **more)
        if which.k == 2:
            state.passed[which.r][which.k + 1 :] += 1
            state.write_slots()
        return what

    monkeypatch.setattr(load_crossings, "apply", losing)
    with pytest.raises(rw.SimulationError, match=r"Internal error: 8 loads are on d \.\.\. d after a crossing, 10"):
        rw.simulate(loop(1.0), 60.0)


def test_a_run_without_progress_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Crossings without effect would repeat indefinitely."""
    monkeypatch.setattr(load_crossings, "apply", lambda *_, **__: "crossing forward")
    with pytest.raises(
        rw.SimulationError, match=r"no progress: \d+ events and failed steps at '\w+' within 0.1 s"
    ) as caught:
        rw.simulate(loop(1.0), 60.0)
    assert caught.value.time < 30.0
    assert len(caught.value.result.records) > 100
    assert "no progress" in str(pickle.loads(pickle.dumps(caught.value)))


def test_events_of_a_short_time_are_counted() -> None:
    guard = ChatterGuard(3)
    for time in np.arange(0.0, 500.0, 0.5):
        for _ in range(300):
            guard.require(float(time), "s1")
    for _ in range(guard.most - guard.count):
        guard.require(499.55)
    with pytest.raises(FinalError, match="'s1'"):
        guard.require(499.55)


def test_an_error_that_shorter_steps_do_not_resolve_is_raised_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def move(self, stop):
        calls.append(stop)
        raise FinalError("no more")

    monkeypatch.setattr(EventStepper, "_move_to", move)
    with pytest.raises(rw.SimulationError, match="no more"):
        rw.simulate(loop(1.0), 10.0)
    assert calls == [1.0]


def test_the_slide_of_a_return_wheel_is_certified() -> None:
    """A wheel off its slide, or with a force other than its take-up, fails; its slide is a free position."""
    x = [0.0, 95.0, 210.0, 95.0]
    table = pd.DataFrame(
        {
            "name": ["d", "o", "r", "b"],
            "x": x,
            "y": [0.0, 0.0, 1.0, 2.0],
            "z": [0.0, 6.0, 9.0, 6.0],
            "kind": ["control", "idler", "return", "idler"],
        }
    )
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    eq = rw.equilibrium(rw.endless(rope, table, tension=60e3, load_mass=[250.0, 120.0], load_spacing=41.0))
    index = eq.model.z.index
    assert index["r.slide"] in {b.travel for b in free_balances(eq.model, eq.point)}
    assert certify(eq.model, eq.point, eq.runs, eq.passed).failed is None
    for name, value in (("z.r.x", 1e-6), ("p.r.take_up", 1.0)):
        kind, _, variable = name.partition(".")
        point = eq.point.copy()
        table_of = eq.model.z if kind == "z" else eq.model.p
        getattr(point, kind)[table_of.index[variable]] += value
        failed = [c for c in certify(eq.model, point, eq.runs, eq.passed).checks if not c.holds]
        assert "r" in {c.component for c in failed if c.name.startswith("TensionedReturn")}
