"""Runs of a line under schedules, all from one start, and those that every plan is compared with."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropeway.components import check
from ropeway.components.errors import InputError, RopewayError
from ropeway.components.response import ProportionalResponse, Response
from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.result import Result
from ropeway.systems.dynamics.simulation import simulate
from ropeway.systems.modelling.dae_model import component_of
from ropeway.systems.modelling.system import System
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.statics.warm_start import carried_over
from ropeway.systems.studies.control.control_sheaves import scheduled_sheaves, with_responses
from ropeway.systems.studies.control.objectives import objectives
from ropeway.systems.studies.control.scheduling.initial_schedules import balancing, require_sheave
from ropeway.systems.studies.control.scheduling.limits import ScheduleLimits
from ropeway.systems.studies.control.scheduling.plan_check import PEAK_GAP, Simulated
from ropeway.systems.studies.control.scheduling.section_equations import LineEquations

_SAMPLES = 4
"""Records of a simulation in each interval of the schedule."""
TENSIONS = r"\.tension_[ab]$"
"""Columns of the tensions at the ends of spans."""


@dataclass(frozen=True)
class ScheduleRequest:
    """What a schedule is asked for: see `optimise_schedule`; limits and settle [s] have their defaults here."""

    line: System
    until: float
    intervals: int
    limits: ScheduleLimits
    settle: float
    target: float | None = None
    lead: str | None = None
    start: Equilibrium | None = None
    trim: ProportionalResponse | None = None
    compiled: bool = False


@dataclass(frozen=True, eq=False)
class LineRuns:
    """The line, its control sheaves by `names`, the `lead` that keeps the line's speed, the `start` without responses,
    the times of the `grid` [s], and whether runs are in `compiled` code."""

    line: System
    names: list[str]
    lead: str
    start: Equilibrium
    grid: np.ndarray
    compiled: bool = False

    @classmethod
    def of(cls, request: ScheduleRequest) -> LineRuns:
        """For a request: solves the line's equilibrium where none is given. Raises InputError, UnknownNameError,
        EquilibriumError."""
        line, names = request.line, scheduled_sheaves(request.line)
        for name in request.limits.sheaves:
            require_sheave(name, names)
        bare = with_responses(line, dict.fromkeys(names))
        rest = equilibrium(bare, compiled=request.compiled) if request.start is None else request.start
        start = carried_over(rest, bare)
        driven = [component_of(name) for name in start.model.u.names]
        drums = [name for name in driven if name not in names]
        if request.lead is not None:
            require_sheave(request.lead, names)
        if len(driven) < 2 or not names:
            raise InputError(
                f"{line.name!r} has nothing to optimise", "A schedule needs a second driven support on the rope"
            )
        lead = request.lead or (drums or names)[0]
        grid = np.linspace(0.0, request.until, request.intervals + 1)
        return cls(line, names, lead, start, grid, request.compiled)

    @property
    def until(self) -> float:
        """End of the runs [s]."""
        return float(self.grid[-1])

    @property
    def step(self) -> float:
        """Length of an interval [s]."""
        return float(self.grid[1])

    @property
    def record_step(self) -> float:
        """Time between two records [s]."""
        return self.step / _SAMPLES

    def own_speed(self, name: str) -> Schedule:
        """The speed that a driven support has by itself. Raises InputError."""
        signal = self.start.model.signals[self.start.model.u.index[f"{name}.speed"]]
        if signal is None:
            raise InputError(f"The speed of {name!r} is open", "Give it a speed, which its schedule starts from")
        return signal if isinstance(signal, Schedule) else Schedule((0.0, self.until), (signal, signal))

    def speeds(self, equations: LineEquations, schedules: Mapping[str, Schedule]) -> np.ndarray:
        """Speeds of the driven supports at grid times, shape (driven, grid)."""
        speeds = [schedules.get(node.name, self.own_speed(node.name)) for node in equations.nodes]
        return np.array([[speed.at(t) for t in self.grid.tolist()] for speed in speeds])

    def run(self, schedules: Mapping[str, Schedule], responses: Mapping[str, Response | None]) -> Result:
        """The line under schedules and responses, with a record at every grid time. Raises SimulationError."""
        line = with_responses(self.line, {**dict.fromkeys(self.names), **responses})
        start = carried_over(self.start, line)
        inputs = {f"{name}.speed": schedule for name, schedule in schedules.items()}
        how: dict[str, Any] = {"every": self.record_step, "inputs": inputs, "start": start, "compiled": self.compiled}
        return simulate(start.model, self.until, progress=False, **how)


@dataclass(frozen=True, eq=False)
class Baseline:
    """Runs that every plan is compared with: the one whose sheaves balance their tensions (`balanced`) and the one at
    the line's own speeds (`constant`, None where it fails); the `target` of tensions [N], the lowest and highest
    `tension` [N], and the `trim` of the sheaves."""

    balanced: Result
    constant: Result | None
    target: float
    tension: tuple[float, float]
    trim: ProportionalResponse
    settle: float

    @classmethod
    def of(cls, request: ScheduleRequest, runs: LineRuns) -> Baseline:
        """Simulates both. Raises InputError, SimulationError."""
        limits = request.limits
        response = balancing(runs.start, 1.0)
        trim = balancing(runs.start, 0.5) if request.trim is None else request.trim
        balanced = runs.run({}, {name: None if name == runs.lead else response for name in runs.names})
        try:
            constant = runs.run({}, {})
        except RopewayError:
            constant = None
        frame = balanced.full_frame
        counts = frame.index >= request.settle
        sides = [f"{n}.tension_{s}" for n in runs.names for s in ("in", "out")]
        target = float(frame.loc[counts, sides].to_numpy().mean()) if request.target is None else request.target
        check.positive(target, "optimise_schedule", "target", "N")
        rope = balanced.runs[0].rope
        lowest = frame.filter(regex=TENSIONS).to_numpy()[counts].min()
        # Below the lowest by the gap allowed: some tensions, as beside a drum, no schedule can change.
        low = float(lowest) - PEAK_GAP if limits.tension_low is None else limits.tension_low
        high = rope.safe_working_load if limits.tension_high is None else limits.tension_high
        if low >= high:
            raise InputError(
                f"The limits of tension are {low:g} N and {high:g} N", "Give limits with tension_low below tension_high"
            )
        return cls(balanced, constant, target, (low, high), trim, request.settle)

    def objectives(self, result: Result) -> dict[str, float]:
        """The objectives of a run."""
        return objectives(result, settle=self.settle, target=self.target)

    def simulated(
        self, runs: LineRuns, schedules: Mapping[str, Schedule], equations: LineEquations | None = None
    ) -> Simulated:
        """The simulation of schedules with its objectives; equations: those of an earlier one, if they still hold.
        Raises SimulationError."""
        begin = clock.perf_counter()
        result = runs.run(schedules, {})
        if equations is None or equations.model is not result.model:
            equations = LineEquations(result.model, result.parameters)
        return Simulated(schedules, result, self.objectives(result), equations, clock.perf_counter() - begin)
