"""Values between two times, by the cubic polynomial through the values and rates at both."""

from __future__ import annotations

import numpy as np


def between(
    start: np.ndarray, rate: np.ndarray, end: np.ndarray, end_rate: np.ndarray, h: float, part: float | np.ndarray
) -> np.ndarray:
    """Values at a `part`, 0 to 1, of the h seconds from `start` to `end`; rates are per second."""
    moved = end - start
    bends = (1.0 - part) * (h * rate - moved) + part * (moved - h * end_rate)
    return np.asarray(start + part * moved + part * (1.0 - part) * bends)
