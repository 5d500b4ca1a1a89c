"""A circular shoe that a rope wraps: where the rope leaves it, and how much rope lies on it.

In the vertical plane of the line. The rope on the shoe stretches with its tension; its weight is left out, so
that tension is the same all along a smooth shoe.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ropeway.components import laws
from ropeway.components.catenary import Strain, Vector, namespace, norm, segment
from ropeway.components.component import Kind, Variable

Plane = tuple[Any, Any]
"""A vector (x, z)."""


class Side(NamedTuple):
    """A rope's way off a shoe on one side: `turn`, the angle from the place on the shoe where it is counted from to
    where it leaves [rad]; that place is `aside` (x, z) [m]; `rope` lies between them [m, unstretched]."""

    turn: Any
    aside: Plane
    rope: Any


def normal_at(slope: Any) -> Plane:
    """Outward normal of a shoe where it has a slope (rise over run)."""
    length = (1.0 + slope**2) ** 0.5
    return (-slope / length, 1.0 / length)


def normal_after(normal: Plane, angle: Any) -> Plane:
    """Outward normal an angle [rad] further on along a shoe, towards greater x."""
    xp = namespace(angle)
    sine, cosine = xp.sin(angle), xp.cos(angle)
    return (normal[0] * cosine + normal[1] * sine, normal[1] * cosine - normal[0] * sine)


def towards_b(normal: Plane) -> Plane:
    """Tangent of a shoe towards greater x, for its outward normal."""
    return (normal[1], -normal[0])


def towards_a(normal: Plane) -> Plane:
    """Tangent of a shoe towards smaller x, for its outward normal."""
    return (-normal[1], normal[0])


def turn(force: Vector, normal: Plane, along: Plane) -> Any:
    """Angle [rad] by which a rope with a `force` on the shoe goes below the tangent `along` the shoe."""
    down = -(force[0] * normal[0] + force[2] * normal[1])
    return namespace(down).atan2(down, force[0] * along[0] + force[2] * along[1])


def not_below(angle: Any) -> Any:
    """How far a rope lies on the shoe: the angle below its tangent, or none where it goes above it."""
    return namespace(angle).fmax(angle, 0.0)


def pull(tension: Any, above: Any, normal: Plane, along: Plane) -> Vector:
    """Force of a rope at an angle `above` the tangent `along` a shoe."""
    xp = namespace(tension, above)
    forth, out = tension * xp.cos(above), tension * xp.sin(above)
    return (forth * along[0] + out * normal[0], 0.0 * forth, forth * along[1] + out * normal[1])


def side(angle: Any, normal: Plane, along: Plane, radius: Any, force: Vector, carried: Any) -> Side:
    """The way off a shoe after an angle [rad] along it. The strain of the rope there is 2 (carried - T) / T, exact
    for an elastic rope."""
    xp = namespace(angle)
    forth, out = radius * xp.sin(angle), radius * (xp.cos(angle) - 1)
    tension = norm(force)
    aside = (forth * along[0] + out * normal[0], forth * along[1] + out * normal[1])
    return Side(angle, aside, radius * angle / (2 * carried / tension - 1))


def clearance(end: Plane, force: Vector, weight: Any, strain: Strain, radius: Any) -> Any:
    """How far a rope passes over a shoe that it comes to lie on [m], or how far its `end` is still before the shoe
    where that is more. end: (x, z) from the shoe's centre, with the tension vector `force` there [N]; weight [N/m]."""
    xp = namespace(*force)
    back: Any = 0.0
    for _ in range(5):  # to the point nearest to the centre; a rope is straighter than a shoe by far
        way = (force[0], force[2] - weight * back)
        reach = segment((force[0], force[1], way[1]), weight, back, strain).reach
        point = (end[0] - reach[0], end[1] - reach[2])
        back = back + (point[0] * way[0] + point[1] * way[1]) / xp.sqrt(way[0] ** 2 + way[1] ** 2)
    return xp.fmax(xp.sqrt(point[0] ** 2 + point[1] ** 2) - radius, -back)


def side_variables(seat: str) -> tuple[Variable, ...]:
    """Unknowns and residuals of one seat of a shoe: its `offset`."""
    alg, res = Kind.ALGEBRAIC, Kind.RESIDUAL
    return (
        *(Variable(f"{seat}_{a}", alg, "m", f"{a} from the node to where the rope leaves it") for a in "xz"),
        Variable(f"{seat}_rope", alg, "m", "unstretched rope between the node and there"),
        *(Variable(f"{seat}_leaves_{a}", res, "m", f"the rope leaves the shoe along it, {a}") for a in "xz"),
        Variable(f"{seat}_laid", res, "m", "rope on the shoe"),
    )


def side_residuals(v: Any, seat: str, found: Side, way: int) -> dict[str, Any]:
    """Residuals of `side_variables`; way: 1 where the rope arrives at the seat, -1 where it leaves."""
    x, z, rope = (getattr(v, f"{seat}_{name}") for name in ("x", "z", "rope"))
    return {
        f"{seat}_leaves_x": x - found.aside[0],
        f"{seat}_leaves_z": z - found.aside[1],
        f"{seat}_laid": rope - way * found.rope,
    }


def laws_of_side(v: Any, seat: str, middle: tuple[Any, Any], *, free: bool = False) -> dict[str, laws.Law]:
    """The laws of `side_residuals`. middle: from the shoe's centre to where the seat counts from (x, z) [m]; free:
    whether the rope may go off above the shoe."""
    x, z, rope = (getattr(v, f"{seat}_{name}") for name in ("x", "z", "rope"))
    end, side = getattr(v, seat), 1.0 if seat == "b" else -1.0
    place = (middle[0] + x, middle[1] + z)
    found = laws.on_arc(middle, place, end.force, (-side * rope, end.stretched), v.radius, side=side, free=free)
    return dict(zip((f"{seat}_leaves_x", f"{seat}_leaves_z", f"{seat}_laid"), found, strict=True))


def moment(place: tuple[Any, Any], force: np.ndarray) -> np.ndarray:
    """Moment of a force (3, ...) [N] that acts at a `place` (x, z) from the centre of a shoe [N.m]."""
    return np.asarray(place[0] * force[2] - place[1] * force[0])
