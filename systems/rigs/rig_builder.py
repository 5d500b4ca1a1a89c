"""How rigs are made: their parts placed on the terrain and checked, and the skyline's length for its tension."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Required, TypedDict

import numpy as np

from ropeway.components import check
from ropeway.components.annotation_checks import Positive
from ropeway.components.carriage import Carriage, Holding
from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.node import Node
from ropeway.components.rope import Rope
from ropeway.components.spar import Block, HeadSpar, TailSpar
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.empty_rope import lengths_for_tension
from ropeway.systems.modelling.system import GRAVITY
from ropeway.systems.rigs.bare_skyline import length_over_shoes
from ropeway.systems.rigs.skyline_rig import RigKind, SkylineRig, Turn


class SkylineParts(TypedDict, total=False):
    """The keywords of `standing_skyline` and `live_skyline`: four are required."""

    headspar: Required[HeadSpar]
    tailspar: Required[TailSpar | GuyedSpar]
    skyline: Required[Rope]
    carriage: Required[Carriage]
    supports: Sequence[IntermediateSupport]
    tension: float | None
    length: float | None
    mainline: Rope | None
    haulback: Rope | None
    haulback_tension: float | None
    haulback_block: Block | None
    holding: Holding
    turn: Turn | None
    name: str
    gravity: Positive


def joined(
    kind: RigKind,
    terrain: Profile | None,
    *,
    headspar: HeadSpar,
    tailspar: TailSpar | GuyedSpar,
    skyline: Rope,
    carriage: Carriage,
    supports: Sequence[IntermediateSupport] = (),
    tension: float | None = None,
    length: float | None = None,
    mainline: Rope | None = None,
    haulback: Rope | None = None,
    haulback_tension: float | None = None,
    haulback_block: Block | None = None,
    holding: Holding = "bisector",
    turn: Turn | None = None,
    name: str | None = None,
    gravity: float = GRAVITY,
) -> SkylineRig:
    """A rig from its parts, placed on the terrain and checked. Raises InputError, SlackRopeError, EquilibriumError."""
    name = f"{kind.value} skyline" if name is None else name
    check.positive(gravity, name, "gravity", "m/s2")
    head = headspar.placed(terrain)
    tail = tailspar.placed(terrain)
    if tail.tailhold is not None:
        tail = replace(tail, tailhold=tail.tailhold.placed(terrain))
    if isinstance(head, GuyedSpar):
        lead = {
            RigKind.STANDING: (),
            RigKind.LIVE: ("skyline",),
            RigKind.GRAVITY: ("skyline",),
            RigKind.RUNNING: ("haulback",),
        }
        pulled = mainline is not None and not carriage.clamped
        back = haulback_block is not None and not carriage.clamped
        more = [rope for rope, on in (("mainline", pulled), ("haulback", back)) if on]
        head = replace(head, blocks=(*lead[kind], *more))
    if isinstance(tail, GuyedSpar):
        through = "haulback" if kind is RigKind.RUNNING else "skyline"
        tail = replace(tail, blocks=(through,) if kind is RigKind.RUNNING or tail.tailhold is not None else ())
    between = tuple(support.placed(terrain) for support in supports)
    stands = (head, *between, tail)
    for before, after in pairwise(stands):
        if not before.at[0] < after.at[0]:
            raise InputError(
                f"{after.described} stands at station {after.at[0]:g} m, "
                f"{before.described} before it at {before.at[0]:g} m",
                "Name headspar, supports and tailspar in the order of their stations",
            )
    if (haulback is None) != (haulback_tension is None):
        raise InputError(f"{name} has one of haulback and haulback_tension", "Give both, or none")
    if haulback_tension is not None:
        check.positive(haulback_tension, name, "haulback_tension", "N")
    if haulback is None and haulback_block is not None:
        raise InputError(f"{name} has a haulback_block and no haulback", "Give haulback and haulback_tension too")
    if haulback is not None and mainline is None and not carriage.clamped and kind is not RigKind.RUNNING:
        raise InputError(f"{name} has a haulback and no mainline", "Give a mainline that holds against it")
    if haulback is not None and haulback_block is None and isinstance(tail, GuyedSpar) and not carriage.clamped:
        raise InputError(
            f"{name}: the ideal drum of a haulback would not pull at {tail.described}, which gives way",
            "Give a haulback_block",
        )
    if kind is RigKind.RUNNING and tail.tailhold is not None:
        raise InputError(f"{name} has no skyline for {tail.tailhold.described}", "Leave the tailhold out")
    if turn is not None and (terrain is None or kind is RigKind.RUNNING):
        raise InputError(f"{name}: a log drags on a terrain", "Give a Profile, and a standing or live skyline")
    ideal = mainline is None and not carriage.clamped
    rig = SkylineRig(
        kind=kind,
        terrain=terrain,
        headspar=head,
        supports=_shod(stands),
        tailspar=tail,
        skyline=skyline,
        length=length,
        tension=tension,
        mainline=mainline,
        haulback=haulback,
        haulback_tension=haulback_tension,
        haulback_block=None if haulback_block is None else haulback_block.placed(terrain),
        carriage=replace(carriage, holding=holding if ideal else None),
        turn=turn,
        name=name,
        gravity=gravity,
    )
    return rig if kind is RigKind.RUNNING else _with_length(rig)


def with_supports(rig: SkylineRig, supports: Sequence[IntermediateSupport]) -> SkylineRig:
    """The same rig over other supports, its bare rope at the same tension. Raises InputError, SlackRopeError,
    EquilibriumError."""
    placed = [support.placed(rig.terrain) for support in supports]
    return _with_length(replace(rig, supports=_shod([rig.headspar, *placed, rig.tailspar]), length=None))


def _with_length(rig: SkylineRig) -> SkylineRig:
    """With the skyline's length for its tension, checked against its strength."""
    rope, points = rig.skyline, rig.points
    weight = rope.mass_per_length * rig.gravity
    if (rig.length is None) == (rig.tension is None):
        raise InputError(f"{rig.name} needs either length or tension", "Give one of them")
    length = rig.length
    if rig.tension is not None:
        check.positive(rig.tension, rig.name, "tension", "N")
        if rig.tension >= rope.breaking_load:
            raise InputError(
                f"{rig.name}: tension {rig.tension:g} N is above the rope's minimum breaking load "
                f"{rope.breaking_load:g} N",
                "Ask for less tension or take a stronger rope",
            )
        names = [f"{a.name}_{b.name}" for a, b in pairwise(rig.stands)]
        names += [f"{a.name}_{b.name}" for a, b in pairwise(rig.ends[len(rig.stands) - 1 :])]
        length = float(np.sum(lengths_for_tension([tuple(p) for p in points], weight, rope.strain, rig.tension, names)))
        if any(support.radius > 0.0 for support in rig.supports):  # so far over the points of the supports
            length = length_over_shoes(replace(rig, length=length), rig.tension)
    check.positive(length or 0.0, rig.name, "length", "m")
    chords = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    shortest = chords / (1.0 + rope.strain.at(rope.breaking_load))
    if (length or 0.0) <= shortest:
        raise InputError(
            f"{rig.name}: the skyline is {length:.6g} m long; at its minimum breaking load it needs at least "
            f"{shortest:.6g} m to reach from {rig.headspar.name!r} to {rig.ends[-1].name!r}",
            "Give a longer skyline or a lower tension",
        )
    return replace(rig, length=length)


def _shod(stands: Sequence[Node]) -> tuple[IntermediateSupport, ...]:
    """The supports between the first and the last of `stands`, their shoes along the bisector of the chords.
    Raises InputError."""
    found = []
    for before, support, after in zip(stands[:-2], stands[1:-1], stands[2:], strict=True):
        if not isinstance(support, IntermediateSupport):
            continue
        if support.radius > 0.0:
            if support.friction > 0.0:
                raise InputError(f"{support.described} has a radius and friction", "Leave one of them out")
            if len({node.at[1] for node in stands}) > 1:
                raise InputError(f"{support.described}: a shoe lies in the plane of the line", "Leave its radius out")
            if support.slope is None:
                ways = np.diff([before.at, support.at, after.at], axis=0)
                x, _, z = (ways / np.linalg.norm(ways, axis=1)[:, None]).sum(axis=0)
                support = replace(support, slope=float(z / x))
        found.append(support)
    return tuple(found)
