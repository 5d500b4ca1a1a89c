"""Random rigs in compiled code have the load paths and payloads that they have without; random systems the equilibria.

pytest tests/campaigns/test_compiled_rigs.py -m slow --campaign-seed 7 --campaign-count 100
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from support.compiled import require_same_table
from support.known_systems import known_system
from support.random_rigs import Drawn, drawn


def _path(case: Drawn, compiled: bool) -> pd.DataFrame:
    stations = np.linspace(case.rig.points[0, 0], case.rig.points[case.rig.spans, 0], 8)[1:-1]
    return rw.load_path(case.rig, case.payload, stations, compiled=compiled)


def _payload(case: Drawn, compiled: bool) -> pd.DataFrame:
    middle = 0.45 * case.rig.points[0, 0] + 0.55 * case.rig.points[case.rig.spans, 0]
    return rw.payload(case.rig, clearance=case.clearance, stations=[middle], compiled=compiled).frame


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ropeway.components.errors.RopewayWarning")  # of ropes above their breaking load
def test_random_rigs_compiled(campaign: Any) -> None:
    count, seen = campaign.size(30), Counter[str]()
    for seed in range(1000 * campaign.seed, 1000 * campaign.seed + count):
        case = drawn(np.random.default_rng(seed))
        if case is None:
            continue
        for study in (_path, _payload):
            try:
                plain = study(case, compiled=False)
            except rw.RopewayError as error:
                with pytest.raises(type(error)):
                    study(case, compiled=True)
                seen["failed"] += 1
                continue
            try:
                require_same_table(study(case, compiled=True), plain)
            except Exception as error:
                error.add_note(f"seed {seed}, {study.__name__}")
                raise
            seen[study.__name__] += 1
    assert seen.total() - seen["failed"] > 0.5 * count, seen


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ropeway.components.errors.RopewayWarning")  # of ropes above their breaking load
def test_random_systems_compiled(campaign: Any) -> None:
    count, solved = campaign.size(40), 0
    for seed in range(1000 * campaign.seed, 1000 * campaign.seed + count):
        try:
            case = known_system(seed)
        except ArithmeticError:
            continue
        wanted: dict[str, Any] = {"given": case.given, "solve_for": case.solve_for}
        try:
            plain = rw.equilibrium(case.system, **wanted)
        except rw.RopewayError as error:
            with pytest.raises(type(error)):
                rw.equilibrium(case.system, **wanted, compiled=True)
            continue
        compiled = rw.equilibrium(case.system, **wanted, compiled=True)
        values = (one.frame["value"].to_numpy(dtype=float) for one in (compiled, plain))
        np.testing.assert_allclose(*values, rtol=1e-7, atol=1e-6, err_msg=f"seed {seed}, {case.kind}")
        solved += 1
    assert solved > 0.5 * count
