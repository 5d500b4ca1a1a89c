"""Damped Newton's method on the scaled algebraic equations of a model."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching, reverse_cuthill_mckee

from ropeway.components.variable import Kind
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.dae_model import Model, kept_with_model, kept_with_structure
from ropeway.systems.solvers.damped_newton import damped

Slot = tuple[Kind, int]
"""An entry of one of the model's vectors."""

VECTORS = {
    Kind.STATE: "x",
    Kind.ALGEBRAIC: "z",
    Kind.INPUT: "u",
    Kind.PARAMETER: "p",
    Kind.DISCRETE: "d",
}
"""The vectors of a model in the order of its functions' arguments, and what each is called."""


@dataclass(frozen=True)
class Vectors:
    """One array for each vector of a model."""

    x: np.ndarray
    z: np.ndarray
    u: np.ndarray
    p: np.ndarray
    d: np.ndarray

    def vector(self, kind: Kind) -> np.ndarray:
        """The array of a kind."""
        return np.asarray(getattr(self, VECTORS[kind]))

    @property
    def vectors(self) -> tuple[np.ndarray, ...]:
        """All of them, in the order of `VECTORS`."""
        return (self.x, self.z, self.u, self.p, self.d)


@dataclass(frozen=True)
class Point(Vectors):
    """A point of the model: the values of all vectors, and the time [s]."""

    t: float = 0.0

    @property
    def arguments(self) -> tuple[np.ndarray, ...]:
        """Arguments of the model's functions."""
        return (np.array([self.t]), self.x, self.z, self.u, self.p, self.d)

    def copy(self) -> Point:
        """With vectors of its own."""
        x, z, u, p, d = (vector.copy() for vector in self.vectors)
        return Point(x, z, u, p, d, self.t)


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


class NewtonFunctions:
    """The scaled residuals of a structure, their Jacobian and Newton's step, for `freed` and `given` entries."""

    def __init__(self, model: Model, freed: tuple[Slot, ...], given: tuple[Slot, ...]) -> None:
        sym, count = model.sym, len(model.z) + len(freed)
        v, scale, weight = sym("v", count), sym("scale", count), sym("weight", len(model.r) + len(given))
        time, point = sym("t"), {kind: sym(kind.value, len(model.tables[kind])) for kind in VECTORS}
        full = {**point, Kind.ALGEBRAIC: v[: len(model.z)] * scale[: len(model.z)]}
        for i, (kind, k) in enumerate(freed, len(model.z)):
            entries = ca.vertsplit(full[kind])
            entries[k] = v[i] * scale[i]
            full[kind] = ca.vertcat(*entries)
            if kind is Kind.PARAMETER:
                full[Kind.DISCRETE] -= _beyond(model, k, full[Kind.DISCRETE]) * (entries[k] - point[kind][k])
        arguments = [time, *(full[kind] for kind in VECTORS)]
        ode, alg = expanded(model)(*arguments)
        target, damping = sym("target", len(given)), sym("damping")
        anchor, slope = sym("anchor", len(model.z)), sym("slope", len(model.u))
        residual = alg * weight[: len(model.r)] - damping * _drag(model, v, anchor)
        if given:
            y = scalar(model, model.outputs)(*arguments)
            chosen = ca.vertcat(*(y[k] if kind is Kind.OUTPUT else full[kind][k] for kind, k in given))
            residual = ca.vertcat(residual, (chosen - target) * weight[len(model.r) :])
        known = {letter: point[kind] for kind, letter in VECTORS.items() if kind is not Kind.ALGEBRAIC}
        nominals = {"scale": scale, "weight": weight}
        inputs = NewtonInputs(v, time, **known, target=target, damping=damping, anchor=anchor, slope=slope, **nominals)
        names = list(NewtonInputs._fields)
        self.residual = ca.Function("residual", inputs, [residual], names, ["residual"])
        matrix = ca.jacobian(residual, v)
        stop_if_interrupted()
        self.jacobian = ca.Function("jacobian", inputs, [matrix], names, ["jacobian"])
        self.value, self.matrix = Buffered(self.residual), Buffered(self.jacobian)
        pattern = self.jacobian.sparsity_out(0)
        self._rows, self._columns = np.array(pattern.row()), np.array(pattern.colind())
        self.step = Buffered(_linear_solves("step", inputs, residual, matrix, residual))
        self._symbols = (inputs, residual, matrix)
        self._moving = ((point[Kind.STATE], ode), (point[Kind.INPUT], slope), (time, 1))

    def sparse(self, entries: np.ndarray) -> csc_matrix:
        """The entries of a Jacobian as a matrix."""
        return csc_matrix((entries, self._rows, self._columns), shape=self.jacobian.size_out(0))

    def matrix_places(self) -> csc_matrix:
        """The pattern of the Jacobian with the number of each of its entries, from 1."""
        return self.sparse(np.arange(1, self.jacobian.nnz_out(0) + 1))

    @cached_property
    def step_and_rates(self) -> Buffered:
        """As `step`, with the rates: made only where rates are asked for."""
        inputs, residual, matrix = self._symbols
        drift = sum(ca.jtimes(residual, moving, rate) for moving, rate in self._moving)
        return Buffered(_linear_solves("rates", inputs, residual, matrix, ca.horzcat(residual, drift)))


