"""A common start of slaves whose outputs follow their inputs at once: algebraic loops."""

from pathlib import Path

import pytest
from scipy.optimize import brentq

from ropeway.fmu import CoSimulation, FmuRunError, Slave, load
from support.masses import mass_fmu

STIFF = {"x": 1.0, "stiffness": 3.0, "cubic": 0.5}


def loop(path: Path, **start: float) -> CoSimulation:
    """An acceleration that is a displacement: physics no one needs, but a loop of one cubic equation."""
    together = CoSimulation(0.1, tolerance=1e-12)
    together.add("spring", path, start=STIFF)
    together.add("mass", path, start={"mass": 2.0, "spring": 1.0, "x": 0.3, **start})
    together.connect("spring.f", "mass.force")
    together.connect("mass.a", "spring.x_in")
    return together


@pytest.mark.parametrize("differentiates", [True, False])
def test_a_loop_is_closed(tmp_path: Path, differentiates: bool) -> None:
    path = mass_fmu(tmp_path / "mass.fmu", differentiates=differentiates)

    def force(x_in: float) -> float:
        return 3.0 * (1.0 - x_in) + 0.5 * (1.0 - x_in) ** 3

    wanted = brentq(lambda a: (force(a) - 0.3) / 2.0 - a, -10.0, 10.0, xtol=1e-14)
    first = loop(path).run(0.1).iloc[0]
    assert first["mass.a"] == pytest.approx(wanted, rel=1e-10)
    assert first["spring.f"] == pytest.approx(force(wanted), rel=1e-10)


def test_directional_derivatives_are_used(tmp_path: Path) -> None:
    outputs, inputs = ["f", "a"], {"x_in": 0.25, "v_in": 0.0, "force": 2.0}
    found = []
    for differentiates in (True, False):
        path = mass_fmu(tmp_path / f"mass{differentiates}.fmu", differentiates=differentiates)
        with Slave(load(path)) as slave:
            slave.enter(0.0, STIFF)
            slave.set(inputs)
            found.append(slave.derivatives(outputs, inputs))
    assert found[0].tolist() == [[-3.0 - 1.5 * 0.75**2, 0.0, 0.0], [3.0 + 1.5 * 0.75**2, 0.0, 1.0]]
    assert found[1] == pytest.approx(found[0], rel=1e-5, abs=1e-5)


def test_a_loop_without_a_solution(mass: Path) -> None:
    together = CoSimulation(0.1)
    together.add("spring", mass, start={"stiffness": -1.0, "x": 1.0})
    together.add("mass", mass)
    together.connect("spring.f", "mass.force")  # f = a - 1
    together.connect("mass.a", "spring.x_in")  # a = f / 1 kg
    with pytest.raises(FmuRunError, match=r"did not converge: .* do not agree"):
        together.run(0.1)


def test_nan_is_not_passed_on(mass: Path) -> None:
    together = CoSimulation(0.1)
    together.add("one", mass, start={"stiffness": 1e200, "x": 1e200})
    together.add("two", mass)
    together.connect("one.f", "two.force")
    with pytest.raises(FmuRunError, match=r"one\.f is inf at t = 0 s"):
        together.run(1.0)
