"""Points on a rope, and the span sighted from one place (PAPOTO)."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from support.measured import ROPE, idlers, standing

GON = rw.units.GON
TWO = (460.296269689673, [(0.0, 95.3282575966228), (165.995104445107, 76.6693939496654)],
       [(4.0612735796946, 94.4241159093392), (15.2623371798393, 88.8639691159579)])  # fmt: skip
"""Span [m], sights [gon] to both supports and to points: mechaphlowers' test of PAPOTO with two points, 2000 m."""
THREE = (498.565922913587, [(0.0, 97.4327311161033), (162.614599621714, 88.6907631859419)],
         [(5.1134354937127, 98.4518011880176), (19.6314054626454, 97.6289296721015),
          (97.1475339907774, 87.9335010245142)])  # fmt: skip
"""Its test with three points, 2000 m."""


def sighted(
    span: float, ends: Sequence[tuple[float, float]], points: Sequence[tuple[float, float]]
) -> rw.CatenaryCurve:
    left, right, *others = [(h * GON, v * GON) for h, v in (*ends, *points)]
    return rw.catenary_for_sights(span, left, right, others)


def test_papoto() -> None:
    assert float(sighted(*TWO).parameter) == pytest.approx(2000.0, abs=1.0)
    assert float(sighted(*TWO).parameter) == pytest.approx(2000.009, abs=1e-3)
    assert float(sighted(*THREE).parameter) == pytest.approx(2000.0, abs=1.0)
    for pair in ((0, 1), (0, 2), (1, 2)):
        assert float(sighted(*THREE[:2], [THREE[2][i] for i in pair]).parameter) == pytest.approx(2000.0, abs=0.1)


def test_papoto_from_either_side_and_with_noise() -> None:
    span, ends, points = THREE
    mirrored = [(-h, v) for h, v in ends], [(-h, v) for h, v in points]
    assert float(sighted(span, *mirrored).parameter) == pytest.approx(float(sighted(*THREE).parameter), rel=1e-8)
    rng = np.random.default_rng(3)
    noisy = [(h + rng.normal(0.0, 1e-3), v + rng.normal(0.0, 1e-3)) for h, v in points]
    assert float(sighted(span, ends, noisy).parameter) == pytest.approx(2000.0, rel=5e-3)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (TWO[2][:1], "two or more"),
        ([(170.0, 90.0), (15.0, 88.0)], "do not lie between"),
        ([(40.0, 120.0), (100.0, 20.0)], "No catenary"),
    ],
)
def test_sights_that_no_span_has(points: list[tuple[float, float]], message: str) -> None:
    with pytest.raises((rw.InputError, rw.FitError), match=message):
        sighted(*TWO[:2], points)


def test_points_of_papoto_fitted_to_an_elastic_span() -> None:
    """The same points, placed by the sights: the horizontal tension over the weight is the same parameter."""
    curve = sighted(*TWO)
    span, rise, x = float(curve.span), float(curve.rise), np.array([40.0, 130.0, 300.0, 420.0])
    rope = rw.Rope(mass_per_length=1.8, axial_stiffness=40e6, breaking_load=300e3)
    s = rw.System("span")
    s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(span, rise)), tension=30e3)
    table = pd.DataFrame({"x": x, "z": curve.height(x)})
    fit = rw.fit(s, table, columns={"x": "a_b.rope_x", "z": "a_b.rope_z"}, free="a.pretension", sigma=0.01)
    strung = rw.equilibrium(s, given={"a_b.tension_a": float(fit.values.iloc[0])}, solve_for="a_b.length")
    tension = strung["a_b.horizontal"]
    stretched = rope.mass_per_length * s.gravity / (1.0 + tension / rope.axial_stiffness)  # weight of a stretched metre
    assert tension / stretched == pytest.approx(2000.0, abs=0.5)
    assert fit.residuals["z"].abs().max() < 2e-3


def test_points_on_loaded_spans_lie_on_the_rope() -> None:
    """A scan of a loaded span off the x axis, and of a skyline with its carriage, gives back what it was made from."""
    line = idlers(l1=430.0, tension=33e3)
    curve = rw.equilibrium(line).profile("s1_s2", 12).iloc[1:-1]
    columns = {"x": "s1_s2.rope_x", "y": "s1_s2.rope_y", "z": "s1_s2.rope_z"}
    free = ["a.pretension", "l1.mass"]
    fit = rw.fit(idlers(), curve[["x", "y", "z"]], columns=columns, free=free, sigma=0.01)
    np.testing.assert_allclose(fit.values, [33e3, 430.0], rtol=1e-6)
    without_y = {key: value for key, value in columns.items() if key != "y"}
    again = rw.fit(idlers(), curve[["x", "z"]], columns=without_y, free=free, sigma=0.01)
    np.testing.assert_allclose(again.values, fit.values, rtol=1e-6)
    with pytest.raises(rw.InputError, match="has no places"):
        rw.fit(idlers(), curve, columns={"z": "s1_s2.rope_z"}, free="l1.mass", sigma=0.01)
    with pytest.raises(rw.UnknownNameError, match="No span 's9'"):
        rw.fit(idlers(), curve, columns={"x": "s9.rope_x", "z": "s1_s2.rope_z"}, free="l1.mass", sigma=0.01)


