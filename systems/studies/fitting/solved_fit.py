"""From the least-squares solution to the result of a fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ropeway.systems.results.column_labels import Labels
from ropeway.systems.studies.fitting.fit_data import quantile
from ropeway.systems.studies.fitting.fit_result import Fit
from ropeway.systems.studies.fitting.information import identified, suggestions, usual_sigmas
from ropeway.systems.studies.fitting.least_squares import Problem, Solution

_FAR = 4.0
"""Residual over its standard deviation from which a measured value is called far off."""


def fit_of(problem: Problem, solution: Solution, declared: np.ndarray, units: Sequence[str], known_sigma: bool) -> Fit:
    """The result of a solution."""
    observations, prior = problem.observations, problem.prior
    names, table = list(observations.free), observations.measured
    found = identified(solution.jacobian, prior.scale, solution.variance, names, units)
    error = np.sqrt(np.diag(found.covariance))
    degrees = solution.count + len(problem.known) - len(names)
    wide = quantile(0.95, 0 if known_sigma else degrees) * error
    columns = {
        "value": solution.fitted,
        "standard_error": error,
        "low": solution.fitted - wide,
        "high": solution.fitted + wide,
        "declared": declared,
        "unit": list(units),
    }
    frame = pd.DataFrame(columns, index=pd.Index(names, name="quantity"))
    frame.attrs["degrees"] = 0 if known_sigma else degrees
    labels = [column.name for column in table.columns]
    rows = pd.Index(table.rows, name="row") if table.time is None else pd.Index(table.time, name="time")
    spread = np.full(table.cells.shape, np.nan)
    spread[problem.there] = problem.sigma * np.sqrt(solution.variance)
    measured, predicted, sigma = (
        _frame(values, rows, labels, [column.unit for column in table.columns])
        for values in (table.cells, solution.prediction.shown, spread)
    )
    sigmas = usual_sigmas([column.unit for column in table.columns], spread)
    more = suggestions(observations, solution.prediction, found.fisher, prior.scale, sigmas)
    notes = tuple(_notes(problem, solution, names))
    covariance = pd.DataFrame(found.covariance, index=names, columns=names)
    return Fit(
        observations.source.name, frame, covariance, measured, predicted, sigma, found.combinations, notes, degrees,
        more,
    )  # fmt: skip


def _frame(values: np.ndarray, rows: pd.Index, columns: Sequence[str], units: Sequence[str]) -> pd.DataFrame:
    frame = pd.DataFrame(values, index=rows, columns=list(columns))
    frame.attrs["units"] = Labels(zip(columns, units, strict=True))
    return frame


def _notes(problem: Problem, solution: Solution, names: Sequence[str]) -> list[str]:
    """What the user should know of the table and of the solution."""
    table, prior = problem.observations.measured, problem.prior
    notes = []
    if table.dropped:
        notes.append(f"{table.dropped} rows are left out, as a given value is blank")
    if table.blank:
        notes.append(f"{table.blank} blank cells are skipped")
    near = 1e-6 * prior.scale
    at_bound = (solution.fitted - prior.low <= near) | (prior.high - solution.fitted <= near)
    notes += [f"{name} is at a bound" for name, at in zip(names, at_bound, strict=True) if at]
    spread = np.sqrt(solution.variance) if np.isfinite(solution.variance) and solution.variance > 0.0 else 1.0
    far = np.abs(solution.residuals[: solution.count]) > _FAR * spread
    if far.any():
        rows, columns = np.nonzero(problem.there)
        first = int(np.flatnonzero(far)[0])
        where = f"row {table.rows[rows[first]] + 1} of column {table.columns[columns[first]].name!r}"
        notes.append(
            f"{int(far.sum())} measured values are more than {_FAR:g} standard deviations off, first in {where}"
        )
    return notes
