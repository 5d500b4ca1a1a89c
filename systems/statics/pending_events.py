"""State of a run besides the variables of its line: the next ticks of clocks, an emergency stop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ropeway.components.schedule import Schedule
from ropeway.systems.modelling.sampled_control import Clock

Ticks = Mapping[tuple[float, float], float]


@dataclass(frozen=True)
class Pending:
    """`ticks`: time of the next tick of each clock, by its period and phase [s]; `stopping`: signals of a stop in place
    of those of the inputs, None without one; `emergency`: the whole line stops, and no clock ticks. Times count from
    the start of the run."""

    ticks: Ticks = field(default_factory=dict)
    stopping: Mapping[str, Schedule] | None = None
    emergency: bool = False

    def next_tick(self, clock: Clock) -> float:
        """Time of the next tick of a clock [s]; by default its first."""
        return self.ticks.get((clock.period, clock.phase), clock.phase)

    def after(self, time: float) -> Pending:
        """The same, with times that count from `time` [s]."""
        ticks = {clock: max(tick - time, 0.0) for clock, tick in self.ticks.items()}
        if self.stopping is None:
            return replace(self, ticks=ticks)
        stopping = {name: _after(signal, time) for name, signal in self.stopping.items()}
        return replace(self, ticks=ticks, stopping=stopping)


def _after(signal: Schedule, time: float) -> Schedule:
    rest = [t - time for t in signal.times if t > time + 1e-9] or [1.0]
    return Schedule([0.0, *rest], [signal.at(time), *(signal.at(time + t) for t in rest)])
