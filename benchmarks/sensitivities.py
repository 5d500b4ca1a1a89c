"""Exact derivatives against central differences: time and agreement, in one run.

python benchmarks/sensitivities.py
"""

from __future__ import annotations

import time
from typing import Annotated

import lines
import numpy as np
import typer
from control import DRIVE
from rich.console import Console
from rich.table import Table

import ropeway as rw
from ropeway.systems.modelling.assembly import assemble


def main(spans: Annotated[list[int] | None, typer.Option(help="Numbers of spans.")] = None) -> None:
    """Derivatives at rest with respect to every load's mass, and over 60 s with crossings with respect to five
    quantities, with hydraulic drives."""
    table = Table("spans", "what", "derivatives", "first s", "exact s", "differences s", "ratio", "agreement")
    for n in spans or (20, 100):
        for row in (_at_rest(n), _in_time(n)):
            table.add_row(str(n), *row)
    Console().print(table)


def _row(what: str, count: int, times: tuple[float, float, float], agreement: float) -> tuple[str, ...]:
    first, exact, differences = times
    ratio = differences / exact
    return what, str(count), f"{first:.3f}", f"{exact:.3f}", f"{differences:.3f}", f"{ratio:.0f}", f"{agreement:.0e}"


def _at_rest(n: int) -> tuple[str, ...]:
    eq = rw.equilibrium(assemble(lines.given(n)))
    names = [f"{load}.mass" for load in eq.loads["load"]]
    of = [f"s{n // 2}.tension_in", f"s{n // 2}.support_force"]
    times = []
    for _ in range(2):
        begin = time.perf_counter()
        frame = rw.sensitivities(eq, of=of, to=names)
        times.append(time.perf_counter() - begin)
    begin = time.perf_counter()
    expected = np.empty(frame.shape)
    for j, name in enumerate(names):
        ends = [rw.equilibrium(eq.model, parameters={name: eq[name] + h}, start=eq) for h in (0.05, -0.05)]
        expected[:, j] = [(ends[0][o] - ends[1][o]) / 0.1 for o in of]
    times.append(time.perf_counter() - begin)
    error = float(np.abs(frame.to_numpy() - expected).max() / np.abs(expected).max())
    return _row("at rest", frame.size, (times[0], times[1], times[2]), error)


def _in_time(n: int) -> tuple[str, ...]:
    model = assemble(lines.driven(n, drive=DRIVE))
    start = rw.equilibrium(model)
    steps = {"l20.mass": 0.1, "l30.mass": 0.1, "s7.z": 1e-3, "s13.x": 1e-3, "gravity": 1e-3}
    of = ["c5.tension_out", "c10.power", "s12.tension_in"]
    result = rw.simulate(model, 60.0, every=5.0, start=start, tolerance=1e-10, progress=False)
    times = []
    for _ in range(2):
        begin = time.perf_counter()
        frame = rw.sensitivities(result, of=of, to=list(steps))
        times.append(time.perf_counter() - begin)
    begin = time.perf_counter()
    error = 0.0
    for name, h in steps.items():
        ends = []
        for step in (h, -h):
            moved = rw.equilibrium(model, parameters={name: start[name] + step}, start=start)
            ends.append(rw.simulate(model, 60.0, every=5.0, start=moved, tolerance=1e-10, progress=False).frame[of])
        expected = ((ends[0] - ends[1]) / (2.0 * h)).to_numpy()
        found = frame.xs(name, axis=1, level="to")[of].to_numpy()
        error = max(error, float(np.abs(found - expected).max() / max(np.abs(expected).max(), 1e-3)))
    times.append(time.perf_counter() - begin)
    return _row("60 s", len(of) * len(steps), (times[0], times[1], times[2]), error)


if __name__ == "__main__":
    typer.run(main)
