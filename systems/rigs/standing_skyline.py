"""A standing skyline: both ends fixed."""

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
from ropeway.systems.rigs.rig_builder import build_rig
from ropeway.systems.rigs.rig_kind import STANDING
from ropeway.systems.rigs.rig_parts import RigParts
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.rigs.turn import Turn


@checked
def standing_skyline(
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
    name: str = "standing skyline",
    gravity: Positive = GRAVITY,
    temperature: float = STRUNG,
) -> SkylineRig:
    """A standing skyline with its carriage.

    The arguments form groups: the site (`terrain`, `headspar`, `tailspar`, `supports`), the skyline (`skyline` with its
    `tension` or its `length`), the carriage and its hold (`carriage`, `holding`, `mainline`), the haulback (`haulback`,
    `haulback_tension`, `haulback_block`), and the load (`turn`).

    Parameters
    ----------
    terrain : Profile, str, Path, DataFrame or None
        Ground, or its table with station and elevation [m], in the format of `rw.Profile.from_csv`. None: headspar,
        supports and tailspar are placed with `at=`.
    headspar : HeadSpar
        The headspar, also a `GuyedSpar`. The skyline ends at its top.
    tailspar : TailSpar or GuyedSpar
        The tailspar. If it has a tailhold, the skyline runs over its top to the tailhold.
    supports : sequence of IntermediateSupport, default ()
        In the order of their stations.
    skyline : Rope or str
        A rope, or a name from `rw.ropes()`, as for every rope argument.
    tension : float, optional
        Tension of the bare skyline at the headspar [N]. Give either this or `length`.
    length : float, optional
        Unstretched length of the whole skyline [m].
    carriage : Carriage
        The carriage, rolling or clamped to the skyline. A clamped one needs neither mainline nor haulback.
    holding : {"bisector", "horizontal"}, default "bisector"
        Direction of the ideal force that holds a rolling carriage without a mainline: along the bisector of the
        skyline's tangents, or horizontal.
    mainline : Rope or str, optional
        Rope from the headspar over rollers at the supports to the carriage.
    haulback : Rope or str, optional
        Rope that pulls the carriage out. Its drum keeps `haulback_tension`.
    haulback_tension : float, optional
        Tension at the haulback's drum [N].
    haulback_block : Block, optional
        Block near the tailspar: the haulback runs from the headspar to it, past the supports, and back to the carriage.
        Otherwise an ideal drum at the top of the tailspar pulls.
    turn : Turn, optional
        A log on a dropline, dragging or free. Its mass is the payload.
    name : str, default "standing skyline"
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
    >>> rig = rw.standing_skyline(
    ...     None,
    ...     headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
    ...     supports=[rw.IntermediateSupport("jack", at=(140.0, 2.0))],
    ...     tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
    ...     skyline="compacted skyline 22",
    ...     tension=70e3,
    ...     mainline="6x19 EEIP 19",
    ...     carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> round(rig.length, 2)
    301.32
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
    return build_rig(STANDING, parts, holding)
