"""The assembled model of a rig with its carriage in one span or on one shoe, and its solved states."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from ropeway.components import catenary
from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.variable import Kind
from ropeway.systems.modelling.assembly import assembled
from ropeway.systems.modelling.dae_model import Model, in_code, kept_with_model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.rigs.rope_paths import roller_name
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.rigs.turn import GROUND, LEAST_MASS
from ropeway.systems.solvers.newton import Newton, newton_of, outputs_of
from ropeway.systems.solvers.points import Point, Slot
from ropeway.systems.statics.certificate.certify import certify_records
from ropeway.systems.statics.certificate.checks import Certificate
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.studies.skyline.rig_check import RigCheck


class Place(NamedTuple):
    """Place of the carriage: in a span, or on the shoe of support `on` at its end. `rollers` is the number of supports
    with a roller under the mainline, by default those that the carriage has passed."""

    span: int
    on: int | None = None
    rollers: int | None = None


class StationCase(NamedTuple):
    """The carriage at a station [m] with a payload [kg], and at a height z [m] if the yarder sets it."""

    station: float
    payload: float
    height: float | None = None


class SpanModel:
    """A rig's model with the carriage at a place. `by_height`: the yarder also sets the carriage's height;
    `compiled`: it is solved in compiled code. `check` rejects non-physical roots."""

    def __init__(self, rig: SkylineRig, place: Place, *, by_height: bool = False, compiled: bool = False) -> None:
        self.rig, self.place, self.by_height = rig, place, by_height
        self.span, self.on = place.span, place.on
        system = rig.system(place.span, on=place.on, rollers=place.rollers)
        self.compiled, self.model = compiled, in_code(assembled(system), compiled=compiled)
        m, name = self.model, rig.carriage.name
        self.log = None if rig.turn is None else rig.turn.log.name
        self.payload = m.p.index[f"{name}.payload" if self.log is None else f"{self.log}.mass"]
        self.axes = [self.slot(f"{name}.{axis}") for axis in "xyz"]
        freed, given = list[Slot](), list[Slot]()
        if not rig.ideal:
            given.append(self.axes[0])
            freed.append(self.slot(f"{name}.travel" if rig.carriage.clamped else "mainline.travel"))
        if by_height:
            given.append(self.axes[2])
            freed.append(self.slot(f"{rig.skyline_drum}.{rig.kind.drum_variable}"))
        self.freed, self.given = tuple(freed), tuple(given)
        """Entries that are solved for in exchange for the carriage's station and height."""
        self.newton = Newton(m, freed, given) if freed else newton_of(m)
        self._outputs, self.output_index, self.value_places = outputs_of(m), m.y.index, places_of(m)
        declared = LineState.declared(m)
        self._declared, self.passed = declared.point, declared.passed
        self.roles = tuple(_role(rig, run) for run in m.runs)
        log_places = ("x", "z", "rear_x", "rear_z") if self.log else ()
        self.places = (self.axes[2], *(self.slot(f"{self.log}.{variable}") for variable in log_places))
        """Coordinates of the carriage and its log."""
        self.check = RigCheck(rig, m, self.newton, self.roles, place.on, by_height=by_height)
        keeps_length = not by_height and rig.kind.keeps_length
        self.rope_lengths = tuple(
            sum(span.length for span in run.spans) if role == "skyline" and keeps_length else np.nan
            for run, role in zip(m.runs, self.roles, strict=True)
        )
        """Unstretched length of each run [m] that a solution must have; NaN where it is free."""

    def moved(self, rig: SkylineRig) -> SpanModel:
        """The same equations for another rig, which differs in the positions of its supports and in the length of its
        skyline. Its supports are points without friction and have the same names."""
        other, point = copy.copy(self), self._declared.copy()
        other.rig, other.check, other._declared = rig, self.check.of(rig), point
        places = self.model.p.index
        for support in rig.supports:
            for name in (support.name, roller_name(support)):
                if f"{name}.x" in places:
                    first = places[f"{name}.x"]
                    point.p[first : first + 3] = support.at
        own, r = self.model.layouts[self.skyline].length_start, self.skyline
        point.p[own] *= (rig.length or 0.0) / point.p[own].sum()
        lengths = list(self.rope_lengths)
        lengths[r] = rig.length or 0.0
        other.rope_lengths = tuple(lengths)
        return other

    def declared(self) -> Point:
        """A point with all values as declared."""
        return self._declared.copy()

    def load(self, point: Point, payload: float) -> None:
        """Sets the payload [kg] of a point."""
        point.p[self.payload] = payload if self.log is None else max(payload, LEAST_MASS)

    def slot(self, name: str) -> Slot:
        """The vector and entry of a variable."""
        for part in _READ:
            if name in self.model.tables[part].index:
                return part, self.model.tables[part].index[name]
        raise InputError(f"{name!r} is not in {self.model.name!r}")

    def read(self, point: Point, slot: Slot) -> float:
        """A value of a point."""
        return float(point.vector(slot[0])[slot[1]])

    def outputs(self, point: Point) -> np.ndarray:
        """All outputs at a point, shape (ny,)."""
        return self._outputs(*point.arguments)[0].copy()

    @property
    def reach(self) -> tuple[float, float]:
        """Stations of both ends of the span; on a shoe, of the support minus and plus the shoe's radius [m]."""
        if self.on is None:
            return float(self.rig.points[self.span, 0]), float(self.rig.points[self.span + 1, 0])
        support = self.rig.supports[self.on]
        return support.at[0] - support.radius, support.at[0] + support.radius

    def ground_under(self, point: Point, lower: float = 0.0) -> bool:
        """Sets the ground under the log's rear, shifted down by `lower` [m]. Returns whether it changed."""
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

    def certificate(self, points: Sequence[Point]) -> Certificate:
        """The worst of each check over solved points. `check` tests the stability of each: the carriage is held at its
        station, so its balance along the skyline need not be stable."""
        states = ((point, self.passed) for point in points)
        return certify_records(self.model, self.model.runs, states, rope=self.rope_lengths, held=None)

    def rest(self, point: Point) -> Equilibrium:
        """An equilibrium from a solved point, with all travels reset to zero. Raises EquilibriumError if its
        certificate fails."""
        self.certificate([point]).require(self.model)
        state = LineState(self.model, point.copy(), self.model.runs, self.passed)
        state.rezero()
        return Equilibrium(self.model, state.point, tuple(state.runs), tuple(state.passed), state.held)

    def free_span(self, k: int) -> str:
        """Name of the skyline's span between the carriage (in a span) and support k."""
        support, carriage = self.rig.supports[k].name, self.rig.carriage.name
        return f"{carriage}_{support}" if self.span == k else f"{support}_{carriage}"

    @property
    def skyline(self) -> int:
        """Index of the skyline's run; for a running skyline, of the haulback's run."""
        return self.roles.index("skyline")

    def carriage_in(self, r: int) -> int:
        """The carriage's position among the nodes of run r."""
        return [node.name for node in self.model.runs[r].nodes].index(self.rig.carriage.name)

    def curve(self, point: Point, k: int, r: int) -> catenary.Vector:
        """Tension vector at the start of span k of run r."""
        f = int(self.model.layouts[r].force[k])
        return (float(point.z[f]), float(point.z[f + 1]), float(point.z[f + 2]))

    def curves(self, point: Point, r: int) -> np.ndarray:
        """Tension vectors at the starts of all spans of run r, (spans, 3)."""
        return np.array([self.curve(point, k, r) for k in range(len(self.model.runs[r].spans))])


