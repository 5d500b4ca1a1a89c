"""Systems as parts of others: the same results as separate systems, component for component, and shared components."""

from typing import Any

import numpy as np
import pytest

import ropeway as rw
from support.drives import hydraulic_drive

ROPE = rw.Rope(mass_per_length=3.1, axial_stiffness=31e6, breaking_load=500e3)
DRIVE = hydraulic_drive(displacement=1e-4, gear_ratio=10.0, relief_pressure=3e7, pump_flow=5e-3, inertia=2000.0)


def line(mass: float, *, spans: int = 6, precedence: str = "worst first", **how: Any) -> rw.System:
    """A line full of loads, each third support a control sheave with a response."""
    s = rw.System("line", precedence=precedence)
    response = rw.ThresholdResponse(low=59.5e3, high=60.5e3, increment=0.02)
    nodes: list[Any] = [rw.Drum("first", at=(0.0, 0.0), tension=60e3)]
    for i in range(1, spans):
        at = (80.0 * i, 2.0 * i)
        nodes.append(
            rw.ControlSheave(f"c{i}", at=at, speed=1.0, response=response, **how)
            if i % 3 == 0
            else rw.Sheave(f"c{i}", at=at)
        )
    nodes.append(rw.Drum("last", at=(80.0 * spans, 10.0), tension=60e3))
    s.feed(s.string(ROPE, *nodes, tension=60e3), spacing=40.0, masses=mass)
    return s


def test_two_lines_in_one_system_are_independent() -> None:
    separate = {"p": line(300.0), "q": line(420.0)}
    outer = rw.System("yard")
    for name, inner in separate.items():
        assert len(outer.add(inner, name=name)) == len(inner.components)
    together, run = rw.equilibrium(outer), rw.simulate(outer, until=45.0, every=1.0, progress=False)
    for name, inner in separate.items():
        eq, alone = rw.equilibrium(inner), rw.simulate(inner, until=45.0, every=1.0, progress=False)
        for variable in eq.model.y.names:
            assert together[f"{name}.{variable}"] == pytest.approx(eq[variable], rel=1e-10, abs=1e-10)
        for column in alone.frame:
            scale = 1.0 + np.abs(alone.frame[column]).max()
            assert np.abs(run.frame[f"{name}.{column}"] - alone.frame[column]).max() < 1e-10 * scale
        own = run.events[run.events["component"].str.startswith(f"{name}.")]
        assert own["event"].tolist() == alone.events["event"].tolist()
        assert own["load"].str.removeprefix(f"{name}.").tolist() == alone.events["load"].tolist()
    assert {"response"} & set(run.events["event"].str.split().str[0])


def test_two_lines_share_a_power_unit() -> None:
    outer = rw.System("yard")
    parts = [outer.add(line(mass, drive=DRIVE), name=name) for name, mass in (("p", 300.0), ("q", 420.0))]
    unit = outer.add(rw.HydraulicPowerUnit("unit", pump_flow=2e-3, engine_power=20e3))
    for part in parts:
        sheave = part["c3"]
        assert isinstance(sheave, rw.ControlSheave)
        outer.connect(sheave.supply, unit.outlet)
    frame = rw.simulate(outer, until=15.0, every=1.0, progress=False).frame
    assert frame["unit.flow_share"].iloc[-1] < 0.6
    flows = [frame[f"{name}.c3.flow"].iloc[-1] for name in "pq"]
    assert sum(flows) == pytest.approx(2e-3, rel=0.01)
    assert flows[0] == pytest.approx(flows[1], rel=0.01)


def test_nested_parts_keep_loads_connections_and_origins() -> None:
    inner = rw.System("inner")
    over = (rw.Anchor("a", at=(0.0, 0.0)), rw.Sheave("m", at=(50.0, 2.0)), rw.Anchor("b", at=(90.0, 0.0)))
    spans = inner.string(ROPE, *over, length=91.0)
    inner.hang(rw.Load("turn", mass=400.0), spans, at=20.0)
    middle, outer = rw.System("middle"), rw.System("outer")
    middle.add(inner, name="i")
    middle.add(inner, name="j")
    outer.add(middle, name="m")
    eq, alone = rw.equilibrium(outer), rw.equilibrium(inner)
    assert eq["m.i.a_m.tension_a"] == pytest.approx(alone["a_m.tension_a"], rel=1e-12)
    assert eq["m.j.turn.z"] == pytest.approx(alone["turn.z"], rel=1e-12)
    assert set(eq.loads["load"]) == {"m.i.turn", "m.j.turn"}
    heavier = rw.equilibrium(outer, parameters={"m.i.turn.mass": 800.0})
    assert heavier["m.i.turn.z"] < eq["m.i.turn.z"]
    assert heavier["m.j.turn.z"] == pytest.approx(eq["m.j.turn.z"], abs=1e-9)
    assert "test_subsystems.py" in outer.origin("m.i.a")
    assert inner.components["a"].name == "a"


def test_parts_in_sweeps_and_summaries() -> None:
    outer = rw.System("yard")
    outer.add(line(300.0, spans=4), name="p")
    frame = rw.sweep(outer, rw.latin_hypercube({"p.first.tension": (58e3, 62e3)}, 3), outputs=["p.c3.tension_in"])
    assert frame["p.c3.tension_in"].is_monotonic_increasing == frame["p.first.tension"].is_monotonic_increasing
    summary = rw.simulate(outer, until=3.0, every=1.0, progress=False).summary()
    assert "p.c3" in summary.supports.index


def test_rejected_input() -> None:
    outer, inner = rw.System("outer"), line(300.0, spans=4)
    for name, words in ((None, "needs a name"), ("a.b", "identifier"), ("", "identifier")):
        with pytest.raises(rw.InputError, match=words):
            outer.add(inner, name=name)
    outer.add(inner, name="p")
    with pytest.raises(rw.InputError, match="taken"):
        outer.add(inner, name="p")
    with pytest.raises(rw.InputError, match="another gravity"):
        outer.add(rw.System("moon", gravity=1.62), name="moon")
    with pytest.raises(rw.InputError, match="part of itself"):
        outer.add(outer, name="self")
    with pytest.raises(rw.InputError, match="has a name"):
        outer.add(rw.Anchor("x", at=(0.0, 0.0)), name="y")
