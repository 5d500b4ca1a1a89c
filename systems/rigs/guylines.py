"""Guylines strung to a spar with their pretension."""

from __future__ import annotations

from functools import lru_cache

from ropeway.components.anchor import Anchor, SpringAnchor
from ropeway.components.argument_checks import checked
from ropeway.components.guyed_spar import GuyedSpar, Guyline
from ropeway.components.node import Node
from ropeway.components.span import Span
from ropeway.systems.modelling.system import System
from ropeway.systems.statics.equilibrium_solver import equilibrium


@checked
def string_guylines(system: System, spar: GuyedSpar) -> tuple[Span, ...]:
    """Strings all guylines of a spar, from their anchors `GUYLINE` to its top, with the lengths that give their
    pretension while the spar stands upright; released, the spar finds its own place. Raises SlackRopeError,
    EquilibriumError."""
    found: list[Span] = []
    for guy in spar.guylines:
        length = pretensioned(guy, spar.at, system.gravity)
        found += system.string(guy.rope, anchor(guy), spar.guy(guy.name), length=length)
    return tuple(found)


def anchor(guy: Guyline) -> Node:
    """A guyline's anchor, named after it."""
    if guy.stiffness == float("inf"):
        return Anchor(guy.name, at=guy.at)
    return SpringAnchor(guy.name, at=guy.at, stiffness=guy.stiffness)


@lru_cache(maxsize=256)
def pretensioned(guy: Guyline, top: tuple[float, ...], gravity: float) -> float:
    """Unstretched length [m] with which a guyline has its pretension at the anchor, its top end held at `top`."""
    alone = System(guy.name, gravity=gravity)
    (span,) = alone.string(guy.rope, anchor(guy), Anchor("top", at=top), tension=guy.pretension)
    if guy.stiffness == float("inf"):
        return span.length
    eq = equilibrium(alone, given={f"{span.name}.tension_a": guy.pretension}, solve_for=f"{span.name}.length")
    return eq[f"{span.name}.length"]
