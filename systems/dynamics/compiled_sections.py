"""A line in the compiled core: its sections solved and led from crossing to crossing there.

The core follows drives whose travel is a known function of time, and loads that pass their supports. What takes more,
as a load that is pushed back or rests on a drum, is done here by the same rules as everywhere (`load_events`), with
sections solved by the core.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ropeway.components.errors import CompiledError
from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.line_stepper import LineMotion, LineStepper
from ropeway.systems.dynamics.section_integrator import LEAST_STEP, SectionIntegrator, UnforeseenError
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.native.section_library import (
    CROSSING,
    FULL,
    LOADS,
    REACHED,
    UNFORESEEN,
    CrossingEvent,
    Motion,
)
from ropeway.systems.solvers.compiled_line import CompiledLine, PointSolver, compiled_line
from ropeway.systems.solvers.drive_trajectories import NODES, Window
from ropeway.systems.solvers.prescribed_states import commanded_of
from ropeway.systems.statics.line_state import Record
from ropeway.systems.statics.stability import require_followed

_RECORDS = 256
"""Records that the core keeps before they are taken over."""


def require_compiled(model: Model) -> CompiledLine:
    """The compiled core of a model whose drives follow commanded speeds. Raises CompiledError, CompilerError,
    WriteError."""
    line = compiled_line(model)
    others = [name for i, name in enumerate(model.x.names) if i not in set(commanded_of(model).rows)]
    if others:
        raise CompiledError(
            f"The compiled core cannot integrate {others[0]!r} of {model.name!r}: only drives that follow their "
            "commanded speed exactly, as IdealDrive does",
            "Leave out compiled=True",
        )
    return line


class CompiledStepper(LineStepper):
    """A line whose sections the core solves."""

    @property
    def core(self) -> CompiledLine:
        """The core of the present model, which grows with the loads in a span."""
        return compiled_line(self.state.model)

    def solver(self, x_rate: np.ndarray, stop: float) -> PointSolver:
        """The present point in the core."""
        return PointSolver(self.core, self.state.point, self.core.used(self.state.passed), x_rate, self.slope(stop))

    def solve(self, stop: float) -> LineMotion:
        x_rate = self.rates()
        solver = self.solver(x_rate, stop)
        self.core.solve(solver)
        return self.motion_at(x_rate, solver.z_rate)

    def sections_beside(self, crossings: Sequence[loads.Crossing]) -> list[int]:
        touched = set[int]()
        first = np.cumsum([0, *(len(run.spans) for run in self.state.runs)])
        of = self.core.section_of
        for c in crossings:
            spans = of[first[c.r] : first[c.r + 1]]
            touched.update(spans[max(c.k - 1, 0) : c.k + 1].tolist())
            if c.k == 0 and self.state.runs[c.r].closed:
                touched.add(int(spans[-1]))
        return sorted(touched)

    def solve_sections(self, sections: Sequence[int], motion: LineMotion, stop: float) -> LineMotion:
        solver = self.solver(motion.x, stop)
        solver.z_rate[:] = motion.z
        self.core.solve(solver, sections)
        return self.motion_at(motion.x, solver.z_rate)

    def motion(self, z: np.ndarray) -> LineMotion:
        return self.motion_at(self.rates(), z)

    def integrate(self, h: float, motion: LineMotion, stop: float) -> LineMotion:
        point = self.state.point
        predicted = point.z + h * motion.z
        window = self.window(h, motion, stop)
        point.x[:] = window.values[-1]
        point.z[:] = predicted
        self.set_time(point.t + h)
        motion = self.solve(stop)
        require_followed(self.state, predicted)
        return motion

    def window(self, h: float, motion: LineMotion, stop: float) -> Window:
        """The states over the next `h` seconds, at a constant rate or by their commands."""
        point = self.state.point
        values = point.x + np.outer(NODES * h, motion.x)
        commanded_of(self.state.model).put(values[1:], point, NODES[1:] * h, self.slope(stop))
        return Window(point.t, h, values)


@dataclass(frozen=True, eq=False)
class _Room:
    """Where the core writes records and events, and works."""

    time: np.ndarray
    x: np.ndarray
    z: np.ndarray
    passed: np.ndarray
    events: ctypes.Array[CrossingEvent]
    work: np.ndarray


class CompiledSections(SectionIntegrator):
    """Advances a line in the core."""

    line: CompiledStepper
    _room: _Room | None = None

    def advance(self, motion: LineMotion, stop: float) -> LineMotion | None:
        line = self.line
        if line.state.standing():
            return None
        return self.attempt(line.window(stop - line.time, motion, stop), stop, motion, stop)

    def through(
        self, window: Window, end: float, motion: LineMotion, stop: float, *, strict: bool
    ) -> LineMotion | None:
        if self.line.state.resting:
            return super().through(window, end, motion, stop, strict=strict)
        crossed = -np.inf
        while True:
            step = _Step(self, window, end, motion, stop, crossed, strict)
            code = step.run()
            motion, crossed = step.taken_over(), step.motion.crossed
            state = self.line.state
            if code == REACHED:
                return motion
            if code == UNFORESEEN:
                raise UnforeseenError
            if code == LOADS:
                for r in range(len(state.runs)):
                    loads.gaps(state, r)
            elif code == CROSSING:
                motion = self.line.correct(motion, stop)
                motion = self.events.cross(loads.gap_of(state, step.coming(), motion.travel), motion, stop, exact=True)
                if state.standing() or self.line.state.standing():
                    return self.line.solve(stop)
                if self.line.state.resting:
                    return super().through(window, end, motion, stop, strict=strict)
            elif code != FULL:
                raise self.line.core.failure(step.motion.failure, step.solver.point.worst)

    def room(self, core: CompiledLine) -> _Room:
        """Room for records of a line."""
        t = core.tables
        sizes = (_RECORDS, t.nx), (_RECORDS, t.nz), (_RECORDS, t.supports)
        if self._room is None or self._room.passed.shape != sizes[2]:
            self._room = _Room(
                np.zeros(_RECORDS),
                np.zeros(sizes[0]),
                np.zeros(sizes[1]),
                np.zeros(sizes[2], dtype=np.int64),
                (CrossingEvent * (4 * _RECORDS + 64))(),
                np.zeros(2 * t.nz + 2 * t.supports),
            )
        return self._room


class _Step:
    """One call of the core: to the end of a window, or to what it leaves to its caller."""

    def __init__(
        self,
        owner: CompiledSections,
        window: Window,
        end: float,
        motion: LineMotion,
        stop: float,
        crossed: float,
        strict: bool,
    ) -> None:
        self.owner, self.line = owner, owner.line
        state, core = self.line.state, self.line.core
        self.core, self.room = core, owner.room(core)
        self.begin_time, self.begin_u = state.point.t, state.point.u.copy()
        self.solver = self.line.solver(window.at(state.point.t)[1], stop)
        self.solver.z_rate[:] = motion.z
        lists = [run.loads for run in state.runs]
        self.arrays = {
            "window": np.ascontiguousarray(window.values),
            "window_rates": np.ascontiguousarray(window.rates),
            "load_first": np.cumsum([0, *(len(own.place) for own in lists)]),
            "place": np.concatenate([own.place for own in lists]),
            "mass": np.concatenate([own.mass for own in lists]),
            "rope": np.concatenate([layout.start(state.point.p) for layout in state.model.layouts]),
            "scale": np.array(state.span_scale),
            "passed": np.concatenate(state.passed).astype(np.int64),
            "mass_per_length": np.concatenate([layout.mass_per_length for layout in state.model.layouts]).astype(
                np.int32
            ),
            "record_time": self.room.time,
            "record_x": self.room.x,
            "record_z": self.room.z,
            "record_passed": self.room.passed,
            "room": self.room.work,
        }
        m = self.motion = Motion()
        for name, array in self.arrays.items():
            setattr(m, name, array.ctypes.data)
        m.time, m.end, m.begin, m.h = state.point.t, end, window.start, window.h
        m.strict, m.crossed, m.most = int(strict), crossed, _RECORDS
        m.short_step, m.least_step = self.line.tiny, LEAST_STEP
        m.event = ctypes.addressof(self.room.events)

    def run(self) -> int:
        """Calls the core; returns why it has come back. Raises Interrupted."""
        stop_if_interrupted()
        return int(
            self.core.core.rs_move(
                ctypes.byref(self.core.tables), ctypes.byref(self.solver.point), ctypes.byref(self.motion)
            )
        )

    def taken_over(self) -> LineMotion:
        """Takes over the state, the records and the events; returns the rates."""
        line, state, m = self.line, self.line.state, self.motion
        nodes = np.cumsum([len(run.nodes) for run in state.runs])[:-1]
        kept = state.point.d[state.model.kept]
        count = m.records
        times, x, z = self.room.time[:count].tolist(), self.room.x[:count].copy(), self.room.z[:count].copy()
        passed = self.room.passed[:count].copy()
        firsts = [run.loads.first for run in state.runs]
        pending = self.owner.recorder.pending
        records = []
        for i, time in enumerate(times):
            own = tuple(p + f for p, f in zip(np.split(passed[i], nodes), firsts, strict=True))
            records.append(Record(time, x[i], z[i], line.inputs_at(time), own, kept, pending))
        self._note(records)
        state.passed = np.split(self.arrays["passed"], nodes)
        line.set_time(m.time)
        return line.motion_at(self.solver.x_rate.copy(), self.solver.z_rate.copy())

    def _note(self, records: Sequence[Record]) -> None:
        """Writes records and events down, in their order."""
        owner, state = self.owner, self.line.state
        done = 0
        for event in self.room.events[: self.motion.events]:
            while done < event.record:
                owner.recorder.add(records[done])
                done += 1
            crossing = self._crossing(event)
            time = records[event.record].time
            owner.guard.require(time, state.runs[crossing.r].nodes[crossing.k].name)
            owner.recorder.note(state, crossing, loads.passing_event(state, crossing), time)
        for record in records[done:]:
            owner.recorder.add(record)

    def _crossing(self, event: CrossingEvent) -> loads.Crossing:
        number = event.load + self.line.state.runs[event.run].loads.first
        return loads.Crossing(0.0, 0.0, event.run, event.support, number, bool(event.forward))

    def coming(self) -> loads.Crossing:
        """The crossing that the core has left."""
        return self._crossing(self.motion.coming)
