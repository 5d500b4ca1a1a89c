"""Sheaves at rest: friction, wrap, bearing load, a load that stands on one."""

from __future__ import annotations

import numpy as np
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)


def line(*, speed: float = 0.0, friction: float = 0.0, length: float = 303.0) -> rw.System:
    """Driven at its start, over two idlers to an end that keeps its tension."""
    s = rw.System("line")
    s.string(
        ROPE,
        rw.Drum("d", at=(0.0, 0.0), speed=speed),
        rw.Sheave("s1", at=(100.0, 5.0), friction=friction),
        rw.Sheave("s2", at=(210.0, 2.0), friction=friction),
        rw.Anchor("b", at=(300.0, 12.0)),
        length=length,
    )
    return s


def vectors(eq: rw.Equilibrium, before: str, after: str, node: str) -> tuple[np.ndarray, np.ndarray]:
    """The rope's forces on a support from the span that comes in and the one that goes out."""
    start = np.array([eq[f"{after}.force_{axis}"] for axis in "xyz"])
    begin = np.array([eq[f"{before}.force_{axis}"] for axis in "xyz"])
    begin[2] = eq[f"{before}.vertical_b"]
    return -begin, start


def test_no_friction_no_difference() -> None:
    eq = rw.equilibrium(line())
    for name, before, after in (("s1", "d_s1", "s1_s2"), ("s2", "s1_s2", "s2_b")):
        assert eq[f"{name}.tension_in"] == pytest.approx(eq[f"{before}.tension_b"])
        assert eq[f"{name}.tension_out"] == pytest.approx(eq[f"{after}.tension_a"])
        assert eq[f"{name}.differential_tension"] == pytest.approx(0.0, abs=1e-6)
        assert eq[f"{name}.travel"] == 0.0


def test_wrap_and_bearing_load() -> None:
    eq = rw.equilibrium(line())
    came, went = vectors(eq, "d_s1", "s1_s2", "s1")
    assert eq["s1.bearing_load"] == pytest.approx(np.linalg.norm(came + went))
    assert eq["s1.support_force"] == pytest.approx(-(came + went)[2])
    cosine = -came @ went / np.linalg.norm(came) / np.linalg.norm(went)
    assert eq["s1.wrap"] == pytest.approx(np.arccos(cosine), rel=1e-9)
    assert eq["s1.bearing_load"] == pytest.approx(2.0 * eq["s1.tension_in"] * np.sin(eq["s1.wrap"] / 2.0), rel=1e-9)


@pytest.mark.parametrize(("speed", "sense"), [(1.0, 1.0), (-1.0, -1.0), (0.0, 0.0)])
def test_friction_holds_back(speed: float, sense: float) -> None:
    """The tension ratio is exp(friction * wrap) in the direction of travel, one at rest."""
    eq = rw.equilibrium(line(speed=speed, friction=0.03))
    for name in ("s1", "s2"):
        ratio = eq[f"{name}.tension_out"] / eq[f"{name}.tension_in"]
        assert ratio == pytest.approx(np.exp(sense * 0.03 * eq[f"{name}.wrap"]), rel=1e-9)


def test_a_frictionless_sheave_has_no_friction_to_set() -> None:
    s = rw.System("idler")
    nodes = [rw.Drum("a", at=(0.0, 0.0), speed=1.0), rw.Sheave("m", at=(100.0, 20.0)), rw.Anchor("b", at=(200.0, 0.0))]
    s.string(ROPE, *nodes, tension=3e4)
    with pytest.raises(rw.RopewayError, match=r"m\.friction"):
        rw.equilibrium(s, parameters={"m.friction": 0.05})


def test_a_bend_in_plan_wraps_too() -> None:
    s = rw.System("corner")
    corner = (
        rw.Anchor("a", at=(0.0, 0.0, 0.0)),
        rw.Sheave("m", at=(100.0, 0.0, 0.0)),
        rw.Anchor("b", at=(100.0, 100.0, 0.0)),
    )
    s.string(ROPE, *corner, tension=4e5)
    eq = rw.equilibrium(s)
    assert eq["m.wrap"] == pytest.approx(np.pi / 2.0, rel=1e-3)
    assert eq["m.bearing_load"] == pytest.approx(np.sqrt(2.0) * 4e5, rel=1e-3)


def test_a_control_sheave_may_hold_a_difference() -> None:
    s = rw.System("line")
    spans = s.string(
        ROPE,
        rw.Anchor("a", at=(0.0, 0.0)),
        rw.ControlSheave("c", at=(100.0, 0.0)),
        rw.Anchor("b", at=(200.0, 0.0)),
        tension=2e4,
    )
    s.hang(rw.Load("turn", mass=500.0), spans[0], at=40.0)
    eq = rw.equilibrium(s)
    assert eq["c.differential_tension"] < -1e3
    assert eq["c.differential_tension"] == pytest.approx(eq["c.tension_out"] - eq["c.tension_in"])
    assert eq["c_b.tension_a"] == pytest.approx(2e4, rel=1e-9)


def test_a_drum_keeps_its_tension() -> None:
    s = rw.System("line")
    spans = s.string(
        ROPE,
        rw.Anchor("a", at=(0.0, 0.0)),
        rw.Sheave("m", at=(100.0, 0.0)),
        rw.Drum("b", at=(200.0, 0.0), tension=3e4),
        tension=2e4,
    )
    s.hang(rw.Load("turn", mass=500.0), spans, at=40.0)
    eq = rw.equilibrium(s)
    assert eq["b.rope_tension"] == pytest.approx(3e4, rel=1e-9)
    assert eq["m_b.tension_b"] == pytest.approx(3e4, rel=1e-9)
    assert eq["turn.distance"] == pytest.approx(40.0)


def test_a_load_pushed_back_from_both_sides_stands_on_the_sheave() -> None:
    """A sheave that presses the rope down: a load lifts the rope where it leaves, and is pushed back."""
    s = rw.System("hold-down")
    spans = s.string(
        ROPE,
        rw.Anchor("a", at=(0.0, 30.0)),
        rw.Sheave("m", at=(100.0, 0.0), hold_down=True),
        rw.Anchor("b", at=(200.0, 30.0)),
        tension=4e4,
    )
    s.hang(rw.Load("turn", mass=300.0), spans, at=spans[0].length)
    eq = rw.equilibrium(s)
    assert len(eq.loads) == 1
    assert np.hypot(eq["turn.x"] - 100.0, eq["turn.z"]) < 0.1
    if eq.held:
        assert eq.held == ("m",)
        assert eq["m.held"] == 1.0
