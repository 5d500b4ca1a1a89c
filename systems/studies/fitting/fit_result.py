"""The result of a fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ropeway.components.argument_checks import checked
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.document import Project, ReportOptions, write_report
from ropeway.systems.reporting.style import Units
from ropeway.systems.studies.fitting.fit_data import FitData

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False, repr=False)
class Fit(FitData):
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

    def report(
        self,
        path: str | Path,
        *,
        project: Project | None = None,
        units: Units = "metric",
        labels: Mapping[str, str] | None = None,
        more: Sequence[Section] = (),
    ) -> Path:
        """Write the report of the fit: fitted values, correlations, measured and predicted values.

        Parameters
        ----------
        path : str or Path
            HTML, or PDF by a browser's print; needs the extra `report`.
        project : Project, optional
            Title, place, client, author and a remark.
        units : {"metric", "imperial"}, default "metric"
            Of the head; fitted and measured values are in SI units.
        labels : mapping, optional
            Words in place of those of `ropeway.systems.reporting.labels.ENGLISH`, by key.
        more : sequence of Section, optional
            Sections of your own after the others.

        Returns
        -------
        Path

        Raises
        ------
        InputError
            The name of the file, an option, or a missing package or browser.
        WriteError
            The file could not be written.
        """
        from ropeway.systems.studies.fitting.fit_report import fit_sections

        options = ReportOptions(project, units, labels, more)
        title = f"{self.name}: {options.style.text('fit')}"
        return write_report(path, title, fit_sections(self, options.style), options)
