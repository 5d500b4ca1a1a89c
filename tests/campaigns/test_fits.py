"""Synthetic fits of lines, standing and running skylines with 2 % noise: coverage of the 95 % intervals.

    pytest tests/campaigns/test_fits.py -m slow --campaign-seed 7 --campaign-count 334

The count is that of fits of each kind. True values are drawn anew around the declared ones for each fit.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
import pytest
from conftest import Campaign

import ropeway as rw
from support.measured import idlers, running, standing

NOISE = 0.02
LINES = {"m1": "l1.mass", "head": "a.tension", "z": "l1.z", "low": "l2.z"}
STANDING = {"station": "station", "head": "headspar_tension", "z": "carriage_z", "main": "mainline_tension"}
RUNNING = {"station": "station", "tail": "tailspar_tension", "sag": "sag"}


@cache
def declared(kind: str) -> Any:
    """What is fitted: the same object for all fits, which is assembled once."""
    return {"line": lambda: rw.assemble(idlers()), "standing": standing, "running": running}[kind]()


def drawn(kind: str, rng: np.random.Generator) -> tuple[object, pd.DataFrame, Mapping[str, str], dict[str, float]]:
    """What is fitted, a table without noise, its columns, and the true values."""
    by = rng.uniform(0.85, 1.15, 3)
    stations = np.sort(rng.uniform(20.0, 280.0, 12))
    if kind == "line":
        true = {"l2.mass": 300.0 * by[0], "a.pretension": 30e3 * by[1]}
        line = rw.assemble(idlers(l2=true["l2.mass"], tension=true["a.pretension"]))
        rows = []
        for mass in rng.uniform(50.0, 650.0, 12):
            eq = rw.equilibrium(line, parameters={"l1.mass": mass})
            rows.append({column: eq[target] for column, target in LINES.items()})
        return declared(kind), pd.DataFrame(rows), LINES, true
    if kind == "standing":
        true = {"payload": 2000.0 * by[0], "tension": 70e3 * by[1], "skyline.axial_stiffness": 24e6 * by[2]}
        rig = standing(true["tension"], true["skyline.axial_stiffness"], true["payload"])
        columns = STANDING
    else:
        true = {"payload": 500.0 * by[0], "tension": 40e3 * by[1]}
        rig, columns = running(true["tension"], true["payload"]), RUNNING
    path = rw.load_path(rig, true["payload"], stations)
    table = pd.DataFrame({"station": stations} | {c: path[t] for c, t in columns.items() if c != "station"})
    return declared(kind), table, columns, true


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["line", "standing", "running"])
def test_intervals_contain_the_true_values(kind: str, campaign: Campaign) -> None:
    """With N intervals the share that contains the true value is within 95 % and three standard deviations of a
    binomial distribution, or 93 to 97 % where that is wider."""
    rng = np.random.default_rng([campaign.seed, len(kind)])
    inside, total = dict[str, int](), 0
    for _ in range(campaign.size(60)):
        system, table, columns, true = drawn(kind, rng)
        sigma = dict[str, float]()
        for column in columns:
            if column not in ("m1", "station"):
                sigma[column] = NOISE * float(table[column].abs().mean())
                table[column] = table[column] + rng.normal(0.0, sigma[column], len(table))
        fit = rw.fit(system, table, columns=columns, free=list(true), sigma=sigma)
        for name, value in true.items():
            row = fit.frame.loc[name]
            inside[name] = inside.get(name, 0) + int(row["low"] <= value <= row["high"])
        total += 1
    shares = {name: count / total for name, count in inside.items()}
    print(kind, total, shares)
    room = max(0.02, 3.0 * np.sqrt(0.95 * 0.05 / total))
    assert all(abs(share - 0.95) <= room for share in shares.values()), shares
