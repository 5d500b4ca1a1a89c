"""Open slaves and what passes between them: a common start, and one communication step after another."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.slave import Slave

Master = Literal["Jacobi", "Gauss-Seidel"]


@dataclass(frozen=True)
class Connection:
    """An output that drives an input: names as "slave.variable"; the input is factor times the output plus offset."""

    source: str
    target: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Scheme:
    """How a step is taken. master: "Jacobi" (all from the values at the last point) or "Gauss-Seidel" (in the order in
    which they were added, each with the newest values); iterated: repeated until the values at its end agree to
    `tolerance`, relative, in at most so many iterations."""

    master: Master
    iterated: bool
    tolerance: float
    iterations: int

    @property
    def order(self) -> int:
        """By which power of the step inputs within it are wrong: they are held, or linear."""
        return 2 if self.iterated else 1


class Coupling:
    """Slaves between two communication points. `values` is what the connections carry, `missed` by how much the values
    at the end of the last step differ from those that the slaves were given for it: held ones, or, when iterated, those
    that the step before foretold."""

    def __init__(self, slaves: Mapping[str, Slave], connections: Sequence[Connection], scheme: Scheme) -> None:
        self.slaves, self.connections, self.scheme = slaves, connections, scheme
        self._sources = {name: _ends([c.source for c in connections], name) for name in slaves}
        self._targets = {name: _ends([c.target for c in connections], name) for name in slaves}
        self._factors = np.array([c.factor for c in connections])
        self._offsets = np.array([c.offset for c in connections])
        self.values = np.zeros(len(connections))
        self.missed = np.zeros(len(connections))
        self._slopes = np.zeros(len(connections))
        variables = {name: slave.fmu.names("output") for name, slave in slaves.items()}
        self._outputs = variables
        self._discrete = [
            (name, slave.fmu.names("output", kind), read)
            for name, slave in slaves.items()
            for kind, read in (("Boolean", bool), ("Integer", int))
        ]
        self.names = [f"{name}.{v}" for name, outputs in variables.items() for v in outputs]
        self.nominals = np.concatenate([_nominals(slaves[name], outputs) for name, outputs in variables.items()])
        self.input_nominals = np.array([1.0] * len(connections))
        for name, ends in self._targets.items():
            for i, nominal in zip(ends, _nominals(slaves[name], list(ends.values())), strict=True):
                self.input_nominals[i] = nominal

    @property
    def can_restore(self) -> bool:
        """Whether a step can be repeated."""
        return all(slave.can_restore for slave in self.slaves.values())

    def outputs(self) -> np.ndarray:
        """All real outputs, as in `names`. Raises FmuRunError."""
        return np.concatenate([self.slaves[name].get(outputs) for name, outputs in self._outputs.items()])

    def discrete(self) -> dict[str, bool | int]:
        """All Boolean and integer outputs, by name. Raises FmuRunError."""
        found: dict[str, bool | int] = {}
        for name, variables, read in self._discrete:
            values = self.slaves[name].get(variables)
            found.update((f"{name}.{v}", read(x)) for v, x in zip(variables, values, strict=True))
        return found

    def _read(self, name: str, values: np.ndarray) -> None:
        """Writes what a slave gives to its connections into `values`."""
        ends = self._sources[name]
        found = self.slaves[name].get(list(ends.values()))
        for (i, variable), value in zip(ends.items(), found, strict=True):
            if not np.isfinite(value):
                slave = self.slaves[name]
                raise FmuRunError(f"{name}.{variable} is {value} at t = {slave.time:.9g} s", "Look at its inputs there")
            values[i] = self._factors[i] * value + self._offsets[i]

    def _read_all(self) -> np.ndarray:
        values = np.zeros(len(self.connections))
        for name in self.slaves:
            self._read(name, values)
        return values

    def _inputs(self, name: str, values: np.ndarray) -> dict[str, float]:
        return {variable: float(values[i]) for i, variable in self._targets[name].items()}

    def _miss(self, values: np.ndarray) -> np.ndarray:
        """What the slaves answer to values, less these."""
        for name, slave in self.slaves.items():
            slave.set(self._inputs(name, values))
        return self._read_all() - values

    def initialise(self) -> None:
        """Consistent values of the connections by a damped Newton's method. Raises FmuRunError."""
        values = self._read_all()
        miss = self._miss(values)
        for _ in range(self.scheme.iterations):
            if self._agree(miss, values):
                self.values = values
                return
            move, share = np.linalg.lstsq(self._loop(values), -miss, rcond=None)[0], 1.0
            before = np.linalg.norm(miss / self.input_nominals)
            while share > 1e-6:
                try:
                    miss = self._miss(values + share * move)
                except FmuRunError as error:  # values that a slave refuses: too far
                    if error.fatal:
                        raise
                else:
                    if np.linalg.norm(miss / self.input_nominals) < (1.0 - 0.1 * share) * before:
                        break
                share /= 2.0
            else:
                break
            values = values + share * move
        worst = self.connections[int(np.argmax(np.abs(miss) / self.input_nominals))]
        raise FmuRunError(
            f"The slaves find no common start: {worst.source} and {worst.target} cannot be made to agree",
            "Give start values nearer to a solution; the algebraic loop may have none",
        )

    def _agree(self, change: np.ndarray, values: np.ndarray) -> bool:
        return bool(np.all(np.abs(change) <= self.scheme.tolerance * (1.0 + np.abs(values))))

    def _loop(self, values: np.ndarray) -> np.ndarray:
        """Derivatives of the slaves' answers, less the values, by the values."""
        matrix = -np.eye(len(values))
        for name, slave in self.slaves.items():
            rows, columns = self._sources[name], self._targets[name]
            if rows and columns:
                direct = slave.derivatives(list(rows.values()), self._inputs(name, values))
                matrix[np.ix_(list(rows), list(columns))] += self._factors[list(rows), None] * direct
        return matrix

    def step(self, size: float) -> None:
        """Moves all slaves on by `size` seconds. When it fails they stand anywhere. Raises FmuRunError."""
        if self.scheme.iterated:
            self._iterate(size)
        else:
            self._once(size)

    def _once(self, size: float) -> None:
        values, given = self.values.copy(), self.values.copy()
        for name, slave in self.slaves.items():
            held = self._inputs(name, values)
            for i in self._targets[name]:
                given[i] = values[i]
            slave.step(size, held, held)
            if self.scheme.master == "Gauss-Seidel":
                self._read(name, values)
        values = self._read_all()
        self.values = values + self._miss(values)  # outputs that follow inputs at once
        self.missed = np.abs(self.values - given)

    def _iterate(self, size: float) -> None:
        foretold = self.values + size * self._slopes
        end = foretold.copy()
        with self.saved() as back:
            for turn in range(self.scheme.iterations):
                before = end.copy()
                if turn:
                    back()
                for name, slave in self.slaves.items():
                    slave.step(size, self._inputs(name, self.values), self._inputs(name, end))
                    if self.scheme.master == "Gauss-Seidel":
                        self._read(name, end)
                end = self._read_all()
                if self._agree(end - before, end):
                    break
            else:
                worst = self.connections[int(np.argmax(np.abs(end - before) / (1.0 + np.abs(end))))]
                raise FmuRunError(
                    f"The values at the end of the step of {size:g} s do not agree after {self.scheme.iterations} "
                    f"iterations, worst is {worst.source}",
                    "Make the step smaller",
                )
        self._slopes = (end - self.values) / size
        self.missed = np.abs(end - foretold)
        self.values = end

    @contextmanager
    def saved(self) -> Iterator[Callable[[], None]]:
        """Keeps the present point; gives a function that goes back to it. Raises FmuRunError, InputError."""
        values, slopes = self.values, self._slopes
        states: dict[str, Any] = {}

        def back() -> None:
            for name, slave in self.slaves.items():
                slave.restore(states[name])
            self.values, self._slopes = values, slopes

        try:
            for name, slave in self.slaves.items():
                states[name] = slave.save()
            yield back
        finally:
            for name, state in states.items():
                self.slaves[name].forget(state)


def _ends(ends: Sequence[str], slave: str) -> dict[int, str]:
    """Variables of a slave among the ends of connections, by place."""
    found = ((i, *end.partition(".")[::2]) for i, end in enumerate(ends))
    return {i: variable for i, owner, variable in found if owner == slave}


def _nominals(slave: Slave, names: Sequence[str]) -> np.ndarray:
    nominals = slave.fmu.variables.loc[list(names), "nominal"]
    return np.array([1.0 if n is None or not np.isfinite(n) or n == 0.0 else abs(n) for n in nominals])
