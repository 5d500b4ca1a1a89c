"""Figure of a skyline's payloads: corridor to scale, payloads and tensions. matplotlib is imported on use."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from ropeway.components import catenary
from ropeway.components.errors import EquilibriumError
from ropeway.components.notebook_figure import new_figure
from ropeway.components.rounding import at_most
from ropeway.systems.results.limit_lines import ABOVE, LimitLine, draw_limits
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.statics.line_state import span_rope
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.load_path import load_path
from ropeway.systems.studies.skyline.station_row import station_row
from ropeway.systems.studies.skyline.station_solver import Stations

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ropeway.systems.studies.skyline.payload.data import PayloadData


class CarriagePath(NamedTuple):
    """A load path to draw."""

    path: pd.DataFrame
    colour: str
    label: str


_COLOURS = ("tab:blue", "tab:orange", "tab:purple", "tab:olive", "tab:pink", "tab:cyan", "tab:brown")
_ROPES = {"mainline": "tab:red", "haulback": "tab:blue", "dropline": "tab:green"}


def corridor(axis: Axes, rig: SkylineRig, paths: Sequence[CarriagePath], shown: Solved | None = None) -> None:
    """The corridor to scale: ground, spars, paths of the carriage, and the ropes with the carriage at one place."""
    (x0, x1), (low, high) = _extent(rig, paths)
    if rig.terrain is not None:
        ground = rig.terrain
        axis.fill_between(ground.station, ground.elevation, low, color="0.86", lw=0)
        axis.plot(ground.station, ground.elevation, color="0.35", lw=1.3)
    for node in rig.stands:
        x, _, z = node.at
        foot = rig.terrain.elevation_at(x) if rig.terrain is not None else z - 0.03 * (x1 - x0)
        axis.plot([x, x], [foot, z], color="tab:brown", lw=2.6, solid_capstyle="butt")
        axis.annotate(node.name, (x, z), xytext=(0, 5), textcoords="offset points", ha="center", fontsize="small")
    for drawn in paths:
        for _, part in drawn.path.dropna(subset=["carriage_z"]).groupby("span"):
            axis.plot(part["carriage_x"], part["carriage_z"], color=drawn.colour, lw=1.1, ls="--", zorder=2)
            if rig.carriage.depth > 0.0 and drawn is paths[-1]:
                lowest = part["carriage_z"] - rig.carriage.depth
                axis.plot(part["carriage_x"], lowest, color=drawn.colour, lw=0.8, ls=":", zorder=2)
        axis.plot([], [], color=drawn.colour, lw=1.1, ls="--", label=drawn.label)
    if rig.carriage.depth > 0.0 and paths:
        axis.plot([], [], color=paths[-1].colour, lw=0.8, ls=":", label="lowest point of the load")
    if shown is not None:
        _ropes(axis, shown)
    axis.set_xlim(x0, x1)
    axis.set_ylim(low, high)
    axis.set_aspect("equal", adjustable="box")
    axis.set_ylabel("elevation [m]")
    axis.grid(alpha=0.25)
    if axis.get_legend_handles_labels()[0]:
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.06), ncols=6, fontsize="small", frameon=False)


def _extent(rig: SkylineRig, paths: Sequence[CarriagePath]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Axis limits of a corridor: (x, x), (z, z)."""
    x = rig.points[:, 0]
    width = float(x.max() - x.min())
    heights = [*rig.points[:, 2], *(float(z) for drawn in paths for z in drawn.path["carriage_z"].dropna())]
    if rig.terrain is not None:
        near = (rig.terrain.station > x.min() - 0.03 * width) & (rig.terrain.station < x.max() + 0.03 * width)
        heights += list(rig.terrain.elevation[near])
    low, high = min(heights) - 0.03 * width, max(heights) + 0.05 * width
    return (float(x.min()) - 0.03 * width, float(x.max()) + 0.03 * width), (low, high)


def _ropes(axis: Axes, shown: Solved) -> None:
    rig, model = shown.at.rig, shown.at.model
    named: set[str] = set()
    for r, run in enumerate(model.runs):
        sky, role = r == shown.at.skyline, shown.at.roles[r]
        colour, width = ("black", 2.2) if sky else (_ROPES.get(role, "0.45"), 1.0)
        name = rig.kind.carrying_rope if sky else role or "guylines"
        for k in range(len(run.spans)):
            points = _curve(shown, r, k)
            label = None if name in named else name
            axis.plot(points[:, 0], points[:, 2], color=colour, lw=width, label=label)
            named.add(name)
    name = rig.carriage.name
    x, z = shown[f"{name}.x"], shown[f"{name}.z"]
    axis.plot([x], [z], "s", color="black", ms=6, zorder=5)
    if rig.carriage.depth > 0.0:
        axis.plot([x, x], [z, z - rig.carriage.depth], color="black", lw=2.5, zorder=5)
    if rig.turn is not None:
        front, rear = ([shown[f"{rig.turn.log.name}.{end}{axis}"] for axis in "xz"] for end in ("", "rear_"))
        axis.plot(*zip(front, rear, strict=True), color="tab:brown", lw=3.5, solid_capstyle="butt", label="log")


