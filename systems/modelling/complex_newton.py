"""Newton's method for many small problems side by side, with derivatives by the complex step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

_STEP = 1e-30  # of the complex step: derivatives to rounding

CONVERGED = 1e-10
"""Relative step after which only rounding errors are left: convergence is quadratic."""

_ITERATIONS = 60


class Roots(NamedTuple):
    """Unknowns (n, k), the Jacobians of the last step (n, k, k), and the relative size of that step (n,). What is not
    a number has no root nearby."""

    unknowns: np.ndarray
    jacobians: np.ndarray
    steps: np.ndarray

    @property
    def converged(self) -> np.ndarray:
        """Which problems are solved, (n,)."""
        return np.asarray(self.steps <= CONVERGED)


def jacobians_of(residual: Callable[[Any], Any], unknowns: np.ndarray) -> np.ndarray:
    """The Jacobians (n, k, k) of n problems at unknowns (n, k)."""
    probe = 1j * _STEP * np.eye(unknowns.shape[-1])[:, None, :]
    return np.asarray((residual(unknowns + probe).imag / _STEP).transpose(1, 2, 0))


def solved_side_by_side(jacobians: np.ndarray, residuals: np.ndarray) -> np.ndarray:
    """Solutions (n, k) of n linear systems; NaN for those that are singular or not finite."""
    right = residuals[:, :, None]
    try:
        return np.asarray(np.linalg.solve(jacobians, right)[:, :, 0])
    except np.linalg.LinAlgError:  # one of them is singular
        singular = ~np.isfinite(jacobians).all(axis=(1, 2)) | (np.linalg.det(jacobians) == 0.0)
        solvable = np.where(singular[:, None, None], np.eye(jacobians.shape[-1]), jacobians)
        return np.asarray(np.where(singular[:, None], np.nan, np.linalg.solve(solvable, right)[:, :, 0]))


def solve_side_by_side(
    residual: Callable[[Any], Any],
    start: np.ndarray,
    relative_step: Callable[[np.ndarray, np.ndarray], np.ndarray],
    longest: float,
) -> Roots:
    """Roots of n problems in k unknowns each.

    residual: unknowns (..., n, k), real or complex, to residuals of the same shape; start: (n, k); relative_step:
    unknowns and a Newton step (n, k) to the size of that step (n,); longest: the largest relative step, above which
    steps are shortened.
    """
    unknowns = before = start
    with np.errstate(all="ignore"):
        for _ in range(_ITERATIONS):
            jacobians = jacobians_of(residual, unknowns)
            moves = -solved_side_by_side(jacobians, residual(unknowns))
            steps = relative_step(unknowns, moves)
            last, before = before, unknowns
            unknowns = unknowns + moves * np.minimum(1.0, longest / np.maximum(steps, 1e-300))[:, None]
            if not (steps > CONVERGED).any():
                break
            if steps.max() > 1e-3 and np.abs(unknowns / last - 1.0).max() < 1e-5:  # large steps alternate
                break
    return Roots(unknowns, jacobians, steps)
