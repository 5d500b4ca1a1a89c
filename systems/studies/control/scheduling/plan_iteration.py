"""Plan and simulation in turn, until both agree."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ropeway.components.errors import InfeasibleScheduleError, ScheduleError
from ropeway.components.schedule import Schedule
from ropeway.systems.studies.control.scheduling.limits import UNITS
from ropeway.systems.studies.control.scheduling.line_runs import Baseline, LineRuns
from ropeway.systems.studies.control.scheduling.plan_check import (
    LEAST_DEVIATION,
    Simulated,
    agreed,
    broken_limits,
    gap_between,
    peaks_beyond,
    root_agrees,
)
from ropeway.systems.studies.control.scheduling.plan_data import Gap, PlanHistory, Round, active_table
from ropeway.systems.studies.control.scheduling.problem import ScheduleProblem
from ropeway.systems.studies.control.scheduling.sample_times import sample_times
from ropeway.systems.studies.control.scheduling.schedule_plan import SchedulePlan
from ropeway.systems.studies.control.scheduling.schedule_tasks import ScheduleTasks
from ropeway.systems.studies.control.scheduling.section_equations import LineEquations
from ropeway.systems.studies.control.scheduling.solution import Planned, planned as solved
from ropeway.systems.studies.control.scheduling.terms import Parts, Task

_ROUNDS, _ITERATIONS, _TOLERANCE = 8, 300, 1e-6
_SIZE = 10.0
"""What the objective is scaled to: with less the solver's barrier outweighs it."""
_LEAST_RELAXATION = 1e-4
"""Share of a limit below which a relaxation counts as none."""
_ALIKE = 1e-3
"""Share of an objective in which two rounds are alike."""


@dataclass(frozen=True)
class PlanLog:
    """The plans of all rounds so far; `advance` takes the share of the work that is done; `begin`: time at which the
    work began [s]."""

    advance: Callable[[float], None]
    begin: float
    plans: list[SchedulePlan] = field(default_factory=list)


@dataclass(frozen=True)
class _Outcome:
    """A round: what was planned, its simulation `after`, the gap between both, the objective that was `expected` by the
    plan and the one by simulation, and the limits that the simulation breaks."""

    task: Task
    planned: Planned
    after: Simulated
    gap: Gap
    expected: float
    objective: float
    broken: Mapping[str, Sequence[float]]


