"""Objectives of a run of a line: the smaller the better."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.systems.dynamics.result import Result
from ropeway.systems.studies.control.control_sheaves import control_sheaves

OBJECTIVES = ("peak tension", "tension deviation", "energy")
"""Highest tension of all spans [N]; root mean square of the control sheaves' tensions, on both sides, from a target
[N]; energy that the control sheaves' drives supply, without what they recover [J], always over the whole run: otherwise
the energy supplied before the tensions count would be free."""


@checked
def objectives(result: Result, *, settle: float = 0.0, target: float | None = None) -> dict[str, float]:
    """What `optimise_schedule` and `tune_response` minimise, for any run.

    Parameters
    ----------
    result : Result
        A run of a line with control sheaves.
    settle : float, default 0.0
        Time from which the two objectives of tension count [s]; the energy counts over the whole run.
    target : float, optional
        Tension from which the deviation counts [N]; by default the mean.

    Returns
    -------
    dict of str to float
        "peak tension" [N]: the highest of all spans; "tension deviation" [N]: the root mean square at the control
        sheaves, on both sides; "energy" [J]: what the drives of the control sheaves supply, without what they recover.

    Raises
    ------
    InputError

    Examples
    --------
    >>> result = rw.simulate(line, 20.0)
    >>> print(f"{rw.objectives(result, settle=10.0)['peak tension'] / 1e3:.1f} kN")
    68.6 kN
    """
    check.not_negative(settle, "objectives", "settle", "s")
    frame, names = result.full_frame, control_sheaves(result.model.system)
    if settle >= result.times[-1]:
        raise InputError(f"The run ends at {result.times[-1]:g} s", f"Choose settle below, not {settle:g} s")
    counts = frame.index.to_numpy() >= settle - 1e-9
    times = frame.index.to_numpy()[counts]
    ends = frame.filter(regex=r"\.tension_[ab]$").to_numpy()[counts]
    span = times[-1] - times[0]
    if span <= 0.0:
        raise InputError(
            f"The run has one record from {settle:g} s on", "Choose an earlier settle, or a smaller `every`"
        )
    sides = [frame[f"{n}.tension_{side}"].to_numpy()[counts] for n in names for side in ("in", "out")]
    aim = np.mean([np.trapezoid(t, times) / span for t in sides]) if target is None else target
    square = np.mean([np.trapezoid((t - aim) ** 2, times) / span for t in sides])
    whole = frame.index.to_numpy()
    power = [np.maximum(frame[f"{n}.power"].to_numpy(), 0.0) for n in names]
    return {
        "peak tension": float(ends.max()),
        "tension deviation": float(np.sqrt(square)),
        "energy": float(sum(np.trapezoid(p, whole) for p in power)),
    }


def objective_weights(minimise: str | Mapping[str, float]) -> dict[str, float]:
    """The weight of each objective that has one. Raises InputError."""
    if not isinstance(minimise, (str, Mapping)):
        raise InputError(f"minimise is {minimise!r}", f"Choose from {', '.join(map(repr, OBJECTIVES))}, or weigh them")
    given = {minimise: 1.0} if isinstance(minimise, str) else dict(minimise)
    for name, weight in given.items():
        if name not in OBJECTIVES:
            raise InputError(f"minimise is {name!r}", f"Choose from {', '.join(map(repr, OBJECTIVES))}")
        check.not_negative(weight, "minimise", f"weight of {name!r}")
    if not any(given.values()):
        raise InputError("minimise has no weight above zero", "Give at least one")
    return {name: float(weight) for name, weight in given.items() if weight}
