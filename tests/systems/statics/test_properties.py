"""Properties that hold for any span and any idler line."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

import ropeway as rw
from support.lines import GRAVITY, random_line

Point = tuple[float, float, float]
# Drawn without regard to their strength.
pytestmark = pytest.mark.filterwarnings("ignore::ropeway.components.errors.RopewayWarning")


@dataclass(frozen=True)
class Drawn:
    """A span with loads at shares of its length."""

    rope: rw.Rope
    end: Point
    length: float
    at: tuple[float, ...]
    masses: tuple[float, ...]

    def solve(self, start: Point = (0.0, 0.0, 0.0)) -> rw.Equilibrium:
        s = rw.System("drawn")
        end = tuple(float(v) for v in np.add(start, self.end))
        (span,) = s.string(self.rope, rw.Anchor("a", at=start), rw.Anchor("b", at=end), length=self.length)
        for i, (at, mass) in enumerate(zip(self.at, self.masses, strict=True)):
            s.hang(rw.Load(f"l{i}", mass=mass), span, at=at * self.length)
        return rw.equilibrium(s)

    @property
    def weight(self) -> float:
        return (self.rope.mass_per_length * self.length + sum(self.masses)) * GRAVITY


@st.composite
def spans(draw: st.DrawFn) -> Drawn:
    mass = draw(st.floats(0.5, 5.0))
    stiffness = draw(st.sampled_from([np.inf, mass * 1e7]))
    stretch = draw(st.sampled_from([rw.Elastic(), rw.ConstructionStretch()]))
    rope = rw.Rope(mass_per_length=mass, axial_stiffness=stiffness, breaking_load=mass * 1.8e5, stretch=stretch)
    across, turn = draw(st.floats(5.0, 500.0)), draw(st.floats(-3.0, 3.0))
    end = (across * np.cos(turn), across * np.sin(turn), across * draw(st.floats(-2.0, 2.0)))
    length = float(np.linalg.norm(end)) * (1.0 + 10.0 ** draw(st.floats(-4.0, -0.3)))
    count = draw(st.integers(0, 4))
    at = tuple(sorted(draw(st.lists(st.floats(0.01, 0.99), min_size=count, max_size=count))))
    masses = draw(st.lists(st.floats(0.01, 3.0), min_size=count, max_size=count))
    return Drawn(rope, tuple(map(float, end)), length, at, tuple(m * mass * length for m in masses))


def vectors(eq: rw.Equilibrium) -> tuple[np.ndarray, np.ndarray]:
    """Forces of the rope on its two anchors."""
    return tuple(np.array([eq[f"{name}.pull_{axis}"] for axis in "xyz"]) for name in "ab")  # type: ignore[return-value]


def tops(eq: rw.Equilibrium) -> float:
    return max(eq["a_b.tension_a"], eq["a_b.tension_b"])


@given(spans())
def test_forces_sum_to_zero(drawn: Drawn) -> None:
    eq = drawn.solve()
    a, b = vectors(eq)
    np.testing.assert_allclose(a + b, [0.0, 0.0, -drawn.weight], atol=1e-10 * (tops(eq) + drawn.weight))


@given(spans())
def test_moments_sum_to_zero(drawn: Drawn) -> None:
    """About end a: the anchor's pull at b, the loads, and the rope's own weight along its curve."""
    eq = drawn.solve()
    _, pull = vectors(eq)
    cuts = np.array([0.0, *(at * drawn.length for at in drawn.at), drawn.length])
    x, share = np.polynomial.legendre.leggauss(40)
    moment = np.cross(drawn.end, -pull)
    for a, b in pairwise(cuts):
        if b > a:
            place = eq.profile("a_b", a + (b - a) * (x + 1.0) / 2.0)[["x", "y", "z"]].to_numpy()
            own = drawn.rope.mass_per_length * GRAVITY * (b - a) / 2.0
            moment += np.cross(share @ place * own, [0.0, 0.0, -1.0])
    for i, mass in enumerate(drawn.masses):
        moment += np.cross([eq[f"l{i}.{axis}"] for axis in "xyz"], [0.0, 0.0, -mass * GRAVITY])
    np.testing.assert_allclose(moment, 0.0, atol=1e-8 * tops(eq) * drawn.length)


@given(spans())
def test_mirror_image(drawn: Drawn) -> None:
    eq = drawn.solve()
    mirrored = replace(
        drawn,
        end=(drawn.end[0], drawn.end[1], -drawn.end[2]),
        at=tuple(1.0 - at for at in drawn.at[::-1]),
        masses=drawn.masses[::-1],
    ).solve()
    assert mirrored["a_b.tension_a"] == pytest.approx(eq["a_b.tension_b"], abs=1e-9 * tops(eq))
    assert mirrored["a_b.vertical_a"] == pytest.approx(eq["a_b.vertical_b"], abs=1e-9 * tops(eq))
    n = len(drawn.at)
    for i in range(n):
        there, here = mirrored[f"l{n - 1 - i}.z"] + drawn.end[2], eq[f"l{i}.z"]
        assert there == pytest.approx(here, abs=1e-7)


@given(spans(), st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), st.floats(-3.0, 3.0))
def test_moved_and_turned(drawn: Drawn, start: Point, turn: float) -> None:
    eq = drawn.solve()
    c, s = np.cos(turn), np.sin(turn)
    spin = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    moved = replace(drawn, end=tuple(map(float, spin @ drawn.end))).solve(start)
    for one, other in zip(vectors(moved), vectors(eq), strict=True):
        # The end points are rounded to 1e-13 m; a taut rope amplifies the error.
        np.testing.assert_allclose(one, spin @ other, atol=2e-8 * tops(eq))
    for i in range(len(drawn.at)):
        place = np.array([eq[f"l{i}.{axis}"] for axis in "xyz"])
        np.testing.assert_allclose([moved[f"l{i}.{axis}"] for axis in "xyz"], spin @ place + start, atol=1e-7)


@given(spans(), st.floats(0.05, 0.95))
@settings(max_examples=25)
def test_cut_in_two_by_a_sheave_on_its_own_curve(drawn: Drawn, share: float) -> None:
    assume(all(abs(at - share) > 1e-3 for at in drawn.at))  # otherwise a load would be on the sheave
    eq = drawn.solve()
    cut = share * drawn.length
    place = eq.profile("a_b", [cut]).iloc[0]
    s = rw.System("cut")
    ends = rw.Anchor("a", at=(0.0, 0.0, 0.0)), rw.Anchor("b", at=drawn.end)
    middle = rw.ControlSheave("m", at=(place.x, place.y, place.z))
    nodes = [s.add(node) for node in (ends[0], middle, ends[1])]
    parts = [
        s.add(rw.Span("a_m", rope=drawn.rope, length=cut)),
        s.add(rw.Span("m_b", rope=drawn.rope, length=drawn.length - cut)),
    ]
    for span, a, b in zip(parts, nodes[:-1], nodes[1:], strict=True):
        s.connect(span.a, a.leaving)
        s.connect(span.b, b.arriving)
    for i, (at, mass) in enumerate(zip(drawn.at, drawn.masses, strict=True)):
        s.hang(rw.Load(f"l{i}", mass=mass), parts, at=at * drawn.length)
    two = rw.equilibrium(s)
    assert two["a_m.tension_a"] == pytest.approx(eq["a_b.tension_a"], abs=1e-7 * tops(eq))
    assert two["m_b.tension_b"] == pytest.approx(eq["a_b.tension_b"], abs=1e-7 * tops(eq))
    assert two["m.tension_in"] == pytest.approx(place.tension, abs=1e-7 * tops(eq))
    for i in range(len(drawn.at)):
        assert two[f"l{i}.z"] == pytest.approx(eq[f"l{i}.z"], abs=1e-6)


@given(st.integers(0, 10_000))
@settings(max_examples=20)
def test_cut_by_an_idler(seed: int) -> None:
    """An idler on the curve of a taut span has no load and changes nothing."""
    rng = np.random.default_rng(seed)
    rope = rw.Rope(mass_per_length=2.0, axial_stiffness=2e7, breaking_load=3.6e5)
    end, length = (200.0, 0.0, float(rng.uniform(-80.0, 80.0))), 0.0
    length = float(np.linalg.norm(end)) * (1.0 + float(rng.uniform(1e-4, 5e-3)))
    drawn = Drawn(rope, end, length, (), ())
    eq = drawn.solve()
    place = eq.profile("a_b", [float(rng.uniform(0.1, 0.9)) * length]).iloc[0]
    s = rw.System("cut")
    nodes = rw.Anchor("a", at=(0.0, 0.0, 0.0)), rw.Sheave("m", at=(place.x, place.y, place.z)), rw.Anchor("b", at=end)
    s.string(rope, *nodes, length=length)
    two = rw.equilibrium(s)
    assert two["a_m.tension_a"] == pytest.approx(eq["a_b.tension_a"], rel=1e-7)
    assert two["m_b.tension_b"] == pytest.approx(eq["a_b.tension_b"], rel=1e-7)
    assert two["a_m.length"] == pytest.approx(place.station, abs=1e-5)
    assert two["m.bearing_load"] == pytest.approx(0.0, abs=1e-5 * eq["a_b.tension_a"])


@given(spans())
def test_the_tension_invariant(drawn: Drawn) -> None:
    """The tension law with construction stretch: the strain potential increases by w times the height."""
    eq = replace(drawn, at=(), masses=()).solve()
    c1, c2, _ = drawn.rope.strain
    low, high = eq["a_b.tension_a"], eq["a_b.tension_b"]

    def potential(t: float) -> float:
        return t + c1 * t**2 / 2.0 + c2 * t**3 / 3.0

    gained = drawn.rope.mass_per_length * GRAVITY * drawn.end[2]
    assert potential(high) - potential(low) == pytest.approx(gained, abs=1e-10 * tops(eq) + 1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_idler_lines(seed: int) -> None:
    """Without friction the strain potential of an empty line is a function of the height alone."""
    case = random_line(seed, most=10, controlled=False)
    s = rw.System("empty")
    last = len(case.points) - 1
    nodes = [(rw.Anchor if k in (0, last) else rw.Sheave)(f"s{k}", at=tuple(p)) for k, p in enumerate(case.points)]
    s.string(case.rope, *nodes, tension=60.0 * case.rope.mass_per_length * GRAVITY * np.ptp(case.points[:, 2]) + 3e4)
    eq = rw.equilibrium(s)
    c1, c2, _ = case.rope.strain
    tension = np.array([eq[f"s{k}_s{k + 1}.tension_a"] for k in range(last)] + [eq[f"s{last - 1}_s{last}.tension_b"]])
    potential = tension + c1 * tension**2 / 2.0 + c2 * tension**3 / 3.0
    weight = case.rope.mass_per_length * GRAVITY
    np.testing.assert_allclose(potential - weight * case.points[:, 2], potential[0], rtol=1e-9)
    pull = sum(np.array([eq[f"s{k}.pull_{axis}"] for axis in "xyz"]) for k in (0, last))
    held = sum(eq[f"s{k}.support_force"] for k in range(1, last))
    total = weight * sum(eq[f"s{k}_s{k + 1}.length"] for k in range(last))
    assert held - pull[2] == pytest.approx(total, abs=1e-8 * tension.max())
