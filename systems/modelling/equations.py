"""The equations of a model as scalar graphs, with derivatives: in closed form where components give them, else by
differentiation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.dae_model import Model, kept_with_structure

_QUANTITIES = 11
"""Quantities on which the three residuals of a closure depend."""


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals `value` (n, 1) as a graph. Those in `rows`, in threes, have `derivatives` (3, 11) each by eleven of the
    `quantities`; all of this is empty where there is no closed form."""

    value: Any
    rows: np.ndarray
    quantities: Any
    derivatives: Any

    def scaled(self, factors: Any) -> Residuals:
        """Each residual times a factor, (n, 1)."""
        if not len(self.rows):
            return replace(self, value=self.value * factors)
        own = ca.reshape(factors[self.rows.tolist()], 3, len(self.rows) // 3)
        wide = ca.horzcat(*(ca.repmat(own[:, k], 1, _QUANTITIES) for k in range(own.shape[1])))
        return replace(self, value=self.value * factors, derivatives=self.derivatives * wide)

    def plus(self, value: Any) -> Residuals:
        """With something added to residuals other than those in closed form, (n, 1)."""
        return replace(self, value=self.value + value)

    def and_also(self, value: Any) -> Residuals:
        """With more residuals behind these."""
        return replace(self, value=ca.vertcat(self.value, value))

    def only(self, rows: Sequence[int]) -> Residuals:
        """Some of the residuals: those of a closure all or none."""
        if not len(self.rows):
            return replace(self, value=self.value[list(rows)])
        place = {row: i for i, row in enumerate(rows)}
        spans = [k for k, row in enumerate(self.rows[::3].tolist()) if row in place]
        own = [place[row] for k in spans for row in self.rows[3 * k : 3 * k + 3].tolist()]
        wide = [k * _QUANTITIES + i for k in spans for i in range(_QUANTITIES)]
        return Residuals(
            self.value[list(rows)], np.array(own, dtype=int), self.quantities[wide], self.derivatives[:, wide]
        )

    def jacobian(self, v: Any) -> Any:
        """Derivatives by v, (n, len(v))."""
        if not len(self.rows):
            return ca.jacobian(self.value, v)
        return self._joined(ca.jacobian(self.value[self._others], v), ca.jacobian(self.quantities, v))

    def along(self, moving: Sequence[tuple[Any, Any]]) -> Any:
        """Derivative as quantities move at their rates, (n, 1)."""

        def drift(value: Any) -> Any:
            return sum(ca.jtimes(value, quantity, rate) for quantity, rate in moving)

        if not len(self.rows):
            return drift(self.value)
        return self._joined(drift(self.value[self._others]), drift(self.quantities))

    @property
    def _others(self) -> list[int]:
        return sorted(set(range(self.value.shape[0])) - set(self.rows.tolist()))

    def _joined(self, others: Any, quantities: Any) -> Any:
        """Derivatives of all residuals, from those of the others and of the quantities."""
        blocks = ca.diagcat(*ca.horzsplit(self.derivatives, _QUANTITIES))
        order = np.argsort(np.concatenate([self._others, self.rows]))
        return ca.vertcat(others, ca.mtimes(blocks, quantities))[order.tolist(), :]


@dataclass(frozen=True, eq=False)
class NestedResiduals(Residuals):
    """Residuals with `derivatives` (n, nz) by the algebraic variables, which are the `quantities`; `beside` (n, 1) is
    the part of the value that these do not cover."""

    beside: Any

    def scaled(self, factors: Any) -> NestedResiduals:
        by_z = ca.mtimes(ca.diag(factors), self.derivatives)
        return replace(self, value=self.value * factors, derivatives=by_z, beside=self.beside * factors)

    def plus(self, value: Any) -> NestedResiduals:
        return replace(self, value=self.value + value, beside=self.beside + value)

    def and_also(self, value: Any) -> NestedResiduals:
        none = type(value)(value.shape[0], self.derivatives.shape[1])
        return replace(
            self,
            value=ca.vertcat(self.value, value),
            derivatives=ca.vertcat(self.derivatives, none),
            beside=ca.vertcat(self.beside, value),
        )

    def only(self, rows: Sequence[int]) -> NestedResiduals:
        own = list(rows)
        return replace(self, value=self.value[own], derivatives=self.derivatives[own, :], beside=self.beside[own])

    def jacobian(self, v: Any) -> Any:
        return ca.jacobian(self.beside, v) + ca.mtimes(self.derivatives, ca.jacobian(self.quantities, v))


def equations(model: Model, arguments: Sequence[Any], *, closed: bool = True) -> tuple[Any, Residuals]:
    """Rates of the states and algebraic equations of a model at arguments (t, x, z, u, p, d). Not closed: all of them
    are differentiated, also by parameters and loads."""
    if closed and model.structure.nested is not None:
        *_, by_z, ode, alg = derivatives(model).call(arguments)
        return ode, NestedResiduals(alg, np.zeros(0, dtype=int), arguments[2], by_z, type(alg)(alg.shape[0], 1))
    closures = model.structure.closures if closed else None
    if closures is None:
        ode, alg = expanded(model)(*arguments)
        return ode, Residuals(alg, np.zeros(0, dtype=int), None, None)
    ode, alg, quantities, by_quantities = closures.expanded(*arguments)
    return ode, Residuals(alg, np.array(closures.rows), quantities, by_quantities)


@kept_with_structure
def derivatives(model: Model) -> ca.Function:
    """(t, x, z, u, p, d) -> derivatives of the rates by x and by z, and of the algebraic equations by x and by z; the
    rates and these equations."""
    dae = expanded(model)
    symbols = dae.mx_in() if model.external else dae.sx_in()
    known, count = ca.vertcat(symbols[1], symbols[2]), [0, len(model.x), len(model.x) + len(model.z)]
    nested = model.structure.nested
    if nested is None:
        values = dae.call(symbols)
        found = ca.jacobian(ca.vertcat(*values), known)
    else:
        outer = scalar(model, nested.outer)
        seen = outer.sx_in()
        ode, alg, quantities = outer.call(seen)
        every = ca.vertcat(ode, alg)
        wanted = [ca.jacobian(every, seen[-1]), *(ca.jacobian(v, ca.vertcat(*seen[1:3])) for v in (every, quantities))]
        parts, own = scalar(model, nested.inner).call(symbols)
        moves = ca.Function("outer_moves", seen, [*wanted, ode, alg])
        by_parts, alone, moved, *values = moves.call([*symbols, parts])
        found = ca.sparsify(alone + ca.mtimes(by_parts, ca.mtimes(own, moved)))
    blocks = ca.blocksplit(found, count, count)
    return ca.Function("derivatives", symbols, [block for row in blocks for block in row] + values)


@kept_with_structure
def expanded(model: Model) -> ca.Function:
    """The model's equations for numerical work."""
    return scalar(model, model.dae)


def scalar(model: Model, function: ca.Function) -> ca.Function:
    """A function of a model as one scalar graph; as it is where that cannot be. Raises Interrupted."""
    stop_if_interrupted()
    return function if model.external else function.expand()
