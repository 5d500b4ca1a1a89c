"""The first public scripts, and the interface of an equilibrium."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)


def one_span() -> rw.System:
    s = rw.System("one span")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -60.0)), length=408.0)
    s.hang(rw.Load("turn", mass=6000.0), span, at=190.0)
    return s


def idlers() -> rw.System:
    s = rw.System("idlers")
    spans = s.string(
        ROPE,
        rw.Anchor("a", at=(0, 0)),
        rw.Sheave("s1", at=(100, 5)),
        rw.Sheave("s2", at=(210, 2)),
        rw.Anchor("b", at=(300, 12)),
        length=303.0,
    )
    s.hang(rw.Load("l1", mass=400.0), spans, at=150.0)
    return s


def described(eq: rw.Equilibrium, *names: str) -> None:
    """Requires each quantity, with unit and description, in the frame and by name."""
    frame = eq.frame
    assert list(frame.columns) == ["value", "unit", "description"]
    assert frame["value"].dtype == float
    assert frame.index.name == "name"
    assert frame.index.is_unique
    for name in names:
        row = frame.loc[name]
        assert row["value"] == eq[name]
        assert np.isfinite(row["value"])
        assert row["unit"] in ("N", "m", "kg", "1", "rad")
        assert len(row["description"]) > 3
    assert frame["description"].str.len().gt(0).all()
    assert frame["unit"].str.len().gt(0).all()


def test_script_1() -> None:
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    s = rw.System("one span")
    (span,) = s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -60.0)), length=408.0)
    s.hang(rw.Load("turn", mass=6000.0), span, at=190.0)
    eq = rw.equilibrium(s)
    described(eq, "a_b.tension_a", "a_b.tension_b", "a_b.horizontal", "a_b.vertical_a", "turn.x", "turn.z")
    assert isinstance(eq.frame, pd.DataFrame)
    # By direct integration (tests/oracle.py).
    assert eq["a_b.tension_a"] == pytest.approx(200236.795138879, rel=1e-9)
    assert eq["a_b.tension_b"] == pytest.approx(188562.707360074, rel=1e-9)
    assert (eq["turn.x"], eq["turn.z"]) == pytest.approx((180.84002132, -61.71231266), abs=1e-7)
    assert eq["a_b.vertical_a"] > 0.0


def test_script_2() -> None:
    rope = ROPE
    s = rw.System("idlers")
    spans = s.string(
        rope,
        rw.Anchor("a", at=(0, 0)),
        rw.Sheave("s1", at=(100, 5)),
        rw.Sheave("s2", at=(210, 2)),
        rw.Anchor("b", at=(300, 12)),
        length=303.0,
    )
    s.hang(rw.Load("l1", mass=400.0), spans, at=150.0)
    eq = rw.equilibrium(s)
    described(eq, "s1_s2.length", "s1_s2.tension_a", "l1.z")
    rope_new = rw.Rope(
        mass_per_length=2.4, axial_stiffness=24.0e6, breaking_load=450.3e3, stretch=rw.ConstructionStretch(0.0414)
    )
    assert rope_new.strain.c2 == pytest.approx(0.0414 / 450.3e3**2)
    assert [span.name for span in spans] == ["a_s1", "s1_s2", "s2_b"]
    assert eq.loads["span"].tolist() == ["s1_s2"]
    assert sum(eq[f"{span.name}.length"] for span in spans) == pytest.approx(303.0, abs=1e-9)
    assert eq["s1.tension_in"] == pytest.approx(eq["s1.tension_out"], rel=1e-9)
    assert eq["s1_s2.length"] - 303.0 / 3.0 > 0.0


def test_a_tension_instead_of_a_length() -> None:
    s = rw.System("idlers")
    nodes = (
        rw.Anchor("a", at=(0, 0)),
        rw.Sheave("s1", at=(100, 5)),
        rw.Sheave("s2", at=(210, 2)),
        rw.Anchor("b", at=(300, 12)),
    )
    spans = s.string(ROPE, *nodes, tension=2.5e4)
    eq = rw.equilibrium(s)
    assert eq["a_s1.tension_a"] == pytest.approx(2.5e4, rel=1e-9)
    assert [eq[f"{span.name}.length"] for span in spans] == pytest.approx([span.length for span in spans], abs=1e-8)


def test_payload_for_a_tension() -> None:
    known = rw.equilibrium(one_span())
    eq = rw.equilibrium(one_span(), given={"a_b.tension_a": 150e3}, solve_for="turn.mass")
    assert eq["a_b.tension_a"] == pytest.approx(150e3, rel=1e-9)
    assert 0.0 < eq["turn.mass"] < known["turn.mass"]
    again = rw.equilibrium(one_span(), parameters={"turn.mass": eq["turn.mass"]})
    assert again["a_b.tension_a"] == pytest.approx(150e3, rel=1e-9)
    assert again["turn.z"] == pytest.approx(eq["turn.z"], abs=1e-7)


def test_length_for_a_position_and_for_a_tension() -> None:
    by_place = rw.equilibrium(one_span(), given={"turn.z": -58.0}, solve_for="a_b.length")
    assert by_place["turn.z"] == pytest.approx(-58.0, abs=1e-8)
    assert by_place["a_b.length"] < 408.0
    by_tension = rw.equilibrium(one_span(), given={"a_b.tension_b": 188562.707360074}, solve_for="a_b.length")
    assert by_tension["a_b.length"] == pytest.approx(408.0, abs=1e-6)


def test_the_taut_branch_for_a_tension() -> None:
    """A very slack rope has the same end tension: the solution is the taut one."""
    s = rw.System("level")
    s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(100.0, 0.0)), length=102.0)
    eq = rw.equilibrium(s, given={"a_b.tension_a": 4000.0}, solve_for="a_b.length")
    assert eq["a_b.tension_a"] == pytest.approx(4000.0, rel=1e-9)
    assert eq["a_b.length"] < 110.0
    assert eq["a_b.horizontal"] > 3000.0


def test_two_given_values_for_two_unknowns() -> None:
    s = one_span()
    eq = rw.equilibrium(s, given={"a_b.tension_a": 150e3, "turn.z": -60.0}, solve_for=["turn.mass", "a_b.length"])
    assert eq["a_b.tension_a"] == pytest.approx(150e3, rel=1e-9)
    assert eq["turn.z"] == pytest.approx(-60.0, abs=1e-8)


def test_given_on_idlers() -> None:
    eq = rw.equilibrium(idlers(), given={"l1.z": -5.0}, solve_for="l1.mass")
    assert eq["l1.z"] == pytest.approx(-5.0, abs=1e-8)
    assert eq["l1.mass"] < 400.0


def test_other_parameters() -> None:
    eq = rw.equilibrium(one_span(), parameters={"turn.mass": 3000.0, "b.z": -50.0, "a_b.length": 407.0})
    s = rw.System("one span")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -50.0)), length=407.0)
    s.hang(rw.Load("turn", mass=3000.0), span, at=190.0)
    known = rw.equilibrium(s)
    for name in ("a_b.tension_a", "a_b.tension_b", "turn.x", "turn.z"):
        assert eq[name] == pytest.approx(known[name], rel=1e-9)
    assert eq["turn.mass"] == 3000.0


def test_a_warm_start() -> None:
    model = rw.assemble(idlers())
    cold = rw.equilibrium(model)
    warm = rw.equilibrium(model, parameters={"l1.mass": 408.0}, start=cold)
    known = rw.equilibrium(model, parameters={"l1.mass": 408.0})
    assert warm["l1.mass"] == 408.0
    assert cold["l1.mass"] == 400.0
    for name in ("a_s1.tension_a", "s1_s2.length", "l1.x", "l1.z"):
        assert warm[name] == pytest.approx(known[name], rel=1e-9)


def test_a_model_keeps_its_declarations() -> None:
    s = one_span()
    model = rw.assemble(s)
    first = rw.equilibrium(model)
    s.hang(rw.Load("other", mass=500.0), next(c for c in s.components.values() if isinstance(c, rw.Span)), at=50.0)
    assert rw.equilibrium(model)["a_b.tension_a"] == first["a_b.tension_a"]
    assert rw.equilibrium(s)["a_b.tension_a"] > first["a_b.tension_a"]


def test_an_equilibrium_as_the_start_of_a_line() -> None:
    """A new solve from its own lengths moves nothing, and all travels are zero."""
    eq = rw.equilibrium(idlers())
    again = rw.equilibrium(eq.model, start=eq)
    for name in ("s1.travel", "s2.travel"):
        assert eq[name] == 0.0
        assert abs(again[name]) == 0.0
    for name in ("a_s1.length", "s1_s2.length", "s2_b.length", "a_s1.tension_a", "l1.z"):
        assert again[name] == pytest.approx(eq[name], rel=1e-10)


def test_a_load_outside_its_initial_span_moves_to_its_span() -> None:
    """The load's position on the whole string decides, not the empty rope."""
    s = idlers()
    for name, at in (("first", 20.0), ("middle", 140.0), ("last", 290.0)):
        s.hang(rw.Load(name, mass=50.0), [c for c in s.components.values() if isinstance(c, rw.Span)], at=at)
    eq = rw.equilibrium(s)
    spans = dict(zip(eq.loads["load"], eq.loads["span"], strict=True))
    assert (spans["first"], spans["middle"], spans["last"]) == ("a_s1", "s1_s2", "s2_b")
    assert eq["first.distance"] == pytest.approx(20.0)
    assert eq["middle.distance"] == pytest.approx(140.0 - eq["a_s1.length"])
    assert list(eq.loads.columns) == ["load", "span", "mass", "distance", "x", "y", "z"]


