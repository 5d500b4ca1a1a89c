"""A fixed end of a rope."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

from ropeway.components.catenary import norm
from ropeway.components.checked import checked
from ropeway.components.component import Equations, Kind, Node, Seat, Site, Variable


@checked
@dataclass(frozen=True)
class Anchor(Node):
    """Holds the end of a rope at a point: no travel."""

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
