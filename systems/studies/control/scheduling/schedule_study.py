"""One study of a line's schedules: plan and simulation in turn, until both agree."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.component import Node
from ropeway.components.control_sheave import ControlSheave
from ropeway.components.errors import InfeasibleScheduleError, InputError, RopewayError, ScheduleError
from ropeway.components.response import ProportionalResponse, Response
from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.result import Result
from ropeway.systems.dynamics.simulation import simulate
from ropeway.systems.modelling.dae_model import component_of
from ropeway.systems.modelling.system import System
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.statics.warm_start import carried_over
from ropeway.systems.studies.control.control_sheaves import control_sheaves, with_responses
from ropeway.systems.studies.control.objectives import objectives
from ropeway.systems.studies.control.scheduling.initial_schedules import balancing, require_sheave, smoothed
from ropeway.systems.studies.control.scheduling.limits import HYDRAULIC, UNITS, ScheduleLimits
from ropeway.systems.studies.control.scheduling.plan_check import (
    LEAST_DEVIATION,
    PEAK_GAP,
    SPARE,
    Simulated,
    agreed,
    broken_limits,
    gap_between,
    peaks_beyond,
    root_agrees,
)
from ropeway.systems.studies.control.scheduling.plan_data import PlanHistory, Round, active_table
from ropeway.systems.studies.control.scheduling.problem import ScheduleProblem
from ropeway.systems.studies.control.scheduling.sample_times import sample_times
from ropeway.systems.studies.control.scheduling.schedule_plan import SchedulePlan
from ropeway.systems.studies.control.scheduling.section_equations import Constraint, LineEquations, drive_parameters
from ropeway.systems.studies.control.scheduling.solution import Planned, planned as solved
from ropeway.systems.studies.control.scheduling.terms import Bounds, Parts, Task

_ROUNDS, _ITERATIONS, _TOLERANCE = 8, 300, 1e-6
_SIZE = 10.0
"""What the objective is scaled to: with less the solver's barrier outweighs it."""
_GIVE = 1e-4
"""Share of a limit below which a relaxation is none."""
_ALIKE = 1e-3
"""Share of an objective in which two rounds are alike."""
_REACH = 0.15
"""Share of a line's highest speed by which a plan may leave the line's own, or m/s for a line that stands."""
_SAMPLES = 4
"""Records of a simulation in each interval of the schedule."""
_TENSIONS = r"\.tension_[ab]$"


