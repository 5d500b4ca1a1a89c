"""Integration of the whole line: IDAS from event to event, where a limit of a drive is active or a load stands on a
support."""

from __future__ import annotations

import numpy as np

from ropeway.components.errors import SimulationError
from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.chattering import ChatterGuard
from ropeway.systems.dynamics.line_stepper import LEAST_STEP, LONGEST_STEP, LineMotion, LineStepper
from ropeway.systems.dynamics.load_events import LoadEvents
from ropeway.systems.statics.line_state import LineState

_STANDING_STEP = 0.02
"""Longest step [s] while a load stands on a support."""

_DEVIATION, _CHECKED_STEP = 0.05, 0.05
"""Largest deviation of the states from the trapezoidal prediction, relative to nominal, in steps longer than this [s]:
beyond it the rope may have turned twice in the step."""

_LOCATE_TRIALS = 30


class LineIntegrator:
    """Advances a line with all its equations at once."""

    def __init__(self, line: LineStepper, events: LoadEvents, guard: ChatterGuard) -> None:
        self.line = line
        self.events = events
        self.guard = guard
        self._longest = LONGEST_STEP

    def advance(self, motion: LineMotion, stop: float) -> LineMotion:
        """Advances the line to the next event or to `stop`, with an entry at each time of the grid before; returns its
        rates there. Raises EquilibriumError, SimulationError."""
        line, recorder = self.line, self.events.recorder
        before = line.state.copy() if recorder.due(line.time + LONGEST_STEP) else None
        moved = self._advance(motion, stop)
        if before is not None:  # times of the grid do not steer the integration: they are reached beside it
            line.state, end = before, line.state
            for time in recorder.due(end.point.t):
                motion = self._integrate(time - line.time, motion, stop)
                recorder.record_due(line.state)
            line.state = end
        return moved

    def _integrate(self, h: float, motion: LineMotion, stop: float) -> LineMotion:
        line = self.line
        return line.advance(h, motion, stop) if h <= line.tiny else line.integrate(h, motion, stop)

    def _advance(self, motion: LineMotion, stop: float) -> LineMotion:
        """To the next event, or over one step."""
        line = self.line
        coming = loads.next_crossing(line.state, motion.travel)
        h = min(stop - line.time, self._longest, np.inf if coming is None else max(coming.time, 0.0))
        standing = bool(line.state.standing())
        h = min(h, _STANDING_STEP) if standing else h
        before, start, overrun = line.state.copy(), motion, bool(loads.overrun(line.state, set()))
        while True:
            motion = self._integrate(h, motion, stop)
            if standing and self.events.release(before, stop):
                return line.solve(stop)
            if h > _CHECKED_STEP and self._deviates(before, start, motion):
                self._longest = h / 2.0
            else:
                self._longest = min(2.0 * self._longest, LONGEST_STEP)
                coming = loads.next_crossing(line.state, motion.travel)
                if coming is not None and coming.time <= max(0.0, min(line.short, stop - line.time)):
                    first, motion = self._locate(before, coming, motion, stop)
                    return self.events.cross(first, motion, stop, exact=True)
                if overrun or h <= LEAST_STEP or not loads.overrun(line.state, set()):
                    return motion
            # A load has passed a support and come back, or may have: a shorter step shows it.
            self.guard.require(before.point.t)
            line.state, h, motion = before.copy(), h / 2.0, start

    def _deviates(self, before: LineState, start: LineMotion, motion: LineMotion) -> bool:
        """Whether the states are far from what their rates at both ends of the step predict."""
        moved = self.line.state.point.x - before.point.x
        predicted = (self.line.time - before.point.t) * (start.x + motion.x) / 2.0
        return bool(np.any(np.abs(moved - predicted) > _DEVIATION * self.line.state.model.x.nominals))

    def _locate(
        self, before: LineState, first: loads.Crossing, motion: LineMotion, stop: float
    ) -> tuple[loads.Crossing, LineMotion]:
        """Advances the state to the time at which the first load stands on its support."""
        line = self.line
        early, late = 0.0, np.inf
        for _ in range(_LOCATE_TRIALS):
            if abs(first.gap) <= loads.NEAR * line.state.span_scale[first.r]:
                return first, motion
            passed = line.time - before.point.t
            early, late = (early, min(late, passed)) if first.gap < 0.0 else (max(early, passed), late)
            if abs(first.time) > line.short:  # far overrun: integrate again from before, to the time predicted
                h = passed + first.time
                if not early < h < late and np.isfinite(late):  # the rate has changed in between: bisect
                    h = (early + late) / 2.0
                line.state = before.copy()
                motion = line.advance(h, line.solve(stop), stop)
            else:
                motion = line.advance(first.time, motion, stop)
            coming = loads.next_crossing(line.state, motion.travel)
            if coming is None:
                break
            first = coming
        raise SimulationError(
            f"Cannot locate the crossing of {line.state.runs[first.r].nodes[first.k].name!r}",
            "The rope hardly moves there; look at its speed",
            line.time,
        )
