"""Three methods for the two equations of a span, with their iteration histories.

The equations are x(H, V) = l and z(H, V) = h for a span with loads (Turk 1988, eq. 2.53 and 2.54, which are swapped
there). Turk's chapter 3 compares successive substitution, Newton-Raphson and Brown's method. The source lacks that text
and the data of its example, so the substitution, the damping and the data are this library's own; no figure of Turk's
is reproduced. This is a study of convergence; `History.converged` gives its outcome. Use `equilibrium` for real
problems.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
import pandas as pd

from ropeway.components import catenary, check, parabola
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Strain
from ropeway.components.errors import InputError
from ropeway.systems.studies.handbook.array_checks import finite
from ropeway.systems.studies.handbook.array_roots import Array

SpanMethod = Literal["successive substitution", "Newton-Raphson", "Brown"]
"""Turk's three methods."""

Unknowns = Literal["horizontal and vertical", "tension and angle"]
"""Unknowns of the iteration: (H, V), or T and its angle at the start."""

_DIFFERENCE = 1e-7  # forward difference, relative


@checked
@dataclass(frozen=True)
class SpanProblem:
    """A span with loads, in any consistent units of force and length.

    Parameters
    ----------
    span : float
        Horizontal distance from end a to end b.
    rise : float
        Height of end b above end a.
    length : float
        Unstretched length of the rope.
    weight : float
        Weight of the rope per unstretched length.
    axial_stiffness : float
        Axial stiffness of the rope.
    distances : tuple of float, default ()
        Unstretched distances of the loads from end a, in order.
    loads : tuple of float, default ()
        Downward forces.

    Raises
    ------
    InputError
        A value is not positive, or distances are not in order inside the span.

    Examples
    --------
    >>> round(rw.SpanProblem(100.0, 10.0, 102.0, 20.0, 3e7).chord, 3)
    100.499
    """

    span: float
    rise: float
    length: float
    weight: float
    axial_stiffness: float
    distances: tuple[float, ...] = ()
    loads: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for field in ("span", "length", "weight", "axial_stiffness"):
            check.positive(getattr(self, field), "SpanProblem", field)
        check.number(self.rise, "SpanProblem", "rise")
        if len(self.distances) != len(self.loads):
            raise InputError("Loads and their distances do not match", "Give one distance for each load")
        inside = (0.0, *self.distances, self.length)
        if any(not b >= a for a, b in pairwise(inside)):
            raise InputError(f"Distances {self.distances} are not in order inside the span", "Sort them from end a")

    @property
    def strain(self) -> Strain:
        """Elastic strain of the rope."""
        return Strain(1.0 / self.axial_stiffness, 0.0)

    @property
    def chord(self) -> float:
        """Straight distance between the ends."""
        return float(np.hypot(self.span, self.rise))

    def reach(self, horizontal: float, vertical: float) -> tuple[float, float]:
        """Position of end b of the rope for a force at end a.

        Parameters
        ----------
        horizontal : float
            Horizontal tension.
        vertical : float
            Upward force of the support at a on the rope.

        Returns
        -------
        x, z : float
            Horizontal and upward distance from end a.
        """
        x, z = finite(self._end(horizontal, vertical), "reach")
        return float(x), float(z)

    def stretched(self, horizontal: float, vertical: float) -> float:
        """Stretched length of the rope for a force at end a.

        Parameters
        ----------
        horizontal : float
            Horizontal tension.
        vertical : float
            Upward force of the support at a on the rope.

        Returns
        -------
        float
            Stretched length.
        """
        return float(finite(self._total(horizontal, vertical), "stretched length"))

    def _end(self, horizontal: float, vertical: float) -> tuple[float, float]:
        """As `reach`, for iterates; NaN where it is undefined."""
        end = self._stations(horizontal, vertical)[-1].reach
        return float(end[0]), float(end[2])

    def _total(self, horizontal: float, vertical: float) -> float:
        """As `stretched`, for iterates; NaN where it is undefined."""
        force = (horizontal, 0.0, -vertical)
        total, at = 0.0, 0.0
        for distance, load, station in zip(
            (*self.distances, self.length), (*self.loads, 0.0), self._stations(horizontal, vertical), strict=True
        ):
            total += float(catenary.stretched_length(force, self.weight, distance - at, self.strain))
            force, at = (station.force[0], 0.0, station.force[2] + load), distance
        return total

    @cached_property
    def start(self) -> tuple[float, float]:
        """H and V of the parabola."""
        chords = parabola.Chords.between(np.array([(0.0, 0.0, 0.0), (self.span, 0.0, self.rise)]))
        beam = parabola.beam(
            chords, self.weight, np.array([self.length]), np.array([self.distances]), np.array([self.loads])
        )
        tension = parabola.common_tension(
            chords, self.weight, beam, self.strain, np.array([self.length]), np.zeros(1, dtype=int)
        )
        horizontal = float(tension[0]) * self.span / self.chord
        return horizontal, float(beam.reaction[0]) - horizontal * self.rise / self.span

    def _stations(self, horizontal: float, vertical: float) -> list[catenary.Segment]:
        force = (horizontal, 0.0, -vertical)
        return catenary.loaded(force, self.weight, self.strain, self.length, self.distances, self.loads)


