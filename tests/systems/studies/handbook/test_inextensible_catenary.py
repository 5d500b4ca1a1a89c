"""The catenary through two points, and the longest rope over a terrain, against quadrature and Harvey (2013)."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from ropeway.components.catenary import Strain, segment
from ropeway.components.errors import InputError, SlackRopeError
from ropeway.systems.studies.handbook.inextensible_catenary import (
    CatenaryCurve,
    catenary_for_horizontal,
    catenary_for_length,
    catenary_for_sag,
    catenary_for_tension,
    minimum_tension,
)
from ropeway.systems.studies.handbook.longest_rope import longest_rope

HARVEY = json.loads((Path(__file__).parents[3] / "reference" / "harvey_2013.json").read_text())
W = HARVEY["weight"]

curves = st.builds(
    lambda d, r, u: CatenaryCurve(d, r * d, d / (2.0 * u)),
    d=st.floats(5.0, 1000.0),
    r=st.floats(-1.5, 1.5),
    u=st.floats(1e-3, 3.0),
)


@settings(max_examples=100, deadline=None)
@given(curve=curves, place=st.floats(0.02, 0.98))
def test_all_functions_give_the_same_curve(curve: CatenaryCurve, place: float) -> None:
    d, r, a = float(curve.span), float(curve.rise), float(curve.parameter)
    same = pytest.approx(a, rel=1e-6)
    assert catenary_for_horizontal(d, r, 7.0 * a, 7.0).parameter == pytest.approx(a, rel=1e-14)
    assert catenary_for_length(d, r, curve.length).parameter == same
    assert catenary_for_sag(d, r, curve.sag(place * d), place).parameter == same
    tension = curve.forces(1.0).tension_start
    again = catenary_for_tension(d, r, tension, 1.0)
    assert again.forces(1.0).tension_start == pytest.approx(tension, rel=1e-12)
    assert float(again.parameter) >= a * (1.0 - 1e-6)  # the taut one of the two


@settings(max_examples=60, deadline=None)
@given(curve=curves)
def test_curve_is_a_hanging_rope(curve: CatenaryCurve) -> None:
    d, r, s = float(curve.span), float(curve.rise), float(curve.length)
    assert curve.height(0.0) == pytest.approx(0.0, abs=1e-9 * d)
    assert curve.height(d) == pytest.approx(r, abs=1e-9 * d)
    assert quad(lambda x: np.hypot(1.0, curve.slope(x)), 0.0, d, epsrel=1e-12)[0] == pytest.approx(s, rel=1e-9)
    f = curve.forces(2.5)
    assert f.vertical_start + f.vertical_end == pytest.approx(2.5 * s, rel=1e-9)
    assert f.tension_end - f.tension_start == pytest.approx(2.5 * r, abs=1e-9 * float(f.tension_end))
    assert np.hypot(f.horizontal, f.vertical_end) == pytest.approx(f.tension_end)
    reach = segment((float(f.horizontal), 0.0, -float(f.vertical_start)), 2.5, s, Strain(0.0, 0.0)).reach
    assert reach[0] == pytest.approx(d, rel=1e-9)
    assert reach[2] == pytest.approx(r, abs=1e-9 * s)
    assert curve.station(curve.slope(0.3 * d)) == pytest.approx(0.3 * d, rel=1e-6, abs=1e-6 * d)
    assert curve.slope(curve.lowest) == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(d=st.floats(10.0, 500.0), r=st.floats(-1.0, 1.0))
def test_least_tension(d: float, r: float) -> None:
    least = minimum_tension(d, r * d, W)
    found = catenary_for_tension(d, r * d, least * (1.0 + 1e-6), W)
    assert found.forces(W).tension_start == pytest.approx(least, rel=2e-6)
    with pytest.raises(SlackRopeError, match="it needs"):
        catenary_for_tension(d, r * d, least * (1.0 - 1e-6), W)


def test_sag_of_a_span_twice_its_parameter() -> None:
    """u = 1: the root of the sag's equation is at log u = 0."""
    curve = CatenaryCurve(5.0, 0.0, 2.5)
    assert catenary_for_sag(5.0, 0.0, curve.sag(1.0), 0.2).parameter == pytest.approx(2.5, rel=1e-12)


def test_arrays() -> None:
    curve = catenary_for_sag(200.0, np.array([0.0, -20.0, -40.0]), 25.0)
    assert curve.length.shape == (3,)
    reference = HARVEY["table_3"]["sag_at_midspan"]
    f = curve.forces(W)
    assert f.tension_start == pytest.approx(reference["tension"], abs=5.1e-4)
    assert f.vertical_start == pytest.approx(reference["vertical"], abs=5.1e-4)
    assert f.horizontal == pytest.approx(reference["horizontal"], abs=5.1e-4)


def test_harveys_appendix_1() -> None:
    """Parameters of Figure 3: H over w, not over w times the span."""
    a = HARVEY["appendix_1"]
    curve = catenary_for_horizontal(200.0, 0.0, np.array(a["horizontal"]), a["weight"])
    assert curve.parameter == pytest.approx(a["parameter"], abs=0.6)
    assert curve.sag(100.0)[0] == pytest.approx(a["sag"], abs=5e-3)
    assert np.array(curve.parameter) / 200.0 == pytest.approx(a["printed_parameter"], abs=0.06)


# ------------------------------------------------------------------ longest rope


