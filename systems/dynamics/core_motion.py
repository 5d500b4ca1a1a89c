"""Calls of the compiled core that move a line: what they are given, and what they have written down."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ropeway.components.catenary import Uniform
from ropeway.systems.dynamics.agenda import Agenda
from ropeway.systems.dynamics.line_stepper import LEAST_STEP, LONGEST_STEP
from ropeway.systems.dynamics.load_crossings import Crossing
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.native import section_library as core
from ropeway.systems.solvers.compiled_line import CompiledLine, PointSolver
from ropeway.systems.solvers.compiled_nodes import Filled, compiled_clocks, compiled_drives, no_clocks
from ropeway.systems.solvers.compiled_rows import load_tables
from ropeway.systems.solvers.drive_trajectories import NODES, WEIGHTS, Window
from ropeway.systems.statics.line_records import AnyRecord, PartRecord, Record
from ropeway.systems.statics.line_state import LineState, load_force, read_value, span_rope
from ropeway.systems.statics.pending_events import Pending
from ropeway.systems.statics.record_blocks import RecordBlock

_NUMBERS = 2_000_000
"""Numbers in the records that the core keeps before they are taken over, about."""
_RECORDS = 1024
"""Records that the core keeps before they are taken over."""
_EVENT = len(core.CrossingEvent._fields_)
_EPOCHS = 256
"""Ticks of clocks before records are taken over."""


class Bends(NamedTuple):
    """Where the slopes of inputs change: times (n,) [s], values of all inputs there (n, nu), and their slopes before
    each and after the last (n + 1, nu)."""

    time: np.ndarray
    value: np.ndarray
    slope: np.ndarray


class CoreMotion:
    """The core for a line with its lists of loads. `drives`: those that move by themselves, None where they are
    integrated elsewhere; `solver`: the point of the last call."""

    solver: PointSolver

    def __init__(self, line: CompiledLine, state: LineState) -> None:
        self.line, tables, model = line, line.tables, state.model
        self._loads = [run.loads for run in state.runs]
        sizes = [len(run.nodes) for run in state.runs]
        self._nodes, self._first = np.cumsum(sizes)[:-1], np.repeat([own.first for own in self._loads], sizes)
        wholes = int(np.clip(_NUMBERS // (tables.nx + tables.nz + tables.supports), 64, _RECORDS))
        drives = compiled_drives(model)
        self.drives = None if drives is None else drives.filled()
        members = sum(len(clock.members) for clock in model.clocks)
        self.events = (core.CrossingEvent * (4 * _RECORDS + core.MOST))()
        self.responses = (core.ResponseEvent * (4 * _RECORDS + members))()
        self._time = np.empty(_RECORDS)
        self._x, self._u = np.empty((_RECORDS, tables.nx)), np.empty((_RECORDS, tables.nu))
        self._grid, self._epoch, self._sections = (np.empty(_RECORDS, np.int32) for _ in range(3))
        self._z, self._beyond = np.empty((wholes, tables.nz)), np.empty((wholes, tables.supports), np.int64)
        self._part_section, self._part_z = np.empty(_RECORDS * core.MOST, np.int32), np.empty(_NUMBERS + 2 * tables.nz)
        self._passed, self._before = np.zeros(tables.supports, np.int64), np.zeros(tables.supports, np.int64)
        self._kept, self._ticks = np.empty((_EPOCHS, len(model.kept))), np.empty((_EPOCHS, len(model.clocks)), np.int64)
        pull, wind = _forces(state)
        fixed = {
            "nodes": NODES,
            "weights": WEIGHTS,
            **load_tables(model, state.runs, state.point.p),
            "scale": np.array(state.span_scale),
            "pull": pull,
            "wind": wind,
            "sign": _signs(model, line),
            "kept": model.kept.astype(np.int32),
            "due": np.zeros(tables.supports),
            "room": np.zeros(2 * tables.nz + 2 * tables.supports),
            "touched": np.zeros(tables.sections, np.int32),
            "old_rate": np.zeros(tables.nz),
            "curve": np.zeros(tables.nz),
        }
        written = {
            "passed": self._passed,
            "record_time": self._time,
            "record_grid": self._grid,
            "record_epoch": self._epoch,
            "record_x": self._x,
            "record_sections": self._sections,
            "record_u": self._u,
            "whole_z": self._z,
            "whole_passed": self._beyond,
            "part_section": self._part_section,
            "part_z": self._part_z,
            "epoch_kept": self._kept,
            "epoch_ticks": self._ticks,
        }
        self.motion = core.Motion(
            most=_RECORDS,
            most_wholes=wholes,
            most_numbers=len(self._part_z),
            event=ctypes.addressof(self.events),
            response=ctypes.addressof(self.responses),
            least_step=LEAST_STEP,
            keeps=len(model.kept),
            epochs=_EPOCHS,
        )
        self._fixed = Filled(self.motion, {**fixed, **written})
        self._saved = np.zeros(line.core.rs_saved_size(ctypes.byref(tables), len(model.d)))

    def fits(self, state: LineState) -> bool:
        """Whether this is the core for a state's model and loads."""
        return self.line.model is state.model and all(
            run.loads is own for run, own in zip(state.runs, self._loads, strict=True)
        )

    def at(self, state: LineState, x_rate: np.ndarray, z_rate: np.ndarray, u_rate: np.ndarray, chain: int = 0) -> None:
        """Takes a state with its rates; the core changes it in place. At most `chain` records that follow a whole one
        hold only what has changed. Raises Interrupted."""
        stop_if_interrupted()
        m = self.motion
        self.solver = PointSolver(self.line, state.point, self.line.used(state.passed), x_rate, u_rate)
        self.solver.z_rate[:] = z_rate
        self._passed[:] = self._before[:] = np.concatenate(state.passed)
        self._kept[0] = state.point.d[state.model.kept]
        m.time, m.events, m.responses, m.epoch = state.point.t, 0, 0, 0
        m.chain = chain
        m.records, m.wholes, m.sections, m.numbers = 0, 0, 0, 0

    def rates(self) -> np.ndarray:
        """Rates of the states here [per s], of drives that the core moves."""
        self._call("rs_rates", self._drives.address)
        return self.solver.x_rate.copy()

    def window(self, end: float) -> tuple[int, Window]:
        """The states from now to `end` [s] or earlier, with the reason where they are not found."""
        m, drives = self.motion, self._drives
        code = self._call("rs_window", drives.address, ctypes.c_double(end))
        return code, Window(m.begin, m.h, drives.arrays["window"].copy())

    def coupled(self) -> bool:
        """Whether a limit of a drive that the core moves is active here."""
        return bool(self._call("rs_coupled", self._drives.address, None, 0))

    def move(self, window: Window, stop: float, *, strict: bool, crossed: float, short: float) -> int:
        """Moves the line through a window of its drives' states to a stop; to the next crossing only where drives are
        integrated elsewhere and may come to their limits. Returns why the core has come back."""
        m = self.motion
        values, rates = np.ascontiguousarray(window.values), np.ascontiguousarray(window.rates)
        m.window, m.window_rates = values.ctypes.data, rates.ctypes.data
        m.begin, m.h, m.crossed = window.start, window.h, crossed
        m.strict, m.single, m.short_step, m.curved = int(strict), int(self.drives is None), short, 0
        drives = None if self.drives is None else self.drives.address
        return self._call("rs_move", ctypes.c_double(stop), drives)

    def run(self, agenda: Agenda, done: int, bends: Bends, short: float) -> int:
        """Moves the line through the stops of an agenda, `done` of which have been reached. Returns why the core has
        come back."""
        model, m = self.line.model, self.motion
        ended = np.isfinite(agenda.last) and (not len(agenda.grid) or agenda.last > agenda.grid[-1])
        stops = np.array([*agenda.grid[done:], *([agenda.last] if ended else [])])
        clocks = compiled_clocks(model) if len(agenda.ticks) else None
        ticks = np.array(agenda.ticks, dtype=np.int64)
        self._clocks = no_clocks() if clocks is None else clocks.filled(np.array(agenda.first, dtype=float), ticks)
        self._ticks[0] = self._clocks.arrays.get("ticks", 0)
        self._names = () if clocks is None else clocks.names
        plan = Filled(
            core.Agenda(bends=len(bends.time), bent=0, discrete=len(model.d)),
            {"bend": bends.time, "value": bends.value, "slope": bends.slope, "saved": self._saved},
        )
        m.stop, m.stops, m.grids, m.reached = stops.ctypes.data, len(stops), len(agenda.grid) - done, 0
        m.strict, m.single, m.short_step, m.longest_step = 1, 0, short, LONGEST_STEP
        return self._call("rs_run", plan.address, self._drives.address, self._clocks.address)

    @property
    def ticks(self) -> list[int]:
        """How often each clock has ticked after the last run."""
        return [int(n) for n in self._clocks.arrays.get("ticks", ())]

    @property
    def _drives(self) -> Filled:
        if self.drives is None:
            raise ValueError("the drives of this line do not move by themselves")
        return self.drives

    def _call(self, name: str, *more: object) -> int:
        """A function of the core on the line, its point and its motion."""
        tables, point = ctypes.byref(self.line.tables), ctypes.byref(self.solver.point)
        return int(getattr(self.line.core, name)(tables, point, ctypes.byref(self.motion), *more))

    def time_of(self, record: int) -> float:
        """Time of a record of the last call [s]."""
        return float(self._time[record])

    def parts(self, pending: Sequence[Pending], last: AnyRecord) -> list[AnyRecord]:
        """The records of the last call, which follow the `last` one: those of crossings hold what they have changed."""
        count, epochs, moved = self.motion.records, self._epoch.tolist(), self._moved()
        kept = _rows_of(self._kept[: self.motion.epoch + 1], last.kept)
        found, whole, section, number = list[AnyRecord](), 0, 0, 0
        rows = zip(_rows_of(self._x[:count], last.x), _rows_of(self._u[:count], last.u), strict=True)
        for i, (x, u) in enumerate(rows):
            vectors, epoch, sections = (float(self._time[i]), x), epochs[i], int(self._sections[i])
            if sections == 0:
                passed = tuple(part.copy() for part in np.split(self._beyond[whole] + self._first, self._nodes))
                last = Record(*vectors, self._z[whole].copy(), u, passed, kept[epoch], pending[epoch])
                whole += 1
            else:
                columns = self.line.columns(tuple(self._part_section[section : section + sections].tolist()))
                values = self._part_z[number : number + len(columns)].copy()
                last = PartRecord(*vectors, u, kept[epoch], pending[epoch], last, columns, values, moved.get(i, ()))
                section, number = section + sections, number + len(columns)
            found.append(last)
        return found

    def _moved(self) -> dict[int, tuple[tuple[int, int, int], ...]]:
        """For records of the last call the supports that loads have passed since the one before, each as run, support
        and the number of the first load that has not passed it."""
        found, passed, first = dict[int, tuple[tuple[int, int, int], ...]](), self._before.copy(), [0, *self._nodes]
        last = [*self._nodes, len(passed)]
        for record, crossing in self.crossed():
            r, loads = crossing.r, self._loads[crossing.r]
            around = crossing.k == 0 and bool(self.line.around[r])
            for k in (first[r] + crossing.k, *((last[r] - 1,) if around else ())):
                passed[k] += 1 if crossing.forward else -1
                own = (r, int(k - first[r]), int(passed[k]) + loads.first)
                found[record] = (*found.get(record, ()), own)
        return found

    def written(self, state: LineState, pending: Sequence[Pending]) -> RecordBlock:
        """The records of the last call, all of which are whole; `pending`: what is pending in each epoch."""
        count, u = self.motion.records, state.point.u
        varied = self._u[:count] if np.any(self._u[:count] != u) else u[None]
        return RecordBlock(
            self._time[:count].copy(),
            self._x[:count].copy(),
            self._z[:count].copy(),
            np.broadcast_to(varied.copy(), (count, len(u))),
            self._beyond[:count] + self._first,
            self._nodes,
            self._epoch[:count].copy(),
            self._kept[: self.motion.epoch + 1].copy(),
            pending,
        )

    def on_grid(self) -> list[bool]:
        """Which records of the last call are at a time of the grid."""
        return list(map(bool, self._grid[: self.motion.records].tolist()))

    def epochs(self) -> list[list[int]]:
        """How often each clock has ticked in each epoch of the last run."""
        return [row[: len(self.ticks)] for row in self._ticks[: self.motion.epoch + 1].tolist()]

    def passed(self) -> list[np.ndarray]:
        """Loads passed at the supports of each run."""
        return [part.copy() for part in np.split(self._passed, self._nodes)]

    def crossed(self) -> list[tuple[int, Crossing]]:
        """The crossings of the last call: the record that each leads to, and what has crossed."""
        rows = np.frombuffer(memoryview(self.events), np.int32).reshape(-1, _EVENT)[: self.motion.events]
        first = np.array([own.first for own in self._loads], dtype=np.int64)
        numbers, events = rows[:, 2] + first[rows[:, 0]], rows.tolist()
        return [
            (record, Crossing(0.0, 0.0, r, k, number, bool(forward)))
            for (r, k, _, forward, record), number in zip(events, numbers.tolist(), strict=True)
        ]

    def corrected(self) -> list[tuple[int, tuple[str, float]]]:
        """The responses of the last run: the record that each leads to, its node and its correction [m/s]."""
        found = self.responses[: self.motion.responses]
        return [(event.record, (self._names[event.member], event.value)) for event in found]

    @property
    def coming(self) -> Crossing:
        """The crossing that the core has left to its caller."""
        event = self.motion.coming
        number = event.load + self._loads[event.run].first
        return Crossing(0.0, 0.0, event.run, event.support, number, bool(event.forward))


