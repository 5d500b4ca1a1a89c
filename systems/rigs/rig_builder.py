"""Construction of rigs: places their parts on the terrain, checks them, and solves for the skyline's length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from itertools import pairwise

import numpy as np

from ropeway.components import check
from ropeway.components.carriage import Holding
from ropeway.components.environment import TEMPERATURES
from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.node import Node
from ropeway.systems.modelling.empty_rope import lengths_for_tension
from ropeway.systems.rigs.bare_skyline import length_over_shoes
from ropeway.systems.rigs.rig_kind import RigKind
from ropeway.systems.rigs.rig_parts import RigParts
from ropeway.systems.rigs.skyline_rig import SkylineRig


def build_rig(kind: RigKind, parts: RigParts, holding: Holding = "bisector") -> SkylineRig:
    """A rig from its parts, placed on the terrain and checked. Raises InputError, SlackRopeError, EquilibriumError.

    `holding` is the direction of the ideal force on a carriage without mainline and clamp.
    """
    check.positive(parts.gravity, parts.name, "gravity", "m/s2")
    check.number(parts.temperature, parts.name, "temperature", "degrees C", TEMPERATURES)
    parts = _placed(parts)
    _require_order(parts.stands)
    _require_lines(parts)
    kind.require_parts(parts)
    parts = replace(
        _with_blocks(kind, parts),
        supports=_with_shoes(parts.stands),
        carriage=replace(parts.carriage, holding=holding if parts.ideal else None),
    )
    rig = SkylineRig(kind=kind, **{field.name: getattr(parts, field.name) for field in fields(parts)})
    return _with_length(rig) if kind.keeps_length else rig


def with_supports(rig: SkylineRig, supports: Sequence[IntermediateSupport], length: float | None = None) -> SkylineRig:
    """The same rig over other supports, with the same tension of its bare rope; `length`: that of its skyline [m], if
    it is known. Raises InputError, SlackRopeError, EquilibriumError."""
    placed = [support.placed(rig.terrain) for support in supports]
    over = replace(rig, supports=_with_shoes([rig.headspar, *placed, rig.tailspar]), length=length)
    return _with_length(over) if length is None else _long_enough(over)


def _placed(parts: RigParts) -> RigParts:
    """The parts at their points on the terrain. Raises InputError."""
    ground, tail, block = parts.terrain, parts.tailspar.placed(parts.terrain), parts.haulback_block
    if tail.tailhold is not None:
        tail = replace(tail, tailhold=tail.tailhold.placed(ground))
    return replace(
        parts,
        headspar=parts.headspar.placed(ground),
        supports=tuple(support.placed(ground) for support in parts.supports),
        tailspar=tail,
        haulback_block=None if block is None else block.placed(ground),
    )


def _with_blocks(kind: RigKind, parts: RigParts) -> RigParts:
    """The parts with a block at the top of a guyed spar for each rope that passes there."""
    head, tail = parts.headspar, parts.tailspar
    if isinstance(head, GuyedSpar):
        back = parts.haulback_block is not None and not parts.carriage.clamped
        lines = [rope for rope, on in (("mainline", parts.pulled), ("haulback", back)) if on]
        head = replace(head, blocks=(*kind.yarder_ropes, *lines))
    if isinstance(tail, GuyedSpar):
        tail = replace(tail, blocks=kind.tail_ropes(parts))
    return replace(parts, headspar=head, tailspar=tail)


def _require_order(stands: Sequence[Node]) -> None:
    """Raises InputError unless the stations of spars and supports increase."""
    for before, after in pairwise(stands):
        if not before.at[0] < after.at[0]:
            raise InputError(
                f"{after.described} stands at station {after.at[0]:g} m, "
                f"{before.described} before it at {before.at[0]:g} m",
                "Give headspar, supports and tailspar in the order of their stations",
            )


def _require_lines(parts: RigParts) -> None:
    """Raises InputError for an incomplete haulback or turn."""
    name, haulback, block = parts.name, parts.haulback, parts.haulback_block
    if (haulback is None) != (parts.haulback_tension is None):
        raise InputError(f"{name} has only one of haulback and haulback_tension", "Give both, or neither")
    if parts.haulback_tension is not None:
        check.positive(parts.haulback_tension, name, "haulback_tension", "N")
    if haulback is None and block is not None:
        raise InputError(f"{name} has a haulback_block but no haulback", "Give haulback and haulback_tension too")
    if haulback is not None and parts.ideal:
        raise InputError(f"{name} has a haulback but no mainline", "Give a mainline that holds it back")
    if haulback is not None and block is None and isinstance(parts.tailspar, GuyedSpar) and parts.pulled:
        raise InputError(
            f"{name}: the ideal drum of a haulback needs a rigid tailspar; {parts.tailspar.described} is guyed",
            "Give a haulback_block",
        )
    if parts.turn is not None and parts.terrain is None:
        raise InputError(f"{name}: a log drags on a terrain", "Give a Profile")


def _with_length(rig: SkylineRig) -> SkylineRig:
    """The rig with the skyline's length for its tension, checked against its strength."""
    if (rig.length is None) == (rig.tension is None):
        raise InputError(f"{rig.name} needs either length or tension", "Give one of them")
    return _long_enough(rig if rig.tension is None else replace(rig, length=length_for(rig, rig.tension)))


