"""Optimal schedules of control sheaves: how each should move, proved by simulation."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.response import ProportionalResponse
from ropeway.components.schedule import Schedule
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.modelling.system import System
from ropeway.systems.progress_bar import bar
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.studies.control.objectives import objective_weights
from ropeway.systems.studies.control.scheduling.limits import ScheduleLimits
from ropeway.systems.studies.control.scheduling.schedule_plan import SchedulePlan
from ropeway.systems.studies.control.scheduling.schedule_study import ScheduleStudy

MOST_INTERVALS = 10_000


@checked
@interruptible
def optimise_schedule(
    line: System,
    until: float,
    *,
    minimise: str | Mapping[str, float] = "peak tension",
    limits: ScheduleLimits | None = None,
    intervals: int = 60,
    target: float | None = None,
    settle: float | None = None,
    lead: str | None = None,
    start: Equilibrium | None = None,
    trim: ProportionalResponse | None = None,
    warm_start: SchedulePlan | Mapping[str, Schedule] | None = None,
    progress: bool | None = None,
) -> SchedulePlan:
    """Speeds of a mono-cable line's control sheaves over `until` seconds that serve an objective within limits.

    minimise: "peak tension", "tension deviation" or "energy" (`OBJECTIVES`), or a weight for each [per N, N, J].
    intervals: pieces on which speeds are linear. target: tension that the deviation counts from [N], by default the
    mean at the control sheaves when they balance their tensions. settle: from when the objectives of tension count [s],
    as a schedule cannot change what the line starts with; by default 10 s or a quarter of the time. The energy counts
    over the whole run, and limits hold from the beginning; before `settle` they are as much wider as a start out of
    balance needs. lead: the control sheave that keeps the line's speed, by default the first, or the drum that drives.
    start: an equilibrium to start from; trim: how the sheaves of `SchedulePlan.trimmed` correct towards the plan, by
    default with a gain that suits the line; warm_start: an earlier plan, or schedules. A plan begins with the first
    speeds of its warm start, by default with the line's own.

    The optimum is simulated, and planned anew around the simulation until both agree. Where the line's own speeds
    keep the limits and serve the objective better, they are the plan. Raises InputError,
    InfeasibleScheduleError with the limits that collide, ScheduleError with the last plan.
    """
    begin = clock.perf_counter()
    check.positive(until, "optimise_schedule", "until", "s")
    check_intervals(intervals)
    weights = objective_weights(minimise)
    bounds = ScheduleLimits() if limits is None else limits
    if not isinstance(bounds, ScheduleLimits):
        raise InputError(f"limits is {bounds!r}", "Give rw.ScheduleLimits(force=..., ...)")
    if trim is not None and not isinstance(trim, ProportionalResponse):
        raise InputError(f"trim is {trim!r}", "Give a ProportionalResponse: others do not correct towards a plan")
    settled = min(10.0, until / 4.0) if settle is None else settle
    check.not_negative(settled, "optimise_schedule", "settle", "s")
    if settled >= until:
        raise InputError(f"settle is {settled:g} s, until {until:g} s", "Let the line settle before the end")
    plans: list[SchedulePlan] = []
    with bar("optimise", 1.0, progress) as advance, keeping(lambda: plans[-1] if plans else None):
        study = ScheduleStudy(line, until, intervals, bounds, settled, target, lead, start, trim)
        schedules = study.first(warm_start)
        return study.optimise(weights, schedules, plans, advance, begin)


def check_intervals(intervals: int) -> None:
    """Raises InputError unless intervals are a whole number of at least 3."""
    if not 3 <= intervals <= MOST_INTERVALS:
        raise InputError(f"intervals is {intervals!r}", f"Give a whole number from 3 to {MOST_INTERVALS}")
