"""A line's own equations, cut into the sections between its driven supports, as terms of an optimisation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import casadi as ca
import numpy as np

from ropeway.components.control_sheave import grip_margin
from ropeway.components.errors import InputError
from ropeway.components.node import Node
from ropeway.systems.modelling.dae_model import Model, component_of
from ropeway.systems.modelling.equations import expanded
from ropeway.systems.solvers.points import Point
from ropeway.systems.studies.control.scheduling.nonlinear_program import Term

FORCE = 1e4
"""Unit of forces in the problem [N]: of the order of what a schedule changes."""

DRIVING = "driving power"
"""The row by which an unknown that is at least zero stays above the power of a drive: it is the power where that is
positive."""


@dataclass(frozen=True)
class Constraint:
    """A constraint: an output that stays within low and high, in the problem's units; `limit` names what bounds it,
    and `output` the quantity. `peak`: it stays below the highest tension, which is an unknown."""

    output: str
    low: float
    high: float
    limit: str
    peak: bool = False

    @property
    def size(self) -> float:
        """What shares of the limit count from: its bounds, or 1, a ratio of tensions, for a margin of grip."""
        bounds = [] if self.limit == "grip" else [abs(b) for b in (self.low, self.high) if np.isfinite(b)]
        return max(bounds, default=1.0)

    def near(self, value: float) -> bool:
        """Whether a value is within half of the bounds' size of them, or 0.5 of a single one."""
        reach = 0.5 * (self.high if np.isfinite(self.high) else 1.0)
        return bool(value > self.high - reach or value < self.low + reach)


def side(limit: str, *, high: bool) -> str:
    """The name of a limit at one of its ends."""
    return limit if limit != "tension" else "tension_high" if high else "tension_low"


@dataclass(frozen=True)
class SectionTerm:
    """A term with what its variables are: (kind, place), kind one of "z" (place in the algebraic variables), "q" and
    "v" (travel and speed of a driven support, by its number), "peak", "driving", "slack <limit>"; `discrete`, `states`
    and `inputs` are the places of its parameters: d, then states and inputs less what the schedule says they are,
    then the weights of its mean square and of its power. `rows` are its constraints after `residuals` equations."""

    term: Term
    variables: tuple[tuple[str, int], ...]
    discrete: np.ndarray
    states: np.ndarray
    inputs: np.ndarray
    residuals: int
    rows: tuple[Constraint, ...]
    signs: np.ndarray


