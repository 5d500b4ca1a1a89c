"""The skyline of a rig without carriage and load, guyed spars held upright."""

from __future__ import annotations

import numpy as np

from ropeway.components.anchor import Anchor
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.span import Span
from ropeway.components.spar import Block
from ropeway.systems.modelling.system import System
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium


def bare_equilibrium(rig: SkylineRig) -> tuple[Equilibrium, tuple[Span, ...]]:
    """It at rest, and its spans between headspar and tailspar. Raises SlackRopeError, EquilibriumError."""
    bare, spans = _strung(rig)
    return equilibrium(bare), spans[: rig.spans]


def bare_tension(rig: SkylineRig) -> float:
    """Its tension at the headspar [N]."""
    found, spans = bare_equilibrium(rig)
    return found[f"{spans[0].name}.tension_a"]


def bare_profile(rig: SkylineRig) -> tuple[np.ndarray, np.ndarray]:
    """Points along it (x, z) between headspar and tailspar, 201 a span [m]."""
    found, spans = bare_equilibrium(rig)
    curves = [found.profile(span.name, 201) for span in spans]
    x, z = (np.concatenate([curve[axis].to_numpy() for curve in curves]) for axis in "xz")
    return x, z


def length_over_shoes(rig: SkylineRig, tension: float) -> float:
    """Its unstretched length [m] for a tension at the headspar [N], from the rig's length that is near it. Raises
    EquilibriumError."""
    bare, spans = _strung(rig)
    freed = f"{spans[-1].name}.length_start"
    found = equilibrium(bare, given={f"{spans[0].name}.tension_a": tension}, solve_for=freed)
    return float(sum(found[f"{span.name}.length_start"] for span in spans))


def _strung(rig: SkylineRig) -> tuple[System, tuple[Span, ...]]:
    bare = System(rig.name, gravity=rig.gravity, terrain=rig.terrain)
    first, *between, last = rig.ends
    over = [node if isinstance(node, IntermediateSupport) else Block(node.name, at=node.at) for node in between]
    anchors = [Anchor(node.name, at=node.at) for node in (first, last)]
    return bare, bare.string(rig.skyline, anchors[0], *over, anchors[1], length=rig.length)
