"""Random rigs of all kinds, their load paths and payloads judged by an oracle that integrates ropes.

Each answer depends on its question alone, obeys the laws of statics, is refused only where the oracle finds no stable
state either, and payloads are the greatest within their limits, without holes or peaks along the corridor."""

from __future__ import annotations

import time

import numpy as np
import pytest
from conftest import Campaign

from support.random_rigs import drawn
from support.rig_verdicts import Verdict, judge


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ropeway.components.errors.RopewayWarning")  # of ropes above their breaking load
def test_random_rigs_answer_rightly(campaign: Campaign) -> None:
    """With `-s` a line for each rig, so that a run that is cut off has numbers too."""
    total, rigs = Verdict(), 0
    for i in range(campaign.size(12)):
        rng = np.random.default_rng([campaign.seed, i])
        if (case := drawn(rng)) is None:
            continue
        began = time.process_time()
        found = judge(case, rng)
        rigs += 1
        total.add(found)
        print(
            f"{i} {case.rig.name}: {found.asked} asked, {found.refused} refused, {found.payloads} payloads, "
            f"{time.process_time() - began:.1f} s CPU",
            *[f"\n   REFUSED {what}" for what in found.refused_wrongly],
            *[f"\n   FAULT {what}" for what in found.faults],
            flush=True,
        )
    print(f"{rigs} rigs, {total.asked} stations, {total.refused} refused, {total.payloads} payloads")
    assert not total.faults, total.faults
    assert len(total.refused_wrongly) <= 0.005 * total.asked, total.refused_wrongly
