"""Skylines whose length the yarder sets: live skyline, and gravity skyline (shotgun)."""

from __future__ import annotations

from collections.abc import Sequence

from ropeway.components.carriage import Carriage, Holding
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.rope import Rope
from ropeway.components.spar import Ground, HeadSpar, TailSpar
from ropeway.systems.rigs.skyline import Kind, SkylineRig, Turn, joined
from ropeway.systems.system import GRAVITY


def live_skyline(
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
    name: str = "live skyline",
    gravity: float = GRAVITY,
) -> SkylineRig:
    """A skyline on a drum at the headspar, so that it can be lowered and raised: `HEADSPAR.travel` is the rope
    paid out [m]. Everything else as for `standing_skyline`; `payload(..., clearance=)` and `load_path(...,
    height=)` set its length at each station. Raises InputError, SlackRopeError.
    """
    return joined(
        Kind.LIVE,
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


def gravity_skyline(
    terrain: Ground | None,
    *,
    headspar: HeadSpar,
    tailspar: TailSpar,
    skyline: Rope,
    mainline: Rope,
    carriage: Carriage,
    tension: float | None = None,
    length: float | None = None,
    name: str = "gravity skyline",
    gravity: float = GRAVITY,
) -> SkylineRig:
    """A live skyline without a haulback (shotgun): the empty carriage runs out by its weight, the mainline
    brings it in. `payload` gives 0 where the empty carriage does not run out. Raises InputError,
    SlackRopeError.
    """
    return joined(
        Kind.GRAVITY,
        terrain,
        headspar=headspar,
        supports=(),
        tailspar=tailspar,
        skyline=skyline,
        tension=tension,
        length=length,
        mainline=mainline,
        haulback=None,
        haulback_tension=None,
        carriage=carriage,
        holding="bisector",
        name=name,
        gravity=gravity,
    )