@dataclass(frozen=True, eq=False)
class History:
    """The iterates of a solution, as `rw.solve_span` returns them.

    `frame` has one row per iterate, beginning with the start; columns horizontal, vertical, tension, angle (at end a
    [rad], positive downwards), miss (distance of the rope's end from b), evaluations (cumulative, of one of the two
    equations). `converged` tells whether the end is within the tolerance.
    """

    problem: SpanProblem
    method: SpanMethod
    damped: bool
    converged: bool
    frame: pd.DataFrame

    @property
    def iterations(self) -> int:
        """Number of iterations, without the start."""
        return len(self.frame) - 1


@checked
def solve_span(
    problem: SpanProblem,
    method: SpanMethod = "Newton-Raphson",
    *,
    start: tuple[float, float] | None = None,
    damped: bool = True,
    unknowns: Unknowns = "horizontal and vertical",
    tolerance: float = 1e-9,
    limit: int = 60,
) -> History:
    """Solve the two equations of a span iteratively.

    Parameters
    ----------
    problem : SpanProblem
        The span.
    method : {"successive substitution", "Newton-Raphson", "Brown"}, default "Newton-Raphson"
        The method. An iteration of Newton takes 6 evaluations of one equation (forward differences), of Brown 5.
    start : tuple of float, optional
        Initial horizontal tension and upward force at end a; by default those of the parabola.
    damped : bool, default True
        Whether steps are damped: Newton and Brown change the tension by at most half of itself, the substitution halves
        each step (in 1/H).
    unknowns : {"horizontal and vertical", "tension and angle"}, default "horizontal and vertical"
        Unknowns of Newton and Brown.
    tolerance : float, default 1e-9
        Largest distance of the rope's end from b, relative to the span.
    limit : int, default 60
        Largest number of iterates.

    Returns
    -------
    History
        All iterates, and whether they converged.

    Raises
    ------
    InputError
        A value is out of range.

    Examples
    --------
    >>> rw.solve_span(rw.SpanProblem(100.0, 10.0, 102.0, 20.0, 3e7)).converged
    True
    """
    check.count(limit, "solve_span", "iterates", 1_000)
    check.positive(tolerance, "solve_span", "tolerance")
    h, v = problem.start if start is None else start
    check.positive(h, "solve_span", "horizontal tension of start")
    check.number(v, "solve_span", "vertical force of start")
    equations = _Equations(problem, unknowns)
    u = equations.of_force(h, v)
    rows = [equations.row(u)]
    step = _STEPS[method]
    with np.errstate(all="ignore"):
        while len(rows) <= limit and rows[-1][4] > tolerance * problem.span:
            u = step(equations, u, damped)
            rows.append(equations.row(u))
            if not np.all(np.isfinite(rows[-1][:5])) or rows[-1][0] <= 0.0:
                break
    columns = ["horizontal", "vertical", "tension", "angle", "miss", "evaluations"]
    converged = bool(rows[-1][4] <= tolerance * problem.span and rows[-1][0] > 0.0)
    return History(problem, method, damped, converged, pd.DataFrame(rows, columns=columns))


