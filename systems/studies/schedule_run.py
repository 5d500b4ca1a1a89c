"""Runs of a line under schedules, and what the objectives come to in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ropeway.components.control_sheave import ControlSheave
from ropeway.components.response import ProportionalResponse, Response
from ropeway.components.schedule import Schedule
from ropeway.systems.assembly import assemble
from ropeway.systems.equilibrium import Equilibrium
from ropeway.systems.newton import VECTORS, Point, newton_of
from ropeway.systems.result import Result
from ropeway.systems.state import LineState
from ropeway.systems.system import System


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


def balancing(start: Equilibrium, period: float) -> ProportionalResponse:
    """A response that brings the tensions on both sides of a sheave together within a few of its periods [s]."""
    stiffness = []
    for name in control_sheaves(start.model.system):
        place, index = start.model.x.index[f"{name}.travel"], start.model.y.index[f"{name}.differential_tension"]
        force = []
        for way in (-0.05, 0.05):
            point = start.point.copy()
            point.x[place] += way
            newton_of(start.model).solve(point)
            force.append(np.array(start.model.outputs(*point.arguments)).ravel()[index])
        stiffness.append(abs(force[1] - force[0]) / 0.1)
    return ProportionalResponse(gain=0.5 / (max(stiffness) * period), period=period, limit=0.15, rate=0.05)


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


def measured(result: Result, names: Sequence[str], settle: float, target: float) -> dict[str, float]:
    """The objectives of a run from `settle` [s] on, by their names."""
    frame = result.full_frame
    counts = frame.index.to_numpy() >= settle - 1e-9
    times = frame.index.to_numpy()[counts]
    ends = frame.filter(regex=r"\.tension_[ab]$").to_numpy()[counts]
    span = times[-1] - times[0]
    sides = [frame[f"{n}.tension_{side}"].to_numpy()[counts] for n in names for side in ("in", "out")]
    square = np.mean([np.trapezoid((t - target) ** 2, times) / span for t in sides])
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
