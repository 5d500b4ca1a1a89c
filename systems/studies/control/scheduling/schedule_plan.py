"""A schedule plan: its data, robustness, picture and files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.systems.modelling.system import System
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.reported import Reported
from ropeway.systems.reporting.style import Style
from ropeway.systems.studies.control.scheduling.plan_data import PlanData
from ropeway.systems.studies.control.scheduling.robustness import Disturbance, robustness, trimmed_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False, repr=False)
class SchedulePlan(PlanData, Reported):
    """Schedules of the control sheaves, and what they lead to.

    Attributes
    ----------
    schedules : mapping of str to Schedule
        Speeds by control sheave.
    predicted : DataFrame
        The line by plan, with the columns of a result's `full_frame`; a row for each side of each sample time (NaN for
        sections without a sample then).
    result : Result
        The line by simulation.
    objectives : mapping of str to float
        Of the simulation: `rw.objectives(plan.result, settle=plan.settle, target=plan.target)`.
    balanced, constant : mapping of str to float
        Objectives of the run whose sheaves balance their tensions, and of the line's own speeds (None where that run
        fails).
    weights : mapping of str to float
        Of the objectives.
    limits : ScheduleLimits
    tension : (float, float)
        Lowest and highest tension allowed [N].
    target : float
        Tension from which the deviation counts [N].
    settle : float
        Time from which the objectives of tension count [s].
    gap : Gap
        Between plan and simulation.
    active : DataFrame
        Active limits, a row for each limit and component: how often, when first [s], the bound, and the `cost`: by how
        much the objective falls per unit of the limit.
    history : PlanHistory
        Rounds, size of the problem, computing time.
    line : System
    start : Equilibrium
    lead : str
        The support that keeps the line's speed.
    trim : ProportionalResponse
        How the others correct towards the plan.

    Examples
    --------
    >>> plan = rw.optimise_schedule(line, 6.0, intervals=3, settle=1.0)
    >>> plan.frame.columns.tolist()
    ['c1.speed', 'c2.speed']
    """

    def __repr__(self) -> str:
        found = ", ".join(self.objective_text(name) for name in self.weights)
        return f"<SchedulePlan of {self.line.name!r} over {self.until:g} s: {found}>"

    @property
    def trimmed(self) -> System:
        """The line with trims that correct towards the plan.

        Feed-forward plus trim is `rw.simulate(plan.trimmed, plan.until, inputs=plan.inputs, start=plan.start)`.
        """
        return trimmed_line(self, self.trim)

    def robustness(
        self, disturbances: Sequence[Disturbance] | None = None, *, settle: float | None = None
    ) -> pd.DataFrame:
        """The plan under disturbances, by simulation.

        Parameters
        ----------
        disturbances : sequence of Disturbance, optional
            By default masses 10 % up and down, a speed 0.1 % up and down, a missing load, a drive 1 s late.
        settle : float, optional
            Time from which tensions count [s]; by default the plan's.

        Returns
        -------
        DataFrame
            A row for each disturbance; columns "open loop" and "trimmed" over "peak tension" [N], "over plan" (that
            over the plan's, less 1), "tension deviation" [N], and "energy" of the whole run [J]; NaN where a run fails.

        Raises
        ------
        InputError, UnknownNameError
        """
        return robustness(self, disturbances, settle)

    def _report_title(self, style: Style) -> str:
        return self.line.name

    def _report_sections(self, style: Style) -> Sequence[Section]:
        from ropeway.systems.studies.control.scheduling.reporting.plan_report import sections_of

        return sections_of(self, style)

    def plot(self) -> Figure:
        """Plot speeds, highest and lowest tension by plan and simulation, and the drives' forces.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ropeway.systems.studies.control.scheduling.plan_plot import plan_figure

        return plan_figure(self)
