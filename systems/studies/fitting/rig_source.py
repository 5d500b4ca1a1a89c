"""A rig as the source of a fit: its carriage at the station of each row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ropeway.components import check
from ropeway.components.errors import EquilibriumError, InputError, UnknownNameError
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.solvers.points import Point
from ropeway.systems.studies.fitting.measured import GIVEN, MEASURED
from ropeway.systems.studies.fitting.rope_points import RETURN_TIME, ROPE_X, ROPE_Y, ROPE_Z, return_time, rope_points
from ropeway.systems.studies.fitting.sources import Source, States
from ropeway.systems.studies.sensitivity import rig_quantities
from ropeway.systems.studies.sensitivity.linearisation import LinearState
from ropeway.systems.studies.sensitivity.reading import Reading
from ropeway.systems.studies.sensitivity.rig_readings import rig_columns, rig_reading, unit_of_reading
from ropeway.systems.studies.skyline.carriage_model import (
    Place,
    Solved,
    SpanModel,
    StationCase,
    span_model,
)
from ropeway.systems.studies.skyline.load_path import carriage_height
from ropeway.systems.studies.skyline.root_selection import solved_in_place
from ropeway.systems.studies.skyline.starting_points import from_geometry, on_mainline
from ropeway.systems.studies.skyline.station_solver import Stations

_LEAST_SHARE = 1.0 / 64.0
"""Smallest part of a change of the free quantities, in steps from one solution to the next."""
_ITERATIONS = 40
"""Largest number of Newton steps of a state."""
_CANDIDATES = (
    *("skyline_tension", "headspar_tension", "tailspar_tension", "anchor_tension", "carriage_z"),
    *("mainline_pull", "mainline_tension", "haulback_tension", "spar_compression", "tailspar_compression"),
)


class RigSource(Source):
    """A rig by the names of its quantities: columns of its load path are measured, the others given."""

    def __init__(self, rig: SkylineRig) -> None:
        self.rig, self.name = rig, rig.name
        middle = 0.5 * (rig.points[0, 0] + rig.points[1, 0])
        self._one = Stations(rig).solve(middle, rig.carriage.payload)
        self._at = span_model(rig, Place(0))

    def role(self, name: str) -> str:
        quantity = name.rpartition(".")[2]
        if quantity in (ROPE_X, ROPE_Y, ROPE_Z):
            return MEASURED if quantity == ROPE_Z else GIVEN
        if quantity == RETURN_TIME:
            return MEASURED
        try:
            rig_quantities.unit_of(self._at, name)
        except UnknownNameError:
            rig_reading(self._one, name)
            return MEASURED
        return GIVEN

    def unit(self, name: str) -> str:
        own = {ROPE_X: "m", ROPE_Y: "m", ROPE_Z: "m", RETURN_TIME: "s"}
        if (unit := own.get(name.rpartition(".")[2])) is not None:
            return unit
        if self.role(name) == MEASURED:
            return unit_of_reading(self._one, name)
        return rig_quantities.unit_of(self._at, name)

    def declared(self, name: str) -> float:
        if name in ("station", "height"):
            raise InputError(f"The {name} cannot be free", "Give it in a column of the table")
        if self.role(name) == MEASURED:
            raise InputError(f"{name} is a result and cannot be free", "Free a payload, a length or a parameter")
        return rig_quantities.declared(self._at, name)

    def states(self, free: Sequence[str], given: Sequence[str], values: np.ndarray, time: np.ndarray | None) -> States:
        if "station" not in given:
            raise InputError(f"No column gives the station of the carriage of {self.name!r}", "Map one to 'station'")
        if {"length", "tension"} <= {*free, *given} and self.rig.kind.keeps_length:
            raise InputError("Length and tension of the skyline follow from each other", "Use one of them")
        return RigStates(self.rig, free, given, values)


class _Known(NamedTuple):
    """A solved state, and the values of what is free or given in it."""

    solved: Solved
    values: dict[str, float]


def _declared(solved: Solved, names: Sequence[str]) -> dict[str, float]:
    """Declared values of quantities; the payload is that of the solved station."""
    return {
        name: solved.case.payload if name == "payload" and solved.case else rig_quantities.declared(solved.at, name)
        for name in names
    }


class RigStates(States):
    """The rig at the station of each row, held by its mainline or its clamp as the values require. Each state starts
    from its last solution."""

    def __init__(self, rig: SkylineRig, free: Sequence[str], given: Sequence[str], values: np.ndarray) -> None:
        self.rig, self.free = rig, list(free)
        self.rows = [dict(zip(given, row, strict=True)) for row in values.tolist()]
        self.stations = Stations(rig, by_height="height" in given)
        self.solved = [self.stations.solve(*self._case(row, {})) for row in self.rows]
        """The last solution of each state: at first with the declared values of what is free or given."""
        names = [*self.free, *(name for name in given if name not in rig_quantities.CASE)]
        self._known = [{one.held_by == "clamp": _Known(one, _declared(one, names))} for one in self.solved]

    def _case(self, row: Mapping[str, float], values: Mapping[str, float]) -> StationCase:
        """Station, payload and height z of a row. Raises InputError."""
        load = float(values.get("payload", row.get("payload", self.rig.carriage.payload)))
        check.not_negative(load, self.rig.name, "payload", "kg")
        height = row.get("height")
        return StationCase(
            row["station"], load, None if height is None else carriage_height(self.rig, row["station"], height)
        )

    def predict(self, values: Mapping[str, float]) -> list[LinearState]:
        names = next(iter(self._known[0].values())).values
        every = [{name: values.get(name, row.get(name, 0.0)) for name in names} for row in self.rows]
        self.solved = [self._held(i, own) for i, own in enumerate(every)]
        return [rig_quantities.linearised(one, self.free, own) for one, own in zip(self.solved, every, strict=True)]

    def _held(self, i: int, values: Mapping[str, float]) -> Solved:
        """A state with other values: held by its clamp where the mainline would have to push, as by `Stations`. Raises
        EquilibriumError, InputError."""
        before, rig, name = self.solved[i], self.rig, self.rig.carriage.name
        clamped = before.held_by == "clamp"
        if rig.ideal or rig.carriage.clamped or not rig.kind.has_clamp:
            return self._moved(i, values, clamp=clamped)
        failure, pulled, held = None, None, None
        if clamped:
            held = self._moved(i, values, clamp=True)
        if held is None or held[f"{name}.holding"] > 0.0:
            try:
                pulled = self._moved(i, values, clamp=False, near=held)
            except EquilibriumError as error:
                failure = error
        own = self.stations.own_pull(before.at.span, self.rows[i]["station"])
        if held is None and (pulled is None or pulled[f"{name}.mainline_pull"] < own):
            try:
                held = self._moved(i, values, clamp=True)
            except EquilibriumError as error:
                failure = failure or error
        if pulled is not None and (held is None or held[f"{name}.holding"] > 0.0):
            return pulled
        if held is None:
            raise failure or EquilibriumError(f"No equilibrium at {self.label(i)}")
        return held

    def _moved(self, i: int, after: Mapping[str, float], *, clamp: bool, near: Solved | None = None) -> Solved:
        """A state with other values, from its last solution with the same hold, in smaller steps where one fails; one
        that has not had this hold before from a state `near` with the clamp, or from geometry. Raises EquilibriumError,
        InputError."""
        if clamp not in self._known[i]:
            solved = self._first(i, after, clamp=clamp, near=near)
            self._known[i][clamp] = _Known(solved, dict(after))
            return solved
        solved, before = self._known[i][clamp]
        done, share = 0.0, 1.0
        while done < 1.0:
            step = min(done + share, 1.0)
            values = {name: before[name] + step * (after[name] - before[name]) for name in after}
            try:
                solved = self._at(i, values, solved.at, solved.point.copy(), clamp=clamp)
            except EquilibriumError:
                share *= 0.5
                if share < _LEAST_SHARE:
                    raise
                continue
            done = step
        self._known[i][clamp] = _Known(solved, dict(after))
        return solved

    def _first(self, i: int, values: Mapping[str, float], *, clamp: bool, near: Solved | None) -> Solved:
        """A state with another hold. Raises EquilibriumError, InputError."""
        other, case = self.solved[i].at, self._case(self.rows[i], values)
        at = span_model(self.rig, other.place, other.by_height, clamp)
        if near is not None:
            try:
                return self._at(i, values, at, on_mainline(at, near), clamp=clamp)
            except EquilibriumError:
                pass
        return self._at(i, values, at, from_geometry(at, *case), clamp=clamp)

    def _at(self, i: int, values: Mapping[str, float], at: SpanModel, point: Point, *, clamp: bool) -> Solved:
        """A state with values, from a starting point of its model. Raises EquilibriumError, InputError."""
        case = self._case(self.rows[i], values)
        rig_quantities.write(at, point, values)
        point, _ = solved_in_place(at, point, case, iterations=_ITERATIONS)
        held_by = "clamp" if clamp else "holding" if at.rig.ideal else "mainline"
        return Solved(at, point, at.outputs(point), held_by, case)

    def reading(self, state: int, name: str) -> Reading:
        owner, _, quantity = name.rpartition(".")
        if quantity == RETURN_TIME:
            model = self.solved[state].at.model
            return return_time(model, model.runs, owner)
        return rig_reading(self.solved[state], name)

    def points(self, state: int, span: str, at: np.ndarray) -> Reading:
        model = self.solved[state].at.model
        return rope_points(model, model.runs, span, at)

    def candidates(self, state: int) -> Sequence[str]:
        columns = rig_columns(self.solved[state])
        return [name for name in columns if name in _CANDIDATES or name.endswith("_force")]

    def label(self, state: int) -> str:
        return f"station {self.rows[state]['station']:g} m"
