"""What a run writes down: states and events, with checkpoints that it can return to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ropeway.systems.dynamics.load_crossings import Crossing
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.results.run_data import Event
from ropeway.systems.statics.line_records import AnyRecord, Record, part_of, recorded
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.pending_events import Pending
from ropeway.systems.statics.record_blocks import Records

_LARGE = 1000
"""Algebraic variables of a model from which records hold only what has changed."""
_PARTS = 256
"""Most records after a whole one that hold only what has changed."""


class Entry(NamedTuple):
    """States of a run: whether each is at a time of the result's grid, and whether all its sections are solved."""

    records: Sequence[AnyRecord]
    on_grid: Sequence[bool]
    exact: Sequence[bool]


class Checkpoint(NamedTuple):
    """How many entries and events there were at a time, and how many of the times that were due had theirs."""

    entries: int
    events: int
    met: int = 0


class Recorder:
    """The entries and events of a run so far; `pending` is what each record says of clocks and an emergency stop. With
    the `model` of a long line, records hold only what has changed."""

    def __init__(self, pending: Pending | None = None, model: Model | None = None) -> None:
        self.entries: list[Entry] = []
        self.events: list[Event] = []
        self._between: dict[int, Record] = {}
        self.pending = Pending() if pending is None else pending
        self._model = model
        self._last: Record | None = None
        self._packed, self._parts = 0, 0
        self._due: Sequence[float] = ()
        self._met = 0

    @property
    def packs(self) -> bool:
        """Whether records hold only what has changed."""
        return self._model is not None and len(self._model.z) >= _LARGE

    @property
    def last(self) -> AnyRecord | None:
        """The last record so far, which others may follow that hold only what has changed; None where they may not."""
        return self.entries[-1].records[-1] if self.packs and self.entries else None

    @property
    def chain(self) -> int:
        """Most records after a whole one that may hold only what has changed."""
        return 0 if self.last is None else _PARTS

    def checkpoint(self) -> Checkpoint:
        """A mark that `rewind` returns to."""
        self._pack()
        return Checkpoint(len(self.entries), len(self.events), self._met)

    def rewind(self, checkpoint: Checkpoint) -> None:
        """Deletes all that was written down after a checkpoint."""
        del self.entries[checkpoint.entries :]
        del self.events[checkpoint.events :]
        self._met = checkpoint.met
        if self._packed > checkpoint.entries:
            self._packed, self._last = checkpoint.entries, None

    def _pack(self) -> None:
        """Reduces those of the entries so far, but the last, in which not all sections are solved."""
        if self._model is None or not self.packs:
            return
        for i in range(self._packed, len(self.entries) - 1):
            (record,), last = self.entries[i].records, self._last
            if not isinstance(record, Record):
                self._last = None
                continue
            self._last, self._parts = record, self._parts + 1
            if all(self.entries[i].exact) or last is None or self._parts > _PARTS:
                self._parts = 0
                continue
            beside = self.entries[i - 1].records[0], self.entries[i + 1].records[0]
            part = part_of(self._model, record, last, *beside)
            self.entries[i] = self.entries[i]._replace(records=(part,))
        self._packed = max(self._packed, len(self.entries) - 1)

    def record(self, state: LineState, *, on_grid: bool = False, exact: bool = True) -> None:
        """Writes a state down."""
        self.entries.append(Entry((recorded(state, self.pending),), (on_grid,), (exact,)))

    def rewrite(self, change: Callable[[AnyRecord], Record]) -> None:
        """Changes all states so far, which are solved again when they are read."""
        self._between = {number: change(record) for number, record in self._between.items()}
        for i, entry in enumerate(self.entries):
            records = tuple(change(record) for record in entry.records)
            self.entries[i] = Entry(records, entry.on_grid, (False,) * len(records))
        self._packed, self._last = len(self.entries), None

    def keep(self, number: int, record: Record) -> None:
        """Takes a state between the entries, which is solved when it is read, instead of the one that was taken before
        for the same number."""
        self._between[number] = record

    def take(self, records: Sequence[AnyRecord], on_grid: Sequence[bool]) -> None:
        """Writes down what the compiled core has: all sections are solved at times of the grid."""
        if not self.packs:
            self.entries.append(Entry(records, on_grid, on_grid))
            return
        self.entries += [Entry((one,), (exact,), (exact,)) for one, exact in zip(records, on_grid, strict=True)]
        self._pack()

    def expect(self, times: Sequence[float]) -> None:
        """Sets the times of the grid [s] that come before the next stop: what advances the line records it there."""
        self._due, self._met = times, 0

    def due(self, until: float) -> Sequence[float]:
        """Those of them before a time [s] at which the line has not been recorded."""
        return [time for time in self._due[self._met :] if time < until]

    def record_due(self, state: LineState) -> None:
        """Writes down the state at the first of these times, before what has happened since."""
        at = len(self.entries)
        while at > 0 and self.entries[at - 1].records[-1].time > state.point.t:
            at -= 1
        self.entries.insert(at, Entry((recorded(state, self.pending),), (True,), (True,)))
        self._met += 1

    def note(self, state: LineState, crossing: Crossing, what: str, time: float | None = None) -> None:
        """Writes down what happened to a load, now or at another time [s]; the event's value is the load's number on
        the rope."""
        run = state.runs[crossing.r]
        load = crossing.load - run.loads.first
        if run.loads.mass[load] == 0.0:  # a missing load
            return
        name = run.loads.names[load]
        number = int(name[1:]) if run.closed else crossing.load + 1
        self.events.append(
            Event(state.point.t if time is None else time, run.nodes[crossing.k].name, what, number, name)
        )

    @property
    def on_grid(self) -> np.ndarray:
        """Which entries are at a time of the grid."""
        return np.array([flag for entry in self._all for flag in entry.on_grid], dtype=bool)

    @property
    def exact(self) -> np.ndarray:
        """In which entries all sections are solved."""
        return np.array([flag for entry in self._all for flag in entry.exact], dtype=bool)

    @property
    def records(self) -> Records:
        """The states."""
        self._pack()
        return Records(entry.records for entry in self._all)

    @property
    def _all(self) -> list[Entry]:
        """The entries with those between them, in order of time."""
        if not self._between:
            return self.entries
        last = self.entries[-1].records[-1].time
        kept = {record.time: record for record in self._between.values() if record.time < last}
        more = [Entry((record,), (False,), (False,)) for record in kept.values()]
        return sorted([*self.entries, *more], key=lambda entry: entry.records[0].time)
