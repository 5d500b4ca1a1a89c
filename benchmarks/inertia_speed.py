"""Lines with inertia whose loads cross supports: times real time, beside the quasi-static run of the same line.

python benchmarks/inertia_speed.py --until 30 --spans 10
"""

from __future__ import annotations

import time
from itertools import pairwise
from typing import Annotated

import lines
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


def main(
    until: Annotated[float, typer.Option(help="Simulated time [s]; the line stops at half of it.")] = 30.0,
    spans: Annotated[list[int] | None, typer.Option(help="Numbers of spans.")] = None,
) -> None:
    """Runs each line with an emergency stop at half the time: quasi-static, and with inertia at three tolerances."""
    table = Table("spans", "run", "tolerance", "CPU s", "times real time", "records", "highest tension N")
    for n in spans or (10,):
        system = line(n)
        start = rw.equilibrium(system)
        stop = [rw.Intervention(until / 2.0, "emergency stop", deceleration=4.0)]
        runs = [
            ("quasi-static", None, 1e-6),
            *(("inertia", rw.Inertia(), tolerance) for tolerance in (1e-3, 1e-4, 1e-5)),
        ]
        for name, inertia, tolerance in runs:
            begin = time.process_time()
            result = rw.simulate(
                system, until, start=start, inertia=inertia, tolerance=tolerance, interventions=stop, progress=False
            )
            spent = time.process_time() - begin
            peak = result.full_frame.filter(regex="tension_[ab]$").to_numpy().max()
            cells = (
                n,
                name,
                f"{tolerance:g}",
                f"{spent:.2f}",
                f"{until / spent:.1f}",
                len(result.records),
                f"{peak:.0f}",
            )
            table.add_row(*map(str, cells))
    Console().print(table)


if __name__ == "__main__":
    typer.run(main)
