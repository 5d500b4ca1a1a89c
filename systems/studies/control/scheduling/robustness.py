"""A plan under disturbances of the line: open loop, and as feed-forward with a tension trim."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, RopewayError
from ropeway.components.response import ProportionalResponse
from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.simulation import simulate
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.modelling.system import System
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import assign_loads
from ropeway.systems.statics.warm_start import carried_over
from ropeway.systems.studies.control.control_sheaves import with_responses
from ropeway.systems.studies.control.objectives import objectives
from ropeway.systems.studies.control.scheduling.initial_schedules import require_sheave

if TYPE_CHECKING:
    from ropeway.systems.studies.control.scheduling.plan_data import PlanData


@checked
@dataclass(frozen=True)
class Disturbance:
    """A difference between a line and its plan.

    Parameters
    ----------
    name : str
        Name of its row in a table.
    mass : float, default 1.0
        Factor of all loads' masses.
    speed : float, default 1.0
        Factor of the speed of `sheave`.
    delay : float, default 0.0
        By how much the schedule of `sheave` is late [s].
    sheave : str, optional
        A control sheave.
    missing : float, optional
        The load nearest to this place, 0 to 1 along the line, is missing.

    Raises
    ------
    InputError

    Examples
    --------
    >>> rw.Disturbance("5 % heavier", mass=1.05).mass
    1.05
    """

    name: str
    mass: float = 1.0
    speed: float = 1.0
    delay: float = 0.0
    sheave: str | None = None
    missing: float | None = None

    def __post_init__(self) -> None:
        owner = f"Disturbance {self.name!r}"
        check.positive(self.mass, owner, "mass")
        check.positive(self.speed, owner, "speed")
        check.not_negative(self.delay, owner, "delay", "s")
        if (self.speed != 1.0 or self.delay) and self.sheave is None:
            raise InputError(f"{owner} has no sheave", "Name the one whose speed differs")
        if self.missing is not None:
            check.number(self.missing, owner, "missing")
            if not 0.0 <= self.missing <= 1.0:
                raise InputError(f"{owner}: missing is {self.missing!r}", "Give a place along the line from 0 to 1")

    def schedules(self, planned: Mapping[str, Schedule]) -> dict[str, Schedule]:
        """The schedules as the drives then follow them.

        Parameters
        ----------
        planned : mapping of str to Schedule
            By control sheave.

        Returns
        -------
        dict of str to Schedule

        Raises
        ------
        UnknownNameError
        """
        found = dict(planned)
        if self.sheave is not None:
            require_sheave(self.sheave, list(planned))
            own = planned[self.sheave]
            times = [0.0, *(t + self.delay for t in own.times)] if self.delay else list(own.times)
            speeds = [own.speeds[0], *own.speeds] if self.delay else list(own.speeds)
            found[self.sheave] = Schedule(times, [v * self.speed for v in speeds])
        return found

    def start(self, planned: Equilibrium) -> Equilibrium:
        """The start of the plan with the other masses, and the rope as it was.

        Parameters
        ----------
        planned : Equilibrium
            The start of the plan.

        Returns
        -------
        Equilibrium

        Raises
        ------
        EquilibriumError
        """
        runs = []
        for run, passed in zip(planned.runs, planned.passed, strict=True):
            mass, feed = run.loads.mass * self.mass, run.feed
            if feed is not None:
                feed = replace(feed, masses=tuple(m * self.mass for m in feed.masses))
            if self.missing is not None:
                on_line = range(int(passed[-1]), int(passed[0]))
                mass[on_line[round((1.0 - self.missing) * (len(on_line) - 1))]] = 0.0
            runs.append(replace(run, loads=replace(run.loads, mass=mass), feed=feed))
        state = LineState(planned.model, planned.point.copy(), runs, planned.passed)
        state.write_slots()
        newton_of(state.model).solve(state.point)
        while not assign_loads(state):
            newton_of(state.model).solve(state.point)
        return Equilibrium(
            state.model, state.point, tuple(state.runs), tuple(state.passed), planned.held, planned.pending
        )


def usual_disturbances(sheave: str) -> tuple[Disturbance, ...]:
    """Masses 10 % up and down, speed of a sheave 0.1 % up and down, a missing load, a drive 1 s late."""
    return (
        Disturbance("as planned"),
        Disturbance("masses +10 %", mass=1.1),
        Disturbance("masses -10 %", mass=0.9),
        Disturbance(f"speed of {sheave} +0.1 %", speed=1.001, sheave=sheave),
        Disturbance(f"speed of {sheave} -0.1 %", speed=0.999, sheave=sheave),
        Disturbance("a missing load", missing=0.5),
        Disturbance(f"drive of {sheave} 1 s late", delay=1.0, sheave=sheave),
    )


def trimmed_line(plan: PlanData, trim: ProportionalResponse) -> System:
    """The line with trims that correct towards the difference of tension that a plan has at each of their samples;
    the sheave that keeps the line's speed has none."""
    frame = plan.result.full_frame
    frame = frame[~frame.index.duplicated(keep="last")]
    times = np.arange(trim.period, plan.until + 1e-9, trim.period)
    responses = {}
    for name in plan.schedules:
        difference = np.interp(times, frame.index, frame[f"{name}.differential_tension"])
        if name != plan.lead:
            responses[name] = replace(trim, target=None, difference=Schedule(times.tolist(), difference.tolist()))
    return with_responses(plan.line, {**dict.fromkeys(plan.schedules), **responses})


