"""Synthetic measurements: a line, a standing and a running skyline with known values, and what devices would show."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pandas as pd

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
SKYLINE = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450e3)
MAINLINE = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)


def idlers(l1: float = 400.0, l2: float = 300.0, tension: float = 30e3, stiffness: float = 34.8e6) -> rw.System:
    """Three spans over idlers with two loads."""
    s = rw.System("idlers")
    nodes = [rw.Anchor("a", at=(0, 0)), rw.Sheave("s1", at=(100, 5)), rw.Sheave("s2", at=(210, 2, 8))]
    rope = replace(ROPE, axial_stiffness=stiffness)
    spans = s.string(rope, *nodes, rw.Anchor("b", at=(300, 12)), tension=tension)
    s.hang(rw.Load("l1", mass=l1), spans, at=150.0)
    s.hang(rw.Load("l2", mass=l2), spans[2], at=50.0)
    return s


def standing(tension: float = 70e3, stiffness: float = 24e6, payload: float = 2000.0) -> rw.SkylineRig:
    """A standing skyline of two spans with a mainline."""
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        supports=[rw.IntermediateSupport("jack", at=(140.0, 2.0))],
        tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
        skyline=replace(SKYLINE, axial_stiffness=stiffness),
        tension=tension,
        mainline=MAINLINE,
        carriage=rw.Carriage("carriage", mass=450.0, payload=payload),
    )


def running(tension: float = 40e3, payload: float = 500.0) -> rw.SkylineRig:
    """A running skyline."""
    return rw.running_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        tailspar=rw.TailSpar("tail", at=(300.0, 10.0)),
        haulback=MAINLINE,
        tension=tension,
        mainline=MAINLINE,
        carriage=rw.Carriage("carriage", mass=400.0, payload=payload),
    )


@dataclass(frozen=True)
class Case:
    """A fit with a known answer: what is fitted, `exact` values of a table without noise, its `columns`, and the `true`
    values of what is free."""

    system: Any
    exact: pd.DataFrame
    columns: Mapping[str, str]
    true: Mapping[str, float]

    def noisy(self, share: float, rng: np.random.Generator) -> tuple[pd.DataFrame, dict[str, float]]:
        """The table with noise of a share of the mean of each measured column, and the standard deviations."""
        table, sigma = self.exact.copy(), dict[str, float]()
        for column in self.columns:
            if column not in ("m1", "station"):
                sigma[column] = share * float(table[column].abs().mean())
                table[column] += rng.normal(0.0, sigma[column], len(table))
        return table, sigma

    def fit(self, table: pd.DataFrame, sigma: Any, **more: Any) -> rw.Fit:
        return rw.fit(self.system, table, columns=self.columns, free=list(self.true), sigma=sigma, **more)


@cache
def line_case() -> Case:
    """A line whose first load changes from row to row."""
    true = {"l2.mass": 280.0, "a.pretension": 32e3}
    line = idlers(l2=280.0, tension=32e3)
    columns = {"m1": "l1.mass", "head": "a.tension", "z": "l1.z", "low": "l2.z"}
    masses = np.linspace(50.0, 650.0, 10)
    rows = []
    for mass in masses:
        eq = rw.equilibrium(line, parameters={"l1.mass": mass})
        rows.append({column: eq[target] for column, target in columns.items()})
    return Case(rw.assemble(idlers()), pd.DataFrame(rows), columns, true)


def _path_case(
    rig: rw.SkylineRig, declared: rw.SkylineRig, measured: Mapping[str, str], true: Mapping[str, float]
) -> Case:
    stations = np.linspace(25.0, 275.0, 10)
    path = rw.load_path(rig, rig.carriage.payload, stations)
    table = pd.DataFrame({"station": stations, **{column: path[target] for column, target in measured.items()}})
    return Case(declared, table, {"station": "station", **measured}, true)


@cache
def standing_case() -> Case:
    true = {"payload": 2300.0, "tension": 74e3, "skyline.axial_stiffness": 22e6}
    measured = {"head": "headspar_tension", "z": "carriage_z"}
    return _path_case(standing(74e3, 22e6, 2300.0), standing(), measured, true)


@cache
def running_case() -> Case:
    true = {"payload": 620.0, "tension": 42e3}
    measured = {"haulback": "tailspar_tension", "sag": "sag"}
    return _path_case(running(42e3, 620.0), running(), measured, true)


CASES: Mapping[str, Callable[[], Case]] = {"line": line_case, "standing": standing_case, "running": running_case}
