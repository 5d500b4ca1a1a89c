"""A running skyline: the haulback runs over the carriage to the tail block and back to the carriage."""

from __future__ import annotations

from ropeway.components import check
from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.carriage import Carriage
from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.rope import Rope
from ropeway.components.spar import HeadSpar, TailSpar
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.system import GRAVITY
from ropeway.systems.rigs.rig_builder import joined
from ropeway.systems.rigs.skyline_rig import RigKind, SkylineRig


@checked
def running_skyline(
    terrain: Profile | None,
    *,
    headspar: HeadSpar,
    tailspar: TailSpar | GuyedSpar,
    haulback: Rope,
    mainline: Rope,
    carriage: Carriage,
    tension: float,
    name: str = "running skyline",
    gravity: Positive = GRAVITY,
) -> SkylineRig:
    """A running skyline. tension: of the haulback at its drum, which the yarder keeps [N]; the mainline holds
    the carriage. `payload(..., clearance=)` and `load_path(..., height=)` set the tension at each station
    instead. Raises InputError.
    """
    check.positive(tension, name, "tension", "N")
    if carriage.clamped:
        raise InputError(f"{carriage.described} is clamped", "A running skyline's carriage rolls on the haulback")
    return joined(
        RigKind.RUNNING,
        terrain,
        headspar=headspar,
        tailspar=tailspar,
        skyline=haulback,
        tension=tension,
        mainline=mainline,
        carriage=carriage,
        name=name,
        gravity=gravity,
    )
