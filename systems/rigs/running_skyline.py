"""A running skyline: the haulback runs over the carriage to the tail block and back to the carriage."""

from __future__ import annotations

from ropeway.components import check
from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.carriage import Carriage
from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.rope import Rope, rope_of
from ropeway.components.spar import HeadSpar, TailSpar
from ropeway.components.terrain import ProfileSource, profile_of
from ropeway.systems.modelling.system import GRAVITY, STRUNG
from ropeway.systems.rigs.rig_builder import build_rig
from ropeway.systems.rigs.rig_kind import RUNNING
from ropeway.systems.rigs.rig_parts import RigParts
from ropeway.systems.rigs.skyline_rig import SkylineRig


@checked
def running_skyline(
    terrain: ProfileSource | None,
    *,
    headspar: HeadSpar,
    tailspar: TailSpar | GuyedSpar,
    haulback: Rope | str,
    tension: float,
    mainline: Rope | str,
    carriage: Carriage,
    name: str = "running skyline",
    gravity: Positive = GRAVITY,
    temperature: float = STRUNG,
) -> SkylineRig:
    """A running skyline: the haulback carries the carriage, the mainline holds it.

    `rw.payload(..., clearance=)` and `rw.load_path(..., height=)` set the haulback's tension at each station.

    Parameters
    ----------
    terrain : Profile, str, Path, DataFrame or None
        Ground, or its table with station and elevation [m]. None: the spars are placed with `at=`.
    headspar : HeadSpar
        The headspar. The yarder's drums are at its top, or at the foot of a `GuyedSpar`.
    tailspar : TailSpar or GuyedSpar
        The tailspar, without a tailhold.
    haulback : Rope or str
        A rope, or a name from `rw.ropes()`, as for every rope argument.
    tension : float
        Tension of the haulback at its drum, kept by the yarder [N].
    mainline : Rope or str
        Rope from the headspar to the carriage.
    carriage : Carriage
        The carriage, a rolling one.
    name : str, default "running skyline"
        Name of the rig in results and messages.
    gravity : float, default 9.80665
        Gravitational acceleration [m/s2].
    temperature : float, default 15
        Temperature at which the ropes are strung [degrees C].

    Returns
    -------
    SkylineRig
        The rig with its parts in position.

    Raises
    ------
    InputError
        The tension is not positive, the carriage is clamped, or the tailspar has a tailhold.

    Examples
    --------
    >>> rig = rw.running_skyline(
    ...     None,
    ...     headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
    ...     tailspar=rw.TailSpar("tail", at=(200.0, 10.0)),
    ...     haulback="6x19 EEIP 19",
    ...     tension=40e3,
    ...     mainline="6x19 EEIP 19",
    ...     carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> rig
    <SkylineRig 'running skyline': head at 0 m, tail at 200 m>
    """
    check.positive(tension, name, "tension", "N")
    if carriage.clamped:
        raise InputError(f"{carriage.described} is clamped", "A running skyline's carriage rolls on the haulback")
    parts = RigParts(
        terrain=profile_of(terrain),
        headspar=headspar,
        tailspar=tailspar,
        skyline=rope_of(haulback),
        tension=tension,
        mainline=rope_of(mainline),
        carriage=carriage,
        name=name,
        gravity=gravity,
        temperature=temperature,
    )
    return build_rig(RUNNING, parts)
