"""Tables of a model: its variables, the travels and loads of its ropes, balances and limits."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ropeway.components.check import Range
from ropeway.components.variable import Kind
from ropeway.systems.modelling.rope_path import Run


@dataclass(frozen=True)
class VariableTable:
    """All variables of one kind in the order of their vector: parallel tuples and arrays of shape (n,). `hidden` has
    the names that results omit; the first `shared` belong to no component: gravity, the weather."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    descriptions: tuple[str, ...]
    values: np.ndarray
    nominals: np.ndarray
    ranges: tuple[Range, ...]
    hidden: frozenset[str] = frozenset()
    shared: int = 0

    @cached_property
    def index(self) -> dict[str, int]:
        """Position of each name."""
        return {name: i for i, name in enumerate(self.names)}

    @cached_property
    def shown(self) -> tuple[int, ...]:
        """Positions of the variables that results show."""
        return tuple(i for i, name in enumerate(self.names) if name not in self.hidden)

    def __len__(self) -> int:
        return len(self.names)


def shared_places(tables: Mapping[Kind, VariableTable]) -> list[tuple[Kind, int]]:
    """Vector and entry of what all components have in common: gravity, with weather also the values of `Weather.of`."""
    inputs, parameters = tables[Kind.INPUT].shared, tables[Kind.PARAMETER].shared
    places = [(Kind.PARAMETER, 0), *((Kind.INPUT, i) for i in range(inputs))]
    return places + [(Kind.PARAMETER, i) for i in range(1, parameters)]


