"""Limits as text, rounded to the safe side: payloads and working loads down, tensions up."""

from __future__ import annotations

import math
from collections.abc import Callable

NOISE = 1e-9
"""Relative error of a computed value, which must not change the rounded digit."""


def at_most(value: float, places: int = 0) -> str:
    """An upper limit (payload, safe working load, clearance), rounded down."""
    return _text(math.floor, value, places, 1.0)


def at_least(value: float, places: int = 0) -> str:
    """A value that must not be underestimated (tension, anchor force), rounded up."""
    return _text(math.ceil, value, places, -1.0)


def _text(whole: Callable[[float], int], value: float, places: int, noise: float) -> str:
    if not math.isfinite(value):
        return f"{value}"
    scaled = value * 10.0**places
    return f"{whole(scaled + noise * NOISE * max(abs(scaled), 1.0)) / 10.0**places:.{places}f}"
