"""A rig with its carriage at one station after another: one assembled model for each span, warm starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca
import numpy as np

from ropeway.components import catenary
from ropeway.components.component import Kind as Part
from ropeway.components.errors import EquilibriumError, InputError, RopewayError
from ropeway.systems.assembly import assemble
from ropeway.systems.model import Model
from ropeway.systems.newton import Buffered, Newton, Point, Slot
from ropeway.systems.rigs import carriage_start
from ropeway.systems.rigs.skyline import Kind, SkylineRig
from ropeway.systems.state import LineState

SIDE = 0.02
"""A carriage at a point saddle hangs this far beside it [m], on the side it was asked for."""


class SpanModel:
    """A rig's model with the carriage in one span, solved for a station, a payload and, where the yarder sets
    it, a height of the carriage."""

    def __init__(self, rig: SkylineRig, span: int, *, by_height: bool) -> None:
        self.rig, self.span, self.by_height = rig, span, by_height
        self.model: Model = assemble(rig.system(span))
        m = self.model
        name = rig.carriage.name
        self.payload = m.p.index[f"{name}.payload"]
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
        arguments = m.outputs.sx_in()
        self._outputs = Buffered(ca.Function("y", arguments, [ca.densify(m.outputs.expand()(*arguments))]))
        self._blank = LineState.cold(m).point
        self.run_of = {run.spans[0].name: r for r, run in enumerate(m.runs)}
        self.lengths = np.array([m.y.index[f"{s.name}.length"] for run in m.runs for s in run.spans])

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
        q = point
        return self._outputs(np.array([q.t]), q.x, q.z, q.u, q.p, q.d)[0].copy()

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
        if rig.kind is Kind.RUNNING and self.by_height:
            point.p[m.p.index["haulback.tension"]] = start.tension
        for run, layout in zip(m.runs, m.layouts, strict=True):
            line = run.nodes[0].name
            on_skyline = run.rope == rig.skyline and line != "mainline"
            pull = start.tension if on_skyline else start.pull
            if line == "haulback" and not on_skyline:
                pull = rig.haulback_tension or 0.0
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
            if rig.carriage.clamped and on_skyline:
                point.p[m.p.index[f"{rig.carriage.name}.travel"]] = travel[self.span + 1]
        return point

    def solve(self, station: float, payload: float, height: float | None = None, near: Point | None = None) -> Point:
        """The equilibrium at a station [m] with a payload [kg], and a height z [m] of the carriage where the
        yarder sets it. near: a solved point to start from. Raises EquilibriumError."""
        target = np.array([v for v, on in ((station, not self.rig.ideal), (height, self.by_height)) if on], dtype=float)
        last: EquilibriumError | None = None
        for attempt in range(3 if near is not None else 2):
            if attempt == 0 and near is not None:
                point = near.copy()
            else:
                point = self.cold(station, payload, height)
            point.p[self.payload] = payload
            if self.rig.ideal:
                slot = self.place[0]
                point.vector(slot[0])[slot[1]] = station
            try:
                if attempt == 2 or (near is None and attempt == 1):
                    self._by_degrees(point, target, station, payload, height)
                self.newton.solve(point, target=target, iterations=30 if attempt == 0 else 80)
                self._check(point, station)
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

    def _by_degrees(
        self, point: Point, target: np.ndarray, station: float, payload: float, height: float | None
    ) -> None:
        """From a heavier carriage, whose ropes are taut, down to the payload."""
        extra = 4.0 * (payload + self.rig.carriage.mass) + 1000.0
        start = self.cold(station, payload + extra, height)
        point.z[:], point.x[:] = start.z, start.x
        share = 1.0
        while share > 1e-3:
            point.p[self.payload] = payload + share * extra
            self.newton.solve(point, target=target, iterations=80)
            share *= 0.4
        point.p[self.payload] = payload

    def _check(self, point: Point, station: float) -> None:
        """Raises EquilibriumError for a root that no rope can have."""
        m = self.model
        lengths = self.outputs(point)[self.lengths]
        if np.any(lengths <= 0.0):
            name = m.y.names[self.lengths[int(np.argmin(lengths))]].split(".")[0]
            raise EquilibriumError(f"No rope is left in span {name!r}", "Give more rope", name)
        if self.rig.kind is Kind.RUNNING and self.by_height and point.p[m.p.index["haulback.tension"]] <= 0.0:
            raise EquilibriumError("The haulback would have to push", "Ask for a lower carriage", "haulback")

    def curve(self, point: Point, k: int, r: int) -> catenary.Vector:
        """Tension vector at the start of span k of run r."""
        f = int(self.model.layouts[r].force[k])
        return (float(point.z[f]), float(point.z[f + 1]), float(point.z[f + 2]))


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

    Where the mainline would have to push, because the carriage stands beyond its rest point, its clamp holds
    it on the skyline: solved with the ideal holding force along the bisector.
    """

    def __init__(self, rig: SkylineRig, *, by_height: bool = False) -> None:
        self.rig, self.by_height = rig, by_height
        self._last: dict[tuple[int, bool], Point] = {}

    def solve(self, station: float, payload: float, height: float | None = None) -> Solved:
        """Raises InputError outside the skyline, EquilibriumError where there is no equilibrium."""
        span = self.rig.span_of(station)
        x = self.beside(span, station)
        rig = self.rig
        can_clamp = rig.mainline is not None and not rig.carriage.clamped and rig.haulback is None
        if can_clamp and rig.kind is not Kind.RUNNING:
            start = rig.start(span, x, payload, height)
            # The start's pull is good to a few percent: only where it says little, is the exact one asked.
            if start.pull < 0.02 * (payload + rig.carriage.mass) * rig.gravity:
                held = self._solve(clamped_twin(rig), span, x, payload, height, clamp=True)
                if held[f"{rig.carriage.name}.holding"] <= 0.0:
                    return held
        try:
            return self._solve(rig, span, x, payload, height, clamp=False)
        except EquilibriumError:
            if not can_clamp or rig.kind is Kind.RUNNING:
                raise
            held = self._solve(clamped_twin(rig), span, x, payload, height, clamp=True)
            if held[f"{rig.carriage.name}.holding"] > 0.02 * (payload + rig.carriage.mass) * rig.gravity:
                raise
            return held

    def beside(self, span: int, station: float) -> float:
        """The station, or a little beside a support that stands there."""
        low, high = self.rig.stands[span].at[0], self.rig.stands[span + 1].at[0]
        side = min(SIDE, (high - low) / 4.0)
        return min(max(station, low + side), high - side)

    def _solve(
        self, rig: SkylineRig, span: int, x: float, payload: float, height: float | None, *, clamp: bool
    ) -> Solved:
        at = span_model(rig, span, self.by_height)
        point = at.solve(x, payload, height, self._last.get((span, clamp)))
        self._last[span, clamp] = point
        held_by = "clamp" if clamp or rig.carriage.clamped else "holding" if rig.ideal else "mainline"
        return Solved(at, point, at.outputs(point), held_by)


@lru_cache(maxsize=256)
def span_model(rig: SkylineRig, span: int, by_height: bool) -> SpanModel:
    """The model of a rig's span: made once."""
    return SpanModel(rig, span, by_height=by_height)


@lru_cache(maxsize=64)
def clamped_twin(rig: SkylineRig) -> SkylineRig:
    """The rig with its carriage held on the skyline instead of by its mainline."""
    return replace(rig, mainline=None, carriage=replace(rig.carriage, holding="bisector"))


Progress = Callable[[float], None]
__all__ = ["SIDE", "RopewayError", "Solved", "SpanModel", "Stations", "clamped_twin", "span_model"]
