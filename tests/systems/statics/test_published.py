"""Published cables: `tests/reference/cables.json` holds each number with its source."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ropeway as rw
from ropeway.components import catenary

CASES: dict[str, Any] = json.loads((Path(__file__).parents[2] / "reference" / "cables.json").read_text())
STRONG = 1e12
G = 9.80665
FOOT = 0.3048
POUND = 0.45359237 * G  # force


def rope(weight: float, axial_stiffness: float) -> rw.Rope:
    return rw.Rope(mass_per_length=weight / G, axial_stiffness=axial_stiffness, breaking_load=STRONG)


def span(made: rw.Rope, across: float, length: float, at: float, load: float) -> rw.Equilibrium:
    """A level span with one load, which may be almost weightless."""
    s = rw.System("published")
    (on,) = s.string(made, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(across, 0.0)), length=length)
    s.hang(rw.Load("joint", mass=load / G), on, at=at)
    return rw.equilibrium(s)


@pytest.mark.parametrize("state", ["unloaded", "loaded"])
def test_sap2000(state: str) -> None:
    """All printed digits: 6e-4 N and 6e-7 m."""
    case = CASES["SAP2000 7-002"]
    first, second = (length * FOOT for length in case["length_ft"])
    made = rope(case["weight_lbf_ft"] * POUND / FOOT, case["modulus_ksi"] * case["area_in2"] * 1e3 * POUND)
    assert case["weight_lbf_ft"] * POUND / FOOT == pytest.approx(46.116733, abs=1e-6)
    load = case["load_kip"] * 1e3 * POUND if state == "loaded" else 1e-9
    eq = span(made, case["span_ft"] * FOOT, first + second, first, load)
    for name, value in case[state].items():
        if name in "xz":
            assert eq[f"joint.{name}"] == pytest.approx(value, abs=6e-7)
        else:
            assert eq[f"a_b.{name}"] == pytest.approx(value, abs=6e-4)


def test_code_aster_ssnl114() -> None:
    case = CASES["code_aster SSNL114"]
    made = rw.Rope(
        mass_per_length=case["density"] * case["area"],
        axial_stiffness=case["modulus"] * case["area"],
        breaking_load=STRONG,
    )
    s = rw.System("SSNL114", gravity=case["gravity"])
    s.string(made, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(case["span"], 0.0)), length=case["length"])
    eq = rw.equilibrium(s)
    middle = eq.profile("a_b", [case["length"] / 2.0])["z"].iloc[0]
    assert -middle == pytest.approx(case["sag"], abs=1e-6)
    assert -middle == pytest.approx(case["printed_sag"], abs=5e-4)
    assert eq["a_b.horizontal"] == pytest.approx(case["horizontal"], abs=1e-3)


def test_rte_overhead_line() -> None:
    """An inextensible rope of the printed parameter; its length is that of the catenary."""
    case = CASES["RTE overhead line"]
    length = 2.0 * case["parameter"] * math.sinh(case["span"] / 2.0 / case["parameter"])
    assert length == pytest.approx(case["length"], abs=5e-4)
    s = rw.System("RTE")
    ends = rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(case["span"], 0.0))
    s.string(rope(case["weight"], math.inf), *ends, length=length)
    eq = rw.equilibrium(s)
    assert eq["a_b.horizontal"] == pytest.approx(case["horizontal"], rel=1e-9)
    assert eq["a_b.vertical_a"] == pytest.approx(case["vertical"], abs=1e-5)
    stations = (np.polynomial.legendre.leggauss(20)[0] + 1.0) * length / 2.0
    tension = eq.profile("a_b", stations)["tension"].to_numpy()
    mean = float(np.polynomial.legendre.leggauss(20)[1] @ tension / 2.0)
    assert mean == pytest.approx(case["mean_tension"], rel=1e-9)


def pulley(**amount: float) -> rw.System:
    case = CASES["code_aster pulley"]
    s = rw.System("pulley")
    nodes = (rw.Anchor("a", at=(0.0, 0.0)), rw.Sheave("m", at=(case["span"], 0.0)), rw.Anchor("b", at=(200.0, 0.0)))
    s.string(rope(case["weight"], case["axial_stiffness"]), *nodes, **amount)
    return s


def test_code_aster_pulley() -> None:
    """Tension 5000 N at the ends: exact sag 7.9397 m; the parabola gives 7.941 m, an error of 1.3 mm."""
    case = CASES["code_aster pulley"]
    eq = rw.equilibrium(pulley(tension=case["tension"]))
    for name in ("a_m", "m_b"):
        assert eq[f"{name}.tension_a"] == pytest.approx(case["tension"], rel=1e-9)
        middle = eq.profile(name, [eq[f"{name}.length"] / 2.0])["z"].iloc[0]
        assert -middle == pytest.approx(case["sag"], abs=5e-5)


def test_code_aster_ssnl100() -> None:
    """10 m paid in: exact 13.9397 m; 13.930 m is printed from few elements."""
    longer = CASES["code_aster pulley"]["longer"]
    eq = rw.equilibrium(pulley(length=2.0 * longer["length"]))
    for name in ("a_m", "m_b"):
        assert eq[f"{name}.tension_a"] == pytest.approx(longer["tension"], abs=6e-3)
        middle = eq.profile(name, [longer["length"] / 2.0])["z"].iloc[0]
        assert -middle == pytest.approx(longer["sag"], abs=5e-5)
    # The same rope with 10 m paid in by a drum.
    s = rw.System("paid in")
    case = CASES["code_aster pulley"]
    nodes = (rw.Drum("a", at=(0.0, 0.0)), rw.Sheave("m", at=(case["span"], 0.0)), rw.Anchor("b", at=(200.0, 0.0)))
    s.string(rope(case["weight"], case["axial_stiffness"]), *nodes, length=2.0 * longer["length"] - longer["paid_in"])
    paid = rw.equilibrium(s, parameters={"a.travel": longer["paid_in"]})
    assert paid["m_b.tension_b"] == pytest.approx(eq["m_b.tension_b"], rel=1e-9)


@pytest.mark.parametrize("number", CASES["Lyons construction stretch"]["cases"])
def test_lyons_construction_stretch(number: str) -> None:
    """psi_inf/psi_EC at T = tau/3. Printed 1.0044 for all; 5, 6, 7 and 11 round to 1.0045 or 1.0046."""
    lyons = CASES["Lyons construction stretch"]
    case = lyons["cases"][number]
    weight = 100.0  # of one metre of rope [N]: forces scale with it
    upward = weight * case["tau"] / 3.0 / math.sqrt(1.0 + 1.0 / case["slope"] ** 2)
    across = upward / case["slope"]
    made = rw.Rope(
        mass_per_length=weight / G,
        axial_stiffness=weight / case["beta"],
        breaking_load=weight * case["tau"],
        stretch=rw.ConstructionStretch(lyons["coefficient"]),
    )
    # One metre of unstretched rope with the force (-across, upward) at its upper end.
    start = (across, 0.0, -upward)
    stretched = catenary.stretched_length(start, weight, 1.0, made.strain)
    end = catenary.segment(start, weight, 1.0, made.strain)
    average = (math.hypot(across, upward) + float(np.linalg.norm(end.force))) / 2.0
    assert stretched / (1.0 + case["beta"] * average / weight) == pytest.approx(case["ratio"], abs=5e-7)
    # A span between those two ends has these forces.
    s = rw.System("Lyons")
    s.string(made, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(end.reach[0], end.reach[2])), length=1.0)
    eq = rw.equilibrium(s)
    assert eq["a_b.vertical_a"] == pytest.approx(upward, rel=1e-9)
    assert eq["a_b.horizontal"] == pytest.approx(across, rel=1e-9)
