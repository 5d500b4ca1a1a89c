"""A line led from crossing to crossing in the compiled core.

The core moves drives, loads that pass their supports, and clocks. What takes more, as a load that is
pushed back or rests on a drum, is done here by the same rules as everywhere (`load_events`), with sections solved by
the core.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.agenda import Agenda, Progress
from ropeway.systems.dynamics.compiled_stepper import CompiledStepper
from ropeway.systems.dynamics.line_stepper import LONGEST_STEP, LineMotion
from ropeway.systems.dynamics.section_integrator import SectionIntegrator, UnforeseenError
from ropeway.systems.native.section_library import (
    ASTRAY,
    COUPLED,
    CROSSING,
    FULL,
    LOADS,
    PASSED,
    REACHED,
    UNFORESEEN,
)
from ropeway.systems.results.run_data import Event
from ropeway.systems.solvers.compiled_nodes import compiled_clocks
from ropeway.systems.solvers.drive_trajectories import Drives, Window, drives_of
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import extend


class CompiledSections(SectionIntegrator):
    """Advances a line in the core."""

    line: CompiledStepper

    def advance(self, motion: LineMotion, stop: float) -> LineMotion | None:
        line = self.line
        if line.moving.drives is None:
            return super().advance(motion, stop)
        if line.state.standing():
            return None
        line.moving.at(line.state, motion.x, motion.z, line.slope(stop))
        code, window = line.moving.window(min(stop, line.time + LONGEST_STEP))
        if code == COUPLED:
            return None
        if code == ASTRAY:
            return super().advance(motion, stop)
        return self.attempt(window, window.start + window.h, motion, stop)

    def through(
        self, window: Window, end: float, motion: LineMotion, stop: float, *, strict: bool
    ) -> LineMotion | None:
        line = self.line
        if line.state.resting:
            return super().through(window, end, motion, stop, strict=strict)
        crossed, limits = -np.inf, self._limits()
        while True:
            core = line.moving
            core.at(line.state, window.at(line.time)[1], motion.z, line.slope(stop), self.recorder.chain)
            code = core.move(window, end, strict=strict, crossed=crossed, short=line.tiny)
            crossed = core.motion.crossed
            motion = self._taken_over()
            state = line.state
            if code == UNFORESEEN:
                raise UnforeseenError
            # A crossing can activate a limit that is inactive again before the stop.
            if code == COUPLED or (code == PASSED and core.drives is not None) or self._is_coupled(limits):
                return None
            if code == REACHED:
                return motion
            if code == LOADS:
                _extend(state)
            elif code == CROSSING:
                motion = line.correct(motion, stop)
                coming = loads.gap_of(state, core.coming, motion.travel)
                motion = self.events.cross(coming, motion, stop, exact=True)
                state = line.state
                if self._is_coupled(limits):
                    return None
                if state.standing():
                    return line.solve(stop)
                if state.resting:
                    return super().through(window, end, motion, stop, strict=strict)
            elif code not in (FULL, PASSED):
                raise core.line.failure(core.motion.failure, core.solver.point.worst)

    def _limits(self) -> Drives | None:
        """The drives, where they are integrated elsewhere and have limits."""
        if self.line.moving.drives is not None:
            return None
        drives = drives_of(self.line.state.model, self.line.tolerance)
        return drives if drives.ties else None

    def _is_coupled(self, limits: Drives | None) -> bool:
        """Whether a limit of a drive is active."""
        line, core = self.line, self.line.moving
        if limits is not None:
            return not limits.decoupled(line.state.point)
        if core.drives is None:
            return False
        nothing = np.zeros(len(line.state.point.x)), np.zeros(len(line.state.point.z))
        core.at(line.state, *nothing, np.zeros(len(line.state.point.u)))
        return core.coupled()

    def along(self, agenda: Agenda) -> tuple[Progress, LineMotion | None]:
        """Advances through as many stops as the core can do alone, each with an entry; the line is then solved at the
        last of them. Returns how far it has come, and its rates there."""
        line, done, motion = self.line, 0, None
        while done <= len(agenda.grid):
            state, core = line.state, line.moving
            if core.drives is None or state.standing() or state.resting or loads.overrun(state, set()):
                break
            if len(agenda.ticks) and compiled_clocks(state.model) is None:
                break
            bends = line.bends(float(max([*agenda.grid[-1:], *([agenda.last] if np.isfinite(agenda.last) else [])])))
            nothing = np.zeros(len(state.point.x)), np.zeros(len(state.point.z))
            core.at(state, *nothing, bends.slope[0], self.recorder.chain)
            code = core.run(agenda, done, bends, line.tiny)
            begin = line.time
            motion = self._taken_over(agenda)
            done, agenda = done + min(core.motion.reached, core.motion.grids), replace(agenda, ticks=core.ticks)
            if code == LOADS:
                _extend(line.state)
            elif not (code == FULL and line.time > begin):
                break
        return Progress(done, tuple(agenda.ticks)), motion

    def _taken_over(self, agenda: Agenda | None = None) -> LineMotion:
        """Takes over the state and the records of the core's last call, with their events; returns the rates."""
        line, state, core, recorder = self.line, self.line.state, self.line.moving, self.recorder
        pending = [recorder.pending] if agenda is None else [agenda.pending(ticks) for ticks in core.epochs()]
        happened: list[tuple[int, loads.Crossing | tuple[str, float]]] = [*core.crossed()]
        if agenda is not None and core.motion.responses:
            happened = sorted([*happened, *core.corrected()], key=lambda entry: entry[0])
        for record, what in happened:
            time = core.time_of(record)
            if isinstance(what, loads.Crossing):
                self.guard.require(time, state.runs[what.r].nodes[what.k].name)
                recorder.note(state, what, loads.passing_event(state, what), time)
            else:
                recorder.events.append(Event(time, what[0], "response", what[1]))
        last = recorder.last
        records = core.written(state, pending) if last is None else core.parts(pending, last)
        recorder.take(records, core.on_grid())
        recorder.pending = pending[-1]
        state.passed = core.passed()
        line.set_time(core.motion.time)
        return line.motion_at(core.solver.x_rate.copy(), core.solver.z_rate.copy())


def _extend(state: LineState) -> None:
    """Takes more loads from the feeds of all runs, on both sides of an endless one."""
    for r, run in enumerate(state.runs):
        if run.feed is not None:
            extend(state, r)
        if run.around:
            extend(state, r, ahead=True)
