"""What slaves are given at communication points only: Booleans, integers, enumerations, texts, discrete reals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ropeway.fmu.cosimulation.input_signals import Signal
from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.importing.participant import OpenFmu
from ropeway.fmu.importing.variable_types import Entry, Value


@dataclass(frozen=True)
class Connection:
    """An output that drives an input: names as "slave.variable"; a real input is factor times the output plus offset.
    held: the input changes at communication points only."""

    source: str
    target: str
    factor: float = 1.0
    offset: float = 0.0
    held: bool = False


@dataclass
class Exchange:
    """Held connections and signals, and what has been `given` so far, by "slave.variable". `switched`: an output other
    than a real one has changed since this was set to False; it did so at some time within the last step."""

    slaves: Mapping[str, OpenFmu]
    connections: Sequence[Connection]
    signals: Mapping[str, Signal]
    iterations: int
    given: dict[str, Value] = field(default_factory=dict)
    switched: bool = False

    def __post_init__(self) -> None:
        kinds = {c.target: _entry(self.slaves, c.source).kind for c in self.connections}
        self._switches = {target for target, kind in kinds.items() if kind != "Real"}

    def settle(self, time: float) -> bool:
        """Gives each slave what has changed, until outputs that follow inputs at once stay as they are. Returns whether
        anything has changed. Raises FmuRunError."""
        changed = self._give({target: signal.after(time) for target, signal in self.signals.items()})
        if not self.connections:
            return bool(changed)
        for _ in range(self.iterations):
            now = self._give(self._read())
            if not now:
                return bool(changed)
            changed = now
            self.switched |= bool(self._switches.intersection(now))
        raise FmuRunError(
            f"{', '.join(changed)}: values keep changing at t = {time:.9g} s",
            "The connections are a loop: cut it",
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

    def _give(self, values: Mapping[str, Value]) -> list[str]:
        """Sets what differs from what was given; the targets of that."""
        changed = [target for target, value in values.items() if self.given.get(target) != value]
        for name, slave in self.slaves.items():
            own = {t.partition(".")[2]: values[t] for t in changed if t.startswith(f"{name}.")}
            if own:
                slave.set(own)
        self.given.update((target, values[target]) for target in changed)
        return changed


def _entry(slaves: Mapping[str, OpenFmu], end: str) -> Entry:
    slave, _, variable = end.partition(".")
    return slaves[slave].fmu.entries[variable]