class LineEquations:
    """The model's equations on the problem's symbols, at the parameters of a run."""

    def __init__(self, model: Model, parameters: np.ndarray) -> None:
        if len(model.runs) != 1 or model.runs[0].closed:
            raise InputError(f"{model.name!r} is not one rope from end to end", "Schedules are for mono-cable lines")
        self.model, self.parameters = model, parameters
        self.run, self.layout = model.runs[0], model.layouts[0]
        self.driven = np.flatnonzero(self.layout.travel.state >= 0)
        """Supports that are driven, in order."""
        n = len(self.driven)
        self.z_unit = np.array([FORCE if u == "N" else 1.0 for u in model.z.units])
        self.y_unit = np.array(
            [FORCE if u in ("N", "W") else k for u, k in zip(model.y.units, model.y.nominals, strict=True)]
        )
        self._z, self._q, self._v = ca.SX.sym("z", len(model.z)), ca.SX.sym("q", n), ca.SX.sym("v", n)
        self._d = ca.SX.sym("d", len(model.d))
        self._more_x, self._more_u = ca.SX.sym("x", len(model.x)), ca.SX.sym("u", len(model.u))
        of_x, of_u = self.owners
        x = ca.vertcat(*(self._q[i] if travel else self._v[i] + self._more_x[k] for k, (i, travel) in enumerate(of_x)))
        u = ca.vertcat(*(self._v[i] + self._more_u[k] for k, i in enumerate(of_u)))
        arguments: list[ca.SX] = [ca.SX(0), x, self._z * self.z_unit, u, ca.SX(ca.DM(parameters)), self._d]
        unit = np.array([FORCE if u == "N" else 1.0 for u in model.r.units])
        self._alg: ca.SX = expanded(model).call(arguments)[1] / unit
        self._y: ca.SX = model.outputs.expand().call(arguments)[0] / self.y_unit
        self._known = {
            "z": self._z,
            "q": self._q,
            "v": self._v,
            "d": self._d,
            "x": self._more_x,
            "u": self._more_u,
        }
        self._peak, self._driving = ca.SX.sym("peak"), ca.SX.sym("driving")
        pattern = ca.jacobian_sparsity(self._alg, self._z)
        self._rows, self._columns = np.array(pattern.row()), np.array(pattern.get_col())

    @property
    def nodes(self) -> list[Node]:
        """The driven supports."""
        return [self.run.nodes[k] for k in self.driven]

    @cached_property
    def owners(self) -> tuple[list[tuple[int, bool]], list[int]]:
        """For each state the number of its driven support and whether it is the travel; for each input likewise the
        number."""
        number = {self.run.nodes[k].name: i for i, k in enumerate(self.driven)}
        travels = {int(self.layout.travel.state[k]) for k in self.driven}
        try:
            states = [(number[component_of(n)], i in travels) for i, n in enumerate(self.model.x.names)]
            inputs = [number[component_of(n)] for n in self.model.u.names]
        except KeyError as error:
            raise InputError(
                f"{error.args[0]!r} moves besides the control sheaves", "Schedules are for mono-cable lines"
            ) from error
        return states, inputs

    def sections(self) -> list[tuple[int, int]]:
        """First and last support of each section."""
        ends = sorted({0, len(self.run.spans), *(int(k) for k in self.driven)})
        return list(pairwise(ends))

    def columns(self, section: tuple[int, int]) -> np.ndarray:
        """Algebraic variables of a section."""
        a, b = section
        force = self.layout.force[a:b, None] + np.arange(3)
        travel = self.layout.travel.algebraic[a : b + 1]
        return np.unique(np.concatenate([force.ravel(), travel[travel >= 0]]))

    def section(self, section: tuple[int, int], rows: Sequence[Constraint], *, relaxed: bool) -> SectionTerm:
        """The equations of a section, and limits on its outputs."""
        columns = self.columns(section)
        own = np.unique(self._rows[np.isin(self._columns, columns)])
        return self._part(_entries(self._alg, own), rows, ca.SX(0), relaxed)

    def sheave(
        self, i: int, rows: Sequence[Constraint], target: float | None, *, energy: bool, relaxed: bool
    ) -> SectionTerm:
        """Limits on a driven support's outputs, and its cost: the mean square of both tensions' distances from a
        target, or the power of the drive where that is positive."""
        name, cost = self.nodes[i].name, ca.SX(0)
        if target is not None:
            for side in ("in", "out"):
                cost += (self._y[self.model.y.index[f"{name}.tension_{side}"]] - target / FORCE) ** 2 / 2.0
        if energy:
            rows = (*rows, Constraint(f"{name}.power", 0.0, np.inf, DRIVING))
        return self._part(ca.SX(0, 1), rows, cost, relaxed)

    def _part(self, equations: ca.SX, rows: Sequence[Constraint], cost: ca.SX, relaxed: bool) -> SectionTerm:
        weight = ca.SX.sym("weight", 2)
        written: list[ca.SX] = []
        kept: list[Constraint] = []
        signs: list[int] = []
        slacks: dict[str, ca.SX] = {}
        drives = any(row.limit == DRIVING for row in rows)
        for row in rows:
            for value in self._values(row):
                if row.peak:
                    written, kept, signs = [*written, value - self._peak], [*kept, row], [*signs, 0]
                elif row.limit == DRIVING:
                    written, kept, signs = [*written, self._driving - value], [*kept, row], [*signs, 0]
                elif not relaxed:
                    written, kept, signs = [*written, value], [*kept, row], [*signs, 0]
                else:
                    for sign, bound in ((1, row.low), (-1, row.high)):
                        if np.isfinite(bound):
                            slack = slacks.setdefault(side(row.limit, high=sign < 0), ca.SX.sym("slack"))
                            written.append(value + sign * slack)
                            kept.append(row)
                            signs.append(sign)
        every = ca.vertcat(equations, *written, cost)
        places = {
            name: np.unique(np.array(ca.jacobian_sparsity(every, symbol).get_col(), dtype=int))
            for name, symbol in self._known.items()
        }
        variables = [(name, int(k)) for name in ("z", "q", "v") for k in places[name]]
        symbols = [self._known[name][k] for name, k in variables]
        if any(row.peak for row in rows):
            variables.append(("peak", 0))
            symbols.append(self._peak)
        if drives:
            variables.append(("driving", 0))
            symbols.append(self._driving)
        for limit, slack in slacks.items():
            variables.append((f"slack {limit}", 0))
            symbols.append(slack)
        parameters = [self._known[name][int(k)] for name in ("d", "x", "u") for k in places[name]]
        total = weight[0] * cost + weight[1] * (self._driving if drives else 0)
        return SectionTerm(
            Term(ca.vertcat(*symbols), ca.vertcat(*parameters, weight), ca.vertcat(equations, *written), total),
            tuple(variables),
            places["d"],
            places["x"],
            places["u"],
            equations.numel(),
            tuple(kept),
            np.array(signs, dtype=int),
        )

    def _values(self, row: Constraint) -> tuple[ca.SX, ...]:
        """What a row bounds: its output; the margin of a grip with either side as the tight one, as it bends where
        both are alike."""
        y, index = self._y, self.model.y.index
        if row.limit != "grip":
            return (y[index[row.output]],)
        name = component_of(row.output)
        friction, turns = (self.parameters[self.model.p.index[f"{name}.{q}"]] for q in ("grip_friction", "turns"))
        wrap = y[index[f"{name}.wrap"]] * self.y_unit[index[f"{name}.wrap"]]
        ends = (y[index[f"{name}.tension_in"]], y[index[f"{name}.tension_out"]])
        unit = self.y_unit[index[row.output]]
        return tuple(grip_margin(friction, wrap, turns, *sides) / unit for sides in (ends, ends[::-1]))

    def excess(self, point: Point, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States and inputs of a point less the speeds of the driven supports that a schedule gives them."""
        of_x, of_u = self.owners
        return (
            np.array([0.0 if travel else point.x[k] - speed[i] for k, (i, travel) in enumerate(of_x)]),
            np.array([point.u[k] - speed[i] for k, i in enumerate(of_u)]),
        )


def drive_parameters(model: Model, sheave: Node, parameters: np.ndarray, names: Sequence[str]) -> Mapping[str, float]:
    """Those parameters of a control sheave's drive that it has; an ideal one has none."""
    index = model.p.index
    own = {name: index[f"{sheave.name}.{name}"] for name in names if f"{sheave.name}.{name}" in index}
    return {name: float(parameters[place]) for name, place in own.items()}


def _entries(vector: ca.SX, places: np.ndarray) -> ca.SX:
    return ca.vertcat(ca.SX(0, 1), *(vector[int(i)] for i in places))
