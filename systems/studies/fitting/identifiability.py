"""How well the free quantities are known: covariance, and combinations that the measured values do not determine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr

from ropeway.components.argument_checks import checked

_DEPENDENT = 1e-8
"""Singular value, relative to the largest one, below which a combination changes nothing that is measured."""
_WEAK = 0.5
"""Usual change over the standard deviation of a combination, below which it is called unidentifiable."""
_TAKES_PART = 1e-4
"""Share of a quantity in an unidentifiable combination from which it has no standard error."""
_SHOWN = 5e-3
"""Share from which a quantity is named in a combination."""


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
    """

    changes: Mapping[str, float]
    units: Mapping[str, str]
    standard_deviation: float

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
