"""A rig with its carriage at one station after another: one assembled model for each span, warm starts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ropeway.components import catenary
from ropeway.components.component import Kind as Part
from ropeway.components.errors import EquilibriumError, InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.systems.assembly import assemble
from ropeway.systems.model import Model
from ropeway.systems.newton import Newton, Point, Slot, outputs_of
from ropeway.systems.rigs import carriage_start
from ropeway.systems.rigs.skyline import LEAST, Kind, SkylineRig, Turn
from ropeway.systems.run import Run
from ropeway.systems.state import LineState

SIDE = 0.02
"""A carriage at a point saddle hangs this far beside it [m], on the side it was asked for."""


SLACK = 2.4
"""A rope with w L / H above this hangs on the slack branch: the least support tension of a level span comes at
w L / H = 2.40. The difference asinh(v/H) between both ends is w L / H, for steep ropes too."""


class SpanModel:
    """A rig's model with the carriage in one span, solved for a station, a payload and, where the yarder sets
    it, a height of the carriage."""

    def __init__(self, rig: SkylineRig, span: int, *, by_height: bool) -> None:
        self.rig, self.span, self.by_height = rig, span, by_height
        self.model: Model = assemble(rig.system(span))
        m = self.model
        name = rig.carriage.name
        self.log = None if rig.turn is None else rig.turn.log.name
        self._mass = m.p.index[f"{name}.payload" if self.log is None else f"{self.log}.mass"]
        self.place = [self.slot(f"{name}.{axis}") for axis in "xyz"]
        freed, given = [], []
        if not rig.ideal:
            given.append(self.place[0])
            freed.append(self.slot(f"{name}.travel" if rig.carriage.clamped else "mainline.travel"))
        if by_height:
            given.append(self.place[2])
            freed.append(self.slot("haulback.tension" if rig.kind is Kind.RUNNING else f"{rig.headspar.name}.travel"))
        self.given = given
        self.newton = Newton(m, freed, given)
        self._blank = LineState.cold(m).point
        self.roles = tuple(_role(rig, run) for run in m.runs)
        self.lengths = np.array([m.y.index[f"{s.name}.length"] for run in m.runs for s in run.spans])
        # Ropes whose length or tension is an unknown have a slack root besides the taut one.
        self._taut = [
            [m.y.index[f"{s.name}.{quantity}"] for quantity in ("horizontal", "vertical_a", "vertical_b")]
            for run, role in zip(m.runs, self.roles, strict=True)
            for s in run.spans
            if role in ("mainline", "haulback") or (role == "skyline" and by_height)
        ]

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
        start = rig.start(self.span, station, payload, height)
        a, b = rig.points[self.span : self.span + 2]
        here = np.array([station, a[1] + (b[1] - a[1]) * (station - a[0]) / (b[0] - a[0]), start.z])
        for slot, value in zip(self.place, here, strict=True):
            point.vector(slot[0])[slot[1]] = value
        if rig.ideal:
            point.z[m.z.index[f"{rig.carriage.name}.holding"]] = start.pull
        if rig.turn is not None:
            self._place_log(rig.turn, point, here, payload)
        if rig.kind is Kind.RUNNING and self.by_height:
            point.p[m.p.index["haulback.tension"]] = start.tension
        pulls = {"skyline": start.tension, "mainline": start.pull, "haulback": rig.haulback_tension or 0.0}
        for run, layout, role in zip(m.runs, m.layouts, self.roles, strict=True):
            if role not in pulls:
                continue
            pull = pulls[role]
            points = np.array([here if node.name == rig.carriage.name else node.at for node in run.nodes])
            weight = run.rope.mass_per_length * rig.gravity
            lengths = carriage_start.rope_lengths(points, weight, run.rope.strain, pull)
            d = np.diff(points, axis=0)
            chord = np.linalg.norm(d, axis=1)
            tension = np.maximum(pull, 0.5 * weight * chord)
            force = tension[:, None] * d / chord[:, None]
            force[:, 2] -= 0.5 * weight * lengths
            for axis in range(3):
                point.z[layout.force + axis] = force[:, axis]
            travel = np.zeros(len(run.nodes))
            for k in range(len(run.spans) - 1, -1, -1):
                travel[k] = lengths[k] - point.p[layout.length_start[k]] + travel[k + 1]
            layout.travel.write(travel, point.x, point.z)
            if rig.carriage.clamped and role == "skyline":
                point.p[m.p.index[f"{rig.carriage.name}.travel"]] = travel[self.span + 1]
        return point

    def _place_log(self, turn: Turn, point: Point, here: np.ndarray, payload: float) -> None:
        """Starting values of the log and its dropline under a carriage at `here`."""
        z, p, name = self.model.z.index, self.model.p.index, turn.log.name
        x, y, at = (float(v) for v in here)
        log = turn.under(x, y, at, payload, self.rig.terrain)
        rear_x, rear_z, normal = log.rear_start()
        for field in ("slope", "ground_x", "ground_z"):
            point.p[p[f"{name}.{field}"]] = getattr(log, field)
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
                slot = self.place[0]
                point.vector(slot[0])[slot[1]] = station
            try:
                if way == "by degrees":
                    self._by_degrees(point, target, station, payload, height)
                self.newton.solve(point, target=target, iterations=25 if quick or isinstance(way, Point) else 80)
                self._on_ground(point, target)
                self.check(point)
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

    def _on_ground(self, point: Point, target: np.ndarray) -> None:
        """Solves again until the rear of the log lies over the ground it was taken to. Where it changes to and
        fro it lies at a vertex of the profile: the plane half-way between both sides through it."""
        if self.log is None or self.rig.terrain is None:
            return
        p, rear = self.model.p.index, self.model.z.index[f"{self.log}.rear_x"]
        entries = [p[f"{self.log}.{field}"] for field in ("slope", "ground_x", "ground_z")]
        seen: list[tuple[float, float, float]] = []
        for _ in range(12):
            plane = self.rig.terrain.plane_at(float(point.z[rear]))
            if plane == tuple(point.p[entries]):
                return
            if plane in seen:
                other = tuple(point.p[entries])
                vertex = max((plane, other), key=lambda side: side[1])
                point.p[entries] = (0.5 * (plane[0] + other[0]), vertex[1], vertex[2])
                self.newton.solve(point, target=target, iterations=80)
                return
            seen.append(plane)
            point.p[entries] = plane
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
        m = self.model
        outputs = self.outputs(point)
        lengths = outputs[self.lengths]
        if np.any(lengths <= 0.0):
            name = m.y.names[self.lengths[int(np.argmin(lengths))]].split(".")[0]
            raise EquilibriumError(f"No rope is left in span {name!r}", "Give more rope", name)
        for entries in self._taut:
            horizontal, down_a, up_b = outputs[entries]
            with np.errstate(divide="ignore", invalid="ignore"):  # a plumb rope is not slack
                turn = np.arcsinh(up_b / horizontal) + np.arcsinh(down_a / horizontal)
            if turn > SLACK:
                name = m.y.names[entries[0]].split(".")[0]
                raise EquilibriumError(f"Rope {name!r} would hang slack", "Ask for more pull", name)
        if self.rig.kind is Kind.RUNNING and self.by_height and point.p[m.p.index["haulback.tension"]] <= 0.0:
            raise EquilibriumError("The haulback would have to push", "Ask for a lower carriage", "haulback")

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

    def __getitem__(self, name: str) -> float:
        m = self.at.model
        if name in m.y.index:
            return float(self.outputs[m.y.index[name]])
        return self.at.read(self.point, self.at.slot(name))


class Stations:
    """A rig's equilibria over stations; each solve starts from the last one in the same span.

    Where the mainline would have to push, because the carriage stands beyond its rest point, or to pull less
    than its own weight does, the carriage's clamp holds it on the skyline: solved with the ideal holding force
    along the bisector.
    """

    def __init__(self, rig: SkylineRig, *, by_height: bool = False) -> None:
        self.rig, self.by_height = rig, by_height
        self._last: dict[tuple[int, bool], list[_Known]] = {}
        self._was_clamped: dict[int, bool] = {}

    def solve(self, station: float, payload: float, height: float | None = None) -> Solved:
        """Raises InputError outside the skyline, EquilibriumError where there is no equilibrium."""
        span = self.rig.span_of(station)
        x = self.beside(span, station)
        rig = self.rig
        if rig.ideal or rig.carriage.clamped:
            return self._solve(rig, span, x, payload, height, clamp=False)
        if rig.kind is Kind.RUNNING and height is None:
            self._require_lift(x, payload)
        own = self._own_pull(span, x)
        held = None
        if self._was_clamped.get(span):
            held = self._solve(clamped_twin(rig), span, x, payload, height, clamp=True)
            if held[f"{rig.carriage.name}.holding"] <= 0.0:
                return held
        try:
            solved = self._solve(rig, span, x, payload, height, clamp=False, quick=True)
        except EquilibriumError:
            held = held or self._solve(clamped_twin(rig), span, x, payload, height, clamp=True)
            if held[f"{rig.carriage.name}.holding"] <= own:
                if rig.kind is Kind.RUNNING:
                    raise EquilibriumError(
                        f"At station {station:g} m the carriage of {rig.name!r} is beyond its rest point with "
                        f"{payload:g} kg: the mainline would have to push",
                        "Raise the haulback's tension, or stay nearer to the headspar",
                        rig.carriage.name,
                    ) from None
                self._was_clamped[span] = True
                return held
            solved = self._solve(rig, span, x, payload, height, clamp=False)
        self._was_clamped[span] = False
        return solved

    def _require_lift(self, x: float, payload: float) -> None:
        """Raises EquilibriumError where a running skyline's haulback cannot carry the load however deep it hangs:
        with straight ropes all but plumb, T + M = 2 T (L - x) / x towards the headspar and 2 T towards the tail.
        Half of the four ropes' weight counts, at least that of their horizontal lengths."""
        head, tail = self.rig.points[0], self.rig.points[1]
        most = 2.0 * (self.rig.tension or 0.0) * (tail[0] - head[0]) / (x - head[0])
        ropes = 0.99 * self.rig.skyline.mass_per_length * (tail[0] - head[0])
        load = (payload + self.rig.carriage.mass + ropes) * self.rig.gravity
        if load >= most:
            raise EquilibriumError(
                f"A haulback tension of {self.rig.tension:g} N carries less than {most:.6g} N at station {x:g} m, "
                f"load and ropes of {self.rig.name!r} weigh {load:.6g} N",
                "Raise the haulback's tension",
                self.rig.carriage.name,
            )

    def _own_pull(self, span: int, x: float) -> float:
        """What the mainline pulls by its own weight, at most [N]: below it, it cannot be kept taut."""
        rope = self.rig.mainline
        if rope is None:
            return 0.0
        stands = [node.at for node in self.rig.stands[: span + 1]]
        ends = np.array([*stands, (x, stands[-1][1], self.rig.stands[span + 1].at[2])])
        return float(np.abs(np.diff(ends, axis=0)).sum(axis=1).max() * rope.mass_per_length * self.rig.gravity)

    def beside(self, span: int, station: float) -> float:
        """The station, or a little beside a support that stands there."""
        low, high = self.rig.stands[span].at[0], self.rig.stands[span + 1].at[0]
        side = min(SIDE, (high - low) / 4.0)
        return min(max(station, low + side), high - side)

    def _solve(
        self,
        rig: SkylineRig,
        span: int,
        x: float,
        payload: float,
        height: float | None,
        *,
        clamp: bool,
        quick: bool = False,
    ) -> Solved:
        at = span_model(rig, span, self.by_height)
        known = self._last.get((span, clamp), [])
        point = at.solve(x, payload, height, _ahead(known, x, payload), quick=quick)
        self._last[span, clamp] = [*known[-1:], _Known(x, payload, point)]
        held_by = "clamp" if clamp or rig.carriage.clamped else "holding" if rig.ideal else "mainline"
        return Solved(at, point, at.outputs(point), held_by)


