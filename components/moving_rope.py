"""A span with inertia: exact catenaries between its loads, which have a place and a velocity of their own.

Behind each load slot the tension vector is an unknown, as at end a. A free slot is where its load is, so that the
catenaries on both sides end there; the difference of their tensions and of the load's weight accelerates the load. A
tied slot hangs in balance, as without inertia, and moves with the rope at its support, which carries its inertia; an
empty slot is tied to end b. A joined slot moves with the slot before it, where two loads hang together. The mass of
each piece of rope acts at its two ends.

The tension sees the geometry a short time, the damping, ahead: stiffness-proportional damping, without effect at rest.
"""

from __future__ import annotations

from functools import reduce
from typing import Any, NamedTuple

from ropeway.components import catenary
from ropeway.components.catenary import Strain, Uniform, Vector, Weight
from ropeway.components.variable import Kind, Site, Variable

AXES = "xyz"
_TYPICAL_MASS = 100.0
"""Scale of the residual of a given acceleration [kg]."""
_LEAST_STRAIN = 1e-4
"""Least typical strain of a rope, for the scale of residuals of length."""
_LEAST = 1.0
"""Horizontal tension of a rope that is cut [N]: a rope that hangs straight down has no direction."""
_NONE: Vector = (0.0, 0.0, 0.0)


def typical_stretch(site: Site, strain: Strain) -> float:
    """Typical stretch of a span, the scale of its residuals of length: forces and accelerations that correct them are
    typical ones [m]."""
    return site.length * max(site.force * float(strain.c1), _LEAST_STRAIN)


def slot_variables(site: Site, damping: float, stretch: float) -> tuple[Variable, ...]:
    """What a span has with inertia, besides the variables that it has without; `stretch`: the typical one."""
    n, zeros = site.slots, (0.0,) * site.slots

    def each(name: str, kind: Kind, unit: str, description: str, nominal: float = 1.0) -> tuple[Variable, ...]:
        return tuple(
            Variable(f"{name}_{a}", kind, unit, f"{description}, {a}", zeros, nominal, n, hidden=True) for a in AXES
        )

    state, alg, res, out = Kind.STATE, Kind.ALGEBRAIC, Kind.RESIDUAL, Kind.OUTPUT
    return (
        Variable("damping", Kind.PARAMETER, "s", "stiffness-proportional damping", damping, 1e-3),
        Variable("lumped", Kind.PARAMETER, "1", "share of the rope's mass that acts at the ends of its pieces alone"),
        *each("place", state, "m", "place of the load in each slot"),
        *each("velocity", state, "m/s", "velocity of the load in each slot"),
        *each("pull", alg, "N", "tension vector behind each slot", site.force),
        *each("acceleration", alg, "m/s2", "acceleration of each slot", 10.0),
        *each("hung", res, "m", "rope reaches each slot", stretch),
        *each("balance", res, "N", "forces on each slot", 0.01 * site.force),
        Variable("tied_a", Kind.DISCRETE, "1", "1: the slot moves with the rope at end a", zeros, 1.0, n),
        Variable("tied_b", Kind.DISCRETE, "1", "1: the slot moves with the rope at end b", (1.0,) * n, 1.0, n),
        Variable("joined", Kind.DISCRETE, "1", "1: the slot moves with the slot before", zeros, 1.0, n),
        Variable("lost", Kind.DISCRETE, "1", "1: the load in the slot is lost", zeros, 1.0, n),
        Variable("broken", Kind.DISCRETE, "1", "1: the rope is cut, and its parts hang from their supports"),
        Variable("tautness", out, "1", "least horizontal tension over the weight of the rope"),
        Variable("kinetic_energy", out, "J", "kinetic energy of rope and loads", nominal=1e3),
        *each("slot_velocity", out, "m/s", "velocity of each slot"),
        *each("slot_acceleration", out, "m/s2", "acceleration of each slot"),
    )


class Piece(NamedTuple):
    """A load-free piece: where it starts, seen from end a, the tension vectors at its start and end [N], its
    unstretched length [m]."""

    start: Vector
    first: Vector
    last: Vector
    length: Any


class Slot(NamedTuple):
    """A slot: its place as the rope sees it from end a, by how much the rope misses it if it is free [m], the force
    that accelerates it [N], and what its load adds to the tension vector of a rope in balance [N]."""

    place: Vector
    miss: Vector
    force: Vector
    load: Vector


def in_span(v: Any) -> tuple[Any, Any]:
    """Of a span the unstretched length between its supports, and the distance of each load slot from end a."""
    length = v.length_start + v.a.travel - v.b.travel
    return length, v.slot_at + v.slot_ride * v.a.travel + v.slot_empty * length


