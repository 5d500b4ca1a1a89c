"""Guylines of a spar, strung with their pretension."""

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
    """String all guylines of a spar, from their anchors `GUYLINE` to its top.

    Their lengths give the pretension while the spar is upright. The released spar then moves to its equilibrium.

    Parameters
    ----------
    system : System
        System to which the guylines are added.
    spar : GuyedSpar
        The spar. Its guylines have unique names.

    Returns
    -------
    tuple of Span
        One span per guyline, in order.

    Raises
    ------
    SlackRopeError
        A pretension is too low for a guyline's own weight.
    EquilibriumError
        A guyline has no equilibrium on its elastic anchor.

    Examples
    --------
    >>> rope = rw.Rope.named("6x19 EEIP 19")
    >>> guys = [rw.Guyline(f"g{i}", rope, at, 20e3) for i, at in enumerate([(-20, 15, 0), (-20, -15, 0), (20, 0, 0)])]
    >>> mast = rw.GuyedSpar("mast", foot=(0, 0, 0), height=15.0, guylines=guys)
    >>> spans = rw.string_guylines(rw.System("guyed mast"), mast)
    >>> [span.name for span in spans]
    ['g0_mast', 'g1_mast', 'g2_mast']
    """
    spans: list[Span] = []
    for guy in spar.guylines:
        length = pretensioned(guy, spar.at, system.gravity)
        spans += system.string(guy.rope, anchor(guy), spar.guy(guy.name), length=length)
    return tuple(spans)


def anchor(guy: Guyline) -> Node:
    """A guyline's anchor, named after it."""
    if guy.stiffness == float("inf"):
        return Anchor(guy.name, at=guy.at)
    return SpringAnchor(guy.name, at=guy.at, stiffness=guy.stiffness)


@lru_cache(maxsize=256)
def pretensioned(guy: Guyline, top: tuple[float, ...], gravity: float) -> float:
    """Unstretched length [m] that gives a guyline its pretension at the anchor while its top end is held at `top`."""
    alone = System(guy.name, gravity=gravity)
    (span,) = alone.string(guy.rope, anchor(guy), Anchor("top", at=top), tension=guy.pretension)
    if guy.stiffness == float("inf"):
        return span.length
    eq = equilibrium(alone, given={f"{span.name}.tension_a": guy.pretension}, solve_for=f"{span.name}.length")
    return eq[f"{span.name}.length"]
