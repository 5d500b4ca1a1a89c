"""A load clamped to the rope."""

from __future__ import annotations

from dataclasses import dataclass

from ropeway.components import check
from ropeway.components.argument_checks import checked


@checked
@dataclass(frozen=True, slots=True)
class Load:
    """A point load clamped to a rope; mass [kg]. It travels with the rope. Raises InputError."""

    name: str
    mass: float

    def __post_init__(self) -> None:
        check.name(self.name, "Load")
        check.positive(self.mass, f"Load {self.name!r}", "mass", "kg")
