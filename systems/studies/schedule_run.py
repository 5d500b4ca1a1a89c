"""Runs of a line under schedules, and what the objectives come to in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ropeway.components import check
from ropeway.components.control_sheave import ControlSheave
from ropeway.components.errors import EquilibriumError, InputError
from ropeway.components.response import ProportionalResponse, Response
from ropeway.components.schedule import Schedule
from ropeway.systems.assembly import assemble
from ropeway.systems.equilibrium import Equilibrium, equilibrium
from ropeway.systems.newton import VECTORS, Point, newton_of
from ropeway.systems.result import Result
from ropeway.systems.state import LineState
from ropeway.systems.system import System

_TRIALS, _BALANCE = 20, 1.0
"""Trials for an even share, and how near to it is near enough [N]."""


def with_responses(line: System, responses: Mapping[str, Response | None]) -> System:
    """The line with other responses at its control sheaves; all act at once."""
    other = line.copy()
    other.precedence = "all at once"
    for name, response in responses.items():
        sheave = other.components[name]
        if isinstance(sheave, ControlSheave):
            other.components[name] = replace(sheave, response=response)
    return other


def control_sheaves(line: System) -> list[str]:
    """Names of a line's control sheaves."""
    return [name for name, c in line.components.items() if isinstance(c, ControlSheave)]


def balanced(line: System) -> Equilibrium:
    """The line at rest with so much rope in each section that all control sheaves have the same difference of tension
    between their sides: they share evenly what the line as a whole pulls. Raises InputError, EquilibriumError.
    """
    names = control_sheaves(line)
    if not names:
        raise InputError(f"{line.name!r} has no control sheave", "Only control sheaves can balance")
    first, *others = (f"{name}.differential_tension" for name in names)
    travels = [f"{name}.travel" for name in names[1:]]

    def excess(share: float) -> tuple[Equilibrium, float]:
        found = equilibrium(line, given=dict.fromkeys(others, share), solve_for=travels)
        return found, found[first] - share

    share, (rest, left) = 0.0, excess(0.0)
    step = left / len(names)
    for _ in range(_TRIALS):
        if abs(left) < _BALANCE:
            return rest
        share, before = share + step, left
        rest, left = excess(share)
        step *= left / (before - left)
    raise EquilibriumError(
        f"The control sheaves of {line.name!r} do not come into balance", "Start from rw.equilibrium(line) instead"
    )


def balancing(start: Equilibrium, period: float) -> ProportionalResponse:
    """A response that brings all sheaves to one difference of tension within a few of its periods [s]."""
    stiffness, names = [], control_sheaves(start.model.system)
    share = float(np.mean([start[f"{name}.differential_tension"] for name in names]))
    for name in names:
        place, index = start.model.x.index[f"{name}.travel"], start.model.y.index[f"{name}.differential_tension"]
        force = []
        for way in (-0.05, 0.05):
            point = start.point.copy()
            point.x[place] += way
            newton_of(start.model).solve(point)
            force.append(np.array(start.model.outputs(*point.arguments)).ravel()[index])
        stiffness.append(abs(force[1] - force[0]) / 0.1)
    return ProportionalResponse(gain=0.5 / (max(stiffness) * period), period=period, difference=share, limit=0.15)


def smoothed(result: Result, grid: np.ndarray, names: Sequence[str]) -> dict[str, Schedule]:
    """Schedules on a grid that follow the travels of a run without its steps."""
    frame, h = result.full_frame, float(grid[1] - grid[0])
    found = {}
    for name in names:
        travel = frame[f"{name}.travel"].to_numpy()
        first = result.records[0].u[result.model.u.index[f"{name}.speed"]]
        q = np.interp(grid, result.times, travel)
        last = (q[-1] - q[-2]) / h
        found[name] = Schedule(grid.tolist(), [float(first), *((q[2:] - q[:-2]) / (2.0 * h)), float(last)])
    return found


def objectives(result: Result, *, settle: float = 0.0, target: float | None = None) -> dict[str, float]:
    """What `optimise_schedule` minimises, of any run from `settle` [s] on: "peak tension" of all spans [N], "tension
    deviation" of the control sheaves' tensions, on both sides, from a target [N], by default their mean, and "energy"
    that their drives give, not less what they recover [J]. Raises InputError."""
    check.not_negative(settle, "objectives", "settle", "s")
    frame, names = result.full_frame, control_sheaves(result.model.system)
    if settle >= result.times[-1]:
        raise InputError(f"The run ends at {result.times[-1]:g} s", f"Choose settle below, not {settle:g} s")
    if not names:
        raise InputError(f"{result.model.name!r} has no control sheave", "Only lines with control sheaves have these")
    counts = frame.index.to_numpy() >= settle - 1e-9
    times = frame.index.to_numpy()[counts]
    ends = frame.filter(regex=r"\.tension_[ab]$").to_numpy()[counts]
    span = times[-1] - times[0]
    sides = [frame[f"{n}.tension_{side}"].to_numpy()[counts] for n in names for side in ("in", "out")]
    aim = np.mean([np.trapezoid(t, times) / span for t in sides]) if target is None else target
    square = np.mean([np.trapezoid((t - aim) ** 2, times) / span for t in sides])
    power = [np.maximum(frame[f"{n}.power"].to_numpy()[counts], 0.0) for n in names]
    return {
        "peak tension": float(ends.max()),
        "tension deviation": float(np.sqrt(square)),
        "energy": float(sum(np.trapezoid(p, times) for p in power)),
    }


def carried_over(start: Equilibrium, line: System) -> Equilibrium:
    """The same place and loads on another declaration of the line, as one with other responses."""
    model = assemble(line)
    old = start.model
    point = Point(0.0, *(model.tables[kind].values.copy() for kind in VECTORS))
    for kind in VECTORS:
        known, values = old.tables[kind].index, start.point.vector(kind)
        for i, name in enumerate(model.tables[kind].names):
            if name in known:
                point.vector(kind)[i] = values[known[name]]
    state = LineState(model, point, start.runs, start.passed)
    state.write_slots()
    return Equilibrium(state.model, state.point, tuple(state.runs), tuple(state.passed), start.held)
