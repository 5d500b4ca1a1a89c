"""Compiled code for any system: the same Jacobians, roots, rates and failures as without, from kernels of kinds."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.sparse import csc_matrix

import ropeway as rw
from ropeway.examples import own_component
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import in_code
from ropeway.systems.native.binary_cache import cache_info
from ropeway.systems.solvers.kernels.compiled_network import CompiledPivots
from ropeway.systems.solvers.newton import Newton, newton_of, outputs_of, residuals_of
from ropeway.systems.statics.line_state import LineState

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)


def spring_line(bulge: float = 20.0, mass: float = 900.0, idlers: int = 1, tension: float = 60e3) -> rw.System:
    """A rope over idlers with friction, behind a driven drum, to an anchor that gives way."""
    system = rw.System("spring")
    between = [rw.Sheave(f"s{i}", at=(400.0 * (i + 1) / (idlers + 1), bulge), friction=0.02) for i in range(idlers)]
    ends = rw.Drum("a", at=(0.0, 0.0), speed=0.3), rw.SpringAnchor("b", at=(400.0, -60.0), stiffness=2e5)
    spans = system.string(ROPE, ends[0], *between, ends[1], tension=tension)
    system.hang(rw.Load("l1", mass=mass), spans, at=90.0)
    system.hang(rw.Load("l2", mass=500.0), spans, at=290.0)
    return system


def own_line() -> rw.System:
    """Components of a user, one of them with an input and states."""
    return own_component.line()


def windy() -> rw.System:
    """A plane line in wind across it."""
    rope = rw.Rope(
        mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3, diameter=0.029,
        thermal_expansion=11.5e-6, drag_coefficient=1.1,
    )  # fmt: skip
    system = rw.System("windy", temperature=15.0)
    nodes = rw.Anchor("a", at=(0.0, 0.0)), rw.Sheave("s", at=(150.0, 9.0)), rw.Block("b", at=(300.0, 2.0))
    spans = system.string(rope, *nodes, rw.SpringAnchor("e", at=(420.0, 3.0), stiffness=4e5), length=423.0)
    system.hang(rw.Load("l", mass=700.0, drag_area=1.2), spans, at=200.0)
    return system.in_weather(
        rw.Environment("gust", temperature=-5.0, ice_thickness=0.006, ice_density=900.0, wind_pressure=300.0)
    )


def yard() -> rw.System:
    """A line in a system, whose drives share the flow of a power unit."""
    drive = rw.HydraulicDrive(
        displacement=1e-4, gear_ratio=20.0, sheave_radius=0.6, relief_pressure=3e7, pump_flow=0.02, engine_power=2e5,
        inertia=500.0, drag=200.0,
    )  # fmt: skip
    line, outer = rw.System("line"), rw.System("yard")
    sheaves = [rw.ControlSheave(f"c{i}", at=(120.0 * i, 4.0 * i), speed=0.5, drive=drive) for i in (1, 2)]
    ends = rw.SpringAnchor("a", at=(0.0, 0.0), stiffness=5e5), rw.Anchor("b", at=(360.0, 5.0))
    line.string(ROPE, ends[0], *sheaves, ends[1], tension=50e3)
    parts = outer.add(line, name="p")
    unit = outer.add(rw.HydraulicPowerUnit("unit", pump_flow=2e-3, engine_power=20e3))
    for name in ("c1", "c2"):
        outer.connect(parts[name].supply, unit.outlet)
    return outer


SYSTEMS = [spring_line, own_line, windy, yard]


@pytest.mark.parametrize("system", SYSTEMS)
def test_an_equilibrium(system: Callable[[], rw.System]) -> None:
    one, other = (rw.equilibrium(system(), compiled=compiled) for compiled in (True, False))
    assert not one.model.compiled
    np.testing.assert_allclose(*(eq.frame["value"].to_numpy(float) for eq in (one, other)), rtol=1e-9, atol=1e-7)
    assert one.certificate["holds"].all()


@pytest.mark.parametrize("system", SYSTEMS)
def test_functions_of_a_model_away_from_its_solution(system: Callable[[], rw.System]) -> None:
    plain = assemble(system())
    compiled, point = in_code(plain, compiled=True), LineState.cold(plain).point
    for model in (plain, compiled):
        assert in_code(model, compiled=False) is plain
    matrices = [newton_of(model).matrix(point).toarray() for model in (compiled, plain)]
    np.testing.assert_allclose(*matrices, rtol=1e-11, atol=1e-12)
    for values in (outputs_of, residuals_of):
        one, other = (values(model)(*point.arguments)[0].copy() for model in (compiled, plain))
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-8)


@pytest.mark.parametrize("system", SYSTEMS)
def test_rates(system: Callable[[], rw.System]) -> None:
    eq = rw.equilibrium(system())
    slope = np.random.default_rng(1).normal(size=len(eq.model.u)) * eq.model.u.nominals
    one, other = (
        newton_of(in_code(eq.model, compiled=compiled)).solve(eq.point.copy(), slope=slope)
        for compiled in (True, False)
    )
    assert one is not None
    assert np.abs(one).max() > 0.0
    np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-9 * np.abs(other).max())


@pytest.mark.parametrize(
    ("wanted", "freed"),
    [({"s0_b.tension_b": 5e3}, ["a_s0.length"]), ({"l2.z": -0.4, "b.x": -0.02}, ["l2.mass", "a_s0.length"])],
)
def test_given_values(wanted: dict[str, float], freed: list[str]) -> None:
    rest = rw.equilibrium(spring_line())
    given = {name: rest[name] + change for name, change in wanted.items()}
    one, other = (
        rw.equilibrium(spring_line(), given=given, solve_for=freed, compiled=compiled) for compiled in (True, False)
    )
    np.testing.assert_allclose(one.frame["value"], other.frame["value"], rtol=1e-8, atol=1e-5)
    for name, value in given.items():
        assert one[name] == pytest.approx(value)


def test_a_run_with_an_anchor_that_gives_way_and_one_with_own_components() -> None:
    for system in (spring_line(), own_line()):
        one, other = (rw.simulate(system, 12.0, compiled=compiled) for compiled in (True, False))
        assert one.events["event"].tolist() == other.events["event"].tolist()
        np.testing.assert_allclose(one.events["time"], other.events["time"], atol=1e-6)
        np.testing.assert_allclose(one.frame, other.frame, rtol=1e-6, atol=1e-3)
        assert not one.model.compiled


def test_other_values_need_no_compiler() -> None:
    rw.equilibrium(spring_line(idlers=2), compiled=True)
    known = cache_info().libraries
    for system in (spring_line(15.0, 700.0, 3, 55e3), spring_line(25.0, 1200.0, 4, 70e3)):
        rw.equilibrium(system, compiled=True)
    assert cache_info().libraries == known


def test_failures_are_those_without_compiled_code() -> None:
    system = spring_line()
    for name, value in (("l2.z", 400.0), ("b.y", 1.0)):
        wanted = {"given": {name: value}, "solve_for": "l1.mass"}
        with pytest.raises(rw.EquilibriumError) as plain:
            rw.equilibrium(system, **wanted)
        with pytest.raises(rw.EquilibriumError) as compiled:
            rw.equilibrium(system, **wanted, compiled=True)
        assert compiled.value.remedy == plain.value.remedy
        assert compiled.value.component == plain.value.component
    model = in_code(assemble(system), compiled=True)
    point = LineState.cold(model).point
    before = point.z.copy()
    with pytest.raises(rw.EquilibriumError, match="has not converged in 2 iterations"):
        newton_of(model).solve(point, iterations=2)
    np.testing.assert_array_equal(point.z, before)
    point.z[model.z.index["b.x"]] = np.nan
    with pytest.raises(rw.EquilibriumError, match="singular"):
        newton_of(model).solve(point)


@dataclass(frozen=True)
class Foreign(rw.Anchor):
    """An anchor as of code that CasADi does not see into."""

    @property
    def external(self) -> bool:
        return True


def test_code_of_others_is_refused() -> None:
    system = rw.System("foreign")
    system.string(ROPE, rw.Anchor("a", at=(0, 0)), Foreign("b", at=(100, 3)), length=101.0)
    with pytest.raises(rw.CompiledError, match="'b'"):
        rw.equilibrium(system, compiled=True)
    with pytest.raises(rw.CompiledError, match="'b'"):
        rw.simulate(system, 5.0, compiled=True)


def test_threads_on_one_model_give_identical_results() -> None:
    model = in_code(assemble(spring_line()), compiled=True)
    start = LineState.cold(model).point

    def root(mass: float) -> bytes:
        point = start.copy()
        point.d[model.d.index["a_s0.slot_mass[1]"]] = mass
        newton_of(model).solve(point)  # built by whichever threads are first
        return point.z.tobytes() + outputs_of(model)(*point.arguments)[0].tobytes()

    masses = np.linspace(300.0, 1500.0, 200).tolist()
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(root, masses))
    assert together == [root(mass) for mass in masses]


def test_a_model_is_solved_for_freed_states() -> None:
    model = assemble(spring_line())
    freed, given = [(rw.Kind.STATE, model.x.index["a.travel"])], [(rw.Kind.ALGEBRAIC, model.z.index["b.x"])]
    points = []
    for compiled in (True, False):
        point = LineState.cold(model).point
        newton_of(model).solve(point)
        target = np.array([point.z[given[0][1]] - 0.02])
        Newton(in_code(model, compiled=compiled), freed, given).solve(point, target=target)
        points.append(np.concatenate([point.x, point.z]))
    np.testing.assert_allclose(*points, rtol=1e-10, atol=1e-8)


@pytest.mark.parametrize("seed", range(6))
def test_pivots_behind_an_inner_matrix(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, outer = int(rng.integers(6, 40)), int(rng.integers(1, 5))
    matrix = np.where(rng.random((n, n)) < 0.15, rng.normal(size=(n, n)), 0.0)
    inner = n - outer
    matrix[np.arange(inner), rng.permutation(inner)] += 3.0  # no usable diagonal, but no singular matrix
    matrix[np.arange(inner, n), np.arange(inner, n)] += 5.0
    pattern = csc_matrix(matrix)
    entries = pattern.data.copy()
    pattern.data = np.arange(1.0, len(entries) + 1.0)
    whole = np.linalg.inv(np.linalg.inv(matrix)[inner:, inner:])
    own = [np.linalg.det(whole[: k + 1, : k + 1]) / (np.linalg.det(whole[:k, :k]) if k else 1.0) for k in range(outer)]
    np.testing.assert_allclose(CompiledPivots(pattern, inner)(entries), own, rtol=1e-8)
    with pytest.raises(RuntimeError, match="singular"):
        CompiledPivots(pattern, inner)(np.where(pattern.indices == 0, 0.0, entries))
