"""Stability of a balance, by the pivots of its condensed stiffness; and the check that a moving line follows it."""

from __future__ import annotations

from collections.abc import Collection
from functools import lru_cache

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from ropeway.components.component import Node
from ropeway.components.errors import EquilibriumError
from ropeway.systems.modelling.dae_model import Balance, Model, component_of
from ropeway.systems.solvers.newton import Point, newton_of
from ropeway.systems.statics.certificate_layout import layout_of
from ropeway.systems.statics.line_state import LineState

SLACK = 1.02
"""Ratio of rope to chord (a sag of 9 %) above which a rope on idlers can have several stable equilibria."""
_FOLLOWED = 0.02
"""Largest deviation of the travel of an idler from its prediction, relative to nominal: beyond it the solution is
another equilibrium."""


def slack(state: LineState) -> bool:
    """Whether a rope on idlers is so slack that it can have other stable equilibria."""
    for r, run in enumerate(state.runs):
        if any(node.balance is not None for node in run.nodes):
            chord = np.linalg.norm(np.diff(state.points(r), axis=0), axis=1)
            if np.any(np.diff(state.rope(r)) > SLACK * chord):
                return True
    return False


def require_stable(state: LineState) -> None:
    """Raises EquilibriumError where the rope over a support would run into one of its spans: the condensed
    stiffness of all free travels must be positive definite."""
    free = free_balances(state.model, state.point)
    if free:
        pivot, balance = least_pivot(state.model, state.point, free)
        if not pivot > 0.0:
            raise unstable(component_of(state.model.z.names[balance.travel]))


def free_balances(model: Model, point: Point, held: Collection[str] = ()) -> tuple[Balance, ...]:
    """The balances that are free: no load stands on the idler, and their variable is not in `held`."""
    kept = {model.z.index[name] for name in held if name in model.z.index}
    for layout in model.layouts:
        can = np.flatnonzero(layout.held >= 0)
        kept.update(layout.travel.algebraic[can[point.d[layout.held[can]] > 0.0]].tolist())
        # The rope on a shoe is counted from the shoe's middle: where all of it lies on one side, the stiffness of the
        # other side is negative. The tensions of such a shoe are taken as equal.
        (leaves, arrives), z = layout.aside, point.z
        shod = np.flatnonzero((leaves[1:] >= 0) & (arrives[:-1] >= 0))
        one_sided = shod[(z[leaves[1:][shod]] > 0.0) | (z[arrives[:-1][shod]] < 0.0)]
        kept.update(layout.travel.algebraic[one_sided + 1].tolist())
    return tuple(b for b in model.balances if b.travel not in kept)


def least_pivot(model: Model, point: Point, free: tuple[Balance, ...]) -> tuple[float, Balance]:
    """The least pivot of the condensed stiffness of some balances, relative to the largest one, and its balance: above
    0 where the stiffness is positive definite, NaN where the equations are singular."""
    condensed = _condensed(model, free)
    try:
        pivots = -condensed.signs * condensed.pivots(newton_of(model).jacobian_values(point))
    except RuntimeError:  # exactly singular
        return np.nan, free[0]
    k = int(np.argmin(pivots))
    return float(pivots[k] / np.abs(pivots).max()), free[k]


def require_followed(state: LineState, predicted: np.ndarray) -> None:
    """Raises EquilibriumError where the travel of an idler is far from its prediction (nz,): where a stable balance
    ends, Newton's method finds another one, far away."""
    travels = _travels(state.model)
    away = np.abs(state.point.z[travels] - predicted[travels]) / state.model.z.nominals[travels]
    if np.any(away > _FOLLOWED):
        raise unstable(component_of(state.model.z.names[travels[int(np.argmax(away))]]))


def unstable(name: str) -> EquilibriumError:
    """The error for a support over which the rope runs away."""
    return EquilibriumError(
        f"The balance of the rope over {name!r} is unstable: it would run into one of the spans",
        "The rope is too slack: shorten it or raise the tension",
        name,
    )


