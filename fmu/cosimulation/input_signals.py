"""Inputs of slaves over time: schedules, tables and constants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pandas as pd

from ropeway.components import table
from ropeway.components.errors import InputError
from ropeway.components.schedule import Schedule
from ropeway.components.table import TableLayout
from ropeway.components.table_file import name_and_unit
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.variable_types import Entry, Value, from_text, taken_by

SAME = 1e-9
"""Times closer than this are equal [s]."""
_EXAMPLE = "time,line.c1.speed,line.c1.brake\n0,1.5,false\n60,1.5,true"
Inputs: TypeAlias = Mapping[str, Schedule | pd.Series | Value] | pd.DataFrame | str | Path


@dataclass(frozen=True)
class Signal:
    """A variable over time: `values` at `times` [s].

    `linear`: linear between two times, and two equal times are a jump; otherwise each value holds until the next.
    Before the first time the first value holds.
    """

    times: np.ndarray
    values: Sequence[Value]
    linear: bool

    def after(self, time: float) -> Value:
        """Value from a time on."""
        return self._at(time, int(np.searchsorted(self.times, time + SAME, side="right")))

    def before(self, time: float) -> Value:
        """Value up to a time."""
        return self._at(time, int(np.searchsorted(self.times, time - SAME, side="left")))

    def _at(self, time: float, later: int) -> Value:
        """Value at a time; `later`: index of the next one."""
        if later == 0 or later == len(self.times) or not self.linear:
            return self.values[max(later - 1, 0)]
        before, after = float(self.times[later - 1]), float(self.times[later])
        share = min(max((time - before) / (after - before), 0.0), 1.0)
        low, high = float(self.values[later - 1]), float(self.values[later])
        return low + share * (high - low)


def next_break(breaks: np.ndarray, time: float, until: float) -> float:
    """First of the sorted times `breaks` after `time`, at most `until` [s]."""
    later = breaks[np.searchsorted(breaks, time + SAME, side="right") :][:1]
    return float(later[0]) if len(later) and later[0] < until - SAME else until


def signals(inputs: Inputs, fmus: Mapping[str, Fmu], until: float) -> dict[str, Signal]:
    """Inputs by "slave.variable". Raises InputError, FmuVariableError."""
    return {target: _signal(target, given, fmus, until) for target, given in _columns(inputs, fmus).items()}


def _columns(inputs: Inputs, fmus: Mapping[str, Fmu]) -> Mapping[str, Schedule | pd.Series | Value]:
    if isinstance(inputs, str | Path):
        inputs = _read(inputs, fmus)
    if isinstance(inputs, pd.DataFrame):
        rows = inputs.set_index("time") if "time" in inputs.columns else inputs
        return {str(name): rows[name] for name in rows.columns}
    if not isinstance(inputs, Mapping):
        raise InputError(f"inputs is {inputs!r:.60}", 'Give a table, or a dictionary {"slave.variable": Schedule(...)}')
    return inputs


def _signal(target: str, given: Schedule | pd.Series | Value, fmus: Mapping[str, Fmu], until: float) -> Signal:
    entry, file = tunable_entry(target, fmus)
    if isinstance(given, Schedule):
        if not entry.continuous:
            raise InputError(
                f"{target!r} is {entry.variability}: it cannot follow a piecewise linear schedule",
                "Give a table or a pandas Series, whose values hold until the next",
            )
        given.require(until)
        return Signal(np.array(given.times), given.speeds, linear=True)
    if not isinstance(given, pd.Series):
        return Signal(np.zeros(1), [taken_by(entry, target, file, given)], linear=False)
    times = _times(given, target)
    linear = entry.continuous and len(times) > 1
    if linear and times[-1] < until - 1e-9:
        raise InputError(
            f"The values of {target!r} end at {times[-1]:g} s, before {until:g} s",
            "Extend them, or end the run earlier",
        )
    return Signal(times, [taken_by(entry, target, file, v) for v in given], linear)


def tunable_entry(target: str, fmus: Mapping[str, Fmu]) -> tuple[Entry, str]:
    """Type of an input or tunable parameter, and its file. Raises InputError, FmuVariableError."""
    slave, _, variable = target.partition(".")
    if slave not in fmus:
        raise InputError(f"{target!r}: no slave is named {slave!r}", f"Slaves are {', '.join(fmus)}")
    entry = fmus[slave].entry(variable)
    if entry.causality != "input" and (entry.causality, entry.variability) != ("parameter", "tunable"):
        raise InputError(
            f"{target!r} is of causality {entry.causality}, {entry.variability}: it cannot change during a run",
            "Only inputs and tunable parameters can change",
        )
    return entry, fmus[slave].path.name


def _times(given: pd.Series, target: str) -> np.ndarray:
    try:
        times = np.asarray(given.index, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"The index of {target!r} has no times", "Give times in seconds as the index") from error
    if not len(times) or not np.all(np.isfinite(times)):
        raise InputError(f"The index of {target!r} has no times", "Give times in seconds as the index")
    if np.any(np.diff(times) < 0.0):
        k = int(np.argmax(np.diff(times) < 0.0))
        raise InputError(f"Times of {target!r} do not increase: {times[k + 1]} s after {times[k]} s", "Sort them")
    return times


def _read(path: str | Path, fmus: Mapping[str, Fmu]) -> pd.DataFrame:
    """Inputs from a file, in the units of the variables."""
    first = table.read(path, TableLayout({"time": "s"}, _EXAMPLE))
    known = {f"{slave}.{variable}" for slave, fmu in fmus.items() for variable in fmu.entries}
    names = [c if c in known else name_and_unit(c)[0] for c in first.columns]  # the index of an element is not a unit
    found = {n: tunable_entry(n, fmus)[0] for n in names if n.casefold() != "time"}
    reals = [n for n, entry in found.items() if entry.kind == "Real"]
    units = {n: str(_variable(n, fmus)["unit"]) if n in reals else None for n in found}
    differences = frozenset(n for n in reals if _variable(n, fmus)["relative"])
    rows = table.read(path, TableLayout({"time": "s"} | units, _EXAMPLE, differences))
    values = pd.DataFrame(rows.numbers("time", *reals), columns=["time", *reals])
    for name in found.keys() - set(reals):
        values[name] = pd.Series([from_text(found[name], cell) for cell in rows.texts(name)], dtype=object)
    return values


def _variable(target: str, fmus: Mapping[str, Fmu]) -> pd.Series:
    slave, _, variable = target.partition(".")
    return fmus[slave].variable(variable)
