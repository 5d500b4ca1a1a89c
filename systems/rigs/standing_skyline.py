"""A standing skyline: both ends fixed."""

from __future__ import annotations

from typing import Unpack

from ropeway.components.argument_checks import checked
from ropeway.components.terrain import Profile
from ropeway.systems.rigs.rig_builder import SkylineParts, joined
from ropeway.systems.rigs.skyline_rig import RigKind, SkylineRig


@checked
def standing_skyline(terrain: Profile | None, **parts: Unpack[SkylineParts]) -> SkylineRig:
    """A standing skyline with its carriage.

    terrain: a `Profile`, or None when headspar, supports and tailspar are placed with at=.

    Required: `headspar`, `tailspar`, `skyline` (a Rope), `carriage`; and `tension`, of the bare rope at the headspar
    [N], or `length`, unstretched, of the whole skyline [m]. Optional: `supports`, in the order of their stations.
    `mainline`: from the headspar over rollers at the supports to the carriage; without one an ideal force holds a
    rolling carriage, along the bisector of the skyline's tangents or horizontal (`holding`, "bisector" or
    "horizontal"). A clamped carriage holds by its clamp, without mainline and haulback. `haulback`: its drum keeps
    `haulback_tension` [N]; with a `haulback_block` (a Block by the tailspar) it runs from the headspar to that block
    and back to the carriage, past the supports; without one an ideal drum at the tailspar's top pulls. `turn`: a log
    on a dropline, which drags on the ground or hangs free; the payload is then its mass. `name`; `gravity` [m/s2].
    Raises InputError, SlackRopeError.
    """
    return joined(RigKind.STANDING, terrain, **parts)
