"""Networks of kernels and sparse matrices with their tables in C (see native/network.h)."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching
from scipy.sparse.linalg import splu

from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.native.c_library import CALL_INTEGERS, CallTables
from ropeway.systems.native.network_library import (
    FAILURES,
    NETWORK_INTEGERS,
    MatrixPattern,
    NetworkProblem,
    NetworkTables,
    network_library,
)
from ropeway.systems.solvers.damped_newton import failure
from ropeway.systems.solvers.kernels.kernel_network import Network
from ropeway.systems.solvers.kernels.kernel_parts import compile_all

Entry = tuple[int, int, float]
"""A travel that can be held back: its residual, its unknown, and the sign of its balance."""


class _Tables:
    """Arrays that a structure in C points to. They stay as they are: threads share them."""

    def __init__(self, structure: ctypes.Structure) -> None:
        self.structure, self._kept = structure, list[np.ndarray]()

    def put(self, name: str, values: Sequence[float] | np.ndarray, kind: type[np.generic] = np.int32) -> None:
        """An array of the structure."""
        found = np.ascontiguousarray(values if len(values) else [0], dtype=kind)
        self._kept.append(found)
        setattr(self.structure, name, found.ctypes.data)


class CompiledNetwork:
    """A network in C, whose travels of `balances` can be held back. Raises CompilerError, WriteError, Interrupted."""

    def __init__(self, net: Network, balances: Sequence[Entry] = ()) -> None:
        self._core, self.one, self.rows = network_library(), net.one, np.array(net.rows, dtype=np.intp)
        places = {(i, j): place for i, row in enumerate(net.matrix) for j, place in row.items()}
        for row, column, _ in balances:
            places.setdefault((row, column), -1)
        cells = sorted(places, key=lambda cell: cell[::-1])
        number = {cell: k for k, cell in enumerate(cells)}
        count = len(net.unknowns)
        columns = np.bincount(np.array([column for _, column in cells], dtype=int), minlength=count)
        ends = np.concatenate([[0], np.cumsum(columns)]).astype(np.int32)
        rows = np.array([row for row, _ in cells], dtype=np.int32)
        self.pattern = csc_matrix((np.arange(1.0, len(cells) + 1.0), rows, ends), shape=(count, count))
        """The matrix, with the numbers of its entries from 1."""
        tables, calls = _Tables(NetworkTables()), _Tables(CallTables())
        self._pattern = _Pattern(self.pattern, count)
        arrays: dict[str, Sequence[int] | np.ndarray] = {
            "result": net.results,
            "inputs_end": np.cumsum([len(read) for read in net.inputs]),
            "input": [place for read in net.inputs for place in read],
            "sum": [place for place, _ in net.sums],
            "terms_end": np.cumsum([len(terms) for _, terms in net.sums]),
            "factor": [a for _, terms in net.sums for a, _ in terms],
            "other": [b for _, terms in net.sums for _, b in terms],
            "unknown": net.unknowns,
            "residual": net.rows,
            "drift": net.drifts,
            "entry": [places[cell] for cell in cells],
            "balance_residual": [row for row, _, _ in balances],
            "balance_unknown": [column for _, column, _ in balances],
            "balance_entry": [number[row, column] for row, column, _ in balances],
        }
        for structure, names in ((calls, CALL_INTEGERS), (tables, NETWORK_INTEGERS)):
            for name in names:
                structure.put(name, arrays[name])
        tables.put("sign", [sign for _, _, sign in balances], np.float64)
        compile_all(net.kernels)
        calls.put("kernels", [kernel.address for kernel in net.kernels], np.uint64)
        t = tables.structure
        calls.structure.calls, calls.structure.values = len(net.kernels), net.size
        t.pattern, t.calls, t.sums = self._pattern.structure, calls.structure, len(net.sums)
        t.drifts, t.entries, t.balances = net.drift_sums, len(cells), len(balances)
        self._tables, self._at, self._unknowns = (tables, calls), ctypes.byref(t), count
        self._size = net.size + max((len(read) for read in net.inputs), default=0)

    def problem(
        self, vectors: Sequence[np.ndarray], scaling: Sequence[np.ndarray]
    ) -> tuple[NetworkProblem, np.ndarray]:
        """What a solve is given, and the array behind it: vectors from the beginning of the values; `scaling`: scale,
        weight, target, anchor, each of which may be shorter than the unknowns."""
        n, size = self._unknowns, self._size
        memory = np.zeros(size + 4 * n)
        self._fill(memory, vectors)
        for k, part in enumerate(scaling):
            memory[size + k * n : size + k * n + len(part)] = part
        first = memory.ctypes.data
        return NetworkProblem(first, *(first + 8 * (size + k * n) for k in range(4))), memory

    def _fill(self, memory: np.ndarray, vectors: Sequence[np.ndarray]) -> None:
        at = 0
        for vector in vectors:
            memory[at : at + len(vector)] = vector
            at += len(vector)
        memory[self.one] = 1.0

    def evaluate(self, vectors: Sequence[np.ndarray]) -> np.ndarray:
        """The entries `rows` for the vectors (t, x, z, u, p, d). Raises Interrupted."""
        stop_if_interrupted()
        values = np.empty(self._size)
        self._fill(values, vectors)
        self._core.rn_evaluate(self._at, values.ctypes.data)
        return values[self.rows]

    def matrix(self, problem: NetworkProblem, unknowns: np.ndarray) -> np.ndarray:
        """Entries of the scaled matrix in the order of `pattern`. Raises Interrupted."""
        stop_if_interrupted()
        entries = np.empty(self.pattern.nnz)
        self._core.rn_matrix(self._at, ctypes.byref(problem), unknowns.ctypes.data, entries.ctypes.data)
        return entries

    def root(self, problem: NetworkProblem, start: np.ndarray, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
        """The root from a start, and the rates of the unknowns, all scaled; `names` of the residuals are for the error.
        Raises EquilibriumError, Interrupted."""
        stop_if_interrupted()
        found = np.full((3, len(start)), np.nan)
        found[0] = start
        first, row = found.ctypes.data, found.strides[0]
        code = self._core.rn_solve(self._at, ctypes.byref(problem), first, first + row, first + 2 * row)
        if code:
            residual = None if np.isnan(found[1]).all() else found[1]
            raise failure(residual, FAILURES[code].format(iterations=problem.iterations), names)
        return found[0], found[2]


class _Pattern(_Tables):
    """A sparse pattern in C, of whose columns and rows the first `inner` are eliminated first, among themselves."""

    def __init__(self, pattern: csc_matrix, inner: int) -> None:
        super().__init__(MatrixPattern())
        order, diagonal = elimination_order(pattern[:inner, :inner])
        outer = np.arange(inner, pattern.shape[0])
        self.structure.n, self.structure.inner = pattern.shape[0], inner
        self.put("column_end", pattern.indptr[1:])
        self.put("row", pattern.indices)
        self.put("order", np.concatenate([order, outer]))
        self.put("diagonal", np.concatenate([diagonal, outer]))


class CompiledPivots:
    """The pivots of the last columns of a matrix after the first `inner` are eliminated, from the entries of a larger
    matrix: `places` has their numbers there, from 1."""

    def __init__(self, places: csc_matrix, inner: int) -> None:
        own = places.tocsc()
        own.sort_indices()
        self._core, self._count = network_library(), own.shape[0] - inner
        self._pattern, self._take = _Pattern(own, inner), np.ascontiguousarray(own.data - 1, dtype=np.int32)
        self._at = ctypes.byref(self._pattern.structure)

    def __call__(self, entries: np.ndarray) -> np.ndarray:
        """Zero from the first pivot that is. Raises RuntimeError where the inner matrix is singular."""
        found, taken = np.zeros(self._count), self._take.ctypes.data
        if self._core.rn_pivots(self._at, np.ascontiguousarray(entries).ctypes.data, taken, found.ctypes.data):
            raise RuntimeError("The equations of the others are singular")
        return found


def elimination_order(pattern: csc_matrix) -> tuple[np.ndarray, np.ndarray]:
    """An order of the columns that fills in little, and the row with which each is best eliminated."""
    n = pattern.shape[0]
    matched = maximum_bipartite_matching(csr_matrix(pattern), perm_type="row") if n else np.zeros(0, dtype=int)
    if n == 0 or np.any(matched < 0):  # singular, whatever the order
        return np.arange(n), np.arange(n)
    trial = pattern[matched].tocsc()
    trial.data = np.random.default_rng(1).uniform(1.0, 2.0, trial.nnz)
    trial.setdiag(4.0 * n)
    order = np.argsort(splu(trial, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0).perm_c)
    return order, matched[order]
