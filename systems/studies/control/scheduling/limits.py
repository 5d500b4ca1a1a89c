"""Limits of a schedule."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ropeway.components import check
from ropeway.components.annotation_checks import Unbounded
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError

PerSheave = Unbounded | Mapping[str, Unbounded]
"""One value for all control sheaves, or one for each name; those not named have no limit of their own."""

_LARGEST = {
    "force": ("N", "drive_force"),
    "power": ("W", "power"),
    "pressure": ("Pa", "pressure"),
    "flow": ("m3/s", "flow"),
    "hydraulic_power": ("W", "hydraulic_power"),
}
"""Limits on the size of an output of a control sheave, with that output's name."""

UNITS = {
    **{name: unit for name, (unit, _) in _LARGEST.items()},
    "tension_low": "N",
    "tension_high": "N",
    "grip": "",
    "speed": "m/s",
    "acceleration": "m/s2",
}
"""Units of all limits."""

HYDRAULIC = {"pressure": "relief_pressure", "flow": "pump_flow", "hydraulic_power": "engine_power"}
"""Parameters of a hydraulic drive that bound these limits."""

SPARE = 0.95
"""Share of a hydraulic drive's limits that a plan uses: beyond it they round off the drive's motion."""


@checked
@dataclass(frozen=True, kw_only=True)
class ScheduleLimits:
    """Limits of a schedule. Those of control sheaves: one value for all, or a mapping by name.

    Parameters
    ----------
    tension_low, tension_high : float, optional
        Of every span [N]; by default the lowest that the line has when its control sheaves balance their tensions, and
        the rope's SWL.
    force, power : float or mapping, default inf
        Largest size of the force [N] and power [W] of a control sheave's drive.
    pressure, flow, hydraulic_power : float or mapping, optional
        Largest size in its hydraulic drive [Pa, m3/s, W]; by default 0.95 of the drive's own.
    grip : float or mapping, default 0.0
        Least grip margin.
    speed : (float, float), optional
        Lowest and highest speed [m/s]; by default the line's own, and 0.15 of its highest beyond them (0.15 m/s for a
        line that stands).
    acceleration : float, default 0.05
        Largest size [m/s2].

    Raises
    ------
    InputError

    Examples
    --------
    >>> rw.ScheduleLimits(power=3.2e3, speed=(0.2, 2.0)).speed
    (0.2, 2.0)
    """

    tension_low: float | None = None
    tension_high: float | None = None
    force: PerSheave = math.inf
    power: PerSheave = math.inf
    pressure: PerSheave | None = None
    flow: PerSheave | None = None
    hydraulic_power: PerSheave | None = None
    grip: PerSheave = 0.0
    speed: tuple[float, float] | None = None
    acceleration: float = 0.05

    def __post_init__(self) -> None:
        owner = "ScheduleLimits"
        if self.speed is not None and not (isinstance(self.speed, Sequence) and len(self.speed) == 2):
            raise InputError(f"{owner}: speed is {self.speed!r}", "Give the lowest and the highest, as (0.9, 1.1)")
        for value in self.speed or ():
            check.number(value, owner, "speed", "m/s")
        for name in ("tension_low", "tension_high"):
            if getattr(self, name) is not None:
                check.not_negative(getattr(self, name), owner, name, "N")
        for name, (unit, _) in _LARGEST.items():
            given = getattr(self, name)
            for value in () if given is None else given.values() if isinstance(given, Mapping) else (given,):
                check.positive(value, owner, name, unit, infinite=True)
        for value in self.grip.values() if isinstance(self.grip, Mapping) else (self.grip,):
            check.number(value, owner, "grip")
        check.positive(self.acceleration, owner, "acceleration", "m/s2")
        for name, bounds in (("tension", (self.tension_low, self.tension_high)), ("speed", self.speed)):
            if bounds is None:
                continue
            low, high = bounds
            if low is not None and high is not None and low >= high:
                raise InputError(f"{owner}: {name} low is {low:g}, high is {high:g}", "Give low below high")

    @property
    def sheaves(self) -> list[str]:
        """Names of control sheaves that have limits of their own."""
        given = (getattr(self, name) for name in (*_LARGEST, "grip"))
        return list(dict.fromkeys(name for one in given if isinstance(one, Mapping) for name in one))

    def outputs(self, sheave: str, hydraulic: Mapping[str, float]) -> dict[str, tuple[float, float, str]]:
        """Lowest and highest value of each limited output of a control sheave, and the limit's name.

        Parameters
        ----------
        sheave : str
            Name of the control sheave.
        hydraulic : mapping of str to float
            Parameters of its hydraulic drive by name, empty for an ideal one.

        Returns
        -------
        dict of str to (float, float, str)
        """
        found = {}
        for name, (_, output) in _LARGEST.items():
            given = getattr(self, name)
            if given is None and HYDRAULIC.get(name) in hydraulic:
                most = SPARE * hydraulic[HYDRAULIC[name]]
            else:
                most = _of(given, sheave, math.inf)
            if math.isfinite(most):
                found[output] = (-most, most, name)
        least = _of(self.grip, sheave, -math.inf)
        if math.isfinite(least):
            found["grip_margin"] = (least, math.inf, "grip")
        return found


def _of(given: PerSheave | None, sheave: str, none: float) -> float:
    if given is None:
        return none
    return float(given.get(sheave, none)) if isinstance(given, Mapping) else float(given)
