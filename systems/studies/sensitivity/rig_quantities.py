"""Quantities of a rig by name: what changes with them in the model of a station, and how they are set.

They are the station [m], the payload [kg], the height z of the carriage [m], the length [m] and the tension [N] of the
bare skyline, the axial stiffness [N] and the mass per length [kg/m] of a rope by its role ("skyline.axial_stiffness"),
and the parameters that the models of all spans have ("tail.z", "jack.friction").
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.rope import Rope
from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import nearest
from ropeway.systems.modelling.empty_rope import pretension
from ropeway.systems.rigs.bare_skyline import bare_equilibrium, bare_tension
from ropeway.systems.rigs.rig_builder import length_for
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.solvers.points import Point
from ropeway.systems.studies.sensitivity.linearisation import Exchange, LinearState, tangent_of
from ropeway.systems.studies.skyline.carriage_model import Solved, SpanModel

CASE = {"station": "m", "payload": "kg", "height": "m"}
"""Quantities of a station, with their units."""
_ROLES = ("skyline", "mainline", "haulback")
_OF_ROPES = {"axial_stiffness": "N", "mass_per_length": "kg/m"}
_OF_SKYLINE = {"length": "m", "tension": "N"}


class Entry(NamedTuple):
    """An entry of a model's vector that changes with a quantity, and its derivative."""

    kind: Kind
    place: int
    rate: float


def unit_of(at: SpanModel, name: str) -> str:
    """Unit of a quantity. Raises UnknownNameError."""
    known = {**CASE, **_OF_SKYLINE, **{f"{role}.{what}": u for role in _ROLES for what, u in _OF_ROPES.items()}}
    if name in known:
        return known[name]
    entry = _entry_of(at, name)
    return at.model.tables[entry.kind].units[entry.place]


def declared(at: SpanModel, name: str) -> float:
    """Value of a quantity as declared. Raises UnknownNameError."""
    rig = at.rig
    if name == "payload":
        return rig.carriage.payload
    if name == "length":
        return rig.length or 0.0
    if name == "tension":
        return rig.tension if rig.tension is not None else bare_tension(rig)
    role, _, quantity = name.rpartition(".")
    if role in _ROLES and quantity in _OF_ROPES:
        return float(getattr(_rope(at, role), quantity))
    entry = _entry_of(at, name)
    return float(at.declared().vector(entry.kind)[entry.place])


def entries(at: SpanModel, name: str, values: Mapping[str, float]) -> list[Entry]:
    """The entries of the model's vectors that change with a quantity other than station and height, where it and others
    have `values`. With a tension among these, the skyline's length also changes with its stiffness and weight. Raises
    UnknownNameError, InputError."""
    rig, layouts = at.rig, at.model.layouts
    if name == "payload":
        return [Entry(Kind.PARAMETER, at.payload, 1.0)]
    if name in _OF_SKYLINE:
        if rig.kind.keeps_length:
            return [_length_entry(at, 1.0 if name == "length" else _strung(rig, values).by_tension)]
        if name == "length":
            raise InputError(f"The {rig.kind.carrying_rope} of {rig.name!r} has no length", "Vary its tension")
        return [_entry_of(at, f"{rig.skyline_drum}.tension")]
    role, _, quantity = name.rpartition(".")
    if role not in _ROLES or quantity not in _OF_ROPES:
        return [_entry_of(at, name)]
    rope, layout = _rope(at, role), layouts[at.roles.index(role)]
    if quantity == "mass_per_length":
        rate, places = 1.0, layout.mass_per_length
    else:
        rate, places = -1.0 / values.get(name, rope.axial_stiffness) ** 2, layout.compliance
    found = [Entry(Kind.PARAMETER, int(k), rate) for k in places]
    if role == "skyline" and "tension" in values and rig.kind.keeps_length:
        strung = _strung(rig, values)
        found.append(_length_entry(at, strung.by_mass if quantity == "mass_per_length" else strung.by_stiffness))
    return found


def write(at: SpanModel, point: Point, values: Mapping[str, float]) -> None:
    """Sets quantities other than payload, station and height. Raises InputError for a value that one cannot have."""
    before = at.declared()
    for name, value in values.items():
        if name in CASE:
            continue
        if name.endswith(".axial_stiffness"):
            change = 1.0 / value - 1.0 / declared(at, name) if value > 0.0 else np.nan
        elif name == "tension" and at.rig.kind.keeps_length:
            change = _strung(at.rig, values).length - (at.rig.length or 0.0)
        else:
            change = value - declared(at, name)
        for kind, k, _ in entries(at, name, {}):
            after = float(before.vector(kind)[k]) + change
            if not np.isfinite(after) or at.model.tables[kind].ranges[k].refuses(after):
                raise InputError(f"{name} is {value:.6g} {unit_of(at, name)}", "Give bounds that it can have")
            point.vector(kind)[k] = after


