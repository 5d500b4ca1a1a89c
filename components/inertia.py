"""What a simulation with inertia takes into account."""

from __future__ import annotations

from dataclasses import dataclass

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError


@checked
@dataclass(frozen=True)
class Inertia:
    """Inertia of loads, ropes and wheels in a simulation.

    Between its loads and rope nodes a rope keeps the shape of a static catenary; its mass acts at its loads, nodes and
    supports. At rest this is the quasi-static line.

    Parameters
    ----------
    nodes : int, default 0
        Rope nodes in each span, spread evenly over its load-free pieces. They resolve waves along a rope; a loaded line
        needs none. Only for ropes that do not run over supports.
    damping : float, default 5e-4
        Stiffness-proportional damping of the rope [s]: its tension follows the shape that the line has this time later.
    zone : float, default 0.5
        Distance from a support within which a load moves with the rope instead of freely [m].

    Raises
    ------
    InputError
        A negative value, a zone of zero, or a value that is not a number.

    Examples
    --------
    >>> rw.Inertia(nodes=6).damping
    0.0005
    """

    nodes: int = 0
    damping: float = 5e-4
    zone: float = 0.5

    def __post_init__(self) -> None:
        if isinstance(self.nodes, bool) or self.nodes < 0 or self.nodes > 200:
            raise InputError(f"Inertia: nodes is {self.nodes}", "Give a number of rope nodes from 0 to 200")
        check.not_negative(self.damping, "Inertia", "damping", "s")
        check.positive(self.zone, "Inertia", "zone", "m")
