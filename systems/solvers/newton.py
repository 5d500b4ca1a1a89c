"""Newton's method on the scaled algebraic equations of a model, compiled or not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import casadi as ca
import numpy as np
from scipy.sparse import csc_matrix

from ropeway.systems.modelling.dae_model import Model, kept_with_model, kept_with_structure
from ropeway.systems.solvers.kernels.compiled_newton import CompiledFunctions, compiled_outputs, compiled_residuals
from ropeway.systems.solvers.model_functions import NewtonFunctions, NewtonInputs, dense
from ropeway.systems.solvers.points import Point, Slot


class Functions(Protocol):
    """What Newton's method needs of the scaled residuals of a structure: `NewtonFunctions`, or compiled ones."""

    @property
    def entries(self) -> int:
        """Number of entries of the Jacobian."""

    def sparse(self, entries: np.ndarray) -> csc_matrix:
        """The entries of a Jacobian as a matrix."""

    def jacobian_values(self, inputs: NewtonInputs) -> np.ndarray:
        """The entries of the Jacobian."""

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


@kept_with_structure
def newton_functions(model: Model, freed: tuple[Slot, ...], given: tuple[Slot, ...]) -> Functions:
    """The functions of a structure, made once. Of a compiled model raises CompiledError, CompilerError, WriteError."""
    if model.compiled:
        return CompiledFunctions(model, freed, given)
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
        return self.functions.jacobian_values(self.arguments(point))

    def solve(
        self,
        point: Point,
        *,
        target: np.ndarray | None = None,
        slope: np.ndarray | None = None,
        damping: float = 0.0,
        iterations: int = 50,
        shortest: float = 1e-7,
        enough: float = 0.0,
    ) -> np.ndarray | None:
        """Solves in place. With `slope` (nu,), the rates of the inputs, returns those of the algebraic
        variables [per s], shape (nz,), as the states move on.

        A step is shortened to a share of at least `shortest`. With `damping` above 0 each idler's travel is held back
        in proportion to its move from the start. A scaled residual of `enough` is taken for a root. Raises
        EquilibriumError; the point is unchanged then.
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
        v, rates = self.functions.solve(
            inputs, self.model.r.names, iterations, shortest, enough, rates=slope is not None
        )
        self._put(v, point)
        return None if slope is None else rates[: len(point.z)] * self.model.z.nominals

    def _start(self, point: Point) -> np.ndarray:
        freed = [point.vector(kind)[k] for kind, k in self.freed]
        return np.asarray(np.concatenate([point.z, freed]) / self.scale)

    def _put(self, v: np.ndarray, point: Point) -> None:
        values = v * self.scale
        point.z[:] = values[: len(point.z)]
        for value, (kind, k) in zip(values[len(point.z) :], self.freed, strict=True):
            point.vector(kind)[k] = value


@kept_with_model
def newton_of(model: Model) -> Newton:
    """The solver of a model without freed quantities, made once."""
    return Newton(model)


@kept_with_structure
def outputs_of(model: Model) -> Callable[..., list[np.ndarray]]:
    """The model's outputs as a function of a point's arguments, as arrays."""
    if model.compiled:
        return compiled_outputs(model)
    return dense(model, model.outputs)


@kept_with_structure
def residuals_of(model: Model) -> Callable[..., list[np.ndarray]]:
    """The algebraic equations of a model as a function of a point's arguments."""
    if model.compiled:
        return compiled_residuals(model)
    arguments = model.dae.mx_in()
    return dense(model, ca.Function("residuals", arguments, [model.dae.call(arguments)[1]]))


def _nominal(model: Model, slot: Slot) -> float:
    kind, k = slot
    return float(model.tables[kind].nominals[k])
