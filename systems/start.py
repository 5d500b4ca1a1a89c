"""Starting values from geometry: each group of spans that shares a rope as a parabola with its loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ropeway.components import parabola
from ropeway.systems.run import Run, loads_passed


@dataclass(frozen=True)
class RunStart:
    """Starting values of a run: `force` (spans, 3) tension vectors at ends a [N]; `travel` (supports,) [m];
    `passed` (supports,) and `counts` (spans,) of loads; `chord` (spans,) [m]; `scale`: typical tension [N]."""

    force: np.ndarray
    travel: np.ndarray
    passed: np.ndarray
    chord: np.ndarray
    scale: float

    @property
    def counts(self) -> np.ndarray:
        """Loads in each span."""
        return np.asarray(self.passed[:-1] - self.passed[1:])


def run_start(run: Run, gravity: float, lengths: np.ndarray | None = None) -> RunStart:
    """Starting values of a run; `lengths` (spans,) at zero travel, by default those of its spans [m]."""
    weight, strain = run.rope.mass_per_length * gravity, run.rope.strain
    at_zero = np.array([s.length for s in run.spans]) if lengths is None else lengths
    start = np.concatenate([[0.0], np.cumsum(at_zero)])
    chords = parabola.Chords.between(run.points)
    free = np.array([n.drive_speed is None and s.travel is not None for n, s in zip(run.nodes, run.seats, strict=True)])
    # Consecutive spans that can pass rope to each other form a group.
    group = np.concatenate([[0], np.cumsum(~free[1:-1])]).astype(int)
    count = int(group[-1]) + 1
    total = np.bincount(group, at_zero, minlength=count)
    kept = np.full(count, np.nan)
    for node, k in ((run.nodes[0], 0), (run.nodes[-1], -1)):
        if node.kept_tension is not None:
            kept[group[k]] = node.kept_tension - (weight * (run.points[k, 2] - run.points[0, 2]))
    travel = np.zeros(len(run.nodes))
    length = at_zero
    tension = np.zeros(len(run.spans))
    beam = None
    beyond = loads_passed(run, start)
    for _ in range(3):
        beyond = loads_passed(run, start - travel)
        distance, load = _in_spans(run, beyond, start - travel, gravity)
        beam = parabola.beam(chords, weight, length, distance, load)
        reference = parabola.common_tension(chords, weight, beam, strain, total, group)
        reference = np.where(np.isnan(kept), reference, kept)
        tension = parabola.tensions(chords, weight, beam, reference[group])
        length = parabola.rope_lengths(chords, beam, strain, tension)
        fixed_total = np.isnan(kept)
        length = length * np.where(fixed_total, total / np.bincount(group, length, minlength=count), 1.0)[group]
        travel = _travels(length - at_zero, free)
        if not np.any(free):
            break
    cosine, sine = chords.horizontal / chords.length, chords.rise / chords.length
    direction = np.diff(run.points, axis=0) / chords.length[:, None]
    force = tension[:, None] * direction
    force[:, 2] = tension * sine - (0.0 if beam is None else beam.reaction)
    force[:, :2] += np.where(cosine < 1e-9, 1e-9 * tension, 0.0)[:, None]
    return RunStart(force, travel, beyond, chords.length, float(np.median(tension)))


def _in_spans(run: Run, beyond: np.ndarray, rope: np.ndarray, gravity: float) -> tuple[np.ndarray, np.ndarray]:
    """Distances [m] and weights [N] of the loads in each span, shape (spans, most in one span)."""
    n = len(run.spans)
    most = max(1, int((beyond[:-1] - beyond[1:]).max())) if n else 1
    index = beyond[:-1, None] - 1 - np.arange(most)[None, :]
    full = index >= beyond[1:, None]
    if len(run.loads.place) == 0:
        return np.zeros((n, 1)), np.zeros((n, 1))
    index = np.where(full, index, 0)
    distance = np.where(full, run.loads.place[index] - rope[:-1, None], 0.0)
    return distance, np.where(full, run.loads.mass[index] * gravity, 0.0)


def _travels(gain: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Travels that give each span its gain in length, counted from a support that holds the rope."""
    travel = np.zeros(len(gain) + 1)
    held = np.flatnonzero(~free)
    origin = int(held[0]) if len(held) else 0
    for k in range(origin, len(gain)):
        travel[k + 1] = 0.0 if not free[k + 1] else travel[k] - gain[k]
    for k in range(origin - 1, -1, -1):
        travel[k] = 0.0 if not free[k] else travel[k + 1] + gain[k]
    return travel
