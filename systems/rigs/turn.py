"""A log on a dropline: what hangs under the carriage of a rig."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.log import Log
from ropeway.components.rope import Rope
from ropeway.components.terrain import Profile

LEAST_MASS = 1.0
"""A log's least mass [kg]: a payload of zero is one of this."""

GROUND = ("ground_x", "ground_z", "slope", "slope_after", "rounding")
"""What a log knows of the ground, as `Profile.vertex_at` gives it."""


@checked
@dataclass(frozen=True)
class Turn:
    """A log on a dropline under the carriage; the payload is the log's mass.

    Parameters
    ----------
    log : Log
        Its mass is replaced by the payload.
    dropline : Rope
        Or the name of one in `rw.ropes()`.
    length : float
        Of the dropline, unstretched [m].

    Raises
    ------
    InputError
        The length is not positive.

    Examples
    --------
    >>> log = Log("log", mass=900.0, length=12.0)
    >>> Turn(log, Rope.named("6x19 EEIP 19"), length=6.0).length
    6.0
    """

    log: Log
    dropline: Rope
    length: float

    def __post_init__(self) -> None:
        check.positive(self.length, f"Dropline of {self.log.name!r}", "length", "m")

    def under(self, x: float, y: float, z: float, mass: float, ground: Profile | None) -> Log:
        """The log near its place under a carriage, as a start.

        Parameters
        ----------
        x, y, z : float
            Place of the carriage [m].
        mass : float
            Of the log [kg].
        ground : Profile or None
            Under the log's rear; None: far below.

        Returns
        -------
        Log
            With its rear on the ground, or free.
        """
        lag = 0.2 * self.length * (-self.log.moving or 1.0)
        log = replace(self.log, at=(x + lag, y, z - 0.98 * self.length), mass=max(mass, LEAST_MASS))
        for _ in range(3):
            log = _on_ground(log, ground, log.rear_start()[0])
        return log


def _on_ground(log: Log, ground: Profile | None, x: float) -> Log:
    """A log with the ground under a point x; far below where there is none."""
    if ground is None:
        return log
    *vertex, room = ground.vertex_at(x)
    known: dict[str, Any] = dict(zip(GROUND, (*vertex, min(log.rounding, room)), strict=True))
    return replace(log, **known)
