"""Lines with inertia whose loads cross supports: times real time, beside the quasi-static run of the same line, with
IDAS and in compiled code; the errors of tensions are against a compiled run of a tolerance of 1e-8.

python benchmarks/inertia.py --until 30 --spans 10 --spans 100
"""

from __future__ import annotations

import time
from itertools import pairwise
from typing import Annotated, Any

import lines
import numpy as np
import typer
from rich.console import Console
from rich.table import Table

import ropeway as rw


def line(spans: int) -> rw.System:
    """A drum with a speed, idlers with inertia, and a drum that keeps its tension; the rope is full of loads."""
    at, s = lines.points(spans), rw.System(f"{spans} spans")
    idlers = [rw.Sheave(f"s{k}", at=at[k], inertia=100.0) for k in range(1, spans)]
    first, last = (
        rw.Drum("first", at=at[0], speed=2.0),
        rw.Drum("last", at=at[-1], tension=lines.TENSION, inertia=100.0),
    )
    chords = sum(sum((b - a) ** 2 for a, b in zip(p, q, strict=True)) ** 0.5 for p, q in pairwise(at))
    s.feed(s.string(lines.ROPE, first, *idlers, last, length=chords), spacing=lines.SPACING, masses=lines.MASSES)
    return s


def runs(until: float, stop: bool) -> dict[str, dict[str, Any]]:
    """What each run of a line is given."""
    stopped = [rw.Intervention(until / 2.0, "emergency stop", deceleration=4.0)] if stop else []
    common = {"interventions": stopped, "progress": False}
    found = {"quasi-static": {**common}}
    for tolerance in (1e-3, 1e-4, 1e-5):
        found[f"IDAS, {tolerance:g}"] = {**common, "inertia": rw.Inertia(), "tolerance": tolerance}
        found[f"compiled, {tolerance:g}"] = {**found[f"IDAS, {tolerance:g}"], "compiled": True}
    return found


def tensions(result: Any) -> np.ndarray:
    """Tensions at all ends of spans on the grid [N]."""
    return np.asarray(result.frame.filter(regex="tension_[ab]$").to_numpy())


def main(
    until: Annotated[float, typer.Option(help="Simulated time [s].")] = 30.0,
    spans: Annotated[list[int] | None, typer.Option(help="Numbers of spans.")] = None,
    tries: Annotated[int, typer.Option(help="Runs of each kind, of which the fastest counts.")] = 3,
) -> None:
    """Runs each line at its speed, and with an emergency stop at half the time."""
    table = Table("spans", "stop", "run", "CPU s", "times real time", "records", "highest tension N", "error N, rms")
    for n, stop in [(n, stop) for n in spans or (10,) for stop in (False, True)]:
        system = line(n)
        start = rw.equilibrium(system)
        exact = {**runs(until, stop)["compiled, 1e-05"], "tolerance": 1e-8}
        best = tensions(rw.simulate(system, until, start=start, **exact))  # also compiles the kernels
        for name, given in runs(until, stop).items():
            spent = np.inf
            for _ in range(tries if "compiled" in name else 1):
                begin = time.process_time()
                result = rw.simulate(system, until, start=start, **given)
                spent = min(spent, time.process_time() - begin)
            found = tensions(result)
            error, speed = np.sqrt(np.mean((found - best) ** 2)), until / spent
            cells = (n, "stop" if stop else "", name, f"{spent:.2f}", f"{speed:.1f}", len(result.records))
            table.add_row(*map(str, cells), f"{found.max():.0f}", f"{error:.1f}")
    Console(width=120).print(table)


if __name__ == "__main__":
    typer.run(main)
