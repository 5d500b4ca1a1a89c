"""The inextensible catenary through two points, for a length, a horizontal tension, a sag or an end tension.

Harvey (2013), eq. 25-26 and "y = y_p cosh((x + x_p)/y_p)", corrected: the general curve is
y = y0 + a cosh((x - x0)/a) with the catenary parameter a = H/w; his Appendix 1 divides H by w times the span,
which draws the 300 kN rope of Figure 3 with a sag of 372 m instead of 0.82 m. Written with u = span/(2 a) and
beta = asinh(rise/(2 a sinh u)), so that nothing cancels for a taut rope.

Arguments are numbers or arrays. Weights and tensions are in any consistent unit of force.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, SlackRopeError
from ropeway.systems.studies.handbook.array_checks import finite, require, require_broadcast
from ropeway.systems.studies.handbook.array_roots import Array, Numbers, complex_step, newton


class EndForces(NamedTuple):
    """Forces of the rope at its ends, in the unit of weight times metres. Vertical ones are upward forces of the
    supports on the rope, negative where the rope leaves its support upwards."""

    horizontal: Array
    vertical_start: Array
    vertical_end: Array
    tension_start: Array
    tension_end: Array


@checked
@dataclass(frozen=True, eq=False, slots=True)
class CatenaryCurve:
    """The catenary from (0, 0) to (span, rise), z up.

    Parameters
    ----------
    span : float or array
        Horizontal distance between the ends, above zero [m].
    rise : float or array
        Height of the end above the start [m].
    parameter : float or array
        Catenary parameter a = H/w, above zero [m].

    Raises
    ------
    InputError
        A value is out of range, or arrays do not broadcast.

    Examples
    --------
    >>> round(float(rw.CatenaryCurve(100.0, 0.0, 250.0).length), 3)
    100.668
    """

    span: Numbers
    rise: Numbers
    parameter: Numbers

    def __post_init__(self) -> None:
        for field in ("span", "rise", "parameter"):
            object.__setattr__(self, field, np.asarray(getattr(self, field), dtype=float))
        require(self.span, "span [m]", lambda v: v > 0.0, "above zero")
        require(self.rise, "rise [m]", np.isfinite, "finite")
        require_broadcast(self.span, self.rise, self.parameter)
        require(self.parameter, "catenary parameter H/w [m]", lambda v: v > 0.0, "above zero")

    @property
    def _u(self) -> Array:
        return np.asarray(self.span) / (2.0 * np.asarray(self.parameter))

    @property
    def _beta(self) -> Array:
        return np.asarray(np.arcsinh(np.asarray(self.rise) / (2.0 * self.parameter * np.sinh(self._u))))

    @property
    def length(self) -> Array:
        """Length of the rope [m] (Harvey eq. 19)."""
        return length_between(self._u, self.span, self.rise)

    @property
    def lowest(self) -> Array:
        """x of the curve's lowest point [m]; it may lie outside the span."""
        return np.asarray(self.span) / 2.0 - np.asarray(self.parameter) * self._beta

    def height(self, x: Numbers) -> Array:
        """Height of the rope above its start.

        Parameters
        ----------
        x : float or array
            Horizontal distance from the start [m].

        Returns
        -------
        array
            z relative to the start [m].
        """
        return finite(_height(self._u, self.span, self.rise, np.asarray(x)), "height")

    def slope(self, x: Numbers) -> Array:
        """Slope of the rope.

        Parameters
        ----------
        x : float or array
            Horizontal distance from the start [m].

        Returns
        -------
        array
            Rise over run.
        """
        return finite(np.sinh(np.asarray(x) / self.parameter - self._u + self._beta), "slope")

    def station(self, slope: Numbers) -> Array:
        """Station at which the rope has a given slope.

        Parameters
        ----------
        slope : float or array
            Rise over run.

        Returns
        -------
        array
            Horizontal distance from the start [m]; it may lie outside the span.
        """
        return finite(self.lowest + self.parameter * np.arcsinh(slope), "station")

    def sag(self, x: Numbers) -> Array:
        """Vertical distance from the chord down to the rope.

        Parameters
        ----------
        x : float or array
            Horizontal distance from the start [m].

        Returns
        -------
        array
            Sag [m].
        """
        return np.asarray(self.rise) * np.asarray(x) / np.asarray(self.span) - self.height(x)

    def forces(self, weight: Numbers) -> EndForces:
        """End forces of the rope. Harvey's T = V/sin, H = V/tan of the end tangents.

        Parameters
        ----------
        weight : float or array
            Weight per metre, in any unit of force.

        Returns
        -------
        EndForces
            Horizontal tension, vertical forces of the supports and tensions at both ends.
        """
        horizontal = np.asarray(self.parameter) * np.asarray(weight)
        start, end = self.slope(0.0), self.slope(self.span)
        return EndForces(
            horizontal,
            -horizontal * start,
            horizontal * end,
            horizontal * np.hypot(1, start),
            horizontal * np.hypot(1, end),
        )


