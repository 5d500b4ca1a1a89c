"""States whose rates are known functions of time: the travel of drives that follow a commanded speed.

They are integrated by Simpson's rule, exact for rates up to the third power of time, so that travel does not
drift over thousands of stretches.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from ropeway.components.component import Kind
from ropeway.systems.model import Model
from ropeway.systems.newton import VECTORS, Buffered, Point, expanded


class Commanded:
    """The commanded states of a model: `rows` are their places."""

    def __init__(self, model: Model) -> None:
        sx = {kind: ca.SX.sym(kind.value, len(model.tables[kind])) for kind in VECTORS}
        t, h, slope = ca.SX.sym("t"), ca.SX.sym("h"), ca.SX.sym("slope", len(model.u))
        ode, _ = expanded(model)(t, *(sx[kind] for kind in VECTORS))
        solved = set(ca.jacobian_sparsity(ode, ca.vertcat(sx[Kind.STATE], sx[Kind.ALGEBRAIC])).row())
        self.rows = [i for i in range(len(model.x)) if i not in solved]
        known, u = ca.densify(ode[self.rows]), sx[Kind.INPUT]
        rate = ca.Function("rate", [t, u, sx[Kind.PARAMETER], sx[Kind.DISCRETE]], [known])
        p, d = sx[Kind.PARAMETER], sx[Kind.DISCRETE]
        ends = [rate(t + share * h, u + share * h * slope, p, d) for share in (0.0, 0.5, 1.0)]
        gain = h / 6.0 * (ends[0] + 4.0 * ends[1] + ends[2])
        self._gain = Buffered(ca.Function("gain", [h, t, u, slope, p, d], [gain]))

    def put(self, x: np.ndarray, point: Point, h: float, slope: np.ndarray) -> None:
        """Writes the commanded states `h` seconds after a point into `x`, with inputs of rate `slope`."""
        if self.rows:
            gain = self._gain(np.array([h]), np.array([point.t]), point.u, slope, point.p, point.d)[0]
            x[self.rows] = point.x[self.rows] + gain


@lru_cache(maxsize=16)
def commanded_of(model: Model) -> Commanded:
    """The commanded states of a model: found once."""
    return Commanded(model)
