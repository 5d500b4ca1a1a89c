"""Values exchanged only at communication points: Booleans, integers, enumerations, texts, discrete reals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from ropeway.fmu.cosimulation.algebraic_loops import loops
from ropeway.fmu.cosimulation.connections import Connection
from ropeway.fmu.cosimulation.discrete_loops import solution
from ropeway.fmu.cosimulation.input_signals import Signal
from ropeway.fmu.cosimulation.scenario import Change
from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.importing.participant import OpenFmu
from ropeway.fmu.importing.variable_types import Entry, Value


@dataclass
class Exchange:
    """Held connections and signals, and the values `given` last, by "slave.variable".

    `changes`: of a scenario, which take precedence; `behind`: whether a slave has not reached the present time, so that
    its inputs wait; `switched`: a discrete output changed within the last step.
    """

    slaves: Mapping[str, OpenFmu]
    connections: Sequence[Connection]
    signals: Mapping[str, Signal]
    iterations: int
    changes: Mapping[str, Change] = field(default_factory=dict)
    behind: Callable[[str], bool] = lambda name: False
    given: dict[str, Value] = field(default_factory=dict)
    switched: bool = False

    def __post_init__(self) -> None:
        kinds = {c.target: _entry(self.slaves, c.source).kind for c in self.connections}
        self._entries = {c.target: _entry(self.slaves, c.target) for c in self.connections}
        self._switches = {target for target, kind in kinds.items() if kind != "Real"}

    def begin(self, time: float) -> None:
        """Consistent values at the start: those of algebraic loops by trial of all their values. Raises FmuRunError."""
        changes = self._changes(time)
        self._pass_on(time, changes)
        for loop in loops(self.slaves, [c for c in self.connections if c.target not in changes]):
            self._set_changed(solution(loop, self._entries, self._answer, self.given, time))
            self._pass_on(time, changes)
        self.settle(time)

    def settle(self, time: float) -> bool:
        """Pass on changed values until direct feedthrough changes none any more.

        Returns whether any value changed. Raises FmuRunError.
        """
        changed, last = self._pass_on(time, self._changes(time))
        if last:
            raise FmuRunError(
                f"{', '.join(last)}: values keep changing at t = {time:.9g} s",
                "The connections form a loop: open it",
                time=time,
            )
        return changed

    def _changes(self, time: float) -> dict[str, Value]:
        return {t: v for t, change in self.changes.items() if (v := change.at(time)) is not None}

    def _pass_on(self, time: float, changes: Mapping[str, Value]) -> tuple[bool, list[str]]:
        """Whether any value changed, and those that changed last, if they keep changing."""
        given = {target: signal.after(time) for target, signal in self.signals.items()}
        changed = self._set_changed({**given, **changes})
        if not self.connections:
            return bool(changed), []
        for _ in range(self.iterations):
            now = self._set_changed({**self._read(), **changes})
            if not now:
                return bool(changed), []
            changed = now
            self.switched |= bool(self._switches.intersection(now))
        return True, changed

    def _answer(self, trial: Mapping[str, Value]) -> dict[str, Value]:
        """What the connections of trial values would set instead."""
        self._set_changed(trial)
        found = self._read()
        return {target: found[target] for target in trial}

    def _read(self) -> dict[str, Value]:
        found: dict[str, Value] = {}
        for name, slave in self.slaves.items():
            own = [c for c in self.connections if c.source.startswith(f"{name}.")]
            values = slave.read([c.source.partition(".")[2] for c in own])
            for c, value in zip(own, values, strict=True):
                if c.mapping:
                    found[c.target] = self._mapped(c, value, slave.time)
                    continue
                if isinstance(value, bool) and self._entries[c.target].kind != "Boolean":
                    value = int(value)
                plain = isinstance(value, str | bytes) or (c.factor, c.offset) == (1.0, 0.0)
                found[c.target] = value if plain else c.factor * float(value) + c.offset
        return found

    def _mapped(self, connection: Connection, value: Value, time: float) -> Value:
        if not isinstance(value, bool | int) or value not in connection.mapping:
            known = ", ".join(map(str, connection.mapping))
            raise FmuRunError(
                f"{connection.source} is {value!r} at t = {time:.9g} s, which its mapping to {connection.target} lacks",
                f"It has values for {known}",
                time=time,
            )
        return connection.mapping[value]

    def _set_changed(self, values: Mapping[str, Value]) -> list[str]:
        """Sets the values that changed; returns their targets."""
        waiting = {name for name in self.slaves if self.behind(name)}
        changed = [
            target
            for target, value in values.items()
            if self.given.get(target) != value and target.partition(".")[0] not in waiting
        ]
        for name, slave in self.slaves.items():
            own = {t.partition(".")[2]: values[t] for t in changed if t.startswith(f"{name}.")}
            if own:
                slave.set(own)
        self.given.update((target, values[target]) for target in changed)
        return changed


def _entry(slaves: Mapping[str, OpenFmu], end: str) -> Entry:
    slave, _, variable = end.partition(".")
    return slaves[slave].fmu.entries[variable]
