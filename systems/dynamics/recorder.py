"""What a run writes down: states and events, with checkpoints that it can return to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ropeway.systems.dynamics.load_crossings import Crossing
from ropeway.systems.results.run_data import Event
from ropeway.systems.statics.line_records import Record, recorded
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.pending_events import Pending


class Entry(NamedTuple):
    """A state of a run: whether it is at a time of the result's grid, and whether all its sections are solved."""

    record: Record
    on_grid: bool
    exact: bool


class Checkpoint(NamedTuple):
    """How many entries and events there were at a time."""

    entries: int
    events: int


class Recorder:
    """The entries and events of a run so far; `pending` is what each record says of clocks and an emergency stop."""

    def __init__(self, pending: Pending | None = None) -> None:
        self.entries: list[Entry] = []
        self.events: list[Event] = []
        self.pending = Pending() if pending is None else pending

    def checkpoint(self) -> Checkpoint:
        """A mark that `rewind` returns to."""
        return Checkpoint(len(self.entries), len(self.events))

    def rewind(self, checkpoint: Checkpoint) -> None:
        """Deletes all that was written down after a checkpoint."""
        del self.entries[checkpoint.entries :]
        del self.events[checkpoint.events :]

    def record(self, state: LineState, *, on_grid: bool = False, exact: bool = True) -> None:
        """Writes a state down."""
        self.entries.append(Entry(recorded(state, self.pending), on_grid, exact))

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
        return np.array([entry.on_grid for entry in self.entries], dtype=bool)

    @property
    def exact(self) -> np.ndarray:
        """In which entries all sections are solved."""
        return np.array([entry.exact for entry in self.entries], dtype=bool)

    @property
    def records(self) -> tuple[Record, ...]:
        """The states."""
        return tuple(entry.record for entry in self.entries)
