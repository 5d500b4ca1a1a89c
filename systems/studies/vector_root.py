"""Roots of one equation in one unknown, for whole arrays side by side."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_STEP = 1e-30  # complex step: derivatives to rounding


def newton(function: Callable[[NDArray[np.complex128]], NDArray[np.complex128]], start: ArrayLike) -> Array:
    """Undamped Newton's method, element by element, for an analytic function that takes complex arrays.

    Meant for convex functions and a start on the steep side of the root, from where it never overshoots twice.
    NaN where it does not converge.
    """
    x = np.array(start, dtype=float)
    error = np.full(x.shape, np.inf)
    with np.errstate(all="ignore"):
        for _ in range(100):
            value = function(x + 1j * _STEP)
            move = -value.real / (value.imag / _STEP)
            x = x + move
            smaller = np.abs(move) < error
            error = np.abs(move)
            if not np.any(smaller & (error > 1e-15 * np.abs(x))):
                break
    return np.where(error <= 1e-12 * np.abs(x), x, np.nan)


def bracketed(function: Callable[[Array], Array], low: ArrayLike, high: ArrayLike) -> Array:
    """Root of a rising function between `low` and `high`, element by element: the false position of Anderson
    and Björck, with bisection where it stalls. NaN of the function counts as below the root; NaN is returned
    where no root lies between.
    """
    a, b = (np.array(v, dtype=float) for v in np.broadcast_arrays(low, high))
    fa, fb = function(a), function(b)
    fa = np.where(np.isnan(fa), -np.inf, fa)
    found = (fa <= 0.0) & (fb >= 0.0)
    scale = np.abs(fb)
    with np.errstate(all="ignore"):
        for k in range(200):
            width = b - a
            secant = a + width * np.where(np.isfinite(fa) & (k % 4 < 3), -fa / (fb - fa), 0.5)
            x = np.where((secant >= a) & (secant <= b), secant, a + width / 2.0)
            f = function(x)
            f = np.where(np.isnan(f), -np.inf, f)
            up, down = f >= 0.0, f <= 0.0
            shrink_a, shrink_b = 1.0 - f / fb, 1.0 - f / fa
            fa_next = np.where(down, f, np.where(np.isfinite(fa), fa * np.where(shrink_a > 0.0, shrink_a, 0.5), fa))
            fb_next = np.where(up, f, fb * np.where(np.isfinite(shrink_b) & (shrink_b > 0.0), shrink_b, 0.5))
            a, b, fa, fb = np.where(down, x, a), np.where(up, x, b), fa_next, fb_next
            if not np.any(found & (b - a > 4e-16 * np.abs(b))):
                break
        root = np.asarray(b)
        rest = np.abs(function(root))
    return np.where(found & (rest <= 1e-9 * scale), root, np.nan)
