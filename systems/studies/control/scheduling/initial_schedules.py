"""Starts and initial schedules of an optimisation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.errors import EquilibriumError, UnknownNameError
from ropeway.components.response import ProportionalResponse
from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.result import Result
from ropeway.systems.modelling.dae_model import nearest
from ropeway.systems.modelling.system import System
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.studies.control.control_sheaves import control_sheaves, scheduled_sheaves

_TRIALS, _BALANCE = 20, 1.0
"""Largest number of iterations for equal differences, and their tolerance [N]."""


@checked
def balanced(line: System) -> Equilibrium:
    """The line at rest with as much rope in each section as gives all control sheaves the same difference of tension.

    The control sheaves then share evenly the force that the line as a whole needs.

    Parameters
    ----------
    line : System
        A line with control sheaves.

    Returns
    -------
    Equilibrium

    Raises
    ------
    InputError, EquilibriumError

    Examples
    --------
    >>> start = rw.balanced(line)
    >>> print(f"{start['c1.tension_in'] - start['c1.tension_out']:.0f} N")
    1171 N
    """
    names = scheduled_sheaves(line)
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
        f"The control sheaves of {line.name!r} cannot be balanced", "Start from rw.equilibrium(line) instead"
    )


def balancing(start: Equilibrium, period: float) -> ProportionalResponse:
    """A response that brings all sheaves to the same difference of tension within a few of its periods [s]."""
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
    """Schedules on a grid that follow the travels of a run, without its steps."""
    frame, h = result.full_frame, float(grid[1] - grid[0])
    found = {}
    for name in names:
        travel = frame[f"{name}.travel"].to_numpy()
        first = result.records[0].u[result.model.u.index[f"{name}.speed"]]
        q = np.interp(grid, result.times, travel)
        last = (q[-1] - q[-2]) / h
        found[name] = Schedule(grid.tolist(), [float(first), *((q[2:] - q[:-2]) / (2.0 * h)), float(last)])
    return found


def require_sheave(name: str, sheaves: Sequence[str]) -> None:
    """Raises UnknownNameError unless a name is that of a control sheave of the line."""
    if name not in sheaves:
        raise UnknownNameError(f"{name!r} is not a control sheave", nearest(name, sheaves))
