"""A rope: mass, stiffness, strength and stretch."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import TYPE_CHECKING, Protocol, overload

from ropeway.components import check
from ropeway.components.accepted_values import RefusedError
from ropeway.components.annotation_checks import Unbounded
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Strain
from ropeway.components.errors import InputError, UnknownNameError

if TYPE_CHECKING:
    import pandas as pd

MODULUS = 93.1e9
"""Modulus of a 6-strand IWRC rope on its metallic area [Pa] (Lyons 2008, p. 32)."""


HEAVIEST, SOFTEST, WEAKEST, THICKEST = 200.0, 1e5, 1e3, 0.2
"""Limits of plausible ropes: mass per length [kg/m], axial stiffness [N], breaking load [N], diameter [m]."""


class StretchLaw(Protocol):
    """A stretch law: returns the coefficients of eps(T) = c1 T + c2 T^2."""

    def strain(self, axial_stiffness: Unbounded, breaking_load: float) -> Strain:
        """Coefficients for a rope of this axial stiffness [N] and minimum breaking load [N]."""
        ...


@checked
@dataclass(frozen=True, slots=True)
class Elastic:
    """Elastic stretch eps = T/EA: a used rope, without construction stretch left."""

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


@dataclass(frozen=True, slots=True)
class Construction:
    """EN 12385-4 factors of a construction: m = W d^2/100 [kg/m], A = C d^2 [mm2], F = K d^2 R/1000 [kN]."""

    mass: float
    area: float
    strength: float


CONSTRUCTIONS: dict[str, Construction] = {
    "6x19 IWRC": Construction(0.400, 0.449, 0.356),
    "6x36 IWRC": Construction(0.409, 0.460, 0.356),
    "6x19 FC": Construction(0.359, 0.384, 0.330),
    "6x36 FC": Construction(0.367, 0.393, 0.330),
}
"""EN 12385-4 factors W, C, K (d in mm, rope grade in N/mm2)."""


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

    Raises
    ------
    InputError
        A value that no rope has, such as one in kg/km, MN, kN or mm.
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
            raise _implausible(owner, "mass_per_length", self.mass_per_length, "kg/m", "kg/km")
        if self.axial_stiffness < SOFTEST:
            raise _implausible(owner, "axial_stiffness", self.axial_stiffness, "N", "kN or MN")
        if self.breaking_load < WEAKEST:
            raise _implausible(owner, "breaking_load", self.breaking_load, "N", "kN or t")
        if self.diameter is not None:
            _require_diameter(self.diameter, owner)

    @classmethod
    def _from_given(cls, value: object) -> Rope:
        """A rope as users give it: itself, or the name of one in `NAMED`. Raises RefusedError."""
        if isinstance(value, Rope):
            return value
        known = [entry.name for entry in NAMED]
        if isinstance(value, str) and value in known:
            return cls.named(value)
        names = ", ".join(map(repr, known))
        near = get_close_matches(value, known, 1) if isinstance(value, str) else ()
        meant = f"; did you mean {near[0]!r}?" if near else ""
        raise RefusedError(value, f"a Rope, or the name of one: {names}{meant}")

    @property
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
            Such as "6x19 IWRC", "6x36 IWRC", "6x19 FC" or "6x36 FC".
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
        if construction not in CONSTRUCTIONS:
            known = ", ".join(CONSTRUCTIONS)
            raise UnknownNameError(f"No construction {construction!r}", f"Known are {known}")
        owner = f"Rope {construction}"
        _require_diameter(diameter, owner)
        check.positive(grade, owner, "grade", "N/mm2")
        check.positive(modulus, owner, "modulus", "Pa")
        factors, mm = CONSTRUCTIONS[construction], diameter * 1e3
        return cls(
            mass_per_length=factors.mass * mm**2 / 100.0,
            axial_stiffness=modulus * factors.area * diameter**2,
            breaking_load=factors.strength * mm**2 * grade,
            diameter=diameter,
            stretch=Elastic() if stretch is None else stretch,
            safety_factor=safety_factor,
            name=f"{construction} {mm:g} mm {grade:g}",
        )

    @classmethod
    def named(cls, name: str, *, stretch: StretchLaw | None = None, safety_factor: float = 3.0) -> Rope:
        """A rope from the list of named ropes; `rw.ropes()` shows it.

        Parameters
        ----------
        name : str
            Such as "compacted skyline 22".
        stretch : Elastic or ConstructionStretch, optional
            Stretch law; by default elastic.
        safety_factor : float, default 3
            Minimum breaking load over safe working load.

        Returns
        -------
        Rope
            The rope.

        Raises
        ------
        UnknownNameError
            An unknown name.
        """
        entry = next((r for r in NAMED if r.name == name), None)
        if entry is None:
            known = ", ".join(repr(r.name) for r in NAMED)
            raise UnknownNameError(f"No rope {name!r}", f"Known are {known}")
        # The sources give no modulus for single ropes. The metallic area follows from the mass and the density of a
        # 6x19 IWRC construction (rho = 9300 kg/m3 on the metallic area, Lyons 2008, p. 32).
        modulus = 100e9 if entry.source == "SEILAPLAN" else MODULUS
        return cls(
            mass_per_length=entry.mass_per_length,
            axial_stiffness=modulus * entry.mass_per_length / 9300.0,
            breaking_load=entry.breaking_load,
            diameter=entry.diameter,
            stretch=Elastic() if stretch is None else stretch,
            safety_factor=safety_factor,
            name=name,
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


@dataclass(frozen=True, slots=True)
class NamedRope:
    """A named rope, with its source."""

    name: str
    diameter: float
    mass_per_length: float
    breaking_load: float
    source: str


NAMED = (
    NamedRope("compacted skyline 20", 0.020, 1.98, 356e3, "SEILAPLAN"),
    NamedRope("compacted skyline 22", 0.022, 2.37, 424e3, "SEILAPLAN"),
    NamedRope("6x19 EEIP 19", 0.01905, 1.4, 256.3e3, "Lyons 2008"),
    NamedRope("6x19 EEIP 25", 0.0254, 2.4, 450.3e3, "Lyons 2008"),
    NamedRope("RHOL-IWRC 29", 0.0286, 3.48, 576.6e3, "Harvey 2013"),
)
"""Named ropes: diameter [m], mass [kg/m], minimum breaking load [N]."""


@checked
def ropes() -> pd.DataFrame:
    """Table of the named ropes; `Rope.named` makes one.

    Returns
    -------
    DataFrame
        Index name; diameter [m], mass_per_length [kg/m], axial_stiffness [N], breaking_load [N], source.

    Examples
    --------
    >>> rw.ropes().loc["compacted skyline 22", "breaking_load"]
    424000.0
    """
    import pandas as pd

    rows = [
        {
            "name": r.name,
            "diameter": r.diameter,
            "mass_per_length": r.mass_per_length,
            "axial_stiffness": Rope.named(r.name).axial_stiffness,
            "breaking_load": r.breaking_load,
            "source": r.source,
        }
        for r in NAMED
    ]
    return pd.DataFrame(rows).set_index("name")


def hanging_limit(rope: Rope, gravity: float) -> float:
    """Longest rope that can hang vertically without breaking under its own weight [m]."""
    return math.inf if gravity == 0.0 else rope.breaking_load / (rope.mass_per_length * gravity)