def _rows_of(rows: np.ndarray, last: np.ndarray) -> list[np.ndarray]:
    """Copies of rows; those that are equal to the one before, or the first to `last`, are one array with it."""
    same = (rows == np.concatenate([last[None], rows[:-1]])).all(axis=1)
    found = [last]
    for row, known in zip(rows, same.tolist(), strict=True):
        found.append(found[-1] if known else row.copy())
    return found[1:]


def _signs(model: Model, line: CompiledLine) -> np.ndarray:
    """For each support the sign of its balance, 1 where more travel lowers its residual (supports,)."""
    by_travel = {balance.travel: int(balance.sign) for balance in model.balances}
    return np.array([by_travel.get(z, 1) for z in line.sections.travel.tolist()], dtype=np.int32)


def _forces(state: LineState) -> tuple[np.ndarray, np.ndarray]:
    """What each metre of rope adds to its tension vector (spans, 3) [N/m], and each square metre of a load's drag area
    (2,) [N/m2]; weather does not change in the core."""
    pull, p = np.zeros((sum(len(run.spans) for run in state.runs), 3)), state.point.p
    if not state.model.weather:
        pull[:, 2] = p[0] * np.concatenate([p[layout.mass_per_length] for layout in state.model.layouts])
        return pull, np.zeros(2)
    read = partial(read_value, state.model, state.point, state.outputs())
    places = [(run, k) for run in state.runs for k in range(len(run.spans))]
    for i, (run, k) in enumerate(places):
        weight = span_rope(state.model, run, k, read).weight
        pull[i] = [-f for f in weight.force] if isinstance(weight, Uniform) else [0.0, 0.0, weight]
    on_load = load_force(state.model, 0.0, 1.0, read)
    wind = np.array([-on_load[0], -on_load[1]]) if isinstance(on_load, tuple) else np.zeros(2)
    return pull, wind
