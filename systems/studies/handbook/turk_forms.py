"""The classic forms of the elastic cable after Turk (1988, chapter 2), corrected.

Irvine's in terms of the unstretched station s, Gonsior's in terms of the slope angle, Sinclair's dimensionless
recursion for a span with loads. All describe the same cable as `components.catenary`, which all other code uses because
its forms do not cancel. Equation numbers are Turk's; units of force and length are any consistent ones.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ropeway.components.errors import InputError
from ropeway.systems.studies.handbook.array_checks import require
from ropeway.systems.studies.handbook.array_roots import Array, Numbers


class CablePoint(NamedTuple):
    """Position relative to the start, and tension. z counts down with Irvine and Sinclair, up with Gonsior."""

    x: Array
    z: Array
    tension: Array


class GonsiorPiece(NamedTuple):
    """A piece between two slope angles, z up: run, rise, stretched and unstretched length."""

    x: Array
    z: Array
    length: Array
    unstretched: Array


class Substitution(NamedTuple):
    """Result of successive substitution: the angle [rad] and all its iterates."""

    angle: float
    iterates: Array


def irvine(
    horizontal: Numbers, vertical: Numbers, weight: Numbers, axial_stiffness: Numbers, station: Numbers
) -> CablePoint:
    """A cable without loads at unstretched stations s (eq. 2.48, 2.52 and 2.35). z down.

    `vertical` is the upward force of the support on the cable at s = 0; `weight` is per unstretched length;
    `horizontal` > 0. The form loses digits where the end slopes are nearly equal.
    """
    h, v, w, s = (np.asarray(a, dtype=float) for a in (horizontal, vertical, weight, station))
    require(h, "horizontal tension", lambda a: a > 0.0, "above zero")
    end = v - w * s
    x = h * s / axial_stiffness + h / w * (np.arcsinh(v / h) - np.arcsinh(end / h))
    z = h / w * (np.hypot(1.0, v / h) - np.hypot(1.0, end / h)) + s / axial_stiffness * (v - w * s / 2.0)
    return CablePoint(x, z, np.hypot(h, end))


def gonsior(
    horizontal: Numbers, angle_start: Numbers, angle_end: Numbers, weight: Numbers, axial_stiffness: Numbers
) -> GonsiorPiece:
    """A cable without loads between two slope angles [rad] (eq. 2.87, 2.89, 2.76, 2.79). z up.

    Eq. 2.79 is corrected: its weight is that of the unstretched cable. asinh(tan) replaces ln(sec + tan), which fails
    on steep falling cables. |angle| < 90 degrees.
    """
    h, w = np.asarray(horizontal, dtype=float), np.asarray(weight, dtype=float)
    require(h, "horizontal tension", lambda a: a > 0.0, "above zero")
    t0, t1 = np.tan(_angle(angle_start)), np.tan(_angle(angle_end))
    sec0, sec1 = np.hypot(1.0, t0), np.hypot(1.0, t1)
    stretch = h / np.asarray(axial_stiffness)  # K H
    x = h / w * (np.arcsinh(t1) - np.arcsinh(t0) + stretch * (t1 - t0))
    z = h / w * (sec1 - sec0 + stretch / 2.0 * (t1**2 - t0**2))
    arc = np.arcsinh(t1) + t1 * sec1 - np.arcsinh(t0) - t0 * sec0
    return GonsiorPiece(x, z, h / w * (t1 - t0 + stretch / 2.0 * arc), h / w * (t1 - t0))


def gonsior_angle(
    horizontal: float, angle_start: float, x: float, weight: float, axial_stiffness: float, *, tolerance: float = 1e-15
) -> Substitution:
    """Slope angle at a horizontal distance x from a point of known slope, by successive substitution (eq.
    2.90-2.94). z up; a negative x gives the angle before the point.

    Each iteration multiplies the error by -T/EA. asinh replaces e^alpha, which overflows for w x/H above 350.
    """
    require(horizontal, "horizontal tension", lambda a: a > 0.0, "above zero")
    start = float(np.tan(_angle(angle_start)))
    reach = weight * x / horizontal
    slope, iterates = start, [float(angle_start)]
    for _ in range(200):
        half = reach - horizontal / axial_stiffness * (slope - start)  # alpha/2
        if not abs(half) < 700.0:
            break
        slope = float(np.sinh(np.arcsinh(start) + half))
        iterates.append(float(np.arctan(slope)))
        if abs(iterates[-1] - iterates[-2]) <= tolerance:
            return Substitution(iterates[-1], np.array(iterates))
    raise InputError(
        "The substitution for the slope angle does not converge: the tension is near or above the axial stiffness",
        "Check the horizontal tension, the distance and the axial stiffness",
    )


def sinclair(
    vertical: float,
    horizontal: float,
    flexibility: float,
    load_stations: ArrayLike,
    loads: ArrayLike,
    station: ArrayLike,
) -> CablePoint:
    """Sinclair's dimensionless recursion for a span with N point loads (eq. 2.101-2.116). z down.

    Forces are relative to the cable's weight W, lengths to its unstretched length L0: alpha = V/W, epsilon = H/W,
    beta = W/EA, the loads' stations sigma_n in order, loads phi_n = M_n/W, stations sigma. Returns Omega, mu and
    T/W. Corrected: the radicals and asinh hold the sums Phi_n of the loads, only beta phi_i (sigma_i - sigma) the
    single loads. At the station of a load the tension is that just after it. Loads may be negative.
    """
    alpha, eps, beta = vertical, horizontal, flexibility
    require(eps, "epsilon = H/W", lambda a: a > 0.0, "above zero")
    at, phi = np.atleast_1d(np.asarray(load_stations, float)), np.atleast_1d(np.asarray(loads, float))
    if at.shape != phi.shape or at.ndim != 1:
        raise InputError("Loads and their stations do not match", "Give one station for each load")
    if np.any(np.diff(at) < 0.0) or np.any((at < 0.0) | (at > 1.0)):
        raise InputError(f"Load stations {at} are not in order between 0 and 1", "Sort them from the span's start")
    sigma = np.asarray(station, dtype=float)
    total = np.cumsum(phi)  # Phi_n
    before = alpha - (total - phi) - at  # just before each load
    after = before - phi
    passed = at <= sigma[..., None]
    hung = np.sum(phi * passed, axis=-1)
    end = alpha - hung - sigma
    jump_x = np.sum((np.arcsinh(after / eps) - np.arcsinh(before / eps)) * passed, axis=-1)
    jump_z = np.sum(
        (beta * phi * (at - sigma[..., None]) + np.hypot(eps, after) - np.hypot(eps, before)) * passed, axis=-1
    )
    x = eps * (beta * sigma + np.arcsinh(alpha / eps) - np.arcsinh(end / eps) + jump_x)
    z = beta * sigma * (alpha - sigma / 2.0) + np.hypot(eps, alpha) - np.hypot(eps, end) + jump_z
    return CablePoint(x, z, np.hypot(eps, end))


def point_load(
    horizontal: float,
    vertical: float,
    weight: float,
    axial_stiffness: float,
    length: float,
    load: float,
    load_station: float,
    station: ArrayLike,
) -> CablePoint:
    """A span with one point load at unstretched stations (eq. 2.95-2.100, corrected: 2.98's missing plus, 2.99's
    load term outside the bracket and its second line, 2.100's /H). z down. Sinclair's recursion for N = 1."""
    total = weight * length
    point = sinclair(
        vertical / total,
        horizontal / total,
        total / axial_stiffness,
        load_station / length,
        load / total,
        np.asarray(station, dtype=float) / length,
    )
    return CablePoint(point.x * length, point.z * length, point.tension * total)


def _angle(value: Numbers) -> Array:
    require(value, "slope angle [rad]", lambda a: np.abs(a) < np.pi / 2.0, "between -pi/2 and pi/2")
    return np.asarray(value, dtype=float)
