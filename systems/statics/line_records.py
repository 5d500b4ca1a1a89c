"""States of a line written down, and restored from that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.pending_events import Pending


@dataclass(frozen=True)
class Record:
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


def recorded(state: LineState, pending: Pending) -> Record:
    """A state as a record."""
    q = state.point
    passed = tuple(p + run.loads.first for p, run in zip(state.passed, state.runs, strict=True))
    return Record(q.t, q.x.copy(), q.z.copy(), q.u.copy(), passed, q.d[state.model.kept], pending)


def restored(model: Model, runs: Sequence[Run], p: np.ndarray, record: Record) -> LineState:
    """The state of a record, with `p` the parameters of the run."""
    d = model.d.values.copy()
    d[model.kept] = record.kept
    passed = [p - run.loads.first for p, run in zip(record.passed, runs, strict=True)]
    state = LineState(model, Point(record.x.copy(), record.z.copy(), record.u.copy(), p, d, record.time), runs, passed)
    state.write_slots()
    return state


def restored_points(
    model: Model, runs: Sequence[Run], p: np.ndarray, records: Sequence[Record]
) -> tuple[list[Point], list[list[np.ndarray]]]:
    """The points of many records, and the loads passed in each run, as `restored` makes them one by one;
    none may have more loads in a span than the model has slots."""
    d = np.repeat(model.d.values[None], len(records), axis=0)
    d[:, model.kept] = [record.kept for record in records]
    passed = [np.array([record.passed[r] for record in records]) - run.loads.first for r, run in enumerate(runs)]
    for run, layout, beyond in zip(runs, model.layouts, passed, strict=True):
        layout.slots.write(d, run, beyond, layout.start(p))
    points = [Point(q.x.copy(), q.z.copy(), q.u.copy(), p, own, q.time) for q, own in zip(records, d, strict=True)]
    return points, [[beyond[i] for beyond in passed] for i in range(len(records))]
