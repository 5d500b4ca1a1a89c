"""Ends and supports of a skyline: headspar, tailspar, tailhold, block.

Each has a position `at`, or a `station` and a `height` on a terrain; `placed` returns the one with its position.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from ropeway.components import check
from ropeway.components.anchor import Anchor
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.node import Node
from ropeway.components.sheave import Sheave
from ropeway.components.terrain import Profile
from ropeway.components.variable import Limit


@checked
@dataclass(frozen=True, kw_only=True)
class Standing(Node):
    """A support at a position, or at a station and a height on a terrain.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float, optional
        Position, (x, z) or (x, y, z) [m]; or give station and height.
    station : float, optional
        Station on a terrain [m].
    height : float, optional
        Height above the ground [m].
    label : str, optional
        Text in pictures and messages; by default the name.
    capacity : float, optional
        Largest resultant of the ropes that it can carry [N].

    Raises
    ------
    InputError
        No position, or an invalid value.
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
                raise InputError(
                    f"{self.described} has only one of station and height", "Give at=, or station and height"
                )
            return
        check.name(self.name, type(self).__name__)
        if self.station is None or self.height is None:
            raise InputError(
                f"{self.described} has no position", "Give at=(x, z), or station and height above the ground"
            )
        check.number(self.station, self.described, "station", "m")
        check.number(self.height, self.described, "height", "m")
        if self.height < 0.0:
            raise InputError(
                f"{self.described} stands {-self.height:g} m below the ground", "Give a height above the ground"
            )

    def placed(self, ground: Profile | None) -> Self:
        """The same with its position on a terrain. Raises InputError."""
        if self.station is None or self.height is None:
            self.require_above(ground)
            return self
        if ground is None:
            raise InputError(
                f"{self.described} is placed by station and height", "Give a terrain, or place it with at="
            )
        at = (self.station, 0.0, ground.elevation_at(self.station) + self.height)
        return self if self.at == at else replace(self, at=at)

    def require_above(self, ground: Profile | None) -> None:
        """Raises InputError if its position is below a terrain."""
        if ground is not None and self.at[2] < ground.elevation_at(self.at[0]):
            raise InputError(
                f"{self.described} at z = {self.at[2]:g} m lies below the ground, "
                f"{ground.elevation_at(self.at[0]):g} m at station {self.at[0]:g} m",
                "Raise it, or place it by station and height",
            )


@checked
@dataclass(frozen=True, kw_only=True)
class HeadSpar(Standing, Anchor):
    """The yarder's spar: the skyline ends at its top.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float, optional
        Position, (x, z) or (x, y, z) [m]; or give station and height.
    label : str, optional
        Text in pictures and messages; by default the name.
    station : float, optional
        Station on a terrain [m].
    height : float, optional
        Height above the ground [m].
    capacity : float, optional
        Largest resultant of the ropes that it can carry [N].

    Raises
    ------
    InputError
        No position, or an invalid value.

    Examples
    --------
    >>> rw.HeadSpar("head", station=0.0, height=15.0).height
    15.0
    """

    def limits(self) -> tuple[Limit, ...]:
        return _capacity(self, "tension")


@checked
@dataclass(frozen=True, kw_only=True)
class Tailhold(Standing, Anchor):
    """A stump or other anchor at the ground that holds the end of a rope.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float, optional
        Position, (x, z) or (x, y, z) [m]; or give station and height.
    label : str, optional
        Text in pictures and messages; by default the name.
    station : float, optional
        Station on a terrain [m].
    height : float, optional
        Height above the ground [m].
    capacity : float, optional
        Largest resultant of the ropes that it can carry [N].

    Raises
    ------
    InputError
        No position, or an invalid value.

    Examples
    --------
    >>> rw.Tailhold("stump", at=(320.0, -24.0)).at
    (320.0, 0.0, -24.0)
    """

    def limits(self) -> tuple[Limit, ...]:
        return _capacity(self, "tension")


@checked
@dataclass(frozen=True, kw_only=True)
class TailSpar(Standing, Anchor):
    """A tail tree or mast: the skyline ends at its top, or runs through a block there on to a tailhold.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float, optional
        Position, (x, z) or (x, y, z) [m]; or give station and height.
    label : str, optional
        Text in pictures and messages; by default the name.
    station : float, optional
        Station on a terrain [m].
    height : float, optional
        Height above the ground [m].
    capacity : float, optional
        Largest resultant of the ropes that it can carry [N].
    tailhold : Tailhold, optional
        Where the skyline ends behind the tailspar; it may stand off the line of the corridor.

    Raises
    ------
    InputError
        No position, or an invalid value.

    Examples
    --------
    >>> stump = rw.Tailhold("stump", station=308.0, height=0.0)
    >>> rw.TailSpar("tail", station=300.0, height=8.0, tailhold=stump).tailhold.name
    'stump'
    """

    tailhold: Tailhold | None = None

    def limits(self) -> tuple[Limit, ...]:
        return _capacity(self, "tension")


@checked
@dataclass(frozen=True, kw_only=True)
class Block(Standing, Sheave):
    """A block that a rope runs through; the rope may pull at it in any direction.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    friction : float, default 0
        Bearing friction referred to the rope, as of a `Sheave`.
    inertia : float, default 0
        As of a `Sheave`; a block does not use it: its rope stays in balance.
    at : tuple of float, optional
        Position, (x, z) or (x, y, z) [m]; or give station and height.
    label : str, optional
        Text in pictures and messages; by default the name.
    hold_down : bool, default True
        False: lift-off is reported where the block pulls the rope down.
    station : float, optional
        Station on a terrain [m].
    height : float, optional
        Height above the ground [m].
    capacity : float, optional
        Largest resultant of the ropes that it can carry [N].

    Raises
    ------
    InputError
        No position, or an invalid value.

    Examples
    --------
    >>> rw.Block("corner", at=(10.0, 3.0), friction=0.02).friction
    0.02
    """

    hold_down: bool = True

    def limits(self) -> tuple[Limit, ...]:
        return _capacity(self, "bearing_load")


def _capacity(component: Standing, output: str) -> tuple[Limit, ...]:
    return () if component.capacity is None else (Limit(output, "above capacity", high=component.capacity),)
