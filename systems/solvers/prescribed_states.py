"""States whose rates are known functions of time: the travel of drives that follow a commanded speed.

They are integrated by Simpson's rule, exact for rates up to the third power of time, so that travel does not drift over
thousands of steps.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ropeway.systems.modelling.dae_model import BUILDING, Model, kept_with_model
from ropeway.systems.modelling.equations import expanded
from ropeway.systems.solvers.model_functions import Buffered
from ropeway.systems.solvers.points import Point


class Commanded:
    """The commanded states of a model: `rows` are their places."""

    def __init__(self, model: Model) -> None:
        t, h = model.sym("t"), model.sym("h")
        slope, u = (model.sym(name, len(model.u)) for name in ("slope", "u"))
        p, d = model.sym("p", len(model.p)), model.sym("d", len(model.d))
        dae = expanded(model)
        solved = {*dae.jac_sparsity(0, 1).row(), *dae.jac_sparsity(0, 2).row()}
        self.rows = [i for i in range(len(model.x)) if i not in solved]
        # These rates do not depend on the states and algebraic variables: any values serve.
        ode, _ = dae(t, model.x.values, model.z.values, u, p, d)
        rate = ca.Function("rate", [t, u, p, d], [ca.densify(ode[self.rows])])
        ends = [rate(t + share * h, u + share * h * slope, p, d) for share in (0.0, 0.5, 1.0)]
        gain = h / 6.0 * (ends[0] + 4.0 * ends[1] + ends[2])
        self._model, self._one = model, ca.Function("gain", [h, t, u, slope, p, d], [gain])
        self._gains: dict[int, Buffered] = {}

    def _gain(self, count: int) -> Buffered:
        """Changes over `count` steps, one after the other; made at the first use."""
        with BUILDING:
            if count not in self._gains:
                make = self._model.sym
                rest = [make(self._one.name_in(i), self._one.numel_in(i)) for i in range(1, self._one.n_in())]
                stretches = [make(f"h{i}") for i in range(count)]
                gains = ca.vertcat(*(self._one(h, *rest) for h in stretches))
                self._gains[count] = Buffered(ca.Function("gains", [ca.vertcat(*stretches), *rest], [gains]))
            return self._gains[count]

    def put(self, x: np.ndarray, point: Point, h: np.ndarray, slope: np.ndarray) -> None:
        """Writes the commanded states after `h` (n,) seconds from a point into `x` (n, nx), with inputs of rate
        `slope`."""
        if self.rows:
            gain = self._gain(len(h))(h, np.array([point.t]), point.u, slope, point.p, point.d)[0]
            x[:, self.rows] = point.x[self.rows] + gain.reshape(len(h), -1)


@kept_with_model
def commanded_of(model: Model) -> Commanded:
    """The commanded states of a model, determined once."""
    return Commanded(model)
