"""A line under schedules that are planned anew as it goes: each plan looks ahead, and only its beginning is driven."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.control_sheave import ControlSheave
from ropeway.components.drum import Drum
from ropeway.components.errors import InputError
from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.result import Result
from ropeway.systems.dynamics.simulation import simulate
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.modelling.system import System
from ropeway.systems.progress_bar import bar
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.statics.warm_start import carried_over
from ropeway.systems.studies.control.control_sheaves import control_sheaves, with_responses
from ropeway.systems.studies.control.optimise_schedule import check_intervals, optimise_schedule
from ropeway.systems.studies.control.scheduling.limits import ScheduleLimits
from ropeway.systems.studies.control.scheduling.schedule_plan import SchedulePlan


@checked
@dataclass(frozen=True, eq=False, repr=False)
class RecedingHorizon:
    """A line driven by plan after plan: the plans, when each began [s], the schedules as driven, and the simulation
    under them."""

    plans: tuple[SchedulePlan, ...]
    begins: tuple[float, ...]
    schedules: Mapping[str, Schedule]
    result: Result

    def __repr__(self) -> str:
        plans = len(self.plans)
        return f"<RecedingHorizon of {self.plans[0].line.name!r} over {self.result.times[-1]:g} s: {plans} plans>"

    @cached_property
    def history(self) -> pd.DataFrame:
        """A row a plan: when it began [s], rounds, time [s], objectives by its own simulation."""
        rows = [
            {"begin": begin, "rounds": len(p.history.rounds), "seconds": p.history.seconds, **p.objectives}
            for begin, p in zip(self.begins, self.plans, strict=True)
        ]
        return pd.DataFrame(rows).rename_axis("plan")


@checked
@interruptible
def receding_horizon(
    line: System,
    until: float,
    *,
    horizon: float,
    every: float,
    minimise: str | Mapping[str, float] = "peak tension",
    limits: ScheduleLimits | None = None,
    intervals: int = 30,
    target: float | None = None,
    settle: float = 10.0,
    lead: str | None = None,
    start: Equilibrium | None = None,
    progress: bool | None = None,
) -> RecedingHorizon:
    """Plans `horizon` seconds ahead, drives the line for `every` seconds, plans anew from where it is then, and so on.

    intervals: of each plan; `every` is a whole number of them. settle: as for `optimise_schedule`, for the first
    plan; the later ones go on from a line that keeps its limits, and count after two intervals. tension_low and the
    target of the first plan hold for all. Where a plan looks beyond the end of the line's own schedules, they keep
    their last speed. Raises InputError, ScheduleError.
    """
    for name, value in (("until", until), ("horizon", horizon), ("every", every)):
        check.positive(value, "receding_horizon", name, "s")
    check_intervals(intervals)
    step = horizon / intervals
    if not 0.5 * step < every <= horizon or abs(every / step - round(every / step)) > 1e-9:
        raise InputError(
            f"every is {every:g} s, the plans have intervals of {step:g} s",
            "Give a whole number of intervals, up to the horizon",
        )
    names = control_sheaves(line)
    bare = with_responses(line, dict.fromkeys(names))
    here = carried_over(equilibrium(bare) if start is None else start, bare)
    for own in here.model.signals:
        if isinstance(own, Schedule):
            own.require(until)
    first, begin = here, 0.0
    plans: list[SchedulePlan] = []
    begins: list[float] = []
    driven: dict[str, dict[float, float]] = {name: {} for name in names}
    bounds = ScheduleLimits() if limits is None else limits
    warm: dict[str, Schedule] | None = None

    def so_far() -> pd.DataFrame:
        return pd.DataFrame({f"{name}.speed": pd.Series(speeds) for name, speeds in driven.items()}).rename_axis("time")

    with bar("receding horizon", until, progress) as advance, keeping(so_far):
        while begin < until - 1e-9:
            plan = optimise_schedule(
                _later(bare, begin, horizon),
                horizon,
                minimise=minimise,
                limits=bounds,
                intervals=intervals,
                target=target,
                settle=settle if not plans else min(settle, 2.0 * step),
                lead=lead,
                start=here,
                warm_start=warm,
                progress=False,
            )
            plans.append(plan)
            begins.append(begin)
            bounds, target = replace(bounds, tension_low=plan.tension[0]), plan.target
            part = min(every, until - begin)
            for name, own in plan.schedules.items():
                times = [t for t in own.times if t < part - 1e-9] + [part]
                driven[name].update((begin + t, own.at(t)) for t in times)
            here = plan.result.at(part)
            warm = {name: own.later(part, horizon) for name, own in plan.schedules.items()}
            begin += part
            advance(begin)
        schedules = {name: Schedule(list(speeds), list(speeds.values())) for name, speeds in driven.items()}
        inputs = {f"{name}.speed": schedule for name, schedule in schedules.items()}
        result = simulate(first.model, until, every=step / 4.0, inputs=inputs, start=first, progress=False)
    return RecedingHorizon(tuple(plans), tuple(begins), schedules, result)


def _later(line: System, by: float, until: float) -> System:
    """The line whose time 0 is `by` seconds later, for `until` seconds."""
    other = line.copy()
    for name, driven in line.components.items():
        if isinstance(driven, (ControlSheave, Drum)) and isinstance(driven.speed, Schedule):
            other.components[name] = replace(driven, speed=driven.speed.later(by, until))
    return other
