"""Whether a log under a carriage hangs or drags as it does in the field: rear below its front, or behind it."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from ropeway.components.errors import EquilibriumError
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.rigs.turn import Turn
from ropeway.systems.solvers.newton import Point

_BEHIND = 1e-6
"""A log that leads its front by less than this part of its length stands upright."""


class LogCheck:
    """Checks the points of one model of a rig with a log. With the rear on the ground, a log can also stand on its
    head, or be pushed ahead of its front: unstable places, which Newton's method finds as well."""

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
        """Raises EquilibriumError for a log upside down. Returns whether it can be in no other place: it hangs free. On
        ground with vertices its rear can rest on more than one segment."""
        x, z, rear_x, rear_z, _ = (float(v) for v in point.z[self._log])
        log = self.turn.log
        if self.hangs(outputs):
            if rear_z >= z:
                raise EquilibriumError(f"{log.label} would stand on its head", "Give it more height", log.name)
            return True
        slope = float(outputs[self._slope])
        trailing = -log.moving or (-1.0 if slope > 0.0 else 1.0)
        if trailing * (rear_x - x) < -_BEHIND * log.length:
            raise EquilibriumError(f"{log.label} would be pushed ahead of its front", "Give it more height", log.name)
        return False

    def gap(self, point: Point) -> float:
        """Height of the rear over the ground [m]."""
        _, _, rear_x, rear_z, _ = (float(v) for v in point.z[self._log])
        return rear_z - self.elevation(rear_x)

    def lay_down(self, point: Point, weight: float) -> None:
        """From a log of a weight [N] that would hang below the ground, starting values of one that drags: its rear
        where, swung out from below the front, it comes out of the ground first."""
        log, front = self.turn.log, point.z[self._log[:2]]
        x, z = float(front[0]), float(front[1])
        side = -log.moving or (-1.0 if self.elevation(x + 0.1) > self.elevation(x - 0.1) else 1.0)

        def over(turn: float) -> float:
            return z - log.length * float(np.cos(turn)) - self.elevation(x + side * log.length * float(np.sin(turn)))

        turns = np.linspace(0.0, 0.9 * np.pi, 55)
        k = next((k for k, turn in enumerate(turns) if over(float(turn)) > 0.0), len(turns) - 1)
        turn = float(brentq(over, turns[k - 1], turns[k])) if k > 0 and over(float(turns[k])) > 0.0 else 0.5 * np.pi
        out, down = log.length * np.sin(turn), log.length * np.cos(turn)
        normal = log.centre * out * weight / max(out + log.friction * down, 0.1 * log.length)
        point.z[self._log[2:]] = x + side * out, z - down, normal
        point.z[self._line] += (-side * log.friction * abs(log.moving) * normal, 0.0, normal)

    def elevation(self, x: float) -> float:
        """The ground [m] that the log knows, its vertices rounded."""
        if self.ground is None:
            return -np.inf
        at, z, before, after, room = self.ground.vertex_at(x)
        r = min(self.turn.log.rounding, room)
        away = abs(x - at)
        size = r * ((away / r) ** 2 + 1.0) / 2.0 if away < r else away
        return z + 0.5 * (before + after) * (x - at) + 0.5 * (after - before) * size
