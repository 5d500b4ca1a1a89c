"""A span as a user sees it: through a System and its equilibrium."""

from __future__ import annotations

import numpy as np
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
G = 9.80665


def solved(length: float = 408.0, at: float | None = 190.0) -> rw.Equilibrium:
    s = rw.System("one span")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -60.0)), length=length)
    if at is not None:
        s.hang(rw.Load("turn", mass=6000.0), span, at=at)
    return rw.equilibrium(s)


def test_outputs_are_consistent() -> None:
    eq = solved()
    f = np.array([eq[f"a_b.force_{axis}"] for axis in "xyz"])
    total = (3.48 * 408.0 + 6000.0) * G
    assert eq["a_b.tension_a"] == pytest.approx(np.linalg.norm(f))
    assert eq["a_b.horizontal"] == pytest.approx(np.hypot(f[0], f[1]))
    assert eq["a_b.vertical_a"] == pytest.approx(-f[2])
    assert eq["a_b.vertical_a"] + eq["a_b.vertical_b"] == pytest.approx(total)
    assert eq["a_b.tension_b"] == pytest.approx(np.hypot(eq["a_b.horizontal"], eq["a_b.vertical_b"]))
    assert eq["a_b.utilisation"] == pytest.approx(max(eq["a_b.tension_a"], eq["a_b.tension_b"]) / 576.6e3)
    assert eq["a_b.length"] == pytest.approx(408.0)
    assert eq["turn.distance"] == pytest.approx(190.0)
    assert eq["turn.mass"] == 6000.0


def test_pull_at_the_anchors() -> None:
    eq = solved()
    assert eq["a.tension"] == pytest.approx(eq["a_b.tension_a"])
    assert eq["b.tension"] == pytest.approx(eq["a_b.tension_b"])
    assert eq["a.pull_x"] == pytest.approx(eq["a_b.horizontal"])
    assert eq["b.pull_x"] == pytest.approx(-eq["a_b.horizontal"])
    assert eq["a.pull_z"] == pytest.approx(-eq["a_b.vertical_a"])
    assert eq["b.pull_z"] == pytest.approx(-eq["a_b.vertical_b"])


def test_a_load_at_an_end_leaves_the_span_alone() -> None:
    bare = solved(at=None)
    for at, end in ((0.0, "a"), (408.0, "b")):
        eq = solved(at=at)
        assert eq["a_b.horizontal"] == pytest.approx(bare["a_b.horizontal"], rel=1e-9)
        assert eq["turn.x"] == pytest.approx(eq[f"{end}.x"], abs=1e-9)
        assert eq["turn.z"] == pytest.approx(eq[f"{end}.z"], abs=1e-9)


def test_two_loads_at_one_place_are_one() -> None:
    s = rw.System("one span")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -60.0)), length=408.0)
    s.hang(rw.Load("one", mass=2500.0), span, at=190.0)
    s.hang(rw.Load("two", mass=3500.0), span, at=190.0)
    eq, known = rw.equilibrium(s), solved()
    assert eq["a_b.tension_a"] == pytest.approx(known["a_b.tension_a"], rel=1e-12)
    assert eq["one.z"] == pytest.approx(known["turn.z"], abs=1e-9)
    assert eq["two.z"] == pytest.approx(known["turn.z"], abs=1e-9)


def test_the_order_of_hanging_does_not_matter() -> None:
    results = []
    for order in ((0, 1, 2), (2, 0, 1)):
        s = rw.System("one span")
        (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -60.0)), length=408.0)
        for i in order:
            s.hang(rw.Load(f"l{i}", mass=500.0 * (i + 1)), span, at=100.0 * (i + 1))
        eq = rw.equilibrium(s)
        results.append([eq["a_b.tension_a"], *(eq[f"l{i}.z"] for i in range(3))])
    np.testing.assert_allclose(results[0], results[1], rtol=1e-12)


def test_profile_of_a_span() -> None:
    eq = solved()
    curve = eq.profile("a_b", 11)
    assert list(curve.columns) == ["station", "x", "y", "z", "tension", "slope"]
    assert len(curve) == 12  # the load's station besides
    assert curve["station"].is_monotonic_increasing
    first, last = curve.iloc[0], curve.iloc[-1]
    assert (first.x, first.z) == (0.0, 0.0)
    assert (last.x, last.z) == pytest.approx((400.0, -60.0), abs=1e-8)
    assert first.tension == pytest.approx(eq["a_b.tension_a"])
    assert last.tension == pytest.approx(eq["a_b.tension_b"])
    at_load = curve[curve["station"] == 190.0].iloc[0]
    assert (at_load.x, at_load.z) == pytest.approx((eq["turn.x"], eq["turn.z"]))
    assert curve["z"].min() == pytest.approx(at_load.z, abs=0.5)


def test_a_longer_rope_sags_more() -> None:
    tensions = [solved(length)["a_b.tension_a"] for length in (405.0, 406.0, 410.0, 450.0)]
    assert tensions == sorted(tensions, reverse=True)


def test_a_new_rope_hangs_lower() -> None:
    new = rw.Rope(
        mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3, stretch=rw.ConstructionStretch(0.0414)
    )
    s = rw.System("one span")
    (span,) = s.string(new, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -60.0)), length=408.0)
    s.hang(rw.Load("turn", mass=6000.0), span, at=190.0)
    eq = rw.equilibrium(s)
    assert eq["turn.z"] < solved()["turn.z"]
    assert eq["a_b.tension_a"] < solved()["a_b.tension_a"]
