"""A line with inertia in the compiled core: it moves there from event to event; events are the same as with IDAS."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components.errors import SimulationError
from ropeway.systems.dynamics.cubic import between
from ropeway.systems.dynamics.inertia.inertial_line import InertialLine
from ropeway.systems.dynamics.inertia.inertial_stepper import InertialStepper
from ropeway.systems.dynamics.inertia.peaks import Path
from ropeway.systems.dynamics.inertia.zone_bounds import Bounds
from ropeway.systems.dynamics.line_stepper import LineMotion, Signal
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.native.inertial_library import FAILURES, SystemRun
from ropeway.systems.solvers.kernels.inertial_core import CorePoint, InertialCore, inertial_core
from ropeway.systems.statics.line_state import LineState

_FIRST, _SHORTEST = 0.01, 1e-9
"""Step that is tried first, and shortest step [s]."""


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

    def move(self, stop: float, quiet: float, motion: LineMotion, bounds: Bounds) -> LineMotion:
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
            room=len(found.trace),
            trace=found.trace.ctypes.data,
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
        self.path = _path(found, time, run.steps + 1)
        inputs = self.state.point.u.copy()
        self.set_time(stop if run.time >= run.stop else time + run.time)
        if np.abs(self.state.point.u - inputs).max(initial=0.0) > 1e-12:  # the rates of inputs jump here
            return self.solve(stop)
        return self.motion_at(found.x_rate.copy(), found.z_rate.copy())


def _path(found: CorePoint, begin: float, count: int) -> Path:
    """How a point has moved last from a time [s], by the first rows of its trace, until it moves again."""
    nx, rows = len(found.x_rate), found.trace[:count]
    times, (x, z, rates) = begin + rows[:, 0], np.split(rows[:, 1:], [nx, rows.shape[1] - 1 - nx], axis=1)

    def at(t: float) -> tuple[np.ndarray, np.ndarray]:
        i = int(np.clip(np.searchsorted(times, t, side="right") - 1, 0, count - 2))
        h = float(times[i + 1] - times[i])
        part = (t - times[i]) / h
        return between(x[i], rates[i], x[i + 1], rates[i + 1], h, part), z[i] + part * (z[i + 1] - z[i])

    return Path(times, z, at)


class CompiledInertialStepper(InertialStepper):
    """As `InertialStepper`, with its line in the compiled core."""

    line: CompiledInertialLine
    line_kind = CompiledInertialLine
