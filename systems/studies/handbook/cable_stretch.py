"""Unstretched length of a hanging rope: Lyons' three methods.

Lyons, C.K. (2008): Considering cable stretch in logging applications. International Journal of Forest
Engineering 19(1): 29-35; equation numbers are his, with corrections. The stretched length and the force at support A
are given: the horizontal tension H, and V_A, the upward force of the support on the rope. The weight W = w L0 depends
on the unknown unstretched length, so each method is an implicit equation, which is solved here. Arguments are numbers
or arrays. The dimensionless forms are in `lyons_cases`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ropeway.components import catenary
from ropeway.components.annotation_checks import Positive
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Strain
from ropeway.components.errors import InputError
from ropeway.components.rope import ConstructionStretch, Elastic, Rope, rope_of
from ropeway.systems.modelling.system import GRAVITY
from ropeway.systems.studies.handbook.array_checks import finite, require, require_broadcast
from ropeway.systems.studies.handbook.array_roots import Array, Numbers, complex_step, newton

StretchMethod = Literal["average tension", "elastic", "elastic and construction"]
"""Lyons' methods: eq. 3, eq. 11, eq. 19."""


@checked
@dataclass(frozen=True, eq=False, slots=True)
class UnstretchedLength:
    """An unstretched length with stretch and end forces, as `rw.unstretched_length` returns it.

    `float()` gives the length.

    Parameters
    ----------
    length : array
        Unstretched length [m].
    stretch : array
        Stretched minus unstretched length [m].
    weight : array
        Weight of the rope [N].
    tension_a, tension_b : array
        Tensions at both ends [N].
    vertical_a, vertical_b : array
        Upward forces of the supports on the rope [N].
    method : {"average tension", "elastic", "elastic and construction"}
        Lyons' method.

    Examples
    --------
    >>> rope = rw.Rope.named("6x19 EEIP 25")
    >>> round(float(rw.unstretched_length(rope, length=250.0, horizontal=40e3, vertical=12e3).stretch), 4)
    0.4264
    """

    length: Array
    stretch: Array
    weight: Array
    tension_a: Array
    tension_b: Array
    vertical_a: Array
    vertical_b: Array
    method: StretchMethod

    def __float__(self) -> float:
        return float(self.length)


class StretchFit(NamedTuple):
    """A fitted construction stretch: coefficient of (T/MBL)^2, and R2 about the mean."""

    coefficient: float
    r_squared: float


@checked
def unstretched_length(
    rope: Rope | str,
    *,
    length: Numbers,
    horizontal: Numbers,
    vertical: Numbers,
    method: StretchMethod = "elastic",
    gravity: Positive = GRAVITY,
) -> UnstretchedLength:
    """Find the unstretched length of a rope at rest from its stretched length.

    Parameters
    ----------
    rope : Rope or str
        A rope, or a name from `rw.ropes()`.
    length : float or array
        Stretched length [m].
    horizontal : float or array
        Horizontal tension [N].
    vertical : float or array
        Upward force of support A on the rope [N], negative where the rope leaves A upwards.
    method : {"average tension", "elastic", "elastic and construction"}, default "elastic"
        "average tension" (eq. 3, Kendrick & Sessions 1991): Hooke's law with the mean of the end tensions. It is too
        short by a relative error of at most W/EA times the lesser of 1/4 and W/(12 H); 4.5e-5 in Lyons' cases 1 to 4.
        It omits construction stretch: 0.44 % too long for a new rope at a third of its breaking load. "elastic" (eq.
        11): exact for eps = T/EA. "elastic and construction" (eq. 19): exact for eps = T/EA + k (T/MBL)^2, a new rope
        under its highest tension so far. k is that of the rope's ConstructionStretch, or Lyons' 0.0414 by default.
    gravity : float, default 9.80665
        Gravitational acceleration [m/s2].

    Returns
    -------
    UnstretchedLength
        The length, with weight, stretch and end forces.

    Raises
    ------
    InputError
        A value is out of range, or no unstretched length fits the force.

    Examples
    --------
    >>> rope = rw.Rope.named("6x19 EEIP 25")
    >>> round(float(rw.unstretched_length(rope, length=250.0, horizontal=40e3, vertical=12e3)), 3)
    249.574
    """
    rope = rope_of(rope)
    require_broadcast(length, horizontal, vertical)
    require(length, "length [m]", lambda v: v > 0.0, "above zero")
    h, v = _force(horizontal, vertical)
    total = np.asarray(length, dtype=float)
    weight = rope.mass_per_length * gravity
    strain = strain_law(rope, construction=method == "elastic and construction")
    force = (h, 0.0, -v)  # z up, in the direction from A to B

    def stretched(unstretched: Any) -> Any:
        if method == "average tension":
            ends = np.sqrt(h * h + v * v) + np.sqrt(h * h + (v - weight * unstretched) ** 2)
            return unstretched * (1.0 + strain.c1 * ends / 2.0)
        return catenary.stretched_length(force, weight, unstretched, strain)

    start = total / (1.0 + strain.at(np.hypot(h, v)))
    found = newton(complex_step(lambda unstretched: stretched(unstretched) - total), start)
    if np.isnan(found).any():
        raise InputError(
            "No unstretched length fits this force: the rope is folded, or its strain is implausible",
            "Check the horizontal tension, V_A and the rope's stiffness",
        )
    end = weight * found - v
    return UnstretchedLength(
        found, total - found, weight * found, np.hypot(h, v), np.hypot(h, end), v + np.zeros_like(found), end, method
    )


