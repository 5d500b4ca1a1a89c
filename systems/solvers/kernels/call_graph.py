"""The equations of a model as calls of its components' functions, joined entry by entry.

Each entry of an input of a call is an entry of the model's vectors, a result of an earlier call, a constant, or an
expression of these, such as a position beside a node.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.solvers.model_functions import with_freed
from ropeway.systems.solvers.points import VECTORS, Slot


@dataclass(frozen=True, eq=False)
class Call:
    """A call of a component's function: the entries of its inputs, and the symbols of its results, both by argument."""

    function: ca.Function
    inputs: tuple[tuple[Any, ...], ...]
    results: tuple[tuple[Any, ...], ...]


@dataclass(frozen=True, eq=False)
class CallGraph:
    """Calls in the order in which they can be made, the symbols of the `vectors` that they read, and the entries of
    some `results`. Of a model these are its rates, residuals and outputs; the vectors are t, x, z, u, p, d, then what
    is freed; `full` are its vectors with what is freed."""

    calls: tuple[Call, ...]
    vectors: tuple[tuple[Any, ...], ...]
    results: tuple[tuple[Any, ...], ...]
    full: dict[Any, Any]

    @property
    def ode(self) -> tuple[Any, ...]:
        """Rates of a model."""
        return self.results[0]

    @property
    def alg(self) -> tuple[Any, ...]:
        """Residuals of a model."""
        return self.results[1]

    @property
    def y(self) -> tuple[Any, ...]:
        """Outputs of a model."""
        return self.results[2]


def call_graph(model: Model, freed: tuple[Slot, ...], *, outputs: bool) -> CallGraph:
    """The calls of a model where entries are freed; outputs: with its outputs, which have calls of their own. Raises
    Interrupted."""
    dae = model.dae
    arguments = [ca.MX.sym(dae.name_in(i), dae.sparsity_in(i)) for i in range(dae.n_in())]
    found = [*dae.call(arguments, True, False)]
    found.append(model.outputs.call(arguments, True, False)[0] if outputs else ca.MX(0, 1))
    given = _scalars(arguments)
    values = ca.SX.sym("freed", len(freed))
    point = dict(zip(VECTORS, given[1:], strict=True))
    full = with_freed(model, point, freed, ca.vertsplit(values) if freed else [])
    calls, results = _joined(arguments, found, [given[0], *full.values()])
    return CallGraph(calls, tuple(map(_entries, (*given, values))), results, full)


def graph_of(arguments: Sequence[ca.MX], results: Sequence[ca.MX], inlined: Sequence[ca.Function] = ()) -> CallGraph:
    """The calls of some results; functions that are `inlined` are no calls, but those within them are. Raises
    Interrupted."""
    given, found = _scalars(arguments), list(results)
    names = {function.__hash__() for function in inlined}
    for node in _calls(arguments, found):
        function = node.which_function()
        if function.__hash__() in names:
            own = function.call([node.dep(i) for i in range(node.n_dep())], True, False)
            made = [node.get_output(i) for i in range(function.n_out())]
            found = ca.graph_substitute(found, made, own)
    calls, entries = _joined(arguments, found, given)
    return CallGraph(calls, tuple(map(_entries, given)), entries, {})


def _scalars(arguments: Sequence[ca.MX]) -> list[ca.SX]:
    return [ca.SX.sym(f"v{i}", argument.sparsity()) for i, argument in enumerate(arguments)]


def _calls(arguments: Sequence[ca.MX], results: Sequence[ca.MX]) -> list[ca.MX]:
    """The calls among the operations of results."""
    whole = ca.Function("whole", arguments, results)
    return [whole.instruction_MX(k) for k in range(whole.n_instructions()) if whole.instruction_id(k) == ca.OP_CALL]


def _joined(
    arguments: Sequence[ca.MX], results: Sequence[ca.MX], given: Sequence[ca.SX]
) -> tuple[tuple[Call, ...], tuple[tuple[Any, ...], ...]]:
    """The calls of some results, and the entries of these, for given arguments. Raises Interrupted."""
    stop_if_interrupted()
    nodes = _calls(arguments, results)
    functions = [node.which_function() for node in nodes]
    made = [node.get_output(i) for node, f in zip(nodes, functions, strict=True) for i in range(f.n_out())]
    symbols = [ca.MX.sym(f"r{i}", result.sparsity()) for i, result in enumerate(made)]
    read = [node.dep(i) for node in nodes for i in range(node.n_dep())]
    joined = ca.graph_substitute([*results, *read], made, symbols)
    scalars = ca.Function("joined", [*arguments, *symbols], joined).expand()
    stop_if_interrupted()
    own = scalars.sx_in()[len(arguments) :]
    found = [_entries(vector) for vector in scalars.call([*given, *own])]
    made_by = [_entries(vector) for vector in own]
    calls, a, b = list[Call](), len(results), 0
    for f in functions:
        calls.append(Call(f, tuple(found[a : a + f.n_in()]), tuple(made_by[b : b + f.n_out()])))
        a, b = a + f.n_in(), b + f.n_out()
    return tuple(calls), tuple(found[: len(results)])


def _entries(vector: Any) -> tuple[Any, ...]:
    return tuple((vector if vector.is_dense() else ca.densify(vector)).elements())