def _role(rig: SkylineRig, run: Run) -> str:
    """Role of a run: "skyline", "mainline", "haulback", or "" for a guyline."""
    for node, seat in zip(run.nodes, run.seats, strict=True):
        if node.name == rig.carriage.name:
            return "skyline" if seat.name == "a" else seat.name
    return ""


_READ = (Kind.ALGEBRAIC, Kind.STATE, Kind.PARAMETER)
"""Vectors that a solved rig is read from, besides its outputs."""


@kept_with_model
def places_of(model: Model) -> dict[str, int]:
    """The place of each variable and output in `Solved.values`, by its name."""
    names = [name for kind in (*_READ, Kind.OUTPUT) for name in model.tables[kind].names]
    return {name: i for i, name in enumerate(names)}


@dataclass(frozen=True, eq=False)
class Solved:
    """A solved rig: the model, the point, all outputs (ny,), the carriage's hold ("mainline", "clamp" or "holding"),
    and the case that was solved."""

    at: SpanModel
    point: Point
    outputs: np.ndarray
    held_by: str
    case: StationCase | None = None

    @property
    def off_shoe(self) -> float:
        """Approximate length of rope [m] that would leave the shoe without the shoe's holding force on the carriage."""
        name = self.at.rig.carriage.name
        return -self[f"{name}.shoe_force"] / self[f"{name}.tension_a"] * self[f"{name}.radius"]

    @cached_property
    def values(self) -> np.ndarray:
        """All values, in the order of `places_of`, and a zero behind them."""
        return np.concatenate([*(self.point.vector(kind) for kind in _READ), self.outputs, (0.0,)])

    def __getitem__(self, name: str) -> float:
        k = self.at.value_places.get(self._renamed(name))
        if k is None:
            raise InputError(f"{name!r} is not in {self.at.model.name!r}")
        return float(self.values[k])

    def slot(self, name: str) -> Slot:
        """The vector and entry of a variable or an output. Raises InputError."""
        name = self._renamed(name)
        k = self.at.output_index.get(name)
        return self.at.slot(name) if k is None else (Kind.OUTPUT, k)

    def _renamed(self, name: str) -> str:
        """The name of a variable in the model: a carriage on a shoe has the outputs of both."""
        on = self.at.on
        if on is None:
            return name
        owner, _, quantity = name.rpartition(".")
        return f"{self.at.rig.carriage.name}.{quantity}" if owner == self.at.rig.supports[on].name else name

    def has(self, output: str) -> bool:
        """Whether the model has an output."""
        return output in self.at.output_index

    def start(self, r: int, k: int) -> np.ndarray:
        """Start of span k of run r, (x, y, z) [m]."""
        return self.at.model.runs[r].start(k, self.__getitem__)

    def end(self, r: int, k: int) -> np.ndarray:
        """End of span k of run r, (x, y, z) [m]."""
        return self.at.model.runs[r].end(k, self.__getitem__)


