"""A load-free piece of rope in a corridor."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ropeway.components.catenary import Strain, Uniform, Vector, Weight, end_of, segment


class Piece(NamedTuple):
    """A load-free piece of rope in a corridor, towards increasing x.

    Its start (x, z) [m], tension vector there [N], weight [N/m] or a `Uniform` force, unstretched length [m] and
    strain law.
    """

    start: tuple[float, float]
    force: Vector
    weight: Weight
    length: float
    strain: Strain

    def distances(self, x: np.ndarray, total: float) -> np.ndarray:
        """Unstretched distances from the start at which the piece passes x; `total` is its reach.

        Newton's method, limited to the piece.
        """
        fx, fy, v0 = self.force
        flat, wanted = math.hypot(fx, fy), x - self.start[0]
        share = np.clip(wanted / total, 0.0, 1.0)
        if isinstance(self.weight, Uniform):
            d = share * self.length
        else:  # exact without stretch: linear in asinh(v / h)
            first, last = (math.asinh(v / flat) for v in (v0, v0 + self.weight * self.length))
            d = (flat * np.sinh(first + share * (last - first)) - v0) / self.weight
            d = np.clip(d, 0.0, self.length)
        for _ in range(50):
            reach = segment((fx, fy, v0), self.weight, d, self.strain).reach[0]
            here = end_of(self.force, self.weight, d)
            tension = np.hypot(np.hypot(here[0], here[1]), here[2])
            rate = self.strain.expanded(here[0] / tension) + here[0] * (self.strain.c1 + self.strain.c2 * tension)
            move = (wanted - reach) / rate
            d = np.clip(d + move, 0.0, self.length)
            # Convergence is quadratic: after a step of 1e-8 only rounding errors are left.
            if np.abs(move).max(initial=0.0) <= 1e-8 * (1.0 + abs(total)):
                break
        return d
