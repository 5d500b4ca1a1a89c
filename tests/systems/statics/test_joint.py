"""Joints: ropes in series, bridles, and a net against published displacements."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

import ropeway as rw
from support.nets import BAY, FOOT, SAG, published_net
from support.oracle import UP, Material, by_quadrature

ROPE = rw.Rope(mass_per_length=2.6, axial_stiffness=24e6, breaking_load=380e3)


@given(
    shares=st.tuples(*[st.floats(0.1, 1.0)] * 3),
    drop=st.floats(-60.0, 60.0),
    slack=st.floats(1.0005, 1.15),
)
def test_ropes_in_series_are_one_rope(shares: tuple[float, ...], drop: float, slack: float) -> None:
    length = slack * math.hypot(180.0, drop)
    one = rw.System("one")
    one.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(180.0, drop)), length=length)
    whole = rw.equilibrium(one)
    parts = length * np.array(shares) / sum(shares)
    at = np.cumsum(parts)[:2] / length
    a, b = rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(180.0, drop))
    first, second = (rw.Joint(f"j{i}", at=(180.0 * s, drop * s - 5.0)) for i, s in enumerate(at, 1))
    three = rw.System("three")
    for from_, to, part in zip((a, first, second), (first, second, b), parts, strict=True):
        three.string(ROPE, from_, to, length=float(part))
    eq = rw.equilibrium(three)
    assert eq["a_j1.tension_a"] == pytest.approx(whole["a_b.tension_a"], rel=1e-10)
    assert eq["j2_b.tension_b"] == pytest.approx(whole["a_b.tension_b"], rel=1e-10)
    place = whole.profile("a_b", [float(parts[0])]).iloc[0]
    assert [eq["j1.x"], eq["j1.z"]] == pytest.approx([place.x, place.z], abs=1e-9)
    assert eq.certificate["holds"].all()


def bridle(mass: float = 800.0) -> rw.System:
    s = rw.System("bridle")
    knot = s.add(rw.Joint("knot", at=(50.0, -20.0), mass=mass))
    for name, at, length in (("p", (0.0, 0.0), 55.0), ("q", (100.0, 8.0), 56.0), ("r", (60.0, -60.0), 42.0)):
        s.string(ROPE, rw.Anchor(name, at=at), knot, length=length)
    return s


def test_balance_of_a_bridle_by_integration() -> None:
    eq = rw.equilibrium(bridle())
    material = Material(2.6 * 9.80665, 1.0 / 24e6)
    knot, total = np.array([eq[f"knot.{axis}"] for axis in "xyz"]), -800.0 * 9.80665 * UP
    for name, length in (("p", 55.0), ("q", 56.0), ("r", 42.0)):
        force = np.array([eq[f"{name}_knot.force_{axis}"] for axis in "xyz"])
        start = np.array([eq[f"{name}.{axis}"] for axis in "xyz"])
        hung = by_quadrature(force[None], np.array([[length]]), np.zeros((1, 1)), material)
        assert hung.node[0, -1] == pytest.approx(knot - start, abs=1e-9)
        total -= force + 2.6 * 9.80665 * length * UP
    assert total == pytest.approx(np.zeros(3), abs=1e-6)


def test_a_net_against_published_displacements() -> None:
    eq = rw.equilibrium(published_net())
    moved = [(eq[f"n11.{axis}"] - at) / FOOT for axis, at in zip("xyz", (BAY, BAY, -SAG), strict=True)]
    assert moved[:2] == pytest.approx([-0.1328, -0.1328], abs=1e-4)
    assert moved[2] == pytest.approx(-1.4745, rel=2e-3)
    assert eq.certificate["holds"].all()


def test_joints_in_runs_and_reports() -> None:
    s = bridle()
    result = rw.simulate(s, until=2.0, every=1.0, progress=False)
    assert result.frame["knot.x"].iloc[-1] == pytest.approx(rw.equilibrium(s)["knot.x"], abs=1e-9)
    assert result.summary().supports.loc["knot", "kind"] == "Joint"
    assert abs(result.energy()["residual"]) < 1e-6
    heavier = rw.equilibrium(s, parameters={"knot.mass": 1600.0})
    assert heavier["knot.z"] < rw.equilibrium(s)["knot.z"]


def test_rejected_joints() -> None:
    with pytest.raises(rw.InputError, match="mass"):
        rw.Joint("j", at=(0.0, 0.0), mass=-1.0)
    s = rw.System("full")
    joint = s.add(rw.Joint("j", at=(0.0, 0.0), ends=2))
    for k in range(2):
        s.string(ROPE, rw.Anchor(f"a{k}", at=(50.0 * (-1) ** k, 20.0)), joint, length=60.0)
    with pytest.raises(rw.InputError, match=r"2 ends .* are used"):
        s.string(ROPE, rw.Anchor("a2", at=(0.0, 50.0)), joint, length=60.0)
    over = (rw.Anchor("a3", at=(-50.0, 50.0)), rw.Joint("k", at=(0.0, 0.0)), rw.Anchor("a4", at=(50.0, 50.0)))
    with pytest.raises(rw.InputError, match="End the rope there"):
        s.string(ROPE, *over, length=160.0)
