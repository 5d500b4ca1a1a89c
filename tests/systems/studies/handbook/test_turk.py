"""The classic cable forms against each other and against the library, and the span solvers (Turk 1988, corrected)."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import solve_ivp

import ropeway as rw
from ropeway.components.catenary import Strain, loaded, profile, stretched_length
from ropeway.components.errors import InputError
from ropeway.systems.studies.handbook.turk_forms import gonsior, gonsior_angle, irvine, point_load, sinclair
from ropeway.systems.studies.handbook.turk_solvers import SpanMethod, SpanProblem, solve_span

cables = st.fixed_dictionaries(
    {
        "h": st.floats(500.0, 2e5),
        "lean": st.floats(-2.0, 2.0),
        "w": st.floats(3.0, 60.0),
        "length": st.floats(20.0, 600.0),
        "ea": st.floats(2e6, 8e7),
    }
)


@settings(max_examples=100, deadline=None)
@given(c=cables)
def test_irvine_is_gonsior_is_the_library(c: dict[str, float]) -> None:
    h, w, length, ea = c["h"], c["w"], c["length"], c["ea"]
    v = c["lean"] * h
    at_end = irvine(h, v, w, ea, length)
    piece = gonsior(h, -np.arctan(v / h), np.arctan((w * length - v) / h), w, ea)
    size = max(length, h / w * 1e-3)  # both lose digits in differences of h/w
    assert at_end.x == pytest.approx(piece.x, rel=1e-12, abs=1e-12 * size + 4e-15 * h / w)
    assert -at_end.z == pytest.approx(piece.z, rel=1e-12, abs=1e-12 * size + 4e-15 * h / w * (1 + c["lean"] ** 2))
    assert piece.unstretched == pytest.approx(length, rel=1e-9)
    force, strain = (h, 0.0, -v), Strain(1.0 / ea, 0.0)
    (end,) = loaded(force, w, strain, length, (), ())
    assert at_end.x == pytest.approx(end.reach[0], abs=1e-12 * size + 4e-15 * h / w)
    assert -at_end.z == pytest.approx(end.reach[2], abs=1e-12 * size + 4e-15 * h / w * (1 + c["lean"] ** 2))
    assert piece.length == pytest.approx(stretched_length(force, w, length, strain), rel=1e-9)


@settings(max_examples=60, deadline=None)
@given(c=cables)
def test_gonsior_angle_recovers_the_angle(c: dict[str, float]) -> None:
    """Eq. 2.90-2.94, and their contraction factor -T/EA."""
    h, w, length, ea = c["h"], c["w"], c["length"], c["ea"]
    start = -np.arctan(c["lean"])
    end = np.arctan((w * length - c["lean"] * h) / h)
    x = float(gonsior(h, start, end, w, ea).x)
    found = gonsior_angle(h, start, x, w, ea)
    assert found.angle == pytest.approx(end, abs=1e-9)
    assert gonsior_angle(h, end, -x, w, ea).angle == pytest.approx(start, abs=1e-9)


def test_contraction_of_the_substitution() -> None:
    h, ea = 42000.0, 2.5e7
    found = gonsior_angle(h, -0.3, 200.0, 29.0, ea)
    slope = np.tan(found.iterates[1:])  # the first iterate is the slope at the other end
    ratio = (slope[2] - slope[1]) / (slope[1] - slope[0])
    tension = h / np.cos(found.angle)
    assert ratio == pytest.approx(-tension / ea, rel=1e-2)
    assert len(found.iterates) < 10


def test_steep_angles_and_overflow() -> None:
    assert gonsior_angle(1.0, -1.5, 400.0, 1.0, float("inf")).angle == pytest.approx(np.pi / 2)  # e^alpha overflows
    with pytest.raises(InputError, match="does not converge"):
        gonsior_angle(1e7, 0.0, 100.0, 30.0, 1e6)
    with pytest.raises(InputError, match="slope angle"):
        gonsior(1.0, -2.0, 0.0, 1.0, 1e6)
    with pytest.raises(InputError, match="horizontal"):
        irvine(0.0, 1.0, 1.0, 1e6, 1.0)


@settings(max_examples=80, deadline=None)
@given(c=cables, places=st.lists(st.floats(0.0, 1.0), max_size=5), data=st.data())
def test_sinclair_is_the_library(c: dict[str, float], places: list[float], data: Any) -> None:
    """The recursion for N loads, at its end and at stations, including upward loads."""
    h, w, length, ea = c["h"], c["w"], c["length"], c["ea"]
    v, at = c["lean"] * h, np.sort(places)
    loads = np.array([data.draw(st.floats(-0.3, 1.0)) * h for _ in places])
    weight = w * length
    sigma = np.linspace(0.0, 1.0, 13)
    point = sinclair(v / weight, h / weight, weight / ea, at, loads / weight, sigma)
    stations = profile((h, 0.0, -v), w, Strain(1.0 / ea, 0.0), length, list(at * length), list(loads), sigma * length)
    noise = 1e-12 * length + 2e-14 * h / w * (1.0 + c["lean"] ** 2) * (1 + len(places))
    assert point.x * length == pytest.approx(stations.reach[:, 0], abs=noise)
    assert -point.z * length == pytest.approx(stations.reach[:, 2], abs=10 * noise)
    free = ~np.isin(sigma, at)  # at a load its tension has two values
    assert (point.tension * weight)[free] == pytest.approx(stations.tension[free], rel=1e-12)


def test_three_loads_against_integration() -> None:
    """The cable's differential equations (z down), integrated piece by piece."""
    h, v, w, length, ea = 42000.0, 21000.0, 29.0, 310.0, 2.5e7
    at, loads = np.array([60.0, 155.0, 240.0]), np.array([6000.0, 9000.0, 5000.0])
    y, s = np.zeros(2), 0.0
    for stop, load in zip([*at, length], [0.0, *loads], strict=True):
        v -= load
        base, from_s = v, s

        def slope(s: float, _: Any, base: float = base, from_s: float = from_s) -> list[float]:
            vertical = base - w * (s - from_s)
            t = np.hypot(h, vertical)
            return [h / t * (1 + t / ea), vertical / t * (1 + t / ea)]

        y = solve_ivp(slope, (s, stop), y, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
        v, s = base - w * (stop - from_s), stop
    weight = w * length
    end = sinclair(21000.0 / weight, h / weight, weight / ea, at / length, loads / weight, 1.0)
    assert end.x * length == pytest.approx(y[0], rel=1e-12)
    assert end.z * length == pytest.approx(y[1], rel=1e-11)


def test_point_load() -> None:
    """Eq. 2.96-2.100, corrected."""
    h, v, w, ea, length, m, s1, s = 42000.0, 9000.0, 29.0, 2.5e7, 250.0, 15000.0, 110.0, 250.0
    total = w * length
    u = [v / h, (v - m - w * s) / h, (v - m - w * s1) / h, (v - w * s1) / h]
    x = h * s / ea + h / w * (np.arcsinh(u[0]) - np.arcsinh(u[1]) + np.arcsinh(u[2]) - np.arcsinh(u[3]))
    z = h / w * (np.hypot(1, u[0]) - np.hypot(1, u[1]) + np.hypot(1, u[2]) - np.hypot(1, u[3]))
    z += m * (s1 - s) / ea + total * s / ea * (v / total - s / (2 * length))
    found = point_load(h, v, w, ea, length, m, s1, s)
    assert found.x == pytest.approx(x, rel=1e-12)
    assert found.z == pytest.approx(z, rel=1e-11)
    assert found.tension == pytest.approx(np.hypot(h, v - m - w * s), rel=1e-14)
    before = point_load(h, v, w, ea, length, m, s1, 50.0)
    assert before.x == pytest.approx(irvine(h, v, w, ea, 50.0).x, rel=1e-12)


def test_sinclair_input() -> None:
    with pytest.raises(InputError, match="one station for each load"):
        sinclair(0.5, 2.0, 1e-4, [0.2, 0.4], [1.0], 1.0)
    with pytest.raises(InputError, match="not in order"):
        sinclair(0.5, 2.0, 1e-4, [0.6, 0.4], [1.0, 1.0], 1.0)


# ------------------------------------------------------------------ solvers

METHODS: tuple[SpanMethod, ...] = ("successive substitution", "Newton-Raphson", "Brown")


def problem(length: float) -> SpanProblem:
    distances = tuple(length * (k + 0.5) / 8 for k in range(8))
    return SpanProblem(1000.0, 45.0, length, 1.42, 3.5e6, distances, (150.0,) * 8)


def start(span: SpanProblem, scale: float) -> tuple[float, float]:
    h, v = span.start
    return scale * h, v + (1.0 - scale) * h * span.rise / span.span


@pytest.mark.parametrize("length", [1000.0, 1001.0])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scale", [0.1, 1.0 / 3.0, 1.0, 3.0, 10.0])
def test_damped_methods_agree_from_every_start(length: float, method: Any, scale: float) -> None:
    span = problem(length)
    found = solve_span(span, method, start=start(span, scale))
    assert found.converged
    assert found.iterations <= 20
    best = solve_span(span, tolerance=1e-12, start=start(span, 1.0)).frame.iloc[-1]
    assert found.frame["horizontal"].iloc[-1] == pytest.approx(best["horizontal"], rel=1e-6)
    assert found.frame["vertical"].iloc[-1] == pytest.approx(best["vertical"], rel=1e-5)


def test_solvers_find_the_equilibrium_of_the_components() -> None:
    span = SpanProblem(300.0, -40.0, 306.0, 3.48 * 9.80665, 34.8e6, (90.0, 200.0), (2000 * 9.80665, 800 * 9.80665))
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    s = rw.System("span")
    (piece,) = s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(300.0, -40.0)), length=306.0)
    s.hang(rw.Load("one", mass=2000.0), piece, at=90.0)
    s.hang(rw.Load("two", mass=800.0), piece, at=200.0)
    eq = rw.equilibrium(s)
    for method in METHODS:
        last = solve_span(span, method, tolerance=1e-13).frame.iloc[-1]
        assert last["tension"] == pytest.approx(eq["a_b.tension_a"], rel=1e-8)
        assert last["vertical"] == pytest.approx(eq["a_b.vertical_a"], rel=1e-8)


