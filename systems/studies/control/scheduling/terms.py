"""The task of a schedule's problem, and its terms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ropeway.systems.studies.control.scheduling.nonlinear_program import Term
from ropeway.systems.studies.control.scheduling.section_equations import FORCE, Constraint, LineEquations, SectionTerm

MOTION = ("speed", "acceleration")
"""Limits of a schedule's own speeds."""

SMOOTH = ("force", "power")
"""Limits of a control sheave on smooth outputs."""


@dataclass(frozen=True)
class Bounds:
    """Lowest and highest tension of the spans [N], and for each driven support the rows of its limits."""

    tension: tuple[float, float]
    rows: tuple[tuple[Constraint, ...], ...]


@dataclass(frozen=True)
class Task:
    """The task: grid times [s]; weights of the objectives, each per its own unit over the objective's size;
    bounds on tensions and drives from `settle` [s] on, from when the objectives of tension count, and `early` ones
    before; for each driven support whether its speed is `fixed`, and its speed range [m/s]; acceleration [m/s2];
    target of tensions [N] and their present deviation [N]."""

    grid: np.ndarray
    weights: Mapping[str, float]
    bounds: Bounds
    early: Bounds
    fixed: tuple[bool, ...]
    speed: tuple[tuple[float, float], ...]
    acceleration: float
    target: float
    deviation: float
    settle: float
    relaxed: bool = False

    def at(self, *, counts: bool) -> Bounds:
        """The bounds where the objectives of tension count, or before."""
        return self.bounds if counts else self.early


class Parts:
    """The terms of a task, each made once: problems of several rounds share them."""

    def __init__(self, equations: LineEquations, task: Task) -> None:
        self.equations, self.task = equations, task
        self._made: dict[tuple[str, int, bool], SectionTerm] = {}

    def section(self, s: int, counts: bool) -> SectionTerm:
        """The equations of section s, with its limits, and the highest tension where it counts."""
        key = ("section", s, counts)
        if key not in self._made:
            a, b = self.equations.sections()[s]
            names = [f"{span.name}.tension_{end}" for span in self.equations.run.spans[a:b] for end in "ab"]
            low, high = (bound / FORCE for bound in self.task.at(counts=counts).tension)
            rows = [Constraint(name, low, high, "tension") for name in names]
            if counts and "peak tension" in self.task.weights and not self.task.relaxed:
                rows += [Constraint(name, -np.inf, 0.0, "", peak=True) for name in names]
            self._made[key] = self.equations.section((a, b), rows, relaxed=self.task.relaxed)
        return self._made[key]

    def sheave(self, i: int, counts: bool) -> SectionTerm:
        """Costs of control sheave i, and its limits on force and power, which are smooth."""
        key = ("sheave", i, counts)
        if key not in self._made:
            weights = {} if self.task.relaxed else self.task.weights
            target = self.task.target if counts and "tension deviation" in weights else None
            rows = [row for row in self.task.at(counts=counts).rows[i] if row.limit in SMOOTH]
            self._made[key] = self.equations.sheave(
                i, rows, target, energy="energy" in weights, relaxed=self.task.relaxed
            )
        return self._made[key]

    def bent(self, i: int, row: Constraint, counts: bool) -> SectionTerm:
        """A limit of control sheave i whose output is not smooth, as an absolute value: for use near the limit only."""
        key = (row.output, i, counts)
        if key not in self._made:
            self._made[key] = self.equations.sheave(i, (row,), None, energy=False, relaxed=self.task.relaxed)
        return self._made[key]


def bounds_of(part: SectionTerm) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of a part's rows, its equations first."""
    low, high = [0.0] * part.residuals, [0.0] * part.residuals
    for row, sign in zip(part.rows, part.signs, strict=True):
        low.append(-np.inf if sign < 0 else row.low)
        high.append(np.inf if sign > 0 else row.high)
    return np.array(low), np.array(high)


def motion(h: float) -> Term:
    """Travel and speed of a driven support at a time near interval [t, t + h], speeds v linear between grid times:
    variables (q, v, time, q at t, v at t - h, t, t + h, t + 2h), parameters (t, what q at t differs from the
    schedule's integral, what it does at the time, and that one's slope)."""
    w, p = ca.SX.sym("w", 8), ca.SX.sym("p", 4)
    q, v, time, q0, before, v0, v1, after = ca.vertsplit(w)
    s = time - p[0]
    slope, earlier, later = (v1 - v0) / h, (v0 - before) / h, (after - v1) / h
    over, under = ca.fmax(s - h, 0), ca.fmin(s, 0)
    speed = v0 + slope * s + (later - slope) * over + (earlier - slope) * under
    travel = q0 - p[1] + v0 * s + slope * s**2 / 2 + (later - slope) * over**2 / 2 + (earlier - slope) * under**2 / 2
    return Term(w, p, ca.vertcat(q - travel - p[2] - p[3] * s, v - speed), ca.SX(0))