def test_a_rope_too_slack_for_its_idlers() -> None:
    """This long rope runs into one of the spans: no stable balance on the taut branch."""
    s = rw.System("slack")
    nodes = (rw.Anchor("a", at=(0, 0)), rw.Sheave("m", at=(100, 0)), rw.Anchor("b", at=(200, 0)))
    s.string(ROPE, *nodes, length=400.0)
    with pytest.raises(rw.EquilibriumError) as info:
        rw.equilibrium(s)
    assert info.value.remedy
    assert info.value.component is not None


def test_position_of_a_moved_support() -> None:
    """Figures and initial guesses use supports from the parameters, not from the declarations."""
    s = rw.System("moved")
    nodes = [rw.Anchor("a", at=(0.0, 0.0)), rw.Sheave("s", at=(100.0, 5.0)), rw.Anchor("b", at=(200.0, 0.0))]
    s.string(ROPE, *nodes, length=204.0)
    eq = rw.equilibrium(s, parameters={"s.z": 9.0, "s.x": 90.0})
    np.testing.assert_allclose(eq.points(0), [[0, 0, 0], [90, 0, 9], [200, 0, 0]])
    at_sheave = eq.profile("s_b", [0.0])
    assert (at_sheave["x"][0], at_sheave["z"][0]) == (90.0, 9.0)


