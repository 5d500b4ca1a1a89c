"""Data of a plan: schedules, and their results by plan and by simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.response import ProportionalResponse
from ropeway.components.schedule import Schedule
from ropeway.components.table_writer import Tabular
from ropeway.systems.dynamics.result import Result
from ropeway.systems.modelling.dae_model import component_of
from ropeway.systems.modelling.system import System
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.studies.control.scheduling.limits import ScheduleLimits
from ropeway.systems.studies.control.scheduling.solution import Active


@dataclass(frozen=True)
class Gap:
    """How far a plan is from its simulation: times of crossings [s], highest tension [N], and crossings that only
    one of them has. `moved`: how far crossings are from where the plan was made around [s]."""

    crossing_time: float
    peak_tension: float
    crossings_in_one_only: int
    moved: float


@dataclass(frozen=True)
class Round:
    """A plan and its simulation: status, iterations and time of the solver [s], time of the simulation [s], the
    objective by plan and by simulation, and the gap."""

    status: str
    iterations: int
    solve_seconds: float
    simulate_seconds: float
    planned: float
    simulated: float
    gap: Gap


@dataclass(frozen=True)
class PlanHistory:
    """The rounds of a plan, size of the problem, and computing time [s]."""

    rounds: tuple[Round, ...]
    variables: int
    constraints: int
    seconds: float

    @property
    def frame(self) -> pd.DataFrame:
        """A row a round."""
        rows = [{**{k: v for k, v in r.__dict__.items() if k != "gap"}, **r.gap.__dict__} for r in self.rounds]
        return pd.DataFrame(rows).rename_axis("round")


@checked
@dataclass(frozen=True, eq=False, repr=False)
class PlanData(Tabular):
    """Data of a plan: schedules, and what they lead to by plan and by simulation. Its fields: see `rw.SchedulePlan`."""

    schedules: Mapping[str, Schedule]
    predicted: pd.DataFrame
    result: Result
    objectives: Mapping[str, float]
    balanced: Mapping[str, float]
    constant: Mapping[str, float] | None
    weights: Mapping[str, float]
    limits: ScheduleLimits
    tension: tuple[float, float]
    target: float
    settle: float
    gap: Gap
    active: pd.DataFrame
    history: PlanHistory
    line: System
    start: Equilibrium
    lead: str
    trim: ProportionalResponse

    def objective_text(self, name: str) -> str:
        """An objective with its value, unit and the time over which it counts, as text.

        Parameters
        ----------
        name : str
            "peak tension", "tension deviation" or "energy".

        Returns
        -------
        str

        Raises
        ------
        UnknownNameError
        """
        if name not in self.objectives:
            raise UnknownNameError(f"The plan has no objective {name!r}", f"It has {', '.join(self.objectives)}")
        since = 0.0 if name == "energy" else self.settle
        unit = "kJ" if name == "energy" else "kN"
        return f"{name} {self.objectives[name] / 1e3:.6g} {unit} from {since:g} to {self.until:g} s"

    @property
    def until(self) -> float:
        """End of the plan [s]."""
        return next(iter(self.schedules.values())).times[-1]

    @property
    def objective(self) -> float:
        """The objective that was minimised, by simulation."""
        return self._value(self.objectives)

    @property
    def better(self) -> bool:
        """Whether the objective is not above that of the line's own speeds, where it can keep them."""
        return self.constant is None or self.objective <= self._value(self.constant)

    def _value(self, objectives: Mapping[str, float]) -> float:
        return sum(w * objectives[name] for name, w in self.weights.items())

    @cached_property
    def frame(self) -> pd.DataFrame:
        """The schedules: index time [s], columns c1.speed [m/s], ...; units in `attrs["units"]`."""
        times = next(iter(self.schedules.values())).times
        columns = {f"{name}.speed": schedule.speeds for name, schedule in self.schedules.items()}
        frame = pd.DataFrame(columns, index=pd.Index(times, name="time"))
        frame.attrs["units"] = dict.fromkeys(frame.columns, "m/s")
        return frame

    def at(self, time: float) -> pd.Series:
        """Speeds at a time.

        Parameters
        ----------
        time : float
            Within the plan [s].

        Returns
        -------
        Series
            [m/s], by control sheave.

        Raises
        ------
        InputError
        """
        if not 0.0 <= time <= self.until:
            raise InputError(f"{time:g} s is outside the schedule", f"Choose from 0 to {self.until:g} s")
        return pd.Series({name: s.at(time) for name, s in self.schedules.items()}, name=time)

    @property
    def inputs(self) -> dict[str, Schedule]:
        """The schedules as inputs of `rw.simulate`."""
        return {f"{name}.speed": schedule for name, schedule in self.schedules.items()}

    @property
    def free(self) -> list[str]:
        """Control sheaves whose speed was planned."""
        return [name for name in self.schedules if name != self.lead]


def active_table(active: list[Active], size: float, objective: float) -> pd.DataFrame:
    """The active limits that matter: a change by the whole limit would change the objective by a thousandth or more.
    `size`: of the objective, in that of the problem.
    """
    rows = pd.DataFrame(
        [(a.limit, component_of(a.component), a.time, a.bound, a.size, a.multiplier * size) for a in active],
        columns=["limit", "component", "time", "bound", "size", "cost"],
    )
    table = rows.groupby(["limit", "component"]).agg(
        times=("time", "nunique"),
        first=("time", "min"),
        bound=("bound", "first"),
        size=("size", "max"),
        cost=("cost", "sum"),
    )
    table = table[table["cost"] * table.pop("size") > 1e-3 * abs(objective)]
    return table.sort_values("cost", ascending=False)
