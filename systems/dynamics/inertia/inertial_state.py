"""A line with inertia: its model, and its state from that of the quasi-static line."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ropeway.components.errors import InputError
from ropeway.components.inertia import Inertia
from ropeway.components.variable import Kind
from ropeway.systems.dynamics.inertia.inertial_system import (
    carries_loads,
    require_fitting,
    rope_nodes,
    with_inertia,
)
from ropeway.systems.modelling.assembly import assembled
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.rope_path import Loads, Run
from ropeway.systems.solvers.newton import newton_of, outputs_of
from ropeway.systems.solvers.points import VECTORS, Point
from ropeway.systems.statics.line_records import AnyRecord, Record
from ropeway.systems.statics.line_state import LineState, declared_point, with_more_slots
from ropeway.systems.statics.load_positions import unpin

_DIFFERENCE = 1e-4
"""Time over which velocities are differences of places [s]."""

_SLACK = 1.005
"""By how much the rope between two supports can become longer, before it needs more slots than at the start."""

JOINED = 0.1
"""Loads that hang nearer together than this move together [m]."""

AXES = "xyz"


@dataclass(frozen=True)
class SlotMotion:
    """Places of the slots' motion in the vectors of a model with inertia: of the first slot of each span of a run.
    `place`, `velocity` (3, spans) in the states; `pull`, `acceleration` (3, spans) in the algebraic variables; `tied`
    (2, spans), to ends a and b, `joined` and `lost` (spans,) in the discrete ones. A span without slots has places that
    are not used."""

    place: np.ndarray
    velocity: np.ndarray
    pull: np.ndarray
    acceleration: np.ndarray
    tied: np.ndarray
    joined: np.ndarray
    lost: np.ndarray


@kept_with_model
def slot_motions(model: Model) -> tuple[SlotMotion, ...]:
    """The slots' motion of each run."""

    def first(run: Run, kind: Kind, name: str) -> list[int]:
        index = model.tables[kind].index
        return [index.get(f"{span.name}.{name}[1]", 0) for span in run.spans]

    def places(run: Run, kind: Kind, name: str, ends: str = AXES) -> np.ndarray:
        return np.array([first(run, kind, f"{name}_{end}") for end in ends])

    return tuple(
        SlotMotion(
            places(run, Kind.STATE, "place"),
            places(run, Kind.STATE, "velocity"),
            places(run, Kind.ALGEBRAIC, "pull"),
            places(run, Kind.ALGEBRAIC, "acceleration"),
            places(run, Kind.DISCRETE, "tied", "ab"),
            np.array(first(run, Kind.DISCRETE, "joined")),
            np.array(first(run, Kind.DISCRETE, "lost")),
        )
        for run in model.runs
    )


@kept_with_model
def inertial_model(model: Model, inertia: Inertia, slots: tuple[tuple[int, ...], ...]) -> Model:
    """The model of the same declarations with inertia, with numbers of load slots in each span of each run. Raises
    InputError where the inertia does not fit a rope."""
    for run in model.runs:
        require_fitting(run, inertia)
    found = assembled(with_inertia(model.system, inertia), slots, inertia)
    if len(found.x) == 0:
        raise InputError(
            f"Nothing in {model.name!r} can move with inertia: it has no load, wheel or carriage",
            "Give rope nodes, as inertia=rw.Inertia(nodes=6), or leave out inertia=",
        )
    for run, layout in zip(found.runs, found.layouts, strict=True):
        still = np.flatnonzero((layout.travel.algebraic >= 0) & carries_loads(run))
        if len(still):
            node = run.nodes[int(still[0])]
            raise InputError(
                f"Loads run over {node.described}, whose rope has no inertia there",
                "With inertia loads run over Sheave, ControlSheave, TensionedReturn and Drum",
            )
    return found


def inertial_state(state: LineState, inertia: Inertia, rates: tuple[np.ndarray, np.ndarray] | None = None) -> LineState:
    """The state of a line with inertia that moves as the quasi-static line does: with the rates (nx,) and (nz,) of its
    states and algebraic variables [per s], by default at rest.

    Loads are clamped to the rope. The accelerations are solved. Raises InputError, EquilibriumError.
    """
    quasi = _noded(state, inertia)
    model, old = quasi.model, quasi.point
    moving = inertial_model(model, inertia, tuple(_slots(quasi, r) for r in range(len(quasi.runs))))
    point = declared_point(moving)
    for kind in VECTORS:
        own, table = point.vector(kind), moving.tables[kind].index
        for other in VECTORS:
            for name, value in zip(model.tables[other].names, old.vector(other), strict=True):
                if name in table:
                    own[table[name]] = value
    runs = [replace(own, loads=run.loads) for own, run in zip(moving.runs, quasi.runs, strict=True)]
    found = LineState(moving, replace(point, t=old.t), runs, quasi.passed)
    x_rate, z_rate = (np.zeros(len(old.x)), np.zeros(len(old.z))) if rates is None else rates
    _set_rates(found, model, {Kind.STATE: x_rate, Kind.ALGEBRAIC: z_rate})
    found.write_slots()
    for r in range(len(runs)):
        _start_slots(found, quasi, r, _station_rates(quasi, x_rate, z_rate))
        _share_mass(found, r)
        _set_directions(found, quasi.points(r), r)
    newton_of(moving).solve(found.point)
    return found


