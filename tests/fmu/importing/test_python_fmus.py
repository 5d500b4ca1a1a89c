"""FMUs whose slaves are Python classes, built by pythonfmu (FMI 2.0) and pythonfmu3 (FMI 3.0)."""

import subprocess
import sys
from pathlib import Path

import pytest

from ropeway.fmu import CoSimulation, load

pytestmark = pytest.mark.importers

TWO = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

class Tank(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.inflow, self.level = 0.0, 1.0
        self.register_variable(Real("inflow", causality=Fmi2Causality.input, start=0.0))
        self.register_variable(Real("level", causality=Fmi2Causality.output))

    def do_step(self, t, h):
        self.level += h * (self.inflow - 0.1 * self.level)
        return True
"""
THREE = """
from pythonfmu3 import Float64, Fmi3Causality, Fmi3Slave, Fmi3Variability

class Tank3(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time, self.inflow, self.level = 0.0, 0.0, 1.0
        how = {"causality": Fmi3Causality.independent, "variability": Fmi3Variability.continuous}
        self.register_variable(Float64("time", **how))
        self.register_variable(Float64("inflow", causality=Fmi3Causality.input, start=0.0))
        self.register_variable(Float64("level", causality=Fmi3Causality.output))

    def do_step(self, t, h):
        self.level += h * (self.inflow - 0.1 * self.level)
        return True
"""


@pytest.mark.parametrize("isolated", [False, True])
@pytest.mark.parametrize(("tool", "source", "fmi"), [("pythonfmu", TWO, "2.0"), ("pythonfmu3", THREE, "3.0")])
def test_a_slave_in_python(tmp_path: Path, tool: str, source: str, fmi: str, isolated: bool) -> None:
    script = tmp_path / f"{tool}_tank.py"  # in one process Python loads a module of one name once
    script.write_text(source)
    subprocess.run([sys.executable, "-m", tool, "build", "-f", script.name], cwd=tmp_path, check=True)
    (path,) = tmp_path.glob("*.fmu")
    fmu = load(path, isolated=isolated)
    assert fmu.fmi == fmi
    master = CoSimulation(0.1)
    master.add("tank", fmu, start={"inflow": 0.5})
    level = master.run(1.0)["tank.level"]
    wanted = [1.0]
    for _ in range(10):
        wanted.append(wanted[-1] + 0.1 * (0.5 - 0.1 * wanted[-1]))
    assert level.to_list() == pytest.approx(wanted, rel=1e-12)
