"""Cases of statics that once gave wrong numbers without an error, each against independent physics."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

import ropeway as rw
from ropeway.systems.solvers.damped_newton import damped
from ropeway.systems.statics import settling
from ropeway.systems.statics.line_state import LineState
from support.oracle import Material, by_quadrature

G = 9.80665
ROPE = rw.Rope(mass_per_length=2.9, axial_stiffness=27e6, breaking_load=480e3)


def one_span(rope: rw.Rope, end: tuple[float, float], length: float) -> rw.System:
    s = rw.System("span")
    s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=end), length=length)
    return s


@pytest.mark.parametrize("stiffness", [4e5, 3e7])
@pytest.mark.parametrize("excess", [0.0, 0.02, -0.004])
def test_an_inextensible_rope_on_a_spring(stiffness: float, excess: float) -> None:
    """For a rope as long as its chord, or shorter, geometry is no good guess: the spring yields."""
    rope = rw.Rope(mass_per_length=2.7, axial_stiffness=np.inf, breaking_load=9e6)
    s = rw.System("spring")
    a, b = rw.SpringAnchor("a", at=(0.0, 0.0), stiffness=stiffness), rw.Anchor("b", at=(84.0, 13.0))
    length = 85.0 + excess
    for node in (a, b):
        s.add(node)
    span = s.add(rw.Span("r", rope=rope, length=length))
    s.connect(span.a, a.rope)
    s.connect(span.b, b.rope)
    eq = rw.equilibrium(s)
    at = np.array([eq[f"a.{axis}"] for axis in "xyz"])
    pull = np.array([eq[f"r.force_{axis}"] for axis in "xyz"])
    np.testing.assert_allclose(stiffness * at, pull, rtol=1e-8, atol=1e-6 * np.linalg.norm(pull))
    hung = by_quadrature(pull[None], np.array([[length]]), np.zeros((1, 1)), Material(2.7 * G))
    np.testing.assert_allclose(at + hung.node[0, -1], [84.0, 0.0, 13.0], atol=1e-7)


def test_a_predicted_root_is_checked() -> None:
    """A residual with a slope that predicts a root one tiny step away, where none exists."""

    def step(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return 0.38 + 1e-9 * v, (0.38 + 1e-9 * v) / 1e9

    with pytest.raises(rw.EquilibriumError):
        damped(np.ones(1), step, lambda v: 0.38 + 1e-9 * v, ["x.residual"])

    def huge(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return v, np.where(np.abs(v) < 1e-100, 1e140, v * (1.0 - 1e-3))

    with pytest.raises(rw.RopewayError):
        damped(np.array([1e-110]), huge, lambda v: v + 1.0, ["x.residual"])


@pytest.mark.parametrize("across", [0.0, 1e-7, 0.004, 0.3])
@pytest.mark.parametrize(("rise", "length"), [(35.0, 48.0), (-35.0, 48.0), (35.0, 34.99), (35.0, 35.0), (0.5, 90.0)])
def test_vertical_ropes(across: float, rise: float, length: float) -> None:
    """A doubled or vertical rope: each end carries its own part."""
    rope = rw.Rope(mass_per_length=41.0, axial_stiffness=6e8, breaking_load=4e6)
    eq = rw.equilibrium(one_span(rope, (across, rise), length))
    w, c1 = 41.0 * G, 1.0 / 6e8
    if length > abs(rise):  # d1 and d2 hang from both ends; d stretches by c1 w d^2 / 2
        low, high = 0.0, length
        for _ in range(200):
            d1 = (low + high) / 2.0
            d2 = length - d1
            low, high = (d1, high) if (d2 - d1) + c1 * w / 2.0 * (d2**2 - d1**2) > rise else (low, d1)
        if min(d1, d2) > 0.1:
            assert eq["a_b.tension_a"] == pytest.approx(w * d1, rel=2e-3 * max(across, 1e-6))
            assert eq["a_b.tension_b"] == pytest.approx(w * d2, rel=2e-3 * max(across, 1e-6))
    assert eq.certificate["holds"].all()
    assert eq["a_b.vertical_a"] + eq["a_b.vertical_b"] == pytest.approx(w * length, rel=1e-12)
    for energy in ("elastic_energy", "gravity_energy"):
        assert np.isfinite(eq[f"a_b.{energy}"])


def test_a_nearly_vertical_slack_rope_against_integration() -> None:
    """The rope's direction, integrated around its sharp bend, leads from one end to the other."""
    rope = rw.Rope(mass_per_length=8.3, axial_stiffness=7e7, breaking_load=9e5)
    eq = rw.equilibrium(one_span(rope, (0.02, 21.0), 64.0))
    across, up, w = eq["a_b.force_x"], eq["a_b.force_z"], 8.3 * G

    def slope(s: float, part: float) -> float:
        tension = np.hypot(across, up + w * s)
        return float((across if part == 0 else up + w * s) / tension * (1.0 + tension / 7e7))

    belly = -up / w
    cuts = [0.0, *(belly + side * 10.0**k for side in (-1.0, 1.0) for k in (-4.0, -3.0, -2.0, -1.0, 0.0)), belly, 64.0]
    for part, right in ((0, 0.02), (1, 21.0)):
        pieces = [quad(slope, *ends, args=(part,), epsabs=1e-14)[0] for ends in itertools.pairwise(sorted(cuts))]
        assert sum(pieces) == pytest.approx(right, abs=1e-9)