@pytest.mark.parametrize("k", range(3))
def test_harveys_table_3_exact(k: int) -> None:
    slope, table = HARVEY["slopes"][k], HARVEY["table_3"]
    ground = -100.0 * slope - 25.0
    rope = longest_rope([0.0, 200.0], [ground, ground], (0.0, 0.0), (200.0, -200.0 * slope))
    f = rope.forces(W)
    assert rope.length == pytest.approx(table["length"][k], abs=5.1e-7)
    for name, value in (
        ("tension", f.tension_start),
        ("vertical", f.vertical_start),
        ("horizontal", f.horizontal),
    ):
        assert value == pytest.approx(table[name][k], abs=5.1e-4)
        too_high = 100.0 * (table["printed"][name][k] / float(value) - 1.0)
        assert too_high == pytest.approx(table["too_high_percent"][name][k], abs=0.06)
    p = table["printed"]  # a valid triple, of another catenary
    assert p["tension"][k] == pytest.approx(np.hypot(p["vertical"][k], p["horizontal"][k]), abs=0.01)


def test_rope_touches_inside_a_piece_of_terrain() -> None:
    """Both vertices clear the rope by metres; it touches the straight piece between them."""
    rope = longest_rope([0.0, 60.0, 140.0, 200.0], [-60.0, -25.0, -25.0, -60.0], (0.0, 0.0), (200.0, 0.0))
    assert rope.touches == pytest.approx(100.0, abs=1e-6)
    assert rope.height(100.0) == pytest.approx(-25.0, abs=1e-9)
    assert rope.height(60.0) > -24.0


def test_rope_touches_a_vertex() -> None:
    x, z = [0.0, 50.0, 100.0, 150.0, 200.0], [-10.0, -20.0, -15.0, -30.0, -10.0]
    rope = longest_rope(x, z, (0.0, 0.0), (200.0, 0.0), clearance=2.0)
    assert rope.touches == 100.0
    assert rope.height(100.0) == pytest.approx(-13.0, abs=1e-10)
    other = longest_rope(x, z, (200.0, 0.0), (0.0, 0.0), clearance=2.0)
    assert other.length == rope.length


@settings(max_examples=60, deadline=None)
@given(
    depths=st.lists(st.floats(3.0, 80.0), min_size=2, max_size=12),
    rise=st.floats(-60.0, 60.0),
    clearance=st.floats(0.0, 2.0),
)
def test_longest_rope_is_clear_and_longest(depths: list[float], rise: float, clearance: float) -> None:
    span = 200.0
    x = np.linspace(-10.0, span + 10.0, len(depths))
    z = rise * x / span - np.array(depths)
    rope = longest_rope(x, z, (0.0, 0.0), (span, rise), clearance=clearance)
    fine = np.union1d(np.linspace(0.0, span, 2001), x[(x > 0) & (x < span)])
    gap = rope.height(fine) - np.interp(fine, x, z) - clearance
    assert gap.min() > -1e-8
    longer = catenary_for_length(span, rise, rope.length * (1.0 + 1e-7))
    at = rope.touches
    assert longer.height(at) < np.interp(at, x, z) + clearance


def test_longest_rope_agrees_with_bisection_over_lengths() -> None:
    """Harvey's method on many nodes: bisection on the length."""
    x, z = np.array([0.0, 70.0, 130.0, 200.0]), np.array([-40.0, -22.0, -33.0, -60.0])
    nodes = np.linspace(0.0, 200.0, 20001)
    ground = np.interp(nodes, x, z)

    def gap(length: float) -> float:
        return float(np.min((catenary_for_length(200.0, -20.0, length).height(nodes) - ground)[1:-1]))

    length = brentq(gap, 201.01, 260.0, xtol=1e-10)
    assert longest_rope(x, z, (0.0, 0.0), (200.0, -20.0)).length == pytest.approx(length, abs=1e-6)


@pytest.mark.parametrize(
    ("stations", "elevations", "error", "word"),
    [
        ([0.0], [-5.0], InputError, "at least two"),
        ([0.0, 200.0], [-5.0], InputError, "as many elevations as stations"),
        ([0.0, 100.0, 100.0, 200.0], [-5.0, -9.0, -9.0, -5.0], InputError, "do not increase"),
        ([0.0, 100.0, float("nan")], [-5.0, -9.0, -5.0], InputError, "finite"),
        ([10.0, 190.0], [-5.0, -5.0], InputError, "Extend the profile"),
        ([0.0, 100.0, 200.0], [-5.0, 1.0, -5.0], SlackRopeError, "chord"),
        ([0.0, 200.0], [1.0, -5.0], SlackRopeError, "chord"),
    ],
)
def test_bad_profiles(stations: list[float], elevations: list[float], error: type[Exception], word: str) -> None:
    with pytest.raises(error, match=word):
        longest_rope(stations, elevations, (0.0, 0.0), (200.0, 0.0))


def test_bad_input() -> None:
    with pytest.raises(InputError, match="longer than its chord"):
        catenary_for_length(100.0, 0.0, 100.0)
    with pytest.raises(InputError, match="sag"):
        catenary_for_sag(100.0, 0.0, 0.0)
    with pytest.raises(InputError, match="station of the sag"):
        catenary_for_sag(100.0, 0.0, 5.0, 1.0)
    with pytest.raises(InputError, match="span"):
        catenary_for_horizontal(0.0, 0.0, 5.0, 1.0)
    with pytest.raises(InputError, match="weight"):
        catenary_for_horizontal(100.0, 0.0, 5.0, 0.0)
    with pytest.raises(InputError, match="two different stations"):
        longest_rope([0.0, 10.0], [-5.0, -5.0], (0.0, 0.0), (0.0, 5.0))
    with pytest.raises(InputError, match="clearance"):
        longest_rope([0.0, 10.0], [-5.0, -5.0], (0.0, 0.0), (10.0, 0.0), clearance=-1.0)
