"""The functions of a model that solvers call: its equations and outputs on arrays, and for Newton's method the scaled
residuals, their Jacobian and the solution of the linear system."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching, reverse_cuthill_mckee

from ropeway.components.variable import Kind
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.dae_model import BUILDING, Model
from ropeway.systems.modelling.equations import equations, scalar
from ropeway.systems.solvers.damped_newton import damped
from ropeway.systems.solvers.points import VECTORS, Slot


class Buffered:
    """A CasADi function called on NumPy arrays without copies; each thread has buffers of its own."""

    def __init__(self, function: ca.Function) -> None:
        self.function = function
        self._own = threading.local()

    def __call__(self, *arguments: np.ndarray) -> list[np.ndarray]:
        """Results as nonzeros; they are overwritten by the next call of this thread. Raises Interrupted."""
        stop_if_interrupted()
        try:
            set_argument, call, results, known = self._own.buffers
        except AttributeError:
            set_argument, call, results, known = self._own.buffers = self._buffers()
        for i, argument in enumerate(arguments):
            if argument is not known[i]:  # most are the same arrays in all steps of one solve
                set_argument(i, argument.data)
                known[i] = argument
        call()
        return results

    def _buffers(self) -> tuple[Callable[[int, memoryview], None], Callable[[], None], list[np.ndarray], list[object]]:
        """The function that sets an argument, the call, the arrays of the results, and the arguments that are set."""
        buffer, call = self.function.buffer()
        results = [np.zeros(self.function.nnz_out(i)) for i in range(self.function.n_out())]
        for i, result in enumerate(results):
            buffer.set_res(i, result.data)
        return buffer.set_arg, call, results, [None] * self.function.n_in()


class NewtonInputs(NamedTuple):
    """Inputs of a residual and its Jacobian: the scaled `unknowns`, the point's other vectors, the `target` of given
    values, the `damping` of the idlers' travels with their start `anchor`, the `slope` of the inputs [per s], the
    nominals of the unknowns, and one over those of the residuals."""

    unknowns: Any
    t: Any
    x: Any
    u: Any
    p: Any
    d: Any
    target: Any
    damping: Any
    anchor: Any
    slope: Any
    scale: Any
    weight: Any


def with_freed(model: Model, point: dict[Kind, Any], freed: Sequence[Slot], values: Sequence[Any]) -> dict[Kind, Any]:
    """The vectors of a point with the values of freed entries instead of its own. Loads behind a span whose length is
    freed keep their places along the rope."""
    full = dict(point)
    for (kind, k), value in zip(freed, values, strict=True):
        entries = ca.vertsplit(full[kind])
        entries[k] = value
        full[kind] = ca.vertcat(*entries)
        if kind is Kind.PARAMETER:
            full[Kind.DISCRETE] -= _beyond(model, k, full[Kind.DISCRETE]) * (value - point[kind][k])
    return full


class NewtonFunctions:
    """The scaled residuals of a structure, their Jacobian and Newton's step, for `freed` and `given` entries."""

    def __init__(self, model: Model, freed: tuple[Slot, ...], given: tuple[Slot, ...]) -> None:
        sym, count = model.sym, len(model.z) + len(freed)
        v, scale, weight = sym("v", count), sym("scale", count), sym("weight", len(model.r) + len(given))
        time, point = sym("t"), {kind: sym(kind.value, len(model.tables[kind])) for kind in VECTORS}
        full = {**point, Kind.ALGEBRAIC: v[: len(model.z)] * scale[: len(model.z)]}
        full = with_freed(model, full, freed, [v[i] * scale[i] for i in range(len(model.z), count)])
        arguments = [time, *(full[kind] for kind in VECTORS)]
        ode, found = equations(model, arguments, closed=not freed)
        target, damping = sym("target", len(given)), sym("damping")
        anchor, slope = sym("anchor", len(model.z)), sym("slope", len(model.u))
        found = found.scaled(weight[: len(model.r)]).plus(-damping * _drag(model, v, anchor))
        if given:
            y = scalar(model, model.outputs)(*arguments)
            chosen = ca.vertcat(*(y[k] if kind is Kind.OUTPUT else full[kind][k] for kind, k in given))
            found = found.and_also((chosen - target) * weight[len(model.r) :])
        known = {letter: point[kind] for kind, letter in VECTORS.items() if kind is not Kind.ALGEBRAIC}
        nominals = {"scale": scale, "weight": weight}
        inputs = NewtonInputs(v, time, **known, target=target, damping=damping, anchor=anchor, slope=slope, **nominals)
        names = list(NewtonInputs._fields)
        residual, matrix = found.value, found.jacobian(v)
        self.residual = ca.Function("residual", inputs, [residual], names, ["residual"])
        stop_if_interrupted()
        self.jacobian = ca.Function("jacobian", inputs, [matrix], names, ["jacobian"])
        self.value, self.matrix = Buffered(self.residual), Buffered(self.jacobian)
        pattern = self.jacobian.sparsity_out(0)
        self._rows, self._columns = np.array(pattern.row()), np.array(pattern.colind())
        self.step = Buffered(_linear_solves("step", inputs, residual, matrix, residual))
        self._symbols = (inputs, found, matrix)
        self._moving = ((point[Kind.STATE], ode), (point[Kind.INPUT], slope), (time, 1))

    @property
    def entries(self) -> int:
        """Number of entries of the Jacobian."""
        return int(self.jacobian.nnz_out(0))

    def sparse(self, entries: np.ndarray) -> csc_matrix:
        """The entries of a Jacobian as a matrix."""
        return csc_matrix((entries, self._rows, self._columns), shape=self.jacobian.size_out(0))

    def jacobian_values(self, inputs: NewtonInputs) -> np.ndarray:
        """The entries of the Jacobian."""
        return self.matrix(*inputs)[0].copy()

    def solve(
        self,
        inputs: NewtonInputs,
        names: Sequence[str],
        iterations: int,
        shortest: float,
        enough: float,
        *,
        rates: bool,
    ) -> tuple[np.ndarray, np.ndarray]:
        """The root from the unknowns of `inputs`, and the rates of the unknowns, scaled. Raises EquilibriumError."""
        n, known, function = len(inputs.unknowns), inputs[1:], self.step_and_rates if rates else self.step

        def step(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            value, sides = function(v, *known)
            return value.copy(), sides.copy()

        def value(v: np.ndarray) -> np.ndarray:
            return self.value(v, *known)[0]

        v, sides = damped(inputs.unknowns, step, value, names, iterations, shortest, enough)
        return v, -sides[n:]

    @cached_property
    def step_and_rates(self) -> Buffered:
        """As `step`, with the rates: made only where rates are asked for."""
        inputs, found, matrix = self._symbols
        with BUILDING:
            sides = ca.horzcat(found.value, found.along(self._moving))
            return Buffered(_linear_solves("rates", inputs, found.value, matrix, sides))


def solve_sparse(matrix: ca.MX, right: ca.MX) -> ca.MX:
    """Solution of a sparse system, its rows and columns ordered so that chains of spans stay banded.

    CasADi's "csparse" does not reorder them, which would fill in; its "qr" gives NaN where an entry of the pattern is
    zero, as all those across a plane line are."""
    rows, columns = banded_order(matrix.sparsity())
    solution = ca.solve(matrix[rows.tolist(), columns.tolist()], right[rows.tolist(), :], "csparse")
    return solution[np.argsort(columns).tolist(), :]


def banded_order(pattern: ca.Sparsity) -> tuple[np.ndarray, np.ndarray]:
    """Orders of the rows and columns of a square pattern that give it a full diagonal and a narrow band.

    A structurally singular one stays as it is.
    """
    if pattern.nnz() == 0:
        return np.arange(pattern.size1()), np.arange(pattern.size2())
    graph = csr_matrix((np.ones(pattern.nnz()), (pattern.row(), pattern.get_col())), shape=pattern.shape)
    rows = maximum_bipartite_matching(graph, perm_type="row")
    if np.any(rows < 0):
        return np.arange(pattern.size1()), np.arange(pattern.size2())
    order = reverse_cuthill_mckee(graph[rows].tocsr(), symmetric_mode=False)
    return rows[order], order


def _linear_solves(name: str, inputs: Sequence[Any], residual: Any, matrix: Any, sides: Any) -> ca.Function:
    """inputs -> residual, and the solutions of the system of `matrix` for all right-hand `sides`."""
    parts = ca.Function("parts", inputs, [residual, matrix, ca.densify(sides)])
    stop_if_interrupted()
    symbols = parts.mx_in()
    value, system, right = parts(*symbols)
    return ca.Function(name, symbols, [value, solve_sparse(system, right)])


def dense(model: Model, function: ca.Function) -> Buffered:
    """The first result of a function of a model, on arrays, with all its entries."""
    arguments: list[Any] = function.mx_in() if model.external else function.sx_in()
    result = scalar(model, function).call(arguments)[0]
    return Buffered(ca.Function(function.name(), arguments, [ca.densify(result)]))


def _drag(model: Model, v: Any, anchor: Any) -> Any:
    """Displacement of each travel that a residual balances, at the place of that residual."""
    drag = type(v)(len(model.r), 1)
    for balance in model.balances:
        drag[balance.residual] = balance.sign * (v[balance.travel] - anchor[balance.travel])
    return ca.densify(drag)


def _beyond(model: Model, parameter: int, discrete: Any) -> Any:
    """By how much loads come nearer to their spans' ends a, per metre of a span's starting length: 1 for those that
    ride on later spans, as they keep their places along the rope. One entry for each discrete variable."""
    nearer = type(discrete)(discrete.shape[0], 1)
    for layout in model.layouts:
        for span in np.flatnonzero(layout.length_start == parameter):
            for k in range(int(span) + 1, len(layout.length_start)):
                for slot in range(int(layout.slots.count[k])):
                    nearer[int(layout.slots.at[k]) + slot] = discrete[int(layout.slots.ride[k]) + slot]
    return nearer
