"""The closed-form segment: limits, invariants, and one implementation for numbers, arrays and symbols."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, strategies as st

from ropeway.components import catenary
from ropeway.components.catenary import Strain
from support.oracle import Material, by_ode

EA = 34.8e6
STRAINS = {"elastic": Strain(1.0 / EA, 0.0), "inextensible": Strain(0.0, 0.0), "new": Strain(1.0 / EA, 1.2e-13)}

forces = st.tuples(st.floats(50.0, 5e5), st.floats(-5e5, 5e5), st.floats(-5e5, 5e5))
weights = st.floats(1.0, 100.0)
lengths = st.floats(0.1, 2000.0)
strains = st.sampled_from(list(STRAINS.values()))


@pytest.mark.parametrize("strain", STRAINS.values(), ids=STRAINS)
@pytest.mark.parametrize("force", [(2e4, 0.0, -3e3), (300.0, 400.0, -2e3), (1e5, -2e4, 8e4), (10.0, 0.0, 500.0)])
def test_a_segment_solves_the_differential_equations(force: catenary.Vector, strain: Strain) -> None:
    piece = catenary.segment(force, 34.1, 130.0, strain)
    known = by_ode(np.array([force]), np.array([[130.0]]), np.zeros((1, 1)), Material(34.1, *strain[:2]))
    np.testing.assert_allclose(piece.reach, known.node[0, 0], rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(piece.force, known.end[0], rtol=1e-13, atol=1e-9)


@given(forces, weights, lengths, strains)
def test_reversed_it_is_the_same_curve(force: catenary.Vector, weight: float, length: float, strain: Strain) -> None:
    there = catenary.segment(force, weight, length, strain)
    back = catenary.segment((-there.force[0], -there.force[1], -there.force[2]), weight, length, strain)
    np.testing.assert_allclose(np.add(there.reach, back.reach), 0.0, atol=1e-11 * length)
    np.testing.assert_allclose(np.add(force, back.force), 0.0, atol=1e-12 * np.linalg.norm(force))


@given(forces, weights, lengths, st.floats(0.0, 1.0), strains)
def test_two_pieces_make_one(
    force: catenary.Vector, weight: float, length: float, share: float, strain: Strain
) -> None:
    whole = catenary.segment(force, weight, length, strain)
    one = catenary.segment(force, weight, share * length, strain)
    two = catenary.segment(one.force, weight, (1.0 - share) * length, strain)
    np.testing.assert_allclose(np.add(one.reach, two.reach), whole.reach, atol=1e-11 * length)


@given(forces, weights, lengths, strains)
def test_the_strain_potential_grows_with_height(
    force: catenary.Vector, weight: float, length: float, strain: Strain
) -> None:
    """The tension law: (T + T^2/(2 EA)) at the end less that at the start is w times the height gained."""
    piece = catenary.segment(force, weight, length, strain)
    low, high = (np.linalg.norm(f) for f in (force, piece.force))
    gain = high + (strain.c1 / 2.0 + strain.c2 * high / 3.0) * high**2
    gain -= low + (strain.c1 / 2.0 + strain.c2 * low / 3.0) * low**2
    assert gain == pytest.approx(weight * piece.reach[2], abs=1e-10 * (high + weight * length))


@given(forces, weights, lengths, strains)
def test_stretched_length_follows_from_tension(
    force: catenary.Vector, weight: float, length: float, strain: Strain
) -> None:
    stretched = catenary.stretched_length(force, weight, length, strain)
    s, share = np.polynomial.legendre.leggauss(60)
    v = force[2] + weight * length * (s + 1.0) / 2.0
    tension = np.sqrt(force[0] ** 2 + force[1] ** 2 + v**2)
    expected = length * (1.0 + np.sum(share * tension * (strain.c1 + strain.c2 * tension)) / 2.0)
    assert stretched == pytest.approx(expected, rel=1e-9)
    assert np.linalg.norm(catenary.segment(force, weight, length, strain).reach) <= stretched * (1.0 + 1e-12)


def test_a_light_rope_is_straight() -> None:
    strain = STRAINS["elastic"]
    force = (3e4, 0.0, 4e4)
    piece = catenary.segment(force, 1e-9, 100.0, strain)
    np.testing.assert_allclose(piece.reach, np.multiply(force, 100.0 / 5e4 * (1.0 + 5e4 / EA)), rtol=1e-11)


def test_a_hanging_rope_is_vertical() -> None:
    """No horizontal force: only the elastic stretch of T = v0 + w s."""
    piece = catenary.segment((0.0, 0.0, 1e3), 30.0, 200.0, STRAINS["elastic"])
    np.testing.assert_allclose(piece.reach, [0.0, 0.0, 200.0 + (1e3 * 200.0 + 30.0 * 200.0**2 / 2.0) / EA], rtol=1e-14)


def test_no_length_no_reach() -> None:
    piece = catenary.segment((1e4, 0.0, -2e3), 30.0, 0.0, STRAINS["new"])
    assert piece.reach == (0.0, 0.0, 0.0)
    assert piece.force == (1e4, 0.0, -2e3)


def test_a_taut_span_is_a_parabola() -> None:
    weight, across, tension = 30.0, 100.0, 5e6
    piece = catenary.segment((tension, 0.0, -weight * across / 2.0), weight, across, Strain(0.0, 0.0))
    assert piece.reach[2] == pytest.approx(0.0, abs=1e-12)
    assert across - piece.reach[0] == pytest.approx(weight**2 * across**3 / (24.0 * tension**2), rel=1e-5)


def test_construction_stretch_as_derived() -> None:
    """Lyons 2008, eq. 14, integrated: against the difference that the quadratic term makes."""
    k, h, v, weight, length = 1.2e-13, 4e4, -9e3, 30.0, 250.0
    with_it = catenary.segment((h, 0.0, v), weight, length, Strain(0.0, k)).reach
    without = catenary.segment((h, 0.0, v), weight, length, Strain(0.0, 0.0)).reach
    u0, u1 = v / h, (v + weight * length) / h

    def primitive(u: float) -> float:
        return float(u * np.sqrt(1.0 + u * u) + np.arcsinh(u))

    dx = k * h**3 / weight * 0.5 * (primitive(u1) - primitive(u0))
    dz = k * h**3 / (3.0 * weight) * ((1.0 + u1 * u1) ** 1.5 - (1.0 + u0 * u0) ** 1.5)
    assert with_it[0] - without[0] == pytest.approx(dx, rel=1e-8)
    assert with_it[2] - without[2] == pytest.approx(dz, rel=1e-8)


def test_numbers_arrays_and_symbols_agree() -> None:
    force, strain = (2e4, 1e3, -3e3), STRAINS["new"]
    number = catenary.segment(force, 30.0, 120.0, strain)
    array = catenary.segment(tuple(np.full(3, f) for f in force), 30.0, np.array([60.0, 120.0, 180.0]), strain)
    for kind in (ca.SX, ca.MX):
        f, d = kind.sym("f", 3), kind.sym("d")
        piece = catenary.segment((f[0], f[1], f[2]), 30.0, d, strain)
        symbol = ca.Function("piece", [f, d], [ca.vertcat(*piece.reach), ca.vertcat(*piece.force)])
        reach, end = symbol(force, 120.0)
        np.testing.assert_allclose(np.array(reach).ravel(), number.reach, rtol=1e-14)
        np.testing.assert_allclose(np.array(end).ravel(), number.force, rtol=1e-14)
    np.testing.assert_allclose([c[1] for c in array.reach], number.reach, rtol=1e-14)


def test_a_loaded_span_jumps_at_its_loads() -> None:
    stations = catenary.loaded((2e4, 0.0, -6e3), 30.0, STRAINS["elastic"], 200.0, (50.0, 50.0, 120.0), (1e3, 2e3, 3e3))
    assert len(stations) == 4
    np.testing.assert_allclose([s.force[2] for s in stations], [-4500.0, -3500.0, 600.0, 6000.0])
    assert stations[0].reach == pytest.approx(stations[1].reach)


def test_a_profile_passes_through_its_stations() -> None:
    arguments = ((2e4, 5e3, -6e3), 30.0, STRAINS["elastic"], 200.0, (50.0, 120.0), (1e3, 3e3))
    stations = catenary.loaded(*arguments)
    profile = catenary.profile(*arguments, np.array([0.0, 50.0, 120.0, 200.0]))
    np.testing.assert_allclose(profile.reach[1:], [s.reach for s in stations], rtol=1e-13)
    np.testing.assert_allclose(profile.force[1:], [s.force for s in stations], rtol=1e-13)
    np.testing.assert_allclose(profile.reach[0], 0.0)
    np.testing.assert_allclose(profile.tension[0], np.linalg.norm((2e4, 5e3, -6e3)))
    np.testing.assert_allclose(profile.slope[0], -6e3 / np.hypot(2e4, 5e3))
