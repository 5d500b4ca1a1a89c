"""Lyons' dimensionless forms, his twelve cases, and the tension that relates them.

Lyons (2008), eq. 20-26, Table 2 and Figure 2. phi = V_A/W, chi = H/W, beta = W/EA, tau = MBL/W; psi is the
unstretched over the stretched length. W is the same in all three, as in Lyons.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ropeway.components import catenary
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Strain
from ropeway.components.rope import ConstructionStretch
from ropeway.components.rope_catalogue import MODULUS
from ropeway.systems.modelling.system import GRAVITY
from ropeway.systems.studies.handbook.array_checks import require
from ropeway.systems.studies.handbook.array_roots import Array, Numbers

DENSITY = 9300.0
"""Density of the metal of a 6x19 IWRC rope [kg/m3] (Lyons, p. 32)."""

STRENGTH_OVER_STIFFNESS = (0.010, 0.025)
"""Range of MBL/EA = beta tau of steel wire ropes: 0.0183 to 0.0187 for Lyons', 0.0147 to 0.0199 for the EN 12385-4
constructions and grades with his modulus."""


class Case(NamedTuple):
    """A row of Table 2. tau is inf for elastic stretch only; slope = phi/chi at support A."""

    number: int
    beta: float
    tau: float
    slope: float

    @property
    def possible(self) -> bool:
        """Whether a steel wire rope can have this beta and tau: beta tau is its strength over its stiffness."""
        low, high = STRENGTH_OVER_STIFFNESS
        return self.tau == np.inf or low <= self.beta * self.tau <= high


CASES = tuple(
    Case(1 + k, beta, tau, slope)
    for k, (beta, tau, slope) in enumerate(
        [
            *((beta, np.inf, slope) for beta in (4.90e-5, 2.94e-4) for slope in (0.2, 1.0)),
            *((beta, tau, slope) for beta in (4.90e-5, 2.94e-4) for tau in (377.0, 62.0) for slope in (0.2, 1.0)),
        ]
    )
)
"""Lyons' Table 2. Cases 7 to 10 fit no rope: beta tau is 0.0030 and 0.111."""


def psi_average(beta: Numbers, phi: Numbers, chi: Numbers) -> Array:
    """Unstretched over stretched length by the average end tension (eq. 21)."""
    b, p, c = _dimensionless(beta, phi, chi)
    return 1.0 / (1.0 + b / 2.0 * (np.hypot(c, p) + np.hypot(c, p - 1.0)))


def psi_elastic(beta: Numbers, phi: Numbers, chi: Numbers) -> Array:
    """Unstretched over stretched length of an elastic rope; exact (eq. 22 and 24). chi > 0."""
    b, p, c = _dimensionless(beta, phi, chi)
    return 1.0 / np.asarray(catenary.stretched_length((c, 0.0, -p), 1.0, 1.0, Strain(b, 0.0)))


def psi_construction(
    beta: Numbers,
    phi: Numbers,
    chi: Numbers,
    tau: Numbers,
    *,
    coefficient: float = ConstructionStretch().coefficient,
    as_printed: bool = False,
) -> Array:
    """Unstretched over stretched length with construction stretch; exact (eq. 25).

    As printed, eq. 25 ends in -2 asinh(phi/chi), although the factor 1/2 is already outside. The correct term is
    -asinh(phi/chi), which Lyons used for his figure.
    """
    b, p, c = _dimensionless(beta, phi, chi)
    require(tau, "tau", lambda v: v > 0.0, "above zero")
    strain = Strain(b, coefficient / np.square(tau))
    stretched = np.asarray(catenary.stretched_length((c, 0.0, -p), 1.0, 1.0, strain))
    return 1.0 / (stretched + c * c * b / 2.0 * np.arcsinh(p / c) if as_printed else stretched)


def flexibility(
    length: Numbers, *, density: float = DENSITY, modulus: float = MODULUS, gravity: float = GRAVITY
) -> Array:
    """beta = W/EA = rho g L0/E of a rope of unstretched `length` [m], independent of its diameter (p. 32)."""
    require(length, "length [m]", lambda v: v > 0.0, "above zero")
    return density * gravity * np.asarray(length) / modulus


def strength(mass_per_length: Numbers, breaking_load: Numbers, length: Numbers, *, gravity: float = GRAVITY) -> Array:
    """tau = MBL/W (p. 33)."""
    return np.asarray(breaking_load) / (np.asarray(mass_per_length) * gravity * np.asarray(length))


def taut_phi(tension: Numbers, chord_slope: Numbers, weight: Numbers, length: Numbers) -> Array:
    """phi = V_A/W of a short tight rope with equal tension [N] at both ends; weight in N/m (eq. 26)."""
    return np.asarray(tension) * np.sin(np.arctan(chord_slope)) / (np.asarray(weight) * np.asarray(length))


def locus_phi(tau: Numbers, slope: Numbers, *, share: float = 1.0 / 3.0) -> Array:
    """phi at which the tension at support A is a share of the breaking load: T_A/W = share tau (Figure 2, dashed).

    phi = share tau / sqrt(1 + 1/slope^2), slope = phi/chi.
    """
    require(slope, "slope at support A", lambda v: v > 0.0, "above zero")
    return share * np.asarray(tau) / np.sqrt(1.0 + 1.0 / np.square(slope))


@checked
def twelve_cases(phi: ArrayLike) -> pd.DataFrame:
    """Lyons' Figure 2 as numbers: the length by the average tension over the exact one, for all twelve cases.

    Parameters
    ----------
    phi : array_like
        V_A/W: ratio of the upward force of support A to the weight of the rope.

    Returns
    -------
    DataFrame
        Columns: case, phi, ratio (psi_inf/psi_E of cases 1-4, psi_inf/psi_EC of 5-12), utilisation: T_A/MBL (NaN in
        cases 1-4), possible: whether a rope can have the case's beta and tau and withstand its tension.

    Raises
    ------
    InputError
        phi is not a number, or too large for a case.

    Examples
    --------
    >>> rw.twelve_cases([1.0, 2.0]).groupby("case")["ratio"].max().round(4).loc[[1, 5]].tolist()
    [1.0, 1.0]
    """
    values = np.asarray(phi, dtype=float).ravel()
    tables = []
    for case in CASES:
        chi = values / case.slope
        exact = (
            psi_elastic(case.beta, values, chi)
            if case.tau == np.inf
            else psi_construction(case.beta, values, chi, case.tau)
        )
        utilisation = np.hypot(values, chi) / case.tau if case.tau < np.inf else np.full(len(values), np.nan)
        tables.append(
            pd.DataFrame(
                {
                    "case": case.number,
                    "phi": values,
                    "ratio": psi_average(case.beta, values, chi) / exact,
                    "utilisation": utilisation,
                    "possible": case.possible & ~(utilisation > 1.0),
                }
            )
        )
    return pd.concat(tables, ignore_index=True)


def _dimensionless(beta: Numbers, phi: Numbers, chi: Numbers) -> tuple[Array, Array, Array]:
    require(beta, "beta", lambda v: v >= 0.0, "zero or more")
    require(phi, "phi", np.isfinite, "finite")
    require(chi, "chi", lambda v: v > 0.0, "above zero")
    return np.asarray(beta, dtype=float), np.asarray(phi, dtype=float), np.asarray(chi, dtype=float)