@dataclass(frozen=True)
class Travel:
    """Positions of the travels of a run's supports, shapes (supports,), in the states or in the algebraic variables; -1
    where absent. A travel in neither is zero."""

    state: np.ndarray
    algebraic: np.ndarray

    def read(self, x: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Travels [m] from the states and algebraic variables."""
        q = np.zeros(len(self.state))
        (in_x, from_x), (in_z, from_z) = self._places
        q[in_x] = x[from_x]
        q[in_z] = z[from_z]
        return q

    def write(self, q: np.ndarray, x: np.ndarray, z: np.ndarray) -> None:
        """Writes travels to the states and algebraic variables."""
        (in_x, from_x), (in_z, from_z) = self._places
        x[from_x] = q[in_x]
        z[from_z] = q[in_z]

    @cached_property
    def _places(self) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """Supports with a travel among the states, and its positions; the same for algebraic variables."""
        in_x, in_z = np.flatnonzero(self.state >= 0), np.flatnonzero(self.algebraic >= 0)
        return (in_x, self.state[in_x]), (in_z, self.algebraic[in_z])


@dataclass(frozen=True)
class LoadSlots:
    """Positions of a run's load slots in the discrete vector: the first slot of each kind in each span (spans,), and
    the number of slots (spans,). `drag`: without weather -1."""

    count: np.ndarray
    mass: np.ndarray
    at: np.ndarray
    ride: np.ndarray
    empty: np.ndarray
    drag: np.ndarray

    @cached_property
    def _cells(self) -> tuple[np.ndarray, np.ndarray]:
        """Span and slot number of every slot."""
        return _cells(np.arange(len(self.count)), self.count)

    @cached_property
    def _every(self) -> tuple[np.ndarray, ...]:
        """As `_places` of all spans."""
        return self._places(*self._cells)

    def _places(self, span: np.ndarray, slot: np.ndarray) -> tuple[np.ndarray, ...]:
        """Of slots their spans and numbers, and the places of mass, at, ride, empty and drag area."""
        return (span, slot, *(first[span] + slot for first in (self.mass, self.at, self.ride, self.empty, self.drag)))

    def filled(self, d: np.ndarray) -> int:
        """Number of slots with a load."""
        span, slot = self._cells
        return len(span) - int(np.count_nonzero(d[self.empty[span] + slot]))

    def write(
        self, d: np.ndarray, run: Run, passed: np.ndarray, start: np.ndarray, spans: np.ndarray | None = None
    ) -> None:
        """Fills the slots of all or of some spans according to `passed`. `start` (supports,) is the rope coordinate at
        each support at zero travel [m]. `d` (..., nd) and `passed` (..., supports) may contain many records."""
        loads = run.loads
        if len(loads.place) == 0:
            return
        places = self._every if spans is None else self._places(*_cells(spans, self.count[spans]))
        span, slot, mass, at, ride, empty, drag = places
        load, full, pinned = self._loads(run, passed, span, slot)
        d[..., mass] = np.where(full, loads.mass.take(load), 0.0)
        d[..., at] = self._at(run, load, full, pinned, start.take(span))
        d[..., ride] = full if pinned is None else full & ~pinned
        d[..., empty] = ~full
        if self.drag[0] >= 0:
            d[..., drag] = np.where(full, loads.drag.take(load), 0.0)

    def write_places(self, d: np.ndarray, run: Run, passed: np.ndarray, start: np.ndarray) -> None:
        """As `write` of all spans, where only the places of the same loads have changed."""
        if len(run.loads.place):
            span, slot, _, at, *_ = self._every
            d[..., at] = self._at(run, *self._loads(run, passed, span, slot), start.take(span))

    @staticmethod
    def _loads(
        run: Run, passed: np.ndarray, span: np.ndarray, slot: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Of slots their loads, whether they have one, and whether it is pinned, None where none is."""
        load = passed.take(span, axis=-1) - 1 - slot
        full = load >= passed.take(span + 1, axis=-1)
        load *= full
        return load, full, full & (run.loads.pinned.take(load) >= 0) if run.loads.pins else None

    @staticmethod
    def _at(run: Run, load: np.ndarray, full: np.ndarray, pinned: np.ndarray | None, start: np.ndarray) -> np.ndarray:
        """Places of the loads in slots, from the starts of their spans."""
        at = np.where(full, run.loads.place.take(load) - start, 0.0)
        return at if pinned is None else np.where(pinned, run.loads.at.take(load), at)


def _cells(spans: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Span and number of each slot of some spans."""
    span = np.repeat(spans, count)
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    return span, np.arange(len(span)) - np.repeat(first, count)


@dataclass(frozen=True)
class RunLayout:
    """Positions of a run's variables in the vectors of the model: travels, slots, initial length, mass per length,
    compliance and tension vector of each span (spans,). `held` (supports,) is -1 for supports that cannot hold a load.
    `aside` (2, spans) is the rope between a node and the end of a span, -1 for a span that ends at the node. `grip` is
    the reference travel of a saddle's friction, -1 without one."""

    travel: Travel
    slots: LoadSlots
    length_start: np.ndarray
    mass_per_length: np.ndarray
    compliance: np.ndarray
    force: np.ndarray
    held: np.ndarray
    held_travel: np.ndarray
    aside: np.ndarray
    grip: np.ndarray

    def start(self, p: np.ndarray) -> np.ndarray:
        """Rope coordinate at each support at zero travel [m], shape (supports,)."""
        found = np.zeros(len(self.length_start) + 1)
        p[self.length_start].cumsum(out=found[1:])
        return found

    @property
    def key(self) -> Hashable:
        """The positions that equations of solvers depend on."""
        return tuple(a.tobytes() for a in (self.length_start, self.slots.count, self.slots.at, self.slots.ride))

    @cached_property
    def holds(self) -> tuple[np.ndarray, np.ndarray]:
        """Places of what says that a load stands on an idler, and of the travel that it holds there."""
        return self.held[self.held >= 0], self.held_travel[self.held_travel >= 0]

    @cached_property
    def holding(self) -> np.ndarray:
        """The supports whose idlers can hold a load."""
        return np.flatnonzero(self.held >= 0)

    def free(self, z: np.ndarray) -> np.ndarray:
        """Length of each span minus the rope between its nodes (spans,) [m]; negative on shoes."""
        more, less = np.where(self.aside >= 0, z[self.aside], 0.0)
        return np.asarray(more - less)


@dataclass(frozen=True)
class Balance:
    """A travel among the algebraic variables and the residual of its tension balance, or a free node's coordinate and
    the sum of forces along it. `sign` is +1 if more travel lowers the residual of a stable line, -1 if it raises it."""

    travel: int
    residual: int
    sign: float


@dataclass(frozen=True)
class Limits:
    """All limits of a model as parallel arrays: position of the output, bounds, event and component."""

    output: np.ndarray
    low: np.ndarray
    high: np.ndarray
    events: tuple[str, ...]
    components: tuple[str, ...]

    def broken(self, outputs: np.ndarray) -> np.ndarray:
        """Limits exceeded by outputs of shape (..., ny), as booleans of shape (..., limits)."""
        values = outputs[..., self.output]
        return np.asarray((values < self.low) | (values > self.high))
