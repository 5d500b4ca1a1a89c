"""A line under schedules that are planned repeatedly: each plan looks ahead, and only its beginning is driven."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

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
from ropeway.systems.studies.control.control_sheaves import scheduled_sheaves, with_responses
from ropeway.systems.studies.control.optimise_schedule import check_intervals, optimise_schedule
from ropeway.systems.studies.control.scheduling.limits import ScheduleLimits
from ropeway.systems.studies.control.scheduling.schedule_plan import SchedulePlan


@checked
@dataclass(frozen=True, eq=False, repr=False)
class RecedingHorizon:
    """A line driven by one plan after another.

    Attributes
    ----------
    plans : tuple of SchedulePlan
    begins : tuple of float
        When each plan begins [s].
    schedules : mapping of str to Schedule
        Speeds as driven, by control sheave.
    result : Result
        The simulation under them.

    Examples
    --------
    >>> moving = rw.receding_horizon(line, 4.0, horizon=6.0, every=2.0, intervals=3, settle=1.0)
    >>> list(moving.schedules)
    ['c1', 'c2']
    """

    plans: tuple[SchedulePlan, ...]
    begins: tuple[float, ...]
    schedules: Mapping[str, Schedule]
    result: Result

    def __repr__(self) -> str:
        plans = len(self.plans)
        return f"<RecedingHorizon of {self.plans[0].line.name!r} over {self.result.times[-1]:g} s: {plans} plans>"

    @cached_property
    def history(self) -> pd.DataFrame:
        """A row a plan: when it begins [s], rounds, computing time [s], objectives by its own simulation."""
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
    compiled: bool = False,
) -> RecedingHorizon:
    """Plan ahead, drive the beginning of the plan, plan again from there, and so on.

    Parameters
    ----------
    line : System
        A mono-cable line with control sheaves. Where a plan looks beyond the end of the line's own schedules, these
        keep their last speed.
    until : float
        End [s].
    horizon : float
        Time that each plan looks ahead [s].
    every : float
        Time between two plans [s], a whole number of intervals.
    minimise : str or mapping of str to float, default "peak tension"
        As for `optimise_schedule`.
    limits : ScheduleLimits, optional
        As for `optimise_schedule`; the `tension_low` of the first plan holds for all.
    intervals : int, default 30
        Number of intervals of each plan.
    target : float, optional
        As for `optimise_schedule`; that of the first plan holds for all [N].
    settle : float, default 10.0
        As for `optimise_schedule`, for the first plan [s]. The later ones start from a line that satisfies its limits,
        and count after two intervals.
    lead : str, optional
        As for `optimise_schedule`.
    start : Equilibrium, optional
        Where the line starts; by default its equilibrium.
    progress : bool, optional
        Whether to show a progress bar; by default on a terminal only.
    compiled : bool, default False
        Whether the runs are in compiled code, as in `simulate`.

    Returns
    -------
    RecedingHorizon

    Raises
    ------
    InputError, ScheduleError
    CompiledError, CompilerError, WriteError
        Of `compiled`, as in `simulate`.

    Examples
    --------
    >>> moving = rw.receding_horizon(line, 4.0, horizon=6.0, every=2.0, intervals=3, settle=1.0)
    >>> len(moving.plans)
    2
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
    names = scheduled_sheaves(line)
    bare = with_responses(line, dict.fromkeys(names))
    first = carried_over(equilibrium(bare, compiled=compiled) if start is None else start, bare)
    for own in first.model.signals:
        if isinstance(own, Schedule):
            own.require(until)
    how: dict[str, Any] = {"progress": False, "compiled": compiled}
    plan = partial(optimise_schedule, minimise=minimise, intervals=intervals, lead=lead, **how)
    bounds = ScheduleLimits() if limits is None else limits
    horizons = _Horizons(bare, names, first, partial(plan, settle=settle, target=target, limits=bounds))
    with bar("receding horizon", until, progress) as advance, keeping(horizons.driven):
        while horizons.begin < until - 1e-9:
            horizons.step(horizon, min(every, until - horizons.begin))
            last = horizons.plans[-1]
            horizons.plan = partial(
                plan,
                settle=min(settle, 2.0 * step),
                target=last.target,
                limits=replace(bounds, tension_low=last.tension[0]),
            )
            advance(horizons.begin)
        inputs = {f"{name}.speed": schedule for name, schedule in horizons.schedules.items()}
        result = simulate(first.model, until, every=step / 4.0, inputs=inputs, start=first, **how)
    return RecedingHorizon(tuple(horizons.plans), tuple(horizons.begins), horizons.schedules, result)


class _Horizons:
    """The plans of a line so far, and what was driven of them. `plan` optimises schedules of a line over a time."""

    def __init__(
        self, line: System, names: Sequence[str], start: Equilibrium, plan: Callable[..., SchedulePlan]
    ) -> None:
        self.line, self.here, self.plan = line, start, plan
        self.begin = 0.0
        self.plans: list[SchedulePlan] = []
        self.begins: list[float] = []
        self._speeds: dict[str, dict[float, float]] = {name: {} for name in names}
        self._warm: dict[str, Schedule] | None = None

    def step(self, horizon: float, part: float) -> None:
        """Plans over a horizon [s], and drives a part of it [s]."""
        plan = self.plan(_later(self.line, self.begin, horizon), horizon, start=self.here, warm_start=self._warm)
        self.plans.append(plan)
        self.begins.append(self.begin)
        for name, own in plan.schedules.items():
            times = [t for t in own.times if t < part - 1e-9] + [part]
            self._speeds[name].update((self.begin + t, own.at(t)) for t in times)
        self.here = plan.result.at(part)
        self._warm = {name: own.later(part, horizon) for name, own in plan.schedules.items()}
        self.begin += part

    @property
    def schedules(self) -> dict[str, Schedule]:
        """The schedules as driven."""
        return {name: Schedule(list(speeds), list(speeds.values())) for name, speeds in self._speeds.items()}

    def driven(self) -> pd.DataFrame:
        """The speeds as driven, over time [s]."""
        columns = {f"{name}.speed": pd.Series(speeds) for name, speeds in self._speeds.items()}
        return pd.DataFrame(columns).rename_axis("time")


def _later(line: System, by: float, until: float) -> System:
    """The line with its time 0 `by` seconds later, for `until` seconds."""
    other = line.copy()
    for name, driven in line.components.items():
        if isinstance(driven, (ControlSheave, Drum)) and isinstance(driven.speed, Schedule):
            other.components[name] = replace(driven, speed=driven.speed.later(by, until))
    return other
