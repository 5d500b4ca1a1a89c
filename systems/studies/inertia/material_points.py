"""An equilibrium whose ropes are cut into exact pieces at material points: loads, and nodes of the rope."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ropeway.components import catenary
from ropeway.components.argument_checks import checked
from ropeway.components.check import PartName
from ropeway.components.component import Seat
from ropeway.components.errors import InputError
from ropeway.components.joint import Joint
from ropeway.components.span import Span
from ropeway.components.variable import Equations, Site, Variable
from ropeway.components.weather import drag_variables
from ropeway.systems.dynamics.inertia.inertial_system import rope_nodes
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model, component_of
from ropeway.systems.solvers.newton import newton_of, residuals_of
from ropeway.systems.solvers.points import VECTORS, Point
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import load_force, span_rope
from ropeway.systems.statics.resting import same_values

_SHORTEST = 1e-6
"""Pieces of rope shorter than this part of their span are left out."""
_EXACT = 1e-7
"""Largest scaled residual of the cut line at rest."""
_OF_ROPE = (
    "mass_per_length",
    "compliance",
    "construction",
    "breaking_load",
    "diameter",
    "thermal_expansion",
    "drag_coefficient",
)


@checked
@dataclass(frozen=True)
class RopePoint(Joint):
    """A point of a rope, with the mass and drag area [m2] of a load that is clamped there. The rope continues through
    it."""

    ends: int = 2
    drag_area: float = 0.0

    def through(self, seat: Seat) -> Seat | None:
        return self.seats[1] if seat == self.seats[0] else None

    def structure(self, site: Site) -> Hashable:
        return self.ends

    def variables(self, site: Site) -> tuple[Variable, ...]:
        return (*super().variables(site), *drag_variables(site, self.drag_area))

    def equations(self, v: Any) -> Equations:
        found = super().equations(v)
        if v.weather is None:
            return found
        blown = zip("xyz", v.weather.drag(v.drag_area), strict=True)
        return replace(found, residuals={f"balance_{a}": found.residuals[f"balance_{a}"] + f for a, f in blown})


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

    def read(self, name: str, missing: float | None = None) -> float:
        """A state, algebraic variable, input or parameter by its name. Raises KeyError where it is `missing`."""
        for kind in VECTORS:
            index = self.model.tables[kind].index.get(name)
            if index is not None:
                return float(self.point.vector(kind)[index])
        if missing is None:
            raise KeyError(name)
        return missing


def material_points(line: Equilibrium, nodes: int) -> MaterialPoints:
    """The equilibrium with `nodes` rope nodes in each span, spread over its load-free pieces. Raises InputError."""
    system = line.model.system.copy()
    system.hung, system.feeds = [], []
    cut: list[CutSpan] = []
    for r, run in enumerate(line.runs):
        for k, span in enumerate(run.spans):
            inner = _inner_points(line, r, k, nodes)
            own = _cut(line, r, k, inner)
            cut.append(own)
            del system.components[span.name]
            ends = [system.connections.pop((span.name, end)) for end in "ab"]
            points = [
                system.add(RopePoint(PartName(f"{name}.point"), tuple(map(float, at)), p.mass, drag_area=p.drag_area))
                for name, at, p in zip(own.pieces[1:], own.place[1:-1], inner.values(), strict=True)
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


class _Inner(NamedTuple):
    """An inner point of a span: its name, and the mass [kg] and drag area [m2] of the loads that hang there."""

    name: str
    mass: float = 0.0
    drag_area: float = 0.0

    def __add__(self, other: object) -> _Inner:
        if not isinstance(other, _Inner):
            return NotImplemented
        return _Inner(f"{self.name}, {other.name}", self.mass + other.mass, self.drag_area + other.drag_area)


def _inner_points(line: Equilibrium, r: int, k: int, nodes: int) -> dict[float, _Inner]:
    """The inner points of a span by their distance from end a [m], in order."""
    run, name = line.runs[r], line.runs[r].spans[k].name
    length, loads = line[f"{name}.length"], line.loads[line.loads["span"] == name]
    drag = dict(zip(run.loads.names, run.loads.drag.tolist(), strict=True))
    found = dict[float, _Inner]()
    for load in loads.itertuples():
        distance, own = float(load.distance), _Inner(str(load.load), float(load.mass), drag[str(load.load)])
        if not _SHORTEST * length < distance < (1.0 - _SHORTEST) * length:
            continue
        known = next((at for at in found if abs(at - distance) <= _SHORTEST * length), None)
        if known is None:
            found[distance] = own
        else:  # at one place they are one point
            found[known] = found[known] + own
    (rope,) = rope_nodes(run, np.array([length]), [np.array(list(found))], nodes)
    found.update({float(at): _Inner(f"{name} {at:.4g} m") for at in rope})
    return dict(sorted(found.items()))


def _cut(line: Equilibrium, r: int, k: int, inner: Mapping[float, _Inner]) -> CutSpan:
    """A span cut at its inner points."""
    run, name = line.runs[r], line.runs[r].spans[k].name
    loads, length = line.loads[line.loads["span"] == name], line[f"{name}.length"]
    rope = span_rope(line.model, run, k, line.__getitem__)
    pulls = [load_force(line.model, own.mass, own.drag_area, line.__getitem__) for own in inner.values()]
    # Loads that stand on the support hang behind it.
    first = float(loads[loads["distance"] <= _SHORTEST * length]["mass"].sum())
    force = line.point.z[line.model.layouts[r].force[k] :][:3].tolist()
    start = catenary.after((force[0], force[1], force[2]), first * line["gravity"])
    stations = catenary.loaded(start, rope.weight, rope.strain, length, list(inner), pulls)
    starts = [start, *(catenary.after(s.force, pull) for s, pull in zip(stations, pulls, strict=False))]
    reach = np.array([(0.0, 0.0, 0.0), *(s.reach for s in stations)], dtype=float)
    return CutSpan(
        name,
        (run.nodes[k].name, *(own.name for own in inner.values()), run.nodes[k + 1].name),
        np.array([0.0, *inner, length]),
        run.start(k, line.__getitem__) + reach,
        tuple(f"{name}.piece_{i + 1}" for i in range(len(stations))),
        np.array([(before, after.force) for before, after in zip(starts, stations, strict=True)], dtype=float),
        0.5 if any(own.mass == 0.0 for own in inner.values()) else 0.0,
    )


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
    if model.weather:  # each piece faces the wind by its own chord
        newton_of(model).solve(point)
    missed = np.abs(residuals_of(model)(*point.arguments)[0] / model.r.nominals)
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