class PlanIteration:
    """The rounds from one start: `weights` of the objectives, `schedules` to begin with; held: speeds are not
    changed, only simulated and priced."""

    def __init__(
        self,
        tasks: ScheduleTasks,
        weights: Mapping[str, float],
        schedules: Mapping[str, Schedule],
        *,
        held: bool = False,
    ) -> None:
        self.tasks, self.weights = tasks, weights
        self.runs: LineRuns = tasks.runs
        self.baseline: Baseline = tasks.baseline
        self.balanced = self.baseline.objectives(self.baseline.balanced)
        # A line that stands takes no energy: then its size is that of the tension over a metre.
        self.size = sum(w * (self.balanced[name] or self.baseline.target) for name, w in weights.items()) / _SIZE
        self.around = self.baseline.simulated(self.runs, schedules)
        self.task = tasks.task({name: w / self.size for name, w in weights.items()}, self.around, held=held)
        self.rounds: list[Round] = []
        self._parts: dict[tuple[LineEquations, bool], Parts] = {}
        # A mean over time needs more samples than a peak, for which they are added where needed.
        between = (self.runs.grid[1:] + self.runs.grid[:-1]) / 2.0
        self.more: set[float] = set() if list(weights) == ["peak tension"] else set(between.tolist())

    def run(self, log: PlanLog) -> SchedulePlan:
        """The plan that agrees with its simulation. Raises InfeasibleScheduleError, ScheduleError."""
        for number in range(_ROUNDS):
            outcome = self._round(again=number < _ROUNDS // 2)
            plan = self._plan(outcome, log.begin)
            log.plans.append(plan)
            log.advance(1.0 - 0.5 ** (number + 1))
            if self._accepted(outcome):
                return plan
            for times in (peaks_beyond(outcome.task, outcome.planned, outcome.after), *outcome.broken.values()):
                self.more.update(np.round(np.array(times) / self.runs.record_step) * self.runs.record_step)
            self.around = outcome.after
        gap = outcome.gap
        raise ScheduleError(
            f"Plan and simulation did not converge in {_ROUNDS} rounds: crossings {gap.crossing_time:.3g} s and "
            f"highest tension {gap.peak_tension:.3g} N apart, objective {outcome.expected:.6g} by plan, "
            f"{outcome.objective:.6g} by simulation",
            f"Take more intervals, or a shorter time{_and(outcome.broken)}",
            plan,
        )

    def _round(self, *, again: bool) -> _Outcome:
        """Plans around the last simulation, and simulates that. again: another round may follow."""
        around = self.around
        deviation = max(around.objectives["tension deviation"], LEAST_DEVIATION)
        task = replace(self.task, deviation=deviation)
        problem = self._problem(task)
        planned = solved(problem, _ITERATIONS, _TOLERANCE)
        if not planned.solution.converged:
            planned = self._relaxed(task, again=again)
        schedules = {
            node.name: Schedule(self.runs.grid.tolist(), planned.speeds[i].tolist())
            for i, node in enumerate(around.equations.nodes)
            if node.name in self.runs.names
        }
        after = self.baseline.simulated(self.runs, schedules, around.equations)
        gap = gap_between(problem.moments, task, planned, after)
        objective = sum(w * after.objectives[name] for name, w in self.weights.items())
        solution = planned.solution
        expected = solution.objective * self.size + self.weights.get("tension deviation", 0.0) * deviation / 2.0
        self.rounds.append(
            Round(
                status=solution.status,
                iterations=solution.iterations,
                solve_seconds=solution.seconds,
                simulate_seconds=after.seconds,
                planned=expected,
                simulated=objective,
                gap=gap,
            )
        )
        return _Outcome(task, planned, after, gap, expected, objective, broken_limits(task, after))

    def _plan(self, outcome: _Outcome, begin: float) -> SchedulePlan:
        """A round as a plan."""
        after, solution, constant = outcome.after, outcome.planned.solution, self.baseline.constant
        return SchedulePlan(
            schedules=after.schedules,
            predicted=outcome.planned.frame,
            result=after.result,
            objectives=after.objectives,
            balanced=self.balanced,
            constant=None if constant is None else self.baseline.objectives(constant),
            weights=self.weights,
            limits=self.tasks.limits,
            tension=self.baseline.tension,
            target=self.baseline.target,
            settle=self.baseline.settle,
            gap=outcome.gap,
            active=active_table(outcome.planned.active, self.size, outcome.objective),
            history=PlanHistory(
                tuple(self.rounds),
                len(solution.variables),
                len(solution.multipliers),
                clock.perf_counter() - begin,
            ),
            line=self.runs.line,
            start=self.runs.start,
            lead=self.runs.lead,
            trim=self.baseline.trim,
        )

    def _accepted(self, outcome: _Outcome) -> bool:
        """Whether plan and simulation agree, and the simulation satisfies all limits."""
        gap, objective = outcome.gap, outcome.objective
        # Where crossings have several equally good times, rounds differ in them but not in the objective.
        near = gap.moved < self.runs.step / 8.0 or (
            len(self.rounds) > 1 and abs(objective - self.rounds[-2].simulated) < _ALIKE * abs(objective)
        )
        if "tension deviation" in self.weights:
            near = near and root_agrees(outcome.expected, objective, self.around, outcome.after)
        feasible = outcome.planned.solution.converged and not outcome.planned.relaxation and not outcome.broken
        return feasible and agreed(gap) and near

    def _problem(self, task: Task) -> ScheduleProblem:
        """The problem around the last simulation."""
        around = self.around
        key = (around.equations, task.relaxed)
        if key not in self._parts:
            self._parts[key] = Parts(around.equations, task)
        moments = sample_times(around.result, self.runs.grid, sorted(self.more), around.equations.sections())
        speeds = self.runs.speeds(around.equations, around.schedules)
        return ScheduleProblem(around.equations, self._parts[key], task, around.result, moments, speeds)

    def _relaxed(self, task: Task, *, again: bool) -> Planned:
        """The schedule with the smallest relaxation of limits. Raises InfeasibleScheduleError where that is not zero,
        and no other round may need less; ScheduleError."""
        problem = self._problem(replace(task, relaxed=True))
        planned = solved(problem, _ITERATIONS, _TOLERANCE)
        if not planned.solution.converged:
            raise ScheduleError(
                f"IPOPT found no schedule: {planned.solution.status}", "Begin with other schedules in warm_start"
            )
        needed = {
            limit: slack
            for limit, slack in planned.relaxation.items()
            if slack > _LEAST_RELAXATION * problem.size(limit)
        }
        # With crossings at other times, another round may need less.
        far = again and any(
            abs(t - m.time) > problem.step / 8.0 for m, t in zip(problem.moments, planned.times, strict=True)
        )
        if not needed or far:
            return planned
        table = active_table(planned.active, 1.0, planned.solution.objective)
        names = sorted({*table.index.get_level_values("limit"), *needed})
        relaxation = {limit: slack * problem.unit(limit) for limit, slack in needed.items()}
        least = [f"{limit} by {slack:.3g} {UNITS[limit]}".rstrip() for limit, slack in relaxation.items()]
        raise InfeasibleScheduleError(
            f"No schedule satisfies all of these limits: {', '.join(names)}",
            f"Relax them; the smallest sufficient change: {', '.join(least)}",
            relaxation,
            table,
        )


def _and(broken: Mapping[str, Sequence[float]]) -> str:
    places = [f"{name} at {times[0]:.1f} s" for name, times in broken.items()]
    return f"; the simulation passes the limit of {', '.join(places)}" if places else ""
