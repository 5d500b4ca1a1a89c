"""The catenary of a span from angles to its supports and to points on its rope, measured from one place (PAPOTO)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import FitError, InputError
from ropeway.systems.studies.handbook.inextensible_catenary import CatenaryCurve

Sight = tuple[float, float]
"""Horizontal angle, clockwise, and angle from the zenith [rad]."""
_STARTS = 24
"""Directions of the span from which the solution is sought."""
_FLATTEST, _DEEPEST = 50.0, 0.3
"""Largest and smallest catenary parameter over the span."""
_MISS = 1e-3
"""Largest miss of a point [rad]."""


@checked
def catenary_for_sights(span: float, left: Sight, right: Sight, points: Sequence[Sight]) -> CatenaryCurve:
    """The catenary of a span by a theodolite at an unknown place.

    The place follows from the span and the angles; two points on the rope suffice, more are adjusted by least squares
    of their angles. The method is known as PAPOTO.

    Parameters
    ----------
    span : float
        Horizontal distance between the supports [m].
    left, right : (float, float)
        Horizontal angle, clockwise, and angle from the zenith to both supports [rad].
    points : sequence of (float, float), shape (n, 2)
        The same to points on the rope, two or more.

    Returns
    -------
    CatenaryCurve
        From the left support; its parameter is horizontal tension over weight per length [m].

    Raises
    ------
    InputError
        A span that is not positive, fewer than two points, or sights that are not to the side of the span.
    FitError
        No catenary goes through the points.

    Examples
    --------
    >>> gon = rw.units.GON
    >>> sights = [(0.0, 95.3282576), (165.9951044, 76.6693939), (4.0612736, 94.4241159), (15.2623372, 88.8639692)]
    >>> left, right, *points = [(h * gon, v * gon) for h, v in sights]
    >>> round(float(rw.catenary_for_sights(460.29627, left, right, points).parameter))
    2000
    """
    check.positive(span, "catenary_for_sights", "span", "m")
    if len(points) < 2:
        raise InputError(f"catenary_for_sights has {len(points)} points", "Sight two or more points on the rope")
    sights = np.array([left, right, *points], dtype=float)
    turn = np.mod(sights[1:, 0] - sights[0, 0] + np.pi, 2.0 * np.pi) - np.pi
    side, turn = np.sign(turn[0]), turn * np.sign(turn[0])
    if not side or not (1e-6 < turn[0] < np.pi - 1e-6) or not np.all((turn[1:] > 0.0) & (turn[1:] < turn[0])):
        raise InputError(
            "The sights do not lie between those to the two supports",
            "Stand beside the span, and give horizontal angles clockwise and angles from the zenith, in radians",
        )
    found = _solved(span, turn, 1.0 / np.tan(sights[:, 1]))
    return CatenaryCurve(span, found[0], found[1])


def _solved(span: float, turn: np.ndarray, slope: np.ndarray) -> tuple[float, float]:
    """Rise [m] and parameter [m] of the catenary. `turn` (1 + points,): angles from the left support to the right one
    and to the points; `slope` (2 + points,): rise over horizontal distance of all sights. Raises FitError."""
    from scipy.optimize import least_squares

    whole, to_points = turn[0], turn[1:]

    def place(at_left: float) -> tuple[float, float, np.ndarray, np.ndarray]:
        """Heights of the left and right supports, and of the points: place along the span and distance, for the
        angle of the triangle at the left support."""
        to_left = span * np.sin(at_left + whole) / np.sin(whole)
        to_right = span * np.sin(at_left) / np.sin(whole)
        beyond = np.sin(at_left + to_points)
        return (
            to_left * slope[0],
            to_right * slope[1],
            to_left * np.sin(to_points) / beyond,
            (to_left * np.sin(at_left) / beyond),
        )

    def misses(unknown: np.ndarray) -> np.ndarray:
        z_left, z_right, along, far = place(unknown[0])
        height = z_left + CatenaryCurve(span, z_right - z_left, span * np.exp(unknown[1])).height(along)
        return np.arctan(height / far) - np.arctan(slope[2:])

    best = None
    low, high = [1e-4, np.log(_DEEPEST)], [np.pi - whole - 1e-4, np.log(_FLATTEST)]
    for at_left in np.linspace(low[0], high[0], _STARTS + 2)[1:-1]:
        one = least_squares(misses, [at_left, np.log(4.0)], bounds=(low, high), xtol=1e-14, ftol=1e-14, gtol=1e-14)
        if best is None or one.cost < best.cost:
            best = one
    if best is None or np.abs(best.fun).max() > _MISS:
        raise FitError(
            "No catenary between the supports goes through the points",
            "Check the span and the angles, in radians from the zenith",
        )
    z_left, z_right, _, _ = place(best.x[0])
    return float(z_right - z_left), float(span * np.exp(best.x[1]))
