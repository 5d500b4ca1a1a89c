"""The ropes of a rig in its System: the drums, blocks and supports of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ropeway.components.carriage import Carriage
from ropeway.components.component import Seat
from ropeway.components.drum import Drum
from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.node import Node
from ropeway.components.rope import Rope
from ropeway.components.sheave import Sheave
from ropeway.components.spar import Block
from ropeway.systems.modelling.system import System
from ropeway.systems.rigs import carriage_guess
from ropeway.systems.rigs.bare_skyline import lengths_over_points, tension_over_points
from ropeway.systems.rigs.rig_parts import RigParts


def from_yarder(rig: RigParts, rope: str, drum: str, tension: float | None = None) -> list[Any]:
    """First nodes of a rope: a drum at the top of the headspar, or a drum at the foot of a guyed spar and a block at
    its top."""
    if isinstance(rig.headspar, GuyedSpar):
        return [Drum(drum, at=rig.headspar.foot, tension=tension), rig.headspar.block(rope)]
    return [Drum(drum, at=rig.headspar.at, tension=tension)]


def tail_block(rig: RigParts, rope: str) -> Node | Seat:
    """The block of a rope at the top of the tailspar."""
    if isinstance(rig.tailspar, GuyedSpar):
        return rig.tailspar.block(rope)
    return Block(rig.tailspar.name, at=rig.tailspar.at, capacity=rig.tailspar.capacity)


def string_skyline(
    system: System, rig: RigParts, carriage: Carriage, head: Sequence[Any], span: int, on: int | None
) -> None:
    """The skyline from its `head` (a spar, or a drum and a block) over the supports to its end. The carriage is in a
    span, or `on` a support."""
    hold = rig.tailspar.tailhold
    tail = (rig.tailspar,) if hold is None else (tail_block(rig, "skyline"), hold)
    over: list[Any] = [*head, *rig.supports, *tail]
    first = len(head) + span
    over[first : first + (on is not None)] = [carriage]
    length = rig.length or 0.0
    if len(head) > 1:  # from the drum up to the block, with the stretch of the bare rope
        strain = rig.skyline.strain.at(tension_over_points(rig))
        length += float(np.linalg.norm(np.subtract(_node(head[1]).at, head[0].at))) / (1.0 + strain)
    if any(s.friction > 0.0 for s in rig.supports):
        # Saddle friction counts from the position of the bare rope in each saddle, given by the rope length beyond it.
        strung = np.cumsum(lengths_over_points(rig, [_node(o).at for o in over], length)[::-1])[::-1]
        bare = np.cumsum(lengths_over_points(rig, rig.points, rig.length or 0.0)[::-1])[::-1]
        for k, support in enumerate(rig.supports):
            if k != on:
                place = over.index(support)
                over[place] = replace(support, rest=float(bare[k + 1] - strung[place]))
    system.string(rig.skyline, *over, length=length)


def string_running_skyline(system: System, rig: RigParts, carriage: Carriage) -> None:
    """The haulback of a running skyline: from its drum over the carriage to the tail block and back to the carriage."""
    over = [*from_yarder(rig, "haulback", "haulback", rig.tension), carriage, tail_block(rig, "haulback")]
    _string(system, rig.skyline, [*over, carriage.haulback], rig.tension or 0.0)


def string_haulback(system: System, rig: RigParts, carriage: Carriage) -> None:
    """The haulback of a rig that has one besides its skyline: from the yarder to its block and back to the carriage.
    Without a block it starts at an ideal drum at the top of the tailspar."""
    if rig.haulback is None or carriage.clamped:
        return
    if rig.haulback_block is None:
        path: list[Any] = [Drum("haulback", at=rig.tailspar.at, tension=rig.haulback_tension)]
    else:
        path = [*from_yarder(rig, "haulback", "haulback", rig.haulback_tension), rig.haulback_block]
    _string(system, rig.haulback, [*path, carriage.haulback], rig.haulback_tension or 0.0)


def string_mainline(system: System, rig: RigParts, carriage: Carriage, count: int, pull: float) -> None:
    """The mainline over rollers at the first `count` supports to the carriage. `pull` is an estimate of its tension
    [N]."""
    if rig.mainline is None or not rig.pulled:
        return
    rollers = [_roller(support) for support in rig.supports[:count]]
    over = [*from_yarder(rig, "mainline", "mainline"), *rollers, carriage.mainline]
    # The default names are taken by the skyline and the guylines of a guyed spar.
    _string(system, rig.mainline, over, pull, "line" if isinstance(rig.headspar, GuyedSpar) else None)


def _node(one: Node | Seat) -> Node:
    """The node itself, or the node of a seat."""
    node = one.owner if isinstance(one, Seat) else one
    if not isinstance(node, Node):
        raise InputError(f"{node.name!r} is not a support", "Give a node or one of its seats")
    return node


def _string(system: System, rope: Rope, over: Sequence[Any], tension: float, name: str | None = None) -> None:
    """Strings a rope at an approximate tension [N], or at the least tension that its own weight needs."""
    points = np.array([_node(o).at for o in over])
    lengths = carriage_guess.rope_lengths(points, rope.mass_per_length * system.gravity, rope.strain, tension)
    system.string(rope, *over, length=float(lengths.sum()), name=name)


def _roller(support: IntermediateSupport) -> Node:
    """Roller of the mainline at a support: a sheave, or an arc like that of its shoe."""
    if support.radius == 0.0:
        return Sheave(roller_name(support), at=support.at)
    return IntermediateSupport(roller_name(support), at=support.at, radius=support.radius, slope=support.slope)


def roller_name(support: IntermediateSupport) -> str:
    """Name of the mainline's roller at a support."""
    return f"{support.name}_mainline"
