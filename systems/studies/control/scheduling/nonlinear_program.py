"""Large sparse optimisation problems out of many small terms, solved by IPOPT.

A term is a function of a few variables that gives constraints and a cost; it is used at many places, each with
variables and parameters of its own. Its derivatives are taken once, as the problem's are put together from them:
so the graph stays small, and the Hessian is exact.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from threading import Lock
from typing import Any

import casadi as ca
import numpy as np

from ropeway.systems.interrupts import WAIT, interrupted, stop_if_interrupted

_IN_USE = Lock()


class Term:
    """A function of `variables` and `parameters` (columns of SX): `rows` (m,) of constraints, and a `cost`."""

    def __init__(self, variables: ca.SX, parameters: ca.SX, rows: ca.SX, cost: ca.SX) -> None:
        self.variables, self.parameters = variables, parameters
        self.rows, self.cost = ca.densify(rows), ca.densify(ca.SX(cost))

    @cached_property
    def value(self) -> ca.Function:
        """(variables, parameters) -> (cost, rows)."""
        return ca.Function("value", [self.variables, self.parameters], [self.cost, self.rows])

    @cached_property
    def first(self) -> tuple[ca.Function, ca.Sparsity]:
        """(variables, parameters) -> (gradient, nonzeros of the rows' Jacobian), and the Jacobian's pattern."""
        gradient = ca.densify(ca.gradient(self.cost, self.variables))
        jacobian = ca.jacobian(self.rows, self.variables)
        results = [gradient, _nonzeros(jacobian)]
        return ca.Function("first", [self.variables, self.parameters], results), jacobian.sparsity()

    @cached_property
    def second(self) -> tuple[ca.Function, ca.Sparsity]:
        """(variables, parameters, factor of the cost, multipliers of the rows) -> nonzeros of the lower half of the
        Hessian of factor * cost + multipliers . rows, and its pattern."""
        factor, multipliers = ca.SX.sym("factor"), ca.SX.sym("multipliers", self.rows.numel())
        lagrangian = factor * self.cost + ca.dot(multipliers, self.rows)
        hessian = ca.tril(ca.hessian(lagrangian, self.variables)[0])
        inputs = [self.variables, self.parameters, factor, multipliers]
        return ca.Function("second", inputs, [_nonzeros(hessian)]), hessian.sparsity()


def _nonzeros(matrix: ca.SX) -> ca.SX:
    pattern = matrix.sparsity()
    return ca.vertcat(
        ca.SX(0, 1), *(matrix[int(i), int(j)] for i, j in zip(pattern.row(), pattern.get_col(), strict=True))
    )


@dataclass(frozen=True)
class Uses:
    """A term at `n` places: `variables` (nw, n), the numbers of its variables in the problem, `parameters` (np, n),
    and bounds of its rows (m, n)."""

    term: Term
    variables: np.ndarray
    parameters: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @property
    def n(self) -> int:
        """Number of places."""
        return self.variables.shape[1]


@dataclass(frozen=True)
class Linear:
    """Rows low <= A w <= high: each row has columns and as many factors."""

    columns: Sequence[Sequence[int]]
    factors: Sequence[Sequence[float]]
    low: Sequence[float]
    high: Sequence[float]


@dataclass(frozen=True)
class Solution:
    """The result of IPOPT: variables; values and multipliers of the rows (those of each `Uses` in order, place by
    place, then the linear ones); objective; whether it `converged`, its `status`, iterations and time [s]."""

    variables: np.ndarray
    rows: np.ndarray
    multipliers: np.ndarray
    objective: float
    converged: bool
    status: str
    iterations: int
    seconds: float


def solve(
    start: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    uses: Sequence[Uses],
    linear: Linear,
    *,
    iterations: int,
    tolerance: float,
) -> Solution:
    """The minimum of the sum of all costs, from a start; low and high bound the variables. Raises Interrupted."""
    uses = [u for u in uses if u.n]
    functions, problem = _problem(len(start), uses, linear)
    options: dict[str, Any] = {
        **functions,
        "ipopt": {
            "max_iter": iterations,
            "tol": tolerance,
            "linear_solver": "mumps",
            "print_level": 0,
            "sb": "yes",
            "mu_init": 1e-4,
            "nlp_scaling_method": "none",
            "acceptable_iter": 5,
        },
        "print_time": False,
        "calc_lam_p": False,
        "error_on_fail": False,
    }
    stop = _Stop(problem)
    solver = ca.nlpsol("solver", "ipopt", problem, {**options, "iteration_callback": stop})
    bounds = [
        np.concatenate([*(u.__dict__[side].ravel(order="F") for u in uses), linear.__dict__[side]])
        for side in ("low", "high")
    ]
    begin = time.perf_counter()
    with _alone():
        found = solver(x0=start, lbx=low, ubx=high, lbg=bounds[0], ubg=bounds[1])
        stats = solver.stats()
    stop_if_interrupted()
    return Solution(
        np.array(found["x"]).ravel(),
        np.array(found["g"]).ravel(),
        np.array(found["lam_g"]).ravel(),
        float(found["f"]),
        bool(stats["success"]),
        str(stats["return_status"]),
        int(stats["iter_count"]),
        time.perf_counter() - begin,
    )


class _Stop(ca.Callback):  # type: ignore[misc]  # CasADi has no types
    """Called by IPOPT after each iteration: stops it after a Ctrl-C."""

    def __init__(self, problem: dict[str, ca.MX]) -> None:
        super().__init__()
        n, m = problem["x"].numel(), problem["g"].numel()
        self._sizes = {"f": 1, "x": n, "lam_x": n, "g": m, "lam_g": m}
        self.construct("stop", {})

    def get_n_in(self) -> int:
        """Arguments: as many as a solver has results."""
        return int(ca.nlpsol_n_out())

    def get_n_out(self) -> int:
        """One: 1 to stop, 0 to continue."""
        return 1

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        """Columns; nothing for the multipliers of parameters."""
        return ca.Sparsity.dense(self._sizes.get(ca.nlpsol_out(i), 0), 1)

    def eval(self, arguments: Sequence[ca.DM]) -> list[bool]:
        """Whether to stop."""
        return [interrupted()]


@contextmanager
def _alone() -> Iterator[None]:
    """One solver at a time: IPOPT's linear solver MUMPS is not thread-safe. Raises Interrupted."""
    while not _IN_USE.acquire(timeout=WAIT):
        stop_if_interrupted()
    try:
        yield
    finally:
        _IN_USE.release()


def _problem(n: int, uses: Sequence[Uses], linear: Linear) -> tuple[dict[str, ca.Function], dict[str, ca.MX]]:
    """The derivatives of the problem as IPOPT takes them, and the problem."""
    w, p = ca.MX.sym("w", n), ca.MX.sym("p", 0)
    rows = sum(u.low.size for u in uses) + len(linear.low)
    factor, multipliers = ca.MX.sym("factor"), ca.MX.sym("multipliers", rows)
    i, j = np.repeat(np.arange(len(linear.columns)), [len(c) for c in linear.columns]), _flat(linear.columns, int)
    matrix = ca.DM.triplet(i.tolist(), j.tolist(), ca.DM(_flat(linear.factors, float)), len(linear.columns), n)
    costs, values, gradients, slopes, curves = [], [], [], [], []
    at_gradient, at_jacobian, at_hessian, twice = [], [], [], []
    offset = 0
    for u in uses:
        local = ca.reshape(w[u.variables.ravel(order="F").tolist()], *u.variables.shape)
        parameters = ca.DM(u.parameters)
        cost, value = u.term.value.map(u.n)(local, parameters)
        costs.append(ca.sum2(cost))
        values.append(ca.vec(value))
        first, pattern = u.term.first
        gradient, slope = first.map(u.n)(local, parameters)
        gradients.append(ca.vec(gradient))
        slopes.append(ca.vec(slope))
        at_gradient.append(u.variables.ravel(order="F"))
        m = u.low.shape[0]
        row = np.array(pattern.row(), dtype=int)[:, None] + offset + m * np.arange(u.n)
        column = u.variables[np.array(pattern.get_col(), dtype=int)]
        at_jacobian.append((row.ravel(order="F"), column.ravel(order="F")))
        second, pattern = u.term.second
        own = ca.reshape(multipliers[offset : offset + m * u.n], m, u.n)
        curves.append(ca.vec(second.map(u.n)(local, parameters, ca.repmat(factor, 1, u.n), own)))
        a, b = u.variables[np.array(pattern.row(), dtype=int)], u.variables[np.array(pattern.get_col(), dtype=int)]
        at_hessian.append((np.minimum(a, b).ravel(order="F"), np.maximum(a, b).ravel(order="F")))
        # Of two variables that are one in the problem, the entry above the diagonal counts too.
        inner = np.array(pattern.row()) == np.array(pattern.get_col())
        twice.append(np.where((a == b) & ~inner[:, None], 2.0, 1.0).ravel(order="F"))
        offset += m * u.n
    cost = sum(costs, ca.MX(0))
    value = ca.vertcat(*values, ca.mtimes(matrix, w))
    scatter = _summing(np.concatenate(at_gradient), n)
    gradient = ca.densify(ca.mtimes(scatter, ca.vertcat(*gradients)))
    slopes.append(ca.MX(ca.DM(_flat(linear.factors, float))))
    at_jacobian.append((offset + i, j))
    jacobian = _assembled(at_jacobian, ca.vertcat(*slopes), (rows, n))
    hessian = _assembled(at_hessian, ca.vertcat(*curves) * np.concatenate(twice), (n, n))
    return (
        {
            "grad_f": ca.Function("nlp_grad_f", [w, p], [cost, gradient], ["x", "p"], ["f", "grad_f_x"]),
            "jac_g": ca.Function("nlp_jac_g", [w, p], [value, jacobian], ["x", "p"], ["g", "jac_g_x"]),
            "hess_lag": ca.Function(
                "nlp_hess_l",
                [w, p, factor, multipliers],
                [hessian],
                ["x", "p", "lam_f", "lam_g"],
                ["triu_hess_gamma_x_x"],
            ),
        },
        {"x": w, "p": p, "f": cost, "g": value},
    )


def _flat(parts: Sequence[Sequence[Any]], kind: type) -> np.ndarray:
    return np.array([value for part in parts for value in part], dtype=kind)


def _summing(places: np.ndarray, n: int) -> ca.DM:
    """The matrix (n, entries) that adds entries up at their places."""
    count = len(places)
    return ca.DM.triplet(places.tolist(), list(range(count)), ca.DM.ones(count), n, count)


def _assembled(places: Sequence[tuple[np.ndarray, np.ndarray]], entries: ca.MX, shape: tuple[int, int]) -> ca.MX:
    """The sparse matrix with entries at (rows, columns), those of one place added up."""
    row, column = (np.concatenate([p[k] for p in places]) for k in (0, 1))
    key, at = np.unique(column.astype(np.int64) * shape[0] + row, return_inverse=True)
    columns = key // shape[0]
    colind = np.searchsorted(columns, np.arange(shape[1] + 1))
    pattern = ca.Sparsity(shape[0], shape[1], colind.tolist(), (key % shape[0]).tolist())
    return ca.MX(pattern, ca.mtimes(_summing(at, len(key)), entries))