def linearised(solved: Solved, names: Sequence[str], values: Mapping[str, float] | None = None) -> LinearState:
    """A solved station with the derivatives by quantities of the rig; `values` of those that are not as declared.
    Raises UnknownNameError, InputError."""
    at, k = solved.at, len(names)
    m = at.model
    x, u, p, d = (np.zeros((len(table), k)) for table in (m.x, m.u, m.p, m.d))
    vectors, rates = {Kind.STATE: x, Kind.INPUT: u, Kind.PARAMETER: p}, np.zeros((len(at.given), k))
    for j, name in enumerate(names):
        if name in ("station", "height"):
            slot = at.axes[0] if name == "station" else at.axes[2]
            if slot in at.given:
                rates[at.given.index(slot), j] = 1.0
            elif slot[0] is Kind.PARAMETER:
                vectors[slot[0]][slot[1], j] = 1.0
            else:
                raise InputError(f"The {name} of {at.rig.name!r} is a result here", "Give height=, on a terrain")
            continue
        for entry in entries(at, name, values or {}):
            vectors[entry.kind][entry.place, j] += entry.rate
    tangent = tangent_of(m)
    found = tangent.solve(solved.point, x, u, p, d, Exchange(at.freed, at.given, rates) if at.freed else None)
    return LinearState(solved.__getitem__, solved.slot, tangent.outputs(solved.point, found), found)


def _rope(at: SpanModel, role: str) -> Rope:
    """The rope of a role. Raises UnknownNameError."""
    if role not in at.roles:
        raise UnknownNameError(f"{at.rig.name!r} has no {role}", f"It has {', '.join(r for r in at.roles if r)}")
    return at.model.runs[at.roles.index(role)].rope


def _entry_of(at: SpanModel, name: str) -> Entry:
    """The entry of a parameter, an input or a state of the model. Raises UnknownNameError."""
    tables = at.model.tables
    for kind in (Kind.PARAMETER, Kind.INPUT, Kind.STATE):
        if name in tables[kind].index:
            return Entry(kind, tables[kind].index[name], 1.0)
    spans = {span.name for run in at.model.runs for span in run.spans}
    known = [n for n in tables[Kind.PARAMETER].names if n.rpartition(".")[0] not in spans]
    own = [*CASE, *_OF_SKYLINE, *(f"{role}.{what}" for role in at.roles if role in _ROLES for what in _OF_ROPES)]
    hint = nearest(name, [*own, *known])
    raise UnknownNameError(f"{at.rig.name!r} has no quantity {name!r} that can be varied", hint)


def _length_entry(at: SpanModel, rate: float) -> Entry:
    """The length of the skyline, whose spans share their rope."""
    return Entry(Kind.PARAMETER, int(at.model.layouts[at.skyline].length_start[-1]), rate)


class _Strung(NamedTuple):
    """Unstretched length of a skyline [m] for a tension of the bare skyline at the headspar, and its derivatives."""

    length: float
    by_tension: float
    by_stiffness: float
    by_mass: float


def _strung(rig: SkylineRig, values: Mapping[str, float]) -> _Strung:
    """The skyline's length for the tension, stiffness and mass per length among some values, else as declared."""
    tension = values.get("tension", rig.tension)
    rope = rig.skyline
    stiffness = values.get("skyline.axial_stiffness", rope.axial_stiffness)
    mass = values.get("skyline.mass_per_length", rope.mass_per_length)
    return _strung_with(rig, bare_tension(rig) if tension is None else float(tension), float(stiffness), float(mass))


@lru_cache(maxsize=64)
def _strung_with(rig: SkylineRig, tension: float, stiffness: float, mass: float) -> _Strung:
    rope = replace(rig.skyline, axial_stiffness=stiffness, mass_per_length=mass)
    length = length_for(replace(rig, skyline=rope), tension)
    if all(support.radius == 0.0 for support in rig.supports):
        names = [f"{a.name}_{b.name}" for a, b in pairwise(rig.ends)]
        rates = pretension(rig.points.tolist(), mass * rig.gravity, rope.strain, tension, names).length.sum(axis=0)
        return _Strung(length, rates[0], -rates[1] / stiffness**2, rates[2] * rig.gravity)
    bare, spans = bare_equilibrium(replace(rig, skyline=rope, length=length, tension=tension))
    m, layout, p = bare.model, bare.model.layouts[0], np.zeros((len(bare.model.p), 3))
    p[layout.length_start[-1], 0] = 1.0
    p[layout.compliance, 1] = -1.0 / stiffness**2
    p[layout.mass_per_length, 2] = 1.0
    x, u, d = (np.zeros((len(table), 3)) for table in (m.x, m.u, m.d))
    tangent = tangent_of(m)
    outputs = tangent.outputs(bare.point, tangent.solve(bare.point, x, u, p, d))
    by_length, by_stiffness, by_mass = outputs[m.y.index[f"{spans[0].name}.tension_a"]]
    return _Strung(length, 1.0 / by_length, -by_stiffness / by_length, -by_mass / by_length)
