"""Slaves and their connections: consistent start values, and communication steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ropeway.components import check
from ropeway.components.errors import InputError
from ropeway.fmu.cosimulation.algebraic_loops import loops, require_one_solution
from ropeway.fmu.cosimulation.connections import Connection
from ropeway.fmu.cosimulation.discrete_exchange import Exchange
from ropeway.fmu.cosimulation.input_signals import Signal
from ropeway.fmu.cosimulation.scenario import Change
from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.importing.participant import OpenFmu

Master = Literal["Jacobi", "Gauss-Seidel"]


@dataclass(frozen=True)
class Span:
    """A run from `start` to `until` in steps [s]."""

    start: float
    until: float
    step: float

    def require(self) -> None:
        """Raises InputError if there are no steps, or too many."""
        check.number(self.until, "run", "until", "s")
        check.number(self.start, "run", "start_time", "s")
        if self.until <= self.start:
            raise InputError(f"run: until is {self.until!r} s", f"It must be above the start time, {self.start:g} s")
        check.count((self.until - self.start) / self.step, "run", "steps")

    def count(self, every: float | None) -> int:
        """Number of rows, one `every` so many seconds or at each communication point, and that of the end."""
        return int((self.until - self.start) / max(every or 0.0, self.step)) + 2

    def point(self, i: int) -> float:
        """Time of communication point i."""
        return self.until if i >= (self.until - self.start) / self.step - 1e-9 else self.start + i * self.step


@dataclass(frozen=True)
class Driving:
    """What drives slaves from outside: `signals` of inputs and `changes` of a scenario, by "slave.variable".

    `slow`: steps of slaves that take longer ones than the others [s].
    """

    signals: Mapping[str, Signal] = field(default_factory=dict)
    changes: Mapping[str, Change] = field(default_factory=dict)
    slow: Mapping[str, float] = field(default_factory=dict)

    @property
    def breaks(self) -> np.ndarray:
        """Times of all vertices, jumps and changes [s]."""
        times = [s.times for s in self.signals.values()] + [c.times for c in self.changes.values()]
        return np.unique(np.concatenate([np.empty(0), *times]))


@dataclass(frozen=True)
class Scheme:
    """How a communication step is taken.

    `master`: "Jacobi" (all slaves use the values of the last point) or "Gauss-Seidel" (in the order in which they were
    added, each with the newest values); `iterated`: repeated until the values at the end agree to the relative
    `tolerance`, in at most `iterations`.
    """

    master: Master
    iterated: bool
    tolerance: float
    iterations: int

    @property
    def order(self) -> int:
        """Order of the input error in the step size: inputs are constant or linear."""
        return 2 if self.iterated else 1


class Coupling:
    """Slaves at a communication point, at `time` [s].

    `values`: those of the continuous connections; `missed`: their difference at the end of the last step from the
    values that the slaves used (constant, or extrapolated when iterated). `aligned`: all slaves are at `time`; they are
    not if an FMU ended the run within a step after others had gone further. Inputs and outputs of slow slaves change at
    the ends of their own steps.
    """

    def __init__(
        self,
        slaves: Mapping[str, OpenFmu],
        connections: Sequence[Connection],
        scheme: Scheme,
        driving: Driving,
        span: Span,
    ) -> None:
        self.slaves, self.scheme, self.time, self.aligned = slaves, scheme, span.start, True
        self._slow, self._until = driving.slow, span.until
        self._begun: dict[str, dict[str, float]] = {}
        held = [c for c in connections if c.held]
        self.connections = connections = [c for c in connections if not c.held]
        continuous = {t: s for t, s in driving.signals.items() if s.linear}
        self._signals = {name: _owned(continuous, name) for name in slaves}
        jumps = {t: s for t, s in driving.signals.items() if not s.linear}
        places = {c.target: i for i, c in enumerate(connections)}
        self._changes = {places[t]: change for t, change in driving.changes.items() if t in places}
        changes = {t: change for t, change in driving.changes.items() if t not in places}
        self.held = Exchange(slaves, held, jumps, scheme.iterations, changes, self._behind)
        self._sources = {name: _ends([c.source for c in connections], name) for name in slaves}
        self._targets = {name: _ends([c.target for c in connections], name) for name in slaves}
        self._factors = np.array([c.factor for c in connections])
        self._offsets = np.array([c.offset for c in connections])
        self.values = np.zeros(len(connections))
        self.missed = np.zeros(len(connections))
        self._slopes = np.zeros(len(connections))
        self._outputs = {name: slave.fmu.outputs() for name, slave in slaves.items()}
        self.names = [f"{name}.{v}" for name, outputs in self._outputs.items() for v in outputs]
        self.nominals = np.concatenate([_nominals(slaves[name], outputs) for name, outputs in self._outputs.items()])
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

    def _read(self, name: str, values: np.ndarray) -> None:
        """Writes the outputs of a slave into `values`."""
        ends, slave = self._sources[name], self.slaves[name]
        if not ends:
            return
        found = slave.get(list(ends.values()))
        for (i, variable), value in zip(ends.items(), found.tolist(), strict=True):
            if not math.isfinite(value):
                cause = f"{name}.{variable} is {value} at t = {slave.time:.9g} s"
                raise FmuRunError(cause, "Check its inputs at that time", time=slave.time)
            values[i] = self._factors[i] * value + self._offsets[i]

    def _change(self, values: np.ndarray) -> None:
        """Writes the values of the scenario, which take precedence over connections."""
        for i, change in self._changes.items():
            if (value := change.at(self.time)) is not None:
                values[i] = float(value)

    def _read_all(self) -> np.ndarray:
        values = np.zeros(len(self.connections))
        for name in self.slaves:
            self._read(name, values)
        self._change(values)
        return values

    def _inputs(self, name: str, values: np.ndarray) -> dict[str, float]:
        return {variable: float(values[i]) for i, variable in self._targets[name].items()}

    def _now(self, name: str) -> dict[str, float]:
        """Values of the signals of a slave at its time."""
        time = min(self.time, self.slaves[name].time)
        return {variable: float(signal.after(time)) for variable, signal in self._signals[name].items()}

    def _behind(self, name: str) -> bool:
        """Whether a slow slave has not reached the present time."""
        return name in self._slow and self.slaves[name].time < self.time - 1e-9 * self._slow[name]

    def _residual(self, values: np.ndarray) -> np.ndarray:
        """Response of the slaves to values, minus these values."""
        for name, slave in self.slaves.items():
            if not self._behind(name):
                self._begun[name] = self._inputs(name, values)
                slave.set(self._begun[name] | self._now(name))
        return self._read_all() - values

    def exchange(self) -> None:
        """Passes on all values, with direct feedthrough. Raises FmuRunError."""
        for _ in range(self.scheme.iterations):
            values = self._read_all()
            self.values = values + self._residual(values)
            if not self.held.settle(self.time):
                return
        raise FmuRunError(
            f"Values of the connections keep changing at t = {self.time:.9g} s",
            "Discrete and real connections form a loop: open it",
            time=self.time,
        )

    def initialise(self) -> None:
        """Consistent values of the connections. Raises FmuRunError."""
        self.held.begin(self.time)
        self._solve()
        if self.held.settle(self.time):
            self._solve()

    def _solve(self) -> None:
        """Consistent values of the continuous connections by a damped Newton's method. Raises FmuRunError."""
        values = self._read_all()
        residual = self._residual(values)
        for _ in range(self.scheme.iterations):
            if self._agree(residual, values):
                self.values = values
                self._require_one_solution(values)
                return
            newton, share = np.linalg.lstsq(self._jacobian(values), -residual, rcond=None)[0], 1.0
            before = np.linalg.norm(residual / self.input_nominals)
            while share > 1e-6:
                try:
                    residual = self._residual(values + share * newton)
                except FmuRunError as error:  # a slave rejects the values: the step is too large
                    if error.fatal:
                        raise
                else:
                    if np.linalg.norm(residual / self.input_nominals) < (1.0 - 0.1 * share) * before:
                        break
                share /= 2.0
            else:
                break
            values = values + share * newton
        worst = self.connections[int(np.argmax(np.abs(residual) / self.input_nominals))]
        raise FmuRunError(
            f"The start values did not converge: {worst.source} and {worst.target} do not agree",
            "Give start values closer to a solution; the algebraic loop may have none",
        )

    def _require_one_solution(self, values: np.ndarray) -> None:
        """Raises FmuRunError if an algebraic loop is singular."""
        found = loops(self.slaves, self.connections)
        if found:
            scales = np.maximum(self.input_nominals, np.abs(values))
            matrix = self._jacobian(values) * (scales / scales[:, None])
            for loop in found:
                require_one_solution(loop, matrix, self.connections, self.time)

    def _agree(self, change: np.ndarray, values: np.ndarray) -> bool:
        return bool(np.all(np.abs(change) <= self.scheme.tolerance * (1.0 + np.abs(values))))

    def _jacobian(self, values: np.ndarray) -> np.ndarray:
        """Jacobian of `_residual`."""
        matrix = -np.eye(len(values))
        for name, slave in self.slaves.items():
            rows, columns = self._sources[name], self._targets[name]
            if rows and columns:
                direct = slave.derivatives(list(rows.values()), self._inputs(name, values))
                matrix[np.ix_(list(rows), list(columns))] += self._factors[list(rows), None] * direct
        for i, change in self._changes.items():
            if change.at(self.time) is not None:
                matrix[i] = 0.0
                matrix[i, i] = -1.0
        return matrix

    @property
    def ended(self) -> str | None:
        """Why an FMU ended the run; None if none has."""
        return next((slave.ended for slave in self.slaves.values() if slave.ended is not None), None)

    def step(self, size: float) -> None:
        """Advance all slaves by `size` seconds, or until an FMU ends the run.

        After a failure their times are undefined. Raises FmuRunError.
        """
        if self.scheme.iterated:
            self._iterate(size)
        else:
            self._once(size)

    def _advance(self, size: float, start: np.ndarray, end: np.ndarray, sent: np.ndarray) -> float:
        """Advance all slaves, with connections that go from `start` to `end`.

        Gauss-Seidel writes the newest values into `end`; the values that each slave used at its end go into `sent`.
        Returns the step reached: less than `size` if an FMU ends the run.
        """
        for name, slave in self.slaves.items():
            if name in self._slow:
                continue
            places = list(self._targets[name])
            sent[places] = end[places]
            if size > 0.0:
                given = {v: float(s.before(self.time + size)) for v, s in self._signals[name].items()}
                slave.step(size, self._inputs(name, start) | self._now(name), self._inputs(name, end) | given)
            if slave.ended is not None:
                size = min(size, slave.time - self.time)
            if self.scheme.master == "Gauss-Seidel":
                self._read(name, end)
                self._change(end)
        return self._advance_slow(size) if self._slow else size

    def _advance_slow(self, size: float) -> float:
        """Advance the slow slaves whose steps end now, with inputs that go linearly to the newest values."""
        time = self.time + size
        due = [
            name
            for name, period in self._slow.items()
            if time >= min(self.slaves[name].time + period, self._until) - 1e-9 * period
        ]
        newest = self._read_all() if due else self.values
        for name in due:
            slave = self.slaves[name]
            given = {v: float(s.before(time)) for v, s in self._signals[name].items()}
            begun = self._begun.get(name, self._inputs(name, self.values))
            slave.step(time - slave.time, begun | self._now(name), self._inputs(name, newest) | given)
            if slave.ended is not None:
                size = min(size, slave.time - self.time)
        return size

    def _arrive(self, size: float) -> None:
        self.time += size
        self.aligned = all(
            abs(slave.time - self.time) <= 1e-9 * (1.0 + abs(size)) or self._behind(name)
            for name, slave in self.slaves.items()
        )

    def _once(self, size: float) -> None:
        values, given = self.values.copy(), self.values.copy()
        self._arrive(self._advance(size, values, values, given))
        if self.aligned:
            self.exchange()
            self.missed = np.abs(self.values - given)

    def _iterate(self, size: float) -> None:
        extrapolated = self.values + size * self._slopes
        end, sent = extrapolated.copy(), extrapolated.copy()
        with self.saved() as back:
            for iteration in range(self.scheme.iterations):
                before = end.copy()
                if iteration:
                    back()
                reached = self._advance(size, self.values, end, sent)
                if 0.0 < reached < (1.0 - 1e-9) * size:  # an FMU ends the run: the step ends there for all
                    size, extrapolated = reached, self.values + reached * self._slopes
                    end = extrapolated.copy()
                    continue
                end = self._read_all()
                if reached == 0.0 or self._agree(end - before, end):
                    break
            else:
                worst = self.connections[int(np.argmax(np.abs(end - before) / (1.0 + np.abs(end))))]
                raise FmuRunError(
                    f"The values at the end of the step of {size:g} s do not agree after {self.scheme.iterations} "
                    f"iterations, worst is {worst.source}",
                    "Use a smaller step",
                    time=self.time,
                )
        self._slopes = (end - self.values) / size
        self.missed = np.abs(end - extrapolated)
        self.values = end
        self._arrive(reached)
        self._change(self.values)
        if self.aligned and self.held.settle(self.time):
            self.exchange()

    @contextmanager
    def saved(self) -> Iterator[Callable[[], None]]:
        """Save the present state; yields a function that restores it. Raises FmuRunError, InputError."""
        values, slopes, time, given = self.values, self._slopes, self.time, dict(self.held.given)
        states: dict[str, Any] = {}

        def back() -> None:
            for name, slave in self.slaves.items():
                slave.restore(states[name])
            self.values, self._slopes, self.time, self.aligned = values, slopes, time, True
            self.held.given = dict(given)

        try:
            for name, slave in self.slaves.items():
                states[name] = slave.save()
            yield back
        finally:
            for name, state in states.items():
                self.slaves[name].forget(state)


def _ends(ends: Sequence[str], slave: str) -> dict[int, str]:
    """Variables of a slave among the ends of connections, by index."""
    found = ((i, *end.partition(".")[::2]) for i, end in enumerate(ends))
    return {i: variable for i, owner, variable in found if owner == slave}


def _owned(signals: Mapping[str, Signal], slave: str) -> dict[str, Signal]:
    """Signals of a slave by variable."""
    ends = ((*target.partition(".")[::2], signal) for target, signal in signals.items())
    return {variable: signal for owner, variable, signal in ends if owner == slave}


def _nominals(slave: OpenFmu, names: Sequence[str]) -> np.ndarray:
    nominals = slave.fmu.variables.loc[list(names), "nominal"]
    return np.array([1.0 if n is None or not np.isfinite(n) or n == 0.0 else abs(n) for n in nominals])
