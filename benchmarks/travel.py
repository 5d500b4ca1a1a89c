"""Speed of a travelling line: minutes of travel with loads over idlers and control sheaves, with a count of the loads.

    python benchmarks/travel.py --spans 10 --until 60

Each line runs in a separate process, which gives its peak memory.
"""

from __future__ import annotations

import multiprocessing
import resource
import time
from typing import Annotated, NamedTuple

import lines
import numpy as np
import typer
from rich.console import Console
from rich.table import Table

import ropeway as rw
from ropeway.systems.modelling.assembly import assemble


class Run(NamedTuple):
    """Times [s], numbers of crossings (including loads put on and taken off), loads, memory [MiB]."""

    prepared: float
    again: float
    spent: float
    crossings: int
    held: int
    before: int
    on: int
    off: int
    after: int
    twice: int
    base: float
    peak: float


def travel(spans: int, until: float, tolerance: float) -> Run:
    """One line over time. `prepared` is the time of assembly and equilibrium, `spent` that of the run with building its
    integrator, `again` that of a second run of the same model."""
    base = _memory()
    begin = time.perf_counter()
    model = assemble(lines.driven(spans))
    start = rw.equilibrium(model)
    prepared = time.perf_counter() - begin

    def once() -> tuple[float, rw.Result]:
        begin = time.perf_counter()
        result = rw.simulate(model, until, start=start, tolerance=tolerance, progress=False)
        return time.perf_counter() - begin, result

    spent, result = once()
    again, _ = once()
    peak = _memory()
    what = [event.event for event in result.noted]
    end = result.at(until).loads["load"]
    on, off = what.count("load put on"), what.count("load taken off")
    return Run(
        prepared, again, spent, sum(w != "load held" for w in what), what.count("load held"),
        len(start.loads), on, off, len(end), int(end.duplicated().sum()), base, peak,
    )  # fmt: skip


def _memory() -> float:
    """Peak memory of this process so far [MiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def main(
    spans: Annotated[list[int] | None, typer.Option(help="Numbers of spans.")] = None,
    until: Annotated[float, typer.Option(help="Time of travel [s], at 1 m/s.")] = 600.0,
    tolerance: Annotated[float, typer.Option(help="Tolerance of IDAS.")] = 1e-6,
) -> None:
    """Print the table."""
    table = Table(title=f"{until:g} s of travel at 1 m/s, two loads a span, IDAS tolerance {tolerance:g}")
    for name in ("spans", "prepare [s]", "run [s]", "again [s]", "x real time", "crossings", "crossings/s"):
        table.add_column(name, justify="right")
    for name in ("held", "loads: before + on - off = after", "memory [MiB]"):
        table.add_column(name, justify="right")
    fresh = multiprocessing.get_context("spawn")
    for n in spans or [10, 100, 300]:
        with fresh.Pool(1) as pool:
            r = pool.apply(travel, (n, until, tolerance))
        right = r.before + r.on - r.off == r.after and r.twice == 0
        quick = float(np.minimum(r.spent, r.again))
        table.add_row(
            *(str(n), f"{r.prepared:.2f}", f"{r.spent:.2f}", f"{r.again:.2f}", f"{until / quick:.0f}"),
            *(str(r.crossings), f"{r.crossings / quick:.0f}", str(r.held)),
            f"{r.before} + {r.on} - {r.off} = {r.after} {'right' if right else 'WRONG'}",
            f"{r.base:.0f} -> {r.peak:.0f}",
        )
    Console(width=150).print(table)


if __name__ == "__main__":
    typer.run(main)
