"""Memory of co-simulations, in one run.

    python benchmarks/fmu_memory.py

20,000 steps of 600 outputs, all recorded, against the frame's own memory; then 24 h at steps of 0.1 s with two chosen
outputs, one row a minute: the largest memory after one hour and after the whole day.
"""

import gc
import resource
import sys
import tempfile
import time
from pathlib import Path

import ropeway as rw

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from support.hostiles import hostile_fmu, library

SLAVES, STEPS = 60, 20_000  # ten real outputs each, and the time


def megabytes() -> float:
    """Largest memory of the process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def all_outputs(path: Path) -> None:
    master = rw.fmu.CoSimulation(0.1)
    for k in range(SLAVES):
        master.add(f"s{k}", path)
    outputs = [f"s{k}.y{i}" for k in range(SLAVES) for i in range(1, 11)]
    master.run(0.1 * 100, outputs=outputs, progress=False)
    gc.collect()
    before = megabytes()
    begin = time.process_time()
    frame = master.run(0.1 * STEPS, outputs=outputs, progress=False)
    taken, own = time.process_time() - begin, frame.memory_usage().sum() / 1024.0**2
    more = megabytes() - before
    print(f"{len(frame)} rows of {frame.shape[1]} outputs in {taken:.0f} s: {own:.1f} MB, used {more / own:.2f} times")


def day(path: Path) -> None:
    master = rw.fmu.CoSimulation(0.1)
    master.add("a", path)
    master.add("b", path, start={"u1": 1.0})
    master.connect("b.y1", "a.u1")
    for hours in (1.0, 24.0):
        begin = time.process_time()
        frame = master.run(3600.0 * hours, outputs=["a.y1", "a.t"], every=60.0, progress=False)
        taken = time.process_time() - begin
        print(f"{hours:4.0f} h: {len(frame)} rows in {taken:.1f} s, largest memory {megabytes():.1f} MB")


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = hostile_fmu(folder / "plain.fmu", library(folder / "plain.so"))
        day(path)
        all_outputs(path)


if __name__ == "__main__":
    main()
