"""Studies of rigs in compiled code have the tables that they have without."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.native.binary_cache import cache_info
from support.call_objects import rig, shod_rig
from support.compiled import require_same_table

STATIONS = [30.0, 90.0, 150.0]


def _plan(compiled: bool) -> pd.DataFrame:
    trees = [rw.Candidate(f"t{i}", 60.0 + 20.0 * i, (6.0, 8.0)) for i in range(3)]
    plan = rw.optimise_supports(rig(), trees, payload=900.0, stations=STATIONS, compiled=compiled)
    return pd.DataFrame({"name": [s.name for s in plan.supports], "height": [s.height for s in plan.supports]})


STUDIES: dict[str, Callable[[bool], pd.DataFrame]] = {
    "load_path": lambda compiled: rw.load_path(rig(), 900.0, STATIONS, compiled=compiled),
    "payload": lambda compiled: rw.payload(rig(), clearance=0.5, stations=STATIONS[:2], compiled=compiled).frame,
    "set_up": lambda compiled: pd.DataFrame(
        [rw.set_up(rig(), station=90.0, payload=900.0, deflection=6.0, compiled=compiled).loaded]
    ),
    "optimise_supports": _plan,
    "inhaul": lambda compiled: rw.inhaul(
        rig(), payload=900.0, start=125.0, end=105.0, every=1.0, compiled=compiled
    ).frame.reset_index(),
    "sensitivities": lambda compiled: rw.sensitivities(
        rig(), of=["skyline_tension", "carriage.z"], to=["payload", "tail.z"], stations=STATIONS, compiled=compiled
    ),
}


@pytest.mark.parametrize("name", STUDIES)
def test_a_study(name: str) -> None:
    require_same_table(*(STUDIES[name](compiled) for compiled in (True, False)))


def test_other_rigs_need_no_compiler() -> None:
    def path(lengthened: float, count: int, mass: float) -> None:
        supports = [rw.IntermediateSupport(f"s{i}", at=(70.0 * i + lengthened, 2.0)) for i in range(1, count + 1)]
        other = rw.standing_skyline(
            None, headspar=rw.HeadSpar("head", at=(0.0, 5.0)), supports=supports,
            tailspar=rw.TailSpar("tail", at=(70.0 * (count + 1) + lengthened, -5.0)), skyline="RHOL-IWRC 29",
            tension=80e3, carriage=rw.Carriage("carriage", mass=mass),
        )  # fmt: skip
        rw.load_path(other, 1000.0, [40.0, 100.0, 70.0 * count + lengthened + 30.0], compiled=True)

    path(0.0, 2, 400.0)
    known = cache_info().libraries
    path(13.0, 3, 650.0)
    path(-4.0, 4, 300.0)
    assert cache_info().libraries == known


@pytest.mark.slow
@pytest.mark.parametrize("study", ["load_path", "inhaul"])
def test_a_rig_with_a_shoe(study: str) -> None:
    how: dict[str, Any] = {"start": 118.0, "end": 95.0} if study == "inhaul" else {"stations": np.arange(95.0, 126.0)}
    found = [getattr(rw, study)(shod_rig(), payload=900.0, **how, compiled=compiled) for compiled in (True, False)]
    require_same_table(*(one.frame.reset_index() if study == "inhaul" else one for one in found))
