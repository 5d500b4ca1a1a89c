"""What a run of a line is judged by: one number, the smaller the better."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ropeway.components.control_sheave import ControlSheave
from ropeway.components.errors import InputError
from ropeway.systems.result import Result

Objective = Callable[[Result, float, float | None], float]
"""(result, from what time on [s], target tension [N]) -> value."""


def peak_tension(result: Result, after: float = 0.0, target: float | None = None) -> float:
    """Highest tension at the ends of all spans [N]."""
    frame = result.full_frame.loc[after:]
    return float(frame.filter(regex=r"\.tension_[ab]$").max(axis=None))


def tension_deviation(result: Result, after: float = 0.0, target: float | None = None) -> float:
    """Root of the mean square over time of the differences from the target, on both sides of all control sheaves
    [N]. Raises InputError without a target."""
    if target is None:
        raise InputError("The tension deviation has no target", "Give target= [N]")
    frame = result.full_frame.loc[after:]
    sides = [f"{name}.tension_{side}" for name in _control_sheaves(result) for side in ("in", "out")]
    squares = ((frame[sides].to_numpy() - target) ** 2).mean(axis=1)
    duration = float(frame.index[-1] - frame.index[0])
    return float(np.sqrt(np.trapezoid(squares, frame.index) / duration))


def energy(result: Result, after: float = 0.0, target: float | None = None) -> float:
    """Energy that the control sheaves' drives give to the rope [J]; what one takes back at the same time or another
    counts for nothing."""
    frame = result.full_frame.loc[after:]
    power = frame[[f"{name}.power" for name in _control_sheaves(result)]].clip(lower=0.0)
    return float(np.trapezoid(power.sum(axis=1), frame.index))


OBJECTIVES: dict[str, Objective] = {
    "peak tension": peak_tension,
    "tension deviation": tension_deviation,
    "energy": energy,
}


def objective_of(name: str) -> Objective:
    """The objective of a name. Raises InputError."""
    if name not in OBJECTIVES:
        raise InputError(f"minimise is {name!r}", f"Choose from {', '.join(map(repr, OBJECTIVES))}")
    return OBJECTIVES[name]


def _control_sheaves(result: Result) -> list[str]:
    """Names of the control sheaves, in order. Raises InputError if there is none."""
    names = [c.name for c in result.model.system.components.values() if isinstance(c, ControlSheave)]
    if not names:
        raise InputError(f"{result.model.name} has no control sheave", "Put a ControlSheave into the line")
    return names
