"""Importers that others wrote run the example line (packages of the extra `fmu-test`): ten minutes with hundreds of
crossings, all tensions at control sheaves compared after each step."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import ropeway as rw
from support.fmus import HYDRAULIC, RESPONSE, Opener, example_line, short_line

pytestmark = pytest.mark.importers
EVERY, STEPS = 0.73, 822  # no load crosses at one of its multiples
Compare = Callable[[list[list[float]]], float]


@pytest.fixture(scope="module")
def result() -> rw.Result:
    found = rw.simulate(example_line(), EVERY * STEPS, every=EVERY)
    assert len(found.events) > 200
    return found


@pytest.fixture(scope="module")
def names(result: rw.Result) -> list[str]:
    return [c for c in result.frame if c.endswith((".tension_in", ".tension_out"))]


@pytest.fixture(scope="module")
def deviation(result: rw.Result, names: list[str]) -> Compare:
    wanted = result.frame[names].to_numpy()[1 : STEPS + 1]

    def of(rows: list[list[float]]) -> float:
        return float((np.abs(np.array(rows) - wanted) / np.abs(wanted)).max())

    return of


def test_libcosim(line2: Path, names: list[str], deviation: Compare) -> None:
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=round(EVERY * 1e9))
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(line2), instance_name="line"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    table = execution.slave_variables(slave)
    references = {v.name.decode(): v.reference for v in table if v.type == CosimVariableType.REAL.value}
    rows = []
    for _ in range(STEPS):
        execution.step(1)
        rows.append(list(observer.last_real_values(slave, [references[n] for n in names])))
    assert execution.status().current_time == round(EVERY * STEPS * 1e9)
    assert deviation(rows) < 1e-4


@pytest.mark.parametrize("name", ["line2", "line3"])
def test_ecos(name: str, request: pytest.FixtureRequest, names: list[str], deviation: Compare) -> None:
    from ecospy import EcosSimulation, EcosSimulationStructure

    rows = []
    with EcosSimulationStructure() as structure:
        structure.add_model("line", str(request.getfixturevalue(name)))
        with EcosSimulation(structure=structure, step_size=EVERY) as simulation:
            simulation.init()
            for _ in range(STEPS):
                simulation.step()
                rows.append([simulation.get_real(f"line::{n}") for n in names])
            assert simulation.get_time() == pytest.approx(EVERY * STEPS)
    assert deviation(rows) < 1e-4


def test_ecos_runs_a_system_structure(tmp_path: Path) -> None:
    """Two lines, a scaled connection and a start value: as here, to the last digits."""
    from ecospy import EcosSimulation

    master = rw.fmu.CoSimulation(0.1)
    master.add("a", short_line(), start={"c1.speed": 1.1})
    master.add("b", short_line())
    master.connect("a.c1.travel", "b.c1.speed", factor=0.1, convert_units=False)
    path = master.to_ssp(tmp_path / "lines.ssp", until=3.0)
    names, rows = ["a.c1.travel", "b.c1.travel", "b.c1.tension_in"], []
    with EcosSimulation(step_size=0.1, ssp_path=str(path)) as simulation:
        simulation.init(parameter_set="initialValues")
        for _ in range(30):
            simulation.step()
            rows.append([simulation.get_real(name.replace(".", "::", 1)) for name in names])
    assert np.array(rows) == pytest.approx(master.run(3.0)[names].to_numpy()[1:], rel=1e-12)


@pytest.mark.parametrize("name", ["line2", "line3", "driven"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-8])
def test_a_second_strict_importer(
    name: str, tolerance: float, open_fmu: Opener, request: pytest.FixtureRequest
) -> None:
    from support.cvode_importer import Importer

    one, until = open_fmu(request.getfixturevalue(name), kind="ModelExchange"), 60.0
    one.initialize()
    importer = Importer(one, tolerance)
    importer.run(until)
    assert importer.failures == []
    assert one.log == []
    assert importer.events > 20
    assert importer.calls < 40_000
    line = short_line(drive=HYDRAULIC, response=RESPONSE) if name == "driven" else example_line()
    last = rw.simulate(line, until, every=until).frame.iloc[-1]
    tension = [n for n in last.index if n.endswith((".tension_in", ".travel"))]
    assert one.get(*tension) == pytest.approx(last[tension].to_numpy(), rel=30.0 * tolerance)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.parametrize("name", ["one_span", "example_line", "skyline", "corridor"])
def test_the_checker_of_fmu_manipulation_toolbox(
    name: str, fmi: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    from fmu_manipulation_toolbox.checker import get_checkers
    from fmu_manipulation_toolbox.operations import FMU

    from support import fmus

    path = rw.fmu.export(getattr(fmus, name)(), tmp_path / "checked.fmu", fmi, platforms=())
    with caplog.at_level("INFO"), FMU(str(path)) as archive:
        for checker in get_checkers():
            archive.apply_operation(checker())
    assert [r.message for r in caplog.records if r.levelname in ("WARNING", "ERROR")] == []
    assert any("compliant" in r.message for r in caplog.records)
