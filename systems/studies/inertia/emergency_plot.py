"""Picture of emergency stops: tension over time, and peaks, stopping distance and swing by deceleration."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
import pandas as pd

from ropeway.components.notebook_figure import new_figure
from ropeway.systems.dynamics.result import Result
from ropeway.systems.results.limit_lines import ABOVE, draw_limits, limits_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def stops_figure(frame: pd.DataFrame, results: Sequence[Result]) -> Figure:
    """The highest tension of all spans in each run, and three panels by deceleration."""
    figure = new_figure(figsize=(12.0, 6.4), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=[1.7, 1.0])
    time = figure.add_subplot(grid[:, 0])
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(results)))
    for a, result, colour in zip(frame.index, results, colours, strict=True):
        ends = result.full_frame.filter(regex=r"\.tension_[ab]$").max(axis=1) / 1e3
        time.plot(ends.index, ends, color=colour, lw=1.3, label=f"{a:g} m/s²")
    rope = next((run.rope for result in results for run in result.runs), None)
    if rope is not None:
        draw_limits(time, [(float(frame["highest_tension"].max()), limits_of(rope))])
    time.set(xlabel="time since the stop [s]", ylabel="highest tension [kN]")
    time.legend(ncols=4, fontsize="small", **ABOVE)
    time.grid(alpha=0.3)
    time.set_xlim(0.0)
    panels = [figure.add_subplot(grid[i, 1]) for i in range(3)]
    _by_deceleration(panels[0], frame, ("highest_tension", 1e-3), "highest tension [kN]")
    _by_deceleration(panels[1], frame, ("stopping_distance", 1.0), "stopping distance [m]")
    _by_deceleration(panels[2], frame, ("swing", 1.0), "swing of a load [m]")
    panels[-1].set_xlabel("deceleration [m/s²]")
    name = results[0].model.name if results else ""
    figure.suptitle(f"{name}: emergency stops")
    return figure


def _by_deceleration(axis: Axes, frame: pd.DataFrame, column: tuple[str, float], label: str) -> None:
    name, scale = column
    values = frame[name] * scale
    axis.plot(frame.index, values, "o-", color="tab:blue", ms=4, lw=1.2)
    slack = frame["slack"].to_numpy(dtype=bool)
    axis.plot(frame.index[slack], values[slack], "x", color="tab:red", ms=8, label="a rope goes slack")
    if slack.any():
        axis.legend(fontsize="small")
    axis.set_ylabel(label)
    axis.set_ylim(0.0 if name != "highest_tension" else None)
    axis.grid(alpha=0.3)
