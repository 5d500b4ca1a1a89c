"""Steps of a line with inertia between two events, by IDAS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.line_stepper import LineMotion, LineStepper, Signal
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.solvers.idas import OSCILLATING, Idas
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

    def integrate(self, h: float, motion: LineMotion, stop: float) -> LineMotion:
        """Advances the state by `h` seconds. Raises EquilibriumError, SimulationError."""
        point, integrator = self.state.point, oscillating_idas_of(self.state.model, self.tolerance)
        point.x[:], point.z[:] = integrator.advance(point, h, motion.x, motion.z, self.slope(stop))
        # The inputs of a stretch that ends at a break are those before it until the line stops there.
        self.state.point = replace(point, t=point.t + h)
        self.state.point.u[:] = self.inputs_at(self.state.point.t)
        return self.solve(stop)


@kept_with_model
def oscillating_idas_of(model: Model, tolerance: float) -> Idas:
    """The integrator of a model with inertia."""
    return Idas(model, tolerance, OSCILLATING)


def _rate_after(signal: Signal, t: float) -> float:
    """Rate of a signal just after a time [per s]."""
    if not isinstance(signal, Schedule):
        return 0.0
    breaks = signal.breaks()
    later = breaks[breaks > t + 1e-9 * max(1.0, t)]
    return float((signal.at(float(later[0])) - signal.at(t)) / (later[0] - t)) if len(later) else 0.0
