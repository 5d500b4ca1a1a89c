"""Initial guesses of a carriage at a station: from geometry, or from a solution of another model of the same rig."""

from __future__ import annotations

import numpy as np

from ropeway.components import shoe
from ropeway.components.component import Seat
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.node import Node
from ropeway.components.variable import Kind
from ropeway.systems.rigs import carriage_guess
from ropeway.systems.rigs.rope_paths import roller_name
from ropeway.systems.rigs.turn import Turn
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.line_state import support_points
from ropeway.systems.studies.skyline.carriage_model import Solved, SpanModel


def from_geometry(at: SpanModel, station: float, payload: float, height: float | None) -> Point:
    """Initial guess from geometry: the carriage on its ellipse (or at a `height` z [m]), nearly straight ropes, a free
    log."""
    rig, point, m = at.rig, at.declared(), at.model
    if at.on is None:
        start = rig.start(at.span, station, payload, height)
    else:
        start = rig.on_shoe_start(at.on, station, payload)
    a, b = rig.points[at.span : at.span + 2]
    here = np.array([station, a[1] + (b[1] - a[1]) * (station - a[0]) / (b[0] - a[0]), start.z])
    for slot, value in zip(at.axes, here, strict=True):
        point.vector(slot[0])[slot[1]] = value
    if rig.ideal:
        point.z[m.z.index[f"{rig.carriage.name}.holding"]] = start.pull
    if rig.turn is not None:
        _place_log(at, rig.turn, point, here, payload)
    if at.by_height and not rig.kind.keeps_length:
        point.p[m.p.index[f"{rig.skyline_drum}.tension"]] = start.tension
    for role, pull in (
        ("skyline", start.tension),
        ("mainline", start.pull),
        ("haulback", rig.haulback_tension or 0.0),
    ):
        if role in at.roles:
            _lay_straight(at, point, role, here, pull)
    return point


def off_shoe(at: SpanModel, solved: Solved) -> Point:
    """Initial guess of a carriage that has just left a shoe, from a solution with a holding force on the shoe. That
    force gives the length of rope that has left the shoe."""
    source, m, name = solved.at, at.model, at.rig.carriage.name
    point = _shared_values(at, solved)
    on = source.on or 0
    support = at.rig.supports[on]
    normal = shoe.normal_at(support.slope or 0.0)
    away = solved[f"{name}.x"] - support.centre[0], solved[f"{name}.z"] - support.centre[1]
    angle = float(np.arctan2(away[0] * normal[1] - away[1] * normal[0], away[0] * normal[0] + away[1] * normal[1]))
    off = solved.off_shoe / support.radius
    before = at.span == on  # the carriage is before the shoe, otherwise after it
    # Angles along the arc from its middle: of the rope next to the carriage, and of the mainline from its roller.
    touch = {"skyline": angle + off if before else angle - off, "mainline": angle - off}
    for role, owner, near in (
        ("skyline", support.name, "a" if before else "b"),
        ("mainline", roller_name(support), "b"),
    ):
        if f"{owner}.a_x" not in m.z.index:
            continue
        _leave_shoe(at, point, f"{owner}.{near}", support, touch[role], np.zeros(3))
        far = "mainline" if role == "mainline" else "b" if before else "a"
        more = np.array([solved[f"{name}.{far}_{quantity}"] for quantity in ("x", "z", "rope")])
        _leave_shoe(at, point, f"{owner}.{'b' if near == 'a' else 'a'}", support, angle, more)
    for r, (run, role) in enumerate(zip(source.model.runs, source.roles, strict=True)):
        if role not in ("skyline", "mainline", "haulback"):
            continue
        force = source.curves(solved.point, r)
        lengths = np.array([solved[f"{s.name}.length"] for s in run.spans])
        if len(m.runs[at.roles.index(role)].spans) > len(lengths):
            k = source.carriage_in(r)
            pull = solved[f"{name}.tension_a" if role == "skyline" else f"{name}.mainline_pull"]
            tangent = shoe.towards_b(shoe.normal_after(normal, touch[role]))
            force = np.insert(force, k, (pull * tangent[0], 0.0, pull * tangent[1]), axis=0)
            lengths = np.insert(lengths, k, solved.off_shoe)
        _lay(at, point, role, force, lengths)
    return point


def on_mainline(at: SpanModel, held: Solved) -> Point:
    """Initial guess of a carriage on its mainline, from a solution with an ideal holding force."""
    point, name = _shared_values(at, held), at.rig.carriage.name
    here = np.array([held[f"{name}.{axis}"] for axis in "xyz"])
    for r, (run, role) in enumerate(zip(held.at.model.runs, held.at.roles, strict=True)):
        if role in ("skyline", "haulback"):
            lengths = np.array([held[f"{s.name}.length"] for s in run.spans])
            _lay(at, point, role, held.at.curves(held.point, r), lengths)
    _lay_straight(at, point, "mainline", here, held[f"{name}.holding"])
    return point