@interruptible
def robustness(
    plan: PlanData, disturbances: Sequence[Disturbance] | None = None, settle: float | None = None
) -> pd.DataFrame:
    """See `SchedulePlan.robustness`. Raises InputError, UnknownNameError."""
    late = plan.settle if settle is None else settle
    known = objectives(plan.result, settle=late, target=plan.target)
    cases = usual_disturbances(plan.free[0]) if disturbances is None else disturbances
    names = [case.name for case in cases]
    if twice := [name for name in names if names.count(name) > 1]:
        raise InputError(f"Two disturbances are named {twice[0]!r}", "Give each a name of its own")
    driven = [case.schedules(plan.schedules) for case in cases]
    lines = {
        "open loop": with_responses(plan.line, dict.fromkeys(plan.schedules)),
        "trimmed": trimmed_line(plan, plan.trim),
    }
    starts = {kind: carried_over(plan.start, line) for kind, line in lines.items()}
    rows: dict[str, dict[tuple[str, str], float]] = {}

    def table() -> pd.DataFrame:
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("case")

    with keeping(table):
        for case, schedules in zip(cases, driven, strict=True):
            rows[case.name] = _row(case, schedules, plan, starts, late, known)
    return table()


def _row(
    case: Disturbance,
    schedules: Mapping[str, Schedule],
    plan: PlanData,
    starts: Mapping[str, Equilibrium],
    late: float,
    known: Mapping[str, float],
) -> dict[tuple[str, str], float]:
    """Objectives of a plan under a disturbance, open loop and trimmed."""
    row: dict[tuple[str, str], float] = {}
    inputs = {f"{name}.speed": schedule for name, schedule in schedules.items()}
    for kind, start in starts.items():
        try:
            begin = case.start(start)
            result = simulate(begin.model, plan.until, every=0.5, inputs=inputs, start=begin, progress=False)
            found = objectives(result, settle=late, target=plan.target)
        except RopewayError:
            found = dict.fromkeys(known, np.nan)
        row[kind, "peak tension"] = found["peak tension"]
        row[kind, "over plan"] = found["peak tension"] / known["peak tension"] - 1.0
        row[kind, "tension deviation"] = found["tension deviation"]
        row[kind, "energy"] = found["energy"]
    return row
