"""Directional derivatives against finite differences and against the model; dependencies against both."""

from pathlib import Path
from typing import Literal

import casadi as ca
import fmpy
import numpy as np
import pytest

import ropeway as rw
from ropeway.fmu import export
from support.fmus import HYDRAULIC, RESPONSE, Opened, Opener, example_line, short_line


@pytest.fixture
def moved(open_fmu: Opener, driven: Path) -> Opened:
    """In mid-run: states are not at their starts."""
    one = open_fmu(driven, kind="ModelExchange")
    one.set(**{n.replace(".", "__"): v for n, v in zip(states(one), (1.7, 0.93, 0.02), strict=False)})
    one.initialize()
    return one


def states(one: Opened) -> list[str]:
    return [v.derivative.name for v in one.description.modelVariables if v.derivative is not None]


def unknowns(one: Opened) -> list[str]:
    return [
        v.name
        for v in one.description.modelVariables
        if v.type == "Real" and (v.derivative is not None or v.initial == "calculated")
    ]


def matrix(one: Opened, knowns: list[str]) -> np.ndarray:
    rows = [one.references[n] for n in unknowns(one)]
    return np.array([one.fmu.getDirectionalDerivative(rows, [one.references[k]], [1.0]) for k in knowns], dtype=float).T


def differences(one: Opened, knowns: list[str], steps: list[float]) -> np.ndarray:
    columns = []
    for name, h in zip(knowns, steps, strict=True):
        (value,) = one.get(name)
        sides = []
        for shift in (h, -h):
            one.set(**{name.replace(".", "__"): value + shift})
            sides.append(np.array(one.get(*unknowns(one))))
        one.set(**{name.replace(".", "__"): value})
        columns.append((sides[0] - sides[1]) / (2 * h))
    return np.array(columns).T


def test_derivatives_equal_differences(moved: Opened) -> None:
    knowns = [*states(moved), *(v.name for v in moved.description.modelVariables if v.causality == "input")]
    exact = matrix(moved, knowns)
    found = differences(moved, knowns, [1e-5] * len(knowns))
    assert np.abs(exact).max() > 100.0
    assert np.abs(exact - found).max(axis=1) == pytest.approx(0.0, abs=1e-5 * np.abs(exact).max())
    assert exact == pytest.approx(found, rel=1e-5, abs=1e-6 * np.abs(exact).max())


def test_derivatives_by_parameters(span3: Path, open_fmu: Opener) -> None:
    one = open_fmu(span3)
    one.fmu.enterInitializationMode()
    rows = [one.references[n] for n in ("a_b.tension_a", "a_b.vertical_b")]
    for name, h in (("turn.mass", 1.0), ("a_b.length_start", 1e-4), ("gravity", 1e-4)):
        reference = one.references[name]
        exact = one.fmu.getDirectionalDerivative(rows, [reference], [1.0])
        value = one.fmu.getFloat64([reference])[0]
        sides = []
        for shift in (h, -h):
            one.fmu.setFloat64([reference], [value + shift])
            sides.append(np.array(one.fmu.getFloat64(rows)))
        one.fmu.setFloat64([reference], [value])
        assert list(exact) == pytest.approx(list((sides[0] - sides[1]) / (2 * h)), rel=1e-5)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_every_output_has_the_derivatives_it_lists(
    fmi: Literal["2.0", "3.0"], tmp_path: Path, open_fmu: Opener
) -> None:
    """States that are outputs too: importers ask for all."""
    one = open_fmu(export(short_line(drive=HYDRAULIC), tmp_path / "all.fmu", fmi), kind="ModelExchange")
    one.initialize()
    own = set(states(one))
    listed = [u for u in one.description.outputs if u.variable.type in ("Real", "Float64")]
    assert own <= {u.variable.name for u in listed}
    for output in listed:
        for known in output.dependencies:
            pair = [output.variable.valueReference], [known.valueReference]
            (found,) = one.fmu.getDirectionalDerivative(*pair, [1.0])
            assert output.variable.name not in own or found == float(output.variable.name == known.name)


