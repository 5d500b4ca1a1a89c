"""Records of a run in their order, most of them as rows of arrays."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple, overload

import numpy as np

from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.solvers.compiled_rows import write_slots
from ropeway.systems.solvers.state_rows import StateRows
from ropeway.systems.statics.line_records import AnyRecord, Record
from ropeway.systems.statics.pending_events import Pending


class RecordRows(NamedTuple):
    """Many records, a row each: the fields of `Record` but what is pending; `passed` of all runs one after the other,
    (records, supports)."""

    time: np.ndarray
    x: np.ndarray
    z: np.ndarray
    u: np.ndarray
    passed: np.ndarray
    kept: np.ndarray


@dataclass(frozen=True, eq=False)
class RecordBlock(Sequence[Record]):
    """Records that the compiled core has written down together. `ends`: where each run but the last ends in `passed`;
    `epoch`: of each record the number of what was `kept` and `pending` then."""

    time: np.ndarray
    x: np.ndarray
    z: np.ndarray
    u: np.ndarray
    passed: np.ndarray
    ends: np.ndarray
    epoch: np.ndarray
    kept: np.ndarray
    pending: Sequence[Pending]

    def __len__(self) -> int:
        return len(self.time)

    @overload
    def __getitem__(self, i: int) -> Record: ...
    @overload
    def __getitem__(self, i: slice) -> Sequence[Record]: ...
    def __getitem__(self, i: int | slice) -> Record | Sequence[Record]:
        if isinstance(i, slice):
            return [self[k] for k in range(*i.indices(len(self)))]
        epoch = int(self.epoch[i])
        passed = tuple(np.split(self.passed[i], self.ends))
        return Record(
            float(self.time[i]), self.x[i], self.z[i], self.u[i], passed, self.kept[epoch], self.pending[epoch]
        )

    def rows(self, which: np.ndarray) -> RecordRows:
        """Records of numbers `which`."""
        time, x, z, u, passed = (values[which] for values in (self.time, self.x, self.z, self.u, self.passed))
        return RecordRows(time, x, z, u, passed, self.kept[self.epoch[which]])


class Records(Sequence[AnyRecord]):
    """Records in order of time, from parts each of which is a block or a list."""

    def __init__(self, parts: Iterable[Sequence[AnyRecord]]) -> None:
        self._parts = list[Sequence[AnyRecord]]()
        alone = list[AnyRecord]()
        for part in parts:
            if not isinstance(part, RecordBlock):
                alone += part
                continue
            if alone:
                self._parts.append(alone)
                alone = []
            self._parts.append(part)
        if alone:
            self._parts.append(alone)
        self._first = np.cumsum([0, *map(len, self._parts)])

    def __len__(self) -> int:
        return int(self._first[-1])

    @overload
    def __getitem__(self, i: int) -> AnyRecord: ...
    @overload
    def __getitem__(self, i: slice) -> Records: ...
    def __getitem__(self, i: int | slice) -> AnyRecord | Records:
        if isinstance(i, slice):
            return Records([[self[k] for k in range(*i.indices(len(self)))]])
        k = range(len(self))[i]
        part = int(np.searchsorted(self._first, k, side="right")) - 1
        return self._parts[part][k - int(self._first[part])]

    def __iter__(self) -> Iterator[AnyRecord]:
        return chain.from_iterable(self._parts)

    @property
    def times(self) -> np.ndarray:
        """Times of all records [s]."""
        empty = np.zeros(0)
        return np.concatenate(
            [empty, *(p.time if isinstance(p, RecordBlock) else [r.time for r in p] for p in self._parts)]
        )

    def rows(self, which: np.ndarray) -> RecordRows:
        """Records of numbers `which`, which ascend."""
        cuts = np.searchsorted(which, self._first)
        found = [
            part.rows(own - first) if isinstance(part, RecordBlock) else _rows([part[i - first] for i in own.tolist()])
            for part, first, own in zip(self._parts, self._first.tolist(), np.split(which, cuts[1:-1]), strict=False)
            if len(own)
        ]
        return found[0] if len(found) == 1 else RecordRows(*map(np.concatenate, zip(*found, strict=True)))


def _rows(records: Sequence[AnyRecord]) -> RecordRows:
    """Records that stand alone, as rows."""
    passed = [np.concatenate(record.passed) if record.passed else np.zeros(0, dtype=int) for record in records]
    own = (np.array([getattr(record, name) for record in records]) for name in ("x", "z", "u", "kept"))
    x, z, u, kept = own
    return RecordRows(np.array([record.time for record in records]), x, z, u, np.array(passed), kept)


def restored_rows(
    model: Model, runs: Sequence[Run], p: np.ndarray, records: RecordRows, *, compiled: bool = False
) -> StateRows:
    """The states of many records, as `restored` makes them one by one; none may have more loads in a span than the
    model has slots. compiled: in compiled code."""
    ends = np.cumsum([len(model.x), len(model.z), len(model.u), len(model.p), len(model.d)])
    values = np.empty((len(records.time), int(ends[-1]) + 1))
    x, z, u, parameters, d, _ = np.split(values, ends, axis=1)
    x[:], z[:], u[:] = records.x, records.z, records.u
    parameters[:], values[:, -1], d[:] = p, 0.0, model.d.values
    d[:, model.kept] = records.kept
    nodes = np.cumsum([len(run.nodes) for run in runs])[:-1]
    passed = [
        beyond - run.loads.first for beyond, run in zip(np.split(records.passed, nodes, axis=1), runs, strict=False)
    ]
    if compiled:
        write_slots(model, runs, p, d, passed)
    else:
        for run, layout, beyond in zip(runs, model.layouts, passed, strict=True):
            layout.slots.write(d, run, beyond, layout.start(p))
    return StateRows(model, values, records.time, passed)
