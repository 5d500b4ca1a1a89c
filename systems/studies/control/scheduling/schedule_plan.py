"""A schedule plan, ready to ask: its data, its robustness, its picture and files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.systems.modelling.system import System
from ropeway.systems.reporting.document import ReportOptions, style_of, write_report
from ropeway.systems.studies.control.scheduling.plan_data import PlanData
from ropeway.systems.studies.control.scheduling.robustness import Disturbance, robustness, trimmed_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False, repr=False)
class SchedulePlan(PlanData):
    """Schedules of the control sheaves, by name, and what they bring.

    predicted: what the plan expects, with the columns of a result's `full_frame`, a row for each side of each moment
    that it looks at (NaN for sections that it does not look at then); result: the simulation; objectives: those of
    the simulation by name, as `rw.objectives(plan.result, settle=plan.settle, target=plan.target)` gives them: tensions
    from `settle` [s] on, energy over the whole run; balanced, constant: those of the run whose sheaves balance their
    tensions, and of the line's own speeds (None where it cannot keep them so long); gap between plan and simulation;
    active: limits that bind, a row for each limit and component, with how often, when first [s], the bound, and the
    `cost`: by how much the objective would fall per unit of the limit; history. lead: the support that keeps the
    line's speed; trim: how the others correct towards the plan.
    """

    def __repr__(self) -> str:
        found = ", ".join(self.told(name) for name in self.weights)
        return f"<SchedulePlan of {self.line.name!r} over {self.until:g} s: {found}>"

    @property
    def trimmed(self) -> System:
        """The line with trims that correct towards the plan: feed-forward plus trim is
        `rw.simulate(plan.trimmed, plan.until, inputs=plan.inputs, start=plan.start)`."""

        return trimmed_line(self, self.trim)

    def robustness(
        self, disturbances: Sequence[Disturbance] | None = None, *, settle: float | None = None
    ) -> pd.DataFrame:
        """The plan when the line is not as planned, a row for each disturbance; by default masses 10 % up and down, a
        speed 0.1 % up and down, a missing load, a drive 1 s late. Columns "open loop" and "trimmed" over highest
        tension [N], "over plan" (that over the plan's, less 1), deviation [N], from `settle` [s] on, by default the
        plan's, and energy [J] of the whole run; NaN where the line could not go on.
        """

        return robustness(self, disturbances, settle)

    def report(self, path: str | Path, **options: Unpack[ReportOptions]) -> Path:
        """Write the report of the plan: objectives, speeds, the moving line, active limits.

        Parameters
        ----------
        path : str or Path
            HTML, or PDF by a browser's print; needs the extra `report`.
        **options
            `project`, `units`, `labels`, `more`, see `docs/reports.md`.

        Returns
        -------
        Path

        Raises
        ------
        InputError, WriteError
        """
        from ropeway.systems.studies.control.scheduling.plan_report import sections_of

        return write_report(path, self.line.name, sections_of(self, style_of(options)), options)

    def plot(self) -> Figure:
        """Speeds, highest and lowest tension by plan and simulation, and the drives' forces."""
        from ropeway.systems.studies.control.scheduling.plan_plot import plan_figure

        return plan_figure(self)
