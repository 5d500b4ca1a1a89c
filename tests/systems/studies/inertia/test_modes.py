"""Natural frequencies against closed forms, published values, bars and chains of springs."""

from __future__ import annotations

import math
from itertools import pairwise

import casadi as ca
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

import ropeway as rw
from support.call_objects import guyed
from support.nets import published_net
from support.spring_chain import SpringChain

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24.03e6, breaking_load=450e3)


def frequencies(eq: rw.Equilibrium, nodes: int, count: int = 10, *, sideways: bool | None = None) -> np.ndarray:
    """Frequencies [Hz]; of the modes in the vertical plane only, or only of those across it."""
    frame = rw.modes(eq, nodes, count).frame
    if sideways is not None:
        frame = frame[(frame["sideways"] > 0.5) == sideways]
    return frame["frequency"].to_numpy()


def span(rope: rw.Rope, length: float, horizontal: float, gravity: float = 9.80665) -> rw.Equilibrium:
    """A level span with a horizontal tension."""
    s = rw.System("span", gravity=gravity)
    s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(length, 0.0)), length=1.001 * length)
    return rw.equilibrium(s, given={"a_b.horizontal": horizontal}, solve_for="a_b.length")


def irvine(rope: rw.Rope, length: float, horizontal: float, gravity: float = 9.80665) -> tuple[float, float, float]:
    """Irvine's parabola: lambda squared, the first symmetric and the first antisymmetric frequency in the plane [Hz].
    His masses are those of a stretched metre."""
    mass = rope.mass_per_length / (1.0 + horizontal / rope.axial_stiffness)
    sag = mass * gravity * length / horizontal
    square = sag**2 * length * rope.axial_stiffness / (horizontal * length * (1.0 + sag**2 / 8.0))
    half = brentq(lambda w: math.tan(w) - w + 4.0 / square * w**3, 0.5 * np.pi + 1e-9, 1.5 * np.pi - 1e-9)
    speed = math.sqrt(horizontal / mass) / length
    return square, 2.0 * half * speed / (2.0 * math.pi), speed


@pytest.mark.parametrize(("horizontal", "tolerances"), [(99.86e3, (3e-3, 3e-3)), (20.06e3, (3e-3, 7e-3))])
def test_frequencies_of_a_suspended_cable(horizontal: float, tolerances: tuple[float, float]) -> None:
    """Irvine 1981: lambda squared of 0.77 and 95."""
    square, symmetric, antisymmetric = irvine(ROPE, 240.0, horizontal)
    assert square == pytest.approx({99.86e3: 0.77, 20.06e3: 95.0}[horizontal], rel=0.05)
    found = frequencies(span(ROPE, 240.0, horizontal), 30, 8, sideways=False)
    for expected, tolerance in zip((symmetric, antisymmetric), tolerances, strict=True):
        assert np.abs(found / expected - 1.0).min() < tolerance


def test_published_frequencies() -> None:
    """ANSYS VM53: 74.708, 149.42, 224.12 Hz. Mehrabi and Tabatabai 1998, cables 1 and 2 of 100 m with 400 kg/m, without
    bending (Irvine): 0.4395, 0.8520 and 0.4260, 0.4627 Hz; here with a hundredth of mass, force and stiffness.

    A parabola omits that a sagging cable is longer than its span and moves lengthwise: 2.3 % of the antisymmetric mode
    of cable 2, which sags by 7 %."""
    area, modulus = 1.97932e-6, 2.06843e11
    wire = rw.Rope(mass_per_length=7801.43 * area * 1.00543228, axial_stiffness=modulus * area, breaking_load=5000.0)
    found = frequencies(span(wire, 2.54, 2224.1, gravity=1e-6), 20, 6)
    assert found == pytest.approx(np.repeat([74.708, 149.42, 224.12], 2), rel=2e-4)
    for horizontal, stiffness, expected, off in (
        (29.036e3, 1.5988e8 * 7.8507e-3, (0.4395, 0.8520), (0.0, 0.0)),
        (7.259e3, 1.7186e8 * 7.6110e-3, (0.4260, 0.4627), (-0.023, 0.0)),
    ):
        cable = rw.Rope(
            mass_per_length=4.0 * (1.0 + horizontal / stiffness), axial_stiffness=stiffness, breaking_load=1e6
        )
        plane = frequencies(span(cable, 100.0, horizontal, gravity=9.8), 30, 6, sideways=False)
        assert plane[:2] / expected - 1.0 == pytest.approx(off, abs=2e-3)


