"""Limits as text, rounded to the safe side: what a rope may carry down, what it has to carry up."""

from __future__ import annotations

import math

NOISE = 1e-9
"""Relative error of a computed value, which must not carry it to the next digit."""


def at_most(value: float, places: int = 0) -> str:
    """A value that must not be taken for larger (a payload, a safe working load, a clearance), rounded down."""
    return _text(math.floor(_scaled(value, places, 1.0)), places)


def at_least(value: float, places: int = 0) -> str:
    """A value that must not be taken for smaller (a tension, a force on an anchor), rounded up."""
    return _text(math.ceil(_scaled(value, places, -1.0)), places)


def _scaled(value: float, places: int, sign: float) -> float:
    scaled = value * 10.0**places
    return scaled + sign * NOISE * max(abs(scaled), 1.0)


def _text(digits: int, places: int) -> str:
    return f"{digits / 10.0**places:.{places}f}"
