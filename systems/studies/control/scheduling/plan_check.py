"""Differences between a plan and its simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.result import Result
from ropeway.systems.studies.control.scheduling.plan_data import Gap
from ropeway.systems.studies.control.scheduling.sample_times import SampleTime, sample_times
from ropeway.systems.studies.control.scheduling.section_equations import LineEquations
from ropeway.systems.studies.control.scheduling.solution import Planned
from ropeway.systems.studies.control.scheduling.terms import Task

LEAST_DEVIATION = 1.0
"""Deviation [N] below which the root of the mean square is not linearised: its slope tends to infinity."""

CROSSING_GAP, PEAK_GAP = 5e-3, 20.0
"""A plan and its simulation agree when times of crossings [s] and the highest tension [N] differ by less."""

_OBJECTIVE_GAP, _DEVIATION_GAP = 0.01, 0.05
"""Shares by which an objective may differ between plan and simulation, and the deviation from where the plan took the
slope of its root: that is also the error of what limits cost."""

SPARE = 5e-3
"""Share of a limit by which a simulation may exceed it between two samples of the plan."""


@dataclass(frozen=True)
class Simulated:
    """Schedules, their simulation with its objectives, its equations, and the time it took [s]."""

    schedules: Mapping[str, Schedule]
    result: Result
    objectives: Mapping[str, float]
    equations: LineEquations
    seconds: float


def gap_between(places: Sequence[SampleTime], task: Task, planned: Planned, after: Simulated) -> Gap:
    """How far a plan, made at moments, is from its simulation."""
    found = sample_times(after.result, task.grid, (), after.equations.sections())
    expected = {key: float(t) for m, t in zip(places, planned.times, strict=True) for key in m.keys}
    came = {key: m.time for m in found for key in m.keys}
    # A load that comes to a support just at the end may be late.
    near_end = float(task.grid[-2])
    lone = [key for key in expected.keys() ^ came.keys() if {**expected, **came}[key] < near_end]
    both = expected.keys() & came.keys()
    moved = [abs(t - m.time) for m, t in zip(places, planned.times, strict=True)]
    return Gap(
        max((abs(expected[key] - came[key]) for key in both), default=0.0),
        abs(_highest(planned.frame, task.settle) - after.objectives["peak tension"]),
        len(lone),
        float(max(moved)),
    )


def agreed(gap: Gap) -> bool:
    """Whether plan and simulation are one."""
    return gap.crossing_time < CROSSING_GAP and gap.peak_tension < PEAK_GAP and not gap.crossings_in_one_only


def root_agrees(expected: float, objective: float, around: Simulated, after: Simulated) -> bool:
    """Whether the deviation is where a plan took the slope of its root, to 1 N at least."""
    before, reached = (run.objectives["tension deviation"] for run in (around, after))
    return (
        abs(expected - objective) <= _OBJECTIVE_GAP * abs(objective)
        and abs(before - reached) <= _DEVIATION_GAP * reached
    ) or max(before, reached) < LEAST_DEVIATION


def peaks_beyond(task: Task, planned: Planned, after: Simulated) -> list[float]:
    """Times [s] at which a simulation's highest tension has a peak above a plan's."""
    frame = after.result.full_frame
    frame = frame[frame.index >= task.settle]
    highest = frame.filter(regex=r"\.tension_[ab]$").max(axis=1).to_numpy()
    return _peaks(frame, highest - _highest(planned.frame, task.settle) - PEAK_GAP / 4.0)


def broken_limits(task: Task, after: Simulated) -> dict[str, list[float]]:
    """Limits that a simulation does not keep, with the times of the worst [s]."""
    equations, found = after.equations, dict[str, list[float]]()
    whole = after.result.full_frame
    for counts in (False, True):
        frame, bounds = whole[(whole.index >= task.settle) == counts], task.at(counts=counts)
        if frame.empty:
            continue
        ends = frame.filter(regex=r"\.tension_[ab]$")
        low, high = bounds.tension
        excess = {"tension": np.maximum(low - ends.min(axis=1), ends.max(axis=1) - high).to_numpy() - PEAK_GAP}
        for row in (row for rows in bounds.rows for row in rows):
            values = frame[row.output].to_numpy() / equations.y_unit[equations.model.y.index[row.output]]
            excess[row.output] = np.maximum(row.low - values, values - row.high) - SPARE * row.size
        for name, values in excess.items():
            found.setdefault(name, []).extend(_peaks(frame, values))
    return {name: times for name, times in found.items() if times}


def _peaks(frame: pd.DataFrame, excess: np.ndarray) -> list[float]:
    """Times [s] of the largest excess in each stretch in which it is above zero."""
    above = np.flatnonzero(excess > 0.0)
    stretches = np.split(above, np.flatnonzero(np.diff(above) > 1) + 1)
    return [float(frame.index[s[np.argmax(excess[s])]]) for s in stretches if len(s)]


def _highest(frame: pd.DataFrame, settle: float) -> float:
    """Highest tension of all spans from `settle` [s] on."""
    ends = frame[frame.index >= settle - 1e-9].filter(regex=r"\.tension_[ab]$")
    return float(np.nanmax(ends.to_numpy()))
