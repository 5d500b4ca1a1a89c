"""The ground under a line: a terrain profile along the line's axis in plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ropeway.components.annotation_checks import Numbers
from ropeway.components.clearance import Clearance, under_line
from ropeway.components.plan_axis import PlanAxis
from ropeway.components.terrain import Profile


@dataclass(frozen=True, eq=False)
class Ground:
    """A terrain `profile`, level across, along an `axis` in the plan of a line; without one its stations are x.

    `clearance`: least height of rope and loads over it [m] that the line has to keep, None where none is asked for.
    """

    profile: Profile
    axis: PlanAxis | None = None
    clearance: float | None = None

    def stations(self, x: Numbers, y: Numbers) -> np.ndarray:
        """Stations of the profile at places in plan [m]."""
        return np.asarray(x if self.axis is None else self.axis.locate(x, y)[0], dtype=float)

    def elevations(self, x: Numbers, y: Numbers) -> np.ndarray:
        """Elevations at places in plan [m], NaN beyond the profile's ends."""
        return self.profile.elevations(self.stations(x, y))

    def under(self, points: np.ndarray) -> Clearance:
        """Least height over the ground of a broken line through points (n, 3), and the station where it is [m]; exact
        over the vertices of the ground too. (inf, nan) where there is no ground below."""
        return under_line(self.profile, np.column_stack([self.stations(*points[:, :2].T), points[:, 2]]))
