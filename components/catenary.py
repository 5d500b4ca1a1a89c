"""The closed-form elastic cable: one load-free segment, and the sums of a span with loads.

One implementation serves numbers, NumPy arrays and CasADi symbols. A segment starts with the tension
vector `force` = (fx, fy, v): its components in the direction of travel, z up, so that v > 0 where the rope
rises. With w the weight per unstretched metre and d the unstretched length, these forms follow
from Irvine's and Sinclair's sums (Turk 1988, eq. 2.48-2.52 and 2.111-2.116, corrected) by taking the
differences analytically: there is no difference of asinh and no cancellation for short, slack, steep or taut pieces.
The strain law is eps(T) = c1 T + c2 T^2 (c1 = 1/EA elastic, c2 construction stretch; Lyons 2008, eq. 14).

Wind on a rope only turns its weight: a `Uniform` force in place of the weight is a weight along another axis.
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
    """Coefficients of eps(T) = c1 T + c2 T^2. A rope that is warmer or colder than when it was strung is `expansion`
    + eps(T) times as long: strains add."""

    c1: Any
    c2: Any
    expansion: Any = 1.0

    @property
    def none(self) -> bool:
        """Whether tension does not stretch the rope."""
        return bool(self.c1 == 0.0 and self.c2 == 0.0)

    def at(self, tension: Any) -> Any:
        """Strain at a tension [N]."""
        return tension * (self.c1 + self.c2 * tension)

    def potential(self, tension: Any) -> Any:
        """Integral of (1 + eps) dT [N]: along a load-free piece it increases by w times the rise.

        T + T^2/(2 EA) for an elastic rope.
        """
        return tension * (self.expansion + tension * (self.c1 / 2 + self.c2 * tension / 3))

    def expanded(self, value: Any) -> Any:
        """A length of the rope as it was strung, warmer or colder without tension."""
        return value if isinstance(self.expansion, float) and self.expansion == 1.0 else self.expansion * value


class Uniform(NamedTuple):
    """A force on each unstretched metre of a rope, in any direction: its `size` [N/m], and the unit vector `up`
    against it."""

    size: Any
    up: Vector

    @classmethod
    def of(cls, force: Vector) -> Uniform:
        """By the force itself [N/m]."""
        size = norm(force)
        return cls(size, (-force[0] / size, -force[1] / size, -force[2] / size))

    @property
    def force(self) -> Vector:
        """The force [N/m]."""
        return (-self.size * self.up[0], -self.size * self.up[1], -self.size * self.up[2])

    def parts(self, force: Vector) -> tuple[Vector, Any, Any]:
        """Of a tension vector the part across `up`, that squared, and the component along `up`."""
        v = force[0] * self.up[0] + force[1] * self.up[1] + force[2] * self.up[2]
        x, y, z = (force[i] - v * self.up[i] for i in range(3))
        return (x, y, z), x * x + y * y + z * z + _VERTICAL, v

    def added(self, vector: Vector, along: Any) -> Vector:
        """A vector with more along `up`."""
        return (vector[0] + along * self.up[0], vector[1] + along * self.up[1], vector[2] + along * self.up[2])


Weight = Any
"""The weight of a rope [N/m], or a `Uniform` force."""


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


def segment(force: Vector, weight: Weight, length: Any, strain: Strain) -> Segment:
    """Reach and end force of a load-free piece of `length` [m, unstretched] and `weight` [N/m].

    Also for a folded rope, whose two parts hang vertically from its ends.
    """
    piece = piece_of(force, weight, length, strain)
    across = piece.across
    if isinstance(weight, Uniform):
        level = weight.parts(force)[0]
        reach = weight.added((level[0] * across, level[1] * across, level[2] * across), piece.rise)
        return Segment(reach, end_of(force, weight, length))
    return Segment((force[0] * across, force[1] * across, piece.rise), (force[0], force[1], piece.v1))


class Piece(NamedTuple):
    """A load-free piece: its tension across the vertical, squared, and at both ends along the vertical and in all; its
    `length`; half its angle over its weight; its reach across the vertical, over the tension there, and its rise."""

    h2: Any
    v0: Any
    v1: Any
    t0: Any
    t1: Any
    length: Any
    angle: Any
    across: Any
    rise: Any


def piece_of(force: Vector, weight: Weight, length: Any, strain: Strain) -> Piece:
    """A load-free piece that starts with the tension vector `force`."""
    if isinstance(weight, Uniform):
        (_, h2, v0), weight = weight.parts(force), weight.size
    else:
        (fx, fy, v0) = force
        h2 = fx * fx + fy * fy + _VERTICAL
    xp = namespace(*force, length, weight)
    v1 = v0 + weight * length
    t0, t1 = xp.sqrt(h2 + v0 * v0), xp.sqrt(h2 + v1 * v1)
    s, v = t0 + t1, v0 + v1
    angle = _half_angle(xp, h2, v0, v1, t0, t1, weight * length) / weight
    across, lift = strain.expanded(2 * angle) + strain.c1 * length, strain.expanded(1 / s) + strain.c1 / 2
    if not (isinstance(strain.c2, float) and strain.c2 == 0.0):
        across = across + strain.c2 * (length / 4 * (s + v * v / s) + h2 * angle)
        lift = lift + strain.c2 * (t0 * t0 + t0 * t1 + t1 * t1) / (3 * s)
    return Piece(h2, v0, v1, t0, t1, length, angle, across, length * v * lift)


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
    """Integrals of T, T^2 and v^2 along a load-free piece, and T and v at its start."""

    tension: Any
    tension_squared: Any
    vertical_squared: Any
    start: Any
    vertical_start: Any


def _integrals(force: Vector, weight: Weight, length: Any) -> _Integrals:
    if isinstance(weight, Uniform):
        (_, h2, v0), weight = weight.parts(force), weight.size
    else:
        fx, fy, v0 = force
        h2 = fx * fx + fy * fy + _VERTICAL
    xp = namespace(*force, length, weight)
    v1 = v0 + weight * length
    t0, t1 = xp.sqrt(h2 + v0 * v0), xp.sqrt(h2 + v1 * v1)
    s, v = t0 + t1, v0 + v1
    vertical = length * (v0 * v0 + v0 * v1 + v1 * v1) / 3
    tension = length / 4 * (s + v * v / s) + h2 * _half_angle(xp, h2, v0, v1, t0, t1, weight * length) / weight
    return _Integrals(tension, h2 * length + vertical, vertical, t0, v0)


def stretched_length(force: Vector, weight: Weight, length: Any, strain: Strain) -> Any:
    """Length of a load-free piece under tension [m]."""
    along = _integrals(force, weight, length)
    return strain.expanded(length) + strain.c1 * along.tension + strain.c2 * along.tension_squared


class Energy(NamedTuple):
    """Energies of a load-free piece [J]: elastic, and of its weight relative to the height of its start; of a
    `Uniform` force relative to its start."""

    elastic: Any
    gravity: Any


def energy(force: Vector, weight: Weight, length: Any, strain: Strain) -> Energy:
    """Energies of a linearly elastic piece, eps = c1 T.

    From z = (T - T0)/w + c1 (v^2 - v0^2)/(2 w) along the piece and the integrals of T, T^2 and v^2.
    """
    along, c1 = _integrals(force, weight, length), strain.c1
    v0 = along.vertical_start
    return Energy(
        c1 / 2 * along.tension_squared,
        strain.expanded(along.tension - along.start * length) + c1 / 2 * (along.vertical_squared - v0 * v0 * length),
    )


def loaded(
    force: Vector,
    weight: Weight,
    strain: Strain,
    length: Any,
    distances: Sequence[Any],
    loads: Sequence[Any],
) -> list[Segment]:
    """Stations of a span with point loads, relative to its start.

    `distances` [m, unstretched, from the start, in order] and `loads` [N], each downward or a vector. The result has
    an element for each load and a last one for the end: the vector from the start and the tension vector just before
    the load.
    """
    stations: list[Segment] = []
    here: Vector = (0.0, 0.0, 0.0)
    at: Any = 0.0
    for distance, load in zip((*distances, length), (*loads, 0.0), strict=True):
        piece = segment(force, weight, distance - at, strain)
        here = (here[0] + piece.reach[0], here[1] + piece.reach[1], here[2] + piece.reach[2])
        stations.append(Segment(here, piece.force))
        force = after(piece.force, load)
        at = distance
    return stations


def end_of(force: Vector, weight: Weight, length: Any) -> Vector:
    """The tension vector at the end of a load-free piece that starts with `force`; length below 0: backwards."""
    if isinstance(weight, Uniform):
        return weight.added(force, weight.size * length)
    return (force[0], force[1], force[2] + weight * length)


def after(force: Vector, load: Any) -> Vector:
    """The tension vector behind a load [N], downward or a vector."""
    if isinstance(load, tuple):
        return (force[0] - load[0], force[1] - load[1], force[2] - load[2])
    return (force[0], force[1], force[2] + load)


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
    weight: Weight,
    strain: Strain,
    length: float,
    distances: Sequence[float],
    loads: Sequence[Any],
    stations: np.ndarray,
) -> SpanCurve:
    """Position, tension and slope at `stations` [m, unstretched, from the span's start] of a loaded span; loads as in
    `loaded`."""
    nodes = loaded(force, weight, strain, length, distances, loads)
    starts = np.array([(0.0, 0.0, 0.0), *(n.reach for n in nodes[:-1])])
    forces = np.array([force, *(after(n.force, load) for n, load in zip(nodes[:-1], loads, strict=True))])
    return through(starts, forces, weight, strain, distances, stations)


def through(
    starts: np.ndarray,
    forces: np.ndarray,
    weight: Weight,
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
