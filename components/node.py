"""A node: a component with a position, where ropes sit."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.component import Component, Port, Seat
from ropeway.components.errors import InputError
from ropeway.components.variable import Kind, MovingMass, Variable


@checked
@dataclass(frozen=True)
class Node(Component):
    """A component with a position, where ropes sit.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float
        Position, (x, z) or (x, y, z) [m].
    label : str, optional
        Text in pictures and messages; by default the name.

    Examples
    --------
    >>> rw.Anchor("a", at=(3.0, 5.0)).position
    (3.0, 0.0, 5.0)
    """

    interchangeable: ClassVar[bool] = False
    """Whether a rope can take any open seat."""
    role: ClassVar[str] = "other support"
    """Name in pictures; supports of one role have the same marker."""
    hangs: ClassVar[bool] = False
    """Whether only ropes hold it: it is then no support."""

    at: tuple[float, ...]
    label: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "label", self.label or self.name)
        object.__setattr__(self, "at", check.point(self.at, self.described))

    @property
    def described(self) -> str:
        """Class and label, for error messages."""
        return f"{type(self).__name__} {self.label or self.name!r}"

    @property
    def position(self) -> tuple[float, float, float]:
        """(x, y, z) [m]. Raises InputError for a support that no terrain has given its position yet."""
        if not self.at:
            raise InputError(f"{self.described} has no position", "Give at=, or place it on a terrain by a rig")
        x, y, z = self.at
        return x, y, z

    @property
    def arriving(self) -> Seat:
        """The seat where a rope arrives."""
        return self.seats[0]

    @property
    def leaving(self) -> Seat:
        """The seat where a rope leaves."""
        return self.seats[-1]

    @property
    @abstractmethod
    def seats(self) -> tuple[Seat, ...]:
        """The seats, in the order in which the rope runs."""

    @property
    def ports(self) -> tuple[Port, ...]:
        """The seats."""
        return self.seats

    @property
    def drive_speed(self) -> str | None:
        """Variable with the commanded or driven rope speed; None if the node does not drive the rope."""
        return None

    @property
    def drive_power(self) -> str | None:
        """Output with the drive's power into the rope [W]; None if it drives no rope."""
        return None

    def through(self, seat: Seat) -> Seat | None:
        """The seat where the rope that arrives at a seat leaves.

        Parameters
        ----------
        seat : Seat
            Where the rope arrives.

        Returns
        -------
        Seat or None
            None where the rope ends.
        """
        return None

    @property
    def set_tension(self) -> float | None:
        """Constant tension that the node holds by paying out or winding in [N]; None otherwise."""
        return None

    @property
    def balance(self) -> str | None:
        """Name of the residual that determines the node's travel, where that is an algebraic variable."""
        return None

    def balance_at(self, seat: Seat) -> str | None:
        """Residual that determines the travel at a seat, where several ropes run over the node.

        Parameters
        ----------
        seat : Seat
            Where the rope sits.

        Returns
        -------
        str or None
            Name of the residual.
        """
        return self.balance

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        """Algebraic variables of a position that ropes determine, each with the residual of the forces along it."""
        return ()

    def masses(self, read: Callable[[str], Any]) -> tuple[MovingMass, ...]:
        """Masses that move with variables of the node. Ropes and loads have theirs already.

        Parameters
        ----------
        read : callable
            `read(name)` returns a variable or an output of the node.

        Returns
        -------
        tuple of MovingMass
            By default none.
        """
        return ()

    def place(self) -> tuple[Variable, ...]:
        """Parameters of the position.

        Returns
        -------
        tuple of Variable
            x, y and z.
        """
        return tuple(
            Variable(axis, Kind.PARAMETER, "m", f"{axis} coordinate of the support", value, 100.0)
            for axis, value in zip("xyz", self.position, strict=True)
        )
