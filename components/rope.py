"""A rope: weight, stiffness, strength, and how it stretches."""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass, field
from typing import Protocol

from ropeway.components import check, table
from ropeway.components.annotation_checks import Unbounded
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Strain
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.rope_catalogue import MODULUS, CatalogueRope, all_ropes, by_factors, constructions

HEAVIEST, SOFTEST, WEAKEST, THICKEST = 200.0, 1e5, 1e3, 0.2
"""What no rope goes beyond: mass per length [kg/m], axial stiffness [N], breaking load [N], diameter [m]."""


class StretchLaw(Protocol):
    """A stretch law as a value: gives the coefficients of eps(T) = c1 T + c2 T^2."""

    def strain(self, axial_stiffness: Unbounded, breaking_load: float) -> Strain:
        """Coefficients for a rope of this axial stiffness and minimum breaking load [N]."""
        ...


@checked
@dataclass(frozen=True, slots=True)
class Elastic:
    """eps = T/EA: a used rope, whose construction stretch has been pulled out."""

    def strain(self, axial_stiffness: Unbounded, breaking_load: float) -> Strain:
        return Strain(1.0 / axial_stiffness, 0.0)


@checked
@dataclass(frozen=True, slots=True)
class ConstructionStretch:
    """eps = T/EA + coefficient * (T/MBL)^2: a new rope under its first load (Lyons 2008, eq. 14).

    0.0414 is Lyons' fit for a heavily loaded 6-strand IWRC rope on MBL/T = 2 to 8; it is 34-48 % low at
    MBL/T = 5 to 8. Construction stretch does not come back: T is the highest tension ever seen.
    """

    coefficient: float = 0.0414

    def __post_init__(self) -> None:
        check.not_negative(self.coefficient, "ConstructionStretch", "coefficient")

    def strain(self, axial_stiffness: Unbounded, breaking_load: float) -> Strain:
        return Strain(1.0 / axial_stiffness, self.coefficient / breaking_load**2)


@checked
@dataclass(frozen=True)
class Rope:
    """A rope.

    mass_per_length [kg/m, unstretched]; axial_stiffness EA [N], inf for an inextensible rope; breaking_load:
    minimum breaking load MBL [N]; diameter [m] where known; stretch: Elastic() or ConstructionStretch(c);
    safety_factor: MBL over safe working load. Raises InputError, also for values that no rope has: those of a
    datasheet in kg/km, MN, kN or mm.
    """

    mass_per_length: float
    axial_stiffness: Unbounded
    breaking_load: float
    diameter: float | None = None
    stretch: StretchLaw = field(default_factory=Elastic)
    safety_factor: float = 3.0
    name: str = "rope"

    def __post_init__(self) -> None:
        owner = f"Rope {self.name!r}"
        check.positive(self.mass_per_length, owner, "mass_per_length", "kg/m")
        check.positive(self.axial_stiffness, owner, "axial_stiffness", "N", infinite=True)
        check.positive(self.breaking_load, owner, "breaking_load", "N")
        check.positive(self.safety_factor, owner, "safety_factor")
        if self.mass_per_length > HEAVIEST:
            raise _asking(owner, "mass_per_length", self.mass_per_length, "kg/m", "kg/km")
        if self.axial_stiffness < SOFTEST:
            raise _asking(owner, "axial_stiffness", self.axial_stiffness, "N", "kN or MN")
        if self.breaking_load < WEAKEST:
            raise _asking(owner, "breaking_load", self.breaking_load, "N", "kN or t")
        if self.diameter is not None:
            _require_diameter(self.diameter, owner)

    @property
    def strain(self) -> Strain:
        """Coefficients of the rope's strain over tension."""
        return self.stretch.strain(self.axial_stiffness, self.breaking_load)

    @property
    def safe_working_load(self) -> float:
        """SWL [N]."""
        return self.breaking_load / self.safety_factor

    @classmethod
    def from_construction(
        cls,
        construction: str,
        diameter: float,
        grade: float = 1960.0,
        *,
        modulus: float = MODULUS,
        stretch: StretchLaw | None = None,
        safety_factor: float = 3.0,
    ) -> Rope:
        """From the EN 12385-4 factors.

        construction: of the catalogue, such as "6x19 IWRC" (`docs/catalogue.md`); diameter [m]; grade: rope grade
        [N/mm2], 1770, 1960 (EIPS) or 2160 (EEIPS); modulus on the metallic area [Pa]. Raises InputError,
        UnknownNameError.
        """
        known = constructions()
        if construction not in known:
            raise UnknownNameError(f"No construction {construction!r}", f"Known are {', '.join(known)}")
        owner = f"Rope {construction}"
        _require_diameter(diameter, owner)
        check.positive(grade, owner, "grade", "N/mm2")
        check.positive(modulus, owner, "modulus", "Pa")
        name = f"{construction} {diameter * 1e3:g} mm {grade:g}"
        entry = by_factors(name, known[construction], diameter, grade, modulus)
        return cls._of(entry, stretch, safety_factor)

    @classmethod
    def named(
        cls,
        name: str,
        *,
        stretch: StretchLaw | None = None,
        safety_factor: float = 3.0,
        catalogue: table.Source | None = None,
    ) -> Rope:
        """A rope of the catalogue by its name.

        Parameters
        ----------
        name : str
            `rw.ropes()` lists them.
        stretch : optional
            By default `Elastic()`.
        safety_factor : float, default 3.0
        catalogue : str, Path or DataFrame, optional
            A table of yours (CSV, Excel, TOML), which is looked up first.

        Raises
        ------
        UnknownNameError
            There is no such rope.
        InputError
            The table cannot be read.
        """
        known = all_ropes(() if catalogue is None else (catalogue,))
        if name not in known:
            near = difflib.get_close_matches(name, known, n=4, cutoff=0.5) or list(known)[:6]
            raise UnknownNameError(f"No rope {name!r}", f"Near are {', '.join(map(repr, near))}; rw.ropes() has all")
        return cls._of(known[name], stretch, safety_factor)

    @classmethod
    def _of(cls, entry: CatalogueRope, stretch: StretchLaw | None, safety_factor: float) -> Rope:
        return cls(
            mass_per_length=entry.mass_per_length,
            axial_stiffness=entry.axial_stiffness,
            breaking_load=entry.breaking_load,
            diameter=entry.diameter,
            stretch=Elastic() if stretch is None else stretch,
            safety_factor=safety_factor,
            name=entry.name,
        )


def _require_diameter(diameter: float, owner: str) -> None:
    check.positive(diameter, owner, "diameter", "m")
    if diameter > THICKEST:
        raise _asking(owner, "diameter", diameter, "m", "mm")


def _asking(owner: str, field: str, value: float, unit: str, meant: str) -> InputError:
    """An error for a value that no rope has."""
    return InputError(f"{owner}: {field} is {value} {unit}, which no rope has", f"Give {unit}. Is it in {meant}?")


def hanging_limit(rope: Rope, gravity: float) -> float:
    """Longest rope that can hang straight down without breaking under its own weight [m]."""
    return math.inf if gravity == 0.0 else rope.breaking_load / (rope.mass_per_length * gravity)
