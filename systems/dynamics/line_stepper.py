"""Steps of a line between two events: its sections are solved, its drives integrated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.load_crossings import Crossing
from ropeway.systems.modelling.dae_model import Model, kept_with_model, kept_with_structure
from ropeway.systems.solvers.block_newton import blocks_of
from ropeway.systems.solvers.idas import Idas
from ropeway.systems.solvers.model_functions import Buffered, dense
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.stability import require_followed

Signal = float | Schedule

LEAST_STEP = 1e-5
"""Shortest step [s] that is tried when a longer one has failed."""
LONGEST_STEP = 1.0
"""Longest step [s] between two checks of the drives' limits, and of whether the rope has turned."""


def breaks_of(signals: Sequence[Signal]) -> np.ndarray:
    """Times at which the slope of an input changes [s]."""
    return np.unique(np.concatenate([[], *(s.breaks() for s in signals if isinstance(s, Schedule))]))


class LineMotion(NamedTuple):
    """Rates at a point [per s]: of the states, of the algebraic variables, and of each run's travels."""

    x: np.ndarray
    z: np.ndarray
    travel: list[np.ndarray]


class LineStepper:
    """A line and the signals of its inputs. `state` is advanced in place; `tolerance` is that of the run."""

    short = 5e-3
    """Steps up to this [s] are one explicit step: they bring a load onto its support."""
    bent = 1e-6
    """Where the second-order part of such a step is beyond this, relative to nominal, IDAS integrates."""
    tiny = 1e-4
    """Steps of a section up to this [s] are linear, of drives that move by themselves."""
    linear = 1e-6
    """Steps of the whole line up to this [s] are linear; drives at a limit swing, whose second order is not small."""

    def __init__(self, state: LineState, signals: Sequence[Signal], tolerance: float) -> None:
        self.state = state
        self.tolerance = tolerance
        self.drive(signals)

    def drive(self, signals: Sequence[Signal]) -> None:
        """Sets the signals of all inputs from now on."""
        self.signals = tuple(signals)
        self.breaks = breaks_of(signals)

    @property
    def time(self) -> float:
        """Time of the state [s]."""
        return self.state.point.t

    def set_time(self, t: float) -> None:
        """Sets the time, and the inputs to their values at that time."""
        self.state.point = replace(self.state.point, t=t)
        self.state.point.u[:] = self.inputs_at(t)

    def inputs_at(self, t: float) -> np.ndarray:
        """Values of all inputs, shape (nu,)."""
        if not len(self.breaks):  # all of them constant
            return np.array(self.signals, dtype=float)
        return np.array([s.at(t) if isinstance(s, Schedule) else s for s in self.signals], dtype=float)

    def slope(self, stop: float) -> np.ndarray:
        """Rates of the inputs from now to `stop`, which is not after their next break, shape (nu,)."""
        t = self.state.point.t
        if not len(self.breaks) or stop - t < 1e-9:
            return np.zeros(len(self.signals))
        return (self.inputs_at(stop) - self.state.point.u) / (stop - t)

    def solve(self, stop: float) -> LineMotion:
        """Solves the algebraic variables; returns all rates at the present point. Raises EquilibriumError."""
        state = self.state
        z = newton_of(state.model).solve(state.point, slope=self.slope(stop))
        return self.motion(np.zeros(0) if z is None else z)

    def sections_beside(self, crossings: Sequence[Crossing]) -> list[int]:
        """Numbers of the sections on both sides of crossings."""
        parts, touched = blocks_of(self.state.model), set[int]()
        for c in crossings:
            force = self.state.model.layouts[c.r].force
            touched.update(int(parts.of[z]) for z in force[max(c.k - 1, 0) : c.k + 1])
            if c.k == 0 and self.state.runs[c.r].closed:
                touched.add(int(parts.of[force[-1]]))
        return sorted(touched)

    def solve_sections(self, sections: Sequence[int], motion: LineMotion, stop: float) -> LineMotion:
        """Solves some sections only; the others keep their rates. Raises EquilibriumError."""
        z = motion.z.copy()
        blocks_of(self.state.model).solve(self.state.point, sections, motion.x, self.slope(stop), z)
        return self.motion_at(motion.x, z)

    def correct(self, motion: LineMotion, stop: float, sections: Sequence[int] | None = None) -> LineMotion:
        """Solves some sections, or all, from the values that their rates predict. Raises EquilibriumError, also where
        the solution is far from the prediction."""
        predicted = self.state.point.z.copy()
        motion = self.solve(stop) if sections is None else self.solve_sections(sections, motion, stop)
        require_followed(self.state, predicted)
        return motion

    def motion(self, z: np.ndarray) -> LineMotion:
        """All rates, from those of the algebraic variables."""
        return self.motion_at(self.rates(), z)

    def rates(self) -> np.ndarray:
        """Rates of the states at the present point [per s], shape (nx,)."""
        return rates_of(self.state.model)(*self.state.point.arguments)[0].copy()

    def motion_at(self, x: np.ndarray, z: np.ndarray) -> LineMotion:
        """Rates of the travels, from those of the states and of the algebraic variables."""
        return LineMotion(x, z, [layout.travel.read(x, z) for layout in self.state.model.layouts])

    def advance(self, h: float, motion: LineMotion, stop: float) -> LineMotion:
        """Advances the state by `h` seconds, which may be a short step backwards. Raises EquilibriumError,
        SimulationError."""
        point, t = self.state.point, self.state.point.t
        if h == 0.0:
            return motion
        if abs(h) <= self.linear:
            point.x[:] += h * motion.x
            point.z[:] += h * motion.z
            self.set_time(t + h)
            return motion
        if abs(h) <= self.short:
            return self._short_step(h, motion, stop)
        return self.integrate(h, motion, stop)

    def _short_step(self, h: float, motion: LineMotion, stop: float) -> LineMotion:
        """A step of Heun's method, or of IDAS where rates change fast, as after a loss of pressure."""
        point, t = self.state.point, self.time
        x, z = point.x.copy(), point.z.copy()

        def moved(rates: np.ndarray) -> LineMotion:
            self.state.point.x[:] = x + h * rates
            self.set_time(t + h)
            return self.solve(stop)

        point.z[:] += h * motion.z
        end = moved(motion.x)
        if np.array_equal(end.x, motion.x):
            return end
        if np.all(np.abs(h / 2.0 * (end.x - motion.x)) <= self.bent * self.state.model.x.nominals):
            return moved((motion.x + end.x) / 2.0)
        point.x[:], point.z[:] = x, z
        self.set_time(t)
        return self.integrate(h, motion, stop)

    def integrate(self, h: float, motion: LineMotion, stop: float) -> LineMotion:
        """Advances the state by `h` seconds with IDAS. Raises EquilibriumError, SimulationError."""
        point, integrator = self.state.point, idas_of(self.state.model, self.tolerance)
        predicted = point.z + h * motion.z
        point.x[:], point.z[:] = integrator.advance(point, h, motion.x, motion.z, self.slope(stop))
        self.set_time(point.t + h)
        motion = self.solve(stop)
        require_followed(self.state, predicted)
        return motion


@kept_with_model
def idas_of(model: Model, tolerance: float) -> Idas:
    """The integrator of a model: made once, as its functions take a while to build."""
    return Idas(model, tolerance)


@kept_with_structure
def rates_of(model: Model) -> Buffered:
    """Rates of the states as a function of a point."""
    return dense(model, model.dae)