@pytest.mark.parametrize(
    ("spans", "kept", "pinned"), list(itertools.product((1, 2, 3), ("start", "end", "none"), (0, -1)))
)
def test_a_load_on_one_span_has_its_declared_position(spans: int, kept: str, pinned: int) -> None:
    at = [(47.0 * k, 2.5 * (k % 2)) for k in range(spans + 1)]
    nodes = [rw.Anchor("n0", at=at[0]), *(rw.Sheave(f"n{k}", at=at[k]) for k in range(1, spans))]
    nodes.append(rw.Anchor(f"n{spans}", at=at[-1]))
    if kept != "none":
        k = 0 if kept == "start" else spans
        nodes[k] = rw.Drum(f"n{k}", at=at[k], tension=52e3)
    if spans == 3 and kept != "none":
        nodes[1] = rw.ControlSheave("n1", at=at[1], speed=0.0)
    s = rw.System("pinned")
    on = s.string(ROPE, *nodes, length=47.0 * spans * 1.04)
    s.hang(rw.Load("l", mass=430.0), on[pinned], at=21.5)
    eq = rw.equilibrium(s)
    assert eq["l.distance"] == pytest.approx(21.5, abs=1e-9)
    assert eq.loads["span"].tolist() == [on[pinned].name]


def test_loads_at_the_start_and_beyond_the_end_of_a_span() -> None:
    def made(at: float) -> rw.System:
        s = rw.System("ends")
        nodes = [
            rw.Drum("d", at=(0.0, 0.0), tension=70e3),
            rw.Sheave("s", at=(55.0, 1.0)),
            rw.Anchor("e", at=(110.0, 0.0)),
        ]
        spans = s.string(ROPE, *nodes, length=121.0)
        s.hang(rw.Load("l", mass=300.0), spans[1], at=at)
        return s

    eq = rw.equilibrium(made(0.0))
    assert eq.loads["span"].tolist() == ["s_e"]
    with pytest.raises(rw.EquilibriumError, match=r"'l' hangs 60 m along span 's_e'"):
        rw.equilibrium(made(60.0))


@pytest.mark.parametrize("tension", [35e3, 75e3])
def test_a_freed_length_and_loads_along_the_rope(tension: float) -> None:
    """For each freed span the rope has the same final length, and the loads are at their declared positions."""
    found = []
    for freed in ("a_m1.length", "m1_m2.length", "m2_b.length"):
        s = rw.System("freed")
        ends = rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(265.0, 4.0))
        sheaves = rw.Sheave("m1", at=(85.0, 3.0)), rw.Sheave("m2", at=(175.0, 1.0))
        spans = s.string(ROPE, ends[0], *sheaves, ends[1], length=266.0)
        for name, mass, at in (("l1", 500.0, 41.0), ("l2", 340.0, 132.0), ("l3", 610.0, 221.0)):
            s.hang(rw.Load(name, mass=mass), spans, at=at)
        eq = rw.equilibrium(s, given={"a_m1.tension_a": tension}, solve_for=freed)
        lengths = [eq[f"{span.name}.length"] for span in spans]
        found.append([*lengths, *(eq[f"l{k}.{axis}"] for k in (1, 2, 3) for axis in "xz")])
        assert eq["l3.distance"] + lengths[0] + lengths[1] == pytest.approx(221.0, abs=1e-9)
        plain = rw.System("plain")
        again = plain.string(ROPE, ends[0], *sheaves, ends[1], length=sum(lengths))
        for name, mass, at in (("l1", 500.0, 41.0), ("l2", 340.0, 132.0), ("l3", 610.0, 221.0)):
            plain.hang(rw.Load(name, mass=mass), again, at=at)
        assert rw.equilibrium(plain)["a_m1.tension_a"] == pytest.approx(tension, rel=1e-8)
    np.testing.assert_allclose(found[1:], found[:1] * np.ones((2, 1)), atol=1e-7)


