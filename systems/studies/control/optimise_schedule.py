"""Optimal schedules of control sheaves, checked by simulation."""

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
from ropeway.systems.studies.control.scheduling.line_runs import ScheduleRequest
from ropeway.systems.studies.control.scheduling.plan_iteration import PlanLog
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
    compiled: bool = False,
) -> SchedulePlan:
    """Optimise the speeds of a mono-cable line's control sheaves over time, within limits.

    The optimum is simulated, and planned again around the simulation until both agree. Where the line's own speeds
    satisfy the limits and serve the objective better, they are the plan.

    Parameters
    ----------
    line : System
        A mono-cable line with control sheaves.
    until : float
        End of the schedules [s].
    minimise : str or mapping of str to float, default "peak tension"
        "peak tension" [N], "tension deviation" [N] or "energy" [J], or a weight for each.
    limits : ScheduleLimits, optional
        By default `ScheduleLimits()`. They hold from the beginning; a limit that the line's start exceeds is wider
        until `settle`.
    intervals : int, default 60
        Number of pieces on which speeds are linear in time, at least 3.
    target : float, optional
        Tension from which the deviation counts [N]; by default the mean at the control sheaves when they balance their
        tensions.
    settle : float, optional
        Time from which the objectives of tension count [s], as a schedule cannot change the tensions at the start; by
        default 10 s or a quarter of `until`. The energy counts over the whole run.
    lead : str, optional
        The control sheave that keeps the line's speed; by default the first, or the drum that drives.
    start : Equilibrium, optional
        Where the line starts; by default its equilibrium.
    trim : ProportionalResponse, optional
        How the sheaves of `SchedulePlan.trimmed` correct towards the plan; by default with a gain that suits the line.
    warm_start : SchedulePlan or mapping of str to Schedule, optional
        Schedules to begin with, by control sheave. The plan keeps their first speeds, by default the line's own.
    progress : bool, optional
        Whether to show a progress bar; by default on a terminal only.
    compiled : bool, default False
        Whether the runs are in compiled code, as in `simulate`.

    Returns
    -------
    SchedulePlan

    Raises
    ------
    InputError
        For invalid arguments, and for a line that is not one rope with a second driven support.
    InfeasibleScheduleError
        Where no schedule satisfies all limits; it names them, with the smallest sufficient relaxation.
    ScheduleError
        Where plan and simulation do not converge, with the last plan.
    CompiledError, CompilerError, WriteError
        Of `compiled`, as in `simulate`.

    Examples
    --------
    >>> plan = rw.optimise_schedule(line, 10.0, intervals=4, settle=2.0)
    >>> plan.objectives["peak tension"] <= plan.constant["peak tension"]
    True
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
    request = ScheduleRequest(line, until, intervals, bounds, settled, target, lead, start, trim, compiled)
    plans: list[SchedulePlan] = []
    with bar("optimise", 1.0, progress) as advance, keeping(lambda: plans[-1] if plans else None):
        study = ScheduleStudy.of(request)
        return study.optimise(weights, study.first(warm_start), PlanLog(advance, begin, plans))


def check_intervals(intervals: int) -> None:
    """Raises InputError unless intervals are a whole number of at least 3."""
    if not 3 <= intervals <= MOST_INTERVALS:
        raise InputError(f"intervals is {intervals!r}", f"Give a whole number from 3 to {MOST_INTERVALS}")
