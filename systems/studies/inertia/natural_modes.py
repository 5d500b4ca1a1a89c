"""Natural frequencies and shapes of a linearised motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, eigh
from scipy.sparse import csc_matrix, diags
from scipy.sparse.linalg import eigs, eigsh

from ropeway.components.errors import EquilibriumError
from ropeway.systems.studies.inertia.mass_matrix import Motion

_SYMMETRIC = 1e-9
"""Largest relative asymmetry of a flexibility that counts as rounding."""
_MASSLESS = 1e-12
"""Part of the largest mass at a coordinate that each coordinate gets: one without mass then has a frequency far above
all others."""
_DENSE = 400
"""Up to so many coordinates the matrices are dense."""


class NaturalModes(NamedTuple):
    """Natural modes in the order of their frequency.

    frequency : circular frequency [rad/s], (modes,).
    shape : displacements of the coordinates, (coordinates, modes).
    """

    frequency: np.ndarray
    shape: np.ndarray


def natural_modes(motion: Motion, count: int) -> NaturalModes:
    """The lowest `count` modes, or as many as there are coordinates. Raises EquilibriumError for an equilibrium that is
    not stable.

    Of C M s = s / omega^2 with the flexibility C and the mass M. The flexibility of ropes is symmetric; friction, and
    an ideal holding force that follows the carriage, are not conservative.
    """
    flexibility, mass = motion.flexibility, csc_matrix(sum(motion.mass))
    size = mass.shape[0]
    count = min(count, size)
    mass += diags(np.full(size, _MASSLESS * mass.diagonal().max(initial=0.0)), format="csc")
    symmetric = _symmetric(motion)
    if size <= _DENSE or count >= size - 1:
        values, shapes = _dense(flexibility @ np.eye(size), mass.toarray(), count, symmetric=symmetric)
    else:
        # ARPACK calls 1/(1/omega^2) the eigenvalue nearest to sigma = 0; the stiffness itself is not needed.
        solve = eigsh if symmetric else eigs
        found, shapes = solve(flexibility, count, M=mass, sigma=0.0, OPinv=flexibility, v0=np.ones(size))
        values = 1.0 / found
    order = np.argsort(-values.real)
    values, shapes = values[order], shapes[:, order]
    if np.any(np.abs(values.imag) > 1e-6 * np.abs(values.real)) or not values.real.min(initial=1.0) > 0.0:
        raise EquilibriumError(
            "The line does not vibrate about this equilibrium: it is unstable, or friction drives it",
            "Check its certificate; leave out friction and the ideal holding force of a carriage",
        )
    return NaturalModes(1.0 / np.sqrt(values.real), shapes.real)


def _symmetric(motion: Motion) -> bool:
    """Whether the flexibility is symmetric, by two random loads."""
    size = motion.flexibility.shape[0]
    one, other = np.random.default_rng(1).standard_normal((2, size))
    there, back = one @ (motion.flexibility @ other), other @ (motion.flexibility @ one)
    return bool(abs(there - back) <= _SYMMETRIC * np.linalg.norm(one) * np.linalg.norm(motion.flexibility @ other))


def _dense(flexibility: np.ndarray, mass: np.ndarray, count: int, *, symmetric: bool) -> tuple[np.ndarray, np.ndarray]:
    """The largest 1/omega^2, and the shapes. With M = L L^T they belong to L^T C L."""
    if not symmetric:
        values, shapes = eig(flexibility @ mass)
        order = np.argsort(-values.real)[:count]
        return values[order], shapes[:, order]
    root = np.linalg.cholesky(mass)
    reduced = root.T @ flexibility @ root
    first = len(mass) - count
    values, vectors = eigh(0.5 * (reduced + reduced.T), subset_by_index=[first, first + count - 1])
    return values, flexibility @ root @ vectors
