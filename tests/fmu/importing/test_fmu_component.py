"""Model Exchange FMUs as components: exported here and back, and FMUs of others."""

from pathlib import Path

import casadi as ca
import fmpy
import numpy as np
import pytest

import ropeway as rw
from ropeway.fmu import (
    CoSimulation,
    FmuComponent,
    FmuExportError,
    FmuImportError,
    FmuRunError,
    FmuVariableError,
    component,
    export,
)
from support.fmus import WEAK_UNIT, fed_line, open_line

COMMAND = {"c1.speed": 1.5}
INPUTS = {"c1.speed": rw.Schedule((0.0, 1.0, 2.0, 20.0), (1.0, 1.0, 1.5, 1.5))}


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def unit(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> FmuComponent:
    s = rw.System("unit")
    s.add(WEAK_UNIT)
    path = export(s, tmp_path_factory.mktemp("unit") / "unit.fmu", request.param)
    return component("power", path, ignore_events=True)


def test_a_line_with_an_fmu_runs_as_the_native_one(unit: FmuComponent) -> None:
    # Both are integrated in steps of their own: only far below the tolerance do they agree to it.
    native = rw.simulate(fed_line(WEAK_UNIT), 20.0, every=0.5, inputs=INPUTS, tolerance=3e-12)
    coupled = rw.simulate(fed_line(unit, "unit."), 20.0, every=0.5, inputs=INPUTS, tolerance=3e-12)
    frame = coupled.frame.rename(columns=lambda n: n.removeprefix("power."))
    assert set(frame.columns) == set(native.frame.columns)
    assert np.ptp(frame["unit.speed"]) > 3.0
    scale = native.frame.abs().max().clip(lower=1.0)
    assert ((frame - native.frame).abs().max() / scale).max() < 1e-9
    assert coupled.events["event"].tolist() == native.events["event"].tolist()
    assert coupled.events["time"].to_numpy() == pytest.approx(native.events["time"].to_numpy(), abs=1e-9)


@pytest.fixture(scope="module")
def line(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return export(open_line(), tmp_path_factory.mktemp("line") / "line.fmu", tolerance=1e-8)


def test_co_simulation_converges_to_the_same(unit: FmuComponent, line: Path) -> None:
    exact = rw.simulate(fed_line(WEAK_UNIT), 3.0, every=0.1, inputs=COMMAND, tolerance=1e-8).frame

    def error(step: float) -> float:
        together = CoSimulation(step, iterated=True)
        together.add("power", unit.fmu)
        together.add("line", line, start={"c1.speed": 1.5})
        together.connect("power.unit.flow", "line.c1.pump_flow")
        together.connect("power.unit.pressure", "line.c1.relief_pressure")
        together.connect("line.c1.hydraulic_power", "power.unit.load_power")
        frame = together.run(3.0).iloc[:: round(0.1 / step)]
        return float(np.abs(frame["power.unit.speed"].to_numpy() - exact["unit.speed"].to_numpy()).max())

    coarse, fine = error(0.05), error(0.025)
    assert coarse / fine > 3.0  # at least of second order
    assert fine < 0.01


def test_jacobians_are_exact(unit: FmuComponent) -> None:
    """Also where a direction leaves the FMU alone: CasADi's own directional derivatives are wrong there."""
    found = []
    for one, prefix in ((WEAK_UNIT, ""), (unit, "unit.")):
        rest = rw.equilibrium(fed_line(one, prefix))
        symbols = rest.model.dae.mx_in()
        whole = ca.vertcat(*rest.model.dae(*symbols))
        matrix = ca.horzcat(*(ca.jacobian(whole, symbols[i]) for i in (1, 2, 3)))
        found.append(np.array(ca.Function("jacobian", symbols, [ca.densify(matrix)])(*rest.point.arguments)))
    assert found[0].shape == found[1].shape
    assert found[1] == pytest.approx(found[0], rel=1e-9, abs=1e-9)


def test_variables_are_in_the_model(unit: FmuComponent) -> None:
    model = rw.assemble(fed_line(unit, "unit."))
    assert "power.unit.speed" in model.x.index
    assert "power.unit.flow" in model.y.index
    assert "power.unit.load_power" in model.z.index
    assert model.z.units[model.z.index["power.unit.load_power"]] == "W"
    rest = rw.equilibrium(model)
    assert rest["c1.pump_flow"] == pytest.approx(rest["power.unit.flow"], rel=1e-12)


def test_an_unconnected_input_keeps_its_start(unit: FmuComponent) -> None:
    s = rw.System("alone")
    s.add(unit)
    still, loaded = rw.simulate(s, 5.0), rw.simulate(s, 5.0, inputs={"power.unit.load_power": 5e3})
    assert loaded.frame["power.unit.speed"].iloc[-1] < still.frame["power.unit.speed"].iloc[-1] - 1.0


def test_values_of_parameters(unit: FmuComponent) -> None:
    path = unit.fmu.path
    heavy = component("power", path, parameters={"unit.inertia": 10.0}, ignore_events=True)

    def drop(one: FmuComponent) -> float:
        s = rw.System("alone")
        s.add(one)
        frame = rw.simulate(s, 0.1, every=0.1, inputs={"power.unit.load_power": 5e3}).frame
        return float(-np.diff(frame["power.unit.speed"])[0])

    assert drop(unit) > 5.0 * drop(heavy)


def test_time_reaches_the_fmu(tmp_path: Path) -> None:
    """A winch whose speed rises by 0.1 m/s each second."""
    s = rw.System("winch")
    s.string(
        rw.Rope(mass_per_length=1.0, axial_stiffness=20e6, breaking_load=500e3),
        rw.Drum("d", at=(0.0, 0.0), speed=rw.Schedule((0.0, 10.0), (0.0, 1.0))),
        rw.Drum("e", at=(100.0, 5.0), tension=30e3),
        tension=30e3,
    )
    path = export(s, tmp_path / "winch.fmu")
    for ignored in (True, False):
        whole = rw.System("whole")
        whole.add(component("winch", path, ignore_events=ignored))
        travel = rw.simulate(whole, 8.0, tolerance=3e-12).frame["winch.d.travel"]
        assert travel.to_numpy() == pytest.approx(0.05 * travel.index.to_numpy() ** 2, abs=1e-6)


def test_a_system_with_links_as_an_fmu(tmp_path: Path) -> None:
    path = rw.fmu.export(fed_line(WEAK_UNIT), tmp_path / "line.fmu", tolerance=1e-8)
    names = ["unit.speed", "c1.tension_in", "c1.rope_speed"]
    found = fmpy.simulate_fmu(
        str(path), fmi_type="CoSimulation", stop_time=5.0, step_size=0.5, output_interval=0.5, output=names
    )
    frame = rw.simulate(fed_line(WEAK_UNIT), 5.0, every=0.5, tolerance=1e-8).frame
    for name in names:
        assert found[name] == pytest.approx(frame[name].to_numpy(), rel=1e-6)


def test_rejected_input(unit: FmuComponent, tmp_path: Path) -> None:
    path = unit.fmu.path
    with pytest.raises(FmuVariableError, match="not a Real parameter"):
        component("power", path, parameters={"unit.speed": 1.0}, ignore_events=True)
    with pytest.raises(FmuVariableError, match="no variable 'inertia'"):
        component("power", path, parameters={"inertia": 1.0}, ignore_events=True)
    with pytest.raises(FmuRunError, match=r"Its log: .* must be above 0"):
        component("power", path, parameters={"unit.inertia": -1.0}, ignore_events=True)
    with pytest.raises(rw.InputError, match=r"unit\.inertia'\] is 'heavy'"):
        component("power", path, parameters={"unit.inertia": "heavy"}, ignore_events=True)  # type: ignore[dict-item]
    with pytest.raises(rw.InputError, match="not an identifier"):
        component("a power unit", path, ignore_events=True)
    with pytest.raises(FmuExportError, match="is an FMU itself"):
        export(fed_line(unit, "unit."), tmp_path / "line.fmu")
    with pytest.raises(rw.UnknownNameError, match="has no input 'load_power'"):
        unit.input("load_power")


@pytest.mark.importers
def test_a_foreign_pair_in_one_run_is_its_monolith(foreign: Path) -> None:
    s = rw.System("pair")
    one, two = (s.add(component(n, foreign / f"MassSpringSubSystem{i}.fmu")) for i, n in ((1, "one"), (2, "two")))
    s.add(component("both", foreign / "MassSpringSystem.fmu"))
    s.connect(one.output("x1"), two.input("x1"))
    s.connect(two.output("x2"), one.input("x2"))
    frame = rw.simulate(s, 10.0, every=0.1, tolerance=3e-12).frame
    assert frame["one.x1"].to_numpy() == pytest.approx(frame["both.x1"].to_numpy(), abs=1e-9)
    # Unit masses and springs: the modes have the circular frequencies 1 and sqrt(3).
    t, w = frame.index.to_numpy(), np.sqrt(3.0)
    exact = (np.cos(t) + np.sin(t)) / 2.0 - (np.cos(w * t) - np.sin(w * t) / w) / 2.0
    assert frame["one.x1"].to_numpy() == pytest.approx(exact, abs=1e-6)


@pytest.mark.importers
def test_a_loop_of_foreign_outputs_and_inputs(foreign: Path) -> None:
    """a = 3 u + b, b = a / 2 + v."""
    s = rw.System("loop")
    a = s.add(component("a", foreign / "add.fmu", parameters={"add.k1": 3.0}))
    b = s.add(component("b", foreign / "add.fmu", parameters={"add.k1": 0.5}))
    s.connect(a.output("y"), b.input("u1"))
    s.connect(b.output("y"), a.input("u2"))
    rest = rw.equilibrium(s, parameters={"a.u1": 2.0, "b.u2": 1.0})
    assert (rest["a.y"], rest["b.y"]) == pytest.approx((14.0, 8.0), rel=1e-9)


@pytest.mark.importers
def test_foreign_events_and_kinds(foreign: Path) -> None:
    with pytest.raises(FmuImportError, match="does not support ModelExchange"):
        component("other", foreign / "FMU3Model.fmu")
    damper = component("damper", foreign / "Mass_Damper.fmu")
    s = rw.System("damper")
    s.add(damper)
    # The spring of 10 kN/m gives way by 0.1 m for each 1 kN.
    rest = [rw.simulate(s, 30.0, inputs={"damper.f": f}).frame["damper.y"].iloc[-1] for f in (0.0, 1e3)]
    assert abs(rest[1] - rest[0]) == pytest.approx(0.1, rel=1e-3)
