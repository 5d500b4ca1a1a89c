"""Eight threads on one model, line or rig give bit-identical results to one thread."""

import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

import ropeway as rw
from ropeway.fmu.cosimulation.cosimulation import CoSimulation
from ropeway.systems.solvers.model_functions import Buffered
from support.fmus import corridor
from support.schedule_lines import line


@pytest.fixture(autouse=True)
def eager() -> Iterator[None]:
    """Threads switch as often as possible."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


def require_same(solve: Callable[[Any], np.ndarray], cases: Sequence[Any]) -> None:
    """Requires equal results of one thread and of eight at a time."""
    with ThreadPoolExecutor(8) as pool:  # first, as cached objects are built then
        together = list(pool.map(solve, cases))
    for question, found in zip(cases, together, strict=True):
        assert found.tobytes() == solve(question).tobytes(), question


def test_a_function_has_results_for_each_thread() -> None:
    x = ca.SX.sym("x", 40)
    f = Buffered(ca.Function("f", [x], [ca.sin(x) * x, ca.sum1(x)]))

    def twice(k: int) -> np.ndarray:
        product, total = f(np.linspace(0.0, k, 40))
        own_sum = product.sum()
        assert product.sum() == own_sum  # no other thread has written there in the meantime
        return np.append(product, total)

    require_same(twice, range(400))


def test_equilibria_of_one_model() -> None:
    model = rw.assemble(line(8, 3))
    require_same(
        lambda mass: rw.equilibrium(model, parameters={"l2.mass": mass, "s1.z": 5.0 + 0.01 * mass}).outputs,
        np.linspace(80.0, 420.0, 24).tolist(),
    )


def test_given_values_of_one_model() -> None:
    s = rw.System("two spans")
    rope = rw.Rope(mass_per_length=2.1, axial_stiffness=21e6, breaking_load=300e3)
    s.string(rope, rw.Anchor("a", at=(0, 0)), rw.Sheave("b", at=(90, 7)), rw.Anchor("c", at=(200, 3)), tension=30e3)
    model = rw.assemble(s)
    require_same(
        lambda wanted: rw.equilibrium(model, given={"b.tension_in": wanted}, solve_for="a_b.length").outputs,
        np.linspace(24e3, 46e3, 16).tolist(),
    )


def test_runs_of_one_model() -> None:
    model = rw.assemble(line(6, 2, drive=None, response=rw.ThresholdResponse(low=36e3, high=44e3, increment=0.01)))
    start = rw.equilibrium(model)

    def run(speed: float) -> np.ndarray:
        return rw.simulate(model, 8.0, start=start, inputs={"c1.speed": speed, "c2.speed": speed}).frame.to_numpy()

    require_same(run, [0.8, 0.9, 0.95, 1.0, 1.1, 1.2, 1.3, 1.4])


def test_derivatives_of_one_equilibrium() -> None:
    rest = rw.equilibrium(line(6, 3))
    names = ["l1.mass", "l2.mass", "s1.z", "s2.z", "s4.z", "s5.z", "c1.z", "gravity"]
    require_same(lambda name: rw.sensitivities(rest, of=["c1.tension_in", "l3.z"], to=name).to_numpy(), names)


def test_load_paths_and_payloads_of_one_rig() -> None:
    rig = corridor(haulback=None, haulback_tension=None)
    stations = [30.0, 100.0, 159.5, 240.0]

    def path(mass: float) -> np.ndarray:
        return rw.load_path(rig, mass, stations).select_dtypes("number").to_numpy()

    require_same(path, [300.0, 600.0, 900.0, 1200.0, 1500.0, 1800.0, 2100.0, 2400.0])

    def largest(factor: float) -> np.ndarray:
        return rw.payload(rig, safety_factor=factor, stations=[70.0, 250.0]).frame["payload"].to_numpy()

    require_same(largest, [2.6, 2.8, 3.0, 3.2, 3.4, 3.6, 3.8, 4.0])


@pytest.mark.slow
def test_inhauls_of_one_rig() -> None:
    rig = corridor()
    require_same(
        lambda mass: rw.inhaul(rig, payload=mass, start=220.0, end=100.0).frame.select_dtypes("number").to_numpy(),
        [500.0, 700.0, 900.0, 1100.0, 1300.0, 1500.0, 1700.0, 1900.0],
    )


@pytest.mark.slow
def test_schedules_sweeps_and_tuning_of_one_line() -> None:
    one = line(8, 2)

    def plan(intervals: int) -> np.ndarray:
        return rw.optimise_schedule(one, 16.0, intervals=intervals).frame.to_numpy()

    require_same(plan, [6, 7, 8, 9])

    def swept(mass: float) -> np.ndarray:
        table = rw.sweep(one, {"l1.mass": [mass, mass + 5.0]}, workers=1)
        return table.select_dtypes("number").to_numpy()

    require_same(swept, [100.0, 200.0, 300.0, 400.0])

    def tuned(seed: int) -> np.ndarray:
        found = rw.tune_response(
            one,
            rw.ThresholdResponse(low=36e3, high=44e3, increment=0.01),
            over={"increment": (0.002, 0.05)},
            minimise="peak tension",
            until=6.0,
            generations=1,
            population=5,
            seed=seed,
            workers=1,
        )
        return found.history["objective"].to_numpy()

    require_same(tuned, [1, 2, 3, 4])


@pytest.mark.slow
def test_fmus_in_threads(tmp_path: Path) -> None:
    one = line(4, 2)
    file = rw.fmu.export(one, tmp_path / "one.fmu")

    def run(mass: float) -> np.ndarray:
        together = CoSimulation(0.5)
        together.add("line", file, start={"c1.speed": 0.5 + mass / 500.0})
        return together.run(5.0).select_dtypes("number").to_numpy()

    require_same(run, [100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0, 450.0])

    def exported(k: int) -> np.ndarray:
        made = rw.fmu.export(one, tmp_path / f"{k}.fmu", platforms=())
        import zipfile

        with zipfile.ZipFile(made) as archive:
            return np.frombuffer(archive.read("sources/model_data.c"), dtype=np.uint8)

    require_same(exported, [1, 2, 3, 4])
