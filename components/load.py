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
    drag_area : float, default 0
        Drag coefficient times area in the wind [m2].

    Raises
    ------
    InputError
        A mass that is not positive, a negative area, or an invalid name.

    Examples
    --------
    >>> rw.Load("turn", mass=400.0).mass
    400.0
    """

    name: str
    mass: float
    drag_area: float = 0.0

    def __post_init__(self) -> None:
        check.name(self.name, "Load")
        check.positive(self.mass, f"Load {self.name!r}", "mass", "kg")
        check.not_negative(self.drag_area, f"Load {self.name!r}", "drag_area", "m2")
