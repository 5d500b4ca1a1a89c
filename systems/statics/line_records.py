"""States of a line written down, and restored from that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.pending_events import Pending


class Record(NamedTuple):
    """A state written down: time [s], states, algebraic variables, inputs, for each run the number of the first load
    that has not passed each support, the discrete variables that are `kept` besides, and what is `pending` in the
    run."""

    time: float
    x: np.ndarray
    z: np.ndarray
    u: np.ndarray
    passed: tuple[np.ndarray, ...]
    kept: np.ndarray
    pending: Pending


@dataclass(frozen=True, eq=False)
class PartRecord:
    """A record that holds only what has changed since the one `before`: some algebraic variables, `columns` with their
    `values`, and loads that have passed, each as run, support and number. The sections of a line that are not solved
    here have the algebraic variables of the record before, from which they are solved when they are read."""

    time: float
    x: np.ndarray
    u: np.ndarray
    kept: np.ndarray
    pending: Pending
    before: Record | PartRecord
    columns: np.ndarray
    values: np.ndarray
    moved: tuple[tuple[int, int, int], ...]

    @property
    def z(self) -> np.ndarray:
        """Algebraic variables."""
        whole, parts = self._chain()
        z = whole.z.copy()
        for part in parts:
            z[part.columns] = part.values
        return z

    @property
    def passed(self) -> tuple[np.ndarray, ...]:
        """As of a `Record`."""
        whole, parts = self._chain()
        passed = tuple(beyond.copy() for beyond in whole.passed)
        for part in parts:
            for r, k, number in part.moved:
                passed[r][k] = number
        return passed

    def _chain(self) -> tuple[Record, list[PartRecord]]:
        """The last whole record, and the parts that follow it."""
        parts, record = list[PartRecord](), self.before
        while isinstance(record, PartRecord):
            parts.append(record)
            record = record.before
        return record, [*parts[::-1], self]


AnyRecord = Record | PartRecord


def part_of(model: Model, record: Record, before: Record, earlier: AnyRecord, after: AnyRecord) -> PartRecord:
    """What a record in which not all sections are solved has changed. `before`: the record before it as it was,
    `earlier`: as it is kept; `after`: the one that follows, which shows what jumps there."""
    moved = [
        (r, int(k), int(own[k]))
        for r, (own, last) in enumerate(zip(record.passed, before.passed, strict=True))
        for k in np.flatnonzero(own != last)
    ]
    jumps = [
        (r, int(k))
        for r, (own, coming) in enumerate(zip(record.passed, after.passed, strict=True))
        for k in np.flatnonzero(own != coming)
    ]
    beside, others = _columns(model)
    places = dict.fromkeys([*((r, k) for r, k, _ in moved), *jumps])
    if len(places) == 1 and not len(others):
        columns = beside[next(iter(places))]  # shared by all records of a support
    else:
        columns = np.unique(np.concatenate([others, *(beside[place] for place in places)]))
    return PartRecord(
        record.time,
        _same(record.x, earlier.x),
        _same(record.u, earlier.u),
        _same(record.kept, earlier.kept),
        record.pending,
        earlier,
        columns,
        record.z[columns],
        tuple(moved),
    )


def _same(own: np.ndarray, other: np.ndarray) -> np.ndarray:
    """One array for both where they are equal."""
    return other if np.array_equal(own, other) else own


@kept_with_model
def _columns(model: Model) -> tuple[dict[tuple[int, int], np.ndarray], np.ndarray]:
    """For each support (run, number) the algebraic variables of the sections beside it; and those of no section."""
    found: dict[tuple[int, int], np.ndarray] = {}
    for r, (run, layout) in enumerate(zip(model.runs, model.layouts, strict=True)):
        travel = layout.travel.algebraic
        ends = [k for k in range(len(run.nodes)) if travel[k] < 0 or k in (0, len(run.spans))]
        sections = [
            np.concatenate([layout.force[a:b, None] + np.arange(3), travel[a : b + 1, None].repeat(3, axis=1)]).ravel()
            for a, b in pairwise(ends)
        ]
        for k in range(len(run.nodes)):
            own = [s for s, (a, b) in enumerate(pairwise(ends)) if a <= k <= b]
            if run.closed and k in (0, len(run.spans)):
                own = sorted({0, len(sections) - 1})
            columns = np.unique(np.concatenate([sections[s] for s in own]))
            found[r, k] = columns[columns >= 0]
    known = np.concatenate([np.zeros(0, dtype=int), *found.values()])
    return found, np.setdiff1d(np.arange(len(model.z)), known)


def recorded(state: LineState, pending: Pending) -> Record:
    """A state as a record."""
    q = state.point
    passed = tuple(p + run.loads.first for p, run in zip(state.passed, state.runs, strict=True))
    return Record(q.t, q.x.copy(), q.z.copy(), q.u.copy(), passed, q.d[state.model.kept], pending)


def restored(model: Model, runs: Sequence[Run], p: np.ndarray, record: AnyRecord) -> LineState:
    """The state of a record, with `p` the parameters of the run."""
    d = model.d.values.copy()
    d[model.kept] = record.kept
    passed = [beyond - run.loads.first for beyond, run in zip(record.passed, runs, strict=True)]
    state = LineState(model, Point(record.x.copy(), record.z.copy(), record.u.copy(), p, d, record.time), runs, passed)
    state.write_slots()
    return state