class _Equations:
    """The two residuals of a span as functions of the unknowns, with a count of evaluations."""

    def __init__(self, problem: SpanProblem, unknowns: Unknowns) -> None:
        self.problem = problem
        self.angular = unknowns == "tension and angle"
        self.evaluations = 0

    def of_force(self, h: float, v: float) -> Array:
        return np.array([np.hypot(h, v), np.arctan2(v, h)] if self.angular else [h, v])

    def force(self, u: Array) -> tuple[float, float]:
        if self.angular:
            return float(u[0] * np.cos(u[1])), float(u[0] * np.sin(u[1]))
        return float(u[0]), float(u[1])

    def scale(self, u: Array) -> Array:
        """Step sizes of the forward differences."""
        return np.array([abs(u[0]), 1.0 if self.angular else max(abs(u[0]), abs(u[1]))]) * _DIFFERENCE

    def residuals(self, u: Array) -> Array:
        self.evaluations += 2
        return self._residuals(u)

    def residual(self, u: Array, which: int) -> float:
        self.evaluations += 1
        return float(self._residuals(u)[which])

    def _residuals(self, u: Array) -> Array:
        return np.subtract(self.problem._end(*self.force(u)), (self.problem.span, self.problem.rise))

    def row(self, u: Array) -> tuple[float, float, float, float, float, int]:
        h, v = self.force(u)
        miss = float(np.hypot(*self._residuals(u)))
        return h, v, float(np.hypot(h, v)), float(np.arctan2(v, h)), miss, self.evaluations


def _substitution(equations: _Equations, u: Array, damped: bool) -> Array:
    """H from the excess of the rope over its chord, which is proportional to 1/H^2; V from the moments about end b.

    An iteration multiplies the error of H by -(stretch)/(2 excess); it diverges where the stretch
    exceeds twice the excess."""
    problem = equations.problem
    h, v = equations.force(u)
    x, z = problem._end(h, v)
    equations.evaluations += 2
    length = problem._total(h, v)
    ratio = (length - float(np.hypot(x, z))) / (length - problem.chord)
    h_new = h * float(np.sqrt(ratio)) if ratio > 0.0 else np.nan
    if damped:
        h_new = h * (h * 0.5 / h_new + 0.5) ** -1 if np.isfinite(h_new) else 1.5 * h
    v_new = v + h * z / x - h_new * problem.rise / problem.span
    return equations.of_force(h_new, v_new)


def _newton(equations: _Equations, u: Array, damped: bool) -> Array:
    """Newton-Raphson with forward differences: 6 evaluations of one equation."""
    value, scale = equations.residuals(u), equations.scale(u)
    jacobian = np.column_stack([(equations.residuals(u + s) - value) / s.sum() for s in np.diag(scale)])
    return u + _limited(u, np.linalg.solve(jacobian, -value), damped)


def _brown(equations: _Equations, u: Array, damped: bool) -> Array:
    """Brown's method (1969): the first equation is linearised and one unknown eliminated before the second is
    evaluated: 5 evaluations of one equation."""
    scale = equations.scale(u)
    first = equations.residual(u, 0)
    slope = np.array([(equations.residual(u + s, 0) - first) / s.sum() for s in np.diag(scale)])
    k = int(np.argmax(np.abs(slope * scale)))  # the unknown to eliminate
    other = 1 - k

    def on_line(value: float) -> Array:
        point = np.empty(2)
        point[other] = value
        point[k] = u[k] - (first + slope[other] * (value - u[other])) / slope[k]
        return point

    second = equations.residual(on_line(u[other]), 1)
    change = (equations.residual(on_line(u[other] + scale[other]), 1) - second) / scale[other]
    step = on_line(u[other] - second / change) - u
    return u + _limited(u, step, damped)


def _limited(u: Array, step: Array, damped: bool) -> Array:
    """A step; a damped one changes the tension by at most half of itself.

    Halving until the residual decreases would stall Brown's method, whose steps need not reduce it.
    """
    return step * min(1.0, 0.5 * abs(u[0]) / abs(step[0])) if damped and step[0] != 0.0 else step


_Step = Callable[[_Equations, Array, bool], Array]
_STEPS: dict[SpanMethod, _Step] = {
    "successive substitution": _substitution,
    "Newton-Raphson": _newton,
    "Brown": _brown,
}
