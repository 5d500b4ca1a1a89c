"""A line on its map: an inset of its picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ropeway.components.map_frame import MapFrame
from ropeway.systems.statics.equilibrium import Equilibrium

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SHORT = 20
"""Characters of a coordinate system's name that a title has room for; in WKT it has more."""


def draw_map(axis: Axes, line: Equilibrium, frame: MapFrame) -> None:
    """The ropes and supports of a line in map coordinates, north up."""
    from matplotlib.ticker import MaxNLocator

    for r, run in enumerate(line.runs):
        east, north = (np.asarray(v) for v in frame.to_map(*line.points(r)[:, :2].T))
        axis.plot(east, north, color="tab:blue", lw=1.4, marker="o", ms=3, mfc="0.35", mec="0.35")
        for k in (0, len(run.nodes) - 1):
            axis.annotate(
                run.nodes[k].label, (east[k], north[k]), xytext=(4, 4), textcoords="offset points", fontsize=7
            )
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.2)
    for side in (axis.xaxis, axis.yaxis):
        side.set_major_locator(MaxNLocator(3))
        side.set_major_formatter("{x:.0f}")
    axis.tick_params(labelsize=7)
    axis.tick_params(axis="y", labelrotation=90)
    axis.annotate("N", (0.9, 0.9), (0.9, 0.98), "axes fraction", ha="center", va="top", arrowprops={"arrowstyle": "<-"})
    system = frame.crs if 0 < len(frame.crs) < _SHORT else "map"
    axis.set_title(f"{system}\nazimuth {frame.azimuth:.1f}°", fontsize="small")
    axis.grid(alpha=0.3)
