"""A campaign of random systems at rest against an independent oracle: no wrong answer, no traceback, no endless solve,
and hardly a system refused that has a stable equilibrium.

    pytest tests/campaigns/test_systems.py -m slow --campaign-seed 7 --campaign-count 1000
"""

from __future__ import annotations

import time
from collections import Counter

import pytest
from conftest import Campaign

import ropeway as rw
from support.known_systems import judged, known_system, stiffness

LONGEST = 60.0
"""Seconds that no system may take."""


def stable(case: object) -> bool:
    """Whether the known equilibrium is one that a rope keeps."""
    from support.known_systems import Known, _pieces

    assert isinstance(case, Known)
    on = {name: (k, distance) for name, k, distance, _, _ in case.loads}
    weight = {name: load for name, _, _, load, _ in case.loads}
    pieces = [_pieces(k, case.length[k], on, weight) for k in range(len(case.length))]
    return stiffness(case, case.points, case.force, pieces, on, weight) > 1e-6


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ropeway.components.errors.RopewayWarning")
def test_random_systems(campaign: Campaign) -> None:
    found: Counter[str] = Counter()
    wrong, refused = [], []
    for i in range(campaign.size(150)):
        seed = 1_000_000 * campaign.seed + i
        try:
            case = known_system(seed)
            if not stable(case):
                continue
        except ArithmeticError:
            continue
        found["tried"] += 1
        begin = time.perf_counter()
        try:
            eq = case.solve()
        except rw.RopewayError as error:
            refused.append((seed, case.kind, str(error)))
        else:
            verdict = judged(case, eq)
            found["as known" if verdict.known else "another stable one"] += 1
            if verdict.faults:
                wrong.append((seed, case.kind, verdict.faults))
        assert time.perf_counter() - begin < LONGEST, seed
    print(dict(found), "refused:", refused, "wrong:", wrong)
    assert not wrong
    assert len(refused) <= max(1, 0.005 * found["tried"]), refused
