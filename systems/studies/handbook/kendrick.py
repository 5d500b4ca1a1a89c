"""Kendrick's improved rigid link: weight and centroid of a catenary piece by iteration.

Kendrick (1992) in Harvey (2013), eq. 10-24. The source does not define r in eq. 17. With r = R the iteration converges
to the exact catenary (taut branch). Harvey rejected the method because it gave a piece as long as its chord. That
result is correct: the piece is 1.4 mm longer.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ropeway.systems.studies.handbook.array_roots import Array, Numbers
from ropeway.systems.studies.handbook.inextensible_catenary import length_between


class Weighed(NamedTuple):
    """Weight of a rope piece and the horizontal distance of its centroid from the far (lower) end [m]."""

    weight: Any
    arm: Any


class Kendrick(NamedTuple):
    """Result of Kendrick's iteration: parameter m [m], length s [m], weight R, arm e [m] from the lower node,
    H, V at the upper and the lower node, and the number of iterations."""

    parameter: Array
    length: Array
    weight: Array
    arm: Array
    horizontal: Array
    vertical_upper: Array
    vertical_lower: Array
    iterations: int


def weighed(span: Numbers, drop: Numbers, weight: Numbers, horizontal: Numbers) -> Weighed:
    """R = w s and e of a catenary piece whose far end is `drop` lower (Harvey eq. 19-21).

    e = d/2 - (h/s)(m - (d/2) coth(d/2m)), in a form that does not cancel for taut pieces.
    """
    m = np.asarray(horizontal) / np.asarray(weight)
    u = np.asarray(span) / (2.0 * m)
    s = length_between(u, span, drop)
    return Weighed(weight * s, np.asarray(span) / 2.0 + drop / s * m * _u_coth_less_one(u))


def kendrick_iteration(
    span: Numbers, drop: Numbers, weight: Numbers, tension: Numbers, *, r: float | None = None
) -> Kendrick:
    """Kendrick's iteration (Harvey eq. 15-24) for the tension at the upper node, the other `drop` lower.

    `r` is the undefined r of eq. 17: None for R (correct), 1 for Harvey's trial. The result is exact with R, after 3 to
    8 iterations for a taut piece, about 50 at 1 % above the least tension. NaN where the iteration does not converge.
    """
    d, h, w, t = (np.asarray(v, dtype=float) for v in (span, drop, weight, tension))
    piece = Weighed(w * np.hypot(d, h), d / 2.0)  # eq. 4 and 1
    a = 1.0 + np.square(h / d)
    m, change, iterations = np.full(np.broadcast(d, h, w, t).shape, np.nan), np.array(np.inf), 0
    with np.errstate(all="ignore"):
        for iterations in range(1, 501):
            b = 2.0 * piece.weight * h * piece.arm / d**2
            c = np.square((piece.weight if r is None else r) * piece.arm / d) - t**2  # eq. 17
            before, m = m, (-b + np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a * w)  # eq. 18, + only
            piece = weighed(d, h, w, w * m)
            change = np.abs(m / before - 1.0)
            if iterations > 2 and not np.any(change > 1e-14):
                break
    m = np.where((change < 1e-10) & (m > 0.0), m, np.nan)
    horizontal = w * m
    upper = np.sqrt(t * t - horizontal * horizontal)
    return Kendrick(m, piece.weight / w, piece.weight, piece.arm, horizontal, upper, upper - piece.weight, iterations)


def _u_coth_less_one(u: Any) -> Any:
    small = np.abs(u) < 0.05
    v = np.where(small, 1.0, u)
    return np.where(small, u**2 / 3.0 - u**4 / 45.0 + 2.0 * u**6 / 945.0, v / np.tanh(v) - 1.0)
