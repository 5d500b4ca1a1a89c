"""Estimate of a loaded carriage's position from geometry: initial guesses, never results.

The rope from the carriage to the two ends of its span is straight, with the excess length of a parabola. The carriage
then lies on an ellipse, and the tension is (Q + w L / 2) / (sin + sin).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ropeway.components.catenary import Strain


class Start(NamedTuple):
    """Height of the carriage [m], skyline tension there [N], and the pull that holds it towards the head [N]."""

    z: float
    tension: float
    pull: float


def rope_lengths(points: np.ndarray, weight: float, strain: Strain, tension: float) -> np.ndarray:
    """Unstretched lengths [m] between `points` (n, 3) of a rope at an approximate tension [N]. A tension too low for
    the rope's own_excess weight is raised."""
    d = np.diff(points, axis=0)
    chord = np.linalg.norm(d, axis=1)
    horizontal = np.hypot(d[:, 0], d[:, 1])
    used = max(tension, float((0.4 * weight * horizontal + 0.6 * weight * np.abs(d[:, 2])).max()))
    return np.asarray((chord + (weight * horizontal) ** 2 * chord / (24.0 * used**2)) / (1.0 + strain.at(used)))


class _Span(NamedTuple):
    """The span of a carriage: horizontal distances from the carriage to both ends [m], heights of the ends [m]."""

    left: float
    right: float
    za: float
    zb: float

    def reach(self, z: float) -> tuple[float, float]:
        """Straight distances from the carriage at height z to both ends."""
        return math.hypot(self.left, self.za - z), math.hypot(self.right, self.zb - z)

    def tension(self, z: float, weight: float, load: float) -> float:
        """Equal tension on both sides that supports a load and half of the rope; inf at or above the chord."""
        a, b = self.reach(z)
        lift = (self.za - z) / a + (self.zb - z) / b
        return (load + 0.5 * weight * (a + b)) / lift if lift > 0.0 else np.inf

    def pull(self, z: float, load: float) -> float:
        """Holding force along the bisector, positive towards a."""
        a, b = self.reach(z)
        x = -self.left / a - self.right / b
        up = (self.za - z) / a - (self.zb - z) / b
        return load * up / math.hypot(x, up)

    @property
    def chord(self) -> float:
        """Height of the chord at the carriage's station."""
        return self.za + (self.zb - self.za) * self.left / (self.left + self.right)


def _span_at(ends: np.ndarray, station: float) -> _Span:
    a, b = ends
    share = (station - a[0]) / (b[0] - a[0])
    horizontal = float(np.hypot(b[0] - a[0], b[1] - a[1]))
    return _Span(share * horizontal, (1.0 - share) * horizontal, float(a[2]), float(b[2]))


def at_height(ends: np.ndarray, station: float, weight: float, load: float, z: float) -> Start:
    """A carriage at a given height z [m] in a span with `ends` (2, 3)."""
    span = _span_at(ends, station)
    return Start(z, min(span.tension(z, weight, load), 1e7), span.pull(z, load))


def ellipse(
    points: np.ndarray, k: int, station: float, weight: float, strain: Strain, total: float, load: float
) -> Start:
    """A loaded carriage in span k of a rope over `points` (n, 3). Its unstretched length is `total` [m], the load is in
    N."""
    span = _span_at(points[k : k + 2], station)
    d = np.diff(points, axis=0)
    chord, horizontal = np.linalg.norm(d, axis=1), np.hypot(d[:, 0], d[:, 1])
    others = np.arange(len(chord)) != k
    excess = float(((weight * horizontal[others]) ** 2 * chord[others] / 24.0).sum())
    straight = float(chord[others].sum())
    own_excess = weight**2 * (span.left**3 + span.right**3) / 24.0

    def height(tension: float) -> float:
        """Height of the carriage on the rope that remains for its span; the chord where that rope is too short."""
        rope = total * (1.0 + strain.at(tension)) - straight - (excess + own_excess) / tension**2
        return _lower_branch(span, rope)

    low, high = 1.0, 1e9
    for _ in range(30):  # to a relative error of 1e-8
        tension = (low * high) ** 0.5
        if span.tension(height(tension), weight, load) > tension:
            low = tension
        else:
            high = tension
    tension = (low * high) ** 0.5
    z = min(height(tension), span.chord - 1e-6 * (span.left + span.right))
    return Start(z, tension, span.pull(z, load))


def _lower_branch(span: _Span, rope: float) -> float:
    """Height at which the two straight pieces have a total length `rope` [m]: the lower branch of the ellipse with the
    ends of the span as foci. The chord where the rope is shorter than the chord."""
    horizontal, rise = span.left + span.right, span.zb - span.za
    if rope * rope <= horizontal * horizontal + rise * rise:
        return span.chord
    # |CA| + |CB| = r: with u = zc - za and |CA|^2 - |CB|^2 known in u, one square root.
    c = span.left**2 - span.right**2 - rise**2 + rope**2  # |CA| = (c + 2 u rise) / (2 r)
    qa = 4.0 * (rope**2 - rise**2)
    qb = -4.0 * c * rise
    qc = 4.0 * rope**2 * span.left**2 - c**2
    root = max(qb * qb - 4.0 * qa * qc, 0.0) ** 0.5
    return span.za + (-qb - root) / (2.0 * qa)


def running(ends: np.ndarray, station: float, weight: float, load: float, tension: float, z: float | None) -> Start:
    """A carriage of a running skyline: the haulback runs over it to the tail and back to it. Either the haulback's
    tension at the carriage or the carriage's height z [m] is given."""
    span = _span_at(ends, station)

    def balance(z: float) -> tuple[float, float]:
        """Haulback tension for vertical balance at height z, and the ratio of mainline pull to that tension."""
        a, b = span.reach(z)
        ratio = max(2.0 * (span.right / b) / (span.left / a) - 1.0, 0.05)
        lift = (1.0 + ratio) * (span.za - z) / a + 2.0 * (span.zb - z) / b
        carried = load + weight * (a + b)
        return (carried / lift if lift > 0.0 else np.inf), ratio

    if z is not None:
        needed, ratio = balance(z)
        needed = min(needed, 1e7)
        return Start(z, needed, ratio * needed)
    low, high = span.chord - 2.0 * (span.left + span.right), max(span.za, span.zb)
    for _ in range(45):  # to less than a micrometre
        middle = 0.5 * (low + high)
        low, high = (middle, high) if balance(middle)[0] < tension else (low, middle)
    z = 0.5 * (low + high)
    return Start(z, tension, balance(z)[1] * tension)
