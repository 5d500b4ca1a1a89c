"""Several models of one system, one for each configuration, united by a discrete variable that selects one."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from typing import Any

import casadi as ca
import numpy as np

from ropeway.components.check import ANY
from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.model_tables import Limits, VariableTable
from ropeway.systems.modelling.structure import Structure
from ropeway.systems.solvers.points import VECTORS, Point

Read = Callable[[str], ca.SX]
"""Reads a variable or an output of a part."""


@dataclass(frozen=True, eq=False)
class SwitchedPart:
    """One of the models.

    `point`: its start, with the values of its own parameters; `shows`: outputs of the united model, each the largest of
    several own outputs.
    """

    model: Model
    point: Point
    shows: Mapping[str, Sequence[str]]

    @cached_property
    def dae(self) -> ca.Function:
        """Its equations as a scalar graph, which is short for about ten spans, as are its derivatives."""
        return self.model.dae.expand()

    def value(self, parameter: str) -> float | None:
        """Value of a parameter, None if there is none."""
        place = self.model.p.index.get(parameter)
        return None if place is None else float(self.point.p[place])


class SwitchedModel:
    """The united `model` of parts with equal states and inputs; the variable `place` selects the active part.

    Unknowns are united by name; one that is not part of the active model is zero. Outputs are those of all parts;
    parameters those of all parts with equal values: others keep the value of their part's `point`. `limits` maps the
    table of outputs to their limits; `local`: unknowns that not all parts have.
    """

    def __init__(self, parts: Sequence[SwitchedPart], place: str, limits: Callable[[VariableTable], Limits]) -> None:
        self.parts = tuple(parts)
        first = parts[0].model
        every = dict.fromkeys(name for part in parts for name in part.model.z.names)
        owners = {name: next(part.model.z for part in parts if name in part.model.z.index) for name in every}
        self.local = frozenset(n for n in every if not all(n in part.model.z.index for part in parts))
        z = _rows([(owners[n], n, n) for n in every])
        p = _rows([(first.p, n, n) for n in first.p.names if len({part.value(n) for part in parts}) == 1])
        y = _rows([(first.y, of[0], n) for n, of in parts[0].shows.items() if all(n in o.shows for o in parts)])
        d = VariableTable((place,), ("1",), ("number of the active place",), np.zeros(1), np.ones(1), (ANY,))
        r = replace(z, nominals=np.ones(len(z)))
        self._tables = {
            **first.tables,
            Kind.ALGEBRAIC: z,
            Kind.PARAMETER: p,
            Kind.DISCRETE: d,
            Kind.OUTPUT: y,
            Kind.RESIDUAL: r,
        }
        self.symbols = [ca.MX.sym("t"), *(ca.MX.sym(kind.value, len(self._tables[kind])) for kind in VECTORS)]
        self.rates = first.dae(*self._arguments(parts[0], self.symbols))[0]
        self.residuals = self._cases("residuals", self._residuals)
        self.views = self.cases("views", lambda part, read: [_largest(part.shows[n], read) for n in y.names])
        residuals, outputs = self.switched("residuals", self.residuals), self.switched("views", self.views)
        names = ["t", "x", "z", "u", "p", "d"]
        self.model = replace(
            first,
            tables=self._tables,
            structure=Structure(
                ca.Function("dae", self.symbols, [self.rates, residuals(*self.symbols)], names, ["ode", "alg"]),
                ca.Function("outputs", self.symbols, [outputs(*self.symbols)], names, ["y"]),
            ),
            runs=(),
            layouts=(),
            balances=(),
            swaps={},
            limits=limits(y),
            kept=np.zeros(0, dtype=int),
        )

    def cases(self, name: str, of: Callable[[SwitchedPart, Read], Sequence[ca.SX]]) -> list[ca.Function]:
        """Of each part (t, x, z, u, p, d) -> expressions."""

        def expressions(part: SwitchedPart, symbols: Sequence[ca.SX]) -> ca.SX:
            arguments = self._arguments(part, symbols)
            vectors = {
                **dict(zip(VECTORS, arguments[1:], strict=True)),
                Kind.OUTPUT: part.model.outputs.expand()(*arguments),
            }

            def read(variable: str) -> ca.SX:
                kind = next(k for k in vectors if variable in part.model.tables[k].index)
                return vectors[kind][part.model.tables[kind].index[variable]]

            return ca.densify(ca.vertcat(*of(part, read)))

        return self._cases(name, expressions)

    def point(self, i: int) -> Point:
        """Start of part i, as a point of the united model."""
        part = self.parts[i]
        p = np.array([part.value(name) for name in self._tables[Kind.PARAMETER].names], float)
        z = self.unknowns(part, part.point.z)
        return Point(part.point.x.copy(), z, part.point.u.copy(), p, np.array([float(i)]))

    def unknowns(self, part: SwitchedPart, z: np.ndarray) -> np.ndarray:
        """Unknowns of the united model from those of a part."""
        found = np.zeros(len(self._tables[Kind.ALGEBRAIC]))
        found[self._places(part)] = z
        return found

    def switched(self, name: str, functions: Sequence[ca.Function]) -> ca.Function:
        """The function of the active part."""
        if len(functions) == 1:
            return functions[0]
        switch = ca.Function.conditional(name, functions[:-1], functions[-1])
        return ca.Function(f"{name}_of_place", self.symbols, [switch(self.symbols[-1], *self.symbols)])

    def _cases(self, name: str, of: Callable[[SwitchedPart, Sequence[ca.SX]], ca.SX]) -> list[ca.Function]:
        cases = []
        for part in self.parts:
            symbols = [ca.SX.sym(s.name(), s.shape) for s in self.symbols]
            cases.append((symbols, of(part, symbols)))
        pattern = reduce(operator.add, (result.sparsity() for _, result in cases))
        return [
            ca.Function(f"{name}_{i}", symbols, [ca.cse(ca.project(result, pattern))])
            for i, (symbols, result) in enumerate(cases)
        ]

    def _places(self, part: SwitchedPart) -> list[int]:
        """Indices of the unknowns of a part in the united vector."""
        return [self._tables[Kind.ALGEBRAIC].index[name] for name in part.model.z.names]

    def _arguments(self, part: SwitchedPart, symbols: Sequence[Any]) -> list[Any]:
        """Arguments of the functions of a part from those of the united model."""
        t, x, z, u, p, _ = symbols
        shared = self._tables[Kind.PARAMETER].index
        own = ca.vertcat(
            *(p[shared[n]] if n in shared else v for n, v in zip(part.model.p.names, part.point.p, strict=True))
        )
        return [t, x, z[self._places(part)], u, own, part.point.d]

    def _residuals(self, part: SwitchedPart, symbols: Sequence[ca.SX]) -> ca.SX:
        """Residuals in the rows of the unknowns that they determine; unknowns of other parts are zero."""
        z, places = symbols[2], self._places(part)
        own = part.dae(*self._arguments(part, symbols))[1] / part.model.r.nominals
        rows = {places[part.model.determined[i]]: own[i] for i in range(len(places))}
        return ca.vertcat(
            *(rows.get(i, z[i] / nominal) for i, nominal in enumerate(self._tables[Kind.ALGEBRAIC].nominals))
        )


def _largest(names: Sequence[str], read: Read) -> ca.SX:
    return reduce(ca.fmax, [read(name) for name in names])


def _rows(chosen: Sequence[tuple[VariableTable, str, str]]) -> VariableTable:
    """A table from rows of other tables: table, name there, name here."""
    rows = [(table, table.index[name]) for table, name, _ in chosen]
    return VariableTable(
        tuple(name for *_, name in chosen),
        tuple(table.units[i] for table, i in rows),
        tuple(table.descriptions[i] for table, i in rows),
        np.array([table.values[i] for table, i in rows], float),
        np.array([table.nominals[i] for table, i in rows], float),
        tuple(table.ranges[i] for table, i in rows),
    )
