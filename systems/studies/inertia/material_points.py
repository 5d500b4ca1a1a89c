"""An equilibrium whose ropes are cut into exact pieces at material points: loads, and nodes of the rope."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from ropeway.components import catenary
from ropeway.components.argument_checks import checked
from ropeway.components.check import PartName
from ropeway.components.component import Seat
from ropeway.components.errors import InputError
from ropeway.components.joint import Joint
from ropeway.components.span import Span
from ropeway.components.variable import Site
from ropeway.systems.dynamics.inertia.inertial_system import rope_nodes
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model, component_of
from ropeway.systems.solvers.newton import Point, newton_of
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.resting import same_values

_SHORTEST = 1e-6
"""Pieces of rope shorter than this part of their span are left out."""
_EXACT = 1e-7
"""Largest scaled residual of the cut line at rest."""
_OF_ROPE = ("mass_per_length", "compliance", "construction", "breaking_load")


@checked
@dataclass(frozen=True)
class RopePoint(Joint):
    """A point of a rope, with the mass of a load that is clamped there. The rope continues through it."""

    ends: int = 2

    def through(self, seat: Seat) -> Seat | None:
        return self.seats[1] if seat == self.seats[0] else None

    def structure(self, site: Site) -> Hashable:
        return self.ends


@dataclass(frozen=True)
class CutSpan:
    """A span cut into pieces.

    names : names of its points, its ends included, (points,).
    station : unstretched distance of the points from end a [m], (points,).
    place : position of the points [m], (points, 3).
    pieces : names of the pieces, (points - 1,).
    force : tension vector at the start and at the end of each piece [N], (points - 1, 2, 3).
    lumped : share of the mass of a piece that acts at its ends alone: a half with rope nodes, most accurate for waves;
        none without, exact for straight pieces.
    """

    name: str
    names: tuple[str, ...]
    station: np.ndarray
    place: np.ndarray
    pieces: tuple[str, ...]
    force: np.ndarray
    lumped: float


@dataclass(frozen=True)
class MaterialPoints:
    """An equilibrium as a point of a model with a node at each material point, and its cut spans."""

    model: Model
    point: Point
    spans: tuple[CutSpan, ...]


def material_points(line: Equilibrium, nodes: int) -> MaterialPoints:
    """The equilibrium with `nodes` rope nodes in each span, spread over its load-free pieces. Raises InputError."""
    system = line.model.system.copy()
    system.hung, system.feeds = [], []
    cut: list[CutSpan] = []
    for r, run in enumerate(line.runs):
        for k, span in enumerate(run.spans):
            own, masses = _cut(line, r, k, nodes)
            cut.append(own)
            del system.components[span.name]
            ends = [system.connections.pop((span.name, end)) for end in "ab"]
            points = [
                system.add(RopePoint(PartName(f"{name}.point"), at=tuple(map(float, at)), mass=mass))
                for name, at, mass in zip(own.pieces[1:], own.place[1:-1], masses, strict=True)
            ]
            lengths = np.diff(own.station)
            for i, (name, length) in enumerate(zip(own.pieces, lengths, strict=True)):
                piece = system.add(Span(PartName(name), rope=span.rope, length=float(length)))
                joined = [points[i - 1].seats[1] if i else None, points[i].seats[0] if i < len(points) else None]
                for end, seat, declared in zip("ab", joined, ends, strict=True):
                    to = declared if seat is None else (seat.owner.name, seat.name)
                    system.connections[piece.name, end] = to
                    system.seated.add(to)
    model = assemble(system)
    return MaterialPoints(model, _point(line, model, cut), tuple(cut))


def _cut(line: Equilibrium, r: int, k: int, nodes: int) -> tuple[CutSpan, list[float]]:
    """A span cut at its loads and rope nodes, and the masses at its inner points."""
    run, point, p = line.runs[r], line.point, line.model.p.index
    name, length = run.spans[k].name, line[f"{run.spans[k].name}.length"]
    loads = line.loads[line.loads["span"] == name]
    inner = loads[(loads["distance"] > _SHORTEST * length) & (loads["distance"] < (1.0 - _SHORTEST) * length)]
    hung = dict[float, tuple[str, float]]()
    for load in inner.itertuples():
        at = next((d for d in hung if abs(d - load.distance) <= _SHORTEST * length), float(load.distance))
        others, mass = hung.get(at, ("", 0.0))  # at one place they are one point
        hung[at] = (f"{others}, {load.load}" if others else str(load.load), mass + float(load.mass))
    (own,) = rope_nodes(run, np.array([length]), [np.array(list(hung))], nodes)
    hung.update({float(at): (f"{name} {at:.4g} m", 0.0) for at in own})
    station = [0.0, *sorted(hung), length]
    names = [run.nodes[k].name, *(hung[at][0] for at in station[1:-1]), run.nodes[k + 1].name]
    masses = [hung[at][1] for at in station[1:-1]]
    force, gravity = point.z[line.model.layouts[r].force[k] :][:3], float(point.p[0])
    strain = catenary.Strain(point.p[p[f"{name}.compliance"]], run.rope.strain.c2)
    weight = point.p[p[f"{name}.mass_per_length"]] * gravity
    pulls = [mass * gravity for mass in masses]
    first = loads[loads["distance"] <= _SHORTEST * length]["mass"].sum() * gravity  # it stands on the support
    start = (float(force[0]), float(force[1]), float(force[2]) + float(first))
    stations = catenary.loaded(start, weight, strain, length, station[1:-1], pulls)
    ends = np.array([s.force for s in stations], dtype=float)
    starts = np.vstack([start, ends[:-1]])
    starts[1:, 2] += pulls
    reach = np.array([(0.0, 0.0, 0.0), *(s.reach for s in stations)], dtype=float)
    return CutSpan(
        name,
        tuple(names),
        np.array(station),
        run.start(k, line.__getitem__) + reach,
        tuple(f"{name}.piece_{i + 1}" for i in range(len(stations))),
        np.stack([starts, ends], axis=1),
        0.5 if len(own) else 0.0,
    ), masses


def _point(line: Equilibrium, model: Model, cut: Sequence[CutSpan]) -> Point:
    """The point of the model with pieces at the equilibrium. Raises InputError."""
    point = same_values(line.model, line.point, model)
    travels = _travels(line)
    for span, (at_a, at_b) in zip(cut, travels, strict=True):
        lengths = np.diff(span.station)
        lengths[0] -= at_a
        lengths[-1] += at_b
        for name, length, force in zip(span.pieces, lengths, span.force[:, 0], strict=True):
            first = model.z.index[f"{name}.force_x"]
            point.z[first : first + 3] = force
            point.p[model.p.index[f"{name}.length_start"]] = length
            for value in _OF_ROPE:
                if f"{name}.{value}" in model.p.index:
                    point.p[model.p.index[f"{name}.{value}"]] = line.point.p[line.model.p.index[f"{span.name}.{value}"]]
    newton = newton_of(model)
    missed = np.abs(newton.functions.residual(*newton.arguments(point)).full().ravel())
    if not missed.max(initial=0.0) < _EXACT:
        name = component_of(model.r.names[int(missed.argmax())])
        raise InputError(
            f"A load stands on {name!r}, or {name!r} is not at rest", "Take an equilibrium with all loads in spans"
        )
    return point


def _travels(line: Equilibrium) -> list[tuple[float, float]]:
    """Travel at both ends of each span, with the rope that lies on a shoe [m]."""
    found = []
    for layout, q in zip(line.model.layouts, line.model.travels(line.point.x, line.point.z), strict=True):
        aside = np.where(layout.aside >= 0, line.point.z[layout.aside], 0.0)
        found += list(zip((q[:-1] + aside[0]).tolist(), (q[1:] + aside[1]).tolist(), strict=True))
    return found
