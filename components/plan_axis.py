"""The axis of a line in plan: a broken line with stations, and places beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ropeway.components.annotation_checks import Numbers
from ropeway.components.errors import InputError


@dataclass(frozen=True)
class PlanAxis:
    """A broken line in plan through points `x`, `y`, at increasing stations `station` [m on the ground].

    Beyond its ends the outermost segments go on. A place has a station along it and an offset to its left [m]. `x` and
    `y` can have a scale of their own, as coordinates of a map do. Raises InputError.
    """

    station: tuple[float, ...]
    x: tuple[float, ...]
    y: tuple[float, ...]

    def __post_init__(self) -> None:
        if not len(self.station) == len(self.x) == len(self.y) >= 2:
            sizes = f"{len(self.station)} stations, {len(self.x)} x and {len(self.y)} y"
            raise InputError(f"An axis has {sizes}", "Give as many of each, at least two")
        steps = np.diff([self.station, self.x, self.y])
        wrong = (steps[0] <= 0.0) | (np.hypot(steps[1], steps[2]) == 0.0)
        if np.any(wrong):
            k = int(np.argmax(wrong))
            raise InputError(
                f"An axis does not go on from station {self.station[k]:g} m to {self.station[k + 1]:g} m",
                "Give increasing stations, and different points",
            )

    def place(self, station: Numbers, offset: Numbers = 0.0) -> tuple[Numbers, Numbers]:
        """x and y at stations [m] and offsets to the left [m]."""
        s, x, y = (np.array(v) for v in (self.station, self.x, self.y))
        k = np.clip(np.searchsorted(s, station, side="right") - 1, 0, len(s) - 2)
        along = np.asarray(station) - s[k]
        run = s[k + 1] - s[k]
        dx, dy = (x[k + 1] - x[k]) / run, (y[k + 1] - y[k]) / run
        return x[k] + along * dx - np.asarray(offset) * dy, y[k] + along * dy + np.asarray(offset) * dx

    def locate(self, x: Numbers, y: Numbers) -> tuple[Numbers, Numbers]:
        """Station and offset to the left [m] of places, by the segment that is nearest."""
        s, ax, ay = (np.array(v) for v in (self.station, self.x, self.y))
        run, dx, dy = np.diff(s), np.diff(ax), np.diff(ay)
        square = dx**2 + dy**2
        px, py = np.broadcast_arrays(x, y)
        rx, ry = px[..., None] - ax[:-1], py[..., None] - ay[:-1]
        share = (rx * dx + ry * dy) / square
        low, high = np.zeros(len(run)), np.ones(len(run))
        low[0], high[-1] = -np.inf, np.inf
        inside = np.clip(share, low, high)
        k = np.argmin((rx - inside * dx) ** 2 + (ry - inside * dy) ** 2, axis=-1)[..., None]
        found = s[:-1] + inside * run, (dx * ry - dy * rx) * run / square
        station, offset = (np.take_along_axis(np.broadcast_to(v, rx.shape), k, axis=-1)[..., 0] for v in found)
        return station, offset