def test_a_scan_of_a_skyline() -> None:
    rig = standing(72e3)
    at = rw.equilibrium(rig.system(1, 220.0, 2000.0), given={"carriage.x": 220.0}, solve_for="mainline.travel")
    curve = at.profile("head_jack", 9).iloc[1:-1]
    table = pd.DataFrame({"station": 220.0, "x": curve["x"], "z": curve["z"]})
    columns = {"station": "station", "x": "head_jack.rope_x", "z": "head_jack.rope_z"}
    fit = rw.fit(standing(), table, columns=columns, free="tension", sigma=0.01)
    assert fit.values["tension"] == pytest.approx(72e3, rel=1e-5)


def blown(tension: float, stiffness: float = 24e6) -> rw.System:
    """A loaded span off the x axis in wind."""
    s = rw.System("blown", temperature=15.0)
    rope = rw.Rope(
        mass_per_length=2.4, axial_stiffness=stiffness, breaking_load=450e3, diameter=0.0254,
        thermal_expansion=11.5e-6, drag_coefficient=1.1,
    )  # fmt: skip
    ends = rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(300.0, 60.0, 20.0))
    (span,) = s.string(rope, *ends, tension=tension)
    s.hang(rw.Load("turn", mass=500.0, drag_area=1.0), span, at=120.0)
    return s.in_weather(rw.Environment("wind", temperature=5.0, wind_pressure=300.0, wind_from=0.0))


def test_a_scan_in_wind() -> None:
    curve = rw.equilibrium(blown(44e3)).profile("a_b", 12).iloc[1:-1]
    columns = {axis: f"a_b.rope_{axis}" for axis in "xyz"}
    fit = rw.fit(blown(40e3), curve[["x", "y", "z"]], columns=columns, free="a.pretension", sigma=0.01)
    assert fit.values["a.pretension"] == pytest.approx(44e3, rel=1e-7)
    assert fit.residuals["z"].abs().max() < 1e-8


def test_temperatures_are_given_in_each_row() -> None:
    true, rows = rw.assemble(blown(44e3, 20e6)), []
    for celsius in (-20.0, 0.0, 20.0, 40.0):
        eq = rw.equilibrium(true, parameters={"temperature": celsius})
        rows.append({"T_degF": 1.8 * celsius + 32.0, "A_kN": eq["a.tension"] / 1e3, "z": eq["turn.z"]})
    columns = {"T_degF": "temperature", "A_kN": "a.tension", "z": "turn.z"}
    free, sigma = ["a.pretension", "a.axial_stiffness"], {"A_kN": 100.0, "z": 0.01}
    fit = rw.fit(blown(40e3), pd.DataFrame(rows), columns=columns, free=free, sigma=sigma)
    np.testing.assert_allclose(fit.values, [44e3, 20e6], rtol=1e-7)


def test_a_pretension_by_stopwatch() -> None:
    """The time of a wave along an empty rope and back, as the stringing table has it; with a load, from the load."""

    def empty(tension: float) -> rw.System:
        s = rw.System("empty")
        s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(250.0, 30.0)), tension=tension)
        return s

    (row,) = rw.stringing_table(empty(25e3), [15.0]).itertuples()
    columns = {"t": "a_b.return_time"}
    fit = rw.fit(empty(20e3), pd.DataFrame({"t": [row.return_time]}), columns=columns, free="a.pretension", sigma=0.05)
    assert fit.values["a.pretension"] == pytest.approx(25e3, rel=1e-6)
    # T is as the square of 1 / t: 1 % of the time is 2 % of the tension.
    assert fit.standard_errors["a.pretension"] / 25e3 == pytest.approx(2.0 * 0.05 / row.return_time, rel=0.1)
    known = {"l1.mass": (400.0, 1e-3)}
    times = pd.DataFrame({"t": [1.2]})
    columns = {"t": "s1_s2.return_time"}
    blow = rw.fit(idlers(tension=33e3), times, columns=columns, free="l1.mass", sigma=0.01, prior=known)
    eq = rw.equilibrium(idlers(tension=33e3))
    curve = eq.profile("s1_s2", np.linspace(0.0, eq["l1.distance"], 2001))
    slowness = np.sqrt(ROPE.mass_per_length * (1.0 + curve["tension"] / ROPE.axial_stiffness) / curve["tension"])
    expected = 2.0 * float(np.trapezoid(slowness, curve["station"]))
    assert blow.predicted["t"].iloc[0] == pytest.approx(expected, rel=1e-6)
