"""Random runs: no load lost, the same for any interval of records, resumed at any time, integrated as a whole, there
and back.

    pytest tests/campaigns/test_runs.py -m slow --campaign-seed 7 --campaign-count 200

Each run has a limit of time, so that one that does not come back is found.
"""

from __future__ import annotations

import signal
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from unittest import mock

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.dynamics.section_integrator import SectionIntegrator
from support.runs import RandomRun, random_run

LIMIT = 90.0
"""Processor time [s] that one run may take: thousands of loads that swing over a support take most of it."""
TOLD_APART = 1e-3
"""Events nearer than this to a time [s] may be counted before or after it."""


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raises TimeoutError when what is done within takes longer."""

    def late(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def tensions(result: rw.Result) -> Any:
    return result.frame.filter(regex=r"\.tension_(in|out|a|b)$")


def difference(one: Any, other: Any) -> float:
    return float(np.abs(one.to_numpy() / other.to_numpy() - 1.0).max())


def require_loads(result: rw.Result) -> None:
    """At each of some records the loads are those of the start, with those put on and without those taken off, in
    their spans and nowhere else."""
    start, times, run = Counter(result.record(0).loads["load"]), result.times, result.runs[0]
    for i in np.unique(np.linspace(0, len(times) - 1, 12).astype(int)):
        expected = start.copy()
        line = result.record(int(i))
        for event in result.noted:
            if event.event in ("load put on", "load taken off") and event.time < times[i] - TOLD_APART:
                expected[event.load] += 1 if event.event == "load put on" else -1
        near = {e.load for e in result.noted if abs(e.time - times[i]) <= TOLD_APART}
        found = Counter(line.loads["load"])
        for load in {*found, *expected} - near:
            assert found[load] == expected[load], f"{load} at {times[i]} s"
        for span, own in line.loads.groupby("span"):
            assert own["distance"].min() > -1e-6
            assert own["distance"].max() < line[f"{span}.length"] + 1e-6
        if run.around:
            assert line.loads["mass"].sum() == pytest.approx(result.record(0).loads["mass"].sum(), rel=1e-12)


def require_same(case: RandomRun, run: rw.Result) -> None:
    """Another interval: the same events, the same tensions at common times."""
    other = case.simulate(2.5)
    names = [sorted((e.component, e.event, e.load) for e in r.noted) for r in (run, other)]
    assert names[0] == names[1]
    both = run.frame.index.intersection(other.frame.index)
    assert difference(tensions(run).loc[both], tensions(other).loc[both]) < 1e-5


def require_resumed(case: RandomRun, run: rw.Result, rng: np.random.Generator) -> None:
    """From a time on, between records, at one, or at an event, it ends where the whole run does; so it does from a
    time in what was resumed."""
    time = float(rng.uniform(0.2, 0.8) * case.until)
    if rng.random() < 0.3:
        time = float(round(time))
    elif rng.random() < 0.3 and run.noted:
        time = float(min(max(run.noted[int(rng.integers(len(run.noted)))].time, 1.0), case.until - 1.0))
    rest = case.rest(run, time, 1.0)
    assert difference(tensions(rest).iloc[-1], tensions(run).iloc[-1]) < 1e-6, f"resumed at {time} s"
    assert sorted(rest.at(case.until - time).loads["load"]) == sorted(run.at(case.until).loads["load"])


def require_whole(case: RandomRun, run: rw.Result) -> None:
    """Drives that are moved by themselves while no limit is active move as they do with the whole line."""
    with mock.patch.object(SectionIntegrator, "advance", return_value=None):
        whole = case.simulate(1.0)
    both = run.frame.index.intersection(whole.frame.index)
    assert difference(tensions(run).loc[both], tensions(whole).loc[both]) < 1e-5


def require_there_and_back(case: RandomRun) -> None:
    """Ideal drives bring the line back to where it was."""
    way = float(np.random.default_rng(case.seed).uniform(0.4, 1.5))
    half = case.until / 2.0
    turn = rw.Schedule((0.0, half - 1.0, half + 1.0, case.until), (way, way, -way, -way))
    result = rw.simulate(case.system, case.until, inputs=dict.fromkeys(case.speeds, turn), progress=False)
    first, last = (result.at(t).loads.set_index("load")["span"] for t in (0.0, case.until))
    crossed = result.at(0.0).loads.set_index("load").loc[first[first != last.reindex(first.index)].index]
    lengths = crossed["span"].map(lambda span: result.at(0.0)[f"{span}.length"])
    if len(crossed):  # a line jumps as a load passes an idler: near it, it can rest on either side
        assert np.minimum(crossed["distance"], lengths - crossed["distance"]).max() < 0.05
        return
    assert difference(tensions(result).iloc[-1], tensions(result).iloc[0]) < 1e-8
    first, last = (result.at(t).loads.sort_values("load") for t in (0.0, case.until))
    assert first["load"].tolist() == last["load"].tolist()
    assert last["distance"].to_numpy() == pytest.approx(first["distance"].to_numpy(), abs=1e-6)


@pytest.mark.slow
def test_random_runs(campaign: Any) -> None:
    count, refused = campaign.size(12), Counter[str]()
    for seed in range(1000 * campaign.seed, 1000 * campaign.seed + count):
        case, rng = random_run(seed), np.random.default_rng(seed)
        try:
            with limited(LIMIT):
                run = case.simulate(1.0)
        except TimeoutError as error:
            error.add_note(f"seed {seed}, {case.kind}")
            raise
        except rw.RopewayError as error:  # too slack a rope, no rope left in a span
            refused[str(error)] += 1
            continue
        try:
            with limited(4.0 * LIMIT):
                require_loads(run)
                require_same(case, run)
                require_resumed(case, run, rng)
                if case.hydraulic:
                    require_whole(case, run)
                if case.returns:
                    require_there_and_back(case)
        except Exception as error:
            error.add_note(f"seed {seed}, {case.kind}")
            raise
    # These lines are taut enough to be far from losing their stability: what is refused would be refused wrongly.
    assert sum(refused.values()) <= 0.005 * count, refused
