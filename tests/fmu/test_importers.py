"""Importers that others wrote run the example line (packages of the extra `fmu-test`)."""

from pathlib import Path

import pytest
from fmus import example_line

import ropeway as rw

pytestmark = pytest.mark.importers
EVERY, UNTIL = 0.73, 73.0
NAMES = ("c1.tension_in", "c1.tension_out", "c3.tension_in")


def wanted() -> list[float]:
    result = rw.simulate(example_line(), UNTIL, every=EVERY)
    return [float(v) for v in result.frame.iloc[-1][list(NAMES)]]


def test_libcosim(line2: Path) -> None:
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=round(EVERY * 1e9))
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(line2), instance_name="line"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    execution.step(100)
    assert execution.status().current_time == round(UNTIL * 1e9)
    table = execution.slave_variables(slave)
    references = {v.name.decode(): v.reference for v in table if v.type == CosimVariableType.REAL.value}
    values = observer.last_real_values(slave, [references[n] for n in NAMES])
    assert list(values) == pytest.approx(wanted(), rel=1e-4)


@pytest.mark.parametrize("name", ["line2", "line3"])
def test_ecos(name: str, request: pytest.FixtureRequest) -> None:
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("line", str(request.getfixturevalue(name)))
        with EcosSimulation(structure=structure, step_size=EVERY) as simulation:
            simulation.init()
            simulation.step(100)
            assert simulation.get_time() == pytest.approx(UNTIL)
            values = [simulation.get_real(f"line::{n}") for n in NAMES]
    assert values == pytest.approx(wanted(), rel=1e-4)
