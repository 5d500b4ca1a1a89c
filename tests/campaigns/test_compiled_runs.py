"""Random runs in the compiled core are those that IDAS integrates.

pytest tests/campaigns/test_compiled_runs.py -m slow --campaign-seed 7 --campaign-count 300
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

import ropeway as rw
from support.compiled import require_alike
from support.runs import random_run


@pytest.mark.slow
def test_random_runs_compiled(campaign: Any) -> None:
    count, seen = campaign.size(40), Counter[str]()
    for seed in range(1000 * campaign.seed, 1000 * campaign.seed + count):
        case = random_run(seed)
        try:
            run = case.simulate(1.0, compiled=True, tolerance=1e-8)
        except rw.CompiledError:
            seen["refused"] += 1
            continue
        except rw.RopewayError as error:
            with pytest.raises(type(error)):
                case.simulate(1.0)
            seen["failed"] += 1
            continue
        try:
            require_alike(run, case.simulate(1.0, tolerance=1e-9))
        except Exception as error:
            error.add_note(f"seed {seed}, {case.kind}")
            raise
        seen[case.kind] += 1
    assert seen.total() - seen["refused"] - seen["failed"] > 0.2 * count, seen
