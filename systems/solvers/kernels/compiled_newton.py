"""Newton's method in compiled code for any system whose components have equations of their own: the steps and tests of
`Newton`. Kernels of kinds of components are compiled, how they are joined is in tables."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching
from scipy.sparse.linalg import splu

from ropeway.components.errors import CompiledError
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.native.network_library import (
    FAILURES,
    NETWORK_INTEGERS,
    NetworkProblem,
    NetworkTables,
    network_library,
)
from ropeway.systems.solvers.damped_newton import failure
from ropeway.systems.solvers.kernels.kernel_network import (
    Network,
    network,
    network_of_outputs,
    network_of_residuals,
)
from ropeway.systems.solvers.model_functions import NewtonInputs
from ropeway.systems.solvers.points import Slot


class CompiledNetwork:
    """A network with its tables in C. They stay as they are: threads share them, each with values of its own."""

    def __init__(
        self, net: Network, unknowns: Sequence[int] = (), balances: Sequence[tuple[int, int, float]] = ()
    ) -> None:
        self._core, self._kept = network_library(), list[np.ndarray]()
        self.tables, self.one = NetworkTables(), net.one
        self.rows = np.array(net.rows, dtype=np.intp)
        places = {(i, j): place for i, row in enumerate(net.matrix) for j, place in row.items()}
        for row, column, _ in balances:
            places.setdefault((row, column), -1)
        cells = sorted(places, key=lambda cell: cell[::-1])
        number = {cell: k for k, cell in enumerate(cells)}
        count = len(unknowns)
        columns = np.array([column for _, column in cells], dtype=int)
        self.pattern = csc_matrix(
            (
                np.arange(1.0, len(cells) + 1.0),
                np.array([row for row, _ in cells], dtype=np.int32),
                np.concatenate([[0], np.cumsum(np.bincount(columns, minlength=count))]).astype(np.int32),
            ),
            shape=(count, count),
        )
        order, diagonal = _elimination_order(self.pattern)
        sums = net.sums
        tables: dict[str, Sequence[int] | np.ndarray] = {
            "result": net.results,
            "inputs_end": np.cumsum([len(read) for read in net.inputs]),
            "input": [place for read in net.inputs for place in read],
            "sum": [place for place, _ in sums],
            "terms_end": np.cumsum([len(terms) for _, terms in sums]),
            "factor": [a for _, terms in sums for a, _ in terms],
            "other": [b for _, terms in sums for _, b in terms],
            "unknown": unknowns,
            "residual": net.rows,
            "drift": net.drifts,
            "column_end": self.pattern.indptr[1:],
            "row": self.pattern.indices,
            "entry": [places[cell] for cell in cells],
            "order": order,
            "diagonal": diagonal,
            "balance_residual": [row for row, _, _ in balances],
            "balance_unknown": [column for _, column, _ in balances],
            "balance_entry": [number[row, column] for row, column, _ in balances],
        }
        for name in NETWORK_INTEGERS:
            self._keep(name, np.array(tables[name], dtype=np.int32))
        self._keep("sign", np.array([sign for _, _, sign in balances], dtype=float))
        self._keep("kernels", np.array(net.kernels, dtype=np.uint64))
        t = self.tables
        t.unknowns, t.calls, t.values, t.sums = count, len(net.kernels), net.size, len(sums)
        t.drifts, t.entries, t.balances = net.drift_sums, len(cells), len(balances)
        self._size = net.size + max((len(read) for read in net.inputs), default=0)

    def _keep(self, name: str, values: np.ndarray) -> None:
        found = np.ascontiguousarray(values if len(values) else np.zeros(1, dtype=values.dtype))
        self._kept.append(found)
        setattr(self.tables, name, found.ctypes.data)

    def values(self, vectors: Sequence[np.ndarray]) -> np.ndarray:
        """The array of values with its vectors, which stand at its begin, filled in."""
        found, at = np.empty(self._size), 0
        for vector in vectors:
            found[at : at + len(vector)] = vector
            at += len(vector)
        found[self.one] = 1.0
        return found

    def evaluate(self, vectors: Sequence[np.ndarray]) -> np.ndarray:
        """The entries `rows` for the vectors (t, x, z, u, p, d)."""
        stop_if_interrupted()
        values = self.values(vectors)
        self._core.rn_evaluate(ctypes.byref(self.tables), values.ctypes.data)
        return values[self.rows]

    def matrix(self, problem: NetworkProblem, unknowns: np.ndarray) -> np.ndarray:
        """Entries of the scaled matrix in the order of `pattern`."""
        entries = np.zeros(len(self.pattern.data))
        self._core.rn_matrix(*_at(self.tables, problem), unknowns.ctypes.data, entries.ctypes.data)
        return entries

    def solve(self, problem: NetworkProblem, unknowns: np.ndarray, residual: np.ndarray, rates: np.ndarray) -> int:
        """Solves in place; returns a code of `FAILURES`, or 0."""
        arrays = (array.ctypes.data for array in (unknowns, residual, rates))
        return int(self._core.rn_solve(*_at(self.tables, problem), *arrays))


def _at(*structures: ctypes.Structure) -> tuple[Any, ...]:
    return tuple(ctypes.byref(one) for one in structures)


def _elimination_order(pattern: csc_matrix) -> tuple[np.ndarray, np.ndarray]:
    """An order of the columns that fills in little, and the row with which each is best eliminated."""
    n = pattern.shape[0]
    if n == 0:
        return np.arange(0), np.arange(0)
    matched = maximum_bipartite_matching(csr_matrix(pattern), perm_type="row")
    if np.any(matched < 0):  # singular, whatever the order
        return np.arange(n), np.arange(n)
    trial = pattern[matched].tocsc()
    trial.data = np.random.default_rng(1).uniform(1.0, 2.0, trial.nnz)
    trial.setdiag(4.0 * n)
    order = np.argsort(splu(trial, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0).perm_c)
    return order, matched[order]


class CompiledFunctions:
    """As `NewtonFunctions`, in compiled code."""

    def __init__(self, model: Model, freed: tuple[Slot, ...], given: tuple[Slot, ...]) -> None:
        require_kernels(model)
        self._model, self._freed, self._given = model, freed, given
        self.plain = self._compiled(rates=False)

    @cached_property
    def with_rates(self) -> CompiledNetwork:
        """The network that finds rates too: made only where they are asked for."""
        return self._compiled(rates=True)

    def _compiled(self, *, rates: bool) -> CompiledNetwork:
        model, freed, given = self._model, self._freed, self._given
        before = 1 + len(model.x)
        after = before + len(model.z) + len(model.u) + len(model.p) + len(model.d)
        unknowns = [*range(before, before + len(model.z)), *range(after, after + len(freed))]
        balances = [(b.residual, b.travel, b.sign) for b in model.balances]
        return CompiledNetwork(network(model, freed, given, rates=rates), unknowns, balances)

    @property
    def entries(self) -> int:
        """Number of entries of the Jacobian."""
        return len(self.plain.pattern.data)

    def sparse(self, entries: np.ndarray) -> csc_matrix:
        """The entries of a Jacobian as a matrix."""
        pattern = self.plain.pattern
        return csc_matrix((entries, pattern.indices, pattern.indptr), shape=pattern.shape)

    def jacobian_values(self, inputs: NewtonInputs) -> np.ndarray:
        """The entries of the Jacobian."""
        stop_if_interrupted()
        problem, _kept = self._problem(self.plain, inputs)
        return self.plain.matrix(problem, inputs.unknowns)

    def solve(
        self, inputs: NewtonInputs, names: Sequence[str], iterations: int, shortest: float, *, rates: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """The root from the unknowns of `inputs`, and the rates of the unknowns, scaled. Raises EquilibriumError."""
        stop_if_interrupted()
        net = self.with_rates if rates else self.plain
        problem, _kept = self._problem(net, inputs)
        problem.iterations, problem.shortest, problem.rates = iterations, shortest, rates
        v, residual, found = inputs.unknowns.copy(), np.zeros(len(inputs.unknowns)), np.zeros(len(inputs.unknowns))
        code = net.solve(problem, v, residual, found)
        if code:
            raise failure(residual, FAILURES[code].format(iterations=iterations), names)
        return v, found

    def _problem(self, net: CompiledNetwork, inputs: NewtonInputs) -> tuple[NetworkProblem, list[np.ndarray]]:
        """What a solve is given, and the arrays that it points to."""
        n, q = len(inputs.unknowns), inputs
        z, own = np.split(q.unknowns * q.scale, [len(q.anchor)])
        values = net.values([q.t, q.x, z, q.u, q.p, q.d, own])
        if net is not self.plain:  # the rates of the inputs stand behind the number one
            values[net.one + 1 : net.one + 1 + len(q.slope)] = q.slope
        target = np.concatenate([np.zeros(len(self._model.r)), q.target])
        anchor = np.concatenate([q.anchor, np.zeros(n - len(q.anchor))])
        arrays = [values, np.ascontiguousarray(q.scale), q.weight, target, anchor]
        problem = NetworkProblem(*(array.ctypes.data for array in arrays), float(q.damping[0]), 1e-7, 0, 0)
        return problem, arrays


def require_kernels(model: Model) -> None:
    """Raises CompiledError for a model that kernels cannot solve."""
    what = None
    if model.external:
        name = next(c.name for c in model.system.components.values() if c.external)
        what = f"{name!r} has compiled code of its own"
    elif model.inertia is not None:
        what = "its ropes have inertia"
    if what is not None:
        raise CompiledError(f"The compiled core cannot solve {model.name!r}: {what}", "Leave out compiled=True")


def compiled_outputs(model: Model) -> Callable[..., list[np.ndarray]]:
    """The outputs of a model as a function of a point's arguments. Raises CompiledError, CompilerError, WriteError."""
    return _values(model, network_of_outputs)


def compiled_residuals(model: Model) -> Callable[..., list[np.ndarray]]:
    """As `compiled_outputs`, the residuals."""
    return _values(model, network_of_residuals)


def _values(model: Model, network_of: Callable[[Model], Network]) -> Callable[..., list[np.ndarray]]:
    require_kernels(model)
    net = CompiledNetwork(network_of(model))
    return lambda *arguments: [net.evaluate(arguments)]
