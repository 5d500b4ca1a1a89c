"""IDAS on a model, over a time without events.

Time is normalised, t = t0 + tau h with h a parameter, so that one integrator serves every step, also backwards. What
the initial rates do not explain is integrated, w = x - h tau x'0 and likewise z: its rates are zero at first, so that
IDAS needs no initialisation; its first prediction is of second order. Inputs are linear in time.

The travel of a drive whose speed is commanded is a known function of time, and is not integrated: it does not drift.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ropeway.components.errors import SimulationError
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.equations import derivatives, expanded
from ropeway.systems.muted import muted
from ropeway.systems.solvers.model_functions import Buffered, banded_order
from ropeway.systems.solvers.points import Point
from ropeway.systems.solvers.prescribed_states import commanded_of


def strict(tolerance: float, share: float) -> float:
    """Tolerance of one step, a share of the run's, as errors of steps add up; not below the rounding error."""
    return min(tolerance, max(share * tolerance, 1e-11))


class Stretch(NamedTuple):
    """How a stretch is integrated: `share` of the tolerance that one step may use, the `first` step, a part of the
    stretch, and by how many times that share Newton's iteration may miss the algebraic variables, which have no part in
    the error of a step; `follows`: whether the rates of the algebraic variables at the start are known. The
    algebraic variables of a line with inertia oscillate, and are solved again at the end of a stretch."""

    share: float
    first: float
    slack: float
    follows: bool


SLOW, OSCILLATING = Stretch(1e-3, 0.03, 1.0, True), Stretch(1.0, 0.02, 10.0, False)


def _scaled_moves(model: Model, arguments: Sequence[Any], h: Any, order: tuple[np.ndarray, np.ndarray]) -> list[Any]:
    """Derivatives of the rates and of the scaled algebraic equations, by the states and then by the algebraic
    variables; `order` of the equations and of these."""
    rates_by_x, rates_by_z, *algebraic = derivatives(model).call(arguments)[:4]
    by_x, by_z = (own * ca.DM(own.sparsity(), 1.0 / model.r.nominals[own.sparsity().row()]) for own in algebraic)
    rows, columns = (part.tolist() for part in order)
    return [h * rates_by_x, by_x[rows, :], h * rates_by_z[:, columns], by_z[rows, columns]]


def _jacobian(given: dict[str, Any], moves: list[Any]) -> ca.Function:
    """The function by this name that CasADi's integrators have, so that they do not build it by differentiation."""
    names = ["jac_ode_x", "jac_alg_x", "jac_ode_z", "jac_alg_z"]
    inputs = [*given.values(), type(given["t"])(0, 1)]
    return ca.Function("jacF", inputs, moves, [*given, "u"], names)


class Idas:
    """The integrator of a model; `tolerance` is absolute, on scaled variables. It gives `count` points of a stretch, at
    equal distances."""

    def __init__(self, model: Model, tolerance: float, stretch: Stretch = SLOW, count: int = 1) -> None:
        self.model, self.count = model, count
        nx, nz, nu = len(model.x), len(model.z), len(model.u)
        sym = model.sym
        w, unknowns, tau = sym("w", nx), sym("zeta", nz), sym("tau")
        start, h, x_rate, z_rate = sym("t0"), sym("h"), sym("dx", nx), sym("dz", nz if stretch.follows else 0)
        u, slope = sym("u", nu), sym("slope", nu)
        p, d = sym("p", len(model.p)), sym("d", len(model.d))
        # IDAS's linear solver does not reorder rows and columns: see `banded_order`.
        dae = expanded(model)
        rows, columns = banded_order(dae.jac_sparsity(1, 2))
        self._columns, self._places = columns, np.argsort(columns)
        passed = tau * h
        x, z = w + passed * x_rate, unknowns[self._places.tolist()]
        if stretch.follows:
            z += passed * z_rate
        arguments = (start + passed, x, z, u + slope * passed, p, d)
        ode, alg = dae(*arguments)
        knowns = ca.vertcat(start, h, x_rate, z_rate, u, slope, p, d)
        # IDAS tests the mean error over all variables, of which only the states count.
        tight = strict(tolerance, stretch.share) * float(np.sqrt(max(nx, 1) / (nx + nz)))
        given = {"t": tau, "x": w, "z": unknowns, "p": knowns}
        moves = _scaled_moves(model, arguments, h, (rows, columns))
        scale = np.concatenate([model.x.nominals, stretch.slack * model.z.nominals[columns]])
        integrator = ca.integrator(
            "idas",
            "idas",
            {
                **given,
                "ode": h * (ode - x_rate),
                "alg": (alg / model.r.nominals)[rows.tolist()],
            },
            0.0,
            1.0 if count == 1 else [(i + 1) / count for i in range(count)],
            {
                "abstolv": (tight * scale).tolist(),
                "reltol": 0.0,
                # z is solved, not integrated: its error is that of Newton's method.
                "suppress_algebraic": True,
                "calc_ic": False,
                "linear_solver": "csparse",
                # The error test shortens the first step.
                "step0": stretch.first,
                "max_num_steps": 100_000,
                "cache": {"jacF": _jacobian(given, moves)},
            },
        )
        self._f = Buffered(integrator)
        self._commanded = commanded_of(model)
        self._follows = stretch.follows

    def advance(
        self, point: Point, h: float, x_rate: np.ndarray, z_rate: np.ndarray, slope: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """States and algebraic variables `h` seconds after a consistent point with its rates [per s]; those of the
        algebraic variables are not used where they oscillate.

        Raises SimulationError.
        """
        x, z = self.along(point, h, x_rate, z_rate, slope)
        return x[-1], z[-1]

    def along(
        self, point: Point, h: float, x_rate: np.ndarray, z_rate: np.ndarray, slope: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """As `advance`, at all points of the stretch: (count, nx) and (count, nz)."""
        passed = h * np.arange(1, self.count + 1) / self.count
        z_rate = z_rate if self._follows else np.zeros(0)
        knowns = np.concatenate([[point.t, h], x_rate, z_rate, point.u, slope, point.p, point.d])
        try:
            with muted():
                end = self._f(point.x, point.z[self._columns], knowns)
        except RuntimeError as error:
            reason = str(error).strip().splitlines()[-1]
            raise SimulationError(
                f"IDAS failed within the next {h:.9g} s: {reason}",
                "Check the last result for a slack rope or a load that stands on a support; or take a larger tolerance",
                point.t,
            ) from error
        x = end[0].reshape(self.count, -1) + passed[:, None] * x_rate
        self._commanded.put(x, point, passed, slope)
        z = end[1].reshape(self.count, -1)[:, self._places]
        return x, z + passed[:, None] * z_rate if self._follows else z
