"""Start values from another solution of the same line, whose drives may differ."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ropeway.components.component import Component
from ropeway.components.errors import InputError
from ropeway.components.response import Response
from ropeway.components.variable import Kind
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model, component_of, kept_with_model
from ropeway.systems.modelling.intervention import SWITCHED
from ropeway.systems.modelling.system import System
from ropeway.systems.solvers.points import VECTORS
from ropeway.systems.statics.line_state import LineState, declared_point
from ropeway.systems.statics.pending_events import Pending

if TYPE_CHECKING:
    from ropeway.systems.statics.equilibrium import Equilibrium

_DRIVEN = ("response", "speed")
"""Fields that may differ between two declarations of one line: those of its drives."""

_DECLARED = {
    "gravity": "gravity",
    "temperature": "temperature of stringing",
    "connections": "joints",
    "supplies": "supplies",
    "links": "links",
    "hung": "loads",
    "feeds": "loads that come in",
}
"""Other declarations of a system, and what messages call them."""


def declared_alike(start: Equilibrium, system: System) -> bool:
    """Whether a start has the same declarations; False where drives or the weather differ. Raises InputError where
    other declarations differ.
    """
    old = start.model.system
    if old is system:
        return True
    alike = old.precedences == system.precedences and old.environment == system.environment
    for name in {**old.components, **system.components}:
        one, other = old.components.get(name), system.components.get(name)
        if one is other or one == other:
            continue
        if type(one) is not type(other) or _other_fields(one) != _other_fields(other):
            _refuse(system, f"another {name!r}")
        alike = False
    for what, words in _DECLARED.items():
        if getattr(old, what) != getattr(system, what):
            _refuse(system, f"other {words}")
    return alike


def _other_fields(component: Component | None) -> dict[str, Any]:
    if component is None:
        return {}
    return {f.name: getattr(component, f.name) for f in fields(component) if f.name not in _DRIVEN}


def _refuse(system: System, words: str) -> None:
    raise InputError(
        f"start is of another system than {system.name!r}, with {words}",
        "Give an equilibrium of this one; change values with parameters=",
    )


def carried_over(start: Equilibrium, system: System | Model) -> Equilibrium:
    """A start on another declaration of the line, with other drives: the same positions and loads, at time 0. A
    response continues where it is the same here, otherwise it begins; so does an input after an emergency stop. Raises
    InputError."""
    model = system if isinstance(system, Model) else assemble(system)
    declared_alike(start, model.system)
    point, continuing = declared_point(model), _continuing(start.model.system, model.system)
    for kind in VECTORS:
        table, values = start.model.tables[kind], start.point.vector(kind)
        for i, name in enumerate(model.tables[kind].names):
            k = table.index.get(name)
            # Parameters and states that the start has not changed are as declared here: those of a response, speeds.
            if k is None or (kind in (Kind.PARAMETER, Kind.STATE) and values[k] == table.values[k]):
                continue
            if kind is Kind.DISCRETE and _of_response(name) and component_of(name) not in continuing:
                continue
            if kind is not Kind.INPUT or start.model.signals[k] == model.signals[i]:
                point.vector(kind)[i] = values[k]
    state = LineState(model, point, start.runs, start.passed)
    state.write_slots()
    return replace(
        start,
        model=state.model,
        point=state.point,
        runs=tuple(state.runs),
        passed=tuple(state.passed),
        pending=_pending(start, model, continuing),
    )


def undriven(state: LineState) -> None:
    """Resets corrections of responses, brakes and losses of pressure, which a run has left in a state."""
    entries = _driven(state.model)
    state.point.d[entries] = state.model.d.values[entries]


@kept_with_model
def _driven(model: Model) -> np.ndarray:
    """Places of the discrete variables of responses, brakes and losses of pressure."""
    switched, names = {variable for variable, _ in SWITCHED.values()}, model.d.names
    found = [i for i in model.kept if _of_response(names[i]) or names[i].rpartition(".")[2] in switched]
    return np.array(found, dtype=int)


def _of_response(name: str) -> bool:
    """Whether a discrete variable is one of a sheave's response."""
    variable = name.rpartition(".")[2]
    return variable == "correction" or variable.startswith("response_")


def _continuing(old: System, new: System) -> dict[str, Response]:
    """Responses that continue in a run of the new system: those of the same kind, period and delay."""
    found = {}
    for name, component in new.components.items():
        before, after = getattr(old.components.get(name), "response", None), getattr(component, "response", None)
        if before is not None and after is not None and _rhythm(before) == _rhythm(after):
            found[name] = after
    return found


def _rhythm(response: Response) -> tuple[type, float, float]:
    return (type(response), response.period, response.delay)


def _pending(start: Equilibrium, model: Model, continuing: Mapping[str, Response]) -> Pending:
    """What is pending of a start in a run of a model."""
    kept = {(r.period, phase) for r in continuing.values() for phase in (r.period, r.period + r.phase)}
    stopping, old = start.pending.stopping, start.model
    if stopping is not None:
        alike = {name for name in stopping if old.signals[old.u.index[name]] == model.signals[model.u.index[name]]}
        stopping = {name: signal for name, signal in stopping.items() if name in alike} or None
    ticks = {clock: tick for clock, tick in start.pending.ticks.items() if clock in kept}
    return Pending(ticks, stopping, start.pending.emergency and stopping is not None)
