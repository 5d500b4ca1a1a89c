"""A rig as the source of a fit: its carriage at the station of each row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ropeway.components import check
from ropeway.components.errors import EquilibriumError, InputError, UnknownNameError
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.fitting.measured import GIVEN, MEASURED
from ropeway.systems.studies.fitting.rope_points import ROPE_X, ROPE_Y, ROPE_Z, rope_points
from ropeway.systems.studies.fitting.sources import Source, States
from ropeway.systems.studies.sensitivity import rig_quantities
from ropeway.systems.studies.sensitivity.linearisation import LinearState
from ropeway.systems.studies.sensitivity.reading import Reading
from ropeway.systems.studies.sensitivity.rig_readings import rig_columns, rig_reading, unit_of_reading
from ropeway.systems.studies.skyline.carriage_model import Place, Solved, StationCase, span_model
from ropeway.systems.studies.skyline.load_path import carriage_height
from ropeway.systems.studies.skyline.root_selection import solved_in_place
from ropeway.systems.studies.skyline.station_solver import Stations

_LEAST_SHARE = 1.0 / 64.0
"""Smallest part of a change of the free quantities, in steps from one solution to the next."""
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
        try:
            rig_quantities.unit_of(self._at, name)
        except UnknownNameError:
            rig_reading(self._one, name)
            return MEASURED
        return GIVEN

    def unit(self, name: str) -> str:
        if name.rpartition(".")[2] in (ROPE_X, ROPE_Y, ROPE_Z):
            return "m"
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


class RigStates(States):
    """The rig at the station of each row. Each state keeps its model and starts from its last solution."""

    def __init__(self, rig: SkylineRig, free: Sequence[str], given: Sequence[str], values: np.ndarray) -> None:
        self.rig, self.free = rig, list(free)
        self.rows = [dict(zip(given, row, strict=True)) for row in values.tolist()]
        solver = Stations(rig, by_height="height" in given)
        self.solved = [solver.solve(*self._case(row, {})) for row in self.rows]
        """The last solution of each state: at first with the declared values of what is free or given."""
        self._values = [rig_values(one, [*self.free, *(n for n in given if n not in rig_quantities.CASE)])
                        for one in self.solved]  # fmt: skip

    def _case(self, row: Mapping[str, float], values: Mapping[str, float]) -> StationCase:
        """Station, payload and height z of a row. Raises InputError."""
        load = float(values.get("payload", row.get("payload", self.rig.carriage.payload)))
        check.not_negative(load, self.rig.name, "payload", "kg")
        height = row.get("height")
        return StationCase(
            row["station"], load, None if height is None else carriage_height(self.rig, row["station"], height)
        )

    def predict(self, values: Mapping[str, float]) -> list[LinearState]:
        found, changes = list[Solved](), list[dict[str, float]]()
        for one, row, before in zip(self.solved, self.rows, self._values, strict=True):
            after = {name: values.get(name, row.get(name, 0.0)) for name in before}
            found.append(self._moved(one, row, before, after))
            changes.append(after)
        self.solved, self._values = found, changes
        return [rig_quantities.linearised(one, self.free, own) for one, own in zip(found, changes, strict=True)]

    def _moved(
        self, solved: Solved, row: Mapping[str, float], before: Mapping[str, float], after: Mapping[str, float]
    ) -> Solved:
        """A state with other values, from its last solution, in smaller steps where one fails. Raises
        EquilibriumError, InputError."""
        done, share, at = 0.0, 1.0, solved.at
        while done < 1.0:
            step = min(done + share, 1.0)
            values = {name: before[name] + step * (after[name] - before[name]) for name in after}
            point, case = solved.point.copy(), self._case(row, values)
            rig_quantities.write(at, point, values)
            try:
                point, _ = solved_in_place(at, point, case)
            except EquilibriumError:
                share *= 0.5
                if share < _LEAST_SHARE:
                    raise
                continue
            solved, done = Solved(at, point, at.outputs(point), solved.held_by, case), step
        return solved

    def reading(self, state: int, name: str) -> Reading:
        return rig_reading(self.solved[state], name)

    def points(self, state: int, span: str, at: np.ndarray) -> Reading:
        model = self.solved[state].at.model
        return rope_points(model, model.runs, span, at)

    def candidates(self, state: int) -> Sequence[str]:
        columns = rig_columns(self.solved[state])
        return [name for name in columns if name in _CANDIDATES or name.endswith("_force")]

    def label(self, state: int) -> str:
        return f"station {self.rows[state]['station']:g} m"


def rig_values(solved: Solved, names: Sequence[str]) -> dict[str, float]:
    """Declared values of quantities; the payload is that of the solved station."""
    return {
        name: solved.case.payload if name == "payload" and solved.case else rig_quantities.declared(solved.at, name)
        for name in names
    }