@pytest.mark.parametrize("share", [0.5, 0.2])
def test_a_taut_string_with_a_point_mass(share: float) -> None:
    length, tension, mass = 240.0, 120e3, 4000.0
    s = rw.System("string", gravity=1e-4)
    (string,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(length, 0.0)), tension=tension)
    s.hang(rw.Load("m", mass), string, at=share * string.length)
    density = ROPE.mass_per_length / (1.0 + tension / ROPE.axial_stiffness)

    def miss(w: float) -> float:
        k = w * math.sqrt(density / tension)
        a, b = share * length, (1.0 - share) * length
        return mass * w**2 - tension * k * (1.0 / math.tan(k * a) + 1.0 / math.tan(k * b))

    exact = brentq(miss, 0.1, 0.95 * math.pi * math.sqrt(tension / density) / (max(share, 1.0 - share) * length))
    assert frequencies(rw.equilibrium(s), 0, 1)[0] == pytest.approx(exact / (2.0 * math.pi), rel=8e-4)
    assert frequencies(rw.equilibrium(s), 20, 1)[0] == pytest.approx(exact / (2.0 * math.pi), rel=1e-4)


def test_a_double_pendulum_below_a_skyline() -> None:
    """Sideways a carriage swings about the chord of its skyline, and its load about the carriage."""
    light = rw.Rope(mass_per_length=1e-3, axial_stiffness=24e6, breaking_load=450e3)
    s = rw.System("skyline")
    carriage = rw.Carriage("carriage", at=(100.0, -11.0), mass=300.0)
    load = rw.Joint("load", at=(100.0, -21.0), mass=1200.0)
    s.string(light, rw.Anchor("a", at=(0.0, 0.0)), carriage, rw.Anchor("b", at=(200.0, 0.0)), length=201.2)
    s.string(light, carriage.dropline, load, length=10.0)
    eq = rw.equilibrium(s)
    sag, hanging, both = -eq["carriage.z"], eq["carriage.z"] - eq["load.z"], 1500.0 * 9.80665
    stiffness = np.array([[both / sag + 1200.0 * 9.80665 / hanging, -1200.0 * 9.80665 / hanging]] * 2)
    stiffness[1] = [-1200.0 * 9.80665 / hanging, 1200.0 * 9.80665 / hanging]
    exact = np.sqrt(eigh(stiffness, np.diag([300.0, 1200.0]), eigvals_only=True)) / (2.0 * np.pi)
    assert frequencies(eq, 0, 8, sideways=True) == pytest.approx(exact, rel=1e-4)


def idler_line() -> rw.Equilibrium:
    """Three spans with an angle in plan, a load in the second."""
    s = rw.System("idlers")
    supports = (
        rw.Anchor("a", at=(0.0, 0.0)),
        rw.Sheave("s1", at=(100.0, 20.0, 5.0)),
        rw.Sheave("s2", at=(220.0, 9.0)),
        rw.Anchor("b", at=(300.0, 12.0)),
    )
    spans = s.string(ROPE, *supports, length=310.0)
    s.hang(rw.Load("turn", 300.0), spans, at=150.0)
    return rw.equilibrium(s)


def test_a_line_over_idlers_is_a_chain_of_springs() -> None:
    eq = idler_line()
    assert frequencies(eq, 12, 6) == pytest.approx(SpringChain(eq, ROPE, 50).frequencies(6), rel=1e-3)


def rolling_carriage() -> rw.System:
    s = rw.System("carriage")
    carriage = rw.Carriage("c", at=(100.0, -10.0), mass=100.0, payload=900.0)
    s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), carriage, rw.Anchor("b", at=(200.0, -10.0)), length=204.0)
    return s


