"""Whether an equilibrium is stable: the pivots of a condensed stiffness."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from ropeway.systems.model import Balance, Model


def condensed_pivots(matrix: csc_matrix, count: int) -> np.ndarray:
    """Pivots of the last `count` rows and columns after the others are eliminated, also where these have no
    usable diagonal, as those of a carriage or a mast."""
    n = matrix.shape[0] - count
    inner = splu(matrix[:n, :n].tocsc()).solve(matrix[:n, n:].toarray())
    stiffness = matrix[n:, n:].toarray() - matrix[n:, :n] @ inner
    pivots = np.empty(count)
    for k in range(count):
        pivots[k] = stiffness[k, k]
        if pivots[k] != 0.0:
            stiffness[k + 1 :] -= np.outer(stiffness[k + 1 :, k] / pivots[k], stiffness[k])
    return pivots


@lru_cache(maxsize=16)
def condensed_last(model: Model, free: tuple[Balance, ...]) -> tuple[np.ndarray, np.ndarray]:
    """An order of rows and columns in which the balances come last.

    Forces are eliminated first, so that the last pivots are those of the condensed stiffness: all positive
    when, and only when, that symmetric matrix is positive definite.
    """
    columns, rows = np.array([b.travel for b in free]), np.array([b.residual for b in free])
    everything = np.arange(len(model.z))
    return (
        np.concatenate([np.setdiff1d(everything, rows), rows]),
        np.concatenate([np.setdiff1d(everything, columns), columns]),
    )
