"""A line that is moved on by steps in which nothing jumps: its sections solved, its drives integrated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.load_crossings import Crossing
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.solvers.block_newton import blocks_of
from ropeway.systems.solvers.idas import Idas
from ropeway.systems.solvers.newton import Buffered, dense, newton_of
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.stability import require_followed

Signal = float | Schedule


def breaks_of(signals: Sequence[Signal]) -> np.ndarray:
    """Times at which an input bends [s]."""
    return np.unique(np.concatenate([[], *(s.breaks() for s in signals if isinstance(s, Schedule))]))


class LineMotion(NamedTuple):
    """Rates at a point [per s]: of the states, of the algebraic variables, and of each run's travels."""

    x: np.ndarray
    z: np.ndarray
    travel: list[np.ndarray]


class LineStepper:
    """A line and what drives it. `state` goes on in place; `tolerance` is that of the run."""

    short = 5e-3
    """Stretches up to this [s] are one trapezoidal step: they bring a load onto its support."""
    tiny = 1e-4
    """Stretches up to this [s] are a straight line: the second order is below rounding."""

    def __init__(self, state: LineState, signals: Sequence[Signal], tolerance: float) -> None:
        self.state = state
        self.signals = tuple(signals)
        self.breaks = breaks_of(signals)
        self.tolerance = tolerance

    @property
    def time(self) -> float:
        """Time of the state [s]."""
        return self.state.point.t

    def set_time(self, t: float) -> None:
        """Sets the clock, and the inputs to their values then."""
        self.state.point = replace(self.state.point, t=t)
        self.state.point.u[:] = self.inputs_at(t)

    def inputs_at(self, t: float) -> np.ndarray:
        """Values of all inputs, shape (nu,)."""
        if not len(self.breaks):  # all of them constant
            return np.array(self.signals, dtype=float)
        return np.array([s.at(t) if isinstance(s, Schedule) else s for s in self.signals], dtype=float)

    def slope(self, stop: float) -> np.ndarray:
        """Rates of the inputs from now to `stop`, no later than their next break, shape (nu,)."""
        t = self.state.point.t
        if not len(self.breaks) or stop - t < 1e-9:
            return np.zeros(len(self.signals))
        return (self.inputs_at(stop) - self.state.point.u) / (stop - t)

    def solve(self, stop: float) -> LineMotion:
        """Solves the algebraic variables; returns how everything moves from here."""
        state = self.state
        z = newton_of(state.model).solve(state.point, slope=self.slope(stop))
        return self._motion(np.zeros(0) if z is None else z)

    def _beside(self, crossings: Sequence[Crossing]) -> list[int]:
        """The sections on both sides of crossings."""
        parts, touched = blocks_of(self.state.model), set[int]()
        for c in crossings:
            force = self.state.model.layouts[c.r].force
            touched.update(int(parts.of[z]) for z in force[max(c.k - 1, 0) : c.k + 1])
            if c.k == 0 and self.state.runs[c.r].closed:
                touched.add(int(parts.of[force[-1]]))
        return sorted(touched)

    def _solve_parts(self, touched: Sequence[int], motion: LineMotion, stop: float) -> LineMotion:
        """Solves some sections only; the others keep their rates."""
        z = motion.z.copy()
        blocks_of(self.state.model).solve(self.state.point, touched, motion.x, self.slope(stop), z)
        return self._moving(motion.x, z)

    def _solve_followed(self, motion: LineMotion, stop: float, touched: Sequence[int] | None = None) -> LineMotion:
        """Solves some sections, or all, where their rates have led them. Raises EquilibriumError."""
        led = self.state.point.z.copy()
        motion = self.solve(stop) if touched is None else self._solve_parts(touched, motion, stop)
        require_followed(self.state, led)
        return motion

    def _motion(self, z: np.ndarray) -> LineMotion:
        """All rates, from those of the algebraic variables."""
        return self._moving(rates_of(self.state.model)(*self.state.point.arguments)[0].copy(), z)

    def _moving(self, x: np.ndarray, z: np.ndarray) -> LineMotion:
        return LineMotion(x, z, [layout.travel.read(x, z) for layout in self.state.model.layouts])

    def _advance(self, h: float, motion: LineMotion, stop: float) -> LineMotion:
        """Moves the state on by `h` seconds, a little backwards too."""
        point, t = self.state.point, self.state.point.t
        if h == 0.0:
            return motion
        if abs(h) <= self.tiny:
            point.x[:] += h * motion.x
            point.z[:] += h * motion.z
            self.set_time(t + h)
            return motion
        if abs(h) <= self.short:
            x = point.x.copy()
            point.x[:] = x + h * motion.x
            point.z[:] += h * motion.z
            self.set_time(t + h)
            end = self.solve(stop)
            if np.array_equal(end.x, motion.x):
                return end
            self.state.point.x[:] = x + h / 2.0 * (motion.x + end.x)
            return self.solve(stop)
        return self._integrate(h, motion, stop)

    def _integrate(self, h: float, motion: LineMotion, stop: float) -> LineMotion:
        """Moves the state on by `h` seconds with IDAS."""
        point, integrator = self.state.point, idas_of(self.state.model, self.tolerance)
        led = point.z + h * motion.z
        point.x[:], point.z[:] = integrator.advance(point, h, motion.x, motion.z, self.slope(stop))
        self.set_time(point.t + h)
        motion = self.solve(stop)
        require_followed(self.state, led)
        return motion


@lru_cache(maxsize=16)
def idas_of(model: Model, tolerance: float) -> Idas:
    """The integrator of a model: made once, as its functions take a while to build."""
    return Idas(model, tolerance)


@lru_cache(maxsize=16)
def rates_of(model: Model) -> Buffered:
    """Rates of the states as a function of a point."""
    return dense(model, model.dae)
