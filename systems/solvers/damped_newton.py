"""Newton's method, damped, on any scaled residual."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ropeway.components.errors import EquilibriumError
from ropeway.systems.modelling.dae_model import component_of

_SMALL = 1e-11
"""Scaled residual of a root."""
_NEAR = 0.1
"""Step after which a residual that is enough can be reached: a nearly linear system comes nearer than steps predict."""
_STAGNANT = 20
"""Number of iterations after which small steps at a root are taken for its rounding error."""


def damped(
    v: np.ndarray,
    step: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    value: Callable[[np.ndarray], np.ndarray],
    names: Sequence[str],
    iterations: int = 50,
    shortest: float = 1e-7,
    enough: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Newton's method from `v`, damped where the residual does not fall, to the rounding error or to a residual that is
    `enough`.

    step(v): residual (n,) and the solutions of the linear system for it and for more right-hand sides, one
    after the other; value(v): residual alone. Returns the root and the last of these solutions. `names` of
    the residuals are for the error. Raises EquilibriumError.
    """
    n = len(v)
    residual: np.ndarray | None = None
    move, before, last = np.zeros(n), np.inf, np.inf
    for number in range(iterations):
        try:
            now, sides = step(v)
            after = _norm(now)
            if residual is not None and not (after <= 0.9 * before or (last < 1e-6 and after <= 1e-12)):
                # After one long step down to the rounding error, the next step is small.
                if min(last, float(np.abs(sides[:n]).max())) < 1e-6 and _rounded(v, now, value):
                    return v - sides[:n], sides
                v = _shortened(v, move, before, value, residual, names, shortest)
                last = np.inf
                now, sides = step(v)
                after = _norm(now)
        except RuntimeError as error:
            raise failure(residual, "The equations are singular", names) from error
        residual, move = now, sides[:n]
        size = float(np.abs(move).max())
        if not np.isfinite(size):
            raise failure(residual, "The equations are singular", names)
        if number >= _STAGNANT and size <= 1e-6 and after <= 1e-12:
            return v - move, sides  # stiff: rounding errors of the unknowns move the others by more than a root's steps
        # Convergence is quadratic: the next step would be about size * (size / last)^2.
        coming = size * (size / last) * (size / last) if np.isfinite(last) else 100.0 * size * size
        if enough > 0.0 and size <= _NEAR and np.abs(value(v - move)).max() <= enough:
            return v - move, sides
        if min(size, coming) <= 1e-12 or after <= 1e-15 * np.sqrt(n):
            if last < 1e-2 and size <= 1e-3 * last and after <= 1e-6:  # seen over two full steps
                return v - move, sides
            # Otherwise it is only predicted: the residual decides.
            final = value(v - move).copy()
            if np.abs(final).max() <= _SMALL or _rounded(v - move, final, value):
                return v - move, sides
        v, before, last = v - move, after, size
    raise failure(residual, f"Newton's method has not converged in {iterations} iterations", names)


def _norm(v: np.ndarray) -> float:
    return math.sqrt(v.dot(v))


def _rounded(v: np.ndarray, residual: np.ndarray, value: Callable[[np.ndarray], np.ndarray]) -> bool:
    """Whether a residual is within the rounding error of the unknowns, as at a stiff spring far from the origin."""
    size, least = np.abs(residual), np.full(len(v), _SMALL)
    for signs in (1.0, np.where(np.arange(len(v)) % 2, 1.0, -1.0)):
        least = np.maximum(least, 4.0 * np.abs(value(v * (1.0 + 4.0 * np.finfo(float).eps * signs)) - residual))
    return bool((size <= least).all())


def _shortened(
    v: np.ndarray,
    move: np.ndarray,
    before: float,
    value: Callable[[np.ndarray], np.ndarray],
    residual: np.ndarray,
    names: Sequence[str],
    shortest: float,
) -> np.ndarray:
    """The point at a half, a quarter, ... of a step that has overshot, where the residual falls. Raises
    EquilibriumError."""
    share = 0.5
    while share > shortest:
        trial = v + (1.0 - share) * move
        if _norm(value(trial)) <= (1.0 - 0.1 * share) * before:
            return trial
        share *= 0.5
    raise failure(residual, "Newton's method makes no progress", names)


def failure(residual: np.ndarray | None, reason: str, names: Sequence[str]) -> EquilibriumError:
    """The error of a solve that has failed, with the worst residual."""
    worst, place = None, ""
    if residual is not None and len(residual):
        k = int(np.argmax(np.where(np.isfinite(residual), np.abs(residual), np.inf)))
        name = names[k] if k < len(names) else "a given value"
        worst, place = component_of(name), f" (worst: {name})"
    return EquilibriumError(
        f"{reason}{place}",
        "Check lengths, tensions and loads there, or start from a nearby equilibrium with start=",
        worst,
    )
