"""Equilibria of a line in all load cases: solved in batches, one for each loading."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ropeway.components.errors import EquilibriumError
from ropeway.components.weather import values_of
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.assembly import assembled
from ropeway.systems.modelling.component_functions import ComponentFunctions
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.modelling.system import System
from ropeway.systems.solvers.condensed_newton import Cases
from ropeway.systems.solvers.newton import Point
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.settling import solve
from ropeway.systems.statics.variants import line_variants
from ropeway.systems.studies.load_cases.load_case import LoadCase
from ropeway.systems.studies.load_cases.loadings import Masses, loaded


def line_states(system: System, cases: Sequence[LoadCase], own: Mapping[str, Masses]) -> list[Equilibrium]:
    """The line at rest in each case. Raises InputError, and EquilibriumError that names the case."""
    found: dict[int, Equilibrium] = {}
    functions = ComponentFunctions()  # all loadings share them
    for loading in dict.fromkeys(case.loading for case in cases):
        which = [i for i, case in enumerate(cases) if case.loading == loading]
        line = loaded(system, loading, own)
        found |= dict(zip(which, _of_loading(line, [cases[i] for i in which], functions), strict=True))
    return [found[i] for i in range(len(cases))]


def _of_loading(line: System, cases: Sequence[LoadCase], functions: ComponentFunctions) -> list[Equilibrium]:
    """The line with its loads in the environment of each case."""
    state = LineState.cold(assembled(line.in_weather(cases[0].environment), functions))
    values = [values_of(case.environment, line.temperature) for case in cases]
    batch: dict[int, Equilibrium] = {}
    try:
        solve(state)
        batch = _in_batch(state, list(values[0]), np.array([list(row.values()) for row in values]))
    except EquilibriumError:
        pass  # each case is solved from geometry
    rows = []
    for i, case in enumerate(cases):
        stop_if_interrupted()
        weather = line.in_weather(case.environment)  # raises where its ropes cannot bear it
        rows.append(batch[i] if i in batch else _alone(weather, case))
    return rows


def _in_batch(state: LineState, names: Sequence[str], values: np.ndarray) -> dict[int, Equilibrium]:
    """Equilibria with `values` (cases, names), those that the batch solves."""
    many = line_variants(state, names)
    if many is None:
        return {}
    good, columns = many.solve(values)
    return {int(i): _equilibrium(state, columns, int(i)) for i in np.flatnonzero(good)}


def _equilibrium(state: LineState, columns: Cases, i: int) -> Equilibrium:
    """The state of a column, whose travels count from its rest."""
    x, z, u, p, d = (np.ascontiguousarray(vector[:, i]) for vector in columns.vectors)
    point = Point(x, z, u, p, d)
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


def _alone(line: System, case: LoadCase) -> Equilibrium:
    """One case by itself. Raises EquilibriumError."""
    try:
        return equilibrium(line)
    except EquilibriumError as error:
        raise EquilibriumError(f"Load case {case.name!r}: {error.cause}", error.remedy, error.component) from error
