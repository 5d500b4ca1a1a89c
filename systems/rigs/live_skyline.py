"""Skylines whose length the yarder sets: live skyline, and gravity skyline (shotgun)."""

from __future__ import annotations

from typing import Unpack

from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.carriage import Carriage
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.rope import Rope
from ropeway.components.spar import HeadSpar, TailSpar
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.system import GRAVITY
from ropeway.systems.rigs.rig_builder import SkylineParts, joined
from ropeway.systems.rigs.skyline_rig import RigKind, SkylineRig


@checked
def live_skyline(terrain: Profile | None, **parts: Unpack[SkylineParts]) -> SkylineRig:
    """A skyline on a drum at the headspar, so that it can be lowered and raised: `HEADSPAR.travel` is the rope
    paid out [m]. All keywords are those of `standing_skyline`; `payload(..., clearance=)` and `load_path(...,
    height=)` set its length at each station. Raises InputError, SlackRopeError.
    """
    return joined(RigKind.LIVE, terrain, **parts)


@checked
def gravity_skyline(
    terrain: Profile | None,
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
        RigKind.GRAVITY,
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
