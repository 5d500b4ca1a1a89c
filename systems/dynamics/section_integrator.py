"""Integration by sections: the drives move by themselves, and a section is solved only where a load crosses.

While no limit of a drive is active, its motion does not depend on the tensions (`drive_trajectories`): the travel of
the drives is known over a whole window, and the sections between them are independent of each other.
"""

from __future__ import annotations

import numpy as np

from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.chattering import ChatterGuard
from ropeway.systems.dynamics.line_stepper import LEAST_STEP, LONGEST_STEP, LineMotion, LineStepper
from ropeway.systems.dynamics.load_events import LoadEvents
from ropeway.systems.dynamics.recorder import Recorder
from ropeway.systems.solvers.drive_trajectories import NODES, Window, drives_of
from ropeway.systems.statics.line_state import LineState

_SHORT_WINDOW = 1e-3
"""Window [s] of the drives' motion that is not shortened where a polynomial does not follow it."""

_EARLY, _INSIDE, _LATE = np.array([2, 4, 6]), np.array([4, 6, 8]), np.array([8, 10])
"""Those of a window's points at which limits are checked: in its first half, within it, in its second half."""


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
        window = drives.window(line.state.point, end - line.time, motion.x, slope)
        while np.any(window.unresolved > line.tolerance * line.state.model.x.nominals) and window.h > _SHORT_WINDOW:
            window = drives.window(line.state.point, window.h / 2.0, motion.x, slope)
        end = window.start + window.h
        tangent = line.state.point.z + np.outer(NODES[_EARLY] * window.h, motion.z)
        if not drives.alone(window, line.state.point, slope, _EARLY, tangent):
            return None
        return self.attempt(window, end, motion, stop)

    def attempt(self, window: Window, end: float, motion: LineMotion, stop: float) -> LineMotion | None:
        """Advances through a window, or, where loads cross before the time that rates predict, a part of it. None, and
        the line is unchanged, where a limit of a drive is active."""
        line, begin = self.line, self.line.time
        saved, checkpoint = line.state.copy(), self.recorder.checkpoint()
        overrun = bool(loads.overrun(line.state, set()))
        while end > begin:
            try:
                done = self._recording(window, end, motion, stop, strict=not overrun and end - begin > LEAST_STEP)
                if done is not None and self.stayed_alone(window, saved, done):
                    return done
                end = begin
            except UnforeseenError:  # over a shorter step rates predict it
                end = (begin + end) / 2.0
            self.guard.require(begin)
            line.state = saved.copy()
            self.recorder.rewind(checkpoint)
        return None

    def stayed_alone(self, window: Window, start: LineState, motion: LineMotion) -> bool:
        """Whether no limit of a drive has been active since the window's start; `motion`: the rates now. Between the
        two the algebraic variables are between the chord and the nearer of both tangents, of which that there has been
        checked."""
        line, begin, now = self.line, start.point, self.line.state.point
        if not line.state.standing() and not drives_of(line.state.model, line.tolerance).decoupled(now):
            return False
        duration = max(now.t - begin.t, 1e-9)
        inside, late = (nodes[NODES[nodes] * window.h < duration - 1e-9] for nodes in (_INSIDE, _LATE))
        chord = begin.z + np.outer(NODES[inside] * window.h / duration, now.z - begin.z)
        tangent = now.z + np.outer(NODES[late] * window.h - duration, motion.z)
        which, slope = np.concatenate([inside, late]), (now.u - begin.u) / duration
        drives = drives_of(start.model, line.tolerance)
        return drives.alone(window, begin, slope, which, np.concatenate([chord, tangent]))

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
            alone = drives.decoupled(line.state.point)
            motion, crossed = self.events.cross(now, motion, stop, exact=False), line.time
            if not alone or not drives.decoupled(line.state.point):
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
