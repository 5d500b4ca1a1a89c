"""Growth of the reports of a run with the line: times for three times the spans, relative to the shorter line.

    python benchmarks/report.py --spans 100

The frame of a run contains each output at each record; both numbers grow with the spans. `summary` and `energy` read
each value of the frame once.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Annotated, Any

import lines
import typer
from rich.console import Console
from rich.table import Table

import ropeway as rw


def main(spans: Annotated[int, typer.Option(help="Spans of the shorter line.")] = 100) -> None:
    """Print times of each report for the shorter and the longer line, their ratios, and the ratio of the frames'
    sizes."""
    results = [rw.simulate(lines.driven(n), 5.0, progress=False) for n in (spans, 3 * spans)]
    reports: dict[str, Callable[[rw.Result], Any]] = {
        "frame": lambda result: result.full_frame,
        "events": lambda result: result.events,
        "summary": lambda result: result.summary(),
        "power": lambda result: result.power(),
        "energy": lambda result: result.energy(),
    }
    table = Table("report", f"{spans} spans [s]", f"{3 * spans} spans [s]", "ratio", title="Reports of a run of 5 s")
    for name, report in reports.items():
        spent = []
        for result in results:
            begin = time.process_time()
            report(result)
            spent.append(time.process_time() - begin)
        table.add_row(name, *(f"{t:.3f}" for t in spent), f"{spent[1] / spent[0]:.1f}")
    sizes = [result.full_frame.size for result in results]
    table.add_row("values in the frame", *(f"{size:,}" for size in sizes), f"{sizes[1] / sizes[0]:.1f}")
    Console().print(table)


if __name__ == "__main__":
    typer.run(main)
