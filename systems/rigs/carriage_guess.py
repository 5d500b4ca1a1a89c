"""Where a loaded carriage is about, from geometry: starting values, never results.

The rope from the carriage to the two ends of its span is taken as straight, with the excess of a parabola;
the carriage then stands on an ellipse, and its tension is (Q + w L / 2) / (sin + sin).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ropeway.components.catenary import Strain


class Start(NamedTuple):
    """Height of the carriage [m], skyline tension there [N], and the pull that holds it towards the head [N]."""

    z: float
    tension: float
    pull: float


def rope_lengths(points: np.ndarray, weight: float, strain: Strain, tension: float) -> np.ndarray:
    """Unstretched lengths [m] between `points` (n, 3) of a rope at about a tension [N], not lower than its own
    weight needs."""
    d = np.diff(points, axis=0)
    chord = np.linalg.norm(d, axis=1)
    flat = np.hypot(d[:, 0], d[:, 1])
    enough = max(tension, float((0.4 * weight * flat + 0.6 * weight * np.abs(d[:, 2])).max()))
    return np.asarray((chord + (weight * flat) ** 2 * chord / (24.0 * enough**2)) / (1.0 + strain.at(enough)))


class _Span(NamedTuple):
    """A carriage's span seen from the carriage: horizontal distances to its ends [m], their heights [m]."""

    left: float
    right: float
    za: float
    zb: float

    def reach(self, z: float) -> tuple[float, float]:
        """Straight distances from a carriage at a height z to both ends."""
        return float(np.hypot(self.left, self.za - z)), float(np.hypot(self.right, self.zb - z))

    def tension(self, z: float, weight: float, load: float) -> float:
        """Equal tension on both sides that carries a load and half the rope; inf at or above the chord."""
        a, b = self.reach(z)
        lift = (self.za - z) / a + (self.zb - z) / b
        return (load + 0.5 * weight * (a + b)) / lift if lift > 0.0 else np.inf

    def pull(self, z: float, load: float) -> float:
        """Holding force along the bisector, positive towards a."""
        a, b = self.reach(z)
        x = -self.left / a - self.right / b
        up = (self.za - z) / a - (self.zb - z) / b
        return load * up / float(np.hypot(x, up))

    @property
    def chord(self) -> float:
        """Height of the chord over the carriage."""
        return self.za + (self.zb - self.za) * self.left / (self.left + self.right)


def _seen(ends: np.ndarray, station: float) -> _Span:
    a, b = ends
    share = (station - a[0]) / (b[0] - a[0])
    flat = float(np.hypot(b[0] - a[0], b[1] - a[1]))
    return _Span(share * flat, (1.0 - share) * flat, float(a[2]), float(b[2]))


def at_height(ends: np.ndarray, station: float, weight: float, load: float, z: float) -> Start:
    """A carriage at a given height z [m] in a span with `ends` (2, 3)."""
    span = _seen(ends, station)
    return Start(z, min(span.tension(z, weight, load), 1e7), span.pull(z, load))


def ellipse(
    points: np.ndarray, k: int, station: float, weight: float, strain: Strain, total: float, load: float
) -> Start:
    """A carriage in span k of a rope of unstretched length `total` [m] over `points` (n, 3), with a load [N]."""
    span = _seen(points[k : k + 2], station)
    d = np.diff(points, axis=0)
    chord, flat = np.linalg.norm(d, axis=1), np.hypot(d[:, 0], d[:, 1])
    others = np.arange(len(chord)) != k
    excess = (weight * flat[others]) ** 2 * chord[others] / 24.0
    straight = float(chord[others].sum())
    own = weight**2 * (span.left**3 + span.right**3) / 24.0

    def height(tension: float) -> float:
        """Where the rope left for the span lets the carriage hang; the chord when it is too short."""
        rope = total * (1.0 + strain.at(tension)) - straight - (float(excess.sum()) + own) / tension**2
        return _below(span, rope)

    low, high = 1.0, 1e9
    for _ in range(60):
        tension = (low * high) ** 0.5
        if span.tension(height(tension), weight, load) > tension:
            low = tension
        else:
            high = tension
    tension = (low * high) ** 0.5
    z = min(height(tension), span.chord - 1e-6 * (span.left + span.right))
    return Start(z, tension, span.pull(z, load))


def _below(span: _Span, rope: float) -> float:
    """Height at which the two straight pieces are `rope` metres long together: the lower branch of the
    ellipse with the span's ends as foci; the chord where the rope is shorter than that."""
    flat, rise = span.left + span.right, span.zb - span.za
    if rope * rope <= flat * flat + rise * rise:
        return span.chord
    # |CA| + |CB| = r: with u = zc - za and |CA|^2 - |CB|^2 known in u, one square root.
    c = span.left**2 - span.right**2 - rise**2 + rope**2  # |CA| = (c + 2 u rise) / (2 r)
    qa = 4.0 * (rope**2 - rise**2)
    qb = -4.0 * c * rise
    qc = 4.0 * rope**2 * span.left**2 - c**2
    root = max(qb * qb - 4.0 * qa * qc, 0.0) ** 0.5
    return span.za + (-qb - root) / (2.0 * qa)


def running(ends: np.ndarray, station: float, weight: float, load: float, tension: float, z: float | None) -> Start:
    """A carriage of a running skyline: the haulback goes over it to the tail and ends at it; the tension of
    the haulback at the carriage is given, or the carriage's height z [m]."""
    span = _seen(ends, station)

    def balance(z: float) -> tuple[float, float]:
        """Haulback tension for vertical balance at a height, and mainline pull over it."""
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
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if balance(middle)[0] < tension else (low, middle)
    z = 0.5 * (low + high)
    return Start(z, tension, balance(z)[1] * tension)