def _shared_values(at: SpanModel, solved: Solved) -> Point:
    """A point with the values of another model's solution for variables of the same name."""
    point = at.declared()
    for here, there, kind in (
        (point.z, solved.point.z, Kind.ALGEBRAIC),
        (point.x, solved.point.x, Kind.STATE),
        (point.p, solved.point.p, Kind.PARAMETER),
    ):
        to, of = at.model.tables[kind].index, solved.at.model.tables[kind].index
        for variable in to.keys() & of.keys():
            if not variable.endswith(("length_start", "travel", ".grip")):  # each model has its own reference
                here[to[variable]] = there[of[variable]]
    return point


def _lay_straight(at: SpanModel, point: Point, role: str, here: np.ndarray, pull: float) -> None:
    """Sets a rope nearly straight, at an approximate tension [N], to a carriage at `here` (3,)."""
    r = at.roles.index(role)
    run, points = at.model.runs[r], support_points(at.model, r, point)
    points[[node.name == at.rig.carriage.name for node in run.nodes]] = here
    weight = run.rope.mass_per_length * at.rig.gravity
    lengths = carriage_guess.rope_lengths(points, weight, run.rope.strain, pull)
    d = np.diff(points, axis=0)
    chord = np.linalg.norm(d, axis=1)
    tension = np.maximum(pull, 0.5 * weight * chord)
    force = tension[:, None] * d / chord[:, None]
    force[:, 2] -= 0.5 * weight * lengths
    _lay(at, point, role, force, lengths)


def _lay(at: SpanModel, point: Point, role: str, force: np.ndarray, lengths: np.ndarray) -> None:
    """Sets tension vectors (spans, 3) and lengths (spans,) of a rope."""
    r = at.roles.index(role)
    layout, run, index = at.model.layouts[r], at.model.runs[r], at.model.z.index
    for axis in range(3):
        point.z[layout.force + axis] = force[:, axis]

    def on_shoe(node: Node, seat: Seat) -> float:
        return 0.0 if seat.offset is None else float(point.z[index[f"{node.name}.{seat.offset}_rope"]])

    more = lengths - point.p[layout.length_start]
    for k, (node, seat) in enumerate(zip(run.nodes, run.seats, strict=True)):
        if k > 0:
            more[k - 1] += on_shoe(node, seat)
        if k < len(more):
            more[k] -= on_shoe(node, node.through(seat) or seat)
    travel = np.append(np.cumsum(more[::-1])[::-1], 0.0)
    # A drum that is not an unknown does not change.
    x = point.x if role != "skyline" or at.by_height else point.x.copy()
    layout.travel.write(travel, x, point.z)
    if at.rig.carriage.clamped and role == "skyline":
        point.p[at.model.p.index[f"{at.rig.carriage.name}.travel"]] = travel[at.carriage_in(r)]


def _leave_shoe(
    at: SpanModel, point: Point, seat: str, support: IntermediateSupport, along: float, more: np.ndarray
) -> None:
    """Sets the point where a rope leaves a shoe: `along` its arc from the middle [rad], plus an offset `more` (3,)."""
    normal = shoe.normal_at(support.slope or 0.0)
    there = shoe.normal_after(normal, along)
    x, z = (support.radius * (n - n0) for n, n0 in zip(there, normal, strict=True))
    for value, quantity in zip(np.array([x, z, -support.radius * along]) + more, ("x", "z", "rope"), strict=True):
        point.z[at.model.z.index[f"{seat}_{quantity}"]] = value


def _place_log(at: SpanModel, turn: Turn, point: Point, here: np.ndarray, payload: float) -> None:
    """Initial guess of a log that hangs free under a carriage at `here` (3,)."""
    z, name = at.model.z.index, turn.log.name
    x, y, carriage_z = (float(v) for v in here)
    log = turn.under(x, y, carriage_z, payload, None)
    rear_x, rear_z, normal = log.rear_start()
    values = {"x": log.at[0], "y": y, "z": log.at[2], "rear_x": rear_x, "rear_z": rear_z, "normal": normal}
    for field, value in values.items():
        point.z[z[f"{name}.{field}"]] = value
    k = int(at.model.layouts[at.roles.index("dropline")].force[0])
    line = np.array(log.at) - here
    point.z[k : k + 3] = line / np.linalg.norm(line) * log.mass * at.rig.gravity