@checked
def catenary_for_horizontal(span: Numbers, rise: Numbers, horizontal: Numbers, weight: Numbers) -> CatenaryCurve:
    """The catenary for a horizontal tension.

    Parameters
    ----------
    span : float or array
        Horizontal distance between the ends [m].
    rise : float or array
        Height of the end above the start [m].
    horizontal : float or array
        Horizontal tension, in any unit of force.
    weight : float or array
        Weight per metre, in the same unit.

    Returns
    -------
    CatenaryCurve
        The catenary with parameter horizontal/weight.

    Raises
    ------
    InputError
        A value is not above zero, or arrays do not broadcast.

    Examples
    --------
    >>> float(rw.catenary_for_horizontal(100.0, 0.0, 5000.0, 20.0).parameter)
    250.0
    """
    require_broadcast(span, rise, horizontal, weight)
    require(horizontal, "horizontal tension", lambda v: v > 0.0, "above zero")
    require(weight, "weight per metre", lambda v: v > 0.0, "above zero")
    return CatenaryCurve(span, rise, np.asarray(horizontal) / np.asarray(weight))


@checked
def catenary_for_length(span: Numbers, rise: Numbers, length: Numbers) -> CatenaryCurve:
    """The catenary for a rope length (Harvey, Appendix 2: 2 sinh(sigma d/2)/sigma = sqrt(s^2 - h^2)).

    Parameters
    ----------
    span : float or array
        Horizontal distance between the ends [m].
    rise : float or array
        Height of the end above the start [m].
    length : float or array
        Length of the rope [m].

    Returns
    -------
    CatenaryCurve
        The catenary with that length.

    Raises
    ------
    InputError
        The rope is not longer than its chord. (Harvey's code returns the chord.)

    Examples
    --------
    >>> round(float(rw.catenary_for_length(100.0, 0.0, 101.0).parameter), 2)
    204.43
    """
    require_broadcast(span, rise, length)
    d, h, s = (np.asarray(v, dtype=float) for v in (span, rise, length))
    require(d, "span [m]", lambda v: v > 0.0, "above zero")
    chord = np.hypot(d, h)
    if np.any(~(s > chord)):
        raise InputError(f"A rope of {s} m is not longer than its chord of {chord} m", "Give a longer rope")
    # log(sinh u/u) = log sqrt(s^2 - h^2)/d: convex in log u, its root below the start
    excess = np.log1p((s - chord) * (s + chord) / d**2) / 2.0
    start = np.minimum(np.sqrt(6.0 * excess), excess + np.log(2.0 + 2.0 * excess)) + excess
    u = newton(complex_step(lambda u: _log_sinhc(u) - excess), start)
    return CatenaryCurve(span, rise, d / (2.0 * u))


@checked
def catenary_for_sag(span: Numbers, rise: Numbers, sag: Numbers, at: Numbers = 0.5) -> CatenaryCurve:
    """The catenary for a sag below its chord.

    Parameters
    ----------
    span : float or array
        Horizontal distance between the ends [m].
    rise : float or array
        Height of the end above the start [m].
    sag : float or array
        Sag below the chord [m].
    at : float or array, default 0.5
        Position of the sag as a share of the span, between 0 and 1.

    Returns
    -------
    CatenaryCurve
        The catenary with that sag.

    Raises
    ------
    InputError
        A value is out of range, or arrays do not broadcast.

    Examples
    --------
    >>> round(float(rw.catenary_for_sag(100.0, 0.0, 5.0).parameter), 2)
    250.83
    """
    require_broadcast(span, rise, sag, at)
    require(span, "span [m]", lambda v: v > 0.0, "above zero")
    require(sag, "sag [m]", lambda v: v > 0.0, "above zero")
    require(at, "station of the sag, share of the span,", lambda v: (v > 0.0) & (v < 1.0), "between 0 and 1")
    d, h, y, c = (np.asarray(v, dtype=float) for v in (span, rise, sag, at))
    x = c * d
    # The parabola's u is too large: the sag grows faster than u. log(sag) over log(u) is close to a line.
    start = y / (c * (1.0 - c) * np.hypot(d, h))
    log_u = newton(complex_step(lambda v: np.log((h * c - _height(np.exp(v), d, h, x)) / y)), np.log(start), scale=1.0)
    return CatenaryCurve(span, rise, d / (2.0 * np.exp(log_u)))


