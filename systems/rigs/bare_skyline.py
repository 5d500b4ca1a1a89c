"""The skyline of a rig without its carriage. Guyed spars are held upright."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ropeway.components.anchor import Anchor
from ropeway.components.errors import SlackRopeError
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.span import Span
from ropeway.components.spar import Block
from ropeway.systems.modelling.empty_rope import lengths_for_tension, lengths_for_total
from ropeway.systems.modelling.system import System
from ropeway.systems.rigs.rig_parts import RigParts
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium


def bare_equilibrium(rig: RigParts) -> tuple[Equilibrium, tuple[Span, ...]]:
    """The bare skyline at rest, and its spans between headspar and tailspar. Raises SlackRopeError,
    EquilibriumError."""
    bare, spans = bare_system(rig)
    return equilibrium(bare), spans[: rig.spans]


def bare_tension(rig: RigParts) -> float:
    """Tension of the bare skyline at the headspar as it is strung, in no weather [N]."""
    solution, spans = bare_equilibrium(replace(rig, environment=None))
    return solution[f"{spans[0].name}.tension_a"]


def bare_profile(rig: RigParts) -> np.ndarray:
    """Points along the bare skyline between headspar and tailspar, 201 per span, (3, n) [m]."""
    solution, spans = bare_equilibrium(rig)
    return np.concatenate([solution.profile(span.name, 201)[["x", "y", "z"]].to_numpy() for span in spans]).T


def length_over_shoes(rig: RigParts, tension: float) -> float:
    """Unstretched length [m] for a tension at the headspar as it is strung [N]. The rig's length is the initial guess.
    Raises EquilibriumError."""
    bare, spans = bare_system(replace(rig, environment=None))
    freed = f"{spans[-1].name}.length_start"
    solution = equilibrium(bare, given={f"{spans[0].name}.tension_a": tension}, solve_for=freed)
    return float(sum(solution[f"{span.name}.length_start"] for span in spans))


def tension_over_points(rig: RigParts) -> float:
    """Tension of the bare skyline at the headspar [N], with shoes as points. For a slack rope, the least possible
    tension."""
    if rig.tension is not None:
        return rig.tension
    points, rope = [tuple(p) for p in rig.points], rig.skyline
    weight, names = rope.mass_per_length * rig.gravity, _span_names(len(points) - 1)
    low, high = 0.0, rope.breaking_load
    for _ in range(50):
        middle = 0.5 * (low + high)
        try:
            too_long = lengths_for_tension(points, weight, rope.strain, middle, names).sum() > (rig.length or 0.0)
        except SlackRopeError:
            too_long = True
        low, high = (middle, high) if too_long else (low, middle)
    return high


def lengths_over_points(rig: RigParts, points: Sequence[Sequence[float]] | np.ndarray, length: float) -> np.ndarray:
    """Unstretched lengths [m] between `points` of an unloaded skyline at rest, for a total `length` [m]."""
    weight = rig.skyline.mass_per_length * rig.gravity
    names = _span_names(len(points) - 1)
    return lengths_for_total([tuple(p) for p in points], weight, rig.skyline.strain, length, names)


def _span_names(count: int) -> list[str]:
    return [f"skyline {k + 1}" for k in range(count)]


def bare_system(rig: RigParts) -> tuple[System, tuple[Span, ...]]:
    """The bare skyline over its supports, and its spans."""
    bare = rig.empty_system()
    first, *between, last = rig.ends
    over = [node if isinstance(node, IntermediateSupport) else Block(node.name, at=node.at) for node in between]
    anchors = [Anchor(node.name, at=node.at) for node in (first, last)]
    return bare, bare.string(rig.skyline, anchors[0], *over, anchors[1], length=rig.length)
