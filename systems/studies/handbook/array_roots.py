"""Roots of one equation in one unknown, element by element for arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ropeway.components.annotation_checks import Array as Array, Numbers as Numbers

_STEP = 1e-30  # complex step: derivatives to rounding


def complex_step(function: Callable[[Any], Any]) -> Callable[[Array], tuple[Any, Any]]:
    """Value and derivative, exact to rounding, of an analytic function that takes complex arrays."""

    def value_and_derivative(x: Array) -> tuple[Any, Any]:
        value = function(x + 1j * _STEP)
        return value.real, value.imag / _STEP

    return value_and_derivative


def newton(function: Callable[[Array], tuple[Any, Any]], start: Numbers, *, scale: float | None = None) -> Array:
    """Undamped Newton's method, element by element, for a function that returns its value and derivative.

    It suits convex functions with a start on the steep side of the root, where every step approaches the root. `scale`
    is the reference of the step tolerance, by default the unknown itself. NaN where the method does not converge.
    """
    x = np.array(start, dtype=float)
    size, error, finished = np.abs(x), np.full(x.shape, np.inf), np.zeros(x.shape, dtype=bool)
    with np.errstate(all="ignore"):
        for _ in range(100):
            value, slope = function(x)
            step = -value / slope
            x = x + step
            before, error, size = error, np.abs(step), np.abs(x) if scale is None else np.full(x.shape, scale)
            # converged to rounding, or no longer improving; NaN ends too
            finished |= (error <= 1e-15 * size) | ((error >= before) & (error <= 1e-9 * size)) | np.isnan(error)
            if finished.all():
                break
        return np.where(error <= 1e-9 * size, x, np.nan)[()]


def rising(function: Callable[[Array], Any], low: Numbers, high: Numbers) -> Array:
    """Root of an increasing function between `low` and `high`, element by element: false position after Anderson and
    Björck, with a bisection every fourth step. A NaN of the function counts as below the root. The result is NaN where
    the bracket has no root.
    """
    a, b = (np.array(v, dtype=float) for v in np.broadcast_arrays(low, high))
    with np.errstate(all="ignore"):
        fa, fb = _value(function, a), _value(function, b)
        scale = np.abs(fb)
        found = (fa <= 0.0) & (fb >= 0.0)
        for k in range(200):
            x = a + (b - a) * (np.where(np.isfinite(fa), fa / (fa - fb), 0.5) if k % 4 < 3 else 0.5)
            f = _value(function, x)
            f = np.where(np.abs(f) <= 4e-15 * scale, 0.0, f)
            low_side, high_side = f <= 0.0, f >= 0.0
            weight_a, weight_b = 1.0 - f / fb, 1.0 - f / fa
            fa = np.where(low_side, f, fa * np.where(weight_a > 0.0, weight_a, 0.5))
            fb = np.where(high_side, f, fb * np.where(weight_b > 0.0, weight_b, 0.5))
            a, b = np.where(low_side, x, a), np.where(high_side, x, b)
            if not np.any(found & (b - a > 4e-16 * np.abs(b))):
                break
        return np.where(found & (np.abs(_value(function, b)) <= 1e-9 * scale), b, np.nan)[()]


def _value(function: Callable[[Array], Any], x: Array) -> Array:
    f = np.asarray(function(x), dtype=float)
    return np.where(np.isnan(f), -np.inf, f)