@checked
def catenary_for_tension(span: Numbers, rise: Numbers, tension: Numbers, weight: Numbers) -> CatenaryCurve:
    """The catenary for a tension at its start: the taut one of the two solutions.

    Parameters
    ----------
    span : float or array
        Horizontal distance between the ends [m].
    rise : float or array
        Height of the end above the start [m].
    tension : float or array
        Tension at the start, in any unit of force.
    weight : float or array
        Weight per metre, in the same unit.

    Returns
    -------
    CatenaryCurve
        The taut catenary.

    Raises
    ------
    InputError
        A value is not above zero, or arrays do not broadcast.
    SlackRopeError
        The tension is too low for the rope's own weight.

    Examples
    --------
    >>> round(float(rw.catenary_for_tension(100.0, 0.0, 5000.0, 20.0).parameter), 2)
    244.88
    """
    require_broadcast(span, rise, tension, weight)
    require(span, "span [m]", lambda v: v > 0.0, "above zero")
    require(tension, "tension", lambda v: v > 0.0, "above zero")
    require(weight, "weight per metre", lambda v: v > 0.0, "above zero")
    u = taut_u(span, -np.asarray(rise, dtype=float), tension, weight)
    if np.isnan(u).any():
        raise too_little(span, rise, tension, weight, np.isnan(u))
    return CatenaryCurve(span, rise, np.asarray(span) / (2.0 * u))


def minimum_tension(span: float, rise: float, weight: float) -> float:
    """The least possible tension at the start of a rope from (0, 0) to (span, rise) under its own weight."""
    best = minimize_scalar(lambda v: float(_start_tension(np.exp(v), span, -rise)), bounds=(-20.0, 5.0))
    return weight * float(best.fun)


def taut_u(span: Numbers, drop: Numbers, tension: Numbers, weight: Numbers) -> Array:
    """u = w span/(2 H) of the taut catenary with a tension at its start, its end `drop` lower; NaN where the tension is
    too low for the rope's own weight.

    T = (w/2)(s coth u + drop), a convex function of 1/u: Newton's method from H = T cos(chord), which is never too low,
    decreases to the taut root without overshoot.
    """
    d, h, t, w = (np.asarray(v, dtype=float) for v in (span, drop, tension, weight))
    upper_tension = t + w * np.maximum(-h, 0.0)  # T at the upper end

    def residual(q: Array) -> tuple[Array, Array]:
        u, p = 1.0 / q, q * np.sinh(1.0 / q)
        cosh, s = np.cosh(u), np.sqrt(h * h + d * d * p * p)
        coth = q * cosh / p
        slope = d * d * p * (cosh - p) * q / s * coth - s / (u * p) ** 2
        return (s * coth + h) / 2.0 - t / w, -u * u * slope / 2.0

    inverse = newton(residual, 2.0 * upper_tension / (w * np.hypot(d, h)))
    return np.where(inverse > 0.0, 1.0 / inverse, np.nan)


def length_between(u: Any, span: Numbers, rise: Numbers) -> Any:
    """Length [m] of a catenary of u = span/(2a): sqrt(rise^2 + (span sinh(u)/u)^2) (Harvey eq. 19)."""
    return np.sqrt(np.square(rise) + np.square(span * np.sinh(u) / u))


def vertical_at(u: Any, span: Numbers, drop: Numbers, weight: Numbers) -> Any:
    """Upward force of the support on the start of a catenary whose end is `drop` lower:
    (w/2)(drop coth u + s). The support at its end carries the rest of w s."""
    return np.asarray(weight) / 2.0 * (drop / np.tanh(u) + length_between(u, span, drop))


def too_little(span: Numbers, rise: Numbers, tension: Numbers, weight: Numbers, bad: Array) -> SlackRopeError:
    """The error of the first element of `bad`, whose tension at the start is too low."""
    values = np.broadcast_arrays(span, rise, tension, weight, bad)
    d, h, t, w = (float(v[values[-1]].flat[0]) for v in values[:-1])
    return SlackRopeError(
        f"A tension of {t:.6g} is too low for the rope's own weight between supports {d:.6g} m apart "
        f"and {h:.6g} m different in height: it needs {minimum_tension(d, h, w):.6g}",
        "Raise the tension, or add a support between them",
    )


def _start_tension(u: Any, span: Numbers, drop: Numbers) -> Any:
    """T/w at the start of a catenary whose end is `drop` lower."""
    return (length_between(u, span, drop) / np.tanh(u) + drop) / 2.0


def _height(u: Any, span: Numbers, rise: Numbers, x: Numbers) -> Any:
    beta = np.arcsinh(rise * u / (span * np.sinh(u)))
    half = u * x / span
    return span / u * np.sinh(half) * np.sinh(half - u + beta)


def _log_sinhc(u: Any) -> Any:
    small = np.abs(u) < 0.05
    v = np.where(small, 1.0, u)
    return np.where(small, u**2 / 6.0 - u**4 / 180.0 + u**6 / 2835.0, np.log(np.sinh(v) / v))
