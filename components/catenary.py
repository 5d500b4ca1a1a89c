"""The closed-form elastic cable: one load-free segment, and the sums of a span with loads.

One implementation serves numbers, NumPy arrays and CasADi symbols. A segment starts with the tension
vector `force` = (fx, fy, v): its components in the direction of travel, z up, so that v > 0 where the rope
rises. With w the weight per unstretched metre and d the unstretched length, these forms follow
from Irvine's and Sinclair's sums (Turk 1988, eq. 2.48-2.52 and 2.111-2.116, corrected) by taking the
differences analytically: there is no difference of asinh and no cancellation for short, slack, steep or taut pieces.
The strain law is eps(T) = c1 T + c2 T^2 (c1 = 1/EA elastic, c2 construction stretch; Lyons 2008, eq. 14).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

_VERTICAL = 1e-280
"""Square of a negligible horizontal force [N2], which keeps the angle of a vertical rope finite."""

Vector = tuple[Any, Any, Any]
"""Three components, each a float, an array or a CasADi symbol."""


class Strain(NamedTuple):
    """Coefficients of eps(T) = c1 T + c2 T^2."""

    c1: Any
    c2: Any

    def at(self, tension: Any) -> Any:
        """Strain at a tension [N]."""
        return tension * (self.c1 + self.c2 * tension)

    def potential(self, tension: Any) -> Any:
        """Integral of (1 + eps) dT [N]: along a load-free piece it increases by w times the rise.

        T + T^2/(2 EA) for an elastic rope.
        """
        return tension * (1 + tension * (self.c1 / 2 + self.c2 * tension / 3))


class Segment(NamedTuple):
    """A load-free piece: the vector from its start to its end [m], and the tension vector at its end [N]."""

    reach: Vector
    force: Vector


def namespace(*values: Any) -> Any:
    """The module whose sqrt, atanh, ... fit the values: casadi for symbols, numpy for numbers."""
    return ca if any(isinstance(v, (ca.SX, ca.MX)) for v in values) else np


def norm(force: Vector) -> Any:
    """Length of a vector."""
    x, y, z = force
    return namespace(*force).sqrt(x * x + y * y + z * z)


def segment(force: Vector, weight: Any, length: Any, strain: Strain) -> Segment:
    """Reach and end force of a load-free piece of `length` [m, unstretched] and `weight` [N/m].

    Also for a folded rope, whose two parts hang vertically from its ends.
    """
    fx, fy, v0 = force
    xp = namespace(*force, length, weight)
    v1 = v0 + weight * length
    h2 = fx * fx + fy * fy + _VERTICAL
    t0, t1 = xp.sqrt(h2 + v0 * v0), xp.sqrt(h2 + v1 * v1)
    s, v = t0 + t1, v0 + v1
    angle = _half_angle(xp, h2, v0, v1, t0, t1, weight * length) / weight
    across, lift = 2 * angle + strain.c1 * length, 1 / s + strain.c1 / 2
    if not (isinstance(strain.c2, float) and strain.c2 == 0.0):
        across = across + strain.c2 * (length / 4 * (s + v * v / s) + h2 * angle)
        lift = lift + strain.c2 * (t0 * t0 + t0 * t1 + t1 * t1) / (3 * s)
    return Segment((fx * across, fy * across, length * v * lift), (fx, fy, v1))


def _half_angle(xp: Any, h2: Any, v0: Any, v1: Any, t0: Any, t1: Any, gain: Any) -> Any:
    """atanh(gain / (t0 + t1)) for gain = v1 - v0 not below 0, half of the increase of asinh(v / h) along a piece;
    written without cancellation near a fold, where the argument approaches one."""
    if xp is np:
        share = gain / (t0 + t1)
        # NumPy's log1p is inaccurate near zero for complex numbers (complex-step derivatives).
        if np.iscomplexobj(share) or np.max(share, initial=0.0) < 0.9:
            return np.arctanh(share)
    choose = ca.if_else if xp is ca else np.where
    up0, up1 = v0 >= 0, v1 <= 0
    steep0, steep1 = t0 + choose(up0, v0, -v0), t1 + choose(up1, -v1, v1)
    rest = choose(up0, steep0, h2 / steep0) + choose(up1, steep1, h2 / steep1)  # t0 + t1 - gain
    return xp.log1p(2 * gain / rest) / 2


class _Integrals(NamedTuple):
    """Integrals of T, T^2 and v^2 along a load-free piece, and T at its start."""

    tension: Any
    tension_squared: Any
    vertical_squared: Any
    start: Any


def _integrals(force: Vector, weight: Any, length: Any) -> _Integrals:
    fx, fy, v0 = force
    xp = namespace(*force, length, weight)
    v1 = v0 + weight * length
    h2 = fx * fx + fy * fy + _VERTICAL
    t0, t1 = xp.sqrt(h2 + v0 * v0), xp.sqrt(h2 + v1 * v1)
    s, v = t0 + t1, v0 + v1
    vertical = length * (v0 * v0 + v0 * v1 + v1 * v1) / 3
    tension = length / 4 * (s + v * v / s) + h2 * _half_angle(xp, h2, v0, v1, t0, t1, weight * length) / weight
    return _Integrals(tension, h2 * length + vertical, vertical, t0)


def stretched_length(force: Vector, weight: Any, length: Any, strain: Strain) -> Any:
    """Length of a load-free piece under tension [m]."""
    along = _integrals(force, weight, length)
    return length + strain.c1 * along.tension + strain.c2 * along.tension_squared


class Energy(NamedTuple):
    """Energies of a load-free piece [J]: elastic, and of its weight relative to the height of its start."""

    elastic: Any
    gravity: Any


def energy(force: Vector, weight: Any, length: Any, c1: Any) -> Energy:
    """Energies of a linearly elastic piece, eps = c1 T.

    From z = (T - T0)/w + c1 (v^2 - v0^2)/(2 w) along the piece and the integrals of T, T^2 and v^2.
    """
    along = _integrals(force, weight, length)
    v0 = force[2]
    return Energy(
        c1 / 2 * along.tension_squared,
        along.tension - along.start * length + c1 / 2 * (along.vertical_squared - v0 * v0 * length),
    )


def loaded(
    force: Vector, weight: Any, strain: Strain, length: Any, distances: Sequence[Any], loads: Sequence[Any]
) -> list[Segment]:
    """Stations of a span with point loads, relative to its start.

    `distances` [m, unstretched, from the start, in order] and `loads` [N, downward]. The result has an
    element for each load and a last one for the end: the vector from the start and the tension vector just
    before the load.
    """
    stations: list[Segment] = []
    here: Vector = (0.0, 0.0, 0.0)
    at: Any = 0.0
    for distance, load in zip((*distances, length), (*loads, 0.0), strict=True):
        piece = segment(force, weight, distance - at, strain)
        here = (here[0] + piece.reach[0], here[1] + piece.reach[1], here[2] + piece.reach[2])
        stations.append(Segment(here, piece.force))
        force = (piece.force[0], piece.force[1], piece.force[2] + load)
        at = distance
    return stations


class SpanCurve(NamedTuple):
    """A loaded span at many stations. `reach` and `force` have shape (n, 3): the vector from the span's
    start [m] and the tension vector [N] (just before a load that stands on the station)."""

    station: np.ndarray
    reach: np.ndarray
    force: np.ndarray

    @property
    def tension(self) -> np.ndarray:
        """Tension [N], shape (n,)."""
        return np.linalg.norm(self.force, axis=1)

    @property
    def slope(self) -> np.ndarray:
        """Slope of the rope, rise over horizontal run, shape (n,)."""
        return self.force[:, 2] / np.hypot(self.force[:, 0], self.force[:, 1])


def profile(
    force: Vector,
    weight: float,
    strain: Strain,
    length: float,
    distances: Sequence[float],
    loads: Sequence[float],
    stations: np.ndarray,
) -> SpanCurve:
    """Position, tension and slope at `stations` [m, unstretched, from the span's start] of a loaded span."""
    nodes = loaded(force, weight, strain, length, distances, loads)
    starts = np.array([(0.0, 0.0, 0.0), *(n.reach for n in nodes[:-1])])
    forces = np.array([force, *(n.force for n in nodes[:-1])])
    forces[1:, 2] += np.asarray(loads, dtype=float)
    return through(starts, forces, weight, strain, distances, stations)


def through(
    starts: np.ndarray,
    forces: np.ndarray,
    weight: float,
    strain: Strain,
    distances: Sequence[float],
    stations: np.ndarray,
) -> SpanCurve:
    """As `profile`, of pieces that begin at `starts` (pieces, 3) with tension vectors `forces` (pieces, 3): the first
    at the span's start, the others at `distances`."""
    cuts = np.array([0.0, *distances])
    station = np.asarray(stations, dtype=float)
    piece = np.maximum(np.searchsorted(cuts, station, side="left") - 1, 0)
    f = forces[piece]
    part = segment((f[:, 0], f[:, 1], f[:, 2]), weight, station - cuts[piece], strain)
    return SpanCurve(station, starts[piece] + np.column_stack(part.reach), np.column_stack(part.force))
