"""The parts of a skyline rig and their positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.carriage import Carriage
from ropeway.components.environment import Environment
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.node import Node
from ropeway.components.rope import Rope
from ropeway.components.spar import Block, HeadSpar, TailSpar
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.system import GRAVITY, STRUNG, System
from ropeway.systems.rigs.turn import Turn


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class RigParts:
    """The parts of a skyline rig.

    Parameters
    ----------
    terrain : Profile or None
    headspar : HeadSpar
    tailspar : TailSpar or GuyedSpar
    skyline : Rope
        Rope that supports the carriage; in a running skyline the haulback.
    carriage : Carriage
    name : str
    supports : sequence of IntermediateSupport, default ()
    length : float, optional
        Unstretched length of the skyline from the headspar to its end [m].
    tension : float, optional
        Tension of the bare skyline at the headspar; for a running skyline, at the haulback's drum [N].
    mainline, haulback : Rope, optional
    haulback_tension : float, optional
        Tension at the haulback's drum [N].
    haulback_block : Block, optional
    turn : Turn, optional
    gravity : float, default 9.80665
        Gravitational acceleration [m/s2].
    temperature : float, default 15
        Temperature at which its ropes are strung [degrees C].
    environment : Environment, optional
        Weather; by default none.
    """

    terrain: Profile | None
    headspar: HeadSpar
    supports: tuple[IntermediateSupport, ...] = ()
    tailspar: TailSpar | GuyedSpar
    skyline: Rope
    length: float | None = None
    tension: float | None = None
    mainline: Rope | None = None
    haulback: Rope | None = None
    haulback_tension: float | None = None
    haulback_block: Block | None = None
    carriage: Carriage
    turn: Turn | None = None
    name: str
    gravity: float = GRAVITY
    temperature: float = STRUNG
    environment: Environment | None = None

    def empty_system(self) -> System:
        """A system of its own, without components."""
        system = System(self.name, gravity=self.gravity, terrain=self.terrain, temperature=self.temperature)
        system.environment = self.environment
        return system

    @property
    def stands(self) -> tuple[Node, ...]:
        """The ends of the spans: headspar, intermediate supports, tailspar."""
        return (self.headspar, *self.supports, self.tailspar)

    @property
    def ends(self) -> tuple[Node, ...]:
        """Nodes of the skyline: headspar, supports, tailspar, and the tailhold behind it."""
        hold = self.tailspar.tailhold
        return (*self.stands, *(() if hold is None else (hold,)))

    @property
    def points(self) -> np.ndarray:
        """Points of these nodes, shape (n, 3) [m]."""
        return np.array([node.at for node in self.ends])

    @property
    def spans(self) -> int:
        """Number of spans on which the carriage runs."""
        return len(self.supports) + 1

    @property
    def ideal(self) -> bool:
        """Whether an ideal force holds the carriage."""
        return self.mainline is None and not self.carriage.clamped

    @property
    def pulled(self) -> bool:
        """Whether a real mainline pulls the carriage."""
        return self.mainline is not None and not self.carriage.clamped

    @property
    def guyed_spars(self) -> tuple[GuyedSpar, ...]:
        """The guyed ones of the two spars."""
        return tuple(spar for spar in (self.headspar, self.tailspar) if isinstance(spar, GuyedSpar))
