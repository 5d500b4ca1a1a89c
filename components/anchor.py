"""Fixed and elastic ends of a rope."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ropeway.components import check, laws
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import norm
from ropeway.components.check import POSITIVE
from ropeway.components.component import Seat
from ropeway.components.node import Node
from ropeway.components.variable import Equations, Kind, Site, Variable


@checked
@dataclass(frozen=True)
class Anchor(Node):
    """A fixed end of a rope.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float
        Position, (x, z) or (x, y, z) [m].
    label : str, optional
        Text in pictures and messages; by default the name.

    Raises
    ------
    InputError
        An invalid name or position.

    Examples
    --------
    >>> rw.Anchor("valley", at=(0.0, 12.0)).at
    (0.0, 0.0, 12.0)
    """

    role: ClassVar[str] = "anchor"

    @property
    def rope(self) -> Seat:
        """Where the rope is fixed."""
        return Seat(self, "rope")

    @property
    def seats(self) -> tuple[Seat, ...]:
        return (self.rope,)

    def structure(self, site: Site) -> Hashable:
        return ()

    def variables(self, site: Site) -> tuple[Variable, ...]:
        return (
            *self.place(),
            Variable("tension", Kind.OUTPUT, "N", "tension of the rope at the anchor", nominal=site.force),
            *(
                Variable(
                    f"pull_{axis}", Kind.OUTPUT, "N", f"pull of the rope on the anchor, {axis}", nominal=site.force
                )
                for axis in "xyz"
            ),
        )

    def equations(self, v: Any) -> Equations:
        pull = v.rope.force
        return Equations(
            outputs={"tension": norm(pull), **{f"pull_{axis}": pull[i] for i, axis in enumerate("xyz")}},
        )


@checked
@dataclass(frozen=True, kw_only=True)
class SpringAnchor(Node):
    """An elastic anchor: the pull of its rope displaces it by pull / stiffness.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float
        Position without pull, (x, z) or (x, y, z) [m].
    label : str, optional
        Text in pictures and messages; by default the name.
    stiffness : float
        The same in all directions [N/m].

    Raises
    ------
    InputError
        An invalid name or position, or a stiffness that is not positive.

    Examples
    --------
    >>> s = rw.System("soft ground")
    >>> stump = rw.SpringAnchor("stump", at=(0.0, 0.0), stiffness=2e6)
    >>> spans = s.string(rope, stump, rw.Anchor("b", at=(100.0, 5.0)), length=100.2)
    >>> print(f"{rw.equilibrium(s)['stump.x']:.4f} m")
    0.0094 m
    """

    stiffness: float

    def __post_init__(self) -> None:
        super().__post_init__()
        check.positive(self.stiffness, self.described, "stiffness", "N/m")

    @property
    def rope(self) -> Seat:
        """Where the rope is fixed."""
        return Seat(self, "rope")

    @property
    def seats(self) -> tuple[Seat, ...]:
        return (self.rope,)

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        return tuple((axis, f"spring_{axis}") for axis in "xyz")

    def structure(self, site: Site) -> Hashable:
        return ()

    def variables(self, site: Site) -> tuple[Variable, ...]:
        par = Kind.PARAMETER
        return (
            Variable("stiffness", par, "N/m", "stiffness of the anchor", self.stiffness, 1e6, range=POSITIVE),
            *(
                Variable(f"rest_{a}", par, "m", f"{a} without pull", at, 100.0)
                for a, at in zip("xyz", self.position, strict=True)
            ),
            *(
                Variable(a, Kind.ALGEBRAIC, "m", f"{a} of the anchor", at, 100.0)
                for a, at in zip("xyz", self.position, strict=True)
            ),
            *(Variable(f"spring_{a}", Kind.RESIDUAL, "N", f"forces, {a}", 0.0, 0.01 * site.force) for a in "xyz"),
            Variable("tension", Kind.OUTPUT, "N", "tension of the rope at the anchor", nominal=site.force),
        )

    def equations(self, v: Any) -> Equations:
        pull = v.rope.force
        place, rest = (v.x, v.y, v.z), (v.rest_x, v.rest_y, v.rest_z)
        return Equations(
            residuals={f"spring_{a}": pull[i] - v.stiffness * (place[i] - rest[i]) for i, a in enumerate("xyz")},
            outputs={"tension": norm(pull)},
        )

    def laws(self, v: Any) -> dict[str, laws.Law]:
        place, rest = np.stack([v.x, v.y, v.z]), np.stack([v.rest_x, v.rest_y, v.rest_z])
        found = laws.balance(v.rope.force, -v.stiffness * (place - rest))
        # A stiff spring amplifies the rounding errors of the coordinates.
        rounding = 1e-7 * v.stiffness * np.abs(rest).max(axis=0)
        return {f"spring_{axis}": laws.Law(law.miss, law.size + rounding) for axis, law in found.items()}