def _sideways(axis: Axes, rig: SkylineRig, paths: Sequence[CarriagePath], shown: Solved | None) -> None:
    """Ropes and paths of the carriage in plan, where wind blows them aside."""
    if shown is not None:
        for r, run in enumerate(shown.at.model.runs):
            colour = "black" if r == shown.at.skyline else _ROPES.get(shown.at.roles[r], "0.45")
            for k in range(len(run.spans)):
                points = _curve(shown, r, k)
                axis.plot(points[:, 0], points[:, 1], color=colour, lw=1.2)
    for drawn in paths:
        axis.plot(drawn.path["carriage_x"], drawn.path["carriage_y"], color=drawn.colour, lw=1.2, ls="--")
    axis.plot(*rig.points[: rig.spans + 1, :2].T, "^", color="tab:brown", ms=5)
    axis.set_ylabel("sideways [m]")
    axis.grid(alpha=0.3)


def _curve(shown: Solved, r: int, k: int) -> np.ndarray:
    """Points of the rope in span k of run r, (n, 3) [m]."""
    model, run = shown.at.model, shown.at.model.runs[r]
    length = shown[f"{run.spans[k].name}.length"]
    rope, stations = span_rope(model, run, k, shown.__getitem__), np.linspace(0.0, length, 60)
    curve = catenary.profile(shown.at.curve(shown.point, k, r), *rope, length, (), (), stations)
    return np.asarray(shown.start(r, k) + curve.reach)


def payload_figure(study: PayloadData) -> Figure:
    """Corridor, payload by station in the colour of its limit, and the tensions with the corridor's payload
    against their safe working loads."""
    rig = study.rig
    paths = _paths(study)
    (x0, x1), (low, high) = _extent(rig, paths)
    needed = 10.7 * (high - low) / (x1 - x0)
    sways = rig.environment is not None
    figure = new_figure(figsize=(11.0, needed + 7.2 + 1.5 * sways), layout="constrained")
    ratios = [needed, *([1.3] if sways else []), 2.7, 2.5]
    top, *plan, middle, bottom = figure.subplots(len(ratios), 1, height_ratios=ratios)
    corridor(top, rig, paths, _shown(study))
    figure.suptitle(_headline(study))
    top.set_title("\n".join([_given(study), *_remarks(study)]), fontsize="small")
    _payloads(middle, study)
    _tensions(bottom, study, paths[-1].path if paths else study.frame)
    if plan:
        _sideways(plan[0], rig, paths, _shown(study))
    for axis in (*plan, middle, bottom):
        axis.set_xlim(x0, x1)
    bottom.set_xlabel("station [m]")
    return figure


def _headline(study: PayloadData) -> str:
    """The corridor's payload and its limit."""
    worst = study.limiting
    carried = f"{at_most(study.payload)} kg" if study.payload > 0.0 else "no payload"
    return f"{study.rig.name}: {carried}, limited at {worst['station']:.0f} m by {worst['limited_by']}"


def _given(study: PayloadData) -> str:
    """Assumptions of the payloads."""
    rig, rope = study.rig, study.rig.skyline
    given = [f"{rig.kind.carrying_rope}: {rope.mass_per_length:g} kg/m, MBL {at_most(rope.breaking_load / 1e3, 1)} kN"]
    if rig.tension is not None:
        given.append(f"pretension {rig.tension / 1e3:g} kN")
    elif rig.length is not None:
        given.append(f"unstretched length {rig.length:.2f} m")
    given.append(f"safety factor {study.safety_factor:g}")
    if study.mainline_safety_factor != study.safety_factor:
        given.append(f"other ropes {study.mainline_safety_factor:g}")
    given.append("no clearance required" if study.clearance is None else f"clearance {study.clearance:g} m")
    given.append(f"carriage {rig.carriage.mass:g} kg")
    return "; ".join(given)


def _remarks(study: PayloadData) -> list[str]:
    """The remarks of a study, wrapped to the width of the figure."""
    return [line for remark in study.remarks for line in wrap(remark, 165)]


def _paths(study: PayloadData) -> list[CarriagePath]:
    """Paths of the carriage, empty and with the corridor's payload, as far as they exist."""
    found = []
    masses = [] if study.lowered else [(0.0, "tab:cyan", "path of the empty carriage")]
    if study.payload > 0.0 or study.lowered:
        masses.append((study.payload, "tab:blue", f"path of the carriage with {at_most(study.payload)} kg"))
    for mass, colour, label in masses:
        try:
            path = _path(study, mass)
        except EquilibriumError:
            continue
        if len(path):
            found.append(CarriagePath(path, colour, label))
    return found


