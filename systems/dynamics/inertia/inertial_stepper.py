"""A line with inertia between two stops: IDAS from event to event, where loads come near supports and cross them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components.errors import EquilibriumError, SimulationError
from ropeway.systems.dynamics.chattering import ChatterGuard, FinalError
from ropeway.systems.dynamics.inertia import support_zones as zones
from ropeway.systems.dynamics.inertia.inertial_line import InertialLine
from ropeway.systems.dynamics.inertia.inertial_state import tieable
from ropeway.systems.dynamics.line_stepper import LineMotion, Signal
from ropeway.systems.dynamics.recorder import Recorder
from ropeway.systems.statics.line_state import LineState

_LONGEST = 0.5
"""Longest stretch [s] of a line whose loads can come near supports."""
_SHORTEST, _FAILED = 1e-4, 1e-5
"""Shortest step to an event, and shortest stretch that is tried when a longer one has failed [s]."""
_OVERRUN = 3e-3
"""How far past its threshold an event may be [m]."""
_TRIALS = 40
_COUNTS = (2, 5, 10, 20, 50, 100)
"""Numbers of points that one stretch can give."""


class InertialStepper:
    """A line with inertia that moves: `line` has its state and signals; `recorder` gets both sides of each event."""

    disturbed = False
    """It is solved again at once after each change."""
    integrates = False
    """It stops at each record."""
    line_kind: type[InertialLine] = InertialLine

    def __init__(
        self, state: LineState, signals: Sequence[Signal], tolerance: float, recorder: Recorder | None = None
    ) -> None:
        self.line = self.line_kind(state, signals, tolerance)
        self.recorder = Recorder() if recorder is None else recorder
        self.guard = ChatterGuard(sum(len(run.nodes) for run in state.runs))
        self._ties = any(tieable(state.model, r).any() and len(run.loads.place) > 0 for r, run in enumerate(state.runs))
        self._motion: LineMotion | None = None

    @property
    def state(self) -> LineState:
        """The state of the line."""
        return self.line.state

    def disturb(self) -> None:
        """Declares that something else than time has changed the line: it is solved again."""
        self._motion = self.line.solve(self.line.time)

    def run_along(self, stops: Sequence[float]) -> int:
        """Advances through the first of some evenly spaced stops with an entry at each, as far as it can do so without
        an event and in one stretch; returns how many they are. Inputs do not bend before the last one. Raises
        EquilibriumError, SimulationError."""
        if len(stops) < 2 or self._motion is None:
            return 0
        line, every = self.line, stops[1] - stops[0]
        if not np.isclose(stops[0] - line.time, every, rtol=1e-9):
            return 0
        events = self._coming(self._motion)
        longest = _LONGEST if self._ties else np.inf
        free = min([longest, *(max(e.gap, 0.0) / e.speed - _SHORTEST for e in events)])
        count = max((n for n in _COUNTS if n <= len(stops) and n * every <= free), default=0)
        if count == 0:
            return 0
        begin = line.state.copy()
        try:
            points, motion = line.integrate_along(stops[count - 1] - line.time, count, self._motion, stops[count - 1])
            line.state.require_rope("End the run before, or turn the drive")
            late = any(e.gap < -_OVERRUN for e in self._coming(motion))
        except FinalError:
            raise
        except (EquilibriumError, SimulationError):
            late = True
        if late:  # it is tried again from stop to stop
            line.state = begin
            return 0
        for point in points:
            line.state.point = point
            self.recorder.record(line.state, on_grid=True)
        self._motion = motion
        return count

    def settle(self, stop: float) -> None:
        """Solves the line where a run starts; inputs do not bend before `stop` [s]. Raises EquilibriumError."""
        self.line.solve(stop)

    def run_to(self, stop: float) -> None:
        """Advances to `stop` [s], before which no input bends and nothing acts on the line; solved there. Raises
        EquilibriumError, SimulationError."""
        line = self.line
        line.set_time(line.time)
        motion = line.solve(stop)
        while line.time < stop - 1e-9:
            events = self._coming(motion)
            if due := zones.due(events):
                motion = self._act(due, motion, stop)
                continue
            longest = min(stop - line.time, _LONGEST if self._ties else np.inf)
            ahead = min((max(e.gap, 0.0) / e.speed for e in events), default=np.inf)
            motion = self._advance(min(longest, max(ahead, _SHORTEST)), motion, stop, events)
        line.set_time(stop)
        self._motion = motion
        self.state.require_rope("End the run before, or turn the drive")

    def _coming(self, motion: LineMotion) -> list[zones.ZoneEvent]:
        return zones.coming(self.state, motion.travel) if self._ties else []

    def _act(self, due: Sequence[zones.ZoneEvent], motion: LineMotion, stop: float) -> LineMotion:
        """Applies events that are due, and solves the line. Raises EquilibriumError, SimulationError."""
        line, names = self.line, self.state.runs[due[0].r].nodes
        self.guard.require(line.time, names[due[0].k].name)
        self.recorder.record(self.state)
        if any(event.what == zones.LEAVE for event in due):
            motion = line.solve_rates(stop)
        crossed = zones.apply(self.state, due, (motion.x, motion.z))
        for crossing, what in crossed:
            self.recorder.note(self.state, crossing, what)
        motion = line.solve(stop)
        self.recorder.record(self.state)
        return motion

    def _advance(self, h: float, motion: LineMotion, stop: float, events: Sequence[zones.ZoneEvent]) -> LineMotion:
        """Advances by at most `h` seconds, not past an event. Raises EquilibriumError, SimulationError."""
        line, begin = self.line, self.line.state.copy()
        gaps = {e[:4]: e.gap for e in events}
        for _ in range(_TRIALS):
            try:
                moved = line.integrate(h, motion, stop)
            except FinalError:
                raise
            except (EquilibriumError, SimulationError):
                self.guard.require(begin.point.t)
                if h / 2.0 < _FAILED:
                    raise
                line.state, h = begin.copy(), h / 2.0
                continue
            late = [e for e in self._coming(moved) if e.gap < -_OVERRUN and h > _SHORTEST]
            if not late:
                return moved
            shares = [_share(gaps.get(e[:4]), e.gap) for e in late]
            line.state, h = begin.copy(), max(h * min(shares), _SHORTEST)
        return line.integrate(h, motion, stop)


def _share(before: float | None, after: float) -> float:
    """Share of a step at which a gap vanishes, from those before and after it."""
    if before is None or before <= 0.0:
        return 0.5
    return float(np.clip((before + 2e-4) / (before - after), 0.05, 0.95))
