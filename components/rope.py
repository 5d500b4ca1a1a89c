"""A rope: mass, stiffness, strength and stretch."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from typing import Protocol, overload

from ropeway.components import check, table
from ropeway.components.accepted_values import RefusedError
from ropeway.components.annotation_checks import Unbounded
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Strain
from ropeway.components.errors import InputError, UnknownNameError
from ropeway.components.rope_catalogue import MODULUS, CatalogueRope, all_ropes, by_factors, constructions

HEAVIEST, SOFTEST, WEAKEST, THICKEST = 200.0, 1e5, 1e3, 0.2
"""Limits of plausible ropes: mass per length [kg/m], axial stiffness [N], breaking load [N], diameter [m]."""
LONGEST = 1e-4
"""Limit of the thermal expansion of plausible ropes [1/K]."""


class StretchLaw(Protocol):
    """A stretch law: returns the coefficients of eps(T) = c1 T + c2 T^2."""

    def strain(self, axial_stiffness: Unbounded, breaking_load: float) -> Strain:
        """Coefficients for a rope of this axial stiffness [N] and minimum breaking load [N]."""
        ...


@checked
@dataclass(frozen=True, slots=True)
class Elastic:
    """Elastic stretch eps = T/EA: a used rope, without construction stretch left.

    Examples
    --------
    >>> rw.Rope(3.48, 34.8e6, 576.6e3).stretch
    Elastic()
    """

    def strain(self, axial_stiffness: Unbounded, breaking_load: float) -> Strain:
        """Coefficients of the strain of a rope.

        Parameters
        ----------
        axial_stiffness : float
            EA [N]; inf: inextensible.
        breaking_load : float
            Minimum breaking load [N].

        Returns
        -------
        Strain
            c1 and c2 of eps(T) = c1 T + c2 T^2.
        """
        return Strain(1.0 / axial_stiffness, 0.0)


@checked
@dataclass(frozen=True, slots=True)
class ConstructionStretch:
    """Elastic and construction stretch, eps = T/EA + coefficient * (T/MBL)^2: a new rope under its first load.

    After Lyons 2008, eq. 14. The default is his fit for a heavily loaded 6-strand IWRC rope at MBL/T = 2 to 8; it is
    34-48 % low at MBL/T = 5 to 8. Construction stretch is permanent: T is the highest tension of the rope's life.

    Parameters
    ----------
    coefficient : float, default 0.0414
        Strain at a tension equal to the minimum breaking load.

    Raises
    ------
    InputError
        A negative coefficient.

    Examples
    --------
    >>> rw.Rope(3.48, 34.8e6, 576.6e3, stretch=rw.ConstructionStretch(0.0414)).stretch.coefficient
    0.0414
    """

    coefficient: float = 0.0414

    def __post_init__(self) -> None:
        check.not_negative(self.coefficient, "ConstructionStretch", "coefficient")

    def strain(self, axial_stiffness: Unbounded, breaking_load: float) -> Strain:
        """Coefficients of the strain of a rope.

        Parameters
        ----------
        axial_stiffness : float
            EA [N]; inf: inextensible.
        breaking_load : float
            Minimum breaking load [N].

        Returns
        -------
        Strain
            c1 and c2 of eps(T) = c1 T + c2 T^2.
        """
        return Strain(1.0 / axial_stiffness, self.coefficient / breaking_load**2)


@checked
@dataclass(frozen=True)
class Rope:
    """A rope, by its values.

    Parameters
    ----------
    mass_per_length : float
        Mass per unstretched length [kg/m].
    axial_stiffness : float
        EA [N]; inf: inextensible.
    breaking_load : float
        Minimum breaking load MBL [N].
    diameter : float, optional
        Diameter [m].
    stretch : Elastic or ConstructionStretch, optional
        Stretch law; by default elastic.
    safety_factor : float, default 3
        Minimum breaking load over safe working load.
    name : str, default "rope"
        Name in messages.
    thermal_expansion : float, default 11.5e-6
        Thermal expansion of steel rope [1/K].
    drag_coefficient : float, default 1.1
        Drag coefficient of the rope in the wind, for its diameter with ice.

    Raises
    ------
    InputError
        A value that no rope has, such as one in kg/km, MN, kN or mm.

    Examples
    --------
    >>> rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
    >>> print(f"{rope.safe_working_load / 1e3:.1f} kN")
    192.2 kN
    """

    mass_per_length: float
    axial_stiffness: Unbounded
    breaking_load: float
    diameter: float | None = None
    stretch: StretchLaw = field(default_factory=Elastic)
    safety_factor: float = 3.0
    name: str = "rope"
    thermal_expansion: float = field(default=11.5e-6, kw_only=True)
    drag_coefficient: float = field(default=1.1, kw_only=True)

    def __post_init__(self) -> None:
        owner = f"Rope {self.name!r}"
        check.positive(self.mass_per_length, owner, "mass_per_length", "kg/m")
        check.positive(self.axial_stiffness, owner, "axial_stiffness", "N", infinite=True)
        check.positive(self.breaking_load, owner, "breaking_load", "N")
        check.positive(self.safety_factor, owner, "safety_factor")
        check.not_negative(self.thermal_expansion, owner, "thermal_expansion", "1/K")
        check.not_negative(self.drag_coefficient, owner, "drag_coefficient")
        if self.thermal_expansion > LONGEST:
            raise _implausible(owner, "thermal_expansion", self.thermal_expansion, "1/K", "1e-6/K")
        if self.mass_per_length > HEAVIEST:
            raise _implausible(owner, "mass_per_length", self.mass_per_length, "kg/m", "kg/km")
        if self.axial_stiffness < SOFTEST:
            raise _implausible(owner, "axial_stiffness", self.axial_stiffness, "N", "kN or MN")
        if self.breaking_load < WEAKEST:
            raise _implausible(owner, "breaking_load", self.breaking_load, "N", "kN or t")
        if self.diameter is not None:
            _require_diameter(self.diameter, owner)

    @classmethod
    def _from_given(cls, value: object) -> Rope:
        """A rope as users give it: itself, or the name of one in the catalogue. Raises RefusedError."""
        if isinstance(value, Rope):
            return value
        known = all_ropes()
        if isinstance(value, str) and value in known:
            return cls.named(value)
        near = get_close_matches(value, known, 3) if isinstance(value, str) else ()
        meant = f"; did you mean {', '.join(map(repr, near))}?" if near else ""
        raise RefusedError(value, f"a Rope, or the name of one of rw.ropes(){meant}")

    @cached_property
    def strain(self) -> Strain:
        """Coefficients of the rope's strain over tension."""
        return self.stretch.strain(self.axial_stiffness, self.breaking_load)

    @property
    def safe_working_load(self) -> float:
        """Safe working load SWL [N]."""
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
        """A rope by the factors of EN 12385-4.

        Parameters
        ----------
        construction : str
            Of the catalogue, such as "6x19 IWRC" (`docs/catalogue.md`).
        diameter : float
            Nominal diameter [m].
        grade : float, default 1960
            Rope grade [N/mm2]: 1770, 1960 (EIPS) or 2160 (EEIPS).
        modulus : float, default 93.1e9
            Modulus of elasticity on the metallic area [Pa].
        stretch : Elastic or ConstructionStretch, optional
            Stretch law; by default elastic.
        safety_factor : float, default 3
            Minimum breaking load over safe working load.

        Returns
        -------
        Rope
            The rope, named after its construction.

        Raises
        ------
        InputError
            A value that no rope has.
        UnknownNameError
            An unknown construction.
        """
        known = constructions()
        if construction not in known:
            raise UnknownNameError(f"No construction {construction!r}", f"Known are {', '.join(known)}")
        owner = f"Rope {construction}"
        _require_diameter(diameter, owner)
        check.positive(grade, owner, "grade", "N/mm2")
        check.positive(modulus, owner, "modulus", "Pa")
        name = f"{construction} {diameter * 1e3:g} mm {grade:g}"
        return cls._of(by_factors(name, known[construction], diameter, grade, modulus), stretch, safety_factor)

    @classmethod
    def named(
        cls,
        name: str,
        *,
        stretch: StretchLaw | None = None,
        safety_factor: float = 3.0,
        catalogue: table.Source | None = None,
    ) -> Rope:
        """A rope of the catalogue by its name; `rw.ropes()` shows it.

        Parameters
        ----------
        name : str
            Such as "compacted skyline 22" or "6x19 IWRC 22 1960".
        stretch : Elastic or ConstructionStretch, optional
            Stretch law; by default elastic.
        safety_factor : float, default 3
            Minimum breaking load over safe working load.
        catalogue : str, Path or DataFrame, optional
            A table of yours (CSV, Excel, TOML), which is looked up first.

        Returns
        -------
        Rope
            The rope.

        Raises
        ------
        UnknownNameError
            An unknown name.
        InputError
            The table cannot be read.
        """
        known = all_ropes(() if catalogue is None else (catalogue,))
        if name not in known:
            near = get_close_matches(name, known, n=4, cutoff=0.5) or list(known)[:6]
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
            **entry.weather,
        )


@overload
def rope_of(rope: Rope | str) -> Rope: ...


@overload
def rope_of(rope: Rope | str | None) -> Rope | None: ...


def rope_of(rope: Rope | str | None) -> Rope | None:
    """The rope that an argument stands for. Raises RefusedError."""
    return None if rope is None else Rope._from_given(rope)


def _require_diameter(diameter: float, owner: str) -> None:
    check.positive(diameter, owner, "diameter", "m")
    if diameter > THICKEST:
        raise _implausible(owner, "diameter", diameter, "m", "mm")


def _implausible(owner: str, field: str, value: float, unit: str, meant: str) -> InputError:
    """An error for an implausible value."""
    return InputError(f"{owner}: {field} is {value} {unit}, which no rope has", f"Give {unit}. Is it in {meant}?")


def hanging_limit(rope: Rope, gravity: float) -> float:
    """Longest rope that can hang vertically without breaking under its own weight [m]."""
    return math.inf if gravity == 0.0 else rope.breaking_load / (rope.mass_per_length * gravity)
