"""Time of a step of an isolated slave and of one in the session's process, with ten values each way, in one run.

python benchmarks/fmu_isolation.py
"""

import statistics
import sys
import tempfile
import time
from pathlib import Path

import ropeway as rw
from ropeway.fmu.importing.participant import OpenFmu

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from support.hostiles import hostile_fmu, library

INPUTS = [f"u{k}" for k in range(1, 11)]
OUTPUTS = [f"y{k}" for k in range(1, 11)]


def microseconds(path: Path, isolated: bool, steps: int = 5000) -> float:
    """Median time of a step with ten inputs and ten outputs."""
    times = []
    with OpenFmu(rw.fmu.load(path, isolated=isolated)) as slave:  # as a master uses it
        slave.enter(0.0, {})
        slave.leave()
        values = dict.fromkeys(INPUTS, 1.5)
        for _ in range(steps):
            begin = time.perf_counter()
            slave.step(0.1, values, values)
            slave.get(OUTPUTS)
            times.append(time.perf_counter() - begin)
    return 1e6 * statistics.median(times)


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = hostile_fmu(folder / "plain.fmu", library(folder / "plain.so"))
        for isolated in (False, True, False, True):
            print(f"isolated {isolated!s:5}: {microseconds(path, isolated):.1f} us a step")


if __name__ == "__main__":
    main()
