"""Skylines with a length that the yarder sets: live skyline and gravity skyline (shotgun)."""

from __future__ import annotations

from collections.abc import Sequence

from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.carriage import Carriage, Holding
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.rope import Rope, rope_of
from ropeway.components.spar import Block, HeadSpar, TailSpar
from ropeway.components.terrain import ProfileSource, profile_of
from ropeway.systems.modelling.system import GRAVITY, STRUNG
from ropeway.systems.rigs import rig_kind
from ropeway.systems.rigs.rig_builder import build_rig
from ropeway.systems.rigs.rig_parts import RigParts
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.rigs.turn import Turn


@checked
def live_skyline(
    terrain: ProfileSource | None,
    *,
    headspar: HeadSpar,
    tailspar: TailSpar | GuyedSpar,
    supports: Sequence[IntermediateSupport] = (),
    skyline: Rope | str,
    tension: float | None = None,
    length: float | None = None,
    carriage: Carriage,
    holding: Holding = "bisector",
    mainline: Rope | str | None = None,
    haulback: Rope | str | None = None,
    haulback_tension: float | None = None,
    haulback_block: Block | None = None,
    turn: Turn | None = None,
    name: str = "live skyline",
    gravity: Positive = GRAVITY,
    temperature: float = STRUNG,
) -> SkylineRig:
    """A skyline on a drum at the headspar, which lowers and raises it.

    `HEADSPAR.travel` is the rope paid out [m]; `rw.payload(..., clearance=)` and `rw.load_path(..., height=)` set the
    skyline's length at each station. The arguments come in the groups of `rw.standing_skyline`.

    Parameters
    ----------
    terrain : Profile, str, Path, DataFrame or None
        Ground, or its table with station and elevation [m]. None: spars and supports are placed with `at=`.
    headspar : HeadSpar
        The headspar. The drums of a `GuyedSpar` stand at its foot.
    tailspar : TailSpar or GuyedSpar
        The tailspar. If it has a tailhold, the skyline runs over its top to the tailhold.
    supports : sequence of IntermediateSupport, default ()
        In the order of their stations.
    skyline : Rope or str
        A rope, or a name from `rw.ropes()`, as for every rope argument.
    tension : float, optional
        Tension of the bare skyline at the headspar [N], before lowering. Give either this or `length`.
    length : float, optional
        Unstretched length from the headspar to the end of the skyline [m], before lowering.
    carriage : Carriage
        The carriage, rolling or clamped to the skyline.
    holding : {"bisector", "horizontal"}, default "bisector"
        Direction of the ideal force that holds a rolling carriage without a mainline.
    mainline : Rope or str, optional
        Rope from the headspar over rollers at the supports to the carriage.
    haulback : Rope or str, optional
        Rope that pulls the carriage out. Its drum keeps `haulback_tension`.
    haulback_tension : float, optional
        Tension at the haulback's drum [N].
    haulback_block : Block, optional
        Block near the tailspar: the haulback runs to it and back to the carriage. Otherwise an ideal drum at the top of
        the tailspar pulls.
    turn : Turn, optional
        A log on a dropline, dragging or free. Its mass is the payload.
    name : str, default "live skyline"
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
        A part is missing, out of order or below the ground, or the skyline is shorter than its chords.
    SlackRopeError
        The given tension leaves the bare skyline slack.
    EquilibriumError
        The bare skyline has no equilibrium over its shoes.

    Examples
    --------
    >>> rig = rw.live_skyline(
    ...     None,
    ...     headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
    ...     tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
    ...     skyline="compacted skyline 22",
    ...     length=306.0,
    ...     carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> rig.kind.sets_height
    True
    """
    parts = RigParts(
        terrain=profile_of(terrain),
        headspar=headspar,
        tailspar=tailspar,
        supports=tuple(supports),
        skyline=rope_of(skyline),
        tension=tension,
        length=length,
        carriage=carriage,
        mainline=rope_of(mainline),
        haulback=rope_of(haulback),
        haulback_tension=haulback_tension,
        haulback_block=haulback_block,
        turn=turn,
        name=name,
        gravity=gravity,
        temperature=temperature,
    )
    return build_rig(rig_kind.LIVE, parts, holding)


@checked
def gravity_skyline(
    terrain: ProfileSource | None,
    *,
    headspar: HeadSpar,
    tailspar: TailSpar | GuyedSpar,
    skyline: Rope | str,
    tension: float | None = None,
    length: float | None = None,
    carriage: Carriage,
    mainline: Rope | str,
    name: str = "gravity skyline",
    gravity: Positive = GRAVITY,
    temperature: float = STRUNG,
) -> SkylineRig:
    """A live skyline without a haulback (shotgun).

    The empty carriage runs out by gravity, the mainline pulls it in. The payload of `rw.payload` is 0 where the empty
    carriage does not run out.

    Parameters
    ----------
    terrain : Profile, str, Path, DataFrame or None
        Ground, or its table with station and elevation [m]. None: the spars are placed with `at=`.
    headspar : HeadSpar
        The headspar. The yarder's drums are at its top, or at the foot of a `GuyedSpar`.
    tailspar : TailSpar or GuyedSpar
        The tailspar. If it has a tailhold, the skyline runs over its top to the tailhold.
    skyline : Rope or str
        A rope, or a name from `rw.ropes()`, as for every rope argument.
    tension : float, optional
        Tension of the bare skyline at the headspar [N], before lowering. Give either this or `length`.
    length : float, optional
        Unstretched length from the headspar to the end of the skyline [m], before lowering.
    carriage : Carriage
        The carriage, rolling or clamped to the skyline.
    mainline : Rope or str
        Rope from the headspar to the carriage.
    name : str, default "gravity skyline"
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
        A part is missing or below the ground, or the skyline is shorter than its chord.
    SlackRopeError
        The given tension leaves the bare skyline slack.

    Examples
    --------
    >>> rig = rw.gravity_skyline(
    ...     None,
    ...     headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
    ...     tailspar=rw.TailSpar("tail", at=(300.0, -80.0)),
    ...     skyline="compacted skyline 22",
    ...     tension=40e3,
    ...     mainline="6x19 EEIP 19",
    ...     carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> rig.spans
    1
    """
    parts = RigParts(
        terrain=profile_of(terrain),
        headspar=headspar,
        tailspar=tailspar,
        skyline=rope_of(skyline),
        tension=tension,
        length=length,
        mainline=rope_of(mainline),
        carriage=carriage,
        name=name,
        gravity=gravity,
        temperature=temperature,
    )
    return build_rig(rig_kind.GRAVITY, parts)
