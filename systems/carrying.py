"""An equilibrium as the start of another: the same line, driven otherwise."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

from ropeway.components.component import Component, Kind
from ropeway.components.errors import InputError
from ropeway.systems.assembly import assemble
from ropeway.systems.model import Model
from ropeway.systems.newton import VECTORS
from ropeway.systems.state import LineState, declared_point
from ropeway.systems.system import System

if TYPE_CHECKING:
    from ropeway.systems.equilibrium import Equilibrium

_DRIVEN = ("response", "speed")
"""What may differ between two declarations of one line: how its supports are driven."""

_DECLARED = {
    "gravity": "gravity",
    "connections": "joints",
    "supplies": "supplies",
    "links": "links",
    "hung": "loads",
    "feeds": "loads that come in",
}
"""What else a system declares, and what a user calls it."""


def declared_alike(start: Equilibrium, system: System) -> bool:
    """Whether a start is of the same declarations; not, where supports are driven otherwise. Raises InputError where
    more differs: it would say nothing about this system."""
    old = start.model.system
    if old is system:
        return True
    alike = old.precedence == system.precedence
    for name in {**old.components, **system.components}:
        one, other = old.components.get(name), system.components.get(name)
        if one is other or one == other:
            continue
        if type(one) is not type(other) or _undriven(one) != _undriven(other):
            _refuse(system, f"another {name!r}")
        alike = False
    for what, words in _DECLARED.items():
        if getattr(old, what) != getattr(system, what):
            _refuse(system, f"other {words}")
    return alike


def _undriven(component: Component | None) -> dict[str, Any]:
    if component is None:
        return {}
    return {f.name: getattr(component, f.name) for f in fields(component) if f.name not in _DRIVEN}


def _refuse(system: System, words: str) -> None:
    raise InputError(
        f"start is of another system than {system.name!r}, with {words}",
        "Give an equilibrium of this one; change values with parameters=",
    )


def carried_over(start: Equilibrium, system: System | Model) -> Equilibrium:
    """The same place and loads, at time 0, on a declaration of the line that is driven otherwise. Raises InputError."""
    model = system if isinstance(system, Model) else assemble(system)
    declared_alike(start, model.system)
    point = declared_point(model)
    for kind in VECTORS:
        table, values = start.model.tables[kind], start.point.vector(kind)
        for i, name in enumerate(model.tables[kind].names):
            k = table.index.get(name)
            # What the start has not changed is as declared here: parameters, as those of a response, and speeds.
            if k is None or (kind in (Kind.PARAMETER, Kind.STATE) and values[k] == table.values[k]):
                continue
            if kind is not Kind.INPUT or start.model.signals[k] == model.signals[i]:
                point.vector(kind)[i] = values[k]
    state = LineState(model, point, start.runs, start.passed)
    state.write_slots()
    return replace(start, model=state.model, point=state.point, runs=tuple(state.runs), passed=tuple(state.passed))
