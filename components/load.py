"""A load clamped to the rope."""

from __future__ import annotations

from dataclasses import dataclass

from ropeway.components import check
from ropeway.components.argument_checks import checked


@checked
@dataclass(frozen=True, slots=True)
class Load:
    """A point load clamped to a rope; it travels with the rope.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    mass : float
        Mass [kg].

    Raises
    ------
    InputError
        A mass that is not positive, or an invalid name.

    Examples
    --------
    >>> rw.Load("turn", mass=400.0).mass
    400.0
    """

    name: str
    mass: float

    def __post_init__(self) -> None:
        check.name(self.name, "Load")
        check.positive(self.mass, f"Load {self.name!r}", "mass", "kg")
