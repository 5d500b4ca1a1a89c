"""Skylines whose length the yarder sets: live skyline, and gravity skyline (shotgun)."""

from __future__ import annotations

from typing import Unpack

from ropeway.components.carriage import Carriage
from ropeway.components.checked import checked
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.hints import Positive
from ropeway.components.rope import Rope
from ropeway.components.spar import Ground, HeadSpar, TailSpar
from ropeway.systems.rigs.joining import SkylineParts, joined
from ropeway.systems.rigs.skyline import Kind, SkylineRig
from ropeway.systems.system import GRAVITY


@checked
def live_skyline(terrain: Ground | None, **parts: Unpack[SkylineParts]) -> SkylineRig:
    """A skyline on a drum at the headspar, so that it can be lowered and raised: `HEADSPAR.travel` is the rope
    paid out [m]. All keywords are those of `standing_skyline`; `payload(..., clearance=)` and `load_path(...,
    height=)` set its length at each station. Raises InputError, SlackRopeError.
    """
    return joined(Kind.LIVE, terrain, **parts)


@checked
def gravity_skyline(
    terrain: Ground | None,
    *,
    headspar: HeadSpar,
    tailspar: TailSpar | GuyedSpar,
    skyline: Rope,
    mainline: Rope,
    carriage: Carriage,
    tension: float | None = None,
    length: float | None = None,
    name: str = "gravity skyline",
    gravity: Positive = GRAVITY,
) -> SkylineRig:
    """A live skyline without a haulback (shotgun): the empty carriage runs out by its weight, the mainline
    brings it in. `payload` gives 0 where the empty carriage does not run out. Raises InputError,
    SlackRopeError.
    """
    return joined(
        Kind.GRAVITY,
        terrain,
        headspar=headspar,
        tailspar=tailspar,
        skyline=skyline,
        tension=tension,
        length=length,
        mainline=mainline,
        carriage=carriage,
        name=name,
        gravity=gravity,
    )
