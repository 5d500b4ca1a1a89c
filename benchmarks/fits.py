"""Fits against the work of predicting, and a monitor against real time, in one run; processor times.

python benchmarks/fits.py
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import lines
import numpy as np
import pandas as pd
from rich.console import Console
from rich.table import Table

import ropeway as rw

STATIONS = np.linspace(10.0, 290.0, 100)
FREE = ["payload", "tension", "skyline.axial_stiffness", "z.offset", "skyline.gain"]


def timed(call: Callable[[], Any]) -> tuple[float, Any]:
    begin = time.process_time()
    found = call()
    return time.process_time() - begin, found


def rig(tension: float) -> rw.SkylineRig:
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        supports=[rw.IntermediateSupport("jack", at=(140.0, 2.0))],
        tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
        skyline=rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450e3),
        tension=tension,
        mainline=rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3),
        carriage=rw.Carriage("carriage", mass=450.0, payload=2000.0),
    )


def fit_of_a_skyline() -> tuple[str, str, str, str]:
    rng = np.random.default_rng(1)
    path_time, path = timed(lambda: rw.load_path(rig(73e3), 2300.0, STATIONS))
    log = pd.DataFrame(
        {
            "station": STATIONS,
            "skyline": 1.02 * path["headspar_tension"] + rng.normal(0.0, 500.0, 100),
            "z": path["carriage_z"] + 0.1 + rng.normal(0.0, 0.03, 100),
            "main": path["mainline_tension"] + rng.normal(0.0, 200.0, 100),
        }
    )
    columns = {"station": "station", "skyline": "headspar_tension", "z": "carriage_z", "main": "mainline_tension"}
    sigma = {"skyline": 500.0, "z": 0.03, "main": 200.0}
    seconds, _ = timed(lambda: rw.fit(rig(70e3), log, columns=columns, free=FREE, sigma=sigma))
    return "5 quantities, 100 stations", f"{seconds:.2f}", "load paths of 100 stations", f"{seconds / path_time:.1f}"


def monitor_of_a_line(spans: int, until: float = 300.0) -> tuple[str, str, str, str]:
    line = lines.driven(spans)
    run = rw.simulate(line, until, every=1.0)
    names = [name for name in run.frame.columns if name.endswith((".tension_in", ".tension_out"))]
    columns = [name for name in names if name.startswith("c")] or names[:4]
    log = run.frame[columns] + np.random.default_rng(2).normal(0.0, 100.0, (len(run.frame), len(columns)))
    watch = rw.monitor(line, columns={"time": "time"} | {c: c for c in columns}, free="*.mass", sigma=100.0)
    seconds, _ = timed(lambda: list(watch.follow(log)))
    what = f"monitor of {spans} spans, {len(columns)} tensions at 1 Hz, {until:g} s"
    return what, f"{seconds:.2f}", "faster than real time", f"{until / seconds:.0f}"


def main() -> None:
    table = Table("what", "s", "in", "ratio")
    for row in (fit_of_a_skyline(), monitor_of_a_line(10), monitor_of_a_line(20)):
        table.add_row(*row)
    Console().print(table)


if __name__ == "__main__":
    main()
