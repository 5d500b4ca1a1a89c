"""The independent blocks of a model's algebraic equations.

For given states, control sheaves and drums separate a line into sections that are independent of each other. A crossing
changes one or two of them, and only these are solved again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import BUILDING, Model, kept_with_model
from ropeway.systems.modelling.equations import equations
from ropeway.systems.solvers.damped_newton import damped
from ropeway.systems.solvers.kernels.compiled_newton import CompiledBlock
from ropeway.systems.solvers.model_functions import Buffered, solve_sparse
from ropeway.systems.solvers.points import VECTORS, Point


@dataclass(frozen=True)
class _Block:
    """A block: its columns and residuals, the entries of the model's vectors that it depends on, its residual, and its
    residual with Newton step and rates.
    """

    columns: np.ndarray
    names: tuple[str, ...]
    used: tuple[np.ndarray, ...]
    value: Buffered
    step: Buffered
    nominal: np.ndarray

    def solve(self, point: Point, x_rate: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The variables from their values at a point, and their rates [per s], for those of the states and inputs.
        Raises EquilibriumError."""
        nominal, n = self.nominal, len(self.columns)
        x, z, u, p, d = (vector[places] for vector, places in zip(point.vectors, self.used, strict=True))
        rest = [u, p, d, x_rate[self.used[0]], slope[self.used[2]]]
        v, sides = damped(
            z / nominal,
            _copied(self.step, [np.array([point.t]), x], nominal, rest),
            _copied(self.value, [np.array([point.t]), x], nominal, rest),
            self.names,
        )
        return v * nominal, -sides[n : 2 * n] * nominal


class Blocks:
    """The blocks of a model; `of` (nz,) is the number of the block of each algebraic variable."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self._symbols = {kind: model.sym(kind.value, len(model.tables[kind])) for kind in VECTORS}
        self._time = model.sym("t")
        self._rate, self._slope = model.sym("rate", len(model.x)), model.sym("slope", len(model.u))
        found = equations(model, [self._time, *(self._symbols[kind] for kind in VECTORS)])[1]
        self._alg = found.scaled(ca.DM(1.0 / model.r.nominals))
        pattern = ca.jacobian_sparsity(self._alg.value, self._symbols[Kind.ALGEBRAIC])
        rows, columns, n = np.array(pattern.row()), np.array(pattern.get_col()), len(model.z)
        graph = csr_matrix((np.ones(len(rows)), (rows, n + columns)), shape=(2 * n, 2 * n))
        # Without a scalar graph, blocks save nothing.
        label = np.zeros(2 * n, dtype=int) if model.external else connected_components(graph, directed=False)[1]
        self.of = label[n:]
        self._row_of = label[:n]
        self._blocks: dict[int, _Block | CompiledBlock] = {}

    def _block(self, number: int) -> _Block | CompiledBlock:
        """A block; its functions, of its own variables only, are made at the first use."""
        if number not in self._blocks:
            with BUILDING:
                self._blocks[number] = self._made(number)
        return self._blocks[number]

    def _made(self, number: int) -> _Block | CompiledBlock:
        rows = np.flatnonzero(self._row_of == number)
        if self.model.compiled:
            return CompiledBlock(self.model, rows, np.flatnonzero(self.of == number))
        found = self._alg.only(rows.tolist())
        residual = found.value
        used = tuple(self._used(residual, kind) for kind in VECTORS)
        x, z, u, p, d = (_entries(self._symbols[kind], places) for kind, places in zip(VECTORS, used, strict=True))
        rate, slope = _entries(self._rate, used[0]), _entries(self._slope, used[2])
        columns = used[1]
        drift = found.along([(x, rate), (u, slope), (self._time, 1)])
        jacobian = ca.mtimes(found.jacobian(z), ca.diag(ca.DM(self.model.z.nominals[columns])))
        inputs = [self._time, x, z, u, p, d, rate, slope]
        parts = ca.Function("parts", inputs, [residual, jacobian, ca.densify(ca.horzcat(residual, drift))])
        symbols = parts.mx_in()
        value, matrix, sides = parts(*symbols)
        return _Block(
            columns,
            tuple(self.model.r.names[i] for i in rows),
            used,
            Buffered(ca.Function("value", inputs, [residual])),
            Buffered(ca.Function("step", symbols, [value, solve_sparse(matrix, sides)])),
            self.model.z.nominals[columns],
        )

    def _used(self, residual: Any, kind: Kind) -> np.ndarray:
        """Entries of a vector that a residual depends on; without a scalar graph all of them."""
        if self.model.external:
            return np.arange(len(self.model.tables[kind]))
        return np.unique(np.array(ca.jacobian_sparsity(residual, self._symbols[kind]).get_col(), dtype=int))

    def solve(
        self, point: Point, blocks: Iterable[int], x_rate: np.ndarray, slope: np.ndarray, rates: np.ndarray
    ) -> None:
        """Solves some blocks in place, and writes the rates of their variables to `rates` (nz,) [per s], for rates
        `x_rate` of the states and `slope` of the inputs. Raises EquilibriumError."""
        for number in blocks:
            block = self._block(number)
            point.z[block.columns], rates[block.columns] = block.solve(point, x_rate, slope)


def _entries(vector: Any, places: np.ndarray) -> Any:
    if len(places) == vector.numel():
        return vector
    return ca.vertcat(ca.SX(0, 1), *(vector[int(i)] for i in places))


def _copied(
    function: Buffered, before: list[np.ndarray], nominal: np.ndarray, after: list[np.ndarray]
) -> Callable[[np.ndarray], Any]:
    """A function of the scaled unknowns alone, with results of its own: one array, or a tuple of them."""

    def at(v: np.ndarray) -> Any:
        results = [result.copy() for result in function(*before, v * nominal, *after)]
        return results[0] if len(results) == 1 else tuple(results)

    return at


@kept_with_model
def blocks_of(model: Model) -> Blocks:
    """The blocks of a model, made once."""
    return Blocks(model)
