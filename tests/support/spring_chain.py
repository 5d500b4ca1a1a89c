"""Natural frequencies of a rope as a chain of springs with lumped masses: an oracle without any catenary.

The energies of straight springs and masses are written down; the rest position is the minimum of the potential energy,
stiffness and mass are second derivatives. Over a pulley, rope passes from the last spring of one span to the first of
the next one.
"""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np
from scipy.sparse.linalg import eigsh, splu

import ropeway as rw


class SpringChain:
    """The first rope of an equilibrium with `springs` in each span. `masses`: of the pulleys that hang freely in the
    rope, by name [kg]; the other supports stand."""

    def __init__(
        self, eq: rw.Equilibrium, rope: rw.Rope, springs: int, masses: Mapping[str, float] | None = None
    ) -> None:
        self.eq, self.rope, self.springs, self.free = eq, rope, springs, dict(masses or {})
        self.unknowns: list[ca.SX] = []
        self.rates: list[ca.SX] = []
        self.start: list[float] = []
        self.potential, self.kinetic = ca.SX(0.0), ca.SX(0.0)
        run = eq.model.runs[0]
        supports = [self._support(node.name) for node in run.nodes]
        nothing = (ca.SX(0.0), ca.SX(0.0))
        travels = [nothing, *(self._unknown(f"travel_{k}", [0.0]) for k in range(1, len(run.nodes) - 1)), nothing]
        for k, span in enumerate(run.spans):
            self._span(span.name, supports[k : k + 2], travels[k : k + 2])

    def _unknown(self, name: str, start: list[float]) -> tuple[ca.SX, ca.SX]:
        """An unknown and its rate."""
        found = ca.SX.sym(name, len(start)), ca.SX.sym(f"{name}_rate", len(start))
        self.unknowns.append(found[0])
        self.rates.append(found[1])
        self.start += start
        return found

    def _support(self, name: str) -> tuple[ca.SX, ca.SX]:
        place = [self.eq[f"{name}.{axis}"] for axis in "xyz"]
        if name not in self.free:
            return ca.SX(place), ca.SX.zeros(3)
        place_and_velocity = self._unknown(name, place)
        self._mass(self.free[name], *place_and_velocity)
        return place_and_velocity

    def _mass(self, mass: float, place: ca.SX, velocity: ca.SX) -> None:
        self.kinetic += mass / 2.0 * ca.dot(velocity, velocity)
        self.potential += mass * self.eq.model.system.gravity * place[2]

    def _span(self, name: str, ends: list[tuple[ca.SX, ca.SX]], travels: list[tuple[ca.SX, ca.SX]]) -> None:
        loads = self.eq.loads[self.eq.loads["span"] == name]
        station = np.linspace(0.0, self.eq[f"{name}.length"], self.springs + 1)
        station = np.union1d(station, loads["distance"])
        curve = self.eq.profile(name, station)[["x", "y", "z"]].to_numpy()
        inner = [self._unknown(f"{name}_{i}", curve[i].tolist()) for i in range(1, len(station) - 1)]
        nodes = [ends[0], *inner, ends[1]]
        for distance, mass in zip(loads["distance"], loads["mass"], strict=True):
            self._mass(mass, *nodes[int(np.argmin(np.abs(station - distance)))])
        rests, last = np.diff(station), len(station) - 2
        stretched = np.diff(curve, axis=0) / rests[:, None]
        for i, rest in enumerate(rests.tolist()):
            own = rest + (travels[0][0] if i == 0 else 0.0) - (travels[1][0] if i == last else 0.0)
            apart = nodes[i + 1][0] - nodes[i][0]
            self.potential += self.rope.axial_stiffness / 2.0 * (ca.sqrt(ca.dot(apart, apart)) - own) ** 2 / own
            weight = self.rope.mass_per_length * self.eq.model.system.gravity
            self.potential += weight * own * (nodes[i][0][2] + nodes[i + 1][0][2]) / 2.0
            speeds = [nodes[i][1], nodes[i + 1][1]]
            if i == 0:
                speeds[0] = speeds[0] + ca.DM(stretched[0]) * travels[0][1]
            if i == last:
                speeds[1] = speeds[1] + ca.DM(stretched[-1]) * travels[1][1]
            for speed in speeds:
                self.kinetic += self.rope.mass_per_length * rest / 4.0 * ca.dot(speed, speed)

    def frequencies(self, count: int) -> np.ndarray:
        """The lowest frequencies [Hz], (count,)."""
        x, rate = ca.vertcat(*self.unknowns), ca.vertcat(*self.rates)
        stiffness, slope = ca.hessian(self.potential, x)
        derivatives = ca.Function("derivatives", [x], [stiffness, slope])
        rest = np.array(self.start)
        for _ in range(20):
            matrix, gradient = derivatives(rest)
            step = splu(matrix.sparse()).solve(np.asarray(gradient).ravel())
            rest = rest - step
            if np.abs(step).max() < 1e-10:
                break
        mass = ca.Function("mass", [rate], [ca.hessian(self.kinetic, rate)[0]])(np.zeros(len(rest))).sparse()
        found = eigsh(derivatives(rest)[0].sparse(), k=count, M=mass, sigma=0.0, v0=np.ones(len(rest)))[0]
        return np.sqrt(np.sort(found)) / (2.0 * np.pi)
