"""The assembled model of a rig with its carriage in one span, solved at stations of it."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ropeway.components import catenary, shoe
from ropeway.components.component import Seat
from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.node import Node
from ropeway.components.variable import Kind
from ropeway.systems.modelling.assembly import assembled
from ropeway.systems.modelling.component_functions import ComponentFunctions
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.rigs import carriage_guess
from ropeway.systems.rigs.skyline_rig import GROUND, LEAST, RigKind, SkylineRig, Turn
from ropeway.systems.solvers.newton import Newton, Point, Slot, newton_of, outputs_of
from ropeway.systems.statics.certificate import Certificate, certify_records
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.studies.skyline.rig_check import RigCheck


class Place(NamedTuple):
    """Where the carriage is: in a span, or on the shoe of support `on` at its end; and how many `rollers` the
    mainline runs over, by default those that it has passed."""

    span: int
    on: int | None = None
    rollers: int | None = None


class SpanModel:
    """A rig's model with the carriage at a place, its starting values for a station, a payload and, where the yarder
    sets it, a height of the carriage; `check` tells which solved points count."""

    def __init__(
        self, rig: SkylineRig, place: Place, functions: ComponentFunctions, *, by_height: bool = False
    ) -> None:
        self.rig, self.place, self.by_height = rig, place, by_height
        self.span, self.on = place.span, place.on
        self.model: Model = assembled(rig.system(place.span, on=place.on, rollers=place.rollers), functions)
        m, name = self.model, rig.carriage.name
        self.log = None if rig.turn is None else rig.turn.log.name
        self._mass = m.p.index[f"{name}.payload" if self.log is None else f"{self.log}.mass"]
        self.axes = [self.slot(f"{name}.{axis}") for axis in "xyz"]
        freed, given = [], []
        if not rig.ideal:
            given.append(self.axes[0])
            freed.append(self.slot(f"{name}.travel" if rig.carriage.clamped else "mainline.travel"))
        if by_height:
            given.append(self.axes[2])
            freed.append(self.slot(f"{rig.skyline_drum}.{'tension' if rig.kind is RigKind.RUNNING else 'travel'}"))
        self.newton = Newton(m, freed, given) if freed else newton_of(m)
        self._outputs = outputs_of(m)
        blank = LineState.declared(m)
        self._blank, self._passed = blank.point, blank.passed
        self.roles = tuple(_role(rig, run) for run in m.runs)
        self.places = (
            self.axes[2],
            *(self.slot(f"{self.log}.{v}") for v in ("x", "z", "rear_x", "rear_z") if self.log),
        )
        """Where the carriage and its log are."""
        self.check = RigCheck(rig, m, self.newton, self.roles, place.on, by_height=by_height)

    def load(self, point: Point, payload: float) -> None:
        """Gives a point a payload [kg]."""
        point.p[self._mass] = payload if self.log is None else max(payload, LEAST)

    def slot(self, name: str) -> Slot:
        """The vector and entry of a variable."""
        for part in (Kind.ALGEBRAIC, Kind.STATE, Kind.PARAMETER):
            if name in self.model.tables[part].index:
                return part, self.model.tables[part].index[name]
        raise InputError(f"{name!r} is not in {self.model.name!r}")

    def read(self, point: Point, slot: Slot) -> float:
        """A value of a point."""
        return float(point.vector(slot[0])[slot[1]])

    def outputs(self, point: Point) -> np.ndarray:
        """All outputs at a point, shape (ny,)."""
        return self._outputs(*point.arguments)[0].copy()

    def cold(self, station: float, payload: float, height: float | None) -> Point:
        """Starting values from geometry."""
        rig, point, m = self.rig, self._blank.copy(), self.model
        if self.on is None:
            start = rig.start(self.span, station, payload, height)
        else:
            start = rig.on_shoe_start(self.on, station, payload)
        a, b = rig.points[self.span : self.span + 2]
        here = np.array([station, a[1] + (b[1] - a[1]) * (station - a[0]) / (b[0] - a[0]), start.z])
        for slot, value in zip(self.axes, here, strict=True):
            point.vector(slot[0])[slot[1]] = value
        if rig.ideal:
            point.z[m.z.index[f"{rig.carriage.name}.holding"]] = start.pull
        if rig.turn is not None:
            self._place_log(rig.turn, point, here, payload)
        if rig.kind is RigKind.RUNNING and self.by_height:
            point.p[m.p.index["haulback.tension"]] = start.tension
        for role, pull in (
            ("skyline", start.tension),
            ("mainline", start.pull),
            ("haulback", rig.haulback_tension or 0.0),
        ):
            if role in self.roles:
                self._lay_straight(point, role, here, pull)
        return point

    def _lay_straight(self, point: Point, role: str, here: np.ndarray, pull: float) -> None:
        """Lays a rope about straight, with about a pull [N], to a carriage at `here` (3,)."""
        run = self.model.runs[self.roles.index(role)]
        points = np.array([here if node.name == self.rig.carriage.name else node.at for node in run.nodes])
        weight = run.rope.mass_per_length * self.rig.gravity
        lengths = carriage_guess.rope_lengths(points, weight, run.rope.strain, pull)
        d = np.diff(points, axis=0)
        chord = np.linalg.norm(d, axis=1)
        tension = np.maximum(pull, 0.5 * weight * chord)
        force = tension[:, None] * d / chord[:, None]
        force[:, 2] -= 0.5 * weight * lengths
        self._lay(point, role, force, lengths)

    def _lay(self, point: Point, role: str, force: np.ndarray, lengths: np.ndarray) -> None:
        """Gives the spans of a rope their tension vectors (spans, 3) and lengths (spans,)."""
        r = self.roles.index(role)
        layout, run, index = self.model.layouts[r], self.model.runs[r], self.model.z.index
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
        # A drum that is not to be found stays as it is.
        x = point.x if role != "skyline" or self.by_height else point.x.copy()
        layout.travel.write(travel, x, point.z)
        if self.rig.carriage.clamped and role == "skyline":
            point.p[self.model.p.index[f"{self.rig.carriage.name}.travel"]] = travel[self._carriage_in(r)]

    def off_shoe(self, solved: Solved) -> Point:
        """Starting values for a carriage that has just left a shoe, from a solution that holds it there by force:
        a piece of rope has come off the shoe, as long as that force needs."""
        source, m, old, name = solved.at, self.model, solved.at.model, self.rig.carriage.name
        found = self._alike(solved)
        on = source.on or 0
        support = self.rig.supports[on]
        normal = shoe.normal_at(support.slope or 0.0)
        away = solved[f"{name}.x"] - support.centre[0], solved[f"{name}.z"] - support.centre[1]
        at = float(np.arctan2(away[0] * normal[1] - away[1] * normal[0], away[0] * normal[0] + away[1] * normal[1]))
        off = solved.off_shoe / support.radius
        before = self.span == on  # the carriage is before the shoe, else beyond it
        # Along the arc from its middle: the rope next to the carriage, and the mainline's from its roller.
        touch = {"skyline": at + off if before else at - off, "mainline": at - off}
        for role, owner, near in (
            ("skyline", support.name, "a" if before else "b"),
            ("mainline", f"{support.name}_mainline", "b"),
        ):
            if f"{owner}.a_x" not in m.z.index:
                continue
            self._leaves(found, f"{owner}.{near}", support, touch[role], np.zeros(3))
            far = "mainline" if role == "mainline" else "b" if before else "a"
            more = np.array([solved[f"{name}.{far}_{quantity}"] for quantity in ("x", "z", "rope")])
            self._leaves(found, f"{owner}.{'b' if near == 'a' else 'a'}", support, at, more)
        for r, (run, role) in enumerate(zip(old.runs, source.roles, strict=True)):
            if role not in ("skyline", "mainline", "haulback"):
                continue
            force = np.array([source.curve(solved.point, k, r) for k in range(len(run.spans))])
            lengths = np.array([solved[f"{s.name}.length"] for s in run.spans])
            if len(m.runs[self.roles.index(role)].spans) > len(lengths):
                k = source._carriage_in(r)
                pull = solved[f"{name}.tension_a" if role == "skyline" else f"{name}.mainline_pull"]
                up = shoe.normal_after(normal, touch[role])
                way = shoe.towards_b(up)
                force = np.insert(force, k, (pull * way[0], 0.0, pull * way[1]), axis=0)
                lengths = np.insert(lengths, k, solved.off_shoe)
            self._lay(found, role, force, lengths)
        return found

    def _alike(self, solved: Solved) -> Point:
        """With the values of another model's solution for what has the same name here."""
        found = self._blank.copy()
        for here, there, kind in (
            (found.z, solved.point.z, Kind.ALGEBRAIC),
            (found.x, solved.point.x, Kind.STATE),
            (found.p, solved.point.p, Kind.PARAMETER),
        ):
            to, of = self.model.tables[kind].index, solved.at.model.tables[kind].index
            for variable in to.keys() & of.keys():
                if not variable.endswith(("length_start", "travel", ".grip")):  # each model counts from its own
                    here[to[variable]] = there[of[variable]]
        return found

    def pulled(self, held: Solved) -> Point:
        """Starting values for a carriage on its mainline, from a solution in which an ideal force holds it."""
        found, name = self._alike(held), self.rig.carriage.name
        here = np.array([held[f"{name}.{axis}"] for axis in "xyz"])
        for r, (run, role) in enumerate(zip(held.at.model.runs, held.at.roles, strict=True)):
            if role in ("skyline", "haulback"):
                force = np.array([held.at.curve(held.point, k, r) for k in range(len(run.spans))])
                self._lay(found, role, force, np.array([held[f"{s.name}.length"] for s in run.spans]))
        self._lay_straight(found, "mainline", here, held[f"{name}.holding"])
        return found

    def _leaves(self, point: Point, seat: str, support: IntermediateSupport, along: float, more: np.ndarray) -> None:
        """Puts the place where a rope leaves a shoe `along` its arc from the middle [rad], and `more` (3,) beyond."""
        normal = shoe.normal_at(support.slope or 0.0)
        there = shoe.normal_after(normal, along)
        x, z = (support.radius * (n - n0) for n, n0 in zip(there, normal, strict=True))
        for value, quantity in zip(np.array([x, z, -support.radius * along]) + more, ("x", "z", "rope"), strict=True):
            point.z[self.model.z.index[f"{seat}_{quantity}"]] = value

    def _place_log(self, turn: Turn, point: Point, here: np.ndarray, payload: float) -> None:
        """Starting values of a log that hangs free under a carriage at `here`."""
        z, name = self.model.z.index, turn.log.name
        x, y, at = (float(v) for v in here)
        log = turn.under(x, y, at, payload, None)
        rear_x, rear_z, normal = log.rear_start()
        found = {"x": log.at[0], "y": y, "z": log.at[2], "rear_x": rear_x, "rear_z": rear_z, "normal": normal}
        for field, value in found.items():
            point.z[z[f"{name}.{field}"]] = value
        k = int(self.model.layouts[self.roles.index("dropline")].force[0])
        way = np.array(log.at) - here
        point.z[k : k + 3] = way / np.linalg.norm(way) * log.mass * self.rig.gravity

    @property
    def reach(self) -> tuple[float, float]:
        """Stations of the ends of its span; of its support on a shoe, with the shoe's width to either side [m]."""
        if self.on is None:
            return float(self.rig.points[self.span, 0]), float(self.rig.points[self.span + 1, 0])
        support = self.rig.supports[self.on]
        return support.at[0] - support.radius, support.at[0] + support.radius

    def ground_under(self, point: Point, lower: float = 0.0) -> bool:
        """Gives the log the ground under its rear, taken `lower` than it is [m]; whether it had another."""
        turn, ground = self.rig.turn, self.rig.terrain
        if turn is None or ground is None:
            return False
        p, rear = self.model.p.index, self.model.z.index[f"{self.log}.rear_x"]
        entries = [p[f"{self.log}.{field}"] for field in GROUND]
        *known, room = ground.vertex_at(float(point.z[rear]))
        at, z, *slopes = known
        vertex = (at, z - lower, *slopes, min(turn.log.rounding, room))
        changed = vertex != tuple(point.p[entries])
        point.p[entries] = vertex
        return changed

    def _carriage_in(self, r: int) -> int:
        """The carriage's place among the nodes of a rope."""
        return [node.name for node in self.model.runs[r].nodes].index(self.rig.carriage.name)

    def certificate(self, points: Sequence[Point]) -> Certificate:
        """The worst of each check over solved points. The stability of each is `check`'s: a carriage is held at its
        station, so that its balance along the skyline need not be stable."""
        keeps_length = not self.by_height and self.rig.kind is not RigKind.RUNNING
        rope = [
            sum(span.length for span in run.spans) if role == "skyline" and keeps_length else np.nan
            for run, role in zip(self.model.runs, self.roles, strict=True)
        ]
        states = ((point, self._passed) for point in points)
        return certify_records(self.model, self.model.runs, states, rope=rope, held=None)

    def rest(self, point: Point) -> Equilibrium:
        """An equilibrium from a solved point, its travels the new zero. Raises EquilibriumError where its certificate
        fails."""
        self.certificate([point]).require(self.model)
        whole = LineState(self.model, point.copy(), self.model.runs, self._passed)
        whole.rezero()
        return Equilibrium(self.model, whole.point, tuple(whole.runs), tuple(whole.passed), whole.held)

    def free_span(self, k: int) -> str:
        """Name of the skyline's span between the carriage, in a span, and support k."""
        support, carriage = self.rig.supports[k].name, self.rig.carriage.name
        return f"{carriage}_{support}" if self.span == k else f"{support}_{carriage}"

    @property
    def skyline(self) -> int:
        """Index of the skyline's run (of the haulback's, for a running skyline)."""
        return self.roles.index("skyline")

    def curve(self, point: Point, k: int, r: int) -> catenary.Vector:
        """Tension vector at the start of span k of run r."""
        f = int(self.model.layouts[r].force[k])
        return (float(point.z[f]), float(point.z[f + 1]), float(point.z[f + 2]))


