"""What a skyline ends at or runs over: headspar, tailspar, intermediate support, tailhold, block.

Each is placed either by position, `at`, or on a terrain by `station` and `height` over the ground; `placed`
gives the one that stands on a terrain.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from ropeway.components import check
from ropeway.components.anchor import Anchor
from ropeway.components.argument_checks import checked
from ropeway.components.component import Limit, Node
from ropeway.components.errors import InputError
from ropeway.components.sheave import Sheave
from ropeway.components.terrain import Profile


@checked
@dataclass(frozen=True, kw_only=True)
class Standing(Node):
    """A support at a point `at`, or at a `station` [m] of a terrain and a `height` [m] above the ground there.

    capacity: largest resultant of the ropes that it can carry [N], if it is known. Raises InputError.
    """

    at: tuple[float, ...] = ()
    station: float | None = None
    height: float | None = None
    capacity: float | None = None

    def __post_init__(self) -> None:
        if self.capacity is not None:
            check.positive(self.capacity, self.described, "capacity", "N")
        if self.at:
            super().__post_init__()
            if (self.station is None) != (self.height is None):
                raise InputError(f"{self.described} has one of station and height", "Give at=, or station and height")
            return
        check.name(self.name, type(self).__name__)
        if self.station is None or self.height is None:
            raise InputError(f"{self.described} has no place", "Give at=(x, z), or station and height above the ground")
        check.number(self.station, self.described, "station", "m")
        check.number(self.height, self.described, "height", "m")
        if self.height < 0.0:
            raise InputError(
                f"{self.described} stands {-self.height:g} m below the ground", "Give a height above the ground"
            )

    def placed(self, ground: Profile | None) -> Self:
        """The same at its point on a terrain. Raises InputError where that cannot be."""
        if self.station is None or self.height is None:
            self.require_above(ground)
            return self
        if ground is None:
            raise InputError(
                f"{self.described} is placed by station and height", "Give a terrain, or place it with at="
            )
        elevation = ground.elevation_at(self.station)
        return replace(self, at=(self.station, 0.0, elevation + self.height))

    def require_above(self, ground: Profile | None) -> None:
        """Raises InputError where its point lies below a terrain."""
        if ground is not None and self.at[2] < ground.elevation_at(self.at[0]):
            raise InputError(
                f"{self.described} at z = {self.at[2]:g} m lies below the ground, "
                f"{ground.elevation_at(self.at[0]):g} m at station {self.at[0]:g} m",
                "Raise it, or place it by station and height",
            )


@checked
@dataclass(frozen=True, kw_only=True)
class HeadSpar(Standing, Anchor):
    """The yarder's spar: the skyline ends at its top."""

    def limits(self) -> tuple[Limit, ...]:
        return _capacity(self, "tension")


@checked
@dataclass(frozen=True, kw_only=True)
class Tailhold(Standing, Anchor):
    """A stump or other anchor at the ground that holds the end of a rope."""

    def limits(self) -> tuple[Limit, ...]:
        return _capacity(self, "tension")


@checked
@dataclass(frozen=True, kw_only=True)
class TailSpar(Standing, Anchor):
    """A tail tree or mast: the skyline ends at its top, or, with a `tailhold`, runs there through a block and
    on to the tailhold, which may stand off the corridor's line."""

    tailhold: Tailhold | None = None

    def limits(self) -> tuple[Limit, ...]:
        return _capacity(self, "tension")


@checked
@dataclass(frozen=True, kw_only=True)
class Block(Standing, Sheave):
    """A block that a rope runs through; `friction` of its bearing as for a sheave. The rope may pull at it in
    any direction."""

    hold_down: bool = True

    def limits(self) -> tuple[Limit, ...]:
        return _capacity(self, "bearing_load")


def _capacity(component: Standing, output: str) -> tuple[Limit, ...]:
    return () if component.capacity is None else (Limit(output, "above capacity", high=component.capacity),)