def test_every_dependency_is_listed(moved: Opened) -> None:
    knowns = [*states(moved), *(v.name for v in moved.description.modelVariables if v.causality == "input")]
    exact = matrix(moved, knowns)
    structure = [*moved.description.outputs, *moved.description.derivatives]
    listed = {u.variable.name: {d.name for d in u.dependencies} for u in structure}
    for name, row in zip(unknowns(moved), exact, strict=True):
        needed = {k for k, v in zip(knowns, row, strict=True) if v != 0.0}
        assert needed <= listed[name], name
    assert listed["c1.tension_in"] < set(knowns) | {"x"}


def test_casadi_sees_the_same_system(tmp_path: Path) -> None:
    line = short_line(drive=HYDRAULIC, response=RESPONSE)
    path = export(line, tmp_path / "again.fmu", "2.0", outputs=["c1.tension_in"])
    folder = fmpy.extract(str(path), unzipdir=str(tmp_path / "again"))
    builder = ca.DaeBuilder("again", str(folder), {"debug": False})
    names = builder.x()
    rates = builder.create("rates", ["x", "u"], ["ode"])
    start = ca.DM([float(builder.start(n)[0]) for n in names])
    given = ca.DM([float(builder.start(n)[0]) for n in builder.u()])
    jacobian = rates.jacobian()(start, given, 0)[0].full()
    rest = rw.equilibrium(line)
    symbols = rest.model.dae.mx_in()
    by_unknowns = ca.jacobian(ca.vertcat(*rest.model.dae(*symbols)), ca.vertcat(symbols[1], symbols[2]))
    whole = ca.Function("whole", symbols, [by_unknowns])(*rest.point.arguments).full()
    n = len(rest.model.x)
    reduced = whole[:n, :n] - whole[:n, n:] @ np.linalg.solve(whole[n:, n:], whole[n:, :n])
    order = [rest.model.x.names.index(name) for name in names]
    assert np.sort_complex(np.linalg.eigvals(jacobian)) == pytest.approx(
        np.sort_complex(np.linalg.eigvals(reduced[np.ix_(order, order)])), rel=1e-9, abs=1e-9
    )


def test_casadi_integrates_until_the_first_crossing(tmp_path: Path) -> None:
    """DaeBuilder knows no events: the first load crosses at 11.8 s."""
    line, until = example_line(), 11.0
    path = export(line, tmp_path / "line.fmu", "3.0", outputs=["c1.tension_in", "c3.tension_out"], parameters=[])
    folder = fmpy.extract(str(path), unzipdir=str(tmp_path / "line"))
    builder = ca.DaeBuilder("line", str(folder), {})
    start, given = (ca.DM([float(builder.start(n)[0]) for n in names]) for names in (builder.x(), builder.u()))
    run = ca.integrator("run", "cvodes", builder.create("rates"), 0.0, until, {"abstol": 1e-9, "reltol": 1e-9})
    end = run(x0=start, u=given)["xf"]
    outputs = builder.create("outputs", ["t", "x", "u"], ["y"])(until, end, given).full().ravel()
    wanted = rw.simulate(line, until, every=until).frame.iloc[-1][list(builder.y())]
    assert list(outputs) == pytest.approx(wanted.to_list(), rel=1e-7)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_derivatives_by_time(fmi: str, tmp_path: Path, open_fmu: Opener) -> None:
    """The speed of a schedule rises by 0.1 m/s each second."""
    s = rw.System("winch")
    s.string(
        rw.Rope(mass_per_length=1.0, axial_stiffness=20e6, breaking_load=500e3),
        rw.Drum("d", at=(0.0, 0.0), speed=rw.Schedule((0.0, 10.0), (0.0, 1.0))),
        rw.Drum("e", at=(100.0, 5.0), tension=30e3),
        tension=30e3,
    )
    one = open_fmu(export(s, tmp_path / "winch.fmu", fmi), kind="ModelExchange")
    one.initialize()
    found = one.fmu.getDirectionalDerivative([one.references["der(d.travel)"]], [one.references["time"]], [2.0])
    assert list(found) == pytest.approx([0.2], rel=1e-12)
