"""The equations of a model as calls of its components' functions, joined entry by entry.

Each entry of an input of a call is an entry of the model's vectors, a result of an earlier call, a constant, or an
expression of these, such as a position beside a node.
"""

from __future__ import annotations

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
    """The calls of a model in the order in which they can be made. The symbols of its vectors (t, x, z, u, p, d), then
    of what is freed; its rates `ode`, residuals `alg`, outputs `y`, and its vectors with what is freed, `full`."""

    calls: tuple[Call, ...]
    vectors: tuple[tuple[Any, ...], ...]
    ode: tuple[Any, ...]
    alg: tuple[Any, ...]
    y: tuple[Any, ...]
    full: dict[Any, Any]


def call_graph(model: Model, freed: tuple[Slot, ...], *, outputs: bool) -> CallGraph:
    """The calls of a model where entries are freed; outputs: with its outputs, which have calls of their own. Raises
    Interrupted."""
    dae = model.dae
    arguments = [ca.MX.sym(dae.name_in(i), dae.sparsity_in(i)) for i in range(dae.n_in())]
    found = [*dae.call(arguments, True, False)]
    found.append(model.outputs.call(arguments, True, False)[0] if outputs else ca.MX(0, 1))
    stop_if_interrupted()
    whole = ca.Function("whole", arguments, found)
    nodes = [whole.instruction_MX(k) for k in range(whole.n_instructions()) if whole.instruction_id(k) == ca.OP_CALL]
    functions = [node.which_function() for node in nodes]
    made = [node.get_output(i) for node, f in zip(nodes, functions, strict=True) for i in range(f.n_out())]
    symbols = [ca.MX.sym(f"r{i}", result.sparsity()) for i, result in enumerate(made)]
    given = [node.dep(i) for node in nodes for i in range(node.n_dep())]
    joined = ca.graph_substitute([*found, *given], made, symbols)
    scalars = ca.Function("joined", [*arguments, *symbols], joined).expand()
    stop_if_interrupted()
    time, *rest = scalars.sx_in()
    point, own = dict(zip(VECTORS, rest, strict=False)), rest[len(VECTORS) :]
    values = ca.SX.sym("freed", len(freed))
    full = with_freed(model, point, freed, ca.vertsplit(values) if freed else [])
    results = [_entries(vector) for vector in scalars.call([time, *full.values(), *own])]
    made_by = [_entries(vector) for vector in own]
    calls, a, b = list[Call](), 3, 0
    for f in functions:
        calls.append(Call(f, tuple(results[a : a + f.n_in()]), tuple(made_by[b : b + f.n_out()])))
        a, b = a + f.n_in(), b + f.n_out()
    vectors = tuple(_entries(vector) for vector in (time, *point.values(), values))
    return CallGraph(tuple(calls), vectors, results[0], results[1], results[2], full)


def _entries(vector: Any) -> tuple[Any, ...]:
    return tuple((vector if vector.is_dense() else ca.densify(vector)).elements())
