"""The result of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ropeway.components.argument_checks import checked
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.reported import Reported
from ropeway.systems.reporting.style import Style
from ropeway.systems.studies.fitting.fit_data import FitData

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False, repr=False)
class Fit(FitData, Reported):
    """A fit to measured values, as `rw.fit` returns it.

    Parameters
    ----------
    name : str
        Name of the system or rig.
    frame : DataFrame
        A row for each free quantity: value, standard_error, low and high (95 % interval), declared, unit.
    covariance : DataFrame
        Of the free quantities, in SI units.
    measured, predicted : DataFrame
        In SI units, a row for each row of the table that is used, a column for each measured column; NaN where a cell
        is blank.
    sigma : DataFrame
        Standard deviations of the measured values, as given or estimated.
    unidentifiable : tuple of Combination
        Combinations of free quantities that the measured values do not determine.
    notes : tuple of str
        What the user should know: cells and rows that are skipped, values at bounds or far off.
    degrees : int
        Measured values and priors minus free quantities.
    helps : Suggestions
        Measurements that would help most.

    Examples
    --------
    >>> measured = pd.DataFrame({"a.tension": [6400.0, 6500.0], "b.z": [5.0, 5.02]})
    >>> rw.fit(span, measured, free=["a_b.length"], sigma=100.0).degrees
    1
    """

    def plot(self) -> Figure:
        """Plot measured and predicted values, their residuals and the intervals of the free quantities.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ropeway.systems.studies.fitting.fit_plot import fit_figure

        return fit_figure(self)

    def _report_title(self, style: Style) -> str:
        return f"{self.name}: {style.text('fit')}"

    def _report_sections(self, style: Style) -> Sequence[Section]:
        from ropeway.systems.studies.fitting.fit_report import fit_sections

        return fit_sections(self, style)
