"""Picture of a line at one time: elevation, tension along the rope, plan. matplotlib is imported when it is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd

from ropeway.components.node import Node
from ropeway.components.notebook_figure import new_figure
from ropeway.components.rope import Rope
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.results.limit_lines import ABOVE, draw_limits, limits_of
from ropeway.systems.results.line_map import draw_map
from ropeway.systems.statics.equilibrium import Equilibrium

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class _Mark(NamedTuple):
    """How supports of a role are drawn."""

    marker: str
    colour: str


_MARKS = {
    "control sheave": _Mark("s", "tab:red"),
    "idler sheave": _Mark("o", "0.35"),
    "drum": _Mark("D", "tab:purple"),
    "anchor": _Mark("^", "tab:brown"),
}
_OTHER = _Mark("P", "tab:pink")

_UPRIGHT = 12
"""Supports with names written level: those of more overlap, and stand upright."""
_NAMED = 60
"""Supports with a name each: of more the idlers have none."""
_CURVE = 60
"""Points of a span's curve."""
_GROUND = 500
"""Points of the ground."""


class _Way(NamedTuple):
    """A rope's way: distance of each support along the line, direction of a straight line, supports in plan [m]."""

    along: np.ndarray
    direction: np.ndarray
    flat: np.ndarray

    def sideways(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Distance of points to the left of the straight line [m]."""
        u, v = self.direction
        return np.asarray(u * (y - self.flat[0, 1]) - v * (x - self.flat[0, 0]))


def line_profile(line: Equilibrium, ground: Profile | None = None) -> Figure:
    """Elevation with rope, loads and supports (and the ground, where it is known), tension along the rope, the plan
    where supports do not stand in one line or wind blows ropes aside, and the map where the line lies on one, of a line
    at one time. `ground`: over the horizontal distance along the line, by default that of its system."""
    ways = [_way(line.points(r)) for r in range(len(line.runs))]
    curves = {span.name: line.profile(span.name, _CURVE) for run in line.runs for span in run.spans}
    plan_needed = any(np.ptp(w.sideways(*line.points(r)[:, :2].T)) > 1e-3 for r, w in enumerate(ways))
    if line.model.weather and not plan_needed:
        apart = [
            w.sideways(curves[s.name]["x"], curves[s.name]["y"])
            for w, run in zip(ways, line.runs, strict=True)
            for s in run.spans
        ]
        plan_needed = bool(np.abs(np.concatenate(apart)).max() > 1e-3)
    heights = [2.4, 1.3, 0.9] if plan_needed else [2.4, 1.3]
    frame = line.model.system.map_frame
    figure = new_figure(figsize=(11.0 if frame is None else 13.5, 2.0 * sum(heights)), layout="constrained")
    columns = [1.0] if frame is None else [4.4, 1.0]
    grid = figure.add_gridspec(len(heights), len(columns), height_ratios=heights, width_ratios=columns)
    elevation = figure.add_subplot(grid[0, 0])
    tension, *rest = (figure.add_subplot(grid[i, 0], sharex=elevation) for i in range(1, len(heights)))
    for axis in (elevation, tension, *rest)[:-1]:
        axis.tick_params(labelbottom=False)
    if frame is not None:
        draw_map(figure.add_subplot(grid[:, 1]), line, frame)
    plan = rest[0] if rest else None
    level = _level(line, max(ways, key=lambda way: way.along[-1]), ground)
    if level is not None:
        elevation.plot(*level, color="0.4", lw=1.2, label="ground")
    highest, names, named = dict[Rope, float](), dict[Rope, str](), set[str]()
    for r, (run, way) in enumerate(zip(line.runs, ways, strict=True)):
        points = line.points(r)
        _loads(elevation, plan, line, run, way, points)
        for k, span in enumerate(run.spans):
            curve = curves[span.name]
            x = way.along[k] + np.hypot(curve["x"] - points[k, 0], curve["y"] - points[k, 1])
            elevation.plot(x, curve["z"], color="tab:blue", lw=1.4, zorder=3)
            tension.plot(x, curve["tension"] / 1e3, color="tab:blue", lw=1.4)
            highest[span.rope] = max(highest.get(span.rope, 0.0), float(curve["tension"].max()))
            names.setdefault(span.rope, run.name)
            if plan is not None:
                plan.plot(x, way.sideways(curve["x"].to_numpy(), curve["y"].to_numpy()), color="tab:blue", lw=1.2)
        _supports(elevation, plan, run.nodes, way, points, level, named)
        for x in way.along:
            for axis in (tension, *rest):
                axis.axvline(x, color="0.85", lw=0.8, zorder=0)
    several = len(names) > 1
    draw_limits(tension, [(most, limits_of(rope, names[rope] if several else "")) for rope, most in highest.items()])
    elevation.set_ylabel("height [m]")
    elevation.legend(ncols=7, fontsize="small", **ABOVE)
    elevation.margins(x=0.02, y=0.14)
    elevation.set_xlim(elevation.get_xlim())
    if level is not None:
        low = elevation.get_ylim()[0]
        elevation.fill_between(*level, low, color="0.88", lw=0, zorder=0)
        elevation.set_ylim(bottom=low)
    tension.set_ylabel("tension [kN]")
    tension.legend(ncols=4, fontsize="small", **ABOVE)
    if plan is not None:
        plan.set_ylabel("sideways [m]")
    (rest or [tension])[-1].set_xlabel("horizontal distance along the line [m]")
    for axis in (elevation, tension, *rest):
        axis.grid(axis="y", alpha=0.3)
    figure.suptitle(f"{line.model.name} at t = {line.point.t:g} s")
    figure.draw_without_rendering()
    box = elevation.get_window_extent()
    scale = (np.ptp(elevation.get_xlim()) / box.width) / (np.ptp(elevation.get_ylim()) / box.height)
    figure.suptitle(f"{line.model.name} at t = {line.point.t:g} s (heights {scale:.1f} times exaggerated)")
    return figure


def _way(points: np.ndarray) -> _Way:
    """The way of a rope over supports (n, 3); straight is from the first to the one farthest from it in plan."""
    flat = points[:, :2]
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(flat, axis=0).T))])
    apart = flat[int(np.argmax(np.hypot(*(flat - flat[0]).T)))] - flat[0]
    length = float(np.hypot(*apart))
    return _Way(along, apart / length if length > 0.0 else np.array([1.0, 0.0]), flat)


def _level(line: Equilibrium, way: _Way, ground: Profile | None) -> tuple[np.ndarray, np.ndarray] | None:
    """The ground along a way: distances and elevations [m]; None where it is unknown. Raises InputError for a ground
    that ends before the line."""
    under = line.model.system.ground
    station = np.union1d(np.linspace(0.0, float(way.along[-1]), _GROUND), way.along)
    if ground is not None:
        return station, np.array([ground.elevation_at(float(x)) for x in station])
    if under is None:
        return None
    return station, under.elevations(*(np.interp(station, way.along, way.flat[:, i]) for i in (0, 1)))


def _loads(elevation: Axes, plan: Axes | None, line: Equilibrium, run: Run, way: _Way, points: np.ndarray) -> None:
    """Loads, under the rope's line and the smaller the more there are."""
    loads: pd.DataFrame = line.loads[line.loads["span"].isin([s.name for s in run.spans])]
    loads = loads[loads["mass"] > 0.0]
    if loads.empty:
        return
    k = loads["span"].map({s.name: i for i, s in enumerate(run.spans)}).to_numpy(dtype=int)
    x = way.along[k] + np.hypot(loads["x"] - points[k, 0], loads["y"] - points[k, 1])
    size = float(np.clip(500.0 / len(loads), 7.0, 40.0))
    sizes = size * (0.4 + 0.6 * loads["mass"] / loads["mass"].max())
    lightest, heaviest = loads["mass"].min(), loads["mass"].max()
    masses = f"{heaviest:g} kg" if lightest == heaviest else f"{lightest:g} to {heaviest:g} kg"
    label = f"{len(loads)} load{'s' if len(loads) > 1 else ''}, {masses}"
    elevation.scatter(x, loads["z"], s=sizes, color="tab:green", zorder=2, label=label, marker="o", lw=0)
    if plan is not None:
        sideways = way.sideways(loads["x"].to_numpy(), loads["y"].to_numpy())
        plan.scatter(x, sideways, s=size, color="tab:green", zorder=1, lw=0)


def _supports(
    elevation: Axes,
    plan: Axes | None,
    nodes: Sequence[Node],
    way: _Way,
    points: np.ndarray,
    level: tuple[np.ndarray, np.ndarray] | None,
    named: set[str],
) -> None:
    """Supports with their names; on the ground, where it is known, else with a guide to the panels below."""
    names: dict[str, Any] = {"rotation": 90, "fontsize": 7} if len(nodes) > _UPRIGHT else {"fontsize": "small"}
    for k, node in enumerate(nodes):
        mark = _MARKS.get(node.role, _OTHER)
        style: dict[str, Any] = {"color": mark.colour, "marker": mark.marker, "ls": "", "ms": 5, "zorder": 4}
        x, z = way.along[k], points[k, 2]
        elevation.plot(x, z, label=None if node.role in named else node.role, **style)
        named.add(node.role)
        if level is None:
            elevation.axvline(x, color="0.85", lw=0.8, zorder=0)
        else:
            elevation.plot(
                [x, x], [np.interp(x, *level), z], color="tab:brown", lw=2.0, zorder=1, solid_capstyle="butt"
            )
        if plan is not None:
            plan.plot(x, way.sideways(points[k, 0], points[k, 1]), **style)
        if len(nodes) <= _NAMED or node.role != "idler sheave":
            elevation.annotate(
                node.label, (x, z), xytext=(0, 7), textcoords="offset points", ha="center", color=mark.colour, **names
            )
