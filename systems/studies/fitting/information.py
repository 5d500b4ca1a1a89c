"""What measured values tell of the free quantities: covariance, combinations that they do not determine, and the
measurement that would help most."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.linalg import qr

from ropeway.components.annotation_checks import Unbounded
from ropeway.components.argument_checks import checked
from ropeway.components.errors import UnknownNameError
from ropeway.systems.studies.fitting.observations import Observations, Prediction

_DEPENDENT = 1e-8
"""Singular value, relative to the largest one, below which a combination changes nothing that is measured."""
_WEAK = 0.5
"""Usual change over the standard deviation of a combination, below which it is called unidentifiable."""
_TAKES_PART = 1e-4
"""Share of a quantity in an unidentifiable combination from which it has no standard error."""
_SHOWN = 5e-3
"""Share from which a quantity is named in a combination."""
_USUAL = {"N": 500.0, "m": 0.05, "Pa": 1e5, "rad": 2e-3, "kg": 10.0, "%": 0.05, "s": 0.05}
"""Standard deviations of usual devices, by unit, where the table has no column of that unit."""
_LISTED = 12
"""Number of suggestions that are listed."""


@checked
@dataclass(frozen=True)
class Combination:
    """Changes of free quantities that together change what is measured by nothing, or by less than its noise.

    Attributes
    ----------
    changes : dict of str to float
        Change of each quantity that has a part in it, in its SI unit; by one unit of the first.
    units : dict of str to str
        Their units.
    standard_deviation : float
        Of the change of the first quantity along this combination; inf where nothing that is measured changes.

    Examples
    --------
    >>> rw.Combination({"a_b.length": 1.0}, {"a_b.length": "m"}, float("inf")).standard_deviation
    inf
    """

    changes: Mapping[str, float]
    units: Mapping[str, str]
    standard_deviation: Unbounded

    def __str__(self) -> str:
        parts = [
            f"{name} {change:+.4g}{'' if self.units[name] in ('', '1') else ' ' + self.units[name]}"
            for name, change in self.changes.items()
        ]
        return ", ".join(parts)


@dataclass(frozen=True)
class Identified:
    """`covariance` (free, free) in SI units, with infinite variance and NaN beside it for quantities that take part in
    a combination which changes nothing; the unidentifiable `combinations`; `fisher` (free, free) by usual changes."""

    covariance: np.ndarray
    combinations: tuple[Combination, ...]
    fisher: np.ndarray


def identified(
    jacobian: np.ndarray, scale: np.ndarray, variance: float, names: Sequence[str], units: Sequence[str]
) -> Identified:
    """What a Jacobian (residuals, free) of normalised residuals determines; `scale` (free,): usual changes.

    A combination is unidentifiable if it changes nothing that is measured, or if its standard deviation is above twice
    its usual change.
    """
    scaled = jacobian * scale
    _, singular, rows = np.linalg.svd(scaled, full_matrices=True)
    values = np.zeros(len(names))
    values[: len(singular)] = singular
    spread = np.sqrt(variance) if np.isfinite(variance) else 1.0
    lost = values <= _DEPENDENT * max(values.max(initial=0.0), 1e-300)
    weak = ~lost & (values < _WEAK * spread)
    good = rows[~lost].T / values[~lost]
    covariance = (good @ good.T) * variance * np.outer(scale, scale)
    takes_part = np.abs(rows[lost]).max(axis=0, initial=0.0) > _TAKES_PART
    covariance[takes_part] = covariance[:, takes_part] = np.nan
    covariance[takes_part, takes_part] = np.inf
    directions = [(direction, np.inf) for direction in _apart(rows[lost].T)]
    directions += [(row, spread / value) for row, value in zip(rows[weak], values[weak], strict=True)]
    found = tuple(_combination(direction, spread, scale, names, units) for direction, spread in directions)
    return Identified(covariance, found, scaled.T @ scaled / (spread**2 if spread > 0.0 else 1.0))


def _apart(null: np.ndarray) -> list[np.ndarray]:
    """Vectors that span a null space (free, lost), each with a quantity that is in no other one."""
    count = null.shape[1]
    if count == 0:
        return []
    pivots = qr(null.T, pivoting=True, mode="r")[1][:count]
    return list((null @ np.linalg.inv(null[pivots])).T)


def _combination(
    direction: np.ndarray, spread: float, scale: np.ndarray, names: Sequence[str], units: Sequence[str]
) -> Combination:
    """The combination of a direction (free,) of usual changes, along which the standard deviation is `spread`."""
    share = np.abs(direction) / np.abs(direction).max()
    order = sorted(np.flatnonzero(share > _SHOWN).tolist(), key=lambda j: (-round(share[j], 6), j))
    one = direction[order[0]] * scale[order[0]]
    changes = {names[j]: float(direction[j] * scale[j] / one) for j in order}
    return Combination(changes, {names[j]: units[j] for j in order}, float(spread * abs(one)))


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
    found = [_row(observations, covariance, *row) for row in rows[:_LISTED]]
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
