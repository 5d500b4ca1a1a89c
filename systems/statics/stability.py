"""Stability of a balance, by the pivots of its condensed stiffness; and the check that a moving line follows it."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ropeway.components.errors import EquilibriumError
from ropeway.components.node import Node
from ropeway.systems.modelling.dae_model import Model, component_of, kept_with_model
from ropeway.systems.modelling.model_tables import Balance
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.condensed_stiffness import CondensedStiffness
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
        pivots = condensed.pivots(newton_of(model).jacobian_values(point))
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


@kept_with_model
def _travels(model: Model) -> np.ndarray:
    """Places of the travels of idlers in the algebraic variables; none where ropes hold a node, which moves far."""
    if has_free_nodes(model):
        return np.zeros(0, dtype=int)
    travels = {place for layout in model.layouts for place in layout.travel.algebraic.tolist()}
    return np.array([b.travel for b in model.balances if b.travel in travels], dtype=int)


@kept_with_model
def has_free_nodes(model: Model) -> bool:
    """Whether ropes alone determine the position of a node, as of a carriage; a wheel on a slide is guided."""
    nodes = [c for c in model.system.components.values() if isinstance(c, Node)]
    return any(place in {"x", "y", "z"} for node in nodes for place, _ in node.free)


@kept_with_model
def _condensed(model: Model, free: tuple[Balance, ...]) -> CondensedStiffness:
    return CondensedStiffness(newton_of(model), free)