def span_model(
    rig: SkylineRig,
    place: Place,
    by_height: bool = False,
    clamped: bool = False,
    *,
    like: SkylineRig | None = None,
    compiled: bool = False,
) -> SpanModel:
    """The model of a rig at a place, or of its clamped twin, for compiled code or not; assembled once, or moved from
    the model of a rig `like` it (`SpanModel.moved`)."""
    return _span_model(rig, place, by_height, clamped, like, compiled)


@lru_cache(maxsize=256)
def _span_model(
    rig: SkylineRig, place: Place, by_height: bool, clamped: bool, like: SkylineRig | None, compiled: bool
) -> SpanModel:
    own = clamped_twin(rig) if clamped else rig
    if like is None:
        return SpanModel(own, place, by_height=by_height, compiled=compiled)
    return _span_model(like, place, by_height, clamped, None, compiled).moved(own)


@lru_cache(maxsize=64)
def clamped_twin(rig: SkylineRig) -> SkylineRig:
    """The rig with its carriage held on the skyline instead of by its mainline."""
    head = rig.headspar
    if isinstance(head, GuyedSpar):
        head = replace(head, blocks=tuple(rope for rope in head.blocks if rope != "mainline"))
    return replace(rig, headspar=head, mainline=None, carriage=replace(rig.carriage, holding="bisector"))
