"""Steps of a line with inertia between two events, by IDAS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.line_stepper import LineMotion, LineStepper, Signal
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.solvers.idas import OSCILLATING, Idas
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.line_state import LineState


class InertialLine(LineStepper):
    """A line with inertia and the signals of its inputs; those that are rates of others follow from these."""

    def __init__(self, state: LineState, signals: Sequence[Signal], tolerance: float) -> None:
        index = state.model.u.index
        pairs = [(index[rate], index[of]) for rate, of in state.model.rate_of.items() if rate in index and of in index]
        self._rates = np.array([rate for rate, _ in pairs], dtype=int)
        self._sources = [source for _, source in pairs]
        super().__init__(state, signals, tolerance)

    def inputs_at(self, t: float) -> np.ndarray:
        """Values of all inputs, shape (nu,); rates are those after the time."""
        u = super().inputs_at(t)
        u[self._rates] = [_rate_after(self.signals[source], t) for source in self._sources]
        return u

    def slope(self, stop: float) -> np.ndarray:
        """Rates of the inputs from now to `stop`, which is not after their next break, shape (nu,)."""
        found = super().slope(stop)
        found[self._rates] = 0.0
        return found

    def solve(self, stop: float) -> LineMotion:
        """Solves the algebraic variables. Their rates, which IDAS does not need, are given as zero: see `solve_rates`.
        Raises EquilibriumError."""
        newton_of(self.state.model).solve(self.state.point)
        return self.motion(np.zeros_like(self.state.point.z))

    def solve_rates(self, stop: float) -> LineMotion:
        """As `solve`, with the rates of the algebraic variables."""
        return super().solve(stop)

    def integrate(self, h: float, motion: LineMotion, stop: float) -> LineMotion:
        """Advances the state by `h` seconds. Raises EquilibriumError, SimulationError."""
        return self.integrate_along(h, 1, motion, stop)[1]

    def integrate_along(self, h: float, count: int, motion: LineMotion, stop: float) -> tuple[list[Point], LineMotion]:
        """As `integrate`, without a restart; also returns the solved points at `count` equal parts of the stretch."""
        start = self.state.point
        integrator = oscillating_idas_of(self.state.model, self.tolerance, count)
        xs, zs = integrator.along(start, h, motion.x, motion.z, self.slope(stop))
        points = []
        for i, (x, z) in enumerate(zip(xs, zs, strict=True)):
            t = start.t + h * (i + 1) / count
            self.state.point = replace(start, x=x, z=z, u=self.inputs_at(t), t=t)
            motion = self.solve(stop)
            points.append(self.state.point)
        return points, motion


@kept_with_model
def oscillating_idas_of(model: Model, tolerance: float, count: int) -> Idas:
    """The integrator of a model with inertia, which gives `count` points of a stretch."""
    return Idas(model, tolerance, OSCILLATING, count)


def _rate_after(signal: Signal, t: float) -> float:
    """Rate of a signal just after a time [per s]."""
    if not isinstance(signal, Schedule):
        return 0.0
    breaks = signal.breaks()
    later = breaks[breaks > t + 1e-9 * max(1.0, t)]
    return float((signal.at(float(later[0])) - signal.at(t)) / (later[0] - t)) if len(later) else 0.0
