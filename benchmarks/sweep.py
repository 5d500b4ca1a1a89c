"""Equilibria of many variants of a line: local processes, a Dask cluster, and a sweep killed half-way and resumed.

    python benchmarks/sweep.py
    python benchmarks/sweep.py --cases 1000 --workers 4

The driven line of 20 spans; each variant has different masses (100 to 500 kg) of all loads and different heights (1 m
up or down) of all supports. Times are from the call to the table, including the start of processes and assembly. Every
table must equal that of the local processes to the last bit.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import lines
import pandas as pd
import typer

import ropeway as rw


def variants(line: rw.System, count: int) -> pd.DataFrame:
    """Variants of masses and heights of a line."""
    model = rw.assemble(line)
    bounds = {f"{load}.mass": (100.0, 500.0) for load in rw.equilibrium(model).loads["load"]}
    for name, value in zip(model.p.names, model.p.values, strict=True):
        if name.endswith(".z"):
            bounds[name] = (value - 1.0, value + 1.0)
    return rw.latin_hypercube(bounds, count)


def timed(label: str, run: Callable[[], pd.DataFrame], known: pd.DataFrame | None = None) -> pd.DataFrame:
    """Runs, prints the time, and compares the table with `known`. Raises AssertionError for a difference."""
    before = time.perf_counter()
    table = run()
    spent = time.perf_counter() - before
    if known is not None:
        pd.testing.assert_frame_equal(table, known, check_exact=True)
    print(f"{label:<36}{spent:8.1f} s {1e3 * spent / len(table):8.2f} ms a case")
    return table


def killed(path: Path, count: int, workers: int) -> int:
    """Runs the sweep in a separate process and kills it half-way. Returns the number of rows in its journal."""
    options = ["--cases", str(count), "--workers", str(workers), "--path", str(path)]
    process = subprocess.Popen([sys.executable, __file__, *options])
    journal = path.with_name(f"{path.name}.journal")
    while process.poll() is None and rows_in(journal) < count // 2:
        time.sleep(0.2)
    process.kill()
    process.wait()
    return rows_in(journal)


def rows_in(journal: Path) -> int:
    """Number of rows in a journal: after its first line, each complete line is a list of rows."""
    chunks = journal.read_bytes().split(b"\n")[1:-1] if journal.exists() else []
    return sum(len(json.loads(line)) for line in chunks)


def main(
    cases: Annotated[int, typer.Option(help="Number of variants.")] = 10_000,
    workers: Annotated[int, typer.Option(help="Number of processes.")] = 2,
    path: Annotated[Path | None, typer.Option(help="Only write the table there.")] = None,
) -> None:
    """Print the times."""
    line = lines.driven(20)
    table = variants(line, cases)
    if path is not None:
        rw.sweep(line, table, workers=workers, path=path)
        return
    print(f"{len(table)} cases of {len(table.columns)} parameters")
    tensions = [name for name in rw.assemble(line).y.names if name.endswith((".tension_a", ".tension_b"))]
    few = timed(
        f"{workers} processes, {len(tensions)} outputs",
        lambda: rw.sweep(line, table, outputs=tensions, workers=workers),
    )
    known = timed(f"{workers} processes, all outputs", lambda: rw.sweep(line, table, workers=workers))
    pd.testing.assert_frame_equal(known[few.columns], few, check_exact=True)
    print(f"{known['error'].ne('').sum()} cases failed, {known.shape[1]} columns")
    timed("this process alone, all outputs", lambda: rw.sweep(line, table, workers=1), known)
    _on_dask(line, table, workers, known)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "sweep.parquet"
        label = f"resumed after {killed(file, cases, workers)} rows"
        timed(label, lambda: rw.sweep(line, table, workers=workers, path=file), known)


def _on_dask(line: rw.System, table: pd.DataFrame, workers: int, known: pd.DataFrame) -> None:
    from dask.distributed import Client, LocalCluster

    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as c:
        timed(f"Dask, {workers} workers, all outputs", lambda: rw.sweep(line, table, workers=c), known)


if __name__ == "__main__":
    typer.run(main)