def _path(study: PayloadData, mass: float) -> pd.DataFrame:
    """The load path of a mass [kg], at the heights of the study if the yarder lowers the skyline."""
    if not study.lowered:
        return load_path(study.rig, mass, study.frame["station"].to_numpy())
    solver, rows = Stations(study.rig, by_height=True), []
    for x, z in study.frame.reindex(columns=["station", "carriage_z"]).dropna().itertuples(index=False):
        rows.append(station_row(certified([solver.solve(x, mass, z)])[0], x))
    return pd.DataFrame(rows)


def _shown(study: PayloadData) -> Solved | None:
    """The rig at its limiting station."""
    worst = study.limiting
    height = float(worst["carriage_z"]) if study.lowered and "carriage_z" in study.frame else None
    try:
        solver = Stations(study.rig, by_height=study.lowered)
        return certified([solver.solve(float(worst["station"]), study.payload, height)])[0]
    except EquilibriumError:
        return None


def shown_up_to(study: PayloadData) -> float:
    """Payload up to which a picture shows those of a study [t]: beside supports they are many times the others."""
    mass = study.frame["payload"] / 1000.0
    typical = float(mass[mass > 0.0].quantile(0.9)) if mass.max() > 0.0 else 0.1
    return max(1.25 * typical, 1.5 * study.payload / 1000.0)


def _payloads(axis: Axes, study: PayloadData) -> None:
    """Payload over station, coloured by its limit. An arrow at the top marks a payload above the panel. Stations
    without a payload interrupt the curve and have a cross on the axis."""
    frame = study.frame
    mass = frame["payload"] / 1000.0
    top = shown_up_to(study)
    axis.plot(frame["station"], mass.where((mass > 0.0) & (mass <= top)), color="0.6", lw=0.8, zorder=1)
    for i, (limit, part) in enumerate(frame.groupby("limited_by", sort=False)):
        colour, x, own = _COLOURS[i % len(_COLOURS)], part["station"], part["payload"] / 1000.0
        places = {"o": (own > 0.0) & (own <= top), "^": own > top, "x": own <= 0.0}
        label = f"limited by {limit}" if (own > 0.0).any() else f"no payload: {limit}"
        for mark, chosen in places.items():
            if chosen.any():
                axis.plot(x[chosen], own[chosen].clip(upper=0.97 * top), mark, ms=4 + (mark != "o"), color=colour,
                          ls="", label=label, clip_on=False)  # fmt: skip
                label = "_nolegend_"
    worst = study.limiting
    axis.axhline(study.payload / 1000.0, color="black", lw=0.8, ls="--")
    axis.annotate(
        f"{at_most(study.payload)} kg at {worst['station']:.0f} m",
        (worst["station"], study.payload / 1000.0),
        xytext=(0, -13 if study.payload > 0.0 else 8),
        textcoords="offset points",
        ha="center",
        fontsize="small",
    )
    axis.set_ylim(0.0, top)
    axis.set_ylabel("largest payload [t]")
    axis.grid(alpha=0.3)
    above = " (an arrow: above the panel)" if (mass > top).any() else ""
    axis.legend(ncols=4, fontsize="small", title=f"largest payload by station{above}", title_fontsize="small", **ABOVE)


def _tensions(axis: Axes, study: PayloadData, frame: pd.DataFrame) -> None:
    """Highest tensions over station, against the safe working loads by the study's safety factors."""
    rig = study.rig
    shown = [(rig.kind.carrying_rope, "highest_tension", "black", rig.skyline, study.safety_factor)]
    if rig.mainline is not None:
        shown.append(("mainline", "mainline_highest", "tab:red", rig.mainline, study.mainline_safety_factor))
    if rig.haulback is not None:
        shown.append(("haulback", "haulback_highest", "tab:blue", rig.haulback, study.mainline_safety_factor))
    found: dict[tuple[float, float], tuple[float, str, str]] = {}
    for name, column, colour, rope, factor in shown:
        if column in frame and float(frame[column].max()) > 0.0:
            axis.plot(frame["station"], frame[column] / 1e3, color=colour, lw=1.3, label=f"{name}, highest")
            highest, names, first = found.get((rope.breaking_load, factor), (0.0, "", colour))
            names = f"{names} and {name}" if names else name
            found[rope.breaking_load, factor] = (max(highest, float(frame[column].max())), names, first)
    draw_limits(
        axis,
        [
            (highest, [LimitLine(strength / factor, f"SWL {names} (MBL / {factor:g})", colour)])
            for (strength, factor), (highest, names, colour) in found.items()
        ],
    )
    load = "the largest payload" if frame is study.frame else f"{at_most(study.payload)} kg"
    axis.set_ylabel(f"tension with\n{load} [kN]")
    axis.grid(alpha=0.3)
    axis.legend(ncols=4, fontsize="small", **ABOVE)
