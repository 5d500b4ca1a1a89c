"""Time of a step of an isolated slave and of one in the session's process, with ten values each way, in one run.

    python benchmarks/fmu_isolation.py

Then, with `hours`, the memory of a run of 24 h at steps of 0.1 s with chosen outputs, one row a minute.
"""

import argparse
import resource
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


def megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def day(path: Path, hours: float) -> None:
    """Largest memory after parts of a long run."""
    master = rw.fmu.CoSimulation(0.1)
    master.add("a", path)
    master.add("b", path, start={"u1": 1.0})
    master.connect("b.y1", "a.u1")
    for part in (0.01 * hours, hours):
        begin = time.perf_counter()
        frame = master.run(3600.0 * part, outputs=["a.y1", "a.t"], every=60.0)
        taken = time.perf_counter() - begin
        print(f"{part:6.2f} h: {len(frame)} rows in {taken:.1f} s, largest memory {megabytes():.1f} MB")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("hours", nargs="?", type=float)
    given = options.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = hostile_fmu(folder / "plain.fmu", library(folder / "plain.so"))
        for isolated in (False, True, False, True):
            print(f"isolated {isolated!s:5}: {microseconds(path, isolated):.1f} us a step")
        if given.hours is not None:
            day(path, given.hours)


if __name__ == "__main__":
    main()
