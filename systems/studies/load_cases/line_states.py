"""Equilibria of a line in all load cases: one model; of each loading, all its weathers in a batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ropeway.components.errors import EquilibriumError
from ropeway.components.weather import values_of
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.modelling.system import System
from ropeway.systems.solvers.array_outputs import outputs_of_rows
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.statics.line_state import LineState, declared_point
from ropeway.systems.statics.settling import solve
from ropeway.systems.statics.variants import line_variants
from ropeway.systems.studies.load_cases.load_case import LoadCase
from ropeway.systems.studies.load_cases.loadings import Masses, loaded, masses_of


def line_states(system: System, cases: Sequence[LoadCase], own: Mapping[str, Masses]) -> list[Equilibrium]:
    """The line at rest in each case. Raises InputError, and EquilibriumError that names the case."""
    for weather in {id(case.environment): case.environment for case in cases}.values():
        system.in_weather(weather)  # raises where its ropes cannot bear it
    model = assemble(system.in_weather(cases[0].environment))
    found: dict[int, Equilibrium] = {}
    for loading in dict.fromkeys(case.loading for case in cases):
        stop_if_interrupted()
        which = [i for i, case in enumerate(cases) if case.loading == loading]
        masses = [masses_of(run, loading, own) for run in model.runs]
        values = [values_of(cases[i].environment, system.temperature) for i in which]
        batch = _in_batch(model, masses, list(values[0]), np.array([list(row.values()) for row in values]))
        found |= {which[k]: line for k, line in batch.items()}
        left = [k for k in range(len(which)) if k not in batch]
        if left:
            line = loaded(system, loading, own)
            alone = model if line is system else assemble(line.in_weather(cases[0].environment))
            found |= {which[k]: _alone(alone, cases[which[k]], values[k]) for k in left}
    return [found[i] for i in range(len(cases))]


def _in_batch(
    model: Model, masses: Sequence[np.ndarray], names: Sequence[str], values: np.ndarray
) -> dict[int, Equilibrium]:
    """Equilibria under loads of these masses with `values` (cases, names), those that the batch solves."""
    state = LineState(model, declared_point(model), model.runs, [np.zeros(0, int) for _ in model.runs])
    state.runs = [_under(run, own) for run, own in zip(model.runs, masses, strict=True)]
    state.restart()
    try:
        solve(state)
    except EquilibriumError:
        return {}
    many = line_variants(state, names)
    if many is None:
        return {}
    good, rows = many.solve(values)
    which = np.flatnonzero(good)
    found = {int(i): _equilibrium(state, rows[int(i)].copy()) for i in which}
    outputs_of_all = outputs_of_rows(state.model, rows.some(which), np.arange(len(state.model.y)))
    for line, outputs in zip(found.values(), outputs_of_all, strict=True):
        line.__dict__["outputs"] = outputs.copy()
    return found


def _under(run: Run, mass: np.ndarray) -> Run:
    """A run under loads of other masses; missing ones bear no wind."""
    return replace(run, loads=replace(run.loads, mass=mass, drag=np.where(mass > 0.0, run.loads.drag, 0.0)))


def _equilibrium(state: LineState, point: Point) -> Equilibrium:
    """A state whose travels count from its rest."""
    runs = tuple(_rested(state, r, point) for r in range(len(state.runs)))
    return Equilibrium(state.model, point, runs, tuple(state.passed), ())


def _rested(state: LineState, r: int, point: Point) -> Run:
    """A run with the places of its loads on the rope, counted from the first support at rest."""
    run, layout, beyond = state.runs[r], state.model.layouts[r], state.passed[r]
    loads, start = run.loads, layout.start(point.p)
    on_line = [
        (i, float(start[k] + point.d[layout.slots.at[k] + slot]))
        for k in range(len(run.spans))
        for slot, i in enumerate(range(beyond[k] - 1, beyond[k + 1] - 1, -1))
        if loads.pinned[i] < 0
    ]
    shift = on_line[0][1] - loads.place[on_line[0][0]] if on_line else 0.0
    pinned = start[np.maximum(loads.pinned, 0)] + loads.at
    return replace(run, loads=replace(loads, place=np.where(loads.pinned >= 0, pinned, loads.place + shift)))


def _alone(model: Model, case: LoadCase, values: Mapping[str, float]) -> Equilibrium:
    """One case by itself. Raises EquilibriumError."""
    stop_if_interrupted()
    try:
        return equilibrium(model, parameters=values)
    except EquilibriumError as error:
        raise EquilibriumError(f"Load case {case.name!r}: {error.cause}", error.remedy, error.component) from error
