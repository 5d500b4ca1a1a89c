"""A line whose sections are solved in the compiled core."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.core_motion import Bends, CoreMotion
from ropeway.systems.dynamics.line_stepper import LineMotion, LineStepper
from ropeway.systems.solvers.compiled_line import CompiledLine, PointSolver, compiled_line


class CompiledStepper(LineStepper):
    """A line whose sections the core solves, and whose drives it moves, unless they share a power unit."""

    _moving: CoreMotion | None = None

    @property
    def core(self) -> CompiledLine:
        """The core of the present model, which grows with the loads in a span."""
        return compiled_line(self.state.model)

    @property
    def moving(self) -> CoreMotion:
        """The core for the present model and loads."""
        if self._moving is None or not self._moving.fits(self.state):
            self._moving = CoreMotion(self.core, self.state)
        return self._moving

    def solver(self, x_rate: np.ndarray, stop: float) -> PointSolver:
        """The present point in the core."""
        return PointSolver(self.core, self.state.point, self.core.used(self.state.passed), x_rate, self.slope(stop))

    def solve(self, stop: float) -> LineMotion:
        self.core.solve_point(self.state.point, self.state.passed)  # rates can depend on the solution
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

    def rates(self) -> np.ndarray:
        core, state = self.moving, self.state
        if core.drives is None:
            return super().rates()
        core.at(state, np.zeros(len(state.point.x)), np.zeros(len(state.point.z)), np.zeros(len(state.point.u)))
        return core.rates()

    def bends(self, last: float) -> Bends:
        """Where inputs bend from now to a time [s]."""
        t, size = self.time, len(self.signals)
        coming = self.breaks[self.breaks > t + 1e-12 * max(1.0, t)]
        count = int(np.searchsorted(coming, last, side="right"))
        times = np.concatenate([[t], coming[: count + 1]])
        values = np.array([self.state.point.u, *(self.inputs_at(time) for time in times[1:].tolist())])
        slope = np.vstack([np.diff(values, axis=0) / np.diff(times)[:, None], np.zeros((1, size))])
        return Bends(times[1 : count + 1], values[1 : count + 1], slope[: count + 1])
