"""Integration by sections: the drives move by themselves, and a section is solved only where a load crosses.

While no limit of a drive is active, its motion does not depend on the tensions (`drive_trajectories`): the travel of
the drives is known over a whole window, and the sections between them are independent of each other.
"""

from __future__ import annotations

import numpy as np

from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.chattering import ChatterGuard
from ropeway.systems.dynamics.cubic import between
from ropeway.systems.dynamics.line_stepper import LEAST_STEP, LONGEST_STEP, LineMotion, LineStepper
from ropeway.systems.dynamics.load_events import LoadEvents
from ropeway.systems.dynamics.recorder import Recorder
from ropeway.systems.solvers.block_newton import blocks_of
from ropeway.systems.solvers.drive_trajectories import NODES, Drives, Window, drives_of
from ropeway.systems.statics.line_state import LineState

_SHORT_WINDOW = 1e-3
"""Window [s] of the drives' motion that is not shortened where a polynomial does not follow it."""

_CHECKED = np.arange(2, len(NODES), 2)
"""Those of a window's points at which limits are checked."""
_LEAST_FREE = 0.02
"""Window [s] below which a drive that nears a limit is integrated with the line."""


class UnforeseenError(Exception):
    """A load has crossed a support before the time that rates predict."""


class SectionIntegrator:
    """Advances a line section by section."""

    def __init__(self, line: LineStepper, events: LoadEvents, guard: ChatterGuard, recorder: Recorder) -> None:
        self.line = line
        self.events = events
        self.guard = guard
        self.recorder = recorder

    def advance(self, motion: LineMotion, stop: float) -> LineMotion | None:
        """Advances the line towards `stop`. None, and the line is unchanged, where a limit of a drive is active or a
        load stands on a support."""
        line = self.line
        drives = drives_of(line.state.model, line.tolerance)
        if line.state.standing() or not drives.decoupled(line.state.point):
            return None
        slope = line.slope(stop)
        end = min(stop, line.time + LONGEST_STEP) if drives.ties else stop
        window = self._window(drives, end - line.time, motion, slope)
        return None if window is None else self.attempt(window, window.start + window.h, motion, stop)

    def _window(self, drives: Drives, h: float, motion: LineMotion, slope: np.ndarray) -> Window | None:
        """The drives' motion over `h` seconds or less. They are moved with the algebraic variables as they are now, and
        must be free with these: None where they soon are not."""
        line, point = self.line, self.line.state.point
        now = np.tile(point.z, (len(_CHECKED), 1))
        while True:
            window = drives.window(point, h, motion.x, slope)
            if drives.alone(window, point, slope, _CHECKED, now):
                coarse = bool(np.any(window.unresolved > line.tolerance * line.state.model.x.nominals))
                if not coarse or h <= _SHORT_WINDOW:
                    return window
            elif h <= _LEAST_FREE:
                return None
            h /= 2.0

    def attempt(self, window: Window, end: float, motion: LineMotion, stop: float) -> LineMotion | None:
        """Advances through a window, or, where loads cross before the time that rates predict, a part of it. None, and
        the line is unchanged, where a limit of a drive is active."""
        line, begin = self.line, self.line.time
        saved, checkpoint = line.state.copy(), self.recorder.checkpoint()
        overrun = bool(loads.overrun(line.state, set()))
        while end > begin:
            try:
                done = self._recording(window, end, motion, stop, strict=not overrun and end - begin > LEAST_STEP)
                if done is not None and self.stayed_alone(window, saved, motion, done):
                    return done
                end = begin
            except UnforeseenError:  # over a shorter step rates predict it
                end = (begin + end) / 2.0
            self.guard.require(begin)
            line.state = saved.copy()
            self.recorder.rewind(checkpoint)
        return None

    def stayed_alone(self, window: Window, start: LineState, first: LineMotion, motion: LineMotion) -> bool:
        """Whether no limit of a drive has been active since the window's start; `first`: the rates there, `motion`: the
        rates now. Between the two the algebraic variables follow a cubic polynomial; where loads have crossed, their
        rates have jumped, and they are near the tangents at its ends and the chord between."""
        line, begin, now = self.line, start.point, self.line.state.point
        if not line.state.standing() and not drives_of(line.state.model, line.tolerance).decoupled(now):
            return False
        duration = max(now.t - begin.t, 1e-9)
        inside = _CHECKED[NODES[_CHECKED] * window.h < duration - 1e-9]
        passed = (NODES[inside] * window.h)[:, None]
        part = passed / duration
        if np.array_equal(begin.d, now.d):
            z = between(begin.z, first.z, now.z, motion.z, duration, part)
        else:
            z = begin.z + part * (now.z - begin.z)
            z = np.where(part < 0.2, begin.z + passed * first.z, z)
            z = np.where(part > 0.8, now.z + (passed - duration) * motion.z, z)
        drives = drives_of(start.model, line.tolerance)
        return drives.alone(window, begin, (now.u - begin.u) / duration, inside, z)

    def _recording(
        self, window: Window, end: float, motion: LineMotion, stop: float, *, strict: bool
    ) -> LineMotion | None:
        """As `through`, with an entry at each time of the grid before the end."""
        found: LineMotion | None = motion
        for time in self.recorder.due(end):
            found = self.through(window, time, motion, stop, strict=strict)
            if found is None or self.line.time < time:
                return found
            motion = found
            self.recorder.record_due(self.line.state)
        return self.through(window, end, motion, stop, strict=strict) if self.line.time < end else found

    def through(
        self, window: Window, end: float, motion: LineMotion, stop: float, *, strict: bool
    ) -> LineMotion | None:
        """To the `end` of a window, crossing by crossing; None where a limit is active. strict: raises
        UnforeseenError."""
        line = self.line
        drives = drives_of(line.state.model, line.tolerance)
        crossed = -np.inf
        while (coming := loads.next_crossing(line.state, motion.travel)) is not None:
            if coming.time > end - line.time:
                break
            motion = self._follow(window, line.time + coming.time, motion)
            touched = line.sections_beside([coming])
            motion = line.correct(motion, stop, touched)
            now = loads.gap_of(line.state, coming, motion.travel)
            if abs(now.gap) > loads.NEAR * line.state.span_scale[now.r]:
                if now.time > end - line.time:
                    continue
                # The section is solved here: one short step brings the load onto its support.
                motion = self._follow(window, line.time + now.time, motion)
                if abs(now.time) > line.tiny:
                    motion = line.correct(motion, stop, touched)
                    now = loads.gap_of(line.state, coming, motion.travel)
                    if abs(now.gap) > loads.NEAR * line.state.span_scale[now.r]:
                        continue
            if strict and line.time < crossed - LEAST_STEP:
                raise UnforeseenError
            # A crossing can activate a limit that is inactive again before the stop.
            alone, before = drives.decoupled(line.state.point, touched), line.state.point.z.copy()
            motion, crossed = self.events.cross(now, motion, stop, exact=False), line.time
            drives = drives_of(line.state.model, line.tolerance)  # a span may hold more loads than before
            jumped = blocks_of(line.state.model).of[line.state.point.z != before] if drives.ties else before[:0]
            if not alone or not drives.decoupled(line.state.point, np.unique(jumped).tolist()):
                return None
            if line.state.standing():
                return line.solve(stop)
        motion = line.correct(self._follow(window, end, motion), stop)
        if strict and loads.overrun(line.state, set()):
            raise UnforeseenError
        return motion

    def _follow(self, window: Window, time: float, motion: LineMotion) -> LineMotion:
        """Takes the states from the drives' trajectories, and the algebraic variables along a straight line."""
        line = self.line
        line.state.point.x[:], x_rate = window.at(time)
        line.state.point.z[:] += (time - line.time) * motion.z
        line.set_time(time)
        return line.motion_at(x_rate, motion.z)
