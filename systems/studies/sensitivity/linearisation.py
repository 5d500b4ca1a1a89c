"""How a model's vectors move together: exact first derivatives at a solved point.

Columns are directions, one for each quantity that is varied. Where states, inputs, parameters and discrete
variables change with it, the algebraic variables follow from the equations by implicit differentiation.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy.sparse import csc_matrix, diags
from scipy.sparse.linalg import splu

from ropeway.components.errors import EquilibriumError
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.sampled_control import Clock
from ropeway.systems.solvers.newton import VECTORS, Buffered, Point, Vectors, scalar


class Directions(Vectors):
    """Derivatives of the model's vectors at a point, one column a direction: shapes (nx, k), (nz, k), ..."""

    @property
    def stacked(self) -> np.ndarray:
        """All of them, one below the other."""
        return np.vstack(self.vectors)


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

    def solve(self, point: Point, x: np.ndarray, u: np.ndarray, p: np.ndarray, d: np.ndarray) -> Directions:
        """The directions with those of the algebraic variables. Raises EquilibriumError where the equations
        are singular."""
        nx, nz = len(self.model.x), len(self.model.z)
        known = Directions(x, np.zeros((nz, x.shape[1])), u, p, d)
        if nz == 0:
            return known
        matrix = diags(1.0 / self.model.r.nominals) @ self._alg(point)
        try:
            factors = splu((matrix[:, nx : nx + nz] @ diags(self.model.z.nominals)).tocsc())
        except RuntimeError as error:
            raise EquilibriumError("The equations are singular", "This state is at a limit of stability") from error
        z = -factors.solve(matrix @ known.stacked) * self.model.z.nominals[:, None]
        return Directions(x, z, u, p, d)

    def rates(self, point: Point, directions: Directions) -> np.ndarray:
        """Directions of the rates of the states, shape (nx, k)."""
        return np.asarray(self._ode(point) @ directions.stacked)

    def outputs(self, point: Point, directions: Directions) -> np.ndarray:
        """Directions of the outputs, shape (ny, k)."""
        return np.asarray(self._outputs(point) @ directions.stacked)


@kept_with_model
def tangent_of(model: Model) -> Tangent:
    """The derivatives of a model, made once."""
    return Tangent(model)


@kept_with_model
def update_jacobian_of(model: Model, clock: Clock) -> Jacobian:
    """The derivatives of the update of a clock."""
    return Jacobian(model, clock.update)
