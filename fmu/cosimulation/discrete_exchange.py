"""Values exchanged only at communication points: Booleans, integers, enumerations, texts, discrete reals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from ropeway.fmu.cosimulation.input_signals import Signal
from ropeway.fmu.cosimulation.scenario import Change
from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.importing.participant import OpenFmu
from ropeway.fmu.importing.variable_types import Entry, Value


@dataclass(frozen=True)
class Connection:
    """An output that drives an input, "slave.variable" each.

    A real input is factor times the output plus offset. `held`: the input changes at communication points only.
    """

    source: str
    target: str
    factor: float = 1.0
    offset: float = 0.0
    held: bool = False


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
        self._switches = {target for target, kind in kinds.items() if kind != "Real"}

    def settle(self, time: float) -> bool:
        """Pass on changed values until direct feedthrough changes none any more.

        Returns whether any value changed. Raises FmuRunError.
        """
        changes = {t: v for t, change in self.changes.items() if (v := change.at(time)) is not None}
        changed = self._set_changed({target: signal.after(time) for target, signal in self.signals.items()} | changes)
        if not self.connections:
            return bool(changed)
        for _ in range(self.iterations):
            now = self._set_changed(self._read() | changes)
            if not now:
                return bool(changed)
            changed = now
            self.switched |= bool(self._switches.intersection(now))
        raise FmuRunError(
            f"{', '.join(changed)}: values keep changing at t = {time:.9g} s",
            "The connections form a loop: open it",
            time=time,
        )

    def _read(self) -> dict[str, Value]:
        found: dict[str, Value] = {}
        for name, slave in self.slaves.items():
            own = [c for c in self.connections if c.source.startswith(f"{name}.")]
            values = slave.read([c.source.partition(".")[2] for c in own])
            for c, value in zip(own, values, strict=True):
                if isinstance(value, bool) and _entry(self.slaves, c.target).kind != "Boolean":
                    value = int(value)
                plain = isinstance(value, str | bytes) or (c.factor, c.offset) == (1.0, 0.0)
                found[c.target] = value if plain else c.factor * float(value) + c.offset
        return found

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