@lru_cache(maxsize=16)
def _travels(model: Model) -> np.ndarray:
    """Places of the travels of idlers in the algebraic variables; none where ropes hold a node, which moves far."""
    if has_free_nodes(model):
        return np.zeros(0, dtype=int)
    travels = {place for layout in model.layouts for place in layout.travel.algebraic.tolist()}
    return np.array([b.travel for b in model.balances if b.travel in travels], dtype=int)


@lru_cache(maxsize=16)
def has_free_nodes(model: Model) -> bool:
    """Whether ropes alone determine the position of a node, as of a carriage; a wheel on a slide is guided."""
    nodes = [c for c in model.system.components.values() if isinstance(c, Node)]
    return any(place in {"x", "y", "z"} for node in nodes for place, _ in node.free)


def condensed_pivots(matrix: csc_matrix, count: int) -> np.ndarray:
    """Pivots of the last `count` rows and columns after the others are eliminated, also where these have no
    usable diagonal, as those of a carriage or a mast."""
    n = matrix.shape[0] - count
    inner = splu(matrix[:n, :n].tocsc()).solve(matrix[:n, n:].toarray())
    stiffness = matrix[n:, n:].toarray() - matrix[n:, :n] @ inner
    return _pivots(stiffness)


def _pivots(stiffness: np.ndarray) -> np.ndarray:
    """Pivots of a small matrix, in place."""
    pivots = np.empty(len(stiffness))
    for k in range(len(stiffness)):
        pivots[k] = stiffness[k, k]
        if pivots[k] != 0.0:
            stiffness[k + 1 :] -= np.outer(stiffness[k + 1 :, k] / pivots[k], stiffness[k])
    return pivots


class _Condensed:
    """The condensed stiffness of some balances of a model; the places of its entries in the Jacobian are determined
    once."""

    def __init__(self, model: Model, free: tuple[Balance, ...]) -> None:
        rows, columns = condensed_last(model, free)
        self.signs, self.count = np.array([b.sign for b in free]), len(free)
        self.whole = layout_of(model).plain
        pattern = newton_of(model).matrix_places()
        if self.whole:
            self._all = _Block(pattern[rows][:, columns])
            return
        inner, outer = slice(0, len(rows) - self.count), slice(len(rows) - self.count, None)
        # An order that fills in little serves for all values.
        trial = pattern[rows][:, columns].astype(float)
        trial.data[:] = np.random.default_rng(1).uniform(1.0, 2.0, trial.nnz)
        columns[inner] = columns[inner][np.argsort(splu(trial[inner, inner].tocsc()).perm_c)]
        ordered = pattern[rows][:, columns]
        self._inner, self._right = _Block(ordered[inner, inner]), _Block(ordered[inner, outer])
        self._below, self._corner = _Block(ordered[outer, inner]), _Block(ordered[outer, outer])

    def pivots(self, values: np.ndarray) -> np.ndarray:
        """Pivots of the balances after all other variables are eliminated, for the entries of a Jacobian. Raises
        RuntimeError where it is singular."""
        if self.whole:
            factors = splu(self._all.of(values), permc_spec="NATURAL", diag_pivot_thresh=0.0)
            return np.asarray(factors.U.diagonal()[-self.count :])
        solved = splu(self._inner.of(values), permc_spec="NATURAL").solve(self._right.of(values).toarray())
        return _pivots(self._corner.of(values).toarray() - self._below.of(values) @ solved)


class _Block:
    """Part of a sparse matrix; `places` has the numbers, from 1, of its entries in the whole matrix."""

    def __init__(self, places: csc_matrix) -> None:
        found = places.tocsc()
        found.sort_indices()
        self._take, self._rows, self._columns, self._shape = found.data - 1, found.indices, found.indptr, found.shape

    def of(self, values: np.ndarray) -> csc_matrix:
        """The part, for the entries of the whole matrix."""
        return csc_matrix((values[self._take], self._rows, self._columns), shape=self._shape)


@lru_cache(maxsize=64)
def _condensed(model: Model, free: tuple[Balance, ...]) -> _Condensed:
    return _Condensed(model, free)


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
