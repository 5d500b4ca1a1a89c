"""Scenarios: changes of inputs and parameters at given times, which take precedence over connections."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pandas as pd

from ropeway.components import table
from ropeway.components.errors import InputError
from ropeway.components.table import TableLayout
from ropeway.fmu.cosimulation.input_signals import SAME, tunable_entry
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.variable_types import Value, from_text, taken_by

Scenario: TypeAlias = pd.DataFrame | str | Path
_COLUMNS = "time", "variable", "value"
_EXAMPLE = "time,variable,value\n10,line.c1.speed,0.5\n20,line.c1.speed,"


@dataclass(frozen=True)
class Change:
    """Values of a variable from `times` on [s]; None: its connection applies again."""

    times: np.ndarray
    values: tuple[Value | None, ...]

    def at(self, time: float) -> Value | None:
        """Value from a time on, None where the scenario gives none."""
        later = int(np.searchsorted(self.times, time + SAME, side="right"))
        return self.values[later - 1] if later else None


def changes(scenario: Scenario, fmus: Mapping[str, Fmu], connected: Iterable[str]) -> dict[str, Change]:
    """Changes by "slave.variable". Raises InputError, FmuVariableError."""
    rows = _rows(scenario)
    found: dict[str, list[tuple[float, Value | None]]] = {}
    for time, target, given in rows:
        entry, file = tunable_entry(target, fmus)
        value: Value | None = None
        if not _empty(given):
            value = taken_by(entry, target, file, from_text(entry, given) if isinstance(given, str) else given)
        elif target not in set(connected):
            raise InputError(
                f"The scenario has no value for {target!r} at {time:g} s",
                "Give one; only a connected input is released by an empty value",
            )
        found.setdefault(target, []).append((time, value))
    return {
        target: Change(np.array([time for time, _ in own]), tuple(value for _, value in own))
        for target, own in ((t, sorted(rows, key=lambda row: row[0])) for t, rows in found.items())
    }


def _rows(scenario: Scenario) -> list[tuple[float, str, object]]:
    if not isinstance(scenario, pd.DataFrame):
        read = table.read(scenario, TableLayout({"time": "s", "variable": None, "value": None}, _EXAMPLE))
        times = read.numbers("time")[:, 0]
        return list(zip(times.tolist(), read.texts("variable"), read.texts("value"), strict=True))
    if missing := [name for name in _COLUMNS if name not in scenario.columns]:
        raise InputError(f"The scenario has no column {missing[0]}", f"It has a row for each change: {_EXAMPLE!r}")
    times = pd.to_numeric(scenario["time"], errors="coerce").to_numpy(dtype=float)
    if not np.all(np.isfinite(times)):
        raise InputError("The scenario has a time that is not a number", "Give times in seconds")
    return list(zip(times.tolist(), map(str, scenario["variable"]), scenario["value"], strict=True))


def _empty(value: object) -> bool:
    return value is None or value == "" or (isinstance(value, float) and np.isnan(value)) or value is pd.NA
