"""A call of the compiled core that moves a line: what it is given, and what it has written down."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import partial

import numpy as np

from ropeway.components.catenary import Uniform
from ropeway.systems.dynamics.compiled_stepper import CompiledStepper
from ropeway.systems.dynamics.line_stepper import LineMotion
from ropeway.systems.dynamics.load_crossings import Crossing
from ropeway.systems.dynamics.recorder import Entry
from ropeway.systems.dynamics.section_integrator import LEAST_STEP
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.native.section_library import CrossingEvent, Motion
from ropeway.systems.solvers.compiled_line import CompiledLine, PointSolver
from ropeway.systems.solvers.drive_trajectories import Window
from ropeway.systems.statics.line_records import Record
from ropeway.systems.statics.line_state import LineState, load_force, read_value, span_rope
from ropeway.systems.statics.pending_events import Pending

_NUMBERS = 2_000_000
"""Numbers in the records that the core keeps before they are taken over, about."""


class CoreMotion:
    """The core for a line with its lists of loads; `events` are those of the last call."""

    solver: PointSolver

    def __init__(self, line: CompiledLine, state: LineState) -> None:
        self.line, tables = line, line.tables
        self._loads = [run.loads for run in state.runs]
        self._nodes = np.cumsum([len(run.nodes) for run in state.runs])[:-1]
        most = int(np.clip(_NUMBERS // (tables.nx + tables.nz + tables.supports), 16, 512))
        self.events = (CrossingEvent * (4 * most + 64))()
        self._time, self._grid = np.zeros(most), np.zeros(most, dtype=np.int32)
        self._x, self._z = np.zeros((most, tables.nx)), np.zeros((most, tables.nz))
        self._beyond = np.zeros((most, tables.supports), dtype=np.int64)
        self._passed = np.zeros(tables.supports, dtype=np.int64)
        layouts = state.model.layouts
        pull, wind = _forces(state)
        self._arrays = {
            "load_first": np.cumsum([0, *(len(own.place) for own in self._loads)], dtype=np.int64),
            "place": np.concatenate([own.place for own in self._loads]),
            "mass": np.concatenate([own.mass for own in self._loads]),
            "drag": np.concatenate([own.drag for own in self._loads]),
            "rope": np.concatenate([layout.start(state.point.p) for layout in layouts]),
            "scale": np.array(state.span_scale),
            "passed": self._passed,
            "pull": pull,
            "wind": wind,
            "record_time": self._time,
            "record_grid": self._grid,
            "record_x": self._x,
            "record_z": self._z,
            "record_passed": self._beyond,
            "room": np.zeros(2 * tables.nz + 2 * tables.supports),
        }
        self.motion = Motion(most=most, event=ctypes.addressof(self.events), least_step=LEAST_STEP)
        for name, array in self._arrays.items():
            setattr(self.motion, name, array.ctypes.data)

    def fits(self, state: LineState) -> bool:
        """Whether this is the core for a state's model and loads."""
        return self.line.model is state.model and all(
            run.loads is own for run, own in zip(state.runs, self._loads, strict=True)
        )

    def move(
        self,
        line: CompiledStepper,
        window: Window,
        motion: LineMotion,
        stops: Sequence[float],
        *,
        grid: bool,
        strict: bool,
        single: bool = False,
        crossed: float = -np.inf,
    ) -> int:
        """Moves a line through a window of its drives' states to each of some stops, with an entry there where they
        are on the grid; single: only to the next crossing. Returns why the core has come back. Raises Interrupted."""
        stop_if_interrupted()
        state, m = line.state, self.motion
        values, rates, times = np.ascontiguousarray(window.values), np.ascontiguousarray(window.rates), np.array(stops)
        self.solver = line.solver(window.at(state.point.t)[1], stops[-1])
        self.solver.z_rate[:] = motion.z
        self._passed[:] = np.concatenate(state.passed)
        m.window, m.window_rates, m.stop = values.ctypes.data, rates.ctypes.data, times.ctypes.data
        m.time, m.begin, m.h, m.crossed = state.point.t, window.start, window.h, crossed
        m.stops, m.reached, m.grid, m.strict = len(stops), 0, int(grid), int(strict)
        m.short_step, m.records, m.events, m.single = line.tiny, 0, 0, int(single)
        tables, point = ctypes.byref(self.line.tables), ctypes.byref(self.solver.point)
        return int(self.line.core.rs_move(tables, point, ctypes.byref(m)))

    def whole_records(self) -> int:
        """Records up to the last one on the grid."""
        on_grid = np.flatnonzero(self._grid[: self.motion.records])
        return int(on_grid[-1]) + 1 if len(on_grid) else 0

    def entries(self, line: CompiledStepper, count: int, pending: Pending) -> list[Entry]:
        """The first `count` records."""
        state = line.state
        kept = state.point.d[state.model.kept]
        x, z, beyond = self._x[:count].copy(), self._z[:count].copy(), self._beyond[:count].copy()
        by_run = [p + own.first for p, own in zip(np.split(beyond, self._nodes, axis=1), self._loads, strict=True)]
        constant = None if len(line.breaks) else state.point.u.copy()
        found = []
        for i, time in enumerate(self._time[:count].tolist()):
            u = line.inputs_at(time) if constant is None else constant
            record = Record(time, x[i], z[i], u, tuple(p[i] for p in by_run), kept, pending)
            found.append(Entry(record, bool(self._grid[i]), exact=bool(self._grid[i])))
        return found

    def passed(self) -> list[np.ndarray]:
        """Loads passed at the supports of each run."""
        return [part.copy() for part in np.split(self._passed, self._nodes)]

    def crossing(self, event: CrossingEvent) -> Crossing:
        """What an event says crosses."""
        number = event.load + self._loads[event.run].first
        return Crossing(0.0, 0.0, event.run, event.support, number, bool(event.forward))

    @property
    def coming(self) -> Crossing:
        """The crossing that the core has left to its caller."""
        return self.crossing(self.motion.coming)


def _forces(state: LineState) -> tuple[np.ndarray, np.ndarray]:
    """What each metre of rope adds to its tension vector (spans, 3) [N/m], and each square metre of a load's drag area
    (2,) [N/m2]; weather does not change in the core."""
    read = partial(read_value, state.model, state.point, state.outputs())
    pull = np.zeros((sum(len(run.spans) for run in state.runs), 3))
    places = [(run, k) for run in state.runs for k in range(len(run.spans))]
    for i, (run, k) in enumerate(places):
        weight = span_rope(state.model, run, k, read).weight
        pull[i] = [-f for f in weight.force] if isinstance(weight, Uniform) else [0.0, 0.0, weight]
    on_load = load_force(state.model, 0.0, 1.0, read)
    wind = np.array([-on_load[0], -on_load[1]]) if isinstance(on_load, tuple) else np.zeros(2)
    return pull, wind
