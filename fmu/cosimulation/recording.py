"""Rows of a co-simulation: chosen variables of all types over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import groupby
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components.errors import InputError, Interrupted
from ropeway.fmu.cosimulation.coupling import Coupling
from ropeway.fmu.errors import FmuRunError, FmuVariableError

_KINDS = "Boolean", "Integer", "Enumeration", "String", "Binary"
_RESERVED = 256e6
"""Largest memory that is reserved for rows to come [bytes]."""


class _Rows:
    """Rows of one NumPy type, which grow by an eighth when they are full."""

    def __init__(self, columns: int, dtype: str, expected: int) -> None:
        most = int(_RESERVED / max(8 * columns, 1))
        self._data = np.empty((max(min(expected, most), 1), columns), dtype)  # memory is used once it is written
        self._columns = columns

    def put(self, place: int, row: Sequence[Any] | np.ndarray) -> None:
        if place == len(self._data):
            self._data.resize((place + max(place // 8, 64), self._columns), refcheck=False)  # in place
        self._data[place] = row

    def first(self, count: int) -> np.ndarray:
        return self._data[:count]


class Recorder:
    """Records variables of coupled slaves: by default all outputs, real ones first.

    `every`: interval of the rows [s], by default each communication point; `expected`: the number of rows, if it is
    known. Raises InputError, FmuVariableError.
    """

    def __init__(
        self,
        coupling: Coupling,
        outputs: Sequence[str] | None = None,
        every: float | None = None,
        expected: int = 0,
    ) -> None:
        self.coupling, self._every = coupling, every
        self._times = _Rows(1, "float64", expected)
        self._count = 0
        self._last = self._next = -np.inf
        self._columns = _all_outputs(coupling) if outputs is None else _chosen(coupling, outputs)
        entries = [coupling.slaves[name].fmu.entries[variable] for name, variable in self._columns]
        self._places: dict[str, list[int]] = {}
        for place, entry in enumerate(entries):
            self._places.setdefault(entry.dtype if entry.kind != "Real" else "float64", []).append(place)
        self._rows = {dtype: _Rows(len(places), dtype, expected) for dtype, places in self._places.items()}
        self._reads = {dtype: self._split(places) for dtype, places in self._places.items()}

    def _split(self, places: Sequence[int]) -> list[tuple[str, list[str]]]:
        """Variables of one type by slave, in their order."""
        chosen = [self._columns[place] for place in places]
        return [(name, [variable for _, variable in own]) for name, own in groupby(chosen, lambda c: c[0])]

    @property
    def times(self) -> np.ndarray:
        """Times of the rows [s]."""
        return self._times.first(self._count)[:, 0]

    def add(self, time: float) -> None:
        """Records a row if one is due. Raises FmuRunError."""
        if self._every is None or time >= self._next - 1e-9 * self._every:
            self._record(time)
            if self._every is not None:
                first = float(self.times[0])
                self._next = first + (np.floor((time - first) / self._every + 1e-9) + 1) * self._every

    def finish(self, time: float) -> None:
        """Records the last row, if it is not recorded yet. Raises FmuRunError."""
        if time > self._last:
            self._record(time)

    def _record(self, time: float) -> None:
        slaves = self.coupling.slaves
        rows: dict[str, Any] = {}
        for dtype, reads in self._reads.items():
            if dtype == "float64":
                parts = [slaves[name].get(variables) for name, variables in reads]
                rows[dtype] = parts[0] if len(parts) == 1 else np.concatenate(parts)
            else:
                rows[dtype] = [v for name, variables in reads for v in slaves[name].read(variables)]
        for dtype, row in rows.items():
            self._rows[dtype].put(self._count, row)
        self._times.put(self._count, [time])
        self._count, self._last = self._count + 1, time

    @contextmanager
    def kept(self) -> Iterator[None]:
        """Attaches the rows up to now to an error or interrupt."""
        try:
            yield
        except (FmuRunError, Interrupted) as stop:
            stop.result = self.frame() if self._count else None
            raise

    def frame(self) -> pd.DataFrame:
        """All rows: index time [s], columns "slave.variable". The numbers are not copied.

        `attrs`: the "units" of the columns; "ended": why an FMU ended the run, or None; "left_out": outputs that cannot
        be shown, with reasons.
        """
        index = pd.Index(self.times, name="time", dtype=float)
        names = [f"{name}.{variable}" for name, variable in self._columns]
        parts = [
            pd.DataFrame(
                self._rows[dtype].first(self._count), index, [names[place] for place in places], dtype, copy=False
            )
            for dtype, places in self._places.items()
        ]
        frame = parts[0] if len(parts) == 1 else pd.concat([pd.DataFrame(index=index), *parts], axis=1)
        if list(frame.columns) != names:
            frame = frame[names]
        frame.attrs["units"] = {name: self._unit(*own) for name, own in zip(names, self._columns, strict=True)}
        frame.attrs["ended"] = self.coupling.ended
        frame.attrs["left_out"] = self._left_out()
        return frame

    def _unit(self, name: str, variable: str) -> str:
        fmu = self.coupling.slaves[name].fmu
        return str(fmu.variables.loc[variable, "unit"]) if fmu.entries[variable].kind == "Real" else "1"

    def _left_out(self) -> dict[str, str]:
        reasons = {}
        for name, slave in self.coupling.slaves.items():
            for v, entry in slave.fmu.entries.items():
                if entry.causality == "output" and (entry.clocked or entry.kind == "Clock"):
                    what = "a clock" if entry.kind == "Clock" else "a clocked variable"
                    reasons[f"{name}.{v}"] = f"{what}: it is defined only at its ticks"
        return reasons


def _all_outputs(coupling: Coupling) -> list[tuple[str, str]]:
    slaves = coupling.slaves.items()
    reals = [(name, variable) for name, slave in slaves for variable in slave.fmu.outputs()]
    return reals + [(name, variable) for name, slave in slaves for variable in slave.fmu.outputs(*_KINDS)]


def _chosen(coupling: Coupling, outputs: Sequence[str]) -> list[tuple[str, str]]:
    """Raises InputError, FmuVariableError."""
    found: list[tuple[str, str]] = []
    for output in outputs:
        name, _, variable = output.partition(".")
        if name not in coupling.slaves:
            raise InputError(f"{output!r}: no slave is named {name!r}", f"Slaves are {', '.join(coupling.slaves)}")
        entry = coupling.slaves[name].fmu.entry(variable)
        if entry.clocked or entry.kind == "Clock":
            raise FmuVariableError(f"{output!r} is defined only at the ticks of a clock", "Leave it out", variable)
        if (name, variable) in found:
            raise InputError(f"{output!r} is named twice in outputs", "Name it once")
        found.append((name, variable))
    if not found:
        raise InputError("outputs is empty", "Name at least one variable, or leave it out")
    return found
