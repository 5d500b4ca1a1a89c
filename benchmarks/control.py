"""Control sheaves: lines with hydraulic drives and threshold responses, and a profile of the run.

python benchmarks/control.py --until 600
"""

from __future__ import annotations

import cProfile
import pstats
import time
from typing import Annotated

import lines
import typer
from rich.console import Console
from rich.table import Table

import ropeway as rw
from ropeway.systems.modelling.assembly import assemble

DRIVE = rw.HydraulicDrive(
    displacement=127e-6,
    gear_ratio=20.0,
    sheave_radius=0.5,
    relief_pressure=250e5,
    pump_flow=7e-3,
    engine_power=60e3,
    inertia=800.0,
)
RESPONSE = rw.ThresholdResponse(low=42e3, high=69e3, increment=0.004, period=2.0, hold=0.0)
PARTS = {
    "all sections": ("line_stepper.py", "solve"),
    "one section": ("line_stepper.py", "_solve_parts"),
    "drives (IDAS)": ("decoupled.py", "window"),
    "whole line (IDAS)": ("idas.py", "advance"),
    "next crossing": ("crossing.py", "next_crossing"),
    "crossing": ("crossing.py", "apply"),
    "samples": ("simulation.py", "act"),
    "writing down": ("simulation.py", "record"),
}


def main(
    until: Annotated[float, typer.Option(help="Simulated time [s].")] = 600.0,
    spans: Annotated[list[int] | None, typer.Option(help="Numbers of spans.")] = None,
) -> None:
    """Simulate each line twice: for its time, and under the profiler for the shares of its parts."""
    table = Table(
        "spans", "loads", "drives", "build s", "run s", "times real time", "us per span and s", "actions", "lost"
    )
    shares = Table("part of the profiled run", *(str(n) for n in spans or (100, 200, 500)))
    columns: list[dict[str, float]] = []
    for n in spans or (100, 200, 500):
        model = assemble(lines.driven(n, drive=DRIVE, response=RESPONSE))
        begin = time.perf_counter()
        start = rw.equilibrium(model)
        rw.simulate(model, 1.0, start=start)
        built = time.perf_counter() - begin
        begin = time.perf_counter()
        result = rw.simulate(model, until, start=start, progress=False)
        spent = time.perf_counter() - begin
        events = [e.event for e in result.noted]
        on, off = events.count("load put on"), events.count("load taken off")
        before, after = (int(r.passed[0][0] - r.passed[0][-1]) for r in (result.records[0], result.records[-1]))
        drives = sum(isinstance(node, rw.ControlSheave) for node in model.runs[0].nodes)
        table.add_row(
            str(n),
            str(before),
            str(drives),
            f"{built:.2f}",
            f"{spent:.2f}",
            f"{until / spent:.0f}",
            f"{spent / until / n * 1e6:.0f}",
            str(events.count("response")),
            str(before + on - off - after),
        )
        columns.append(_profiled(model, until / 10.0, start))
    for part in (*PARTS, "the rest"):
        shares.add_row(part, *(f"{c[part]:.0%}" for c in columns))
    console = Console()
    console.print(table)
    console.print(shares)


def _profiled(model: rw.Model, until: float, start: rw.Equilibrium) -> dict[str, float]:
    """Shares of the time in each part."""
    profile = cProfile.Profile()
    profile.enable()
    rw.simulate(model, until, start=start, progress=False)
    profile.disable()
    stats = pstats.Stats(profile)
    spent = {
        part: sum(row[3] for (path, _, name), row in stats.stats.items() if path.endswith(file) and name == function)
        for part, (file, function) in PARTS.items()
    }
    spent = {part: seconds / stats.total_tt for part, seconds in spent.items()}
    return {**spent, "the rest": max(0.0, 1.0 - sum(spent.values()))}


if __name__ == "__main__":
    typer.run(main)
