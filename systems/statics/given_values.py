"""Equilibria with values given and as many quantities freed in exchange."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ropeway.components.errors import EquilibriumError, InputError
from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import component_of
from ropeway.systems.solvers.newton import Newton, newton_of
from ropeway.systems.solvers.points import Slot
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import assign_loads, require_pinned
from ropeway.systems.statics.settling import settle


def solve_swapped(
    state: LineState, given: Mapping[str, float], solve_for: Sequence[str], *, from_chord: bool = True
) -> None:
    """Solves a state for rest with values given and as many quantities freed. from_chord: ropes whose length is freed
    start straight; otherwise from the state, which is at rest then. Raises InputError, EquilibriumError.
    """
    lengths = {int(k) for layout in state.model.layouts for k in layout.length_start}
    freed = [state.find(name) for name in solve_for]
    for name, (kind, _) in zip(solve_for, freed, strict=True):
        if kind not in (Kind.PARAMETER, Kind.STATE, Kind.INPUT, Kind.DISCRETE):
            raise InputError(f"{name} is a result and cannot be freed", "Free a parameter, a length or a mass")
    stretched = [k for kind, k in freed if kind is Kind.PARAMETER and k in lengths]
    if stretched and from_chord:
        _pull_straight(state, stretched, given)
    else:
        settle(state)
    for _ in range(20):
        wanted = [state.find(name) for name in given]
        freed = [state.find(name) for name in solve_for]
        _approach(state, Newton(state.model, freed, wanted), wanted, np.array(list(given.values()), float))
        _read_masses(state)
        if assign_loads(state):
            require_pinned(state)
            break
    else:
        raise EquilibriumError(
            f"The loads of system {state.model.name!r} do not settle in spans with the values given",
            "Ask for values nearer to an equilibrium that you know",
        )
    for name, (kind, k) in zip(solve_for, freed, strict=True):
        value = state.point.vector(kind)[k]
        if value < 0.0 and (name.endswith(".mass") or k in stretched):
            raise EquilibriumError(f"The values given need {name} = {value:.6g}", "Ask for less", component_of(name))


def _pull_straight(state: LineState, lengths: Sequence[int], given: Mapping[str, float]) -> None:
    """Starts from a taut rope along its chord: a very slack rope may have the given tension too."""
    for run, layout in zip(state.runs, state.model.layouts, strict=True):
        for k, span in enumerate(run.spans):
            if int(layout.length_start[k]) in lengths:
                a, b = run.nodes[k], run.nodes[k + 1]
                near = [
                    v
                    for name, v in given.items()
                    if "tension" in name and component_of(name) in (span.name, a.name, b.name)
                ]
                tension = max(near, default=0.1 * run.rope.breaking_load)
                chord = float(np.linalg.norm(np.subtract(a.at, b.at)))
                state.point.p[layout.length_start[k]] = chord / (1.0 + run.rope.strain.at(tension))
                if run.rope.strain.none:
                    sag = run.rope.mass_per_length * state.point.p[0] * chord / tension
                    state.point.p[layout.length_start[k]] *= 1.0 + sag**2 / 24.0
    state.restart()


def _approach(state: LineState, newton: Newton, wanted: Sequence[Slot], target: np.ndarray) -> None:
    """Newton's method to the target, in smaller steps where one step fails."""
    try:
        newton.solve(state.point, target=target)
        return
    except EquilibriumError:
        plain = newton_of(state.model)
        plain.solve(state.point)
    outputs = state.outputs()
    origin = np.array([outputs[k] if kind is Kind.OUTPUT else state.point.vector(kind)[k] for kind, k in wanted])
    done, share = 0.0, 0.25
    while done < 1.0:
        share = min(share, 1.0 - done)
        try:
            newton.solve(state.point, target=origin + (done + share) * (target - origin))
            done, share = done + share, 2.0 * share
        except EquilibriumError as error:
            share /= 2.0
            if share < 1e-3:
                raise EquilibriumError(
                    f"No equilibrium of {state.model.name!r} has the values given",
                    "Ask for values nearer to an equilibrium that you know",
                    error.component,
                ) from error


def _read_masses(state: LineState) -> None:
    """Copies masses that were solved for from the slots to the loads."""
    for r, (run, layout) in enumerate(zip(state.runs, state.model.layouts, strict=True)):
        beyond, mass = state.passed[r], run.loads.mass.copy()
        for k in range(len(run.spans)):
            for slot, i in enumerate(range(beyond[k] - 1, beyond[k + 1] - 1, -1)):
                mass[i] = state.point.d[layout.slots.mass[k] + slot]
        state.runs[r] = replace(run, loads=replace(run.loads, mass=mass))