def test_a_rolling_carriage_is_a_pulley_on_a_chain_of_springs() -> None:
    eq = rw.equilibrium(rolling_carriage())
    assert frequencies(eq, 12, 6) == pytest.approx(SpringChain(eq, ROPE, 50, {"c": 1000.0}).frequencies(6), rel=1e-3)


def linearised(system: rw.System, inertia: rw.Inertia) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and shares of critical damping of the equations of a simulation at rest."""
    rest = rw.simulate(system, until=1e-3, every=1e-3, inertia=inertia).record(0)
    arguments = rest.model.dae.mx_in()
    matrices = [ca.jacobian(of, by) for of in rest.model.dae.call(arguments) for by in arguments[1:3]]
    found = ca.Function("jacobians", arguments, matrices)(*rest.point.arguments)
    xx, xz, zx, zz = (np.asarray(matrix) for matrix in found)
    roots = np.linalg.eigvals(xx - xz @ np.linalg.solve(zz, zx))
    roots = roots[roots.imag > 1e-6]
    roots = roots[np.argsort(np.abs(roots))]
    return np.abs(roots) / (2.0 * np.pi), -roots.real / np.abs(roots)


@pytest.mark.parametrize("nodes", [0, 4])
def test_modes_are_those_of_a_simulation(nodes: int) -> None:
    """A span with loads, or with rope nodes; idlers with inertia."""
    s = rw.System("line")
    supports = (
        rw.Anchor("a", at=(0.0, 0.0)),
        rw.Sheave("s1", at=(100.0, 20.0, 5.0), inertia=100.0),
        rw.Anchor("b", at=(210.0, 9.0)),
    )
    spans = s.string(ROPE, *supports, length=219.0)
    if not nodes:
        s.hang(rw.Load("one", 300.0), spans, at=40.0)
        s.hang(rw.Load("two", 200.0), spans, at=150.0)
    frame = rw.modes(rw.equilibrium(s), nodes, 40).frame
    frequency, damping = linearised(s, rw.Inertia(nodes=nodes))
    assert frame["frequency"].to_numpy() == pytest.approx(frequency, rel=1e-6)
    assert frame["damping"].to_numpy() == pytest.approx(damping, rel=1e-6)


def test_a_carriage_rolls_in_a_simulation_too() -> None:
    """In a simulation the rope does not move along the skyline's chord at the carriage; the modes have its run."""
    frame = rw.modes(rw.equilibrium(rolling_carriage()), 0, 3).frame
    frequency, damping = linearised(rolling_carriage(), rw.Inertia())
    assert frame["frequency"].to_numpy() == pytest.approx(frequency, rel=3e-3)
    # The damping of the rope does not brake a carriage that rolls.
    assert frame["damping"].to_numpy() == pytest.approx(damping, rel=2e-2, abs=5e-5)


def bar(eq: rw.Equilibrium, name: str, places: np.ndarray, stiffness: float) -> np.ndarray:
    """Stiffness of a straight bar under tension, by one end against the other (3, 3)."""
    apart = places[1] - places[0]
    length = float(np.linalg.norm(apart))
    outer = np.outer(apart, apart) / length**2
    return stiffness / eq[f"{name}.length"] * outer + eq[f"{name}.tension_a"] / length * (np.eye(3) - outer)


def test_a_net_of_bars() -> None:
    """The net of SAP2000 example 7-003 as bars of a textbook; its cables weigh a ten-thousandth of its loads."""
    eq = rw.equilibrium(published_net())
    joints, matrix = ["n11", "n12", "n21", "n22"], np.zeros((12, 12))
    for run in eq.model.runs:
        (cable,), names = run.spans, [node.name for node in run.nodes]
        places = np.array([[eq[f"{name}.{axis}"] for axis in "xyz"] for name in names])
        own = bar(eq, cable.name, places, cable.rope.axial_stiffness)
        for i, one in enumerate(names):
            for j, other in enumerate(names):
                if one in joints and other in joints:
                    p, q = 3 * joints.index(one), 3 * joints.index(other)
                    matrix[p : p + 3, q : q + 3] += own if i == j else -own
    exact = np.sqrt(eigh(matrix, eq["n11.mass"] * np.eye(12), eigvals_only=True)) / (2.0 * np.pi)
    assert frequencies(eq, 0, 12) == pytest.approx(exact, rel=2e-3)


