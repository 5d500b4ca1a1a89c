"""Figure of a rig with its bare skyline, to scale or in 3-D. matplotlib is imported on use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ropeway.components.errors import InputError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.notebook_figure import new_figure
from ropeway.systems.rigs.bare_skyline import bare_profile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ropeway.systems.rigs.rig_parts import RigParts


def rig_figure(rig: RigParts, view: str) -> Figure:
    """Ground, spars, supports, guylines and the bare skyline (of a running skyline the chord). Raises
    InputError, EquilibriumError."""
    if view not in ("elevation", "3d"):
        raise InputError(f"There is no view {view!r}", 'Choose "elevation" or "3d"')
    flat = view == "elevation"
    figure = new_figure(figsize=(10.0, 4.8 if flat else 7.0), layout="constrained")
    axis: Any = figure.subplots(subplot_kw={} if flat else {"projection": "3d"})

    def line(x: Any, y: Any, z: Any, **style: Any) -> None:
        axis.plot(*((x, z) if flat else (x, y, z)), **style)

    if rig.terrain is not None:
        station, elevation = rig.terrain.station, rig.terrain.elevation
        line(station, np.zeros(len(station)), elevation, color="0.4", lw=1.2, label="ground")
    for node in rig.stands:
        x, y, z = node.at
        foot = z - 0.03 * np.ptp(rig.points[:, 0]) if rig.terrain is None else rig.terrain.elevation_at(x)
        line([x, x], [y, y], [foot, z], color="tab:brown", lw=2.6)
        axis.text(*((x, z) if flat else (x, y, z)), f" {node.label}", fontsize="small", va="bottom")
    for spar in (rig.headspar, rig.tailspar):
        for guy in spar.guylines if isinstance(spar, GuyedSpar) else ():
            line(*np.array([guy.at, spar.at]).T, color="0.45", lw=0.9)
    if rig.length is not None:
        line(*bare_profile(rig), color="black", lw=2.0, label="bare skyline")
    else:
        line(*rig.points.T, color="black", lw=1.2, ls="--", label="chord of the haulback")
    axis.set_xlabel("station [m]")
    if flat:
        axis.set_ylabel("elevation [m]")
        axis.set_aspect("equal", adjustable="datalim")
        axis.grid(alpha=0.3)
    else:
        axis.set_ylabel("sideways [m]")
        axis.set_zlabel("elevation [m]")
    axis.set_title(rig.name)
    axis.legend(fontsize="small")
    return figure
