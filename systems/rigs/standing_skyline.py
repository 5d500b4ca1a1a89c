"""A standing skyline: fixed at both ends, over any number of intermediate supports."""

from __future__ import annotations

from collections.abc import Sequence

from ropeway.components.carriage import Carriage, Holding
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.rope import Rope
from ropeway.components.spar import Ground, HeadSpar, TailSpar
from ropeway.systems.rigs.skyline import Kind, SkylineRig, Turn, joined
from ropeway.systems.system import GRAVITY


def standing_skyline(
    terrain: Ground | None,
    *,
    headspar: HeadSpar,
    tailspar: TailSpar,
    skyline: Rope,
    carriage: Carriage,
    supports: Sequence[IntermediateSupport] = (),
    tension: float | None = None,
    length: float | None = None,
    mainline: Rope | None = None,
    haulback: Rope | None = None,
    haulback_tension: float | None = None,
    holding: Holding = "bisector",
    turn: Turn | None = None,
    name: str = "standing skyline",
    gravity: float = GRAVITY,
) -> SkylineRig:
    """A standing skyline with its carriage.

    terrain: a `Profile`, or None when headspar, supports and tailspar are placed with at=. tension: of the
    bare rope at the headspar [N]; or length: unstretched, whole skyline [m]. mainline: from the headspar over
    rollers at the supports to the carriage; without one an ideal force holds a rolling carriage, along the
    bisector of the skyline's tangents or horizontal (`holding`). A clamped carriage holds by its clamp.
    haulback: from a block at the tailspar, which keeps `haulback_tension` [N]. turn: a log on a dropline, which
    drags on the ground or hangs free; the payload is then its mass. Raises InputError, SlackRopeError.
    """
    return joined(
        Kind.STANDING,
        terrain,
        headspar=headspar,
        supports=supports,
        tailspar=tailspar,
        skyline=skyline,
        tension=tension,
        length=length,
        mainline=mainline,
        haulback=haulback,
        haulback_tension=haulback_tension,
        carriage=carriage,
        holding=holding,
        turn=turn,
        name=name,
        gravity=gravity,
    )
