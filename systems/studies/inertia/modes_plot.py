"""Picture of a mode: the ropes at rest, and displaced to both sides."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from scipy.interpolate import Akima1DInterpolator

from ropeway.components.notebook_figure import new_figure
from ropeway.systems.statics.equilibrium import Equilibrium

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LARGEST = 0.04
"""Largest displacement in the picture, as a part of the length of the line."""
_SEEN = 0.02
"""Smallest part of the largest displacement for which the plan is drawn."""
_STATIONS = 61


def mode_figure(line: Equilibrium, points: pd.DataFrame, shape: np.ndarray, title: str) -> Figure:
    """Elevation of a mode, and the plan where it moves sideways. `shape` (points, 3)."""
    place = points[["x", "y", "z"]].to_numpy()
    forth = _direction(place)
    side = np.array([-forth[1], forth[0], 0.0])
    views = [(forth, np.array([0.0, 0.0, 1.0]), "height [m]")]
    if np.abs(shape @ side).max(initial=0.0) > _SEEN or np.ptp(place @ side) > _SEEN * np.ptp(place @ forth):
        views.append((forth, side, "sideways [m]"))
    scale = _LARGEST * max(np.ptp(place @ forth), np.ptp(place[:, 2]))
    figure = new_figure(figsize=(11.0, 3.6 * len(views)), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(views), 1, sharex=True))
    for axis, (across, up, label) in zip(axes, views, strict=True):
        for name, own in points.groupby("span", sort=False):
            _draw(axis, line, str(name), own, scale * shape[own.index], (across, up))
        loads = points[points["point"].isin(line.loads["load"])]
        moved = loads[["x", "y", "z"]].to_numpy() + scale * shape[loads.index]
        axis.plot(moved @ across, moved @ up, "o", ms=5, color="tab:green")
        axis.set_ylabel(label)
        axis.grid(alpha=0.3)
    axes[-1].set_xlabel("horizontal distance [m]")
    figure.suptitle(f"{title} (displacement exaggerated)")
    return figure


def _direction(place: np.ndarray) -> np.ndarray:
    """Horizontal unit vector from the first point to the farthest one in plan."""
    flat = place * (1.0, 1.0, 0.0)
    apart = flat[int(np.argmax(np.linalg.norm(flat - flat[0], axis=1)))] - flat[0]
    length = float(np.linalg.norm(apart))
    return apart / length if length > 0.0 else np.array([1.0, 0.0, 0.0])


def _draw(
    axis: Axes,
    line: Equilibrium,
    span: str,
    points: pd.DataFrame,
    moved: np.ndarray,
    view: tuple[np.ndarray, np.ndarray],
) -> None:
    """One span at rest and displaced, and its ends."""
    station, loaded = points["station"].to_numpy(), points["point"].isin(line.loads["load"]).to_numpy()
    curve = line.profile(span, np.union1d(np.linspace(0.0, station[-1], _STATIONS), station))
    rest, away = curve[["x", "y", "z"]].to_numpy(), np.zeros((len(curve), 3))
    kinks = [0, *np.flatnonzero(loaded[1:-1]) + 1, len(station) - 1]
    for first, last in pairwise(kinks):
        own = curve["station"].between(station[first], station[last]).to_numpy()
        smooth = Akima1DInterpolator(station[first : last + 1], moved[first : last + 1])
        away[own] = smooth(curve["station"][own])
    across, up = view
    axis.plot(rest @ across, rest @ up, color="0.6", lw=1.0)
    axis.plot((rest + away) @ across, (rest + away) @ up, color="tab:blue", lw=1.6)
    axis.plot((rest - away) @ across, (rest - away) @ up, color="tab:blue", lw=0.8, ls="--", alpha=0.6)
    ends = points[["x", "y", "z"]].to_numpy()[[0, -1]]
    axis.plot(ends @ across, ends @ up, "^", ms=5, color="0.35")