def test_newton_is_quadratic_and_brown_cheaper_per_iteration() -> None:
    span = problem(1000.0)
    newton = solve_span(span, "Newton-Raphson", start=start(span, 1.0 / 3.0), damped=False)
    brown = solve_span(span, "Brown", start=start(span, 1.0 / 3.0), damped=False)
    assert newton.frame["evaluations"].iloc[-1] == 6 * newton.iterations
    assert brown.frame["evaluations"].iloc[-1] == 5 * brown.iterations
    for history in (newton, brown):
        miss = history.frame["miss"].to_numpy()
        assert miss[-1] < 1e-2 * miss[-2]


def test_one_foot_more_halves_the_substitution() -> None:
    """The contraction factor is the rope's stretch over twice its excess over the chord, which a foot of rope
    changes."""
    rounds = {}
    for length in (1000.0, 1001.0):
        span = problem(length)
        history = solve_span(span, "successive substitution", start=start(span, 3.0), damped=False)
        assert history.converged
        rounds[length] = history.iterations
        h, v = (history.frame[c].iloc[-1] for c in ("horizontal", "vertical"))
        stretch = span.stretched(h, v) - length
        factor = stretch / (2.0 * (span.stretched(h, v) - span.chord))
        miss = history.frame["miss"].to_numpy()
        assert miss[-6] / miss[-7] == pytest.approx(factor, rel=0.05)
    assert rounds[1000.0] > 1.8 * rounds[1001.0]


