"""A piece of rope between two supports, with loads clamped to it."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from ropeway.components import catenary, check, compliance
from ropeway.components.argument_checks import checked
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Component, RopeEnd
from ropeway.components.inertia import Inertia
from ropeway.components.moving_rope import MovingRope, in_span, slot_variables, typical_stretch
from ropeway.components.rope import Rope
from ropeway.components.variable import Equations, Kind, Limit, Site, Variable
from ropeway.components.weather import Weather


@checked
@dataclass(frozen=True)
class Span(Component):
    """A piece of rope from support a to support b.

    Loads occupy slots, in order from a. Load j hangs `slot_at + slot_ride * travel_a + slot_empty * length` from end a
    along the unstretched rope: a clamped load moves with the travel at a (1), one fixed at a distance does not (0), and
    an empty slot is a massless point at end b.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    rope : Rope
        Its rope.
    length : float
        Unstretched length at zero travel of both supports [m].

    Raises
    ------
    InputError
        A length that is not positive, or an invalid name.

    Examples
    --------
    >>> rw.Span("a_b", rope=rope, length=90.0).length
    90.0
    """

    rope: Rope
    length: float

    def __post_init__(self) -> None:
        super().__post_init__()
        check.positive(self.length, f"Span {self.name!r}", "length", "m")

    @property
    def a(self) -> RopeEnd:
        """The end at the first support."""
        return RopeEnd(self, "a")

    @property
    def b(self) -> RopeEnd:
        """The end at the second support."""
        return RopeEnd(self, "b")

    @property
    def ports(self) -> tuple[RopeEnd, ...]:
        return (self.a, self.b)

    def with_inertia(self, inertia: Inertia) -> Component:
        return MovingSpan(self.name, self.rope, self.length, inertia)

    def limits(self) -> tuple[Limit, ...]:
        return (
            Limit("utilisation", "tension above SWL", high=1.0 / self.rope.safety_factor),
            Limit("utilisation", "tension above MBL", high=1.0),
        )

    def structure(self, site: Site) -> Hashable:
        return self._constructional

    @property
    def _constructional(self) -> bool:
        """Whether the rope has construction stretch; elastic ropes have simpler equations."""
        return bool(self.rope.strain.c2 > 0.0)

    def variables(self, site: Site) -> tuple[Variable, ...]:
        rope, n, force, length = self.rope, site.slots, site.force, site.length
        strain = rope.strain
        par, alg, dis, res, out = Kind.PARAMETER, Kind.ALGEBRAIC, Kind.DISCRETE, Kind.RESIDUAL, Kind.OUTPUT

        stretch = "construction strain per tension squared"

        def slots(name: str, unit: str, description: str, value: float = 0.0) -> Variable:
            return Variable(name, dis, unit, description, (value,) * n, 1.0, n, hidden=True)

        return (
            Variable(
                "length_start", par, "m", "unstretched length at zero travel", self.length, length, range=POSITIVE
            ),
            Variable("mass_per_length", par, "kg/m", "mass per length", rope.mass_per_length, range=POSITIVE),
            Variable("compliance", par, "1/N", "elastic strain per tension, 1/EA", strain.c1, 1e-8, range=NOT_NEGATIVE),
            *(
                (Variable("construction", par, "1/N2", stretch, strain.c2, 1e-14, range=NOT_NEGATIVE),)
                if self._constructional
                else ()
            ),
            *(self._weather_variables() if site.weather else ()),
            Variable("breaking_load", par, "N", "minimum breaking load MBL", rope.breaking_load, force, range=POSITIVE),
            *(
                Variable(f"force_{axis}", alg, "N", f"tension vector at end a, {axis}", start, force)
                for axis, start in zip("xyz", site.tension, strict=True)
            ),
            slots("slot_mass", "kg", "mass of the load in each slot"),
            slots("slot_at", "m", "unstretched distance of each slot from end a at zero travel"),
            slots("slot_ride", "1", "1: the load moves with the rope, 0: fixed or empty"),
            *((slots("slot_drag", "m2", "drag area of the load in each slot"),) if site.weather else ()),
            slots("slot_empty", "1", "1: the slot is empty", 1.0),
            *(Variable(f"closure_{axis}", res, "m", f"span reaches end b, {axis}", 0.0, length) for axis in "xyz"),
            Variable("tension_a", out, "N", "tension at end a", nominal=force),
            Variable("tension_b", out, "N", "tension at end b", nominal=force),
            Variable("horizontal", out, "N", "horizontal tension", nominal=force),
            Variable("vertical_a", out, "N", "upward force of the support on the rope at end a", nominal=force),
            Variable("vertical_b", out, "N", "upward force of the support on the rope at end b", nominal=force),
            Variable("length", out, "m", "current unstretched length", nominal=length, freed_by="length_start"),
            *(
                Variable(f"load_{axis}", out, "N/m", f"weight, ice and wind on a metre as strung, {axis}", nominal=10.0)
                for axis in ("xyz" if site.weather else "")
            ),
            *(
                Variable(name, out, "1", "length without tension over that when strung")
                for name in (("expansion",) if site.weather else ())
            ),
            *(
                Variable(f"pull_b_{axis}", out, "N", f"tension vector at end b, {axis}", nominal=force, hidden=True)
                for axis in ("xy" if site.weather else "")
            ),
            Variable("elastic_energy", out, "J", "elastic energy of the rope", nominal=1e5),
            Variable("gravity_energy", out, "J", "potential energy of rope and loads relative to z = 0", nominal=1e6),
            Variable("utilisation", out, "1", "highest tension over minimum breaking load"),
            *(Variable(f"slot_{x}", out, "m", f"{x} of each slot", nominal=length, size=n, hidden=True) for x in "xyz"),
            Variable(
                "slot_distance", out, "m", "unstretched distance of each slot from end a", 0.0, length, n, hidden=True
            ),
        )

    def equations(self, v: Any) -> Equations:
        force = (v.force_x, v.force_y, v.force_z)
        length, distance = in_span(v)
        n = distance.numel()
        weight, strain, loads = self._hung(v, v.slot_mass)
        stations = catenary.loaded(force, weight, strain, length, [distance[j] for j in range(n)], loads)
        end = stations[-1]
        tension_a, tension_b = catenary.norm(force), catenary.norm(end.force)
        xp = catenary.namespace(tension_a)
        # A span's tension is highest at one of its ends: the vertical component grows from a to b.
        highest = xp.fmax(tension_a, tension_b)
        if v.weather is not None:  # loads that are blown aside bend the rope otherwise than its own weight does
            for station, load in zip(stations, loads, strict=False):
                behind = catenary.after(station.force, load)
                highest = xp.fmax(highest, xp.fmax(catenary.norm(station.force), catenary.norm(behind)))
        elastic, gravity = self._energy(v, force, weight, strain, loads, length, distance, stations)
        return Equations(
            residuals={
                f"closure_{axis}": end.reach[i] - (v.b.position[i] - v.a.position[i]) for i, axis in enumerate("xyz")
            },
            outputs={
                "tension_a": tension_a,
                "tension_b": tension_b,
                "horizontal": catenary.norm((force[0], force[1], 0.0)),
                "vertical_a": -force[2],
                "vertical_b": end.force[2],
                "length": length,
                **self._weather_outputs(weight, strain, end.force),
                "elastic_energy": elastic,
                "gravity_energy": gravity,
                "utilisation": highest / v.breaking_load,
                **{
                    f"slot_{axis}": xp.vertcat(*(v.a.position[i] + s.reach[i] for s in stations[:-1]))
                    for i, axis in enumerate("xyz")
                },
                "slot_distance": distance,
            },
            forces={"a": (-force[0], -force[1], -force[2]), "b": end.force},
            carried={"a": strain.potential(tension_a), "b": strain.potential(tension_b)},
            expansion=strain.expansion,
        )

    def closure_moves(self, v: Any) -> tuple[tuple[Any, ...], ...]:
        """Derivatives of the closure, each (3,): by the components of the tension vector, and by the travels at a and
        b. What differentiation of `equations` gives, in fewer operations."""
        found = self._moves(v)
        return (*found.by_force, *self._by_travels(v, found.by_length, found.by_distance))

    def force_moves(self, v: Any, closure: Sequence[Any]) -> list[catenary.Vector]:
        """How the tension vector moves so that the span reaches its end: for a closure (3,), and for each metre of
        travel at a and at b."""
        found = self._moves(v)
        own = found if found.plane is None else found.plane
        at_a, at_b = self._by_travels(v, own.by_length, own.by_distance)
        sides = [tuple(-miss for miss in side) for side in (closure, at_a, at_b)]
        if found.plane is None:
            return compliance.solved(found.by_force, sides)
        return found.plane.forces(sides[0], sides[1:])

    def _moves(self, v: Any) -> compliance.Moves:
        length, distance = in_span(v)
        weight, strain, loads = self._hung(v, v.slot_mass)
        distances = [distance[j] for j in range(distance.numel())]
        return compliance.moves((v.force_x, v.force_y, v.force_z), weight, strain, length, distances, loads)

    @staticmethod
    def _by_travels(
        v: Any, by_length: Sequence[Any], by_distance: Sequence[Sequence[Any]]
    ) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        """How an end moves by the travels at a and b, from its moves by the length and the distances of loads."""
        at_a, at_b = list(by_length), [-move for move in by_length]
        for j, moved in enumerate(by_distance):
            for i, own in enumerate(moved):
                at_a[i] += own * (v.slot_ride[j] + v.slot_empty[j])
                at_b[i] -= own * v.slot_empty[j]
        return tuple(at_a), tuple(at_b)

    def _hung(self, v: Any, mass: Any) -> tuple[catenary.Weight, catenary.Strain, list[Any]]:
        """Weight and strain of the rope, and its loads of some masses in the slots, as `catenary.loaded` takes them."""
        n = v.slot_at.numel()
        strain = catenary.Strain(v.compliance, v.construction if self._constructional else 0.0)
        weight: catenary.Weight = v.mass_per_length * v.gravity
        loads = [mass[j] * v.gravity for j in range(n)]
        if v.weather is not None:
            chord = tuple(v.b.position[i] - v.a.position[i] for i in range(3))
            weight = v.weather.rope(v.mass_per_length, v.gravity, v.diameter, v.drag_coefficient, chord)
            strain = strain._replace(expansion=v.weather.expansion(v.thermal_expansion))
            loads = [self._blown(v.weather, down, v.slot_drag[j]) for j, down in enumerate(loads)]
        return weight, strain, loads

    def _weather_variables(self) -> tuple[Variable, ...]:
        """What the weather needs to know of the rope."""
        par, rope = Kind.PARAMETER, self.rope
        return (
            Variable("diameter", par, "m", "diameter", rope.diameter or 0.0, 0.01, range=NOT_NEGATIVE),
            Variable(
                "thermal_expansion", par, "1/K", "thermal expansion", rope.thermal_expansion, 1e-5, range=NOT_NEGATIVE
            ),
            Variable("drag_coefficient", par, "1", "drag coefficient", rope.drag_coefficient, range=NOT_NEGATIVE),
        )

    @staticmethod
    def _blown(weather: Weather, down: Any, drag_area: Any) -> catenary.Vector:
        """Force of a load on the rope: its weight, and the wind on it."""
        x, y, _ = weather.drag(drag_area)
        return (x, y, -down)

    @staticmethod
    def _weather_outputs(weight: catenary.Weight, strain: catenary.Strain, end: catenary.Vector) -> dict[str, Any]:
        """The load on each metre of rope, and how the temperature has made it longer; none without weather."""
        if not isinstance(weight, catenary.Uniform):
            return {}
        force = {f"load_{axis}": weight.force[i] for i, axis in enumerate("xyz")}
        return {**force, "expansion": strain.expansion, "pull_b_x": end[0], "pull_b_y": end[1]}

    @staticmethod
    def _energy(
        v: Any,
        force: catenary.Vector,
        weight: catenary.Weight,
        strain: catenary.Strain,
        loads: list[Any],
        length: Any,
        distance: Any,
        stations: list[catenary.Segment],
    ) -> tuple[Any, Any]:
        """Elastic energy, and potential energy relative to the origin, also of a wind that does not change [J].
        Construction stretch stores none."""

        def potential(load: Any, reach: tuple[Any, ...], size: Any = 1) -> Any:
            """Of a load [N], downward or a vector, at a place seen from end a."""
            at = [v.a.position[i] + reach[i] for i in range(3)]
            return -sum(load[i] * size * at[i] for i in range(3)) if isinstance(load, tuple) else load * size * at[2]

        pull = weight.force if isinstance(weight, catenary.Uniform) else weight
        elastic, gravity, at, n = 0, 0, 0, distance.numel()
        reach: tuple[Any, ...] = (0, 0, 0)
        for j, station in enumerate(stations):
            here = distance[j] if j < n else length
            piece = catenary.energy(force, weight, here - at, strain)
            elastic += piece.elastic
            gravity += piece.gravity + potential(pull, reach, here - at)
            reach, force, at = station.reach, station.force, here
            if j < n:
                gravity += potential(loads[j], reach)
                force = catenary.after(force, loads[j])
        return elastic, gravity


@checked
@dataclass(frozen=True)
class MovingSpan(Span):
    """A span with the inertia of its rope and its loads; see `moving_rope`.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    rope : Rope
        Its rope.
    length : float
        Unstretched length at zero travel of both supports [m].
    inertia : Inertia
        Damping of the rope.
    """

    inertial: ClassVar[bool] = True
    inertia: Inertia = field(default_factory=Inertia)

    def limits(self) -> tuple[Limit, ...]:
        # A rope that pulls with less than its own weight sags by more than an eighth of its span.
        return (*super().limits(), Limit("tautness", "slack rope", low=1.0))

    def structure(self, site: Site) -> Hashable:
        return self._constructional

    def variables(self, site: Site) -> tuple[Variable, ...]:
        stretch = typical_stretch(site, self.rope.strain)
        own = [replace(v, nominal=stretch) if v.name.startswith("closure_") else v for v in super().variables(site)]
        return (*own, *slot_variables(site, self.inertia.damping, stretch))

    def equations(self, v: Any) -> Equations:
        rope = MovingRope(v, *self._hung(v, v.slot_mass * (1 - v.lost)))
        strain = rope.strain
        first, last, n = rope.pieces[0].first, rope.pieces[-1].last, rope.n
        tension_a, tension_b = catenary.norm(first), catenary.norm(last)
        hung, balances, inertia_a, inertia_b = rope.inertia()
        elastic, gravity = rope.stored
        velocities = rope.velocities
        xp = catenary.namespace(tension_a)

        def each(name: str, vectors: Sequence[catenary.Vector]) -> dict[str, Any]:
            return {f"{name}_{axis}": xp.vertcat(*(w[i] for w in vectors)) for i, axis in enumerate("xyz")}

        def own(name: str) -> list[catenary.Vector]:
            return [rope.of(name, j) for j in range(n)]

        return Equations(
            rates={
                **{f"place_{axis}": rope.free * getattr(v, f"velocity_{axis}") for axis in "xyz"},
                **{f"velocity_{axis}": rope.free * getattr(v, f"acceleration_{axis}") for axis in "xyz"},
            },
            residuals={
                **{f"closure_{axis}": miss for axis, miss in zip("xyz", rope.closure, strict=True)},
                **each("hung", hung),
                **each("balance", balances),
            },
            outputs={
                "tension_a": tension_a,
                "tension_b": tension_b,
                "horizontal": catenary.norm((first[0], first[1], 0.0)),
                "vertical_a": -first[2],
                "vertical_b": last[2],
                "length": rope.length,
                "elastic_energy": elastic,
                "gravity_energy": gravity,
                "kinetic_energy": rope.kinetic,
                **self._weather_outputs(rope.weight, strain, last),
                "utilisation": rope.highest / v.breaking_load,
                "tautness": rope.tautness,
                "slot_distance": rope.distance,
                **each("slot", rope.places),
                **each("slot_velocity", velocities[1:-1]),
                **each("slot_acceleration", own("acceleration")),
            },
            forces={"a": (-first[0], -first[1], -first[2]), "b": last},
            carried={"a": strain.potential(tension_a), "b": strain.potential(tension_b)},
            expansion=strain.expansion,
            inertia={"a": inertia_a, "b": inertia_b},
        )
