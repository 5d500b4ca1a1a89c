"""Measured values against their predictions: residuals and their exact derivatives by all free quantities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ropeway.components.errors import InputError, UnknownNameError
from ropeway.systems.studies.fitting.measured import Measured
from ropeway.systems.studies.fitting.rope_points import ROPE_X, ROPE_Y, ROPE_Z
from ropeway.systems.studies.fitting.sources import Source, States
from ropeway.systems.studies.sensitivity.linearisation import LinearState

SENSOR = {"gain": 1.0, "offset": 0.0}
"""Quantities of a measured column that can be free, with their declared values."""


@dataclass(frozen=True)
class Prediction:
    """Predicted values `shown` (rows, columns), NaN where nothing is measured, their derivatives (rows, columns, free),
    and the states with their derivatives by the free quantities of the system."""

    shown: np.ndarray
    rates: np.ndarray
    states: Sequence[LinearState]


class Observations:
    """A measured table and the source of its predictions. `free` are quantities of the system, and "A.gain" and
    "A.offset" of column A."""

    def __init__(self, source: Source, measured: Measured, free: Sequence[str]) -> None:
        self.source, self.measured, self.free = source, measured, tuple(free)
        sensors = {f"{c.name}.{what}": (i, what) for i, c in enumerate(measured.columns) for what in SENSOR}
        for owner, _, quantity in (name.rpartition(".") for name in free):
            if owner in {c.name for c in measured.columns} and quantity not in SENSOR:
                raise UnknownNameError(
                    f"Column {owner!r} has no quantity {quantity!r}", f"Free {owner}.gain or {owner}.offset"
                )
        self.sensors = {j: sensors[name] for j, name in enumerate(free) if name in sensors}
        self.own = [j for j in range(len(free)) if j not in self.sensors]
        self.names = tuple(free[j] for j in self.own)
        """Free quantities of the system."""
        kept = [i for i, c in enumerate(measured.givens) if c.target.rpartition(".")[2] not in (ROPE_X, ROPE_Y)]
        targets = [measured.givens[i].target for i in kept]
        if both := set(targets) & set(self.names):
            raise InputError(f"{min(both)} is free, and given in a column", "Leave it out of one of them")
        values = measured.given[:, kept]
        if measured.time is None:
            unique, self.state = np.unique(values, axis=0, return_inverse=True)
            self.state = self.state.ravel()
        else:
            unique, self.state = values, np.arange(len(values))
        self.states: States = source.states(self.names, targets, unique, measured.time)
        self._places = [self._plan(c.target) for c in measured.columns]

    def _plan(self, target: str) -> np.ndarray | None:
        """Places (rows, 2) in plan of the points of a column; None for a column without points. Raises InputError."""
        span, _, quantity = target.rpartition(".")
        if quantity != ROPE_Z:
            return None
        at = np.full((len(self.measured.cells), 2), np.nan)
        for i, axis in enumerate((ROPE_X, ROPE_Y)):
            for j, column in enumerate(self.measured.givens):
                if column.target == f"{span}.{axis}":
                    at[:, i] = self.measured.given[:, j]
        if np.isnan(at[:, 0]).all():
            raise InputError(f"{target} has no places", f"Map a column to {span}.{ROPE_X}")
        return at

    def declared(self, name: str) -> float:
        """Declared value of a free quantity. Raises UnknownNameError, InputError."""
        quantity = name.rpartition(".")[2]
        return SENSOR[quantity] if self._is_sensor(name) else self.source.declared(name)

    def unit(self, name: str) -> str:
        """SI unit of a free quantity. Raises UnknownNameError."""
        if not self._is_sensor(name):
            return self.source.unit(name)
        column, _, quantity = name.rpartition(".")
        return "1" if quantity == "gain" else self.measured.columns[self.measured.column(column)].unit

    def usual(self, name: str, declared: float) -> float:
        """Size of a usual change of a free quantity: of a length 1 m, of a sensor's offset a tenth of what it shows, of
        others their declared value."""
        if name.rpartition(".")[2] == "offset" and self._is_sensor(name):
            shown = self.measured.cells[:, self.sensors[self.free.index(name)][0]]
            return 0.1 * float(np.nanmean(np.abs(shown))) or 1.0
        return 1.0 if self.unit(name) == "m" else abs(declared) or 1.0

    def _is_sensor(self, name: str) -> bool:
        return self.free.index(name) in self.sensors

    def predict(self, values: np.ndarray) -> Prediction:
        """Predictions for values of the free quantities. Raises EquilibriumError, SimulationError, InputError."""
        named = dict(zip(self.names, values[self.own].tolist(), strict=True))
        states = self.states.predict(named)
        shape = self.measured.cells.shape
        true, rates = np.full(shape, np.nan), np.zeros((*shape, len(self.free)))
        for s, state in enumerate(states):
            rows = np.flatnonzero(self.state == s)
            for i, column in enumerate(self.measured.columns):
                there = rows[np.isfinite(self.measured.cells[rows, i])]
                if not len(there):
                    continue
                places = self._places[i]
                try:
                    if places is None:
                        reading = self.states.reading(s, column.target)
                    else:
                        reading = self.states.points(s, column.target.rpartition(".")[0], places[there])
                    found, slope = reading.at(state)
                except UnknownNameError as error:
                    raise InputError(
                        f"Row {self.measured.rows[there[0]] + 1} measures {column.target} in {self.states.label(s)}: "
                        f"{error.cause}",
                        "Leave the cell blank",
                    ) from error
                true[there, i] = found
                rates[there[:, None], i, np.array(self.own, dtype=int)] = slope
        return Prediction(*self._sensed(values, true, rates), states)

    def _sensed(self, values: np.ndarray, true: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What sensors with unknown gain and offset show."""
        shown = true.copy()
        for j, (i, what) in self.sensors.items():
            if what == "gain":
                shown[:, i] *= values[j]
                rates[:, i] *= values[j]
        for j, (i, what) in self.sensors.items():
            if what == "gain":
                rates[:, i, j] = np.nan_to_num(true[:, i])
            else:
                shown[:, i] += values[j]
                rates[:, i, j] = np.isfinite(true[:, i])
        return shown, rates
