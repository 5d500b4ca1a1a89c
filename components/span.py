"""A piece of rope between two supports, with loads clamped to it."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from ropeway.components import catenary, check
from ropeway.components.argument_checks import checked
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Component, RopeEnd
from ropeway.components.inertia import Inertia
from ropeway.components.moving_rope import MovingRope, slot_variables, typical_stretch
from ropeway.components.rope import Rope
from ropeway.components.variable import Equations, Kind, Limit, Site, Variable


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
            Variable("breaking_load", par, "N", "minimum breaking load MBL", rope.breaking_load, force, range=POSITIVE),
            *(
                Variable(f"force_{axis}", alg, "N", f"tension vector at end a, {axis}", start, force)
                for axis, start in zip("xyz", site.tension, strict=True)
            ),
            slots("slot_mass", "kg", "mass of the load in each slot"),
            slots("slot_at", "m", "unstretched distance of each slot from end a at zero travel"),
            slots("slot_ride", "1", "1: the load moves with the rope, 0: fixed or empty"),
            slots("slot_empty", "1", "1: the slot is empty", 1.0),
            *(Variable(f"closure_{axis}", res, "m", f"span reaches end b, {axis}", 0.0, length) for axis in "xyz"),
            Variable("tension_a", out, "N", "tension at end a", nominal=force),
            Variable("tension_b", out, "N", "tension at end b", nominal=force),
            Variable("horizontal", out, "N", "horizontal tension", nominal=force),
            Variable("vertical_a", out, "N", "upward force of the support on the rope at end a", nominal=force),
            Variable("vertical_b", out, "N", "upward force of the support on the rope at end b", nominal=force),
            Variable("length", out, "m", "current unstretched length", nominal=length, freed_by="length_start"),
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
        length = v.length_start + v.a.travel - v.b.travel
        distance = v.slot_at + v.slot_ride * v.a.travel + v.slot_empty * length
        n = distance.numel()
        strain = catenary.Strain(v.compliance, v.construction if self._constructional else 0.0)
        weight = v.mass_per_length * v.gravity
        stations = catenary.loaded(
            force,
            weight,
            strain,
            length,
            [distance[j] for j in range(n)],
            [v.slot_mass[j] * v.gravity for j in range(n)],
        )
        end = stations[-1]
        # A span's tension is highest at one of its ends: the vertical component grows from a to b.
        tension_a, tension_b = catenary.norm(force), catenary.norm(end.force)
        xp = catenary.namespace(tension_a)
        elastic, gravity = self._energy(v, force, weight, length, distance, stations)
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
                "elastic_energy": elastic,
                "gravity_energy": gravity,
                "utilisation": xp.fmax(tension_a, tension_b) / v.breaking_load,
                **{
                    f"slot_{axis}": xp.vertcat(*(v.a.position[i] + s.reach[i] for s in stations[:-1]))
                    for i, axis in enumerate("xyz")
                },
                "slot_distance": distance,
            },
            forces={"a": (-force[0], -force[1], -force[2]), "b": end.force},
            carried={"a": strain.potential(tension_a), "b": strain.potential(tension_b)},
        )

    @staticmethod
    def _energy(
        v: Any, force: catenary.Vector, weight: Any, length: Any, distance: Any, stations: list[catenary.Segment]
    ) -> tuple[Any, Any]:
        """Elastic energy, and potential energy relative to z = 0 [J]. Construction stretch stores none."""
        elastic, gravity, at, height = 0, 0, 0, v.a.position[2]
        n = distance.numel()
        for j, station in enumerate(stations):
            here = distance[j] if j < n else length
            piece = catenary.energy(force, weight, here - at, v.compliance)
            elastic += piece.elastic
            gravity += piece.gravity + weight * (here - at) * height
            height = v.a.position[2] + station.reach[2]
            load = v.slot_mass[j] * v.gravity if j < n else 0
            gravity += load * height
            force = (station.force[0], station.force[1], station.force[2] + load)
            at = here
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
        strain = catenary.Strain(v.compliance, v.construction if self._constructional else 0.0)
        rope = MovingRope(v, strain)
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
                "utilisation": rope.highest / v.breaking_load,
                "tautness": rope.tautness,
                "slot_distance": rope.distance,
                **each("slot", rope.places),
                **each("slot_velocity", velocities[1:-1]),
                **each("slot_acceleration", own("acceleration")),
            },
            forces={"a": (-first[0], -first[1], -first[2]), "b": last},
            carried={"a": strain.potential(tension_a), "b": strain.potential(tension_b)},
            inertia={"a": inertia_a, "b": inertia_b},
        )