@pytest.mark.parametrize("name", ["a_s1.length", "a_s1.length_start"])
def test_length_of_one_span_over_idlers_counts_from_those_at_rest(name: str) -> None:
    s = rw.System("idlers")
    ends = rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(300.0, 12.0))
    idlers = rw.Sheave("s1", at=(100.0, 5.0)), rw.Sheave("s2", at=(210.0, 2.0))
    spans = s.string(ROPE, ends[0], *idlers, ends[1], length=303.0)
    s.hang(rw.Load("l1", mass=400.0), spans, at=150.0)
    eq = rw.equilibrium(s)
    same = rw.equilibrium(s, parameters={name: eq["a_s1.length"]})
    assert same["a_s1.tension_a"] == pytest.approx(eq["a_s1.tension_a"], rel=1e-10)
    longer = rw.equilibrium(s, parameters={name: eq["a_s1.length"] + 0.1})
    assert sum(longer[f"{span.name}.length"] for span in spans) == pytest.approx(303.1, abs=1e-9)
    warm = rw.equilibrium(s, parameters={name: eq["a_s1.length"] + 0.1}, start=eq)
    assert longer["s2_b.tension_b"] == pytest.approx(warm["s2_b.tension_b"], rel=1e-9)


@pytest.mark.parametrize(("easting", "stiffness"), [(3.1e6, 11.2e6), (3.5e6, 14.3e6), (3.9e6, 18.3e6)])
def test_a_stiff_spring_in_national_coordinates_is_solved(easting: float, stiffness: float) -> None:
    """One long step already reduces the residual to the rounding of the coordinates."""

    def solved(origin: float) -> rw.Equilibrium:
        s, rope = rw.System("far"), rw.Rope(mass_per_length=1.9, axial_stiffness=75e6, breaking_load=1e6)
        nodes = [rw.Drum("d", at=(origin, 0.0, 900.0)), rw.Sheave("m", at=(origin + 23.0, 0.0, 899.0))]
        end = rw.SpringAnchor("e", at=(origin + 47.0, 0.0, 900.6), stiffness=stiffness)
        s.hang(rw.Load("l", mass=35.0), s.string(rope, *nodes, end, tension=50e3), at=6.0)
        return rw.equilibrium(s)

    near, far = solved(0.0), solved(easting)
    for name in ("d_m.tension_a", "m_e.tension_b"):
        assert far[name] == pytest.approx(near[name], rel=1e-6)
