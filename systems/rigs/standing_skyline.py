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
from ropeway.systems.modelling.system import GRAVITY
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
) -> SkylineRig:
    """A standing skyline with its carriage.

    The arguments come in groups: where it stands (`terrain`, `headspar`, `tailspar`, `supports`), the skyline
    (`skyline` with its `tension` or its `length`), the carriage and what holds it (`carriage`, `holding`,
    `mainline`), the haulback (`haulback`, `haulback_tension`, `haulback_block`), and the load (`turn`).

    Parameters
    ----------
    terrain : Profile, str, Path, DataFrame or None
        The ground, or its table with station and elevation [m], as `rw.Profile.from_csv` reads it. None: headspar,
        supports and tailspar are placed with `at=`.
    headspar : HeadSpar
        The skyline ends at its top; a `GuyedSpar` too.
    tailspar : TailSpar or GuyedSpar
        With a tailhold the skyline runs over its top to that.
    supports : sequence of IntermediateSupport, default ()
        In the order of their stations.
    skyline : Rope or str
        Or the name of one in `rw.ropes()`; so for every rope.
    tension : float, optional
        Of the bare skyline at the headspar [N]. Give either this or `length`.
    length : float, optional
        Unstretched, of the whole skyline [m].
    carriage : Carriage
        Rolling, or clamped to the skyline: then it needs neither mainline nor haulback.
    holding : {"bisector", "horizontal"}, default "bisector"
        Direction of the ideal force that holds a rolling carriage without a mainline: along the bisector of the
        skyline's tangents, or horizontal.
    mainline : Rope or str, optional
        From the headspar over rollers at the supports to the carriage.
    haulback : Rope or str, optional
        Pulls the carriage out, at the `haulback_tension` that its drum keeps.
    haulback_tension : float, optional
        At the haulback's drum [N].
    haulback_block : Block, optional
        By the tailspar: the haulback runs from the headspar to it, past the supports, and back to the carriage.
        Without one an ideal drum at the tailspar's top pulls.
    turn : Turn, optional
        A log on a dropline, which drags on the ground or hangs free; the payload is its mass.
    name : str, default "standing skyline"
        Of the rig, in results and messages.
    gravity : float, default 9.80665
        [m/s2].

    Returns
    -------
    SkylineRig
        With its parts at their places.

    Raises
    ------
    InputError
        A part is missing, not in order or below the ground, or the skyline is shorter than its chords.
    SlackRopeError
        The bare skyline does not hang taut at its tension.
    EquilibriumError
        The bare skyline has no equilibrium over its shoes.

    Examples
    --------
    >>> rig = standing_skyline(
    ...     None,
    ...     headspar=HeadSpar("head", at=(0.0, 15.0)),
    ...     supports=[IntermediateSupport("jack", at=(140.0, 2.0))],
    ...     tailspar=TailSpar("tail", at=(300.0, -20.0)),
    ...     skyline="compacted skyline 22",
    ...     tension=70e3,
    ...     mainline="6x19 EEIP 19",
    ...     carriage=Carriage("carriage", mass=450.0),
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
    )
    return build_rig(STANDING, parts, holding)
