"""Initial guess from geometry: parabolas with loads for each group of spans that share a length of rope."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ropeway.components import parabola
from ropeway.systems.modelling.rope_path import Run, loads_passed


@dataclass(frozen=True)
class RunStart:
    """Initial guess of a run.

    `force` (spans, 3): tension vectors at ends a [N]; `travel` (supports,) [m]; `passed` (supports,) and `counts`
    (spans,) of loads; `chord` (spans,) [m]; `scale`: typical tension [N].
    """

    force: np.ndarray
    travel: np.ndarray
    passed: np.ndarray
    chord: np.ndarray
    scale: float

    @property
    def counts(self) -> np.ndarray:
        """Loads in each span."""
        return np.asarray(self.passed[:-1] - self.passed[1:])


def run_start(
    run: Run,
    gravity: float,
    lengths: np.ndarray | None = None,
    travel: np.ndarray | None = None,
    points: np.ndarray | None = None,
) -> RunStart:
    """Initial guess of a run.

    `lengths` (spans,) are unstretched lengths at zero travel [m], by default those of the spans. `travel` (supports,)
    [m] is zero by default and counts at supports that hold the rope. `points` (supports, 3) are positions [m], by
    default the declared ones.
    """
    points = run.points if points is None else points
    weight, strain = run.rope.mass_per_length * gravity, run.rope.strain
    length = np.array([s.length for s in run.spans]) if lengths is None else lengths
    start = np.concatenate([[0.0], np.cumsum(length)])
    rope = start - (np.zeros(len(start)) if travel is None else travel)
    chords = parabola.Chords.between(points)
    free = np.array([n.drive_speed is None and s.travel is not None for n, s in zip(run.nodes, run.seats, strict=True)])
    held = np.flatnonzero(~free)
    # Consecutive spans that can exchange rope form a group.
    group = np.concatenate([[0], np.cumsum(~free[1:-1])]).astype(int)
    count = int(group[-1]) + 1
    first = np.searchsorted(group, np.arange(count))
    last = np.append(first[1:], len(run.spans))
    total = rope[last] - rope[first]
    kept = np.full(count, np.nan)
    for node, k in ((run.nodes[0], 0), (run.nodes[-1], -1)):
        if node.set_tension is not None:
            kept[group[k]] = node.set_tension - weight * (points[k, 2] - points[0, 2])
    closed = np.isnan(kept)
    for _ in range(3 if np.any(free) else 1):
        passed = loads_passed(run, rope)
        distance, load = _in_spans(run, passed, rope, gravity)
        beam = parabola.beam(chords, weight, np.maximum(np.diff(rope), 1e-3 * chords.length), distance, load)
        reference = parabola.common_tension(chords, weight, beam, strain, total, group)
        tension = parabola.tensions(chords, weight, beam, np.where(closed, reference, kept)[group])
        length = parabola.rope_lengths(chords, beam, strain, tension)
        length = length * np.where(closed, total / np.bincount(group, length, minlength=count), 1.0)[group]
        rope = _rope_at_supports(length, rope, held)
    cosine, sine = chords.horizontal / chords.length, chords.rise / chords.length
    direction = np.diff(points, axis=0) / chords.length[:, None]
    force = tension[:, None] * direction
    force[:, 2] = tension * sine - beam.reaction
    force[:, :2] += np.where(cosine < 1e-9, 1e-9 * tension, 0.0)[:, None]
    return RunStart(force, start - rope, passed, chords.length, float(np.median(tension)))


def _in_spans(run: Run, passed: np.ndarray, rope: np.ndarray, gravity: float) -> tuple[np.ndarray, np.ndarray]:
    """Distances [m] and weights [N] of the loads in each span, shape (spans, largest number in a span)."""
    n = len(run.spans)
    most = max(1, int((passed[:-1] - passed[1:]).max())) if n else 1
    index = passed[:-1, None] - 1 - np.arange(most)[None, :]
    full = index >= passed[1:, None]
    if len(run.loads.place) == 0:
        return np.zeros((n, 1)), np.zeros((n, 1))
    index = np.where(full, index, 0)
    distance = np.where(full, run.loads.place[index] - rope[:-1, None], 0.0)
    return distance, np.where(full, run.loads.mass[index] * gravity, 0.0)


def _rope_at_supports(length: np.ndarray, rope: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Rope coordinate at each support for spans of `length`, counted from the supports that hold the rope."""
    result = rope.copy()
    origin = int(held[0]) if len(held) else 0
    fixed = set(held.tolist())
    for k in range(origin, len(length)):
        result[k + 1] = rope[k + 1] if k + 1 in fixed else result[k] + length[k]
    for k in range(origin - 1, -1, -1):
        result[k] = result[k + 1] - length[k]
    return result
