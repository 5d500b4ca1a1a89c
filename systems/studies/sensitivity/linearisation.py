"""How a model's vectors move together: exact first derivatives at a solved point.

Columns are directions, one for each quantity that is varied. Where states, inputs, parameters and discrete
variables change with it, the algebraic variables follow from the equations by implicit differentiation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.sparse import csc_matrix, diags, vstack
from scipy.sparse.linalg import splu

from ropeway.components.errors import EquilibriumError
from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.equations import scalar
from ropeway.systems.modelling.sampled_control import Clock
from ropeway.systems.solvers.model_functions import Buffered
from ropeway.systems.solvers.points import VECTORS, Point, Slot, Vectors

_SMALL = 120
"""Number of algebraic variables up to which dense matrices are faster."""


class Directions(Vectors):
    """Derivatives of the model's vectors at a point, one column a direction: shapes (nx, k), (nz, k), ..."""

    @property
    def stacked(self) -> np.ndarray:
        """All of them, one below the other."""
        return np.vstack(self.vectors)


@dataclass(frozen=True)
class Exchange:
    """Entries of the vectors that are `freed` in exchange for `given` values, which change by `rates` (given, k)."""

    freed: Sequence[Slot]
    given: Sequence[Slot]
    rates: np.ndarray


class Jacobian:
    """The derivatives of one result of a model's function by all of the model's vectors, as a sparse matrix."""

    def __init__(self, model: Model, function: ca.Function, result: int = 0) -> None:
        sizes = [len(model.tables[kind]) for kind in VECTORS]
        everything, time = model.sym("v", sum(sizes)), model.sym("t")
        parts = ca.vertsplit(everything, np.concatenate([[0], np.cumsum(sizes)]).tolist())
        matrix = ca.jacobian(scalar(model, function).call([time, *parts])[result], everything)
        pattern = matrix.sparsity()
        self._rows, self._columns, self._shape = np.array(pattern.row()), np.array(pattern.colind()), matrix.shape
        self._f = Buffered(ca.Function("jacobian", [time, everything], [matrix]))

    def __call__(self, point: Point) -> csc_matrix:
        """At a point."""
        values = self._f(np.array([point.t]), np.concatenate(point.vectors))[0]
        return csc_matrix((values.copy(), self._rows, self._columns), shape=self._shape)


class Tangent:
    """The directions of a model's algebraic variables, rates and outputs."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self._ode = Jacobian(model, model.dae)
        self._alg = Jacobian(model, model.dae, result=1)
        self._outputs = Jacobian(model, model.outputs)
        sizes = np.cumsum([0, *(len(model.tables[kind]) for kind in VECTORS)]).tolist()
        self._first = dict(zip(VECTORS, sizes, strict=False))

    def solve(
        self, point: Point, x: np.ndarray, u: np.ndarray, p: np.ndarray, d: np.ndarray, exchange: Exchange | None = None
    ) -> Directions:
        """The directions with those of the algebraic variables, and of what is freed in an exchange. Raises
        EquilibriumError where the equations are singular."""
        m = self.model
        found = Directions(x.copy(), np.zeros((len(m.z), x.shape[1])), u.copy(), p.copy(), d)
        unknown = [(Kind.ALGEBRAIC, k) for k in range(len(m.z))] + list(exchange.freed if exchange else ())
        if not unknown:
            return found
        matrix = self._equations(point, () if exchange is None else exchange.given)
        right = -(matrix @ found.stacked)
        if exchange is not None:
            right[len(m.z) :] += exchange.rates
        nominals = np.array([m.tables[kind].nominals[k] for kind, k in unknown])
        places = [self._first[kind] + k for kind, k in unknown]
        try:
            if isinstance(matrix, np.ndarray):
                solution = np.linalg.solve(matrix[:, places] * nominals, right)
            else:
                solution = splu((matrix[:, places] @ diags(nominals)).tocsc()).solve(right)
        except (RuntimeError, np.linalg.LinAlgError) as error:
            raise EquilibriumError("The equations are singular", "This state is at a limit of stability") from error
        moved = solution * nominals[:, None]
        found.z[:] = moved[: len(m.z)]
        for (kind, k), rates in zip(unknown[len(m.z) :], moved[len(m.z) :], strict=True):
            found.vector(kind)[k] += rates
        return found

    def _equations(self, point: Point, given: Sequence[Slot]) -> np.ndarray | csc_matrix:
        """The derivatives of the scaled residuals and of given values by all vectors; dense for a small model."""
        alg, nominals = self._alg(point), self.model.r.nominals
        rows = np.zeros((len(given), alg.shape[1]))
        for row, (kind, k) in zip(rows, given, strict=True):
            if kind is Kind.OUTPUT:
                row[:] = self._outputs(point)[[k]].toarray()[0]
            else:
                row[self._first[kind] + k] = 1.0
        if len(nominals) <= _SMALL:
            return np.vstack([alg.toarray() / nominals[:, None], rows])
        return vstack([diags(1.0 / nominals) @ alg, csc_matrix(rows)]).tocsc()

    def rates(self, point: Point, directions: Directions) -> np.ndarray:
        """Directions of the rates of the states, shape (nx, k)."""
        return np.asarray(self._ode(point) @ directions.stacked)

    def outputs(self, point: Point, directions: Directions) -> np.ndarray:
        """Directions of the outputs, shape (ny, k)."""
        return np.asarray(self._outputs(point) @ directions.stacked)


@dataclass(frozen=True)
class LinearState:
    """A solved state, and how its quantities change with those that are varied. `read` gives the value of a quantity,
    `slot` its vector and entry; `outputs` (ny, k) and `directions`: the derivatives; `offset` (nz, k): of algebraic
    variables that count from another state."""

    read: Callable[[str], float]
    slot: Callable[[str], Slot]
    outputs: np.ndarray
    directions: Directions
    offset: np.ndarray | None = None

    def rates(self, name: str) -> np.ndarray:
        """Derivatives of a quantity, (k,). Raises UnknownNameError."""
        kind, k = self.slot(name)
        if kind is Kind.OUTPUT:
            return np.asarray(self.outputs[k])
        rates = self.directions.vector(kind)[k]
        return np.asarray(rates if kind is not Kind.ALGEBRAIC or self.offset is None else rates - self.offset[k])


@kept_with_model
def tangent_of(model: Model) -> Tangent:
    """The derivatives of a model, made once."""
    return Tangent(model)


@kept_with_model
def update_jacobian_of(model: Model, clock: Clock) -> Jacobian:
    """The derivatives of the update of a clock."""
    return Jacobian(model, clock.update)
