"""A line led from crossing to crossing in the compiled core.

The core follows drives whose travel is a known function of time, and loads that pass their supports. What takes more,
as a load that is pushed back or rests on a drum, is done here by the same rules as everywhere (`load_events`), with
sections solved by the core.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.compiled_stepper import CompiledStepper
from ropeway.systems.dynamics.core_motion import CoreMotion
from ropeway.systems.dynamics.line_stepper import LineMotion
from ropeway.systems.dynamics.section_integrator import SectionIntegrator, UnforeseenError
from ropeway.systems.native.section_library import (
    CROSSING,
    FULL,
    LOADS,
    PASSED,
    REACHED,
    UNFORESEEN,
)
from ropeway.systems.solvers.drive_trajectories import Drives, Window, drives_of
from ropeway.systems.statics.line_records import Record
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import extend


class CompiledSections(SectionIntegrator):
    """Advances a line in the core."""

    line: CompiledStepper
    _core: CoreMotion | None = None

    def advance(self, motion: LineMotion, stop: float) -> LineMotion | None:
        line = self.line
        if not line.commanded:
            return super().advance(motion, stop)
        if line.state.standing():
            return None
        return self.attempt(line.window(stop - line.time, motion, stop), stop, motion, stop)

    def through(
        self, window: Window, end: float, motion: LineMotion, stop: float, *, strict: bool
    ) -> LineMotion | None:
        if self.line.state.resting:
            return super().through(window, end, motion, stop, strict=strict)
        crossed, limits = -np.inf, self._limits()
        while True:
            core, single = self.core(), limits is not None
            code = core.move(
                self.line, window, motion, [end], grid=False, strict=strict, single=single, crossed=crossed
            )
            crossed = core.motion.crossed
            motion = self._taken_over(core, core.motion.records)
            state = self.line.state
            if code == UNFORESEEN:
                raise UnforeseenError
            # A crossing can activate a limit that is inactive again before the stop.
            if limits is not None and not limits.decoupled(state.point):
                return None
            if code == REACHED:
                return motion
            if code == LOADS:
                _extend(state)
            elif code == CROSSING:
                motion = self.line.correct(motion, stop)
                coming = loads.gap_of(state, core.coming, motion.travel)
                motion = self.events.cross(coming, motion, stop, exact=True)
                state = self.line.state
                if limits is not None and not limits.decoupled(state.point):
                    return None
                if state.standing():
                    return self.line.solve(stop)
                if state.resting:
                    return super().through(window, end, motion, stop, strict=strict)
            elif code not in (FULL, PASSED):
                raise core.line.failure(core.motion.failure, core.solver.point.worst)

    def _limits(self) -> Drives | None:
        """The drives, where they have limits."""
        if self.line.commanded:
            return None
        drives = drives_of(self.line.state.model, self.line.tolerance)
        return drives if drives.ties else None

    def along(self, motion: LineMotion, stops: Sequence[float]) -> tuple[LineMotion, int]:
        """Advances through as many stops as the core can do alone, each with an entry on the grid; the line is then
        solved at the last of them. Returns its rates there, and how many they are."""
        done = 0
        while done < len(stops):
            line, state = self.line, self.line.state
            if not line.commanded or state.standing() or state.resting or loads.overrun(state, set()):
                break
            saved = state.copy()
            window = line.window(stops[-1] - line.time, motion, stops[-1])
            core = self.core()
            code = core.move(line, window, motion, stops[done:], grid=True, strict=True)
            reached = core.motion.reached
            led = self._taken_over(core, core.whole_records())
            done += reached
            if code == REACHED:
                return led, done
            line.state = saved
            if reached:
                _return_to(line.state, self.recorder.entries[-1].record)
                line.set_time(stops[done - 1])
                motion = line.solve(stops[-1])
            if code == LOADS:
                _extend(line.state)
            elif not reached or code != FULL:
                break
        return motion, done

    def core(self) -> CoreMotion:
        """The core for the present model and loads."""
        if self._core is None or not self._core.fits(self.line.state):
            self._core = CoreMotion(self.line.core, self.line.state)
        return self._core

    def _taken_over(self, core: CoreMotion, count: int) -> LineMotion:
        """Takes over the state, and the first `count` records with their events; returns the rates."""
        line, state = self.line, self.line.state
        records = core.entries(line, count, self.recorder.pending)
        done = 0
        for event in core.events[: core.motion.events]:
            if event.record >= count:
                break
            while done < event.record:
                self.recorder.entries.append(records[done])
                done += 1
            crossing = core.crossing(event)
            time = records[event.record].record.time
            self.guard.require(time, state.runs[crossing.r].nodes[crossing.k].name)
            self.recorder.note(state, crossing, loads.passing_event(state, crossing), time)
        self.recorder.entries += records[done:]
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


def _return_to(state: LineState, record: Record) -> None:
    """Takes a state back to a record of it."""
    state.point.x[:], state.point.z[:] = record.x, record.z
    state.passed = [p - run.loads.first for p, run in zip(record.passed, state.runs, strict=True)]
    state.write_slots()
