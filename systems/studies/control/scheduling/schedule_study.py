"""The best schedules of a line: planned from several starts, never worse than the line's own speeds."""

from __future__ import annotations

from collections.abc import Mapping

from ropeway.components.errors import InputError
from ropeway.components.schedule import Schedule
from ropeway.systems.studies.control.scheduling.initial_schedules import smoothed
from ropeway.systems.studies.control.scheduling.line_runs import Baseline, LineRuns, ScheduleRequest
from ropeway.systems.studies.control.scheduling.plan_check import broken_limits
from ropeway.systems.studies.control.scheduling.plan_iteration import PlanIteration, PlanLog
from ropeway.systems.studies.control.scheduling.schedule_plan import SchedulePlan
from ropeway.systems.studies.control.scheduling.schedule_tasks import ScheduleTasks


class ScheduleStudy:
    """The schedules of one line within its limits."""

    def __init__(self, runs: LineRuns, tasks: ScheduleTasks) -> None:
        self.runs, self.tasks = runs, tasks

    @classmethod
    def of(cls, request: ScheduleRequest) -> ScheduleStudy:
        """For a request; simulates the runs that plans are compared with. Raises InputError, UnknownNameError,
        EquilibriumError, SimulationError."""
        runs = LineRuns.of(request)
        return cls(runs, ScheduleTasks(request.limits, runs, Baseline.of(request, runs)))

    def first(self, warm_start: SchedulePlan | Mapping[str, Schedule] | None) -> dict[str, Schedule]:
        """The schedules to begin with: given ones on this grid, or those of the balanced run; the lead keeps its own
        speed. Raises InputError."""
        runs, grid = self.runs, self.runs.grid.tolist()
        if warm_start is None:
            found = smoothed(self.tasks.baseline.balanced, runs.grid, runs.names)
        else:
            given = warm_start.schedules if isinstance(warm_start, SchedulePlan) else warm_start
            if missing := [n for n in runs.names if n not in given]:
                raise InputError(f"warm_start has no schedule of {missing[0]!r}", "Give one for each control sheave")
            for name in runs.names:
                given[name].require(runs.until)
            found = {name: given[name].on(grid) for name in runs.names}
        if runs.lead in found:
            found[runs.lead] = runs.own_speed(runs.lead).on(grid)
        return found

    def optimise(self, weights: Mapping[str, float], schedules: Mapping[str, Schedule], log: PlanLog) -> SchedulePlan:
        """The plan; from constant speed, or constant speed itself, where that satisfies the limits and is better than
        what is found from `schedules`. Raises InfeasibleScheduleError, ScheduleError."""
        plan = PlanIteration(self.tasks, weights, schedules).run(log)
        if plan.better:
            return plan
        grid = self.runs.grid.tolist()
        own = {name: self.runs.own_speed(name).on(grid) for name in self.runs.names}
        if not self._allowed(own, plan):
            return plan
        for held in (False, True):
            plan = PlanIteration(self.tasks, weights, own, held=held).run(log)
            if plan.better:
                break
        return plan

    def _allowed(self, own: Mapping[str, Schedule], plan: SchedulePlan) -> bool:
        """Whether the line's own speeds begin as a plan does, and satisfy its limits."""
        for name, schedule in own.items():
            if schedule.speeds[0] != plan.schedules[name].speeds[0] or not self.tasks.allows(name, schedule):
                return False
        run = self.tasks.baseline.simulated(self.runs, own)
        return not broken_limits(self.tasks.task(plan.weights, run, held=True), run)
