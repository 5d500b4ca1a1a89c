"""A line with inertia in the compiled core: it moves there from event to event; events are the same as with IDAS."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components.errors import SimulationError
from ropeway.systems.dynamics.inertia import support_zones as zones
from ropeway.systems.dynamics.inertia.inertial_line import InertialLine
from ropeway.systems.dynamics.inertia.inertial_stepper import InertialStepper
from ropeway.systems.dynamics.line_stepper import LineMotion, Signal
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.native.inertial_library import FAILURES, SystemRun
from ropeway.systems.solvers.kernels.inertial_core import CorePoint, InertialCore, inertial_core
from ropeway.systems.statics.line_state import LineState

_FIRST, _SHORTEST = 0.01, 1e-9
"""Step that is tried first, and shortest step [s]."""
_BEHIND = 1e-4
"""Travel after which an event is due that was due before but for the direction of the rope [m]."""


class Bounds:
    """What loads come to as the line moves: until then the `watched` states, travels of the rope, are between `low` and
    `high` [m]."""

    def __init__(self, state: LineState) -> None:
        self._thresholds, self._travels = zones.thresholds(state), self._read(state)
        travels = [layout.travel.state for layout in state.model.layouts]
        self.watched = np.unique(np.concatenate([own[own >= 0] for own in travels])).astype(np.int32)
        gaps = np.full((2, len(state.point.x)), np.inf)
        for t in self._thresholds:
            gap = np.where(t.gap > zones.NEAR, t.gap, _BEHIND)[t.on]
            np.minimum.at(gaps[int(t.side < 0.0)], travels[t.r][t.k[t.on]], gap)
        self.high = state.point.x[self.watched] + gaps[0, self.watched]
        self.low = state.point.x[self.watched] - gaps[1, self.watched]

    @staticmethod
    def _read(state: LineState) -> list[np.ndarray]:
        return state.model.travels(state.point.x, state.point.z)

    def due(self, state: LineState, rates: Sequence[np.ndarray]) -> list[zones.ZoneEvent]:
        """The events that are due, one for each load, of a line that has moved without any; `rates` of travel of each
        run [m/s]."""
        moved = [now - then for now, then in zip(self._read(state), self._travels, strict=True)]
        now = [t._replace(gap=t.gap - t.side * moved[t.r][t.k]) for t in self._thresholds]
        return zones.due(zones.approached(now, rates, zones.NEAR))


class CompiledInertialLine(InertialLine):
    """A line with inertia that the core solves and moves. Raises CompiledError where it does not fit, CompilerError,
    WriteError."""

    def __init__(self, state: LineState, signals: Sequence[Signal], tolerance: float) -> None:
        super().__init__(state, signals, tolerance)
        self._step, self._point = _FIRST, CorePoint(self.core)

    @property
    def core(self) -> InertialCore:
        """The core of the present model, which grows with the loads in a span."""
        return inertial_core(self.state.model)

    def point(self, stop: float) -> CorePoint:
        """The present point in the core."""
        stop_if_interrupted()
        if self._point.core is not self.core:
            self._point = CorePoint(self.core)
        self._point.put(self.state.point, self.slope(stop))
        return self._point

    def solve(self, stop: float) -> LineMotion:
        """Solves the algebraic variables; returns all rates at the present point. Raises EquilibriumError."""
        start, found = self.state.point.z.copy(), self.point(stop)
        if found.solve():
            self.state.point.z[:] = start
            return super().solve_rates(stop)
        return self.motion_at(found.x_rate.copy(), found.z_rate.copy())

    def solve_rates(self, stop: float) -> LineMotion:
        """The same: the core has all rates at once."""
        return self.solve(stop)

    def move(self, stop: float, bounds: Bounds) -> LineMotion:
        """Moves the line to `stop` [s] or to the first of some bounds. Raises EquilibriumError, SimulationError."""
        time, found = self.time, self.point(stop)
        run = SystemRun(
            stop=stop - time,
            h=self._step,
            tolerance=self.tolerance,
            shortest=_SHORTEST,
            watches=len(bounds.watched),
            watched=bounds.watched.ctypes.data,
            low=bounds.low.ctypes.data,
            high=bounds.high.ctypes.data,
        )
        failed = found.move(run)
        if failed:
            name = self.state.model.r.names[found.point.worst]
            raise SimulationError(
                f"The compiled core failed at {time + run.time:.9g} s: {FAILURES[failed]} (worst: {name})",
                "Check the last result for a slack rope or a load that stands on a support; or take a larger tolerance",
                time,
            )
        self._step = run.h
        inputs = self.state.point.u.copy()
        self.set_time(stop if run.hit < 0 else time + run.time)
        if np.abs(self.state.point.u - inputs).max(initial=0.0) > 1e-12:  # the rates of inputs jump here
            return self.solve(stop)
        return self.motion_at(found.x_rate.copy(), found.z_rate.copy())


class CompiledInertialStepper(InertialStepper):
    """As `InertialStepper`, with its line in the compiled core."""

    line: CompiledInertialLine
    line_kind = CompiledInertialLine

    def run_along(self, stops: Sequence[float]) -> int:
        """Advances through evenly spaced stops with an entry at each; returns how many they are. Inputs do not bend
        before the last one. Raises EquilibriumError, SimulationError."""
        if stops:
            begin = self._begin(stops[-1])
            for stop in stops:
                begin = self._advance_to(stop, *begin)
                self.recorder.record(self.state, on_grid=True)
        return len(stops)

    def run_to(self, stop: float) -> None:
        """Advances to `stop` [s], before which no input bends and nothing acts on the line; solved there. Raises
        EquilibriumError, SimulationError."""
        self._advance_to(stop, *self._begin(stop))

    def _begin(self, stop: float) -> tuple[LineMotion, Bounds]:
        """The rates at the present time, and what loads come to."""
        self.line.set_time(self.line.time)
        return self.line.solve(stop), Bounds(self.state)

    def _advance_to(self, stop: float, motion: LineMotion, bounds: Bounds) -> tuple[LineMotion, Bounds]:
        """As `run_to`, from known rates and bounds; returns those at the stop."""
        line = self.line
        while line.time < stop - 1e-9:
            if due := bounds.due(self.state, motion.travel):
                motion = self._act(due, motion, stop)
                bounds = Bounds(self.state)
            else:
                motion = line.move(stop, bounds)
        self._motion = motion
        self.state.require_rope("End the run before, or turn the drive")
        return motion, bounds