def _long_enough(rig: SkylineRig) -> SkylineRig:
    """The rig, its skyline's length checked against its strength. Raises InputError."""
    length = rig.length
    check.positive(length or 0.0, rig.name, "length", "m")
    with np.errstate(over="ignore"):  # ground of 1e300 m: infinite chords are longer than any rope
        chords = float(np.linalg.norm(np.diff(rig.points, axis=0), axis=1).sum())
    shortest = chords / (1.0 + rig.skyline.strain.at(rig.skyline.breaking_load))
    if (length or 0.0) <= shortest:
        raise InputError(
            f"{rig.name}: the skyline is {length:.6g} m long; at its minimum breaking load it needs at least "
            f"{shortest:.6g} m to reach from {rig.headspar.name!r} to {rig.ends[-1].name!r}",
            "Give a longer skyline or a lower tension",
        )
    return rig


def length_for(rig: SkylineRig, tension: float) -> float:
    """Unstretched length [m] of the bare skyline for a tension at the headspar [N]. Raises InputError,
    SlackRopeError, EquilibriumError."""
    rope = rig.skyline
    check.positive(tension, rig.name, "tension", "N")
    if tension >= rope.breaking_load:
        raise InputError(
            f"{rig.name}: tension {tension:g} N is above the rope's minimum breaking load {rope.breaking_load:g} N",
            "Reduce the tension or choose a stronger rope",
        )
    names = [f"{a.name}_{b.name}" for a, b in pairwise(rig.ends)]
    weight, points = rope.mass_per_length * rig.gravity, [tuple(p) for p in rig.points]
    length = float(np.sum(lengths_for_tension(points, weight, rope.strain, tension, names)))
    if any(support.radius > 0.0 for support in rig.supports):  # so far over the supports' points
        length = length_over_shoes(replace(rig, length=length), tension)
    return length


def _with_shoes(stands: Sequence[Node]) -> tuple[IntermediateSupport, ...]:
    """The supports between the first and the last of `stands`, their shoes along the bisector of the chords.
    Raises InputError."""
    supports = []
    for before, support, after in zip(stands[:-2], stands[1:-1], stands[2:], strict=True):
        if not isinstance(support, IntermediateSupport):
            continue
        if support.radius > 0.0:
            if support.friction > 0.0:
                raise InputError(f"{support.described} has a radius and friction", "Remove one of them")
            if len({node.at[1] for node in stands}) > 1:
                raise InputError(f"{support.described}: a shoe lies in the plane of the line", "Remove its radius")
            if support.slope is None:
                chords = np.diff([before.at, support.at, after.at], axis=0)
                x, _, z = (chords / np.linalg.norm(chords, axis=1)[:, None]).sum(axis=0)
                support = replace(support, slope=float(z / x))
        supports.append(support)
    return tuple(supports)
