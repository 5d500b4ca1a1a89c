"""The most probable failure: the point of the limit nearest to the median, in standard normal space.

Hasofer and Lind's search with the line search of Zhang and Der Kiureghian: the step is halved until the merit
0.5 |u|^2 + c |g| decreases.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ropeway.components.errors import DesignPointError
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.studies.uncertainty.limit_state import LimitState

_STEPS = 60
_HALVINGS = 10
_NEAR = 1e-5
"""Largest distance of the design point from the limit, in standard deviations."""
_ALONG = 1e-3
"""Largest distance from the gradient's line, relative to the reliability index, which it changes by its square."""
_BESIDE = 0.05
"""Distance for differences of the gradient."""


@dataclass(frozen=True)
class DesignPoint:
    """A point u (n,) with g and its gradient; `solves` counts the evaluations."""

    u: np.ndarray
    g: float
    gradient: np.ndarray
    solves: int = 1

    @property
    def steepness(self) -> float:
        """Norm of the gradient."""
        return float(np.linalg.norm(self.gradient))

    @property
    def direction(self) -> np.ndarray:
        """Unit vector towards failure."""
        return -self.gradient / self.steepness

    @property
    def index(self) -> float:
        """Reliability index; negative if the median is beyond the limit."""
        return float(self.direction @ self.u)

    @property
    def found(self) -> bool:
        """Whether it is on the limit, and nearest to the median."""
        aside = np.linalg.norm(self.u - self.index * self.direction)
        return bool(abs(self.g) <= _NEAR * self.steepness and aside <= _ALONG * max(1.0, abs(self.index)))


def design_point(state: LimitState) -> DesignPoint:
    """The design point of a limit. Raises DesignPointError."""
    zero = np.zeros(len(state.inputs.names))
    point = DesignPoint(zero, *state.at(zero))
    for _ in range(_STEPS):
        stop_if_interrupted()
        if not np.isfinite(point.steepness) or point.steepness < 1e-12 * max(abs(point.g), 1e-300):
            raise DesignPointError(
                f"The result does not change with the inputs at {np.linalg.norm(point.u):.3g} standard deviations from "
                "their medians",
                "Name inputs that it depends on; where it is flat, or never passes the limit, sweep cases and use "
                "rw.exceedance",
            )
        if point.found:
            return point
        point = _step(state, point)
    raise _not_converged(point)


def _step(state: LimitState, point: DesignPoint) -> DesignPoint:
    """The next point, the step halved until the merit decreases. Raises DesignPointError."""
    target = (point.index + point.g / point.steepness) * point.direction
    weight = 2.0 * float(np.linalg.norm(point.u)) / point.steepness
    if abs(point.g) > _NEAR * point.steepness:
        weight = max(weight, float(target @ target) / abs(point.g))
    before = _merit(point, weight)
    failure = _not_converged(point)
    for k in range(_HALVINGS):
        u = point.u + 0.5**k * (target - point.u)
        try:
            tried = DesignPoint(u, *state.at(u), point.solves + k + 1)
        except DesignPointError as error:
            failure = error
            continue
        if tried.found or _merit(tried, weight) < before:
            return tried
        failure = _not_converged(point)
    raise failure


def _not_converged(point: DesignPoint) -> DesignPointError:
    return DesignPointError(
        f"The search has not converged; its last point is {np.linalg.norm(point.u):.3g} standard deviations from the "
        f"median and misses the limit by {abs(point.g):.3g}",
        "The limit is not smooth there, or never reached: sweep cases of the inputs, and use rw.exceedance",
    )


def _merit(point: DesignPoint, weight: float) -> float:
    return 0.5 * float(point.u @ point.u) + weight * abs(point.g)


def second_order(state: LimitState, point: DesignPoint) -> float:
    """The probability with the curvature of the limit at the design point, after Hohenbichler and Rackwitz; NaN if the
    curvature is too strong. Raises DesignPointError where the study fails beside that point."""
    from scipy.special import ndtr
    from scipy.stats import norm

    count = len(point.u)
    hessian = np.empty((count, count))
    for i, step in enumerate(_BESIDE * np.eye(count)):
        hessian[i] = (state.at(point.u + step)[1] - state.at(point.u - step)[1]) / (2.0 * _BESIDE)
    # An orthonormal basis whose first vector is the direction of failure; the others span the tangent plane.
    plane = np.linalg.qr(np.column_stack([point.direction, np.eye(count)]))[0][:, 1:count]
    curvatures = np.linalg.eigvalsh(plane.T @ (0.5 * (hessian + hessian.T)) @ plane) / point.steepness
    factors = 1.0 + curvatures * norm.pdf(point.index) / ndtr(-point.index)
    return float(ndtr(-point.index) / np.sqrt(np.prod(factors))) if np.all(factors > 0.0) else np.nan