def test_a_guyed_spar_leans_on_its_guylines() -> None:
    """A mast on a hinge: bars in place of its light guylines, less its compression over its length."""
    spar, light = guyed(), rw.Rope(mass_per_length=1e-3, axial_stiffness=9e6, breaking_load=140e3)
    corners = [(-14.0, -14.0, 0.0), (-14.0, 14.0, 0.0), (14.0, -14.0, 0.0), (14.0, 14.0, 0.0)]
    guys = tuple(rw.Guyline(f"g{k}", light, at=at, pretension=9e3) for k, at in enumerate(corners))
    spar = rw.GuyedSpar("mast", height=12.0, foot=(0.0, 0.0), mass=800.0, guylines=guys)
    s = rw.System("mast")
    rw.string_guylines(s, spar)
    eq = rw.equilibrium(s)
    top = np.array([eq[f"mast.{axis}"] for axis in "xyz"])
    matrix = -eq["mast.axial"] / 12.0 * np.eye(3)
    for run in eq.model.runs:
        guy = run.spans[0]
        ends = [[eq[f"{node.name}.{axis}"] for axis in "xyz"] for node in run.nodes]
        matrix += bar(eq, guy.name, np.array(ends), light.axial_stiffness)
    assert top == pytest.approx([0.0, 0.0, 12.0], abs=1e-6)
    exact = np.sqrt(np.linalg.eigvalsh(matrix[:2, :2]) / (800.0 / 3.0)) / (2.0 * np.pi)
    assert frequencies(eq, 0, 2) == pytest.approx(exact, rel=1e-3)


def test_shapes_damping_and_shares() -> None:
    eq = idler_line()
    found = rw.modes(eq, 4, 7, damping=2e-3)
    assert found.frame["damping"].to_numpy() == pytest.approx(np.pi * 2e-3 * found.frame["frequency"])
    assert (found.frame["period"] * found.frame["frequency"]).to_numpy() == pytest.approx(np.ones(7))
    shares = found.frame[["lengthwise", "sideways", "vertical"]]
    assert shares.sum(axis=1).to_numpy() == pytest.approx(np.ones(7))
    assert found.frame["largest"].iloc[0] == "turn"
    assert found.shapes.shape == (7, len(found.points), 3)
    assert np.abs(found.shapes).max(axis=(1, 2)) == pytest.approx(np.ones(7))
    for end in ("a", "b"):
        assert np.abs(found.shapes[:, (found.points["point"] == end).to_numpy()]).max() == 0.0
    turn = found.points[found.points["point"] == "turn"].iloc[0]
    assert [turn.x, turn.y, turn.z] == pytest.approx([eq[f"turn.{axis}"] for axis in "xyz"], abs=1e-9)
    # The rope that runs over a sheave is the same on both sides.
    at_sheave = found.shapes[:, (found.points["point"] == "s1").to_numpy()]
    assert np.linalg.norm(at_sheave[:, 0], axis=1) == pytest.approx(np.linalg.norm(at_sheave[:, 1], axis=1))
    assert found.frame.attrs["units"]["frequency"] == "Hz"
    assert "frequency [Hz]" in found._repr_html_()
    figure = found.plot(2)
    assert len(figure.axes) == 2
    plt.close(figure)


def test_a_joint_in_the_rope_changes_nothing() -> None:
    whole = span(ROPE, 200.0, 40e3)
    length, joint = whole["a_b.length"], rw.Joint("j", at=(100.0, -3.0))
    s = rw.System("halves")
    for ends in pairwise((rw.Anchor("a", at=(0.0, 0.0)), joint, rw.Anchor("b", at=(200.0, 0.0)))):
        s.string(ROPE, *ends, length=length / 2.0)
    assert frequencies(rw.equilibrium(s), 3, 6) == pytest.approx(frequencies(whole, 7, 6), rel=1e-6)


