"""Check that a log hangs or drags as in the field: with its rear below or behind its front."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from ropeway.components.errors import EquilibriumError
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.rigs.turn import Turn
from ropeway.systems.solvers.points import Point

_BEHIND = 1e-6
"""Tolerance on the rear ahead of the front, relative to the log's length."""


class LogCheck:
    """Checks the points of one model of a rig with a log. With its rear on the ground a log can also stand upside down,
    or have its rear ahead of its front: unstable positions, to which Newton's method can converge."""

    def __init__(self, turn: Turn, ground: Profile | None, carriage: str, model: Model) -> None:
        self.turn, self.ground = turn, ground
        names = [f"{turn.log.name}.{v}" for v in ("x", "z", "rear_x", "rear_z", "normal")]
        self._log = np.array([model.z.index[name] for name in names])
        self._gap = model.y.index[f"{turn.log.name}.gap"]
        self._slope = model.y.index[f"{turn.log.name}.ground_slope"]
        k = model.z.index[f"{carriage}_{turn.log.name}.force_x"]
        self._line = np.arange(k, k + 3)

    def hangs(self, outputs: np.ndarray) -> bool:
        """Whether the log is off the ground."""
        return bool(outputs[self._gap] > 1e-7)

    def require(self, point: Point, outputs: np.ndarray) -> bool:
        """Raises EquilibriumError for a log upside down. Returns whether its position is unique: only a free log's is,
        as the rear can rest on several segments of the ground."""
        x, z, rear_x, rear_z, _ = (float(v) for v in point.z[self._log])
        log = self.turn.log
        if self.hangs(outputs):
            if rear_z >= z:
                raise EquilibriumError(f"{log.label} would be upside down", "Raise the carriage", log.name)
            return True
        slope = float(outputs[self._slope])
        trailing = -log.moving or (-1.0 if slope > 0.0 else 1.0)
        if trailing * (rear_x - x) < -_BEHIND * log.length:
            raise EquilibriumError(f"{log.label} would have its rear in front", "Raise the carriage", log.name)
        return False

    def gap(self, point: Point) -> float:
        """Height of the rear over the ground [m]."""
        _, _, rear_x, rear_z, _ = (float(v) for v in point.z[self._log])
        return rear_z - self.elevation(rear_x)

    def lay_down(self, point: Point, weight: float) -> None:
        """Initial guess of a dragging log of a weight [N], from a free one that reaches below the ground. The log
        swings out from the vertical until its rear first emerges from the ground."""
        log, front = self.turn.log, point.z[self._log[:2]]
        x, z = float(front[0]), float(front[1])
        side = -log.moving or (-1.0 if self.elevation(x + 0.1) > self.elevation(x - 0.1) else 1.0)

        def height(turn: float) -> float:
            return z - log.length * float(np.cos(turn)) - self.elevation(x + side * log.length * float(np.sin(turn)))

        turns = np.linspace(0.0, 0.9 * np.pi, 55)
        k = next((k for k, turn in enumerate(turns) if height(float(turn)) > 0.0), len(turns) - 1)
        turn = float(brentq(height, turns[k - 1], turns[k])) if k > 0 and height(float(turns[k])) > 0.0 else 0.5 * np.pi
        outward, downward = log.length * np.sin(turn), log.length * np.cos(turn)
        normal = log.centre * outward * weight / max(outward + log.friction * downward, 0.1 * log.length)
        point.z[self._log[2:]] = x + side * outward, z - downward, normal
        point.z[self._line] += (-side * log.friction * abs(log.moving) * normal, 0.0, normal)

    def elevation(self, x: float) -> float:
        """Elevation of the ground [m] in the log's equations, with rounded vertices."""
        if self.ground is None:
            return -np.inf
        at, z, before, after, room = self.ground.vertex_at(x)
        r = min(self.turn.log.rounding, room)
        away = abs(x - at)
        size = r * ((away / r) ** 2 + 1.0) / 2.0 if away < r else away
        return z + 0.5 * (before + after) * (x - at) + 0.5 * (after - before) * size
