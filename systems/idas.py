"""IDAS on a model, over a stretch of time in which nothing jumps.

Time is normalised, t = t0 + tau h with h a parameter, so that one integrator serves every stretch, and
backwards too. States and algebraic variables are scaled by their nominals. Inputs are linear in time, so
the travel of a drive whose speed is commanded is a quadratic of time: it is taken from there, without drift.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ropeway.components.component import Kind
from ropeway.components.errors import SimulationError
from ropeway.systems.model import Model
from ropeway.systems.newton import Point


class Idas:
    """The integrator of a model for a relative and absolute `tolerance` on scaled variables."""

    def __init__(self, model: Model, tolerance: float) -> None:
        self.model = model
        sx = {kind: ca.SX.sym(kind.value, len(model.tables[kind])) for kind in (Kind.STATE, Kind.ALGEBRAIC)}
        start, h, tau = ca.SX.sym("t0"), ca.SX.sym("h"), ca.SX.sym("tau")
        u, slope = ca.SX.sym("u", len(model.u)), ca.SX.sym("slope", len(model.u))
        p, d = ca.SX.sym("p", len(model.p)), ca.SX.sym("d", len(model.d))
        x, z = sx[Kind.STATE], sx[Kind.ALGEBRAIC]
        # IDAS tests the mean error over all variables, of which only the states count.
        tight = tolerance * float(np.sqrt(max(len(model.x), 1) / (len(model.x) + len(model.z))))
        passed = tau * h
        ode, alg = model.dae.expand()(
            start + passed, x * model.x.nominals, z * model.z.nominals, u + slope * passed, p, d
        )
        self._f = ca.integrator(
            "idas",
            "idas",
            {
                "t": tau,
                "x": x,
                "z": z,
                "p": ca.vertcat(start, h, u, slope, p, d),
                "ode": h * ode / model.x.nominals,
                "alg": alg / model.r.nominals,
            },
            0.0,
            1.0,
            {
                "abstol": tight,
                "reltol": tight,
                # z is solved, not integrated: its error is that of Newton's method.
                "suppress_algebraic": True,
                "calc_ic": True,
                "linear_solver": "csparse",
                # A stretch between two events is short: try it in one step, the error test cuts it down.
                "step0": 1.0,
                "max_num_steps": 100_000,
                "disable_internal_warnings": True,
            },
        )
        solved = set(ca.jacobian_sparsity(ode, ca.vertcat(x, z)).row())
        self._commanded = [i for i in range(len(model.x)) if i not in solved]
        known = ca.densify(ode[self._commanded])
        # Simpson's rule: exact for rates up to the third power of time.
        ends = [ca.substitute(known, tau, at) for at in (0.0, 0.5, 1.0)]
        gain = h / 6.0 * (ends[0] + 4.0 * ends[1] + ends[2])
        self._gain = ca.Function("gain", [ca.vertcat(start, h, u, slope, p, d)], [gain])

    def advance(self, point: Point, h: float, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States and algebraic variables `h` seconds after a consistent point. Raises SimulationError."""
        m = self.model
        parameters = np.concatenate([[point.t, h], point.u, slope, point.p, point.d])
        try:
            end = self._f(x0=point.x / m.x.nominals, z0=point.z / m.z.nominals, p=parameters)
        except RuntimeError as error:
            reason = str(error).strip().splitlines()[-1]
            raise SimulationError(
                f"IDAS failed between t = {point.t:.9g} s and {point.t + h:.9g} s: {reason}",
                "Look at the last result: a rope gone slack or a load stuck shows there; or loosen the tolerance",
                point.t,
            ) from error
        x = end["xf"].full().ravel() * m.x.nominals
        if self._commanded:
            x[self._commanded] = point.x[self._commanded] + self._gain(parameters).full().ravel()
        return x, end["zf"].full().ravel() * m.z.nominals
