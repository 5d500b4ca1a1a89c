"""Three ways to solve the two equations of a span, with their iteration histories.

x(H, V) = l and z(H, V) = h for a span with loads (Turk 1988, eq. 2.53 and 2.54, which are swapped there).
Turk's chapter 3 compares successive substitution, Newton-Raphson and Brown's method; its text and its example's
data are not in the source, so the substitution, the damping and the data are this library's own, and no
figure of Turk's is reproduced. For real work use `equilibrium`; this is a study of convergence, and says in
`History.converged` whether it got there.
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
"""What the solver iterates on: (H, V), or T and its angle at the start."""

_DIFFERENCE = 1e-7  # forward difference, relative


@checked
@dataclass(frozen=True)
class SpanProblem:
    """A span with loads, in any one unit of force and length.

    Parameters
    ----------
    span : float
        Horizontal distance from end a to end b.
    rise : float
        Height of end b over end a.
    length : float
        Unstretched, of the rope.
    weight : float
        Of the rope per unstretched length.
    axial_stiffness : float
        Of the rope.
    distances : tuple of float, default ()
        Unstretched, of the loads from end a, in order.
    loads : tuple of float, default ()
        Downward forces.

    Raises
    ------
    InputError
        A value is not positive, or distances are not in order inside the span.

    Examples
    --------
    >>> round(SpanProblem(100.0, 10.0, 102.0, 20.0, 3e7).chord, 3)
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
        """Straight distance of the ends."""
        return float(np.hypot(self.span, self.rise))

    def reach(self, horizontal: float, vertical: float) -> tuple[float, float]:
        """Where end b of the rope is for a force at end a.

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
        """As `reach`, for iterates: NaN where there is none."""
        end = self._stations(horizontal, vertical)[-1].reach
        return float(end[0]), float(end[2])

    def _total(self, horizontal: float, vertical: float) -> float:
        """As `stretched`, for iterates: NaN where there is none."""
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

    `frame`: one row for each iterate, the start first; columns horizontal, vertical, tension, angle (at end a [rad],
    rise over run downwards positive), miss (distance of the rope's end from b), evaluations (of one of the two
    equations, so far). `converged`: whether the end is within the tolerance.
    """

    problem: SpanProblem
    method: SpanMethod
    damped: bool
    converged: bool
    frame: pd.DataFrame

    @property
    def iterations(self) -> int:
        """Rounds, the start not counted."""
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
    """Iterate on a span's two equations until its end is within a tolerance.

    Parameters
    ----------
    problem : SpanProblem
        The span.
    method : {"successive substitution", "Newton-Raphson", "Brown"}, default "Newton-Raphson"
        Newton takes 6 evaluations of one equation a round (forward differences), Brown 5.
    start : tuple of float, optional
        Horizontal tension and upward force at end a; by default those of the parabola.
    damped : bool, default True
        Whether a step of Newton or Brown changes the tension by half of itself at most, and the substitution goes half
        of each step (in 1/H).
    unknowns : {"horizontal and vertical", "tension and angle"}, default "horizontal and vertical"
        Of Newton and Brown.
    tolerance : float, default 1e-9
        Distance of the rope's end from b over the span.
    limit : int, default 60
        Most iterates.

    Returns
    -------
    History
        All iterates, and whether they converged.

    Raises
    ------
    InputError
        A value is out of its range.

    Examples
    --------
    >>> solve_span(SpanProblem(100.0, 10.0, 102.0, 20.0, 3e7)).converged
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
    """The two misses of a span in terms of the unknowns, with a count of the evaluations."""

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
        """Size of the steps of a difference."""
        return np.array([abs(u[0]), 1.0 if self.angular else max(abs(u[0]), abs(u[1]))]) * _DIFFERENCE

    def misses(self, u: Array) -> Array:
        self.evaluations += 2
        return self._misses(u)

    def miss(self, u: Array, which: int) -> float:
        self.evaluations += 1
        return float(self._misses(u)[which])

    def _misses(self, u: Array) -> Array:
        return np.subtract(self.problem._end(*self.force(u)), (self.problem.span, self.problem.rise))

    def row(self, u: Array) -> tuple[float, float, float, float, float, int]:
        h, v = self.force(u)
        miss = float(np.hypot(*self._misses(u)))
        return h, v, float(np.hypot(h, v)), float(np.arctan2(v, h)), miss, self.evaluations


def _substitution(equations: _Equations, u: Array, damped: bool) -> Array:
    """H from the excess of the rope over its chord, which goes with 1/H^2; V from the moments about end b.

    A round brings the error of H down by -(stretch)/(2 excess): it diverges for a rope tauter than its chord."""
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
    value, scale = equations.misses(u), equations.scale(u)
    jacobian = np.column_stack([(equations.misses(u + s) - value) / s.sum() for s in np.diag(scale)])
    return u + _limited(u, np.linalg.solve(jacobian, -value), damped)


def _brown(equations: _Equations, u: Array, damped: bool) -> Array:
    """Brown's method (1969): the first equation is made linear and one unknown eliminated from it before the
    second is evaluated, so 5 evaluations of one equation."""
    scale = equations.scale(u)
    first = equations.miss(u, 0)
    slope = np.array([(equations.miss(u + s, 0) - first) / s.sum() for s in np.diag(scale)])
    k = int(np.argmax(np.abs(slope * scale)))  # the unknown to eliminate
    other = 1 - k

    def on_line(value: float) -> Array:
        point = np.empty(2)
        point[other] = value
        point[k] = u[k] - (first + slope[other] * (value - u[other])) / slope[k]
        return point

    second = equations.miss(on_line(u[other]), 1)
    change = (equations.miss(on_line(u[other] + scale[other]), 1) - second) / scale[other]
    move = on_line(u[other] - second / change) - u
    return u + _limited(u, move, damped)


def _limited(u: Array, move: Array, damped: bool) -> Array:
    """A step; a damped one changes the tension by at most half of it.

    Halving until the residual decreases would stall Brown's method, whose steps need not reduce it.
    """
    return move * min(1.0, 0.5 * abs(u[0]) / abs(move[0])) if damped and move[0] != 0.0 else move


_Step = Callable[[_Equations, Array, bool], Array]
_STEPS: dict[SpanMethod, _Step] = {
    "successive substitution": _substitution,
    "Newton-Raphson": _newton,
    "Brown": _brown,
}