def _share_mass(state: LineState, r: int) -> None:
    """Sets how the mass of rope acts. Where the rope moves in straight lines between a load and its supports, the
    consistent mass matrix is exact; the waves of a span without loads between supports are most accurate with the mean
    of the consistent and the lumped matrix."""
    run, index, beyond = state.runs[r], state.model.p.index, state.passed[r]
    stand = [f"{node.name}.x" in index for node in run.nodes]
    for k, span in enumerate(run.spans):
        own = run.loads.mass[int(beyond[k + 1]) : int(beyond[k])]
        waves = len(own) > 0 and not own.any() and stand[k] and stand[k + 1]
        state.point.p[index[f"{span.name}.lumped"]] = 0.5 if waves else 0.0


def _set_directions(state: LineState, points: np.ndarray, r: int) -> None:
    """Sets the direction of a rope on which a node rolls, from the `points` of a run's supports (supports, 3)."""
    index = state.model.p.index
    for k, node in enumerate(state.runs[r].nodes[1:-1], 1):
        if f"{node.name}.along_x" in index:
            chord = points[k + 1] - points[k - 1]
            state.point.p[[index[f"{node.name}.along_{axis}"] for axis in AXES]] = chord / np.linalg.norm(chord)


def _slots(state: LineState, r: int) -> tuple[int, ...]:
    """Load slots of each span: for its present loads, and on a moving rope for all that fit between two supports. Each
    has states: a span in which loads come together gets more when it needs them."""
    run, beyond = state.runs[r], state.passed[r]
    count = beyond[:-1] - beyond[1:]
    gaps = np.diff(-run.loads.place)
    if run.moves and np.any(gaps > JOINED):
        fit = np.ceil(_SLACK * np.diff(state.rope(r)) / gaps[gaps > JOINED].min()).astype(int)
        count = np.maximum(count, np.minimum(fit, len(run.loads.place)))
    return tuple(int(n) for n in count)


def _noded(state: LineState, inertia: Inertia) -> LineState:
    """The quasi-static state with its loads clamped to the rope, and with rope nodes, which are loads without mass."""
    quasi = state.copy()
    unpin(quasi)
    for run in quasi.model.runs:
        require_fitting(run, inertia)
    still = [r for r, run in enumerate(quasi.runs) if inertia.nodes and not run.moves]
    for r in still:
        run, rope, beyond = quasi.runs[r], quasi.rope(r), quasi.passed[r]
        place = run.loads.place
        spans = range(len(run.spans))
        distances = [place[beyond[k + 1] : beyond[k]] - rope[k] for k in spans]
        nodes = rope_nodes(run, np.diff(rope), distances, inertia.nodes)
        loads, passed = _with_nodes(run, [rope[k] + nodes[k] for k in spans], beyond)
        quasi.runs[r], quasi.passed[r] = replace(run, loads=loads), passed
    if still:
        quasi.write_slots()
    return quasi


def _with_nodes(run: Run, places: list[np.ndarray], passed: np.ndarray) -> tuple[Loads, np.ndarray]:
    """The loads of a run and nodes at `places` in each span, foremost first, and how many have passed each support."""
    loads, count = run.loads, np.zeros_like(passed)
    names, mass, place, drag = list[str](), list[float](), list[float](), list[float]()
    for k in reversed(range(len(run.spans))):
        own = slice(int(passed[k + 1]), int(passed[k]))
        labels = [f"{run.spans[k].name} node {i + 1}" for i in range(len(places[k]))]
        there = [*zip(loads.place[own], loads.mass[own], loads.names[own], loads.drag[own], strict=True)]
        there += [(at, 0.0, label, 0.0) for at, label in zip(places[k], labels, strict=True)]
        for at, heavy, name, area in sorted(there, key=lambda item: -item[0]):
            names, mass = [*names, name], [*mass, float(heavy)]
            place, drag = [*place, float(at)], [*drag, float(area)]
        count[k] = len(names)
    none, zeros = np.full(len(names), -1), np.zeros(len(names))
    found = Loads(tuple(names), np.array(mass), np.array(place), none, zeros, loads.first, np.array(drag))
    return found, count


