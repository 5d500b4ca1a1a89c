"""How the end of a loaded span moves with its tension vector and with the rope in it: derivatives of
`catenary.loaded`, in closed form.

At the unstretched distance s from the start the tension vector is F(s), its size T, and the reach grows by g F ds with
g = (1 + eps(T)) / T. A piece that ends farther along the rope therefore reaches g F farther, and the derivative by the
tension vector is the integral of g + (dg/dT / T) F F', which has a closed form as the reach itself. It is written, as
there, without cancellation: for short, slack, steep and taut pieces alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import casadi as ca

from ropeway.components.catenary import Piece, Strain, Uniform, Vector, Weight, after, end_of, piece_of


class _Sums(NamedTuple):
    """Integrals along pieces with one tension vector across the vertical, v being the component along it: of g, of k =
    dg/dT / T, of k v, and of g + k v^2."""

    size: Any
    across: Any
    mixed: Any
    along: Any


class Plane(NamedTuple):
    """Of a span without wind, in its vertical plane: its level tension (x, y), the sums of its pieces, and how its end
    moves with its length and the distance of each load: as a multiple of the level tension, and upwards."""

    level: tuple[Any, Any]
    sums: _Sums
    by_length: tuple[Any, Any]
    by_distance: tuple[tuple[Any, Any], ...]

    def forces(self, reach: Vector, ways: Sequence[tuple[Any, Any]]) -> list[Vector]:
        """The moves of the tension vector that move the end by `reach`, and by `ways` in the plane."""
        (fx, fy), (size, across, mixed, along) = self.level, self.sums
        h2 = fx * fx + fy * fy
        flat = size + across * h2  # in the plane; across it the end gives way by `size`
        inverse = 1 / (flat * along - mixed * mixed * h2)
        own, other, upright = along * inverse, mixed * inverse, flat * inverse
        ahead, aside = fx * reach[0] + fy * reach[1], 1 / size
        turned = (mixed * other - across * own) * aside * ahead - other * reach[2]
        found = [(reach[0] * aside + turned * fx, reach[1] * aside + turned * fy, upright * reach[2] - other * ahead)]
        for more, up in ways:
            turned = own * more - other * up
            found.append((turned * fx, turned * fy, upright * up - other * h2 * more))
        return found


class Moves(NamedTuple):
    """Derivatives of the vector from the start of a span to its end: by the tension vector at its start, a row for each
    component of the reach; by its length; and by the distance of each load. `plane`: the same, None with wind."""

    by_force: tuple[Vector, Vector, Vector]
    by_length: Vector
    by_distance: tuple[Vector, ...]
    plane: Plane | None


def moves(
    force: Vector, weight: Weight, strain: Strain, length: Any, distances: Sequence[Any], loads: Sequence[Any]
) -> Moves:
    """Derivatives of the last of `catenary.loaded` with the same arguments, on CasADi's symbols."""
    up: Vector = weight.up if isinstance(weight, Uniform) else (0.0, 0.0, 1.0)
    sums: list[tuple[Vector, _Sums]] = []
    ends: list[tuple[Vector, Vector]] = []
    ways: list[tuple[tuple[Any, Any], tuple[Any, Any]]] = []
    level: Vector = (force[0], force[1], 0.0)
    at: Any = 0.0
    for distance, load in zip((*distances, length), (*loads, 0.0), strict=True):
        piece = piece_of(force, weight, distance - at, strain)
        own = _sums(piece, strain)
        if not isinstance(weight, Uniform) and sums:
            own = _Sums(*(a + b for a, b in zip(sums.pop()[1], own, strict=True)))
        sums.append((weight.parts(force)[0] if isinstance(weight, Uniform) else level, own))
        last, share_0, share_1 = (
            end_of(force, weight, distance - at),
            _share(piece.t0, strain),
            _share(piece.t1, strain),
        )
        ends.append((_scaled(force, share_0), _scaled(last, share_1)))
        ways.append(((share_0, piece.v0 * share_0), (share_1, piece.v1 * share_1)))
        force, at = after(last, load), distance
    by_distance = tuple(
        (before[0] - behind[0], before[1] - behind[1], before[2] - behind[2])
        for (_, before), (behind, _) in pairwise(ends)
    )
    plane: Plane | None = None
    if not isinstance(weight, Uniform):
        moved = tuple((a[0] - b[0], a[1] - b[1]) for (_, a), (b, _) in pairwise(ways))
        plane = Plane((level[0], level[1]), sums[0][1], ways[-1][1], moved)
    return Moves(_matrix(sums, up), ends[-1][1], by_distance, plane)


def solved(matrix: tuple[Vector, Vector, Vector], sides: Sequence[Vector]) -> list[Vector]:
    """Solutions of a system of three equations, rows of a matrix, by Cramer's rule, on CasADi's symbols."""
    one, two, three = (ca.vertcat(*(row[i] for row in matrix)) for i in range(3))
    cofactors = (ca.cross(two, three), ca.cross(three, one), ca.cross(one, two))
    inverse = 1.0 / ca.dot(one, cofactors[0])
    x, y, z = (row * inverse for row in cofactors)
    return [(ca.dot(x, side), ca.dot(y, side), ca.dot(z, side)) for side in map(_column, sides)]


def _column(vector: Vector) -> Any:
    return ca.vertcat(*vector)


def _share(tension: Any, strain: Strain) -> Any:
    """Stretched over unstretched length, over the tension."""
    return strain.expanded(1 / tension) + strain.c1 + strain.c2 * tension


def _scaled(force: Vector, factor: Any) -> Vector:
    return (force[0] * factor, force[1] * factor, force[2] * factor)


def _sums(piece: Piece, strain: Strain) -> _Sums:
    """The integrals along one piece.

    With u = v / T, that of 1 / T^3 is (u1 - u0) / (w h^2). Here u1 - u0 is h^2 w l (1 + q) / (T0 T1 (T0 + T1)), where
    q = (h^2 + v0^2 + v1^2) / (T0 T1 + v0 v1), a sum whose terms must have one sign: at a fold it is
    (T0 T1 - v0 v1) / h^2.
    """
    h2, length, c2 = piece.h2, piece.length, strain.c2
    s, v, product, slopes = piece.t0 + piece.t1, piece.v0 + piece.v1, piece.t0 * piece.t1, piece.v0 * piece.v1
    sound = product + ca.fabs(slopes)
    ratio = ca.if_else(slopes >= 0, (h2 + piece.v0 * piece.v0 + piece.v1 * piece.v1) / sound, sound / h2)
    turned = strain.expanded(length * (1 + ratio) / (product * s))
    mean = length * v / s
    across, mixed = -turned, -strain.expanded(mean / product)
    along = h2 * turned + strain.c1 * length
    if not (isinstance(c2, float) and c2 == 0.0):
        across, mixed = across + c2 * (2 * piece.angle), mixed + c2 * mean
        along = along + c2 * (length * s + mean * v) / 2
    return _Sums(piece.across, across, mixed, along)


def _matrix(sums: Sequence[tuple[Vector, _Sums]], up: Vector) -> tuple[Vector, Vector, Vector]:
    """The derivative by the tension vector, a symmetric matrix."""

    def entry(i: int, j: int) -> Any:
        found: Any = 0.0
        for level, own in sums:
            found = found + own.size * ((1.0 if i == j else 0.0) - up[i] * up[j]) + own.across * level[i] * level[j]
            found = found + own.mixed * (level[i] * up[j] + up[i] * level[j]) + own.along * up[i] * up[j]
        return found

    xx, xy, xz, yy, yz, zz = (entry(i, j) for i in range(3) for j in range(i, 3))
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