class ScheduleStudy:
    """What all rounds share: the line, its limits, and the run that balances tensions."""

    def __init__(
        self,
        line: System,
        until: float,
        intervals: int,
        limits: ScheduleLimits,
        settle: float,
        target: float | None,
        lead: str | None,
        start: Equilibrium | None,
        trim: ProportionalResponse | None,
    ) -> None:
        self.line, self.until, self.limits, self.settle = line, until, limits, settle
        self.names = control_sheaves(line)
        for name in limits.sheaves:
            require_sheave(name, self.names)
        self._parts: dict[tuple[LineEquations, bool], Parts] = {}
        self.bare = with_responses(line, dict.fromkeys(self.names))
        self.start = equilibrium(self.bare) if start is None else carried_over(start, self.bare)
        self.grid = np.linspace(0.0, until, intervals + 1)
        self.lead = self._lead(lead)
        response = balancing(self.start, 1.0)
        self.trim = balancing(self.start, 0.5) if trim is None else trim
        rule = {name: None if name == self.lead else response for name in self.names}
        self.balanced = self.run({}, rule)
        self.constant = self._constant()
        frame = self.balanced.full_frame
        counts = frame.index >= settle
        sides = [f"{n}.tension_{s}" for n in self.names for s in ("in", "out")]
        self.target = float(frame.loc[counts, sides].to_numpy().mean()) if target is None else target
        check.positive(self.target, "optimise_schedule", "target", "N")
        rope = self.balanced.runs[0].rope
        low = frame.filter(regex=_TENSIONS).to_numpy()[counts].min()
        self.tension = (
            # Below it by the gap allowed: some tensions, as beside a drum, no schedule can change.
            float(low) - PEAK_GAP if limits.tension_low is None else limits.tension_low,
            rope.safe_working_load if limits.tension_high is None else limits.tension_high,
        )
        if self.tension[0] >= self.tension[1]:
            raise InputError(
                f"Tensions are to stay above {self.tension[0]:g} N and below {self.tension[1]:g} N",
                "Give limits with tension_low below tension_high",
            )

    def _lead(self, lead: str | None) -> str:
        """The support whose speed is the line's. Raises InputError, UnknownNameError."""
        driven = [component_of(name) for name in self.start.model.u.names]
        drums = [name for name in driven if name not in self.names]
        if lead is not None:
            require_sheave(lead, self.names)
        if len(driven) < 2 or not self.names:
            raise InputError(
                f"{self.line.name!r} has nothing to optimise", "A schedule needs a second driven support on the rope"
            )
        return lead or (drums or self.names)[0]

    def own_speed(self, name: str) -> Schedule:
        """The speed that a driven support has by itself. Raises InputError."""
        signal = self.start.model.signals[self.start.model.u.index[f"{name}.speed"]]
        if signal is None:
            raise InputError(f"The speed of {name!r} is open", "Give it a speed, which its schedule starts from")
        return signal if isinstance(signal, Schedule) else Schedule((0.0, self.until), (signal, signal))

    def _constant(self) -> Result | None:
        """The run at the line's own speeds; None where the line cannot keep them so long."""
        try:
            return self.run({}, {})
        except RopewayError:
            return None

    def run(self, schedules: Mapping[str, Schedule], responses: Mapping[str, Response | None]) -> Result:
        """The line under schedules and responses, with a record at every grid time."""
        line = with_responses(self.line, {**dict.fromkeys(self.names), **responses})
        start = carried_over(self.start, line)
        inputs = {f"{name}.speed": schedule for name, schedule in schedules.items()}
        every = float(self.grid[1]) / _SAMPLES
        return simulate(start.model, self.until, every=every, inputs=inputs, start=start, progress=False)

    def first(self, warm_start: SchedulePlan | Mapping[str, Schedule] | None) -> dict[str, Schedule]:
        """The schedules to begin with: given ones on this grid, or those of the balanced run; the lead keeps its own
        speed. Raises InputError."""
        if warm_start is None:
            found = smoothed(self.balanced, self.grid, self.names)
        else:
            given = warm_start.schedules if isinstance(warm_start, SchedulePlan) else warm_start
            if missing := [n for n in self.names if n not in given]:
                raise InputError(f"warm_start has no schedule of {missing[0]!r}", "Give one for each control sheave")
            for name in self.names:
                given[name].require(self.until)
            found = {name: given[name].on(self.grid.tolist()) for name in self.names}
        if self.lead in found:
            found[self.lead] = self.own_speed(self.lead).on(self.grid.tolist())
        return found

    def task(self, weights: Mapping[str, float], first: Simulated, *, held: bool) -> Task:
        """The task of the problems around the simulation `first` and later ones; held: speeds stay as they are."""
        equations = first.equations
        bounds = Bounds(self.tension, tuple(self._rows(equations, node) for node in equations.nodes))
        return Task(
            grid=self.grid,
            weights=weights,
            bounds=bounds,
            early=self._early(bounds, first),
            fixed=tuple(held or n.name == self.lead or n.name not in self.names for n in equations.nodes),
            speed=tuple(self._speed_range(node.name) for node in equations.nodes),
            acceleration=self.limits.acceleration,
            target=self.target,
            deviation=1.0,
            settle=self.settle,
        )

    def _early(self, bounds: Bounds, first: Simulated) -> Bounds:
        """The bounds before `settle`. What the line's start does not keep is as much wider as the start, and the
        sheaves on their way to balance, need; so is a lowest tension that nobody gave. No tension is higher than the
        highest with sheaves in balance."""
        balanced = self.balanced.full_frame
        before = pd.concat([first.result.full_frame.iloc[:1], balanced[balanced.index < self.settle]])
        ends = before.filter(regex=_TENSIONS)
        low, high = bounds.tension
        if self.limits.tension_low is None or ends.iloc[0].min() < low:
            low = min(low, float(ends.min(axis=None)) - PEAK_GAP)
        high = min(high, float(balanced.filter(regex=_TENSIONS).max(axis=None)) + PEAK_GAP)
        if ends.iloc[0].max() > high:
            high = float(ends.max(axis=None)) + PEAK_GAP
        return Bounds((low, high), tuple(tuple(_wider(row, first, before) for row in rows) for rows in bounds.rows))

    def _rows(self, equations: LineEquations, node: Node) -> tuple[Constraint, ...]:
        if not isinstance(node, ControlSheave):
            return ()
        hydraulic = drive_parameters(equations.model, node, equations.parameters, tuple(HYDRAULIC.values()))
        rows = []
        for output, (low, high, limit) in self.limits.outputs(node.name, hydraulic).items():
            name = f"{node.name}.{output}"
            if name not in equations.model.y.index:
                raise InputError(f"{node.name!r} has no {output}: its drive is ideal", "Limit force and power instead")
            unit = equations.y_unit[equations.model.y.index[name]]
            rows.append(Constraint(name, low / unit, high / unit, limit))
        return tuple(rows)

    def _speed_range(self, name: str) -> tuple[float, float]:
        if self.limits.speed is not None:
            return self.limits.speed
        speeds = self.own_speed(name).on(self.grid.tolist()).speeds
        reach = _REACH * (max(map(abs, speeds)) or 1.0)
        return min(speeds) - reach, max(speeds) + reach

    def optimise(
        self,
        weights: Mapping[str, float],
        schedules: dict[str, Schedule],
        plans: list[SchedulePlan],
        advance: Callable[[float], None],
        begin: float,
    ) -> SchedulePlan:
        """The plan; from constant speed, or that itself, where it keeps the limits and is better than what is found
        from `schedules`. Each plan on the way is added to `plans`. Raises InfeasibleScheduleError, ScheduleError."""
        plan = self.rounds(weights, schedules, plans, advance, begin)
        if plan.better:
            return plan
        own = {name: self.own_speed(name).on(self.grid.tolist()) for name in self.names}
        if not self._allowed(own, plan):
            return plan
        for held in (False, True):
            plan = self.rounds(weights, own, plans, advance, begin, held=held)
            if plan.better:
                break
        return plan

    def _allowed(self, own: Mapping[str, Schedule], plan: SchedulePlan) -> bool:
        """Whether the line's own speeds begin as a plan does, and keep its limits."""
        for name, schedule in own.items():
            speeds = np.array(schedule.speeds)
            low, high = self._speed_range(name)
            steepest = np.abs(np.diff(speeds)).max() / float(self.grid[1])
            if speeds[0] != plan.schedules[name].speeds[0] or speeds.min() < low or speeds.max() > high:
                return False
            if steepest > self.limits.acceleration and name != self.lead:
                return False
        run = self.around(own)
        return not broken_limits(self.task(plan.weights, run, held=True), run)

    def rounds(
        self,
        weights: Mapping[str, float],
        schedules: Mapping[str, Schedule],
        plans: list[SchedulePlan],
        advance: Callable[[float], None],
        begin: float,
        *,
        held: bool = False,
    ) -> SchedulePlan:
        """Plans and simulates in turn until both agree; each plan is added to `plans`. Raises InfeasibleScheduleError,
        ScheduleError."""
        balanced = self.value(self.balanced)
        # A line that stands takes no energy: then what its tension does over a metre.
        size = sum(w * (balanced[name] or self.target) for name, w in weights.items()) / _SIZE
        around = self.around(schedules)
        asked = self.task({name: w / size for name, w in weights.items()}, around, held=held)
        rounds: list[Round] = []
        plan: SchedulePlan | None = None
        # A mean over time wants more samples than a peak, which asks for its own where it needs them.
        record = float(self.grid[1]) / _SAMPLES
        between = (self.grid[1:] + self.grid[:-1]) / 2.0
        more: set[float] = set() if list(weights) == ["peak tension"] else set(between.tolist())
        for number in range(_ROUNDS):
            deviation = max(around.objectives["tension deviation"], LEAST_DEVIATION)
            task = replace(asked, deviation=deviation)
            problem = self.problem(task, around, sorted(more))
            planned = solved(problem, _ITERATIONS, _TOLERANCE)
            if not planned.solution.converged:
                planned = self.relaxed(task, around, sorted(more), again=number < _ROUNDS // 2)
            after = self.around(
                {
                    node.name: Schedule(self.grid.tolist(), planned.speeds[i].tolist())
                    for i, node in enumerate(around.equations.nodes)
                    if node.name in self.names
                },
                around.equations,
            )
            gap = gap_between(problem.moments, task, planned, after)
            objective = sum(w * after.objectives[name] for name, w in weights.items())
            told = planned.solution
            expected = told.objective * size + weights.get("tension deviation", 0.0) * deviation / 2.0
            rounds.append(Round(told.status, told.iterations, told.seconds, after.seconds, expected, objective, gap))
            history = PlanHistory(
                tuple(rounds), len(told.variables), len(told.multipliers), clock.perf_counter() - begin
            )
            plan = SchedulePlan(
                schedules=after.schedules,
                predicted=planned.frame,
                result=after.result,
                objectives=after.objectives,
                balanced=balanced,
                constant=None if self.constant is None else self.value(self.constant),
                weights=weights,
                limits=self.limits,
                tension=self.tension,
                target=self.target,
                settle=self.settle,
                gap=gap,
                active=active_table(planned.active, size, objective),
                history=history,
                line=self.line,
                start=self.start,
                lead=self.lead,
                trim=self.trim,
            )
            plans.append(plan)
            advance(1.0 - 0.5 ** (number + 1))
            broken = broken_limits(task, after)
            # Where crossings can come at several times alike, rounds differ in them but not in what they reach.
            near = gap.moved < float(self.grid[1]) / 8.0 or (
                number > 0 and abs(objective - rounds[-2].simulated) < _ALIKE * abs(objective)
            )
            near = near and ("tension deviation" not in weights or root_agrees(expected, objective, around, after))
            if told.converged and not planned.relaxation and agreed(gap) and near and not broken:
                return plan
            for times in (peaks_beyond(task, planned, after), *broken.values()):
                more.update(np.round(np.array(times) / record) * record)
            around = after
        raise ScheduleError(
            f"Plan and simulation did not converge in {_ROUNDS} rounds: crossings {gap.crossing_time:.3g} s and "
            f"highest tension {gap.peak_tension:.3g} N apart, objective {expected:.6g} by plan, {objective:.6g} by "
            "simulation",
            f"Take more intervals, or a shorter time{_and(broken)}",
            plan,
        )

    def around(self, schedules: Mapping[str, Schedule], equations: LineEquations | None = None) -> Simulated:
        """The simulation of schedules, to plan around; equations: those of an earlier one, if they still hold."""
        begin = clock.perf_counter()
        result = self.run(schedules, {})
        if equations is None or equations.model is not result.model:
            equations = LineEquations(result.model, result.parameters)
        return Simulated(schedules, result, self.value(result), equations, clock.perf_counter() - begin)

    def value(self, result: Result) -> dict[str, float]:
        """The objectives of a run."""
        return objectives(result, settle=self.settle, target=self.target)

    def problem(self, task: Task, around: Simulated, more: Sequence[float]) -> ScheduleProblem:
        """The problem around a simulation."""
        key = (around.equations, task.relaxed)
        if key not in self._parts:
            self._parts[key] = Parts(around.equations, task)
        places = sample_times(around.result, self.grid, more, around.equations.sections())
        speeds = self.speeds(around.equations, around.schedules)
        return ScheduleProblem(around.equations, self._parts[key], task, around.result, places, speeds)

    def relaxed(self, task: Task, around: Simulated, more: Sequence[float], *, again: bool) -> Planned:
        """The schedule that gives way least; again: another round may follow.

        Raises InfeasibleScheduleError when it has to give way, ScheduleError."""
        problem = self.problem(replace(task, relaxed=True), around, more)
        planned = solved(problem, _ITERATIONS, _TOLERANCE)
        if not planned.solution.converged:
            raise ScheduleError(
                f"IPOPT found no schedule: {planned.solution.status}", "Begin with other schedules in warm_start"
            )
        needed = {limit: give for limit, give in planned.relaxation.items() if give > _GIVE * problem.size(limit)}
        # Where crossings come at other times, another round may need less.
        far = again and any(
            abs(t - m.time) > problem.step / 8.0 for m, t in zip(problem.moments, planned.times, strict=True)
        )
        if not needed or far:
            return planned
        table = active_table(planned.active, 1.0, planned.solution.objective)
        names = sorted({*table.index.get_level_values("limit"), *needed})
        relaxation = {limit: give * problem.unit(limit) for limit, give in needed.items()}
        least = [f"{limit} by {give:.3g} {UNITS[limit]}".rstrip() for limit, give in relaxation.items()]
        raise InfeasibleScheduleError(
            f"No schedule keeps these limits together: {', '.join(names)}",
            f"The least that would do: {', '.join(least)}",
            relaxation,
            table,
        )

    def speeds(self, equations: LineEquations, schedules: Mapping[str, Schedule]) -> np.ndarray:
        """Speeds of the driven supports at grid times, shape (driven, grid)."""
        speeds = [schedules.get(node.name, self.own_speed(node.name)) for node in equations.nodes]
        return np.array([[speed.at(t) for t in self.grid.tolist()] for speed in speeds])


def _wider(row: Constraint, run: Simulated, before: pd.DataFrame) -> Constraint:
    """A row with bounds that the values of a time keep too, where the first of them does not keep its own."""
    unit = run.equations.y_unit[run.equations.model.y.index[row.output]]
    values, spare = before[row.output] / unit, SPARE * row.size
    if row.low <= values.iloc[0] <= row.high:
        return row
    return replace(row, low=min(row.low, values.min() - spare), high=max(row.high, values.max() + spare))


def _and(broken: Mapping[str, Sequence[float]]) -> str:
    places = [f"{name} at {times[0]:.1f} s" for name, times in broken.items()]
    return f"; the simulation passes the limit of {', '.join(places)}" if places else ""
