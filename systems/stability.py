"""Whether an equilibrium is stable: the pivots of a condensed stiffness."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu


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
