"""Whether a balance is stable, by the pivots of a condensed stiffness, and whether a line that moves still follows
it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from ropeway.components.component import Node
from ropeway.components.errors import EquilibriumError
from ropeway.systems.model import Balance, Model, component_of
from ropeway.systems.newton import newton_of
from ropeway.systems.state import LineState

SLACK = 1.02
"""Rope over chord (a sag of 9 %) beyond which a rope on idlers can have several stable places."""
_FOLLOWED = 0.02
"""Part of a span by which the rope on an idler may be elsewhere than its rate led to: beyond is another balance."""


def slack(state: LineState) -> bool:
    """Whether a rope on idlers is so slack that it could lie otherwise too."""
    for r, run in enumerate(state.runs):
        if any(node.balance is not None for node in run.nodes):
            chord = np.linalg.norm(np.diff(state.points(r), axis=0), axis=1)
            if np.any(np.diff(state.rope(r)) > SLACK * chord):
                return True
    return False


def require_stable(state: LineState) -> None:
    """Raises EquilibriumError where the rope over a support would run into one of its spans: the condensed
    stiffness of all free travels must be positive definite."""
    held = state.held_travels()
    free = tuple(b for b in state.model.balances if b.travel not in held)
    if not free:
        return
    rows, columns = condensed_last(state.model, free)
    matrix = newton_of(state.model).matrix(state.point)[rows][:, columns].tocsc()
    if has_free_nodes(state.model):
        pivots = condensed_pivots(matrix, len(free))
    else:
        pivots = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0).U.diagonal()[-len(free) :]
    soft = -np.array([b.sign for b in free]) * pivots <= 0.0
    if soft.any():
        raise _unstable(state.model, free[int(np.argmax(soft))])


def require_followed(state: LineState, led: np.ndarray) -> None:
    """Raises EquilibriumError where the rope on an idler is elsewhere than its rates led to, `led` (nz,): beyond the
    end of a stable balance Newton's method finds another one, far away."""
    travels = _travels(state.model)
    away = np.abs(state.point.z[travels] - led[travels]) / state.model.z.nominals[travels]
    if np.any(away > _FOLLOWED):
        raise _unstable(state.model, state.model.balances[int(np.argmax(away))])


def _unstable(model: Model, balance: Balance) -> EquilibriumError:
    name = component_of(model.z.names[balance.travel])
    return EquilibriumError(
        f"The balance of the rope over {name!r} is unstable: it would run into one of the spans",
        "The rope is too slack: shorten it or raise the tension",
        name,
    )


@lru_cache(maxsize=16)
def _travels(model: Model) -> np.ndarray:
    """Places of the travels on idlers in the algebraic variables; none where ropes hold a node, which moves far."""
    return np.array([] if has_free_nodes(model) else [b.travel for b in model.balances], dtype=int)


@lru_cache(maxsize=16)
def has_free_nodes(model: Model) -> bool:
    """Whether ropes hold a node in its place, as a carriage."""
    return any(isinstance(c, Node) and c.free for c in model.system.components.values())


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