def test_loads_above_the_breaking_load_cause_a_warning() -> None:
    s = one_span(ROPE, (240.0, 0.0), 241.0)
    s.hang(rw.Load("turn", mass=26e3), s.components["a_b"], at=100.0)  # type: ignore[arg-type]
    with pytest.warns(rw.RopewayWarning, match=r"span 'a_b' at rest is 1\.\d+ times .* breaking load\. Take lighter"):
        eq = rw.equilibrium(s)
    assert max(eq["a_b.tension_a"], eq["a_b.tension_b"]) > 480e3


@pytest.mark.parametrize(
    ("mass", "tension", "blamed"), [(60.0, 20e3, False), (2600.0, 20e3, True), (2600.0, None, False)]
)
def test_loads_are_not_the_cause_of_a_numerical_failure(
    mass: float, tension: float | None, blamed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A solver that fails above 30 % of the loads. The error names loads only if their weight is comparable with the
    tension, and if a drum pays out rope. A rope of fixed length holds any load."""
    s = rw.System("one span")
    (span,) = s.string(
        ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Drum("b", at=(150.0, 12.0), tension=tension), length=155.0
    )
    s.hang(rw.Load("turn", mass=mass), span, at=70.0)
    solve = settling.solve

    def failing(state: LineState, *, quick: bool = False) -> None:
        if state.runs[0].loads.mass[0] > 0.3 * mass:
            raise rw.EquilibriumError("no convergence")
        solve(state, quick=quick)

    monkeypatch.setattr(settling, "solve", failing)
    with pytest.raises(rw.EquilibriumError) as caught:
        settling.loaded(LineState.cold(rw.assemble(s)))
    assert isinstance(caught.value, settling.TooHeavyError) == blamed
    assert ("too heavy" in caught.value.cause) == blamed


def test_loads_on_a_rope_of_fixed_length_are_not_the_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """A drum's tension holds another rope of the system, without loads."""
    s = rw.System("two ropes")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(150.0, 12.0)), length=155.0)
    s.hang(rw.Load("turn", mass=4000.0), span, at=70.0)
    s.string(ROPE, rw.Anchor("c", at=(0.0, 9.0)), rw.Drum("d", at=(150.0, 21.0), tension=15e3), length=151.0)
    solve = settling.solve

    def failing(state: LineState, *, quick: bool = False) -> None:
        if state.runs[0].loads.mass[0] > 1200.0:
            raise rw.EquilibriumError("no convergence")
        solve(state, quick=quick)

    monkeypatch.setattr(settling, "solve", failing)
    with pytest.raises(rw.EquilibriumError, match="No equilibrium of system 'two ropes' is found"):
        settling.loaded(LineState.cold(rw.assemble(s)))


def test_a_line_is_solved_by_continuation_in_its_loads(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the start from geometry fails, loads are increased gradually, including those still in a feed."""
    table = Path(__file__).parents[3] / "examples" / "line.csv"
    line = rw.assemble(rw.monocable(ROPE, table, tension=48e3, load_mass=[700.0, 250.0], load_spacing=37.0))
    shares: list[float] = []
    state = settling.loaded(LineState.cold(line), shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    plain = rw.equilibrium(line)
    assert np.concatenate([run.loads.mass for run in state.runs])[:4] == pytest.approx([700.0, 250.0, 700.0, 250.0])
    assert state.runs[0].feed is not None
    assert state.runs[0].feed.masses == pytest.approx((700.0, 250.0))
    state.rezero()
    assert state.outputs() == pytest.approx(plain.outputs, rel=1e-7, abs=1e-5)


@pytest.mark.slow
def test_the_error_names_loads_that_are_too_heavy() -> None:
    """A line of ten spans with a constant-tension drum: under these loads the rope would run out indefinitely."""
    table = Path(__file__).parents[3] / "examples" / "line.csv"
    line = rw.monocable(ROPE, table, tension=45e3, load_mass=18e3, load_spacing=50.0)
    with pytest.raises(rw.EquilibriumError, match=r"too heavy for its rope.* Take lighter or fewer loads"):
        rw.equilibrium(line)
