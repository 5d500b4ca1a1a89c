"""The numbers of a fit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from scipy.special import ndtri, stdtrit

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.table_writer import Tabular
from ropeway.systems.studies.fitting.information import Combination, Suggestions


@checked
@dataclass(frozen=True, eq=False)
class FitData(Tabular):
    """The numbers of a fit. Fields as in `rw.Fit`."""

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


def quantile(confidence: float, degrees: int) -> float:
    """Half of a confidence interval over the standard error: normal where sigma is given (`degrees` 0), otherwise of
    Student's distribution."""
    half = 0.5 * (1.0 + confidence)
    return float(stdtrit(degrees, half) if degrees > 0 else ndtri(half))
