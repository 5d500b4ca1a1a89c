"""A carriage that moves with inertia, as the models of its places in balance see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ropeway.components.variable import Kind
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.points import VECTORS, Point
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.studies.skyline.carriage_model import Solved, SpanModel

Rate = Callable[[str], float]
"""The rate of a variable, by its name [per s]."""


def balanced_point(at: SpanModel, state: Equilibrium) -> Point:
    """The values of a state with inertia in the vectors of a place's model."""
    point = at.declared()
    tables, values = state.model.tables, state.point
    known = {name: x for kind in VECTORS for name, x in zip(tables[kind].names, values.vector(kind), strict=True)}
    for kind in VECTORS:
        own = point.vector(kind)
        for i, name in enumerate(at.model.tables[kind].names):
            if name in known:
                own[i] = known[name]
    return replace(point, t=values.t)


def seen(at: SpanModel, state: Equilibrium) -> tuple[Solved, Rate]:
    """A state with inertia as the rows of a run read it, and its rates."""
    point = balanced_point(at, state)
    outputs, moving = at.outputs(point), state.model.y.index
    values = state.outputs
    for name, i in at.output_index.items():
        if name in moving:
            outputs[i] = values[moving[name]]
    of = {source: rate for rate, source in state.model.rate_of.items()}

    def rate(name: str) -> float:
        return float(state[of[name]]) if name in of else 0.0

    return Solved(at, point, outputs, "mainline"), rate


def come_to_rest(at: SpanModel, state: Equilibrium) -> Point:
    """The equilibrium about which a carriage with inertia swings, with the ropes' present lengths. Raises
    EquilibriumError."""
    point = balanced_point(at, state)
    newton_of(at.model).solve(point)
    return point


def loaded(state: Equilibrium, at: SpanModel, payload: float) -> Equilibrium:
    """A state with inertia that continues with another payload [kg]."""
    point, other = state.point.copy(), at.declared()
    at.load(other, payload)
    point.p[state.model.tables[Kind.PARAMETER].index[at.model.p.names[at.payload]]] = other.p[at.payload]
    return replace(state, point=point)
