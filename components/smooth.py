"""Smooth switches on symbols and numbers."""

from __future__ import annotations

from typing import Any

from ropeway.components.catenary import Vector, namespace


def sign(x: Any, width: float) -> Any:
    """Sign of x, smooth within `width` of zero."""
    return namespace(x).tanh(x / width)


def angle_between(a: Vector, b: Vector) -> Any:
    """Angle between two vectors [rad], 0 to pi, accurate for small angles; differentiable at 0."""
    xp = namespace(*a, *b)
    cx, cy, cz = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    tiny = 1e-30 * (a[0] ** 2 + a[1] ** 2 + a[2] ** 2) * (b[0] ** 2 + b[1] ** 2 + b[2] ** 2)
    return xp.atan2(xp.sqrt(cx * cx + cy * cy + cz * cz + tiny), dot)


def size(force: Vector) -> Any:
    """Magnitude of a force that may be zero, with a defined derivative."""
    return namespace(*force).sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2 + 1e-60) - 1e-30


def clip_above(x: Any, limit: Any, corner: float = 0.02) -> Any:
    """The smaller of x and a positive limit, smooth.

    Exactly x below (1 - corner) * limit, exactly the limit above (1 + corner) * limit; between them a parabola with
    continuous slope that never exceeds the limit.
    """
    xp = namespace(x, limit)
    start, width = (1.0 - corner) * limit, 2.0 * corner * limit
    s = xp.fmin(xp.fmax((x - start) / width, 0.0), 1.0)
    return xp.fmin(x, start) + width * (s - s * s / 2.0)


def clip(x: Any, low: Any, high: Any, corner: float = 0.02) -> Any:
    """x limited to -low and high, both positive, with the corners of `clip_above`."""
    return -clip_above(-clip_above(x, high, corner), low, corner)
