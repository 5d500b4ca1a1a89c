"""Lyons' (2008) three methods against quadrature of the cable's strain, and all printed numbers."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

import ropeway as rw
from ropeway.components.catenary import Strain, segment
from ropeway.components.errors import InputError
from ropeway.systems.studies.handbook.cable_stretch import (
    UnstretchedLength,
    fit_construction_stretch,
    strain_law,
    stretched_position,
    unstretched_length,
)
from ropeway.systems.studies.handbook.lyons_cases import (
    CASES,
    flexibility,
    locus_phi,
    psi_average,
    psi_construction,
    psi_elastic,
    strength,
    taut_phi,
    twelve_cases,
)

LYONS = json.loads((Path(__file__).parents[3] / "reference" / "lyons_2008.json").read_text())
G = 9.80665
ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)


def quadrature(rope: rw.Rope, unstretched: float, horizontal: float, vertical: float, strain: Strain) -> float:
    """Stretched length by integration of 1 + eps(T) along the rope."""
    w = rope.mass_per_length * G

    def excess(s: float) -> float:
        return strain.at(np.hypot(horizontal, vertical - w * s))

    belly = vertical / w
    breaks = [belly] if 0.0 < belly < unstretched else None
    return unstretched + quad(excess, 0.0, unstretched, points=breaks, epsabs=0.0, epsrel=1e-13, limit=200)[0]


ropes = st.builds(
    lambda m, c, s: rw.Rope(
        mass_per_length=m, axial_stiffness=m * 1e7, breaking_load=m * 1.7e5 * s, stretch=rw.ConstructionStretch(c)
    ),
    m=st.floats(0.3, 6.0),
    c=st.floats(0.0, 0.08),
    s=st.floats(0.6, 1.4),
)


@settings(max_examples=150, deadline=None)
@given(
    rope=ropes,
    length=st.floats(5.0, 800.0),
    pull=st.floats(0.005, 0.45),
    lean=st.floats(-2.0, 2.0),
    method=st.sampled_from(["elastic", "elastic and construction"]),
)
def test_exact_methods_agree_with_quadrature(
    rope: rw.Rope, length: float, pull: float, lean: float, method: Any
) -> None:
    horizontal = pull * rope.breaking_load / np.hypot(1.0, lean)
    found = unstretched_length(rope, length=length, horizontal=horizontal, vertical=lean * horizontal, method=method)
    strain = strain_law(rope, construction=method != "elastic")
    back = quadrature(rope, float(found), horizontal, lean * horizontal, strain)
    assert back == pytest.approx(length, rel=1e-12)
    along = stretched_position(
        rope, stations=float(found), horizontal=horizontal, vertical=lean * horizontal, method=method
    )
    assert along == pytest.approx(length, rel=1e-12)
    assert found.weight == pytest.approx(rope.mass_per_length * G * float(found))
    assert found.tension_b == pytest.approx(np.hypot(horizontal, lean * horizontal - found.weight))


@settings(max_examples=150, deadline=None)
@given(rope=ropes, length=st.floats(5.0, 800.0), pull=st.floats(0.005, 0.45), lean=st.floats(-2.0, 2.0))
def test_average_tension_is_within_its_stated_error(rope: rw.Rope, length: float, pull: float, lean: float) -> None:
    horizontal = pull * rope.breaking_load / np.hypot(1.0, lean)
    force = {"length": length, "horizontal": horizontal, "vertical": lean * horizontal}
    average = unstretched_length(rope, method="average tension", **force)
    exact = unstretched_length(rope, method="elastic", **force)
    relative = 1.0 - float(average) / float(exact)
    bound = exact.weight / rope.axial_stiffness * min(0.25, exact.weight / (12.0 * horizontal))
    assert -1e-14 <= relative <= bound * (1.0 + 1e-3) + 1e-14


def test_readme_call_and_arrays() -> None:
    one = rw_call("elastic")
    assert float(one) == pytest.approx(249.70714456, abs=1e-7)
    assert one.stretch == pytest.approx(250.0 - float(one))
    many = unstretched_length(ROPE, length=np.array([100.0, 250.0]), horizontal=40e3, vertical=12e3)
    assert many.length.shape == (2,)
    assert many.length[1] == pytest.approx(float(one), rel=1e-14)
    assert many.vertical_a + many.vertical_b == pytest.approx(many.weight)


def rw_call(method: Any) -> UnstretchedLength:
    return unstretched_length(ROPE, length=250.0, horizontal=40e3, vertical=12e3, method=method)


def test_lyons_construction_stretch_is_the_default() -> None:
    plain = rw_call("elastic and construction")
    new = rw.Rope(
        mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3, stretch=rw.ConstructionStretch(0.0414)
    )
    own = unstretched_length(new, length=250.0, horizontal=40e3, vertical=12e3, method="elastic and construction")
    assert float(own) == float(plain)
    assert float(plain) < float(rw_call("elastic"))


def test_coordinates_with_construction_stretch() -> None:
    """x(s) and z(s) with construction stretch (Turk 2.48, 2.52 with the closed form of T^2 added)."""
    h, v, w, length = 40e3, 25e3, 3.48 * G, 250.0
    strain = Strain(1 / 34.8e6, 0.0414 / 576.6e3**2)

    def part(component: Callable[[float], float]) -> float:
        def integrand(s: float) -> float:
            t = np.hypot(h, v - w * s)
            return component(s) / t * (1.0 + strain.at(t))

        return quad(integrand, 0.0, length, epsabs=0.0, epsrel=1e-13)[0]

    reach = segment((h, 0.0, -v), w, length, strain).reach
    assert reach[0] == pytest.approx(part(lambda s: h), rel=1e-12)
    assert -reach[2] == pytest.approx(part(lambda s: v - w * s), rel=1e-12)
    u0, u1 = v / h, (v - w * length) / h
    k = strain.c2
    dx = k * h**3 / w * 0.5 * ((u0 * np.hypot(1, u0) + np.arcsinh(u0)) - (u1 * np.hypot(1, u1) + np.arcsinh(u1)))
    dz = k * h**3 / (3 * w) * ((1 + u0**2) ** 1.5 - (1 + u1**2) ** 1.5)
    plain = segment((h, 0.0, -v), w, length, Strain(1 / 34.8e6, 0.0)).reach
    assert reach[0] - plain[0] == pytest.approx(dx, rel=1e-9)
    assert plain[2] - reach[2] == pytest.approx(dz, rel=1e-9)


def test_printed_ranges() -> None:
    beta = flexibility(np.array(LYONS["beta"]["lengths"]), gravity=LYONS["gravity"])
    assert np.round(beta * 1e6, 1) == pytest.approx(np.array(LYONS["beta"]["printed"]) * 1e6, abs=0.051)
    p = LYONS["phi"]
    phi = taut_phi(p["tension"], p["slope"], p["weight"], p["length"])
    assert round(float(phi), 1) == p["printed"]
    t = LYONS["tau"]
    tau = strength(*(np.array(t[k]) for k in ("mass_per_length", "breaking_load", "length")), gravity=LYONS["gravity"])
    assert np.round(tau).tolist() == t["printed"]


def test_construction_stretch_fit() -> None:
    table = LYONS["table_1"]
    fit = fit_construction_stretch(table["safety_factors"], table["elongations"])
    assert round(fit.coefficient, 4) == table["coefficient"]
    assert round(fit.r_squared, 4) == table["r_squared"]
    for factor, low in table["low_by"].items():
        elongation = dict(zip(table["safety_factors"], table["elongations"], strict=True))[float(factor)]
        assert 1.0 - 0.0414 / float(factor) ** 2 / elongation == pytest.approx(low, abs=0.006)


def test_construction_stretch_of_another_rope_is_recovered() -> None:
    factors = np.array([2.0, 3.0, 4.0, 6.0])
    fit = fit_construction_stretch(factors, 0.03 / factors**2)
    assert fit.coefficient == pytest.approx(0.03, rel=1e-14)
    assert fit.r_squared == pytest.approx(1.0)


def test_cases_1_to_4() -> None:
    reference = LYONS["cases_1_to_4"]
    phi = np.linspace(0.2, 33.0, 3281)
    table = twelve_cases(phi)
    for case, worst in reference["exact_worst"].items():
        assert table[table["case"] == int(case)]["ratio"].min() == pytest.approx(worst, abs=6e-7)
    fourth = table[table["case"] == 4].reset_index()
    assert fourth["phi"][fourth["ratio"].idxmin()] == pytest.approx(reference["worst_phi_of_case_4"], abs=0.011)
    assert round(table[table["case"] <= 4]["ratio"].min() + 5e-6, 5) == reference["printed_worst"]


def test_locus_of_a_third() -> None:
    reference = LYONS["locus_at_a_third"]
    for case in CASES[4:]:
        phi = locus_phi(case.tau, case.slope)
        chi = phi / case.slope
        assert np.hypot(phi, chi) == pytest.approx(case.tau / 3.0, rel=1e-14)
        ratio = psi_average(case.beta, phi, chi) / psi_construction(case.beta, phi, chi, case.tau)
        assert ratio == pytest.approx(reference["exact"][str(case.number)], abs=5.1e-7)
        assert (round(float(ratio), 4) == reference["printed"]) == (case.number in reference["printed_as_is"])
    assert locus_phi(377.0, 1.0) == pytest.approx(reference["phi_of_cases_6_and_10"], abs=5e-4)
    for number, value in reference["printed_phi_exact"].items():
        case, phi = CASES[int(number) - 1], reference["printed_phi"]
        ratio = psi_average(case.beta, phi, phi) / psi_construction(case.beta, phi, phi, case.tau)
        assert ratio == pytest.approx(value, abs=5.1e-7)
        assert round(float(ratio), 4) != reference["printed_phi_ratio"]  # printed, not reproducible


def test_impossible_cases_are_marked() -> None:
    assert [c.number for c in CASES if not c.possible] == LYONS["impossible_cases"]
    table = twelve_cases([33.0]).set_index("case")
    assert not table.loc[LYONS["impossible_cases"], "possible"].any()
    assert not table.loc[11, "possible"]  # beta and tau of a rope, but above its breaking load
    assert table.loc[12, "possible"]
    for number in ("7", "11"):
        assert table.loc[int(number), "ratio"] == pytest.approx(LYONS["worst_over_phi"][number], abs=5.1e-5)
        assert table.loc[int(number), "utilisation"] == pytest.approx(LYONS["worst_over_phi"]["utilisation"], abs=5e-3)


@settings(max_examples=60, deadline=None)
@given(beta=st.floats(1e-5, 3e-4), phi=st.floats(-20.0, 30.0), chi=st.floats(0.05, 100.0), tau=st.floats(40.0, 400.0))
def test_dimensionless_forms_are_the_printed_equations(beta: float, phi: float, chi: float, tau: float) -> None:
    """Eq. 24 as printed; eq. 25 with the corrected last term, and as printed."""
    a, b = (phi - 1.0) / chi, phi / chi
    brace = a * np.hypot(1, a) + np.arcsinh(a) - b * np.hypot(1, b) - np.arcsinh(b)
    elastic = 1.0 - chi**2 * beta / 2.0 * brace
    assert psi_elastic(beta, phi, chi) == pytest.approx(1.0 / elastic, rel=1e-12)
    construction = 0.0414 / tau**2 * (chi**2 + phi**2 - phi + 1.0 / 3.0)
    assert psi_construction(beta, phi, chi, tau) == pytest.approx(1.0 / (elastic + construction), rel=1e-12)
    printed = 1.0 - chi**2 * beta / 2.0 * (brace - np.arcsinh(b)) + construction
    if printed > 0.1:
        assert psi_construction(beta, phi, chi, tau, as_printed=True) == pytest.approx(1.0 / printed, rel=1e-12)


def test_dimensional_and_dimensionless_agree() -> None:
    found = rw_call("elastic and construction")
    w = float(found.weight)
    psi = psi_construction(w / 34.8e6, 12e3 / w, 40e3 / w, 576.6e3 / w)
    assert psi * 250.0 == pytest.approx(float(found), rel=1e-14)


def test_implicit_weight_is_solved() -> None:
    """Eq. 11 and 19 contain W = w L0 with the unknown L0."""
    w = 3.48 * G
    strain = strain_law(ROPE, construction=True)
    root = brentq(lambda s: quadrature(ROPE, s, 40e3, 12e3, strain) - 250.0, 200.0, 260.0, xtol=1e-12)
    assert float(rw_call("elastic and construction")) == pytest.approx(root, rel=1e-12)
    assert rw_call("elastic").weight == pytest.approx(w * float(rw_call("elastic")), rel=1e-14)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"length": -1.0}, "length"),
        ({"length": float("nan")}, "length"),
        ({"horizontal": 0.0}, "horizontal"),
        ({"horizontal": -5.0}, "horizontal"),
        ({"vertical": float("inf")}, "vertical"),
        ({"method": "guess"}, "method"),
    ],
)
def test_bad_input(change: dict[str, Any], word: str) -> None:
    arguments: dict[str, Any] = {"length": 250.0, "horizontal": 40e3, "vertical": 12e3, "method": "elastic"} | change
    with pytest.raises(InputError, match=word):
        unstretched_length(ROPE, **arguments)


def test_bad_tables() -> None:
    with pytest.raises(InputError, match="two or more"):
        fit_construction_stretch([8.0], [0.001])
    with pytest.raises(InputError, match="safety factor"):
        fit_construction_stretch([0.5, 2.0], [0.001, 0.01])
    with pytest.raises(InputError, match="elongation"):
        fit_construction_stretch([8.0, 2.0], [0.125, 1.0])
    with pytest.raises(InputError, match="average tension"):
        stretched_position(ROPE, stations=1.0, horizontal=1.0, vertical=1.0, method="average tension")
    with pytest.raises(InputError, match="chi"):
        psi_elastic(1e-4, 1.0, 0.0)