def test_wave_return_of_a_span() -> None:
    taut = span(ROPE, 200.0, 100e3, gravity=1e-4)
    speed = math.sqrt(100e3 * (1.0 + 100e3 / 24.03e6) / 2.4)  # of the wave over the stretched rope
    assert rw.modes(taut).wave_return.loc["a_b"].to_numpy() == pytest.approx([400.0 / speed] * 2, rel=1e-6)
    loaded = rw.modes(idler_line(), 0, 1).wave_return
    assert loaded.loc["a_s1", "from_a"] == pytest.approx(loaded.loc["a_s1", "from_b"])
    eq = idler_line()
    curve = eq.profile("s1_s2", np.linspace(0.0, eq["turn.distance"], 20001))
    slowness = np.sqrt(2.4 * (1.0 + curve["tension"] / 24.03e6) / curve["tension"])
    assert loaded.loc["s1_s2", "from_a"] == pytest.approx(2.0 * np.trapezoid(slowness, curve["station"]), rel=1e-7)


def test_modes_in_weather() -> None:
    """Ice is mass of the rope. Wind across a span turns its plane: its rope hangs as in stronger gravity."""
    rope = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450e3, diameter=0.0254)
    ice = 900.0 * math.pi * 0.01 * (0.0254 + 0.01)
    wind = 300.0 * rope.drag_coefficient * 0.0254

    def strung(rope: rw.Rope, gravity: float) -> rw.System:
        s = rw.System("span", gravity=gravity)
        (span,) = s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(240.0, 0.0)), length=240.3)
        s.hang(rw.Load("turn", mass=500.0, drag_area=500.0 * wind / 300.0 / 2.4), span, at=100.0)
        return s

    iced = rw.Environment("iced", ice_thickness=0.01, ice_density=900.0)
    heavy = rw.Rope(mass_per_length=2.4 + ice, axial_stiffness=24e6, breaking_load=450e3)
    found = rw.modes(rw.equilibrium(strung(rope, 9.80665), environment=iced), 4, 6)
    exact = rw.modes(rw.equilibrium(strung(heavy, 9.80665)), 4, 6)
    assert found.frame["frequency"].to_numpy() == pytest.approx(exact.frame["frequency"].to_numpy(), rel=1e-9)
    assert found.wave_return.to_numpy() == pytest.approx(exact.wave_return.to_numpy(), rel=1e-9)
    windy = rw.Environment("windy", wind_pressure=300.0, wind_from=0.0)
    blown = frequencies(rw.equilibrium(strung(rope, 9.80665), environment=windy), 4, 6)
    still = frequencies(rw.equilibrium(strung(rope, math.hypot(9.80665, wind / 2.4))), 4, 6)
    assert blown == pytest.approx(still, rel=2e-3)


def test_rejected_modes() -> None:
    eq = idler_line()
    for wrong in ({"nodes": -1}, {"nodes": 2000}, {"count": 0}, {"damping": -1e-3}, {"count": 10**9}):
        with pytest.raises(rw.InputError, match=next(iter(wrong))):
            rw.modes(eq, **wrong)
    with pytest.raises(rw.InputError, match="k is 11"):
        rw.modes(eq).plot(11)


def test_shapes_that_are_no_shapes_are_refused() -> None:
    s = rw.System("span")
    s.string(ROPE, rw.Anchor("a", at=(0, 0)), rw.Anchor("b", at=(100, 0)), length=100.5)
    found = rw.modes(rw.equilibrium(s), nodes=3, count=2)
    for shapes in (np.full(found.shapes.shape, np.nan), found.shapes[:1]):
        with pytest.raises(rw.InputError, match="shapes"):
            rw.Modes(found.equilibrium, found.frame, found.points, shapes, found.wave_return)