@kept_with_structure
def newton_functions(model: Model, freed: tuple[Slot, ...], given: tuple[Slot, ...]) -> NewtonFunctions:
    """The functions of a structure, made once."""
    return NewtonFunctions(model, freed, given)


class Newton:
    """Solves a model's algebraic equations for its algebraic variables and, in exchange for `given` values
    of variables or outputs, for the `freed` entries of its other vectors."""

    def __init__(self, model: Model, freed: Sequence[Slot] = (), given: Sequence[Slot] = ()) -> None:
        self.model = model
        self.freed = tuple(freed)
        self.functions = newton_functions(model, self.freed, tuple(given))
        self.scale = np.concatenate([model.z.nominals, [_nominal(model, slot) for slot in freed]])
        self._weight = 1.0 / np.concatenate([model.r.nominals, [_nominal(model, slot) for slot in given]])
        self._target, self._damping, self._slope = np.zeros(len(given)), np.zeros(1), np.zeros(len(model.u))

    def arguments(self, point: Point) -> NewtonInputs:
        """Inputs of the residual and the Jacobian at a point, without target and damping."""
        return NewtonInputs(
            unknowns=self._start(point),
            t=np.array([point.t]),
            x=point.x,
            u=point.u,
            p=point.p,
            d=point.d,
            target=self._target,
            damping=self._damping,
            anchor=point.z / self.model.z.nominals,
            slope=self._slope,
            scale=self.scale,
            weight=self._weight,
        )

    def matrix(self, point: Point) -> csc_matrix:
        """The Jacobian of the scaled residuals by the scaled unknowns at a point."""
        return self.functions.sparse(self.jacobian_values(point))

    def jacobian_values(self, point: Point) -> np.ndarray:
        """The entries of `matrix` in the order of its pattern."""
        return self.functions.matrix(*self.arguments(point))[0].copy()

    def solve(
        self,
        point: Point,
        *,
        target: np.ndarray | None = None,
        slope: np.ndarray | None = None,
        damping: float = 0.0,
        iterations: int = 50,
        shortest: float = 1e-7,
    ) -> np.ndarray | None:
        """Solves in place. With `slope` (nu,), the rates of the inputs, returns those of the algebraic
        variables [per s], shape (nz,), as the states move on.

        A step is shortened to a share of at least `shortest`. With `damping` above 0 each idler's travel is held back
        in proportion to its move from the start.
        Raises EquilibriumError; the point is unchanged then.
        """
        n = len(self.scale)
        if n == 0:
            return None if slope is None else np.zeros(0)
        inputs = self.arguments(point)
        if damping > 0.0:
            inputs = inputs._replace(damping=np.array([damping]))
        if target is not None:
            inputs = inputs._replace(target=target)
        if slope is not None:
            inputs = inputs._replace(slope=slope)
        known = inputs[1:]
        function = self.functions.step if slope is None else self.functions.step_and_rates

        def step(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            value, sides = function(v, *known)
            return value.copy(), sides.copy()

        def value(v: np.ndarray) -> np.ndarray:
            return self.functions.value(v, *known)[0]

        v, sides = damped(inputs.unknowns, step, value, self.model.r.names, iterations, shortest)
        self._put(v, point)
        return None if slope is None else -sides[n : n + len(point.z)] * self.model.z.nominals

    def _start(self, point: Point) -> np.ndarray:
        freed = [point.vector(kind)[k] for kind, k in self.freed]
        return np.asarray(np.concatenate([point.z, freed]) / self.scale)

    def _put(self, v: np.ndarray, point: Point) -> None:
        values = v * self.scale
        point.z[:] = values[: len(point.z)]
        for value, (kind, k) in zip(values[len(point.z) :], self.freed, strict=True):
            point.vector(kind)[k] = value


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


@kept_with_structure
def expanded(model: Model) -> ca.Function:
    """The model's equations for numerical work."""
    return scalar(model, model.dae)


def scalar(model: Model, function: ca.Function) -> ca.Function:
    """A function of a model as one scalar graph; as it is where that cannot be. Raises Interrupted."""
    stop_if_interrupted()
    return function if model.external else function.expand()


def dense(model: Model, function: ca.Function) -> Buffered:
    """The first result of a function of a model, on arrays, with all its entries."""
    arguments: list[Any] = function.mx_in() if model.external else function.sx_in()
    result = scalar(model, function).call(arguments)[0]
    return Buffered(ca.Function(function.name(), arguments, [ca.densify(result)]))


@kept_with_structure
def outputs_of(model: Model) -> Buffered:
    """The model's outputs as a function of a point's arguments, as arrays."""
    return dense(model, model.outputs)


@kept_with_structure
def residuals_of(model: Model) -> Buffered:
    """The algebraic equations of a model as a function of a point's arguments."""
    arguments = model.dae.mx_in()
    return dense(model, ca.Function("residuals", arguments, [model.dae.call(arguments)[1]]))


def _nominal(model: Model, slot: Slot) -> float:
    kind, k = slot
    return float(model.tables[kind].nominals[k])


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


@kept_with_model
def newton_of(model: Model) -> Newton:
    """The solver of a model without freed quantities, made once."""
    return Newton(model)
