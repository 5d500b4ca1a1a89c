"""Spans and idler lines against direct integration of the cable's differential equations (`oracle.py`)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

import ropeway as rw
from support.lines import GRAVITY, random_line
from support.oracle import Hung, Material, by_ode, by_quadrature, hang, solve_line

BATCH = 20
UP = (0.0, 0.0, 1.0)
pytestmark = pytest.mark.filterwarnings(
    "ignore::ropeway.components.errors.RopewayWarning"
)  # drawn without regard to their strength


@dataclass(frozen=True)
class Single:
    """A span with loads, solved by the library and by the oracle."""

    rope: rw.Rope
    hung: Hung

    @property
    def material(self) -> Material:
        return Material(self.rope.mass_per_length * GRAVITY, *self.rope.strain[:2])

    def solve(self) -> rw.Equilibrium:
        s = rw.System("single")
        (span,) = s.string(
            self.rope,
            rw.Anchor("a", at=(0.0, 0.0, 0.0)),
            rw.Anchor("b", at=tuple(float(x) for x in self.hung.reach)),
            length=self.hung.length,
        )
        for i, (at, load) in enumerate(zip(self.hung.at, self.hung.loads, strict=True)):
            s.hang(rw.Load(f"l{i}", mass=load / GRAVITY), span, at=at)
        return rw.equilibrium(s)


def agree(case: Single, note: object = "") -> None:
    """Requires agreement to 1e-9 of the tension in force and 1e-7 m in position."""
    eq = case.solve()
    known = hang([case.hung], case.material)
    start = np.array([eq[f"a_b.force_{axis}"] for axis in "xyz"])
    top = max(np.linalg.norm(known.start), np.linalg.norm(known.end))
    assert np.linalg.norm(start - known.start[0]) <= 1e-9 * top, note
    for name, value in {
        "tension_a": np.linalg.norm(known.start),
        "tension_b": np.linalg.norm(known.end),
        "vertical_a": -known.start[0, 2],
        "vertical_b": known.end[0, 2],
        "horizontal": np.hypot(known.start[0, 0], known.start[0, 1]),
    }.items():
        assert abs(eq[f"a_b.{name}"] - value) <= 1e-9 * top, (note, name)
    at = np.array([[eq[f"l{i}.{axis}"] for axis in "xyz"] for i in range(len(case.hung.at))]).reshape(-1, 3)
    np.testing.assert_allclose(at, known.loads[0], rtol=0.0, atol=1e-7, err_msg=str(note))


def random_single(seed: int) -> Single:
    """0 to 10 loads, slopes to 80 degrees, from shorter than the chord (elastic) to twice as long."""
    rng = np.random.default_rng([1414, seed])
    across, angle, heading = rng.uniform(10.0, 600.0), rng.uniform(-1.4, 1.4), rng.uniform(-np.pi, np.pi)
    reach = across * np.array([np.cos(heading), np.sin(heading), np.tan(angle)])
    chord = float(np.linalg.norm(reach))
    mass = float(rng.uniform(0.3, 6.0))
    stiff = rng.random() < 0.2
    new = rng.random() < 0.2
    rope = rw.Rope(
        mass_per_length=mass,
        axial_stiffness=np.inf if stiff else mass * 1e7 * rng.uniform(0.3, 1.2),
        breaking_load=mass * 1.8e5,
        stretch=rw.ConstructionStretch() if new else rw.Elastic(),
    )
    excess = float(np.exp(rng.uniform(np.log(1e-5), 0.0)))
    if not stiff and rng.random() < 0.2:
        excess = -rng.uniform(0.0, 5e-3)
    length = chord * (1.0 + excess)
    count = int(rng.integers(0, 11))
    at = np.sort(rng.uniform(0.0, 1.0, count)) * length
    loads = mass * GRAVITY * length * np.exp(rng.uniform(np.log(0.01), np.log(3.0), count))
    return Single(rope, Hung(reach, length, at.tolist(), loads.tolist()))


@pytest.mark.parametrize("first", range(0, 120, BATCH))
def test_random_spans(first: int) -> None:
    for seed in range(first, first + BATCH):
        agree(random_single(seed), f"seed {seed}")


@pytest.mark.slow
@pytest.mark.parametrize("first", range(120, 1000, 80))
def test_more_random_spans(first: int) -> None:
    for seed in range(first, first + 80):
        agree(random_single(seed), f"seed {seed}")


ELASTIC = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
INEXTENSIBLE = rw.Rope(mass_per_length=3.48, axial_stiffness=np.inf, breaking_load=576.6e3)
NEW = rw.Rope(
    mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3, stretch=rw.ConstructionStretch(0.0414)
)


@dataclass(frozen=True)
class Limit:
    """A limiting case: horizontal span, rise, length over chord, loads."""

    across: float
    rise: float
    share: float
    at: tuple[float, ...] = ()
    loads: tuple[float, ...] = field(default=())

    def single(self, rope: rw.Rope) -> Single:
        length = float(np.hypot(self.across, self.rise) * self.share)
        return Single(rope, Hung((self.across, 0.0, self.rise), length, [a * length for a in self.at], self.loads))


TEN = tuple(np.linspace(0.05, 0.95, 10))
LIMITS = {
    "taut": Limit(300.0, 20.0, 1.00001),
    "taut with a load": Limit(300.0, 20.0, 1.00001, (0.3,), (5e3,)),
    "slack": Limit(100.0, 10.0, 3.0),
    "slack with loads": Limit(100.0, 10.0, 3.0, (0.2, 0.5, 0.9), (4e3, 1e2, 9e3)),
    "steep up": Limit(50.0, 400.0, 1.003, (0.4,), (8e3,)),
    "steep down": Limit(50.0, -400.0, 1.003, (0.4,), (8e3,)),
    "near vertical, taut": Limit(1.0, 150.0, 1.0002),
    "near vertical, slack": Limit(1.0, 150.0, 1.01),
    "near vertical, folded": Limit(1.0, 150.0, 1.5),
    "near vertical, down": Limit(1.0, -150.0, 1.001),
    "near vertical with loads": Limit(1.0, 150.0, 1.01, (0.1, 0.6, 0.95), (2e3, 7e3, 500.0)),
    "one load": Limit(200.0, -30.0, 1.01, (0.5,), (2e4,)),
    "ten loads": Limit(500.0, 60.0, 1.004, TEN, (3e3,) * 10),
    "ten loads, slack": Limit(500.0, 60.0, 1.4, TEN, tuple(500.0 * (k + 1) for k in range(10))),
    "coincident loads": Limit(300.0, 0.0, 1.01, (0.25, 0.25, 0.7, 0.7, 0.7), (1e3, 2e3, 3e3, 4e3, 5e3)),
    "loads at both ends": Limit(300.0, 0.0, 1.01, (0.0, 0.0, 1.0), (1e3, 2e3, 3e3)),
    "tiny load": Limit(300.0, 15.0, 1.003, (0.6,), (1e-6,)),
    "huge load": Limit(300.0, 15.0, 1.03, (0.6,), (2e5,)),
}


@pytest.mark.parametrize("rope", [ELASTIC, INEXTENSIBLE, NEW], ids=["elastic", "inextensible", "new"])
@pytest.mark.parametrize("limit", LIMITS)
def test_limits(limit: str, rope: rw.Rope) -> None:
    agree(LIMITS[limit].single(rope))


@pytest.mark.parametrize("rope", [ELASTIC, NEW], ids=["elastic", "new"])
@pytest.mark.parametrize("limit", [Limit(300.0, 40.0, 0.999), Limit(1.0, 150.0, 0.997, (0.5,), (3e3,))])
def test_shorter_than_the_chord(limit: Limit, rope: rw.Rope) -> None:
    agree(limit.single(rope))


@pytest.mark.parametrize("count", range(11))
def test_loads_by_number(count: int) -> None:
    rng = np.random.default_rng(count)
    at = np.sort(rng.uniform(0.02, 0.98, count))
    agree(Limit(250.0, -40.0, 1.015, tuple(at), tuple(rng.uniform(1e2, 1e4, count))).single(ELASTIC))


def integrated_line(seed: int) -> None:
    """An idler line of `lines.py`, refined with the integrator, against the library."""
    case = random_line(seed, most=8, controlled=False)
    eq = rw.equilibrium(case.system())
    names = [s.name for s in eq.runs[0].spans]
    start = np.array([[eq[f"{name}.force_{axis}"] for axis in "xyz"] for name in names])
    (section,) = case.taut(start).sections
    known = solve_line(section.line, section.solved.start, section.solved.rope, by_ode)
    scale = np.linalg.norm(known.start, axis=1).max()
    assert np.abs(start - known.start).max() <= 1e-9 * scale, seed
    tension = np.array([eq[f"{name}.tension_b"] for name in names])
    assert np.abs(tension - np.linalg.norm(known.end, axis=1)).max() <= 1e-9 * scale, seed
    np.testing.assert_allclose([eq[f"{name}.length"] for name in names], np.diff(known.rope), rtol=0.0, atol=1e-7)
    count = len(known.loads)
    at = np.array([[eq[f"l{i}.{axis}"] for axis in "xyz"] for i in range(count)]).reshape(-1, 3)
    np.testing.assert_allclose(at, known.loads, rtol=0.0, atol=1e-7, err_msg=str(seed))


@pytest.mark.parametrize("first", range(0, 40, 10))
def test_idler_lines(first: int) -> None:
    for seed in range(first, first + 10):
        integrated_line(seed)


@pytest.mark.slow
def test_more_idler_lines() -> None:
    for seed in range(40, 120):
        integrated_line(seed)


def test_the_curve_between_the_supports() -> None:
    """Positions, tensions and slopes at any station, also exactly at a load."""
    case = Limit(300.0, -35.0, 1.02, (0.2, 0.7), (4e3, 9e3)).single(ELASTIC)
    eq = case.solve()
    stations = np.linspace(0.0, case.hung.length, 41)
    curve = eq.profile("a_b", stations)
    start = np.array([eq[f"a_b.force_{axis}"] for axis in "xyz"])
    for station, x, y, z, tension, slope in curve[["station", "x", "y", "z", "tension", "slope"]].itertuples(
        index=False
    ):
        before = [i for i, a in enumerate(case.hung.at) if a < station]
        cut = Hung(UP, station, [case.hung.at[i] for i in before], [case.hung.loads[i] for i in before])
        piece, load = cut.pieces(3)
        there = by_ode(start[None], piece[None], load[None], case.material)
        np.testing.assert_allclose([x, y, z], there.node[0, -1], rtol=0.0, atol=1e-7)
        force = there.end[0]
        assert tension == pytest.approx(np.linalg.norm(force), rel=1e-9)
        assert slope == pytest.approx(force[2] / np.hypot(force[0], force[1]), rel=1e-9, abs=1e-9)


def test_the_two_integrators_of_the_oracle_agree() -> None:
    """Quadrature, used to build the random lines, and the Runge-Kutta method."""
    for seed in range(5):
        (section,) = random_line(seed, most=6, controlled=False).sections
        line, solved = section.line, section.solved
        polished = solve_line(line, solved.start, solved.rope, by_ode)
        np.testing.assert_allclose(solved.start, polished.start, rtol=0.0, atol=1e-11 * np.abs(solved.start).max())
    force, piece = np.array([[3e3, 100.0, -2e3]]), np.array([[40.0, 0.0, 60.0]])
    load = np.array([[500.0, 200.0, 0.0]])
    one, other = (f(force, piece, load, Material(30.0, 3e-8, 2e-13)) for f in (by_ode, by_quadrature))
    for name in ("node", "compliance", "energy", "end"):
        a, b = getattr(one, name), getattr(other, name)
        np.testing.assert_allclose(a, b, rtol=1e-11, atol=1e-12 * np.abs(b).max())


def test_the_oracle_by_hand() -> None:
    """A level inextensible span with a known catenary: a = 1000 m, half span a asinh(1/4)."""
    across = 2000.0 * np.arcsinh(0.25)
    solved = hang([Hung((across, 0.0, 0.0), 500.0)], Material(20.0))
    np.testing.assert_allclose(solved.start[0], [20e3, 0.0, -5e3], rtol=1e-11, atol=1e-7)
    np.testing.assert_allclose(solved.end[0], [20e3, 0.0, 5e3], rtol=1e-11, atol=1e-7)
