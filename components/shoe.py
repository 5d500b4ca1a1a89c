"""A circular shoe that a rope wraps: where the rope leaves it, and how much rope lies on it.

All vectors are in the vertical plane of the line. The rope on the shoe stretches with its tension. Its weight is
neglected, so the tension is constant along a shoe without friction.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ropeway.components import laws
from ropeway.components.catenary import Strain, Vector, Weight, end_of, namespace, norm, segment
from ropeway.components.variable import Kind, Variable

Plane = tuple[Any, Any]
"""A vector (x, z)."""


class Side(NamedTuple):
    """How a rope leaves a shoe on one side.

    `turn`: angle along the shoe from the reference point to the point of departure [rad]; `aside`: vector (x, z)
    between both [m]; `rope`: unstretched length between both [m].
    """

    turn: Any
    aside: Plane
    rope: Any


def normal_at(slope: Any) -> Plane:
    """Outward normal of a shoe where it has a slope (rise over run)."""
    length = (1.0 + slope**2) ** 0.5
    return (-slope / length, 1.0 / length)


def normal_after(normal: Plane, angle: Any) -> Plane:
    """Outward normal an angle [rad] further along a shoe, towards greater x."""
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
    """Angle of a rope with a `force` on the shoe below the tangent `along` the shoe [rad]."""
    down = -(force[0] * normal[0] + force[2] * normal[1])
    return namespace(down).atan2(down, force[0] * along[0] + force[2] * along[1])


def contact_angle(angle: Any) -> Any:
    """Angle of contact on the shoe: the angle below the tangent, or zero."""
    return namespace(angle).fmax(angle, 0.0)


def pull(tension: Any, above: Any, normal: Plane, along: Plane) -> Vector:
    """Force of a rope at an angle `above` the tangent `along` a shoe."""
    xp = namespace(tension, above)
    forth, out = tension * xp.cos(above), tension * xp.sin(above)
    return (forth * along[0] + out * normal[0], 0.0 * forth, forth * along[1] + out * normal[1])


def side(angle: Any, normal: Plane, along: Plane, radius: Any, rope: Any) -> Side:
    """The point of departure after an angle along the shoe [rad] of the `rope` at a seat.

    On the shoe the rope is 2 carried / T - expansion times as long as it was strung, exact for an elastic rope.
    """
    xp = namespace(angle)
    forth, out = radius * xp.sin(angle), radius * (xp.cos(angle) - 1)
    tension = norm(rope.force)
    aside = (forth * along[0] + out * normal[0], forth * along[1] + out * normal[1])
    return Side(angle, aside, radius * angle / (2 * rope.carried / tension - rope.expansion))


def clearance(end: Plane, force: Vector, weight: Weight, strain: Strain, radius: Any) -> Any:
    """Distance of a rope from a shoe that it approaches, or of its `end` from the shoe, if larger [m].

    `end`: (x, z) from the centre of the shoe, with the tension vector `force` there [N]; `weight` [N/m].
    """
    xp = namespace(*force)
    back: Any = 0.0
    for _ in range(5):  # to the point nearest to the centre; the curvature of the rope is much smaller
        start = end_of(force, weight, -back)
        reach = segment(start, weight, back, strain).reach
        point = (end[0] - reach[0], end[1] - reach[2])
        back = back + (point[0] * start[0] + point[1] * start[2]) / xp.sqrt(start[0] ** 2 + start[2] ** 2)
    return xp.fmax(xp.sqrt(point[0] ** 2 + point[1] ** 2) - radius, -back)


def side_variables(seat: str) -> tuple[Variable, ...]:
    """Unknowns and residuals of one seat of a shoe: its `offset`."""
    alg, res = Kind.ALGEBRAIC, Kind.RESIDUAL
    return (
        *(Variable(f"{seat}_{a}", alg, "m", f"{a} from the node to the point of departure") for a in "xz"),
        Variable(f"{seat}_rope", alg, "m", "unstretched length of rope between both"),
        *(Variable(f"{seat}_leaves_{a}", res, "m", f"tangency of the rope, {a}") for a in "xz"),
        Variable(f"{seat}_laid", res, "m", "length of rope on the shoe"),
    )


def side_residuals(v: Any, seat: str, found: Side, sign: int) -> dict[str, Any]:
    """Residuals of `side_variables`; `sign`: 1 where the rope arrives at the seat, -1 where it leaves."""
    x, z, rope = (getattr(v, f"{seat}_{name}") for name in ("x", "z", "rope"))
    return {
        f"{seat}_leaves_x": x - found.aside[0],
        f"{seat}_leaves_z": z - found.aside[1],
        f"{seat}_laid": rope - sign * found.rope,
    }


def laws_of_side(v: Any, seat: str, middle: tuple[Any, Any], *, free: bool = False) -> dict[str, laws.Law]:
    """Laws of `side_residuals`.

    `middle`: from the centre of the shoe to the reference point of the seat, (x, z) [m]; `free`: whether the rope may
    leave above the shoe.
    """
    x, z, rope = (getattr(v, f"{seat}_{name}") for name in ("x", "z", "rope"))
    end, side = getattr(v, seat), 1.0 if seat == "b" else -1.0
    place = (middle[0] + x, middle[1] + z)
    found = laws.on_arc(middle, place, end.force, (-side * rope, end.stretched), v.radius, side=side, free=free)
    return dict(zip((f"{seat}_leaves_x", f"{seat}_leaves_z", f"{seat}_laid"), found, strict=True))


def moment(place: tuple[Any, Any], force: np.ndarray) -> np.ndarray:
    """Moment of a force (3, ...) [N] about the centre of a shoe, at `place` (x, z) from it [N m]."""
    return np.asarray(place[0] * force[2] - place[1] * force[0])
