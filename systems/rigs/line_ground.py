"""The ground under a line of supports."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.errors import InputError
from ropeway.components.ground import Ground
from ropeway.components.map_frame import MapFrame
from ropeway.components.plan_axis import PlanAxis
from ropeway.components.terrain import Profile


def ground_under(
    table: pd.DataFrame, terrain: Profile | None, map_frame: MapFrame | None, clearance: float | None
) -> Ground | None:
    """The terrain under the supports of a table, along the line [of an endless one as far as its return]; or, where
    both lie on one map, where the terrain lies there. Raises InputError for supports beyond or below it."""
    if clearance is not None:
        check.number(clearance, "The line", "clearance", "m")
        if terrain is None:
            raise InputError("The line has no terrain to clear", "Give it a Profile, or leave clearance out")
    if terrain is None:
        return None
    at = table[["x", "y", "z"]].to_numpy(dtype=float)
    if map_frame is not None and terrain.map_frame is not None:
        axis = _on_the_map(map_frame, terrain.map_frame)
    else:
        returns = np.flatnonzero(table["kind"] == "return")
        axis = _along(at[: returns[0] + 1 if len(returns) else len(at), :2])
    ground = Ground(terrain, axis, clearance)
    station, level = ground.stations(at[:, 0], at[:, 1]), ground.elevations(at[:, 0], at[:, 1])
    first, last = terrain.station[[0, -1]]
    for label, s, z, elevation in zip(table["label"], station, at[:, 2], level, strict=True):
        if np.isnan(elevation):
            raise InputError(
                f"Support {label!r} at station {s:.6g} m is outside the terrain, {first:.6g} to {last:.6g} m",
                "Give a longer Profile, over the horizontal distance along the line",
            )
        if z < elevation:
            raise InputError(
                f"Support {label!r} at z = {z:.6g} m lies below the ground, {elevation:.6g} m at station {s:.6g} m",
                "Raise it, or check the heights of both",
            )
    return ground


def _on_the_map(line: MapFrame, terrain: MapFrame) -> PlanAxis:
    """The axis of a terrain in the plan of a line. Raises InputError where they are on different maps."""
    if line.crs and terrain.crs and line.crs != terrain.crs:
        raise InputError(f"The line is in {line.crs}, its terrain in {terrain.crs}", "Give both in one of them")
    x, y = (tuple(np.asarray(v).tolist()) for v in line.to_local(np.array(terrain.axis.x), np.array(terrain.axis.y)))
    return PlanAxis(terrain.axis.station, x, y)


def _along(way: np.ndarray) -> PlanAxis:
    """The axis over supports in plan (n, 2)."""
    way = way[np.concatenate([[True], np.any(np.diff(way, axis=0) != 0.0, axis=1)])]
    if len(way) < 2:
        raise InputError("All supports of the line stand at one point of the plan", "Leave its terrain out")
    station = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    return PlanAxis(*(tuple(v.tolist()) for v in (station, *way.T)))
