"""Tension, sag and wave-return time by temperature."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
GRAVITY = 9.80665


def test_a_taut_span_against_the_equation_of_change_of_state() -> None:
    """Level span of 400 m: H^2 (H - H0 + EA w^2 a^2 / 24 H0^2 + EA alpha dT) = EA w^2 a^2 / 24, exact for small sag."""
    span, weight, stiff = 400.0, 3.48 * GRAVITY, 34.8e6
    table = rw.stringing_table(ROPE, [-30.0, 15.0, 40.0], span=span, tension=120e3)
    start = table["horizontal"].iloc[1]
    for row in table.itertuples():
        bent = stiff * (weight * span) ** 2 / 24.0
        stretch = stiff * 11.5e-6 * (row.temperature - 15.0) + bent / start**2 - start
        parabolic = brentq(lambda h, stretch=stretch, bent=bent: h * h * (h + stretch) - bent, 1e3, 400e3)
        assert row.horizontal == pytest.approx(parabolic, rel=1e-3)
        # The sag follows from the time that a wave takes: g t^2 / 32 on a taut level span.
        assert row.sag == pytest.approx(GRAVITY * row.return_time**2 / 32.0, rel=2e-3)
    assert table["tension_a"].iloc[1] == pytest.approx(120e3, rel=1e-10)
    assert (np.diff(table["sag"]) > 0.0).all()
    assert (np.diff(table["tension_a"]) < 0.0).all()
    assert table.attrs["units"]["return_time"] == "s"


def test_an_inclined_inextensible_catenary() -> None:
    """Sag and time of a wave against the closed form z = a cosh(x / a), T = H cosh(x / a), and a quadrature."""
    rigid = rw.Rope(2.4, np.inf, 450e3)
    row = rw.stringing_table(rigid, [15.0], span=300.0, rise=-80.0, tension=30e3).iloc[0]
    a = row["horizontal"] / (2.4 * GRAVITY)
    middle = a * np.arcsinh(-80.0 / (2.0 * a * np.sinh(150.0 / a)))
    x0, x1 = middle - 150.0, middle + 150.0
    assert row["horizontal"] * np.cosh(x0 / a) == pytest.approx(30e3, rel=1e-9)
    lowest = a * np.arcsinh(-80.0 / 300.0)
    chord = a * np.cosh(x0 / a) - 80.0 / 300.0 * (lowest - x0)
    assert row["sag"] == pytest.approx(chord - a * np.cosh(lowest / a), rel=1e-9)
    time = 2.0 * quad(lambda x: np.cosh(x / a) * np.sqrt(2.4 / (row["horizontal"] * np.cosh(x / a))), x0, x1)[0]
    assert row["return_time"] == pytest.approx(time, rel=1e-9)


def test_lines_without_their_loads_and_bare_skylines() -> None:
    s = rw.System("line", temperature=10.0)
    nodes = rw.Anchor("a", at=(0, 0)), rw.Sheave("m", at=(110, 9)), rw.Anchor("b", at=(230, 4))
    spans = s.string(ROPE, *nodes, length=231.0)
    s.hang(rw.Load("turn", 400.0), spans[0], at=60.0)
    table = rw.stringing_table(s, [10.0, -10.0])
    empty = s.copy()
    empty.hung = []
    cold = rw.equilibrium(empty, environment=rw.Environment("cold", temperature=-10.0))
    own = table[table["temperature"] == -10.0].set_index("span")
    for name in ("a_m", "m_b"):
        assert own.loc[name, "tension_a"] == pytest.approx(cold[f"{name}.tension_a"], rel=1e-10)
    assert s.hung
    rig = rw.standing_skyline(
        None, headspar=rw.HeadSpar("head", at=(0.0, 15.0)), tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
        skyline=ROPE, tension=70e3, carriage=rw.Carriage("carriage", mass=450.0), temperature=5.0,
    )  # fmt: skip
    bare = rw.stringing_table(rig, [5.0, 25.0])
    assert bare["tension_a"].iloc[0] == pytest.approx(70e3, rel=1e-9)
    assert bare["tension_a"].iloc[1] < 69e3


@pytest.mark.parametrize(
    ("of", "arguments", "message"),
    [
        (ROPE, {"tension": 50e3}, "has no span"),
        (ROPE, {"span": 200.0}, "either length or tension"),
        (ROPE, {"span": 200.0, "tension": 50e3, "temperatures": []}, "no temperature"),
        (ROPE, {"span": 200.0, "tension": 50e3, "temperatures": [-300.0]}, "temperature"),
        (rw.System("line"), {"span": 200.0}, "those of a rope"),
        ("no such rope", {"span": 200.0, "tension": 50e3}, "rope"),
    ],
)
def test_wrong_arguments(of: object, arguments: dict[str, object], message: str) -> None:
    with pytest.raises(rw.InputError, match=message):
        rw.stringing_table(of, **{"temperatures": [15.0], **arguments})  # type: ignore[arg-type]
