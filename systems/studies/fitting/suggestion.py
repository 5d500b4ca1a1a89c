"""The measurement that would help most: candidates ranked by what they add to the Fisher information."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
import pandas as pd

from ropeway.components.errors import UnknownNameError
from ropeway.systems.studies.fitting.observations import Observations, Prediction

_USUAL = {"N": 500.0, "m": 0.05, "Pa": 1e5, "rad": 2e-3, "kg": 10.0, "%": 0.05}
"""Standard deviations of usual devices, by unit, where the table has no column of that unit."""
_SHOWN = 12
"""Number of suggestions that are listed."""


class Suggestions(NamedTuple):
    """The best candidates, and the best one in words."""

    frame: pd.DataFrame
    text: str


def suggestions(
    observations: Observations,
    prediction: Prediction,
    fisher: np.ndarray,
    scale: np.ndarray,
    sigma: Mapping[str, float],
) -> Suggestions:
    """Candidates in the order of what one more measurement adds; `fisher` (free, free) by changes of the usual size.
    `sigma`: standard deviations by unit."""
    free = len(observations.free)
    information = fisher + np.eye(free)  # a usual change is what is known without any measurement
    covariance = np.linalg.inv(information)
    unit_of = cache(observations.source.unit)
    rows = list[tuple[str, int, str, float, float, np.ndarray]]()
    for s, state in enumerate(prediction.states):
        for name in observations.states.candidates(s):
            try:
                _, slope = observations.states.reading(s, name).at(state)
                unit = unit_of(name)
            except UnknownNameError:
                continue
            deviation = sigma.get(unit, _USUAL.get(unit, np.nan))
            rates = np.zeros(free)
            rates[observations.own] = slope[0]
            rates *= scale / deviation
            if np.isfinite(rates).all():
                gain = float(rates @ covariance @ rates)
                rows.append((name, s, unit, deviation, 0.5 * np.log1p(gain), rates))
    rows.sort(key=lambda row: -row[4])
    found = [_row(observations, covariance, *row) for row in rows[:_SHOWN]]
    columns = ["quantity", "state", "sigma", "unit", "gain", "helps", "error_falls_to"]
    frame = pd.DataFrame(found, columns=columns)
    if frame.empty or frame.loc[0, "gain"] < 1e-3:
        return Suggestions(frame, "No single measurement of these states would help")
    best = frame.iloc[0]
    text = (
        f"Measure {best['quantity']} ({best['state']}) with a standard deviation of {best['sigma']:g} {best['unit']}: "
        f"the standard error of {best['helps']} falls to {100.0 * best['error_falls_to']:.0f} %"
    )
    return Suggestions(frame, text)


def _row(
    observations: Observations,
    covariance: np.ndarray,
    name: str,
    state: int,
    unit: str,
    deviation: float,
    gain: float,
    rates: np.ndarray,
) -> tuple[str, str, float, str, float, str, float]:
    """A row of the frame: with the quantity whose standard error falls most, and its share that remains."""
    moved = covariance @ rates
    after = np.diag(covariance) - moved**2 / (1.0 + rates @ moved)
    share = np.sqrt(np.maximum(after, 0.0) / np.diag(covariance))
    best = int(np.argmin(share))
    return (
        name, observations.states.label(state), deviation, unit, gain, observations.free[best], float(share[best])
    )  # fmt: skip


def usual_sigmas(units: Sequence[str], sigma: np.ndarray) -> dict[str, float]:
    """Median standard deviation of the measured columns, by unit."""
    by_unit: dict[str, list[float]] = {}
    for unit, values in zip(units, sigma.T, strict=True):
        by_unit.setdefault(unit, []).append(float(np.median(values)))
    return {unit: float(np.median(values)) for unit, values in by_unit.items()}
