"""An independent oracle for skylines: the cable equations integrated step by step (DOP853), none of the library's
closed forms. Along the unstretched length s, with f the tension vector and w the weight per unstretched metre,

    dx/ds = (1 + T/EA) fx/T,   dz/ds = (1 + T/EA) fz/T,   dfz/ds = w.

A skyline with a carriage has as unknowns the force at its start, how its length is shared out, and what holds the
carriage (positive towards the start). They are found by Newton's method with central differences, and checked to
1e-11.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

G = 9.80665


@dataclass(frozen=True)
class Cable:
    weight: float
    stiffness: float

    def run(self, start: np.ndarray, force: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
        """Position (x, z) and force (fx, fz) at the end of a piece."""

        def slope(_: float, y: np.ndarray) -> list[float]:
            tension = float(np.hypot(force[0], y[2]))
            stretch = (1.0 + tension / self.stiffness) / tension
            return [stretch * force[0], stretch * y[2], self.weight]

        end = solve_ivp(slope, (0.0, length), [*start, force[1]], method="DOP853", rtol=1e-13, atol=1e-10)
        return end.y[:2, -1], np.array([force[0], end.y[2, -1]])


@dataclass(frozen=True)
class Answer:
    """Height of the carriage, tensions on its two sides, at the start and the end of the skyline, holding force."""

    z: float
    left: float
    right: float
    start: float
    end: float
    holding: float


def carriage(
    cable: Cable,
    points: Sequence[tuple[float, float]],
    length: float,
    span: int,
    station: float,
    load: float,
    *,
    holding: str,
    z: float,
    tension: float,
) -> Answer:
    """A carriage with a load [N] at a station in one span of a skyline over frictionless saddles at `points`.

    holding: "horizontal", "bisector" (rolling) or "clamp" (no force but the clamp's). z, tension: a rough start."""
    at = [np.array(p, dtype=float) for p in points]
    nodes = [*at[: span + 1], np.array([station, z]), *at[span + 1 :]]
    n = len(nodes) - 1
    chord = [float(np.linalg.norm(b - a)) for a, b in pairwise(nodes)]

    # Each piece: force at its start (2) and its length; plus the carriage's height and what holds it.
    def unpack(u: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
        pieces = u[: 3 * n].reshape(n, 3)
        return pieces[:, :2] * tension, pieces[:, 2] * np.array(chord), u[-2] * 10.0, u[-1] * tension

    def solve(u: np.ndarray) -> tuple[np.ndarray, list[np.ndarray], float, float]:
        force, pieces, height, hold = unpack(u)
        ends, miss = [], []
        for k in range(n):
            start = np.array([station, height]) if k == span + 1 else nodes[k]
            goal = np.array([station, height]) if k == span else nodes[k + 1]
            there, last = cable.run(start, force[k], pieces[k])
            miss += list((there - goal) / 100.0)
            ends.append(last)
        for k in range(n - 1):
            left, right = np.linalg.norm(ends[k]), np.linalg.norm(force[k + 1])
            if k != span:
                miss.append((right - left) / tension)
                continue
            way = force[k + 1] / right + ends[k] / left
            if holding == "horizontal":
                way[1] = 0.0
            held = hold * way / np.linalg.norm(way) if holding != "clamp" else np.zeros(2)
            total = force[k + 1] - ends[k] - held - np.array([0.0, load])
            miss += list(total / load)
            miss.append(hold / tension if holding == "clamp" else (right - left) / tension)
        miss.append((pieces.sum() - length) / 100.0)
        return np.array(miss), [*force, *ends], height, hold

    def residual(u: np.ndarray) -> np.ndarray:
        return solve(u)[0]

    guess = []
    for k in range(n):
        d = (nodes[k + 1] - nodes[k]) / chord[k]
        guess += [d[0], d[1] - 0.5 * cable.weight * chord[k] / tension, length / sum(chord)]
    found = root(residual, np.array([*guess, z / 10.0, 0.0]), method="hybr", options={"xtol": 1e-15})
    u = found.x
    for _ in range(6):  # polish: a central difference is good to 1e-10, so each round gains that much
        jacobian = np.empty((len(u), len(u)))
        for j in range(len(u)):
            h = 1e-5
            up, down = u.copy(), u.copy()
            up[j] += h
            down[j] -= h
            jacobian[:, j] = (residual(up) - residual(down)) / (2.0 * h)
        u = u - np.linalg.solve(jacobian, residual(u))
        if np.abs(residual(u)).max() < 1e-12:
            break
    miss, forces, height, hold = solve(u)
    assert np.abs(miss).max() < 1e-11, "the oracle has not converged"
    t = [float(np.linalg.norm(f)) for f in forces]
    return Answer(height, t[n + span], t[span + 1], t[0], t[-1], hold)
