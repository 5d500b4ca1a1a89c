"""Newton's method in compiled code for any system whose components have equations of their own: the steps and tests of
`Newton`. Kernels of kinds of components are compiled, how they are joined is in tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix

from ropeway.components.errors import CompiledError
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.native.network_library import NetworkProblem
from ropeway.systems.solvers.kernels.compiled_network import CompiledNetwork
from ropeway.systems.solvers.kernels.kernel_network import (
    Network,
    block_network,
    network_of_outputs,
    network_of_residuals,
    newton_network,
)
from ropeway.systems.solvers.model_functions import NewtonInputs
from ropeway.systems.solvers.points import Point, Slot


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
        balances = [(b.residual, b.travel, b.sign) for b in model.balances]
        return CompiledNetwork(newton_network(model, freed, given, rates=rates), balances)

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
        problem, _kept = self._problem(self.plain, inputs)
        return self.plain.matrix(problem, inputs.unknowns)

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
        """The root from the unknowns of `inputs`, and the rates of the unknowns, scaled; always as accurate as rounding
        allows. Raises EquilibriumError."""
        net = self.with_rates if rates else self.plain
        problem, _kept = self._problem(net, inputs)
        problem.iterations, problem.shortest, problem.rates = iterations, shortest, rates
        return net.root(problem, inputs.unknowns, names)

    def _problem(self, net: CompiledNetwork, q: NewtonInputs) -> tuple[NetworkProblem, np.ndarray]:
        """What a solve is given, and the array behind it. The unknowns are written into the vectors later."""
        nothing, residuals = np.zeros(len(q.anchor)), len(q.weight) - len(q.target)
        vectors = [q.t, q.x, nothing, q.u, q.p, q.d, np.zeros(len(self._freed))]
        if net is not self.plain:  # rates of the inputs stand behind the number one
            vectors += [np.ones(1), q.slope]
        target = np.concatenate([np.zeros(residuals), q.target]) if len(q.target) else q.target
        problem, memory = net.problem(vectors, (q.scale, q.weight, target, q.anchor))
        problem.damping = float(q.damping[0])
        return problem, memory


class CompiledBlock:
    """Some residuals of a model in compiled code, solved for as many algebraic variables `columns`."""

    def __init__(self, model: Model, rows: np.ndarray, columns: np.ndarray) -> None:
        require_kernels(model)
        self.columns, self._names = columns, tuple(model.r.names[i] for i in rows)
        self._net = CompiledNetwork(block_network(model, rows.tolist(), columns.tolist()))
        self._scaling = (model.z.nominals[columns], 1.0 / model.r.nominals[rows])

    def solve(self, point: Point, x_rate: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The variables from their values at a point, and their rates [per s], for those of the states and inputs.
        Raises EquilibriumError."""
        scale, time = self._scaling[0], np.array([point.t])
        problem, _kept = self._net.problem([time, *point.vectors, np.ones(1), x_rate, slope], self._scaling)
        problem.iterations, problem.shortest, problem.rates = 50, 1e-7, True
        v, rates = self._net.root(problem, point.z[self.columns] / scale, self._names)
        return v * scale, rates * scale


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
