"""The condensed stiffness of what can move in a model, all else in balance: the pivots say whether it is stable."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from ropeway.systems.modelling.dae_model import Model, kept_with_structure
from ropeway.systems.modelling.model_tables import Balance
from ropeway.systems.solvers.kernels.compiled_network import CompiledPivots
from ropeway.systems.solvers.newton import Functions, Newton
from ropeway.systems.statics.certificate_layout import layout_of

_SMALL = 128
"""Balances of so many unknowns are eliminated in one dense matrix, faster than in a sparse one."""

NONE_KEPT = np.zeros((2, 0), int)


class CondensedStiffness:
    """The condensed stiffness of some balances, for the Jacobians of `newton`. Where its entries go is found once.

    kept: rows and columns (2, n) of what stays as it is, neither moves nor is in balance.
    """

    def __init__(self, newton: Newton, free: Sequence[Balance], kept: np.ndarray = NONE_KEPT) -> None:
        self.newton, self.balances, self.kept = newton, tuple(free), kept
        self._signs = -np.array([b.sign for b in free])
        kept_places = tuple(map(tuple, kept.tolist()))
        self._pivots_of = _elimination(newton.model, newton.functions, self.balances, kept_places)

    def condensed(self, balances: Sequence[Balance]) -> CondensedStiffness:
        """On some of the balances, the others kept in balance."""
        return CondensedStiffness(self.newton, balances, self.kept)

    def pivots(self, jacobian: np.ndarray) -> np.ndarray:
        """Pivots of the balances after all else is eliminated, for the entries of a Jacobian: all above zero where the
        state is stable. After the first that is not, they mean nothing. Raises RuntimeError where the other equations
        are singular."""
        return np.asarray(self._signs * self._pivots_of(jacobian))


def places_of(balances: Sequence[Balance]) -> np.ndarray:
    """Rows and columns of balances, (2, n)."""
    return np.array([[b.residual for b in balances], [b.travel for b in balances]], int).reshape(2, -1)


@kept_with_structure
def _elimination(
    model: Model, functions: Functions, free: tuple[Balance, ...], kept: tuple[tuple[int, ...], ...]
) -> CompiledPivots | _Banded | _Dense | _Sparse:
    """The elimination of all but some balances in the Jacobians of some functions of a structure."""
    rows, columns = (
        np.concatenate([np.setdiff1d(np.arange(len(model.z)), [*own, *still]), own])
        for own, still in zip(places_of(free), kept, strict=True)
    )
    pattern, inner = functions.sparse(np.arange(1, functions.entries + 1)), len(rows) - len(free)
    if model.compiled:
        return CompiledPivots(pattern[rows][:, columns], inner)
    if layout_of(model).plain:
        return _Banded(pattern[rows][:, columns], inner)
    if inner <= _SMALL:
        return _Dense(pattern[rows][:, columns], inner)
    return _Sparse(pattern, rows, columns, inner)


class _Banded:
    """Of a plain line: all pivots in one sparse factorisation, in the order of the line. Forces are eliminated first,
    so that the last pivots are those of the condensed stiffness."""

    def __init__(self, places: csc_matrix, inner: int) -> None:
        self._inner, self._all = inner, _Block(places)

    def __call__(self, jacobian: np.ndarray) -> np.ndarray:
        factors = splu(self._all.of(jacobian), permc_spec="NATURAL", diag_pivot_thresh=0.0)
        return np.asarray(factors.U.diagonal()[self._inner :])


class _Dense:
    """Of a small model, where the others need not have a usable diagonal, as those of a carriage or a mast."""

    def __init__(self, places: csc_matrix, inner: int) -> None:
        entries = places.tocoo()
        self._inner, self._size = inner, places.shape[0]
        self._take, self._at = entries.data - 1, entries.row * self._size + entries.col

    def __call__(self, jacobian: np.ndarray) -> np.ndarray:
        n, entries = self._inner, np.zeros(self._size**2)
        entries[self._at] = jacobian[self._take]
        whole = entries.reshape(self._size, self._size)
        try:
            moved = np.linalg.solve(whole[:n, :n], whole[:n, n:])
        except np.linalg.LinAlgError as error:
            raise RuntimeError("The equations of the others are singular") from error
        return _pivots(whole[n:, n:] - whole[n:, :n] @ moved)


class _Sparse:
    """Of a large model. An order of the others that fills in little serves for all values."""

    def __init__(self, pattern: csc_matrix, rows: np.ndarray, columns: np.ndarray, count: int) -> None:
        inner, outer = slice(0, count), slice(count, None)
        trial = pattern[rows][:, columns].astype(float)
        trial.data[:] = np.random.default_rng(1).uniform(1.0, 2.0, trial.nnz)
        columns[inner] = columns[inner][np.argsort(splu(trial[inner, inner].tocsc()).perm_c)]
        ordered = pattern[rows][:, columns]
        self._inner, self._right = _Block(ordered[inner, inner]), _Block(ordered[inner, outer])
        self._below, self._corner = _Block(ordered[outer, inner]), _Block(ordered[outer, outer])

    def __call__(self, jacobian: np.ndarray) -> np.ndarray:
        right = self._right.of(jacobian).toarray()
        moved = splu(self._inner.of(jacobian), permc_spec="NATURAL").solve(right)
        return _pivots(self._corner.of(jacobian).toarray() - self._below.of(jacobian) @ moved)


class _Block:
    """Part of a sparse matrix whose entries are taken from those of the whole: `places` holds their numbers, from 1."""

    def __init__(self, places: csc_matrix) -> None:
        block = places.tocsc()
        block.sort_indices()
        self._take, self._rows, self._columns, self._shape = block.data - 1, block.indices, block.indptr, block.shape

    def of(self, values: np.ndarray) -> csc_matrix:
        """With these entries of the whole."""
        return csc_matrix((values[self._take], self._rows, self._columns), shape=self._shape)


def _pivots(stiffness: np.ndarray) -> np.ndarray:
    """Pivots of a small matrix, in place."""
    for k in range(len(stiffness) - 1):
        below = stiffness[k + 1 :, k, None]
        if stiffness[k, k] != 0.0:
            stiffness[k + 1 :, k + 1 :] -= below / stiffness[k, k] * stiffness[k, k + 1 :]
    return np.diagonal(stiffness)
