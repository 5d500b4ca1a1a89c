"""Time of doStep of an exported line, of the same line in pythonfmu and of `simulate`, in one run; size and time of the
export, with an empty cache and with the functions of components in it.

    python benchmarks/fmu_speed.py

pythonfmu comes with the extra fmu-test.
"""

import importlib.util
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pandas as pd
from control import DRIVE, RESPONSE
from lines import driven

import ropeway as rw

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
STEP, STEPS = 0.1, 600

SLAVE = """
import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

import ropeway as rw
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.dynamics.event_stepper import EventStepper
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import unpin

rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
line = rw.monocable(rope, {supports!r}, tension=45e3, speed=1.0, load_mass=300.0, load_spacing=50.0)


class PythonLine(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        model = assemble(line)
        rest = rw.equilibrium(model)
        state = LineState(rest.model, rest.point.copy(), rest.runs, rest.passed)
        unpin(state)
        self.stepper = EventStepper(state, model.signals, 1e-6)
        self.stepper.line.set_time(0.0)
        self.stepper.line.solve(0.1)
        self.place = model.y.index["c1.tension_in"]
        self.tension = 0.0
        self.register_variable(Real("tension", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.stepper.run_to(current_time + step_size)
        self.tension = float(self.stepper.state.outputs()[self.place])
        return True
"""


def seconds_a_step(path: Path, output: str) -> float:
    """Mean time of doStep and reading one output [s]."""
    with rw.fmu.Slave(rw.fmu.load(path)) as slave:
        slave.enter(0.0, {})
        slave.leave()
        begin = time.perf_counter()
        for _ in range(STEPS):
            slave.step(STEP, {}, {})
            slave.get([output])
        return (time.perf_counter() - begin) / STEPS


def exported(line: rw.System, path: Path) -> Path:
    """Export the line as an FMU, and print times of this process and of the compilers, and the size."""
    before, compilers = time.process_time(), resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    rw.fmu.export(line, path)
    own = time.process_time() - before
    compilers = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - compilers
    print(f"export of {line.name}: {own:.1f} s, compilers {compilers:.1f} s, {path.stat().st_size / 1e3:.0f} kB")
    return path


def against_simulate(line: rw.System, path: Path, until: int = 600) -> None:
    """Print processor times of the FMU's steps of a second, and of `simulate`."""
    with rw.fmu.Slave(rw.fmu.load(path)) as slave:
        slave.enter(0.0, {})
        slave.leave()
        before = time.process_time()
        for _ in range(until):
            slave.step(1.0, {}, {})
        own = time.process_time() - before
    model = rw.assemble(line)
    start = rw.equilibrium(model)
    rw.simulate(model, 1.0, start=start, progress=False)
    before = time.process_time()
    rw.simulate(model, float(until), start=start, progress=False)
    other = time.process_time() - before
    print(f"{line.name}: {until} s in {1e3 * own:.0f} ms; simulate takes {other / own:.1f} times as long")


def main() -> None:
    """Prints times and ratios."""
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    supports = EXAMPLES / "line.csv"
    line = rw.monocable(
        rope, supports, tension=45e3, speed=1.0, load_mass=300.0, load_spacing=50.0, name="24 spans, 45 loads"
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ["ROPEWAY_CACHE"] = str(folder / "cache")
        path = exported(line, folder / "line.fmu")
        shorter = pd.read_csv(supports).drop(index=2)
        another = rw.monocable(
            rope, shorter, tension=45e3, speed=1.0, load_mass=300.0, load_spacing=50.0, name="another line"
        )
        exported(another, folder / "another.fmu")
        exported(line, path)
        against_simulate(line, path)
        for long in (driven(100), driven(100, drive=DRIVE, response=RESPONSE)):
            against_simulate(long, exported(long, folder / "long.fmu"))
        ours = seconds_a_step(path, "c1.tension_in")
        print(f"doStep of {STEP} s: {ours * 1e6:.0f} us")
        if importlib.util.find_spec("pythonfmu") is None:
            print("pythonfmu is not installed (extra fmu-test): no comparison")
            return
        script = folder / "python_line.py"
        script.write_text(SLAVE.format(supports=str(supports)))
        subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", str(script), "-d", str(folder)], check=True)
        theirs = seconds_a_step(folder / "PythonLine.fmu", "tension")
        print(f"the same line in pythonfmu: {theirs * 1e6:.0f} us; ratio {theirs / ours:.0f}")


if __name__ == "__main__":
    main()