def _role(rig: SkylineRig, run: Run) -> str:
    """What a run is to the carriage: "skyline", "mainline", "haulback", or "" for a guyline."""
    for node, seat in zip(run.nodes, run.seats, strict=True):
        if node.name == rig.carriage.name:
            return "skyline" if seat.name == "a" else seat.name
    return ""


@dataclass(frozen=True, eq=False)
class Solved:
    """A rig at a station: the model of its span, the point, all outputs (ny,), what holds the carriage ("mainline",
    "clamp" or "holding"), and where it was asked for: station [m], payload [kg], and height z [m] or None."""

    at: SpanModel
    point: Point
    outputs: np.ndarray
    held_by: str
    asked: tuple[float, float, float | None] | None = None

    @property
    def off_shoe(self) -> float:
        """About how much rope [m] would come off the shoe, if the shoe did not hold the carriage by its force."""
        name = self.at.rig.carriage.name
        return -self[f"{name}.shoe_force"] / self[f"{name}.tension_a"] * self[f"{name}.radius"]

    def __getitem__(self, name: str) -> float:
        on = self.at.on
        if on is not None:
            owner, _, quantity = name.rpartition(".")
            if owner == self.at.rig.supports[on].name:  # the carriage on it speaks for both
                name = f"{self.at.rig.carriage.name}.{quantity}"
        k = self.at.model.y.index.get(name)
        return self.at.read(self.point, self.at.slot(name)) if k is None else float(self.outputs[k])

    def start(self, r: int, k: int) -> np.ndarray:
        """Where span k of run r starts, (x, y, z) [m]."""
        return self.at.model.runs[r].start(k, self.__getitem__)

    def end(self, r: int, k: int) -> np.ndarray:
        """Where it ends."""
        return self.at.model.runs[r].end(k, self.__getitem__)


def span_model(rig: SkylineRig, place: Place, by_height: bool = False, clamped: bool = False) -> SpanModel:
    """The model of a rig at a place, or of its twin with a clamp: made once."""
    return _span_model(rig, place, by_height, clamped)


@lru_cache(maxsize=256)
def _span_model(rig: SkylineRig, place: Place, by_height: bool, clamped: bool) -> SpanModel:
    return SpanModel(
        clamped_twin(rig) if clamped else rig, place, _functions_of(rig, threading.get_ident()), by_height=by_height
    )


@lru_cache(maxsize=64)
def _functions_of(rig: SkylineRig, thread: int) -> ComponentFunctions:
    """The component functions that all models of a rig share which one thread makes: CasADi counts references to its
    functions without a lock."""
    return ComponentFunctions()


@lru_cache(maxsize=64)
def clamped_twin(rig: SkylineRig) -> SkylineRig:
    """The rig with its carriage held on the skyline instead of by its mainline."""
    head = rig.headspar
    if isinstance(head, GuyedSpar):
        head = replace(head, blocks=tuple(rope for rope in head.blocks if rope != "mainline"))
    return replace(rig, headspar=head, mainline=None, carriage=replace(rig.carriage, holding="bisector"))