class _Known(NamedTuple):
    """A solved point, its station [m] and payload [kg]."""

    station: float
    payload: float
    point: Point


def _ahead(known: list[_Known], station: float, payload: float) -> Point | None:
    """Where to start from: the last solved point, or on the line through the last two of one payload."""
    if not known:
        return None
    last = known[-1]
    if len(known) == 1 or not last.payload == known[0].payload == payload or last.station == known[0].station:
        return last.point
    share = (station - last.station) / (last.station - known[0].station)
    if not 0.0 < share <= 2.0:
        return last.point
    point = last.point.copy()
    point.z[:] += share * (last.point.z - known[0].point.z)
    point.x[:] += share * (last.point.x - known[0].point.x)
    return point


@lru_cache(maxsize=256)
def span_model(rig: SkylineRig, span: int, by_height: bool) -> SpanModel:
    """The model of a rig's span: made once."""
    return SpanModel(rig, span, by_height=by_height)


@lru_cache(maxsize=64)
def clamped_twin(rig: SkylineRig) -> SkylineRig:
    """The rig with its carriage held on the skyline instead of by its mainline."""
    head = rig.headspar
    if isinstance(head, GuyedSpar):
        head = replace(head, mainline_block=False)
    return replace(rig, headspar=head, mainline=None, carriage=replace(rig.carriage, holding="bisector"))
