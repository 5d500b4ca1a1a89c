"""Remarks of a payload study: stations where the carriage cannot be hauled, and a bare rope below the ground."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from ropeway.components.errors import EquilibriumError, InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.systems.reporting.style import Style
from ropeway.systems.rigs.bare_skyline import bare_profile
from ropeway.systems.rigs.rig_kind import STANDING
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.skyline.station_solver import Stations

_TOUCHING = 1e-3
"""Depth of a log that drags, by rounding, at most [m]."""


class BareRope(NamedTuple):
    """Point of the bare skyline nearest to the ground: station [m], and height over the ground [m], negative below."""

    station: float
    height: float


def bare_rope(rig: SkylineRig) -> BareRope | None:
    """Point of a rig's bare skyline nearest to the ground; None without a terrain or a separate skyline."""
    if not rig.kind.keeps_length or rig.terrain is None:
        return None
    x, _, z = bare_profile(rig)
    inside = (x >= rig.terrain.station[0]) & (x <= rig.terrain.station[-1])
    heights = z[inside] - rig.terrain.elevations(x[inside])
    k = int(np.argmin(heights))
    return BareRope(float(x[inside][k]), float(heights[k]))


def not_hauled(rig: SkylineRig, frame: pd.DataFrame) -> np.ndarray:
    """Stations [m] at which a rolling carriage needs a clamp, as its mainline would have to push."""
    if not rig.pulled or "held_by" not in frame:
        return np.zeros(0)
    return frame.loc[frame["held_by"] == "clamp", "station"].to_numpy(float)


def haulback_that_hauls(rig: SkylineRig, stations: np.ndarray, payload: float) -> float | None:
    """Least haulback tension [N], at most 2 percent too high, with which the mainline holds a payload [kg] at all given
    stations [m]. None if no tension within the rope's safe working load is enough."""
    rope = rig.haulback or rig.mainline
    if rope is None or not rig.kind.keeps_length or not len(stations):
        return None
    if isinstance(rig.tailspar, GuyedSpar) and rig.haulback_block is None:
        return None
    sample = stations[np.unique(np.linspace(0, len(stations) - 1, 12).astype(int))]

    def hauls(tension: float, where: np.ndarray) -> bool:
        solver = Stations(replace(rig, haulback=rope, haulback_tension=tension, kind=STANDING))
        try:
            return all(solver.solve(float(x), payload).held_by == "mainline" for x in where)
        except (EquilibriumError, InputError):
            return False

    low, high = rig.haulback_tension or 0.0, max(1.25 * (rig.haulback_tension or 0.0), 0.02 * rope.safe_working_load)
    while not hauls(high, sample):
        low, high = high, 1.5 * high
        if high > rope.safe_working_load:
            return None
    while high - low > 0.02 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if hauls(middle, sample) else (middle, high)
    while not hauls(high, stations):
        high *= 1.05
        if high > rope.safe_working_load:
            return None
    return high


def under_ground(frame: pd.DataFrame) -> pd.Series[float]:
    """Depths [m] of load or rope under the ground by station [m], where either is."""
    heights = frame[[name for name in ("clearance", "rope_clearance") if name in frame]]
    depths = -heights.min(axis=1).set_axis(frame["station"])
    return depths[depths > _TOUCHING]


def remarks(
    failed: np.ndarray,
    count: int,
    haulback: float | None,
    bare: BareRope | None,
    under: pd.Series[float],
    style: Style,
) -> list[str]:
    """Sentences for the headline, in a report's words and units."""
    found = []
    if len(failed):
        first, last = style.value(failed.min(), "length"), style.value(failed.max(), "length")
        values = {"failed": len(failed), "count": count, "first": first, "last": last}
        if haulback is None:
            found.append(style.text("not_hauled", **values))
        else:
            values["haulback"] = style.value(haulback, "force", "up")
            found.append(style.text("not_hauled_without", **values))
    if bare is not None and bare.height < 0.0:
        height, station = style.value(-bare.height, "length", "up"), style.value(bare.station, "length")
        found.append(style.text("bare_under_ground", height=height, station=station))
    if len(under):
        first, last = (style.value(under.index[k], "length") for k in (0, -1))
        depth = style.value(under.max(), "length", "up")
        found.append(style.text("under_ground", failed=len(under), count=count, first=first, last=last, depth=depth))
    return found