class MovingRope:
    """The pieces of a span with inertia, and its slots, on the symbols of its variables and ports."""

    def __init__(self, v: Any, weight: Weight, strain: Strain, loads: list[Any]) -> None:
        """`weight`, `strain` and `loads` as `catenary.loaded` takes them."""
        self.v, self.weight, self.strain, self.loads = v, weight, strain, loads
        self.shares = (2 + v.lumped) / 6, (1 - v.lumped) / 6  # of a piece's mass: at the same end, and across
        self.n = v.slot_at.numel()
        self.force = weight.force if isinstance(weight, Uniform) else (0.0, 0.0, -weight)  # on each metre of rope
        self.length, self.distance = in_span(v)
        self.free = 1 - v.tied_a - v.tied_b - v.joined
        self.mass = v.slot_mass * (1 - v.lost)
        self.yields = (v.compliance + _LEAST_STRAIN * 1e-5) * v.length_start  # metres of stretch for each newton
        self.pieces: list[Piece] = []
        self.slots: list[Slot] = []
        self.end = self._chain()
        first, last = self.pieces[0].first, self.pieces[-1].last
        self.along = _unit(first), _unit(last)

    def _chain(self) -> Vector:
        """Goes through the span piece by piece; returns where it ends. All places are seen from end a, so that far from
        the origin they are not rounded."""
        v, ahead = self.v, self.v.damping
        shift = v.a.speed - v.b.speed
        to = self.distance + ahead * (v.slot_ride * v.a.speed + v.slot_empty * shift)
        place, force, at = _times(ahead, v.a.velocity), (v.force_x, v.force_y, v.force_z), 0.0
        for j in range(self.n):
            piece, there = self._piece(place, force, to[j] - at)
            own = _moved(_minus(self.of("place", j), v.a.position), self.of("velocity", j), ahead)
            pull, miss, behind = self.of("pull", j), _minus(there, own), catenary.after(piece, self.loads[j])
            place = _minus(there, _times(self.free[j], miss))
            self.slots.append(Slot(place, miss, _minus(pull, behind), catenary.after(_NONE, self.loads[j])))
            force, at = pull, to[j]
        return self._piece(place, force, self.length + ahead * shift - at)[1]

    def _piece(self, start: Vector, force: Vector, length: Any) -> tuple[Vector, Vector]:
        """Adds a piece; returns the tension vector at its end, and where it ends."""
        found = catenary.segment(force, self.weight, length, self.strain)
        self.pieces.append(Piece(start, force, found.force, length))
        return found.force, _plus(start, found.reach)

    def of(self, name: str, j: int) -> Vector:
        """A vector of slot j."""
        x, y, z = (getattr(self.v, f"{name}_{axis}")[j] for axis in AXES)
        return (x, y, z)

    @property
    def places(self) -> list[Vector]:
        """Where the slots are [m]; tied ones as the rope sees them."""
        v, found = self.v, list[Vector]()
        for j, slot in enumerate(self.slots):
            ahead = _times(self.free[j] * v.damping, self.of("velocity", j))
            found.append(_plus(v.a.position, _minus(slot.place, ahead)))
        return found

    @property
    def closure(self) -> Vector:
        """By how much the rope misses its end b [m]; if it is cut, by how much its tension at end a differs from the
        weight of half the rope."""
        v = self.v
        miss = _minus(self.end, _moved(_minus(v.b.position, v.a.position), v.b.velocity, v.damping))
        half = _times(self.length / 2, self.force)
        hanging = (v.force_x - half[0] - _LEAST, v.force_y - half[1], v.force_z - half[2])
        return _plus(_times(1 - v.broken, miss), _times(v.broken * self.yields, hanging))

    def _ends(self, node: str, rope: str) -> tuple[Vector, Vector]:
        """A rate of the rope at both ends: that of the node, and that of the rope that runs over it."""
        a, b = ((getattr(end, node), getattr(end, rope)) for end in (self.v.a, self.v.b))
        return _plus(a[0], _times(a[1], self.along[0])), _plus(b[0], _times(b[1], self.along[1]))

    @property
    def velocities(self) -> list[Vector]:
        """Velocities of end a, all slots, and end b."""
        a, b = self._ends("velocity", "speed")
        found = [a]
        for j in range(self.n):
            bound = self._bound(j, a, b, found[-1])
            found.append(_plus(_times(self.free[j], self.of("velocity", j)), bound))
        return [*found, b]

    def _bound(self, j: int, a: Vector, b: Vector, before: Vector) -> Vector:
        """A rate of slot j where it is not free: that of its end, or of the slot before."""
        v = self.v
        ends = _plus(_times(v.tied_a[j], a), _times(v.tied_b[j], b))
        return _plus(ends, _times(v.joined[j], before))

    @property
    def kinetic(self) -> Any:
        """Kinetic energy of rope and loads [J]."""
        near, across = self.shares
        speeds, v = self.velocities, self.v
        energy = sum(self.mass[j] * _dot(speeds[j + 1], speeds[j + 1]) / 2 for j in range(self.n))
        for piece, a, b in zip(self.pieces, speeds[:-1], speeds[1:], strict=True):
            mass = v.mass_per_length * piece.length
            energy = energy + mass * (near / 2 * (_dot(a, a) + _dot(b, b)) + across * _dot(a, b))
        return energy

    def inertia(self) -> tuple[list[Vector], list[Vector], Vector, Vector]:
        """Residuals of the places and of the accelerations of all slots, and the inertia that the ends carry [N]."""
        v, n = self.v, self.n
        a, b = self._ends("acceleration", "rope_acceleration")
        each = [a, *(self.of("acceleration", j) for j in range(n)), b]
        at = [_minus(own, air) for own, air in zip(self._carried(each), self._air(), strict=True)]
        hung, balances, at_a, at_b = [], [], at[0], at[-1]
        for j, slot in enumerate(self.slots):
            own = at[j + 1]
            bound = _times(_TYPICAL_MASS, _minus(each[j + 1], self._bound(j, a, b, each[j])))
            balances.append(_chosen(self.free[j], _minus(own, slot.force), bound))
            # Of a rope that is cut the loads fall: only their weight accelerates them.
            fallen = v.broken * self.free[j]
            held = _plus(_minus(slot.force, _times(v.joined[j], own)), _times(fallen, slot.load))
            hangs = self.free[j] - fallen
            hung.append(_plus(_times(hangs, slot.miss), _times((1 - hangs) * self.yields, held)))
            at_a, at_b = _plus(at_a, _times(v.tied_a[j], own)), _plus(at_b, _times(v.tied_b[j], own))
        return hung, balances, at_a, at_b

    def _carried(self, each: list[Vector]) -> list[Vector]:
        """Forces that accelerate end a, all slots and end b with their loads and rope [N]; `each`: accelerations."""
        near, across = (share * self.v.mass_per_length for share in self.shares)
        own = [0.0, *(self.mass[j] for j in range(self.n)), 0.0]
        for k, piece in enumerate(self.pieces):
            own[k], own[k + 1] = own[k] + near * piece.length, own[k + 1] + near * piece.length
        found = [_times(mass, rate) for mass, rate in zip(own, each, strict=True)]
        for k, piece in enumerate(self.pieces):
            mass = across * piece.length
            found[k], found[k + 1] = _moved(found[k], each[k + 1], mass), _moved(found[k + 1], each[k], mass)
        return found

    def _air(self) -> list[Vector]:
        """By how much the wind on moving loads and rope differs from that on resting ones, at end a, all slots and end
        b [N]; none without weather. It is quadratic in the relative velocity, and across the rope."""
        v, weather, speeds = self.v, self.v.weather, self.velocities
        found: list[Vector] = [_NONE] * len(speeds)
        if weather is None:
            return found
        for j in range(self.n):
            found[j + 1] = _times(v.slot_drag[j] * (1 - v.lost[j]), weather.relative(speeds[j + 1]))
        width = v.drag_coefficient * (v.diameter + 2 * weather.ice_thickness)
        for k, piece in enumerate(self.pieces):
            mean = _times(0.5, _plus(speeds[k], speeds[k + 1]))
            half = _times(width * piece.length / 2, weather.relative(mean, _unit(piece.first)))
            found[k], found[k + 1] = _plus(found[k], half), _plus(found[k + 1], half)
        return found

    @property
    def stored(self) -> tuple[Any, Any]:
        """Elastic energy, and potential energy relative to z = 0 [J]."""
        elastic, gravity = 0, 0
        for piece in self.pieces:
            own = catenary.energy(piece.first, self.weight, piece.length, self.strain)
            elastic, gravity = elastic + own.elastic, gravity + own.gravity
            gravity = gravity - piece.length * _dot(self.force, _plus(piece.start, self.v.a.position))
        for slot, place in zip(self.slots, self.places, strict=True):
            # A load adds to the tension vector what pulls it, against its own direction.
            gravity = gravity + _dot(slot.load, place)
        return elastic, gravity

    @property
    def highest(self) -> Any:
        """Highest tension at an end of a piece [N]."""
        tensions = [catenary.norm(f) for piece in self.pieces for f in (piece.first, piece.last)]
        return reduce(catenary.namespace(tensions[0]).fmax, tensions)

    @property
    def tautness(self) -> Any:
        """Least horizontal tension over the weight of the rope; above 1 if it is cut."""
        level = [catenary.norm((piece.first[0], piece.first[1], 0.0)) for piece in self.pieces]
        weight = self.weight.size if isinstance(self.weight, catenary.Uniform) else self.weight
        return reduce(catenary.namespace(level[0]).fmin, level) / (weight * self.length) + 2 * self.v.broken


def _unit(force: Vector) -> Vector:
    return _times(1 / catenary.norm(force), force)


def _moved(place: Vector, velocity: Vector, time: Any) -> Vector:
    return _plus(place, _times(time, velocity))


def _plus(a: Vector, b: Vector) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _times(factor: Any, a: Vector) -> Vector:
    return (factor * a[0], factor * a[1], factor * a[2])


def _dot(a: Vector, b: Vector) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _chosen(share: Any, a: Vector, b: Vector) -> Vector:
    """The first vector where share is 1, the second where it is 0."""
    return _plus(_times(share, a), _times(1 - share, b))
