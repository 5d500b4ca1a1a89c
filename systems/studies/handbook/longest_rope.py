"""The longest rope that clears a terrain profile.

Harvey (2013), section 2.2.6 and Appendix 2, with exact values for his Table 3. He replaces the terrain by a polynomial
and compares nodes. Here the terrain is piecewise linear; the rope is tested at its vertices and, where it is parallel
to a piece of terrain, inside that piece.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, SlackRopeError
from ropeway.components.terrain import Profile
from ropeway.systems.studies.handbook.array_checks import require
from ropeway.systems.studies.handbook.array_roots import Array
from ropeway.systems.studies.handbook.inextensible_catenary import CatenaryCurve, EndForces


@dataclass(frozen=True, eq=False, slots=True)
class LongestRope:
    """A bare rope that just touches the clearance line, as `rw.longest_rope` returns it.

    `length` in m; `curve` relative to the left support; `touches`, the station of contact [m]; `start`, the left
    support (x, z) [m].
    """

    curve: CatenaryCurve
    start: tuple[float, float]
    touches: float

    @property
    def length(self) -> float:
        """Length of the rope [m]."""
        return float(self.curve.length)

    def height(self, x: ArrayLike) -> Array:
        """Elevation of the rope at stations x [m]."""
        return self.start[1] + self.curve.height(np.asarray(x) - self.start[0])

    def forces(self, weight: float) -> EndForces:
        """End forces for a weight per metre. The start is the left support."""
        return self.curve.forces(weight)


@checked
def longest_rope(
    stations: ArrayLike,
    elevations: ArrayLike,
    headspar: tuple[float, float],
    tailspar: tuple[float, float],
    *,
    clearance: float = 0.0,
) -> LongestRope:
    """The longest inextensible rope between two supports that clears a terrain.

    Parameters
    ----------
    stations : array_like
        Stations of the terrain [m], increasing, over the whole span. The terrain is straight between them.
    elevations : array_like
        Elevations of the terrain at these stations [m].
    headspar, tailspar : tuple of float
        Supports (x, z) [m].
    clearance : float, default 0.0
        Vertical clearance of the rope over the terrain [m].

    Returns
    -------
    LongestRope
        Length, curve and point of contact with the clearance line.

    Raises
    ------
    InputError
        The profile is invalid, or does not cover the span.
    SlackRopeError
        No rope clears the terrain.

    Examples
    --------
    >>> rope = rw.longest_rope([0.0, 100.0, 200.0], [0.0, -20.0, 0.0], (0.0, 10.0), (200.0, 10.0), clearance=2.0)
    >>> round(rope.length, 2), round(rope.touches, 2)
    (207.32, 142.64)
    """
    terrain = Profile(stations, elevations)
    x, z = terrain.station, terrain.elevation
    require(clearance, "clearance [m]", lambda v: v >= 0.0, "zero or more")
    (ax, az), (bx, bz) = sorted((float(p[0]), float(p[1])) for p in (headspar, tailspar))
    if not ax < bx:
        raise InputError(f"Both supports are at station {ax} m", "Give two different stations")
    if ax < x[0] or bx > x[-1]:
        raise InputError(
            f"The supports at {ax} m and {bx} m are not both on the profile, {x[0]} m to {x[-1]} m",
            "Extend the profile",
        )
    span, rise = bx - ax, bz - az
    inner = (x > ax) & (x < bx)
    at = np.concatenate([[0.0], x[inner] - ax, [span]])
    ground = np.interp(at + ax, x, z) + clearance - az
    slope = np.diff(ground) / np.diff(at)
    if ground[0] > 0.0 or ground[-1] > rise or np.any(ground[1:-1] >= rise * at[1:-1] / span):
        raise SlackRopeError(
            f"The terrain reaches the chord of the supports, or its clearance is below {clearance} m",
            "Raise the supports or reduce the clearance",
        )

    def nearest(log_u: float) -> tuple[float, float]:
        curve = CatenaryCurve(span, rise, span / (2.0 * np.exp(log_u)))
        tangent = curve.station(slope)
        place = np.concatenate([at[1:-1], np.clip(tangent, at[:-1], at[1:])])
        level = np.concatenate([ground[1:-1], ground[:-1] + slope * (place[len(at) - 2 :] - at[:-1])])
        inside = (place > 0.0) & (place < span)  # the ends of the rope are fixed
        gap = np.where(inside, curve.height(place) - level, np.inf)
        k = int(np.argmin(gap))
        return float(gap[k]), float(place[k])

    low, high = np.log(1e-9), np.log(1e-9)
    while nearest(high)[0] > 0.0 and high < np.log(200.0):
        low, high = high, high + 1.0
    if nearest(high)[0] > 0.0 or low == high:
        raise SlackRopeError("No rope just touches this terrain", "Check the profile and the supports")
    log_u = brentq(lambda v: nearest(v)[0], low, high, xtol=1e-15, rtol=4.0 * np.finfo(float).eps)
    return LongestRope(CatenaryCurve(span, rise, span / (2.0 * np.exp(log_u))), (ax, az), ax + nearest(log_u)[1])
