"""The assembled model of a rig with its carriage in one span, solved at stations of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ropeway.components import catenary, shoe
from ropeway.components.component import Kind as Part
from ropeway.components.component import Node, Seat
from ropeway.components.errors import EquilibriumError, InputError, OutOfReachError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.systems.assembly import assemble
from ropeway.systems.equilibrium import Equilibrium
from ropeway.systems.model import Balance, Model, component_of
from ropeway.systems.newton import Newton, Point, Slot, newton_of, outputs_of
from ropeway.systems.rigs import carriage_start
from ropeway.systems.rigs.skyline import GROUND, LEAST, Kind, SkylineRig, Turn
from ropeway.systems.run import Run
from ropeway.systems.stability import condensed_last, condensed_pivots
from ropeway.systems.state import LineState

SLACK = 2.4
"""A rope with w L / H above this hangs on the slack branch: the least support tension of a level span comes at
w L / H = 2.40. The difference asinh(v/H) between both ends is w L / H, for steep ropes too."""


class Place(NamedTuple):
    """Where the carriage is: in a span, or on the shoe of support `on` at its end; and how many `rollers` the
    mainline runs over, by default those that it has passed."""

    span: int
    on: int | None = None
    rollers: int | None = None


class SpanModel:
    """A rig's model with the carriage at a place, solved for a station, a payload and, where the yarder sets it, a
    height of the carriage."""

    def __init__(self, rig: SkylineRig, place: Place, *, by_height: bool = False) -> None:
        self.rig, self.place, self.by_height = rig, place, by_height
        self.span, self.on = place.span, place.on
        self.model: Model = assemble(rig.system(place.span, on=place.on, rollers=place.rollers))
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
            freed.append(self.slot(f"{rig.skyline_drum}.{'tension' if rig.kind is Kind.RUNNING else 'travel'}"))
        self.newton = Newton(m, freed, given)
        self._blank = LineState.cold(m).point
        self.roles = tuple(_role(rig, run) for run in m.runs)
        self.lengths = np.array([m.y.index[f"{s.name}.length"] for run in m.runs for s in run.spans])
        # Ropes whose length or tension is an unknown have a slack root besides the taut one.
        self.taut = tuple(
            s.name
            for run, role in zip(m.runs, self.roles, strict=True)
            for s in run.spans
            if role in ("mainline", "haulback") or (role == "skyline" and by_height)
        )
        ends = ("horizontal", "vertical_a", "vertical_b")
        self._taut = [[m.y.index[f"{name}.{quantity}"] for quantity in ends] for name in self.taut]
        # Which way the top of each guyed spar can go.
        self._tops = {
            spar.name: tuple(b for b in m.balances if m.z.names[b.travel].startswith(f"{spar.name}."))
            for spar in (rig.headspar, rig.tailspar)
            if isinstance(spar, GuyedSpar)
        }

    def load(self, point: Point, payload: float) -> None:
        """Gives a point a payload [kg]."""
        point.p[self._mass] = payload if self.log is None else max(payload, LEAST)

    def slot(self, name: str) -> Slot:
        """The vector and entry of a variable."""
        for part in (Part.ALGEBRAIC, Part.STATE, Part.PARAMETER):
            if name in self.model.tables[part].index:
                return part, self.model.tables[part].index[name]
        raise InputError(f"{name!r} is not in {self.model.name!r}")

    def read(self, point: Point, slot: Slot) -> float:
        """A value of a point."""
        return float(point.vector(slot[0])[slot[1]])

    def outputs(self, point: Point) -> np.ndarray:
        """All outputs at a point, shape (ny,)."""
        return outputs_of(self.model)(*point.arguments)[0].copy()

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
        if rig.kind is Kind.RUNNING and self.by_height:
            point.p[m.p.index["haulback.tension"]] = start.tension
        pulls = {"skyline": start.tension, "mainline": start.pull, "haulback": rig.haulback_tension or 0.0}
        for run, role in zip(m.runs, self.roles, strict=True):
            if (pull := pulls.get(role)) is None:
                continue
            points = np.array([here if node.name == rig.carriage.name else node.at for node in run.nodes])
            weight = run.rope.mass_per_length * rig.gravity
            lengths = carriage_start.rope_lengths(points, weight, run.rope.strain, pull)
            d = np.diff(points, axis=0)
            chord = np.linalg.norm(d, axis=1)
            tension = np.maximum(pull, 0.5 * weight * chord)
            force = tension[:, None] * d / chord[:, None]
            force[:, 2] -= 0.5 * weight * lengths
            self._lay(point, role, force, lengths)
        return point

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
        found = self._blank.copy()
        for here, there, kind in ((found.z, solved.point.z, Part.ALGEBRAIC), (found.p, solved.point.p, Part.PARAMETER)):
            to, of = m.tables[kind].index, old.tables[kind].index
            for variable in to.keys() & of.keys():
                if not variable.endswith(("length_start", ".travel", ".grip")):  # each model counts from its own
                    here[to[variable]] = there[of[variable]]
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

    def _leaves(self, point: Point, seat: str, support: IntermediateSupport, along: float, more: np.ndarray) -> None:
        """Puts the place where a rope leaves a shoe `along` its arc from the middle [rad], and `more` (3,) beyond."""
        normal = shoe.normal_at(support.slope or 0.0)
        there = shoe.normal_after(normal, along)
        x, z = (support.radius * (n - n0) for n, n0 in zip(there, normal, strict=True))
        for value, quantity in zip(np.array([x, z, -support.radius * along]) + more, ("x", "z", "rope"), strict=True):
            point.z[self.model.z.index[f"{seat}_{quantity}"]] = value

    def _place_log(self, turn: Turn, point: Point, here: np.ndarray, payload: float) -> None:
        """Starting values of the log and its dropline under a carriage at `here`."""
        z, p, name = self.model.z.index, self.model.p.index, turn.log.name
        x, y, at = (float(v) for v in here)
        log = turn.under(x, y, at, payload, self.rig.terrain)
        rear_x, rear_z, normal = log.rear_start()
        for field in GROUND:
            point.p[p[f"{name}.{field}"]] = getattr(log, "after" if field == "slope_after" else field)
        found = {"x": log.at[0], "y": log.at[1], "z": log.at[2], "rear_x": rear_x, "rear_z": rear_z, "normal": normal}
        for field, value in found.items():
            point.z[z[f"{name}.{field}"]] = value
        way = np.array(log.at) - here
        force = way / np.linalg.norm(way) * (log.mass * self.rig.gravity - 0.8 * normal)
        k = int(self.model.layouts[self.roles.index("dropline")].force[0])
        point.z[k : k + 3] = force

    def solve(
        self,
        station: float,
        payload: float,
        height: float | None = None,
        near: Point | None = None,
        *,
        quick: bool = False,
    ) -> Point:
        """The equilibrium at a station [m] with a payload [kg], and a height z [m] of the carriage where the
        yarder sets it. near: a solved point to start from; quick: from there and from geometry only, without
        the long way round. Raises EquilibriumError."""
        target = np.array([v for v, on in ((station, not self.rig.ideal), (height, self.by_height)) if on], dtype=float)
        last: EquilibriumError | None = None
        ways = ([near] if near is not None else []) + ["geometry"] + ([] if quick else ["by degrees"])
        for way in ways:
            point = way.copy() if isinstance(way, Point) else self.cold(station, payload, height)
            self.load(point, payload)
            if self.rig.ideal:
                slot = self.axes[0]
                point.vector(slot[0])[slot[1]] = station
            try:
                if way == "by degrees":
                    self._by_degrees(point, target, station, payload, height)
                self.newton.solve(point, target=target, iterations=25 if quick or isinstance(way, Point) else 80)
                self._on_ground(point, target)
                self.check(point)
            except OutOfReachError:
                raise
            except EquilibriumError as error:
                last = error
                continue
            return point
        raise EquilibriumError(
            f"No equilibrium of {self.model.name!r} with the carriage at station {station:g} m "
            f"and {payload:g} kg: {last.cause if last else ''}",
            "Check the skyline's length, the payload and the lines that hold the carriage",
            None if last is None else last.component,
        )

    def ground_under(self, point: Point) -> bool:
        """Gives the log the ground under its rear; whether it had another."""
        turn, ground = self.rig.turn, self.rig.terrain
        if turn is None or ground is None:
            return False
        p, rear = self.model.p.index, self.model.z.index[f"{self.log}.rear_x"]
        entries = [p[f"{self.log}.{field}"] for field in GROUND]
        *known, room = ground.vertex_at(float(point.z[rear]))
        vertex = (*known, min(turn.log.rounding, room))
        changed = vertex != tuple(point.p[entries])
        point.p[entries] = vertex
        return changed

    def _on_ground(self, point: Point, target: np.ndarray) -> None:
        """Solves again until the rear of the log lies over the ground it was taken to."""
        for _ in range(12):
            if not self.ground_under(point):
                return
            self.newton.solve(point, target=target, iterations=80)

    def _by_degrees(
        self, point: Point, target: np.ndarray, station: float, payload: float, height: float | None
    ) -> None:
        """From a heavier carriage, whose ropes are taut, down to the payload."""
        extra = 4.0 * (payload + self.rig.carriage.mass) + 1000.0
        start = self.cold(station, payload + extra, height)
        point.z[:], point.x[:] = start.z, start.x
        share = 1.0
        while share > 1e-3:
            self.load(point, payload + share * extra)
            self.newton.solve(point, target=target, iterations=80)
            share *= 0.4
        self.load(point, payload)

    def check(self, point: Point) -> None:
        """Raises EquilibriumError for a root that no rope can have."""
        m, outputs = self.model, self.outputs(point)
        lengths = outputs[self.lengths]
        if np.any(lengths <= 0.0):
            name = component_of(m.y.names[self.lengths[int(np.argmin(lengths))]])
            raise EquilibriumError(f"No rope is left in span {name!r}", "Give more rope", name)
        for entries in self._taut:
            horizontal, down_a, up_b = outputs[entries]
            with np.errstate(divide="ignore", invalid="ignore"):  # a plumb rope is not slack
                turn = np.arcsinh(up_b / horizontal) + np.arcsinh(down_a / horizontal)
            if turn > SLACK:
                name = component_of(m.y.names[entries[0]])
                raise EquilibriumError(f"Rope {name!r} would hang slack", "Ask for more pull", name)
        if self.rig.kind is Kind.RUNNING and self.by_height and point.p[m.p.index["haulback.tension"]] <= 0.0:
            raise EquilibriumError("The haulback would have to push", "Ask for a lower carriage", "haulback")
        for name, free in self._tops.items():
            if self._topples(point, free):
                raise OutOfReachError(
                    f"The guylines of {name!r} do not hold it: it would topple",
                    "Spread their anchors around the spar, or give them more pretension",
                    name,
                    f"guylines of {name}",
                )

    def _topples(self, point: Point, free: tuple[Balance, ...]) -> bool:
        """Whether the stiffness of a spar's top, all else in balance, is not positive definite."""
        rows, columns = condensed_last(self.model, free)
        if self.on is not None and not self.rig.ideal:
            # Held on its shoe: where a carriage would run over at once, its own balance is the unstable one.
            name = self.rig.carriage.name
            rows = rows[rows != self.model.r.index[f"{name}.balance"]]
            columns = columns[columns != self.model.z.index[f"{name}.x"]]
        matrix = newton_of(self.model).matrix(point)[rows][:, columns].tocsc()
        signs = np.array([b.sign for b in free])
        return bool(np.any(signs * condensed_pivots(matrix, len(free)) >= 0.0))

    def _carriage_in(self, r: int) -> int:
        """The carriage's place among the nodes of a rope."""
        return [node.name for node in self.model.runs[r].nodes].index(self.rig.carriage.name)

    def rest(self, point: Point) -> Equilibrium:
        """An equilibrium from a solved point, its travels the new zero."""
        whole = LineState(self.model, point.copy(), self.model.runs, LineState.cold(self.model).passed)
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
    """A rig at a station: the model of its span, the point, all outputs (ny,), and what holds the carriage:
    "mainline", "clamp" or "holding"."""

    at: SpanModel
    point: Point
    outputs: np.ndarray
    held_by: str

    @property
    def off_shoe(self) -> float:
        """About how much rope [m] would come off the shoe, if the shoe did not hold the carriage by its force."""
        name = self.at.rig.carriage.name
        return -self[f"{name}.shoe_force"] / self[f"{name}.tension_a"] * self[f"{name}.radius"]

    def __getitem__(self, name: str) -> float:
        m, on = self.at.model, self.at.on
        owner, _, quantity = name.partition(".")
        if on is not None and owner == self.at.rig.supports[on].name:  # the carriage on it speaks for both
            name = f"{self.at.rig.carriage.name}.{quantity}"
        if name in m.y.index:
            return float(self.outputs[m.y.index[name]])
        return self.at.read(self.point, self.at.slot(name))

    def start(self, r: int, k: int) -> np.ndarray:
        """Where span k of run r starts, (x, y, z) [m]."""
        return self.at.model.runs[r].start(k, self.__getitem__)


@lru_cache(maxsize=256)
def span_model(rig: SkylineRig, place: Place, by_height: bool = False) -> SpanModel:
    """The model of a rig at a place: made once."""
    return SpanModel(rig, place, by_height=by_height)