def _set_rates(found: LineState, model: Model, rates: dict[Kind, np.ndarray]) -> None:
    """Writes velocities and speeds that are states, from the rates of what they are the rates of."""
    known = {
        name: float(value)
        for kind, values in rates.items()
        for name, value in zip(model.tables[kind].names, values, strict=True)
    }
    for name, source in found.model.rate_of.items():
        place = found.model.x.index.get(name)
        if place is not None:
            found.point.x[place] = known.get(source, 0.0)


def _station_rates(quasi: LineState, x_rate: np.ndarray, z_rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Outputs of a quasi-static state, and their rates."""
    return quasi.outputs(), output_rates(quasi, x_rate, z_rate)


def output_rates(state: LineState, x_rate: np.ndarray, z_rate: np.ndarray) -> np.ndarray:
    """Rates of all outputs [per s] as states and algebraic variables move at these rates."""
    point, y = state.point, outputs_of(state.model)
    ends = [
        y(*Point(point.x + h * x_rate, point.z + h * z_rate, point.u, point.p, point.d, point.t + h).arguments)[
            0
        ].copy()
        for h in (-_DIFFERENCE, _DIFFERENCE)
    ]
    return np.asarray((ends[1] - ends[0]) / (2.0 * _DIFFERENCE))


def tieable(model: Model, r: int) -> np.ndarray:
    """The supports of a run over which a rope with inertia runs: loads near them move with the rope; (supports,)."""
    return np.asarray(model.layouts[r].travel.state >= 0)


def _start_slots(found: LineState, quasi: LineState, r: int, seen: tuple[np.ndarray, np.ndarray]) -> None:
    """Writes places, velocities and tensions of the slots of a run, and ties those that are near a support."""
    run, layout, motion, inertia = (
        found.runs[r],
        found.model.layouts[r],
        slot_motions(found.model)[r],
        found.model.inertia,
    )
    if inertia is None:
        return
    (y, rate), rope, point, beyond = seen, found.rope(r), found.point, found.passed[r]
    stations, ties = slot_outputs(quasi.model, r), tieable(found.model, r)
    for k in range(len(run.spans)):
        force = point.z[layout.force[k] : layout.force[k] + 3].copy()
        weight = point.p[layout.mass_per_length[k]] * point.p[0]
        there = int(beyond[k] - beyond[k + 1])
        for j in range(int(layout.slots.count[k])):
            full = j < there
            load = int(beyond[k]) - 1 - j
            at = run.loads.place[load] - rope[k] if full else rope[k + 1] - rope[k]
            carried = run.loads.mass[beyond[k] - 1 - np.arange(min(j + 1, there))].sum() * point.p[0]
            point.z[motion.pull[:, k] + j] = force + np.array([0.0, 0.0, weight * at + carried])
            if not full:
                continue
            point.x[motion.place[:, k] + j] = y[stations[:, k] + j]
            point.x[motion.velocity[:, k] + j] = rate[stations[:, k] + j]
            near = [ties[k] and at <= inertia.zone, ties[k + 1] and rope[k + 1] - rope[k] - at <= inertia.zone]
            point.d[motion.tied[:, k] + j] = [float(near[0]), float(near[1] and not near[0])]
        join(found, r, k)


def join(state: LineState, r: int, k: int) -> None:
    """Joins free slots of span k that hang so near to the slot before that the rope between them is stiff."""
    motion, point, beyond = slot_motions(state.model)[r], state.point, state.passed[r]
    count = int(beyond[k] - beyond[k + 1])
    if count < 2:
        return
    slots = np.arange(count)
    place = state.runs[r].loads.place[int(beyond[k]) - 1 - slots]
    loose = point.d[motion.tied[0, k] + slots] + point.d[motion.tied[1, k] + slots] == 0.0
    near = np.diff(place, prepend=-np.inf) < JOINED
    point.d[motion.joined[k] + slots] = loose & near & np.append(False, loose[:-1])


def slot_outputs(model: Model, r: int) -> np.ndarray:
    """Places of the slots' places in the outputs of a model: of the first slot of each span of a run, (3, spans)."""
    index = model.y.index
    return np.array([[index.get(f"{span.name}.slot_{axis}[1]", 0) for span in model.runs[r].spans] for axis in AXES])


def regrown(record: AnyRecord, old: Model, new: Model) -> Record:
    """A record of a model as that of the same model with more load slots; it is not solved for these."""
    d = old.d.values.copy()
    d[old.kept] = record.kept
    point = with_more_slots(old, Point(record.x, record.z, record.u, old.p.values, d, record.time), new)
    for before, layout, motion in zip(old.layouts, new.layouts, slot_motions(new), strict=True):
        for k, (had, count) in enumerate(zip(before.slots.count, layout.slots.count, strict=True)):
            last = motion.pull[:, k] + had - 1 if had else layout.force[k] + np.arange(3)
            for j in range(int(had), int(count)):
                point.z[motion.pull[:, k] + j] = point.z[last]
    return Record(point.t, point.x, point.z, point.u, record.passed, point.d[new.kept], record.pending)
