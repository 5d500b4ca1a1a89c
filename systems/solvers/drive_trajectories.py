"""Trajectories of drives that do not depend on the line.

While no limit is active, the motion of a drive does not depend on the tensions: its control cancels them. The states
alone are then a small system of equations, which IDAS solves over a whole window, across crossings, and the algebraic
variables follow section by section. Where all of them follow commands, they are known without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from ropeway.components.errors import SimulationError
from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import BUILDING, Model, kept_with_model
from ropeway.systems.modelling.equations import expanded
from ropeway.systems.solvers.block_newton import blocks_of
from ropeway.systems.solvers.idas import strict
from ropeway.systems.solvers.model_functions import Buffered
from ropeway.systems.solvers.points import VECTORS, Point
from ropeway.systems.solvers.prescribed_states import commanded_of

NODES = (1.0 - np.cos(np.pi * np.arange(13) / 12.0)) / 2.0
"""Chebyshev points on [0, 1]."""
_COUPLED = 1e-9
"""Least effect on a rate [per s] of an algebraic variable, changed by its nominal, that counts."""
WEIGHTS = (-1.0) ** np.arange(13) * np.where((np.arange(13) == 0) | (np.arange(13) == 12), 0.5, 1.0)
"""Weights of the barycentric formula at these points."""


def _derivative() -> np.ndarray:
    """Matrix of the derivatives, at the points, of the polynomial through values there."""
    with np.errstate(divide="ignore"):
        matrix = (WEIGHTS[None, :] / WEIGHTS[:, None]) / (NODES[:, None] - NODES[None, :])
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return matrix


DERIVATIVE = _derivative()
"""The derivatives, at these points, of the polynomial through values there."""


@dataclass(frozen=True)
class Window:
    """States over `h` seconds from `start` [s]: `values` (13, nx) at the Chebyshev points."""

    start: float
    h: float
    values: np.ndarray

    @cached_property
    def rates(self) -> np.ndarray:
        """Rates of the states at the Chebyshev points [per s]."""
        return np.asarray(DERIVATIVE @ self.values / self.h)

    @property
    def unresolved(self) -> np.ndarray:
        """Parts of the two highest polynomials in the states, (nx,): how far a polynomial may be from them."""
        parts = WEIGHTS[:, None] * (self.values - self.values[0])
        cosines = np.stack([np.ones(13), 2.0 * (1.0 - 2.0 * NODES)])
        return np.asarray(np.abs(cosines @ parts).sum(axis=0) / 12.0)

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """States and their rates at a time, by the polynomials through all points, shapes (nx,)."""
        distance = (time - self.start) / self.h - NODES
        near = int(np.argmin(np.abs(distance)))
        if abs(distance[near]) < 1e-14:
            return self.values[near].copy(), self.rates[near].copy()
        share = WEIGHTS / distance
        share /= share.sum()
        return share @ self.values, share @ self.rates


class Drives:
    """The states of a model alone; `tolerance` is absolute, on scaled variables."""

    def __init__(self, model: Model, tolerance: float) -> None:
        self.model = model
        nx, nu = len(model.x), len(model.u)
        sx = {kind: model.sym(kind.value, len(model.tables[kind])) for kind in VECTORS}
        time, start, h, tau = (model.sym(name) for name in ("t", "t0", "h", "tau"))
        ode, _ = expanded(model)(time, *(sx[kind] for kind in VECTORS))
        by_z = ca.jacobian(ode, sx[Kind.ALGEBRAIC])
        self.ties = by_z.nnz() > 0
        """Whether a limit can be active, so that a drive depends on the tensions."""
        if self.ties:
            inputs = [time, *(sx[kind] for kind in VECTORS)]
            scaled = by_z * ca.repmat(ca.DM(model.z.nominals).T, nx, 1)
            self._effects = inputs, np.array(scaled.nonzeros()), blocks_of(model).of[by_z.sparsity().get_col()]
            self._coupling = self._largest(np.ones(by_z.nnz(), dtype=bool))
            self._beside: dict[int, Buffered] = {}
        w, slope = model.sym("w", nx), model.sym("slope", nu)
        x0, rate = model.sym("x0", nx), model.sym("rate", nx)
        passed = tau * h
        rest = [sx[kind] for kind in (Kind.ALGEBRAIC, Kind.INPUT, Kind.PARAMETER, Kind.DISCRETE)]
        z, u, p, d = rest
        moving, _ = expanded(model)(
            start + passed, x0 + passed * rate + w * model.x.nominals, z, u + slope * passed, p, d
        )
        self._commanded = commanded_of(model)
        self._f: Buffered | None = None
        if nx > len(self._commanded.rows):  # those that follow commands are known
            dae = {
                "t": tau,
                "x": w,
                "p": ca.vertcat(start, h, x0, rate, slope, *rest),
                "ode": h * (moving - rate) / model.x.nominals,
            }
            options = {
                "abstol": strict(tolerance, 0.05),
                "reltol": 0.0,
                # The deviations and their rates begin at zero.
                "calc_ic": False,
                "linear_solver": "csparse",
                "step0": 0.003,
                "max_num_steps": 100_000,
                "disable_internal_warnings": True,
            }
            self._f = Buffered(ca.integrator("drives", "idas", dae, 0.0, NODES[1:].tolist(), options))

    def _largest(self, which: np.ndarray) -> Buffered:
        """The largest of some effects of algebraic variables on rates, as a function of a point."""
        inputs, effects, _ = self._effects
        return Buffered(ca.Function("coupling", inputs, [ca.norm_inf(ca.vertcat(0, *effects[which]))]))

    def _of_section(self, section: int) -> Buffered:
        """As `_largest`, of the algebraic variables of a section; made where it is asked for."""
        if section not in self._beside:
            with BUILDING:
                self._beside[section] = self._largest(self._effects[2] == section)
        return self._beside[section]

    def decoupled(self, point: Point, sections: Sequence[int] | None = None) -> bool:
        """Whether the rates of the states do not depend on the algebraic variables here, or on those of some
        sections."""
        if not self.ties:
            return True
        functions = [self._coupling] if sections is None else [self._of_section(section) for section in sections]
        return all(float(function(*point.arguments)[0][0]) < _COUPLED for function in functions)

    def alone(self, window: Window, point: Point, slope: np.ndarray, which: np.ndarray, z: np.ndarray) -> bool:
        """Whether no limit is active at some of the Chebyshev points of a window from a point; `z`: the algebraic
        variables there, (count, nz)."""
        if not self.ties:
            return True
        passed = NODES[which] * window.h
        u = point.u + np.outer(passed, slope)
        rows = zip((point.t + passed)[:, None], window.values[which], z, u, strict=True)
        return all(float(self._coupling(*row, point.p, point.d)[0][0]) < _COUPLED for row in rows)

    def window(self, point: Point, h: float, rate: np.ndarray, slope: np.ndarray) -> Window:
        """The states over `h` seconds from a point with the rates of the states there [per s].

        Raises SimulationError.
        """
        nominal = self.model.x.nominals
        line = point.x + np.outer(NODES * h, rate)
        if self._f is None:
            self._commanded.put(line[1:], point, NODES[1:] * h, slope)
            return Window(point.t, h, line)
        knowns = np.concatenate([[point.t, h], point.x, rate, slope, point.z, point.u, point.p, point.d])
        try:
            deviations = self._f(np.zeros(len(nominal)), np.zeros(0), knowns)[0]
        except RuntimeError as error:
            raise SimulationError(
                f"IDAS failed within the next {h:.9g} s: {str(error).splitlines()[-1]}",
                "Check the drives in the last result",
                point.t,
            ) from error
        line[1:] += deviations.reshape(len(NODES) - 1, len(nominal)) * nominal
        self._commanded.put(line[1:], point, NODES[1:] * h, slope)
        return Window(point.t, h, line)


@kept_with_model
def drives_of(model: Model, tolerance: float) -> Drives:
    """The drives of a model, made once."""
    return Drives(model, tolerance)
