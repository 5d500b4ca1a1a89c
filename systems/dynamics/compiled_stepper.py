"""A line whose sections are solved in the compiled core."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.line_stepper import LineMotion, LineStepper
from ropeway.systems.solvers.compiled_line import CompiledLine, PointSolver, compiled_line
from ropeway.systems.solvers.drive_trajectories import NODES, Window
from ropeway.systems.solvers.prescribed_states import commanded_of
from ropeway.systems.statics.stability import require_followed


class CompiledStepper(LineStepper):
    """A line whose sections the core solves. Drives that follow their commanded speeds are known functions of time;
    others are integrated by IDAS: by themselves, and with the whole line while one is at a limit."""

    @property
    def commanded(self) -> bool:
        """Whether all drives follow their commanded speeds."""
        return len(commanded_of(self.state.model).rows) == len(self.state.model.x)

    @property
    def core(self) -> CompiledLine:
        """The core of the present model, which grows with the loads in a span."""
        return compiled_line(self.state.model)

    def solver(self, x_rate: np.ndarray, stop: float) -> PointSolver:
        """The present point in the core."""
        return PointSolver(self.core, self.state.point, self.core.used(self.state.passed), x_rate, self.slope(stop))

    def solve(self, stop: float) -> LineMotion:
        if not self.commanded:  # their rates depend on the solution
            self.core.solve_point(self.state.point, self.state.passed)
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
        if not self.commanded:
            return super().integrate(h, motion, stop)
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