def test_undamped_methods_can_fail_and_report_it() -> None:
    span = problem(1000.0)
    for method in ("successive substitution", "Brown"):
        history = solve_span(span, method, start=start(span, 10.0), damped=False)
        assert not history.converged
    rough = solve_span(problem(1001.0), start=start(problem(1001.0), 10.0), damped=False, unknowns="tension and angle")
    assert not rough.converged
    assert solve_span(problem(1001.0), start=start(problem(1001.0), 10.0), unknowns="tension and angle").converged


def test_history_begins_with_the_start() -> None:
    span = problem(1000.0)
    history = solve_span(span)
    assert history.frame["horizontal"].iloc[0] == pytest.approx(span.start[0])
    assert history.frame["miss"].iloc[-1] < 1e-6
    assert history.iterations == 2


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: SpanProblem(0.0, 0.0, 10.0, 1.0, 1e6), "span"),
        (lambda: SpanProblem(10.0, float("nan"), 10.0, 1.0, 1e6), "rise"),
        (lambda: SpanProblem(10.0, 0.0, 11.0, 1.0, 1e6, (5.0,), ()), "one distance"),
        (lambda: SpanProblem(10.0, 0.0, 11.0, 1.0, 1e6, (12.0,), (1.0,)), "in order"),
        (lambda: solve_span(problem(1000.0), "guess"), "method"),  # type: ignore[arg-type]
        (lambda: solve_span(problem(1000.0), unknowns="x"), "unknowns"),  # type: ignore[arg-type]
        (lambda: solve_span(problem(1000.0), start=(-1.0, 0.0)), "horizontal"),
    ],
)
def test_bad_input(make: Callable[[], object], word: str) -> None:
    with pytest.raises(InputError, match=word):
        make()
