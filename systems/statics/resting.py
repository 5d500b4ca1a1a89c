"""A system at rest: free states become unknowns, and their rates residuals."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.csgraph import structural_rank

from ropeway.components.component import Component
from ropeway.components.errors import UnbalancedSystemError
from ropeway.components.variable import Equations, Kind, Site, Variable
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model, component_of, in_code, kept_with_model
from ropeway.systems.solvers.points import VECTORS, Point
from ropeway.systems.statics.line_state import LineState, declared_point

_SUFFIX = " at rest"


@kept_with_model
def at_rest_model(model: Model) -> Model:
    """The model with its free states as algebraic variables and their rates as residuals. Raises
    UnbalancedSystemError for a state that no equation determines at rest."""
    _require_determined(model)
    system = model.system.copy()
    for name in {component_of(state) for state in model.free_states}:
        system.components[name] = _resting(system.components[name])
    return assemble(system, slots=[layout.slots.count.tolist() for layout in model.layouts])


def _require_determined(model: Model) -> None:
    """Raises UnbalancedSystemError with the states that no equation determines at rest."""
    states = [model.x.index[name] for name in model.free_states]
    rows = [[_pattern(model, 1, 2), _pattern(model, 1, 1)[:, states]]]
    rows.append([_pattern(model, 0, 2)[states], _pattern(model, 0, 1)[np.ix_(states, states)]])
    graph = csc_matrix(np.block(rows))
    rank, count = structural_rank(graph), graph.shape[1]
    if rank == count:
        return
    first = count - len(states)
    # The rank is the same without its column: the equations determine the other unknowns only.
    loose = [
        name
        for k, name in enumerate(model.free_states, first)
        if structural_rank(graph[:, np.arange(count) != k]) == rank
    ]
    raise UnbalancedSystemError(
        f"Nothing determines {', '.join(loose or model.free_states)} at rest",
        "Let a rate depend on it, or declare it with kept_at_rest=True, as a travel that is driven",
    )


def _pattern(model: Model, result: int, argument: int) -> np.ndarray:
    """Sparsity of a result of the model's equations by one of their arguments."""
    pattern = model.dae.jac_sparsity(result, argument)
    found = np.zeros(pattern.shape, dtype=bool)
    found[pattern.row(), pattern.get_col()] = True
    return found


def on_model(state: LineState, model: Model) -> LineState:
    """A state of a model on its `at_rest_model`, or the other way round; variables without a value stay as declared."""
    counts = [layout.slots.count.tolist() for layout in state.model.layouts]
    if counts != [layout.slots.count.tolist() for layout in model.layouts]:
        model = in_code(assemble(model.system, slots=counts), compiled=model.compiled)
    point = same_values(state.model, state.point, model)
    runs = [replace(own, loads=run.loads) for own, run in zip(model.runs, state.runs, strict=True)]
    return LineState(model, point, runs, state.passed)


def same_values(model: Model, point: Point, other: Model) -> Point:
    """The point of another model with the same values by name; variables without a value stay as declared."""
    values = {
        name: value
        for kind in VECTORS
        for name, value in zip(model.tables[kind].names, point.vector(kind), strict=True)
    }
    found = declared_point(other)
    for kind in VECTORS:
        declared = found.vector(kind)
        declared[:] = [values.get(name, value) for name, value in zip(other.tables[kind].names, declared, strict=True)]
    return found


def _is_free(v: Variable) -> bool:
    return v.kind is Kind.STATE and not v.kept_at_rest


def _resting(component: Component) -> Component:
    """The component with its free states as unknowns at rest."""
    own: Any = type(component)

    class Resting(own):  # type: ignore[misc]
        __slots__ = ()

        def variables(self, site: Site) -> tuple[Variable, ...]:
            found: list[Variable] = []
            for v in super().variables(site):
                if _is_free(v):
                    rate = replace(v, name=v.name + _SUFFIX, kind=Kind.RESIDUAL, unit="", value=0.0)
                    found += [replace(v, kind=Kind.ALGEBRAIC), rate]
                else:
                    found.append(v)
            return tuple(found)

        def equations(self, v: Any) -> Equations:
            found = super().equations(v)
            kept = {s.name for s in super().variables(Site(1.0, 1.0)) if s.kind is Kind.STATE and s.kept_at_rest}
            rates = {name: rate for name, rate in found.rates.items() if name in kept}
            at_rest = {name + _SUFFIX: rate for name, rate in found.rates.items() if name not in kept}
            return replace(found, rates=rates, residuals={**found.residuals, **at_rest})

    made = copy.copy(component)
    object.__setattr__(made, "__class__", Resting)
    return made
