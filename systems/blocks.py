"""The independent parts of a model's algebraic equations.

With the states given, control sheaves and drums cut a line into sections that do not know of each other. A
crossing touches one or two of them, and only these are solved anew.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import casadi as ca
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from ropeway.components.component import Kind
from ropeway.systems.model import Model
from ropeway.systems.newton import VECTORS, Buffered, Point, damped, expanded


class Blocks:
    """The parts; `of` (nz,) is the part of each algebraic variable."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self._sx = {kind: ca.SX.sym(kind.value, len(model.tables[kind])) for kind in VECTORS}
        self._time, self._slope = ca.SX.sym("t"), ca.SX.sym("slope", len(model.u))
        self._ode, alg = expanded(model)(self._time, *(self._sx[kind] for kind in VECTORS))
        self._alg = alg / model.r.nominals
        pattern = ca.jacobian_sparsity(self._alg, self._sx[Kind.ALGEBRAIC])
        rows, columns, n = np.array(pattern.row()), np.array(pattern.get_col()), len(model.z)
        graph = csr_matrix((np.ones(len(rows)), (rows, n + columns)), shape=(2 * n, 2 * n))
        _, label = connected_components(graph, directed=False)
        self.of = label[n:]
        self._row_of = label[:n]
        self._steps: dict[int, tuple[np.ndarray, Buffered, Buffered]] = {}

    def _functions(self, block: int) -> tuple[np.ndarray, Buffered, Buffered]:
        """Columns of a part, its residual, and residual with solved steps; made when first used."""
        if block not in self._steps:
            model, sx = self.model, self._sx
            columns = np.flatnonzero(self.of == block)
            z = sx[Kind.ALGEBRAIC]
            residual = self._alg[np.flatnonzero(self._row_of == block).tolist()]
            jacobian = ca.jacobian(residual, ca.vertcat(*(z[int(c)] for c in columns)))
            jacobian = ca.mtimes(jacobian, ca.diag(ca.SX(model.z.nominals[columns])))
            drift = (
                ca.jtimes(residual, sx[Kind.STATE], self._ode)
                + ca.jtimes(residual, sx[Kind.INPUT], self._slope)
                + ca.jtimes(residual, self._time, 1)
            )
            inputs = [self._time, *(sx[kind] for kind in VECTORS), self._slope]
            parts = ca.Function("parts", inputs, [residual, jacobian, ca.densify(ca.horzcat(residual, drift))])
            symbols = [ca.MX.sym(f"a{i}", *parts.size_in(i)) for i in range(parts.n_in())]
            value, matrix, sides = parts(*symbols)
            step = ca.Function("step", symbols, [value, ca.solve(matrix, sides, "csparse")])
            self._steps[block] = (columns, Buffered(ca.Function("value", inputs, [residual])), Buffered(step))
        return self._steps[block]

    def solve(self, point: Point, blocks: Iterable[int], slope: np.ndarray, rates: np.ndarray) -> None:
        """Solves some parts in place, and puts the rates of their variables into `rates` (nz,) [per s].

        Raises EquilibriumError.
        """
        for block in blocks:
            self._solve(point, block, slope, rates)

    def _solve(self, point: Point, block: int, slope: np.ndarray, rates: np.ndarray) -> None:
        columns, value, step = self._functions(block)
        nominal, z, n = self.model.z.nominals[columns], point.z.copy(), len(columns)
        arguments = [np.array([point.t]), point.x, z, point.u, point.p, point.d, slope]

        def value_at(v: np.ndarray) -> np.ndarray:
            z[columns] = v * nominal
            return value(*arguments)[0]

        def step_at(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            z[columns] = v * nominal
            residual, sides = step(*arguments)
            return residual.copy(), sides.copy()

        names = [self.model.r.names[i] for i in np.flatnonzero(self._row_of == block)]
        v, sides = damped(z[columns] / nominal, step_at, value_at, names)
        point.z[columns] = v * nominal
        rates[columns] = -sides[n : 2 * n] * nominal


@lru_cache(maxsize=16)
def blocks_of(model: Model) -> Blocks:
    """The parts of a model: found once, as their functions take a while to build."""
    return Blocks(model)
