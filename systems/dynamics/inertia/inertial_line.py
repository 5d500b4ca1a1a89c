"""Steps of a line with inertia between two events, by IDAS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ropeway.components.errors import SimulationError
from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.chattering import ChatterGuard
from ropeway.systems.dynamics.inertia.peaks import Path
from ropeway.systems.dynamics.inertia.solved_stretch import SolvedStretch
from ropeway.systems.dynamics.inertia.zone_bounds import Bounds
from ropeway.systems.dynamics.line_stepper import LineMotion, LineStepper, Signal
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.solvers.idas import OSCILLATING, Idas
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.points import VECTORS, Point
from ropeway.systems.statics.line_state import LineState

_FIRST, _SHORTEST = 0.5, 1e-5
"""First stretch of a run, and the shortest that is tried when a longer one has failed [s]."""
_MARGIN, _FARTHER = 0.01, 1.1
"""A stretch goes past the next event by this time [s] and by this factor: when it is due follows from its points."""
_AIMED, _ACCEPTED, _GROWTH = 10.0, 100.0, 10.0
"""Errors of interpolation that are aimed at and accepted, as multiples of the tolerance of the states, and the largest
growth of stretches."""

_SOLVED, _RESIDUALS = 1e-6, (1e-11, 1e-10)
"""Scaled residual of a root as a share of the tolerance of the states, and its limits."""
_VALUES, _COUNTS = 100_000, (50, 200)
"""States at all points of a stretch, and least and largest number of points."""


class InertialLine(LineStepper):
    """A line with inertia and the signals of its inputs; those that are rates of others follow from these. `path`: how
    it has moved last."""

    path: Path
    _ahead: SolvedStretch | None
    _solved: Point | None = None
    """The point that was solved last, which has the rates `_motion`."""
    _motion: LineMotion

    def __init__(self, state: LineState, signals: Sequence[Signal], tolerance: float) -> None:
        self.guard = ChatterGuard(sum(len(run.nodes) for run in state.runs))
        self._longest = _FIRST
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
        """Solves the algebraic variables, unless they are solved. Their rates, which IDAS does not need and which can
        be infinite where a wind rises, are given as zero: see `solve_rates`. Raises EquilibriumError."""
        if self._solved is None or not _equal(self._solved, self.state.point):
            enough = float(np.clip(_SOLVED * self.tolerance, *_RESIDUALS))
            newton_of(self.state.model).solve(self.state.point, enough=enough)
            self._solved, self._motion = self.state.point.copy(), self.motion(np.zeros_like(self.state.point.z))
        return self._motion

    def solve_rates(self, stop: float) -> LineMotion:
        """As `solve`, with the rates of the algebraic variables."""
        return super().solve(stop)

    def move(self, stop: float, quiet: float, motion: LineMotion, bounds: Bounds) -> LineMotion:
        """Moves the line to `stop` [s] or to the first of some bounds, from its rates. Nothing but time changes it
        before `quiet` [s], up to which inputs are linear. Raises EquilibriumError, SimulationError."""
        ahead = self._ahead
        if ahead is None or not ahead.continues(self.state.point):
            ahead = self._ahead = self._integrated(quiet, motion, bounds)
        t = min(stop, ahead.end, ahead.time_of_event(self.time, bounds))
        self.path = ahead.path(self.time, t)
        x, z = ahead.at(t)
        self.state.point = replace(self.state.point, x=x, z=z, u=self.inputs_at(t), t=t)
        return self.solve(stop)

    def drive(self, signals: Sequence[Signal]) -> None:
        super().drive(signals)
        self._ahead = None

    def _integrated(self, quiet: float, motion: LineMotion, bounds: Bounds) -> SolvedStretch:
        """Integrates a stretch: to `quiet` [s], a little past the next bound, or as far as its points are near enough
        to each other."""
        point = self.state.point.copy()
        left = quiet - point.t
        h = left / np.ceil(left / self._longest)
        h = min(h, _MARGIN + _FARTHER * bounds.time_left(point.x, motion.x))
        integrator = oscillating_idas_of(self.state.model, self.tolerance)
        while True:
            try:
                x, z = integrator.along(point, h, motion.x, motion.z, self.slope(quiet))
            except SimulationError:
                self.guard.require(point.t)
                if h / 2.0 < _SHORTEST:
                    raise
                h = self._longest = h / 2.0
                continue
            found = SolvedStretch(point, h, np.vstack([point.x, x]), np.vstack([point.z, z]))
            error = float(np.max(found.error / self.state.model.x.nominals)) / self.tolerance
            self._longest = h * min(0.8 * max(error / _AIMED, 1e-30) ** (-1.0 / 6.0), _GROWTH)
            if error <= _ACCEPTED:
                return found
            h = self._longest


@kept_with_model
def oscillating_idas_of(model: Model, tolerance: float) -> Idas:
    """The integrator of a model with inertia. It gives more points of small models: they cost less, and the stretches
    are longer."""
    return Idas(model, tolerance, OSCILLATING, int(np.clip(_VALUES // max(len(model.x), 1), *_COUNTS)))


def _equal(a: Point, b: Point) -> bool:
    return a.t == b.t and all(np.array_equal(a.vector(kind), b.vector(kind)) for kind in VECTORS)


def _rate_after(signal: Signal, t: float) -> float:
    """Rate of a signal just after a time [per s]."""
    if not isinstance(signal, Schedule):
        return 0.0
    breaks = signal.breaks()
    later = breaks[breaks > t + 1e-9 * max(1.0, t)]
    return float((signal.at(float(later[0])) - signal.at(t)) / (later[0] - t)) if len(later) else 0.0
