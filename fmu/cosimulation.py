"""Slaves coupled by a master: Jacobi or Gauss-Seidel, explicit or iterated with rollback."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.errors import InputError
from ropeway.fmu.errors import FmuRunError, FmuVariableError
from ropeway.fmu.exporting import export
from ropeway.fmu.imported import Fmu, load
from ropeway.fmu.slave import Slave, require_causality
from ropeway.systems.system import System


@dataclass(frozen=True)
class Connection:
    """An output that drives an input: names as "slave.variable"; the input is factor times the output plus offset."""

    source: str
    target: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class _Participant:
    fmu: Fmu
    kind: str
    start: Mapping[str, float]


class CoSimulation:
    """FMUs and systems that exchange values at communication points.

    step: between two points [s]. master: "Jacobi" (all from the values at the last point) or "Gauss-Seidel" (in the
    order in which they were added, each with the newest values). iterated: each step is repeated until the values at
    its end agree to `tolerance` (relative, on changes of the inputs); inputs are then linear in time where a slave
    can take that, else held at their mean. Raises InputError.
    """

    def __init__(
        self,
        step: float,
        *,
        master: Literal["Jacobi", "Gauss-Seidel"] = "Jacobi",
        iterated: bool = False,
        tolerance: float = 1e-9,
        iterations: int = 50,
    ) -> None:
        check.positive(step, "CoSimulation", "step", "s")
        check.positive(tolerance, "CoSimulation", "tolerance")
        if master not in ("Jacobi", "Gauss-Seidel"):
            raise InputError(f"master is {master!r}", 'Choose "Jacobi" or "Gauss-Seidel"')
        self.step, self.master, self.iterated = float(step), master, iterated
        self.tolerance, self.iterations = tolerance, iterations
        self._participants: dict[str, _Participant] = {}
        self._connections: list[Connection] = []
        self._folder = Path(tempfile.mkdtemp(prefix="ropeway-"))
        weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)

    def add(
        self,
        name: str,
        participant: System | Fmu | str | Path,
        *,
        kind: Literal["CoSimulation", "ModelExchange"] = "CoSimulation",
        start: Mapping[str, float] | None = None,
    ) -> Fmu:
        """Adds an FMU, or a system, which is exported first; returns the FMU. kind: how it is moved on, "ModelExchange"
        by an integrator here. start: values of its parameters and inputs. Raises InputError, FmuImportError,
        FmuVariableError."""
        check.name(name, "slave")
        if name in self._participants:
            raise InputError(f"Two slaves are named {name!r}", "Give each a name of its own")
        if isinstance(participant, System):
            participant = export(participant, self._folder / f"{name}.fmu")
        fmu = participant if isinstance(participant, Fmu) else load(participant)
        values = {key: float(value) for key, value in (start or {}).items()}
        for key, value in values.items():
            fmu.variable(key)
            check.number(value, f"Slave {name!r}", key)
        self._participants[name] = _Participant(fmu, kind, values)
        return fmu

    def connect(self, source: str, target: str) -> Connection:
        """Lets an output drive an input, "slave.variable" each; units are converted. Raises InputError for a slave that
        is not there, FmuVariableError for a variable that is not, or does not fit."""
        ends = []
        for end, causality in ((source, "output"), (target, "input")):
            slave, _, variable = end.partition(".")
            if slave not in self._participants:
                raise InputError(f"{end!r}: no slave is named {slave!r}", f"Slaves are {', '.join(self._participants)}")
            fmu = self._participants[slave].fmu
            require_causality(fmu, variable, causality)
            ends.append((fmu, variable))
        if any(c.target == target for c in self._connections):
            raise InputError(f"{target!r} is driven already", "An input takes one connection")
        connection = Connection(source, target, *_conversion(*ends[0], *ends[1]))
        self._connections.append(connection)
        return connection

    def run(self, until: float) -> pd.DataFrame:
        """Runs from 0 to `until` [s]. Returns all real outputs over time, columns "slave.variable"; units in
        `attrs["units"]`. Raises InputError, FmuImportError, FmuRunError."""
        check.positive(until, "run", "until", "s")
        if not self._participants:
            raise InputError("There is no slave", "Add FMUs or systems")
        with ExitStack() as stack:
            slaves = {name: stack.enter_context(Slave(p.fmu, name, p.kind)) for name, p in self._participants.items()}
            if self.iterated:
                self._require_rollback(slaves)
            for name, slave in slaves.items():
                slave.enter(0.0, self._participants[name].start)
            values = self._initialise(slaves)
            for slave in slaves.values():
                slave.leave()
            columns = {name: p.fmu.names("output") for name, p in self._participants.items()}
            times, rows = [0.0], [_row(slaves, columns)]
            count = max(1, round(until / self.step))
            for i in range(count):
                size = (until if i == count - 1 else (i + 1) * self.step) - i * self.step
                values = self._iterate(slaves, size, values) if self.iterated else self._once(slaves, size, values)
                times.append(i * self.step + size)
                rows.append(_row(slaves, columns))
        names = [f"{slave}.{v}" for slave, outputs in columns.items() for v in outputs]
        frame = pd.DataFrame(rows, index=pd.Index(times, name="time"), columns=names)
        units = [str(p.fmu.variables.loc[v, "unit"]) for slave, p in self._participants.items() for v in columns[slave]]
        frame.attrs["units"] = dict(zip(names, units, strict=True))
        return frame

    def _require_rollback(self, slaves: Mapping[str, Slave]) -> None:
        for name, slave in slaves.items():
            if not slave.can_restore:
                raise InputError(
                    f"{name!r} cannot go back in time, so its steps cannot be repeated",
                    'Use iterated=False, or add it with kind="ModelExchange"',
                )

    def _read(self, slaves: Mapping[str, Slave]) -> np.ndarray:
        """What the connections carry now."""
        carried = []
        for c in self._connections:
            slave, _, variable = c.source.partition(".")
            carried.append(c.factor * float(slaves[slave].get([variable])[0]) + c.offset)
        return np.array(carried)

    def _inputs_of(self, name: str, values: np.ndarray) -> dict[str, float]:
        """The connected inputs of a slave."""
        prefix = f"{name}."
        return {
            c.target.removeprefix(prefix): float(v)
            for c, v in zip(self._connections, values, strict=True)
            if c.target.startswith(prefix)
        }

    def _from(self, name: str) -> np.ndarray:
        """Which connections a slave drives."""
        return np.array([c.source.partition(".")[0] == name for c in self._connections], dtype=bool)

    def _put(self, slaves: Mapping[str, Slave], values: np.ndarray) -> None:
        for name, slave in slaves.items():
            slave.set(self._inputs_of(name, values))

    def _initialise(self, slaves: Mapping[str, Slave]) -> np.ndarray:
        """Consistent values of the connections: Newton's method, its Jacobian by finite differences."""
        values = self._read(slaves)
        n = len(values)
        for _ in range(self.iterations):
            self._put(slaves, values)
            miss = self._read(slaves) - values
            scale = 1.0 + np.abs(values)
            if np.all(np.abs(miss) <= self.tolerance * scale):
                return values
            jacobian = -np.eye(n)
            for j in range(n):
                moved = values.copy()
                moved[j] += 1e-6 * scale[j]
                self._put(slaves, moved)
                jacobian[:, j] += (self._read(slaves) - miss - values) / (1e-6 * scale[j])
            values = values - np.linalg.lstsq(jacobian, miss, rcond=None)[0]
        raise FmuRunError(
            "The slaves find no common start: an algebraic loop has no solution that Newton's method finds",
            "Give start values nearer to one",
        )

    def _once(self, slaves: Mapping[str, Slave], size: float, values: np.ndarray) -> np.ndarray:
        """One step with the values at its start."""
        for name, slave in slaves.items():
            given = self._inputs_of(name, values)
            slave.step(size, given, given)
            if self.master == "Gauss-Seidel":
                values = np.where(self._from(name), self._read(slaves), values)
        return self._read(slaves)

    def _iterate(self, slaves: Mapping[str, Slave], size: float, values: np.ndarray) -> np.ndarray:
        """One step, repeated until the values at its end agree."""
        states = {name: slave.save() for name, slave in slaves.items()}
        end = values.copy()
        try:
            for turn in range(self.iterations):
                before = end.copy()
                for name, slave in slaves.items():
                    if turn:
                        slave.restore(states[name])
                    slave.step(size, self._inputs_of(name, values), self._inputs_of(name, end))
                    if self.master == "Gauss-Seidel":
                        end = np.where(self._from(name), self._read(slaves), end)
                end = self._read(slaves)
                if np.all(np.abs(end - before) <= self.tolerance * (1.0 + np.abs(end))):
                    return end
        finally:
            for name, slave in slaves.items():
                slave.forget(states[name])
        raise FmuRunError(
            f"The values at the end of the step of {size:g} s do not agree after {self.iterations} iterations",
            "Make the step smaller",
        )


def _row(slaves: Mapping[str, Slave], columns: Mapping[str, list[str]]) -> np.ndarray:
    return np.concatenate([slaves[name].get(outputs) for name, outputs in columns.items()])


def _conversion(source: Fmu, output: str, target: Fmu, entry: str) -> tuple[float, float]:
    """Factor and offset from one unit to another. Raises FmuVariableError."""
    names = str(source.variable(output)["unit"]), str(target.variable(entry)["unit"])
    one, other = source.units.get(names[0]), target.units.get(names[1])
    if names[0] == names[1] or one is None or other is None:
        return 1.0, 0.0
    if not one.fits(other):
        raise FmuVariableError(
            f"{output!r} of {source.path.name} is in {names[0]}, {entry!r} of {target.path.name} in {names[1]}",
            "Connect variables of one quantity",
            entry,
        )
    return one.factor / other.factor, (one.offset - other.offset) / other.factor
