"""Rows of a co-simulation: outputs of all types over time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from ropeway.components.errors import Interrupted
from ropeway.fmu.cosimulation.coupling import Coupling
from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.importing.variable_types import Value

_KINDS = "Boolean", "Integer", "Enumeration", "String", "Binary"


@dataclass
class Recorder:
    """Records the outputs of coupled slaves, real ones first."""

    coupling: Coupling
    times: list[float] = field(default_factory=list)
    _rows: list[np.ndarray] = field(default_factory=list)
    _others: list[list[Value]] = field(default_factory=list)

    def __post_init__(self) -> None:
        slaves = self.coupling.slaves
        self._names = {name: slave.fmu.outputs(*_KINDS) for name, slave in slaves.items()}
        self._columns = [f"{name}.{v}" for name, names in self._names.items() for v in names]
        self._dtypes = [slaves[name].fmu.entries[v].dtype for name, names in self._names.items() for v in names]

    def add(self, time: float) -> None:
        """Records a row. Raises FmuRunError."""
        row = self.coupling.outputs()
        others = [v for name, names in self._names.items() for v in self.coupling.slaves[name].read(names)]
        self.times.append(time)
        self._rows.append(row)
        self._others.append(others)

    @contextmanager
    def kept(self) -> Iterator[None]:
        """Attaches the rows up to now to an error or interrupt."""
        try:
            yield
        except (FmuRunError, Interrupted) as stop:
            stop.result = self.frame() if self.times else None
            raise

    def frame(self) -> pd.DataFrame:
        """All rows: index time [s], columns "slave.variable".

        `attrs`: the "units" of the columns; "ended": why an FMU ended the run, or None; "left_out": outputs that cannot
        be shown, with reasons.
        """
        index = pd.Index(self.times, name="time", dtype=float)
        reals = pd.DataFrame(np.reshape(self._rows, (len(index), -1)), index, self.coupling.names)
        columns = zip(self._columns, self._dtypes, zip(*self._others, strict=True), strict=False)
        others = {name: pd.Series(list(values), index, dtype=dtype) for name, dtype, values in columns}
        frame = reals.join(pd.DataFrame(others, index)) if others else reals
        frame.attrs["units"] = dict.fromkeys(frame.columns, "1") | self._units()
        frame.attrs["ended"] = self.coupling.ended
        frame.attrs["left_out"] = self._left_out()
        return frame

    def _units(self) -> dict[str, str]:
        return {
            f"{name}.{v}": str(slave.fmu.variables.loc[v, "unit"])
            for name, slave in self.coupling.slaves.items()
            for v in slave.fmu.outputs()
        }

    def _left_out(self) -> dict[str, str]:
        reasons = {}
        for name, slave in self.coupling.slaves.items():
            for v, entry in slave.fmu.entries.items():
                if entry.causality == "output" and (entry.clocked or entry.kind == "Clock"):
                    what = "a clock" if entry.kind == "Clock" else "a clocked variable"
                    reasons[f"{name}.{v}"] = f"{what}: it is defined only at its ticks"
        return reasons