@checked
def stretched_position(
    rope: Rope | str,
    *,
    stations: Numbers,
    horizontal: Numbers,
    vertical: Numbers,
    method: StretchMethod = "elastic",
    gravity: Positive = GRAVITY,
) -> Array:
    """Find distances along the stretched rope for stations along the unstretched rope.

    Eq. 10, and eq. 18 with construction stretch.

    Parameters
    ----------
    rope : Rope or str
        A rope, or a name from `rw.ropes()`.
    stations : float or array
        Unstretched distances s from support A [m].
    horizontal : float or array
        Horizontal tension [N].
    vertical : float or array
        Upward force of support A on the rope [N].
    method : {"elastic", "elastic and construction"}, default "elastic"
        As for `rw.unstretched_length`.
    gravity : float, default 9.80665
        Gravitational acceleration [m/s2].

    Returns
    -------
    array
        Distances p(s) along the stretched rope [m].

    Raises
    ------
    InputError
        A value is out of range, or the method is "average tension".

    Examples
    --------
    >>> rope = rw.Rope.named("6x19 EEIP 25")
    >>> round(float(rw.stretched_position(rope, stations=100.0, horizontal=40e3, vertical=12e3)), 4)
    100.1725
    """
    rope = rope_of(rope)
    require_broadcast(stations, horizontal, vertical)
    require(stations, "stations [m]", lambda v: v >= 0.0, "zero or more")
    if method == "average tension":
        raise InputError("The average tension does not give positions inside the rope", 'Use "elastic"')
    h, v = _force(horizontal, vertical)
    strain = strain_law(rope, construction=method == "elastic and construction")
    weight = rope.mass_per_length * gravity
    return finite(catenary.stretched_length((h, 0.0, -v), weight, np.asarray(stations, float), strain), "position")


def strain_law(rope: Rope, *, construction: bool) -> Strain:
    """The rope's strain without, or with, its construction stretch (eq. 14; Lyons' 0.0414 if it has none)."""
    law = rope.stretch if construction and not isinstance(rope.stretch, Elastic) else ConstructionStretch()
    return (law if construction else Elastic()).strain(rope.axial_stiffness, rope.breaking_load)


@checked
def fit_construction_stretch(safety_factors: ArrayLike, elongations: ArrayLike) -> StretchFit:
    """Fit eps = coefficient * (T/MBL)^2 by least squares to measured elongations.

    Lyons' Table 1 (8, 5, 3 and "heavily loaded", a safety factor of 2, at 0.125, 0.25, 0.5 and 1 %) gives 0.0414 and R2
    0.9698 (eq. 13); the fit is 48 % low at a factor of 8, 34 % at 5. Use it as `ConstructionStretch(fit.coefficient)`.

    Parameters
    ----------
    safety_factors : array_like
        MBL/T of two or more measurements.
    elongations : array_like
        Elongation over length, 0.005 for 0.5 %.

    Returns
    -------
    StretchFit
        Coefficient and R2.

    Raises
    ------
    InputError
        Values are missing, out of range or all equal.

    Examples
    --------
    >>> round(rw.fit_construction_stretch([8.0, 5.0, 3.0, 2.0], [0.00125, 0.0025, 0.005, 0.01]).coefficient, 4)
    0.0414
    """
    factor, y = np.atleast_1d(np.asarray(safety_factors, float)), np.atleast_1d(np.asarray(elongations, float))
    if factor.shape != y.shape or factor.size < 2:
        raise InputError("The table needs two or more safety factors, each with its elongation", "Complete the table")
    require(factor, "safety factor", lambda v: v >= 1.0, "1 or more")
    require(y, "elongation", lambda v: (v >= 0.0) & (v < 0.1), "a share of the length, 0.005 for 0.5 %")
    x = 1.0 / factor**2
    coefficient = float(x @ y / (x @ x))
    about_mean = float(np.sum((y - y.mean()) ** 2))
    if about_mean == 0.0:
        raise InputError("All elongations are the same", "Give elongations that grow with the load")
    return StretchFit(coefficient, 1.0 - float(np.sum((y - coefficient * x) ** 2)) / about_mean)


def _force(horizontal: Numbers, vertical: Numbers) -> tuple[Array, Array]:
    require(horizontal, "horizontal tension [N]", lambda v: v > 0.0, "above zero")
    require(vertical, "vertical force [N]", np.isfinite, "finite")
    return np.asarray(horizontal, dtype=float), np.asarray(vertical, dtype=float)
