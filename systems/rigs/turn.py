"""A log on a dropline under the carriage of a rig."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.log import Log
from ropeway.components.rope import Rope
from ropeway.components.terrain import Profile

LEAST_MASS = 1.0
"""Least mass of a log [kg]; it replaces a payload of zero."""

GROUND = ("ground_x", "ground_z", "slope", "slope_after", "rounding")
"""Local description of the ground for a log, from `Profile.vertex_at`."""


@checked
@dataclass(frozen=True)
class Turn:
    """A log on a dropline under the carriage; the payload is the log's mass.

    Parameters
    ----------
    log : Log
        Its mass is replaced by the payload.
    dropline : Rope
        A rope, or a name from `rw.ropes()`.
    length : float
        Unstretched length of the dropline [m].

    Raises
    ------
    InputError
        The length is not positive.

    Examples
    --------
    >>> log = rw.Log("log", mass=900.0, length=12.0)
    >>> rw.Turn(log, rw.Rope.named("6x19 EEIP 19"), length=6.0).length
    6.0
    """

    log: Log
    dropline: Rope
    length: float

    def __post_init__(self) -> None:
        check.positive(self.length, f"Dropline of {self.log.name!r}", "length", "m")

    def under(self, x: float, y: float, z: float, mass: float, ground: Profile | None) -> Log:
        """The log near its position under a carriage: an initial guess.

        Parameters
        ----------
        x, y, z : float
            Position of the carriage [m].
        mass : float
            Mass of the log [kg].
        ground : Profile or None
            Ground under the log's rear; None: far below it.

        Returns
        -------
        Log
            The log, with its rear on the ground or free.
        """
        lag = 0.2 * self.length * (-self.log.moving or 1.0)
        log = replace(self.log, at=(x + lag, y, z - 0.98 * self.length), mass=max(mass, LEAST_MASS))
        for _ in range(3):
            log = _on_ground(log, ground, log.rear_start()[0])
        return log


def _on_ground(log: Log, ground: Profile | None, x: float) -> Log:
    """A log with the ground under a point x; without a terrain the ground is far below."""
    if ground is None:
        return log
    *vertex, room = ground.vertex_at(x)
    known: dict[str, Any] = dict(zip(GROUND, (*vertex, min(log.rounding, room)), strict=True))
    return replace(log, **known)
