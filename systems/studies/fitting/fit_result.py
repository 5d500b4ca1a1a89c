"""The result of a fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.table_writer import Tabular
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.document import Project, ReportOptions, write_report
from ropeway.systems.reporting.style import Units
from ropeway.systems.studies.fitting.identifiability import Combination
from ropeway.systems.studies.fitting.suggestion import Suggestions

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False)
class Fit(Tabular):
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
    """

    name: str
    frame: pd.DataFrame
    covariance: pd.DataFrame
    measured: pd.DataFrame
    predicted: pd.DataFrame
    sigma: pd.DataFrame
    unidentifiable: tuple[Combination, ...]
    notes: tuple[str, ...]
    degrees: int
    helps: Suggestions

    def __repr__(self) -> str:
        shown = ", ".join(
            f"{name} = {row.value:.6g} +- {row.standard_error:.2g} {row.unit}".rstrip()
            for name, row in zip(self.frame.index, self.frame.itertuples(), strict=True)
        )
        return f"<Fit of {self.name!r}: {shown}>"

    @property
    def values(self) -> pd.Series:
        """The fitted values, in SI units."""
        return self.frame["value"]

    @property
    def standard_errors(self) -> pd.Series:
        """Their standard errors; inf for a quantity that is not identified."""
        return self.frame["standard_error"]

    @cached_property
    def correlations(self) -> pd.DataFrame:
        """Correlations of the free quantities."""
        error = self.standard_errors.to_numpy()
        with np.errstate(invalid="ignore", divide="ignore"):
            values = self.covariance.to_numpy() / np.outer(error, error)
        return pd.DataFrame(values, index=self.covariance.index, columns=self.covariance.columns)

    @property
    def residuals(self) -> pd.DataFrame:
        """Measured minus predicted values, in SI units."""
        return self.measured - self.predicted

    @property
    def suggestion(self) -> str:
        """The one more measurement, in the states of the table, that would help most."""
        return self.helps.text

    @property
    def suggestions(self) -> pd.DataFrame:
        """Candidates for one more measurement, best first.

        Columns quantity, state, sigma, unit, gain (of the logarithm of the volume of the confidence ellipsoid), helps
        (the free quantity) and error_falls_to (share of its standard error).
        """
        return self.helps.frame

    def intervals(self, confidence: float = 0.95) -> pd.DataFrame:
        """Confidence intervals of the free quantities.

        Parameters
        ----------
        confidence : float, default 0.95
            Probability that an interval contains the true value.

        Returns
        -------
        DataFrame
            Columns low and high.

        Raises
        ------
        InputError
            The confidence is not between 0 and 1.
        """
        check.positive(confidence, "intervals", "confidence")
        if confidence >= 1.0:
            raise InputError(f"confidence is {confidence:g}", "Give a probability below 1, such as 0.95")
        wide = quantile(confidence, int(self.frame.attrs["degrees"])) * self.standard_errors
        return pd.DataFrame({"low": self.values - wide, "high": self.values + wide})

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


def quantile(confidence: float, degrees: int) -> float:
    """Half of a confidence interval over the standard error: normal where sigma is given (`degrees` 0), otherwise of
    Student's distribution."""
    from scipy.stats import norm, t

    half = 0.5 * (1.0 + confidence)
    return float(t.ppf(half, degrees) if degrees > 0 else norm.ppf(half))
