"""Sample times of a schedule's problem: grid times, and both sides of each crossing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ropeway.components.errors import InputError
from ropeway.systems.dynamics.result import Result


@dataclass(frozen=True)
class SupportCrossing:
    """A load that crosses a support of the line's one rope, at a travel [m] of the support."""

    support: int
    load: int
    forward: bool
    travel: float


@dataclass(frozen=True)
class SampleTime:
    """A time [s], with the places of a run's records `before` and `after` it, the same unless there are
    `crossings`: then the time is a variable. `grid`: the number of its grid time, or -1."""

    time: float
    before: int
    after: int
    grid: int
    crossings: tuple[SupportCrossing, ...] = ()

    def touches(self, section: tuple[int, int]) -> bool:
        """Whether a load comes into a section, leaves it, or changes its span there."""
        return any(section[0] <= c.support <= section[1] for c in self.crossings)

    @property
    def keys(self) -> frozenset[tuple[int, int, bool]]:
        """Support, load and direction of each crossing, which identify it."""
        return frozenset((c.support, c.load, c.forward) for c in self.crossings)


def sample_times(
    result: Result, grid: np.ndarray, more: Sequence[float], sections: Sequence[tuple[int, int]]
) -> list[SampleTime]:
    """The moments of a run that has a record at each of the `grid` and `more` times [s], in order of time.

    Raises InputError when a load is held on a support.
    """
    times = result.times
    found = [SampleTime(float(t), i, i, g) for g, t in enumerate(grid) for i in [_last(times, t)]]
    near = 1e-6
    found += [SampleTime(float(t), _last(times, t), _last(times, t), -1) for t in more if np.abs(grid - t).min() > near]
    layout, start = result.model.layouts[0], result.model.layouts[0].start(result.parameters)
    place, foremost = result.runs[0].loads.place, result.runs[0].loads.first
    for i in range(len(times) - 1):
        a, b = result.records[i], result.records[i + 1]
        change = b.passed[0] - a.passed[0]
        if not change.any():
            continue
        travel = layout.travel.read(a.x, a.z)
        crossed = []
        for k in np.flatnonzero(change):
            forward = bool(change[k] > 0)
            load = int(a.passed[0][k]) - foremost - (0 if forward else 1)
            crossed.append((abs(start[k] - place[load] - travel[k]), int(k), load, forward))
        crossed.sort(key=lambda c: (c[0] > near, c[1]))
        # Crossings at one time that share no section are independent.
        groups: list[list[SupportCrossing]] = []
        for _, support, load, forward in crossed:
            crossing = SupportCrossing(support, load, forward, float(start[support] - place[load]))
            beside = [g for g in groups if any(_share(c.support, support, sections) for c in g)]
            if not beside:
                beside = [[]]
                groups += beside
            beside[0].append(crossing)
        found += [SampleTime(float(a.time), i, i + 1, -1, tuple(g)) for g in groups]
    if any(e.event == "load held" for e in result.noted):
        raise InputError("A load is held on a support", "A schedule needs a line that all loads pass; move supports")
    return sorted(found, key=lambda m: (m.time, m.before))


def _last(times: np.ndarray, t: float) -> int:
    """The record at a time, after an event at that time."""
    at = np.flatnonzero(np.abs(times - t) < 1e-6)
    if not len(at):
        raise InputError(f"The run has no record at {t:g} s", "Simulate with a finer interval")
    return int(at[-1])


def _share(one: int, other: int, sections: Sequence[tuple[int, int]]) -> bool:
    return any(a <= one <= b and a <= other <= b for a, b in sections)


def shares(times: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Weights [s] of a mean over the times that count, by the trapezoidal rule; zero for the others."""
    weights = np.zeros(len(times))
    own = times[counts]
    around = np.concatenate([own[:1], own, own[-1:]])
    weights[counts] = (around[2:] - around[:-2]) / 2.0
    return weights
