"""The equilibria that a line with inertia moves about: where it would be without inertia."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from ropeway.components.carriage import Carriage
from ropeway.components.component import Component
from ropeway.components.errors import EquilibriumError, InputError
from ropeway.components.span import Span
from ropeway.components.variable import Kind
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.modelling.system import System
from ropeway.systems.results.run_data import RunData
from ropeway.systems.statics.line_records import restored
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.resting import same_values
from ropeway.systems.statics.settling import settle

_STATES = 200
"""Largest number of equilibria, evenly over the records of a run."""


@dataclass(frozen=True, eq=False)
class QuasiStatic:
    """The line in equilibrium at some records of a run with inertia: with the rope that its drives have moved until
    then, and the loads that still hang on it. Records without an equilibrium are left out."""

    records: np.ndarray
    lines: tuple[LineState, ...]

    @classmethod
    def of(cls, result: RunData) -> QuasiStatic:
        """Raises InputError for a run without inertia."""
        if result.model.inertia is None:
            cause = f"The run of {result.model.name!r} is without inertia"
            raise InputError(cause, "Give simulate(..., inertia=rw.Inertia())")
        last = len(result.records) - 1
        which = np.unique(np.linspace(0, last, min(last + 1, _STATES)).round().astype(int))
        found = _equilibria(result, which.tolist())
        known = [i for i, line in enumerate(found) if line is not None]
        return cls(which[known], tuple(line for line in found if line is not None))


@kept_with_model
def _quasi_static_model(model: Model) -> Model:
    """The model of the same line without inertia."""
    return assemble(without_inertia(model.system))


def without_inertia(system: System) -> System:
    """The declarations of which `with_inertia` has made a system."""
    found = system.copy()
    found.components = {name: _at_rest(c) for name, c in system.components.items()}
    spans = {name: c for name, c in found.components.items() if isinstance(c, Span)}
    found.hung = [replace(h, spans=tuple(spans[s.name] for s in h.spans)) for h in system.hung]
    found.feeds = [replace(f, spans=tuple(spans[s.name] for s in f.spans)) for f in system.feeds]
    return found


def _at_rest(component: Component) -> Component:
    if not component.inertial:
        return component
    kind = next(k for k in type(component).__mro__ if issubclass(k, Component) and not k.inertial)
    return kind(**{f.name: getattr(component, f.name) for f in fields(kind)})


def _equilibria(result: RunData, which: Sequence[int]) -> list[LineState | None]:
    """The line in equilibrium at records of a run; None where it has none."""
    found: list[LineState | None] = []
    model, before = _quasi_static_model(result.model), None
    for i in which:
        moving = restored(result.model, result.runs, result.parameters, result.records[i])
        if _is_cut(moving):
            found.append(None)
            continue
        state = _start(moving, model, before)
        try:
            settle(state)
        except EquilibriumError:
            found.append(None)
            continue
        found.append(state)
        model, before = state.model, state
    return found


def _is_cut(moving: LineState) -> bool:
    """Whether a rope is broken."""
    cuts = [moving.model.d.index[f"{span.name}.broken"] for run in moving.runs for span in run.spans]
    return bool(np.any(moving.point.d[cuts] > 0.0))


def _start(moving: LineState, model: Model, before: LineState | None) -> LineState:
    """Where the search begins: at the equilibrium before, or where the moving line is."""
    point = same_values(moving.model, moving.point, model)
    # A carriage's place is a state with inertia, and an unknown without.
    values = dict(zip(moving.model.x.names, moving.point.x, strict=True))
    unknown = point.vector(Kind.ALGEBRAIC)
    unknown[:] = [values.get(name, value) for name, value in zip(model.z.names, unknown, strict=True)]
    if before is not None:
        unknown[:] = before.point.z
    for name, component in model.system.components.items():
        dropped = moving.model.d.index.get(f"{name}.dropped")
        if isinstance(component, Carriage) and dropped is not None and moving.point.d[dropped] > 0.0:
            point.p[model.p.index[f"{name}.payload"]] = 0.0
    runs = [_kept_loads(moving, r, own) for r, own in enumerate(model.runs)]
    state = LineState(model, replace(point, t=moving.point.t), runs, moving.passed if before is None else before.passed)
    state.write_slots()
    return state


def _kept_loads(state: LineState, r: int, own: Run) -> Run:
    """A run with its loads; those that are lost have no mass."""
    run, beyond, index = state.runs[r], state.passed[r], state.model.d.index
    mass = run.loads.mass.copy()
    for k, span in enumerate(run.spans):
        for j, load in enumerate(range(int(beyond[k]) - 1, int(beyond[k + 1]) - 1, -1)):
            if state.point.d[index[f"{span.name}.lost[{j + 1}]"]] > 0.0:
                mass[load] = 0.0
    return replace(own, loads=replace(run.loads, mass=mass), feed=run.feed)
