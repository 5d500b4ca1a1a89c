"""Pictures of a skyline corridor: to scale, payloads and tensions below. matplotlib is imported when one is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from ropeway.components import catenary
from ropeway.components.errors import EquilibriumError
from ropeway.systems.rigs.skyline import Kind, SkylineRig
from ropeway.systems.studies.load_path import load_path, row
from ropeway.systems.studies.span_model import Solved
from ropeway.systems.studies.stations import Stations
from ropeway.systems.studies.terrain import Profile

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ropeway.systems.studies.inhaul import Inhaul
    from ropeway.systems.studies.payload import PayloadStudy


class Way(NamedTuple):
    """A load path to draw."""

    path: pd.DataFrame
    colour: str
    label: str


_COLOURS = ("tab:blue", "tab:orange", "tab:purple", "tab:olive", "tab:pink", "tab:cyan", "tab:brown")
_ROPES = {"mainline": "tab:red", "haulback": "tab:blue", "dropline": "tab:green"}


def corridor(axis: Axes, rig: SkylineRig, ways: Sequence[Way], shown: Solved | None = None) -> None:
    """The corridor to scale: ground, spars, ways of the carriage, and the ropes with the carriage at one place."""
    (x0, x1), (low, high) = _extent(rig, ways)
    if isinstance(rig.terrain, Profile):
        ground = rig.terrain
        axis.fill_between(ground.station, ground.elevation, low, color="0.86", lw=0)
        axis.plot(ground.station, ground.elevation, color="0.35", lw=1.3)
    for node in rig.stands:
        x, _, z = node.at
        foot = rig.terrain.elevation_at(x) if rig.terrain is not None else z - 0.03 * (x1 - x0)
        axis.plot([x, x], [foot, z], color="tab:brown", lw=2.6, solid_capstyle="butt")
        axis.annotate(node.name, (x, z), xytext=(0, 5), textcoords="offset points", ha="center", fontsize="small")
    for way in ways:
        for _, part in way.path.dropna(subset=["carriage_z"]).groupby("span"):
            axis.plot(part["carriage_x"], part["carriage_z"], color=way.colour, lw=1.1, ls="--", zorder=2)
            if rig.carriage.depth > 0.0 and way is ways[-1]:
                lowest = part["carriage_z"] - rig.carriage.depth
                axis.plot(part["carriage_x"], lowest, color=way.colour, lw=0.8, ls=":", zorder=2)
        axis.plot([], [], color=way.colour, lw=1.1, ls="--", label=way.label)
    if rig.carriage.depth > 0.0 and ways:
        axis.plot([], [], color=ways[-1].colour, lw=0.8, ls=":", label="lowest point of the load")
    if shown is not None:
        _ropes(axis, shown)
    axis.set_xlim(x0, x1)
    axis.set_ylim(low, high)
    axis.set_aspect("equal", adjustable="box")
    axis.set_ylabel("elevation [m]")
    axis.grid(alpha=0.25)
    if axis.get_legend_handles_labels()[0]:
        axis.legend(loc="best", fontsize="small", framealpha=0.9)


def _extent(rig: SkylineRig, ways: Sequence[Way]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of the picture of a corridor: (x, x), (z, z)."""
    x = rig.points[:, 0]
    width = float(x.max() - x.min())
    heights = [*rig.points[:, 2], *(float(z) for way in ways for z in way.path["carriage_z"].dropna())]
    if isinstance(rig.terrain, Profile):
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
        name = "haulback" if sky and rig.kind is Kind.RUNNING else role or "guylines"
        for k, span in enumerate(run.spans):
            start = shown.start(r, k)
            length = shown[f"{span.name}.length"]
            weight = run.rope.mass_per_length * rig.gravity
            stations = np.linspace(0.0, length, 60)
            curve = catenary.profile(
                shown.at.curve(shown.point, k, r), weight, run.rope.strain, length, (), (), stations
            )
            label = None if name in named else name
            axis.plot(start[0] + curve.reach[:, 0], start[2] + curve.reach[:, 2], color=colour, lw=width, label=label)
            named.add(name)
    name = rig.carriage.name
    x, z = shown[f"{name}.x"], shown[f"{name}.z"]
    axis.plot([x], [z], "s", color="black", ms=6, zorder=5)
    if rig.carriage.depth > 0.0:
        axis.plot([x, x], [z, z - rig.carriage.depth], color="black", lw=2.5, zorder=5)
    if rig.turn is not None:
        front, rear = ([shown[f"{rig.turn.log.name}.{end}{axis}"] for axis in "xz"] for end in ("", "rear_"))
        axis.plot(*zip(front, rear, strict=True), color="tab:brown", lw=3.5, solid_capstyle="butt", label="log")


def payload_figure(study: PayloadStudy) -> Figure:
    """Corridor, payload by station in the colour of its limit, and the tensions with the corridor's payload
    against their safe working loads."""
    from matplotlib.figure import Figure

    rig = study.rig
    ways = _ways(study)
    (x0, x1), (low, high) = _extent(rig, ways)
    needed = 10.7 * (high - low) / (x1 - x0)
    figure = Figure(figsize=(11.0, needed + 6.6), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, height_ratios=[needed, 2.7, 2.5])
    corridor(top, rig, ways, _shown(study))
    worst = study.limiting
    top.set_title(
        f"{rig.name}: {study.payload / 1000.0:.2f} t can be brought along the corridor, "
        f"limited at {worst['station']:.0f} m by {worst['limited_by']}"
    )
    _payloads(middle, study)
    _tensions(bottom, study, ways[-1].path if ways else study.frame)
    for axis in (middle, bottom):
        axis.set_xlim(x0, x1)
    bottom.set_xlabel("station [m]")
    return figure


def _ways(study: PayloadStudy) -> list[Way]:
    """The carriage's way empty and with the corridor's payload, where there are such."""
    found = []
    masses = [] if study.lowered else [(0.0, "tab:cyan", "way of the empty carriage")]
    masses.append((study.payload, "tab:blue", f"way of the carriage with {study.payload / 1000.0:.2f} t"))
    for mass, colour, label in masses:
        try:
            path = _path(study, mass)
        except EquilibriumError:
            continue
        if len(path):
            found.append(Way(path, colour, label))
    return found


def _path(study: PayloadStudy, mass: float) -> pd.DataFrame:
    """The load path of a mass [kg], at the heights of the study where the yarder lowers the skyline."""
    if not study.lowered:
        return load_path(study.rig, mass, study.frame["station"].to_numpy())
    solver, rows = Stations(study.rig, by_height=True), []
    for x, z in study.frame.reindex(columns=["station", "carriage_z"]).dropna().itertuples(index=False):
        rows.append(row(solver.solve(x, mass, z), x))
    return pd.DataFrame(rows)


def _shown(study: PayloadStudy) -> Solved | None:
    """The rig at its limiting station."""
    worst = study.limiting
    height = float(worst["carriage_z"]) if study.lowered and "carriage_z" in study.frame else None
    try:
        return Stations(study.rig, by_height=study.lowered).solve(float(worst["station"]), study.payload, height)
    except EquilibriumError:
        return None


def _payloads(axis: Axes, study: PayloadStudy) -> None:
    frame = study.frame
    x, mass = frame["station"].to_numpy(), frame["payload"].to_numpy() / 1000.0
    axis.plot(x, mass, color="0.6", lw=0.8, zorder=1)
    for i, (limit, part) in enumerate(frame.groupby("limited_by", sort=False)):
        colour = _COLOURS[i % len(_COLOURS)]
        axis.vlines(part["station"], 0.0, part["payload"] / 1000.0, color=colour, lw=1.0, alpha=0.35)
        axis.plot(part["station"], part["payload"] / 1000.0, "o", ms=4, color=colour, label=f"limited by {limit}")
    worst = study.limiting
    axis.axhline(study.payload / 1000.0, color="black", lw=0.8, ls="--")
    axis.annotate(
        f"{study.payload:.0f} kg at {worst['station']:.0f} m",
        (worst["station"], study.payload / 1000.0),
        xytext=(0, -13 if study.payload > 0.0 else 5),
        textcoords="offset points",
        ha="center",
        fontsize="small",
    )
    axis.set_ylim(0.0, max(float(np.quantile(mass, 0.9)) * 1.25, study.payload / 1000.0 * 1.5, 0.1))
    axis.set_ylabel("largest payload [t]")
    axis.grid(alpha=0.3)
    axis.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, fontsize="small", frameon=False)


def _tensions(axis: Axes, study: PayloadStudy, frame: pd.DataFrame) -> None:
    rig = study.rig
    limit = rig.skyline.breaking_load / study.safety_factor / 1e3
    sky = "haulback" if rig.kind is Kind.RUNNING else "skyline"
    rows = [("highest_tension", f"{sky}, highest", "black"), ("mainline_highest", "mainline, highest", "tab:red")]
    for column, label, colour in rows:
        if column in frame and float(frame[column].max()) > 0.0:
            axis.plot(frame["station"], frame[column] / 1e3, color=colour, lw=1.3, label=label)
    axis.axhline(limit, color="black", ls="--", lw=1.0)
    same = rig.mainline is rig.skyline and study.safety_factor == study.mainline_safety_factor
    axis.annotate(
        f"SWL {sky}{' and mainline' if same else ''} {limit:.0f} kN (MBL / {study.safety_factor:g})",
        (float(frame["station"].iloc[0]), limit),
        xytext=(4, 3),
        textcoords="offset points",
        fontsize="small",
    )
    if rig.mainline is not None and not same:
        main = rig.mainline.breaking_load / study.mainline_safety_factor / 1e3
        axis.axhline(main, color="tab:red", ls="--", lw=1.0)
        axis.annotate(
            f"SWL mainline {main:.0f} kN",
            (float(frame["station"].iloc[0]), main),
            xytext=(4, 3),
            textcoords="offset points",
            color="tab:red",
            fontsize="small",
        )
    axis.set_ylim(0.0, 1.32 * limit)
    load = "the largest payload" if frame is study.frame else f"{study.payload / 1000.0:.2f} t"
    axis.set_ylabel(f"tension with {load} [kN]")
    axis.grid(alpha=0.3)
    if axis.get_legend_handles_labels()[0]:
        axis.legend(loc="upper right", ncols=2, fontsize="small", framealpha=0.9)


def inhaul_figure(run: Inhaul) -> Figure:
    """Station of the carriage, rope tensions and drum power over time."""
    from matplotlib.figure import Figure

    frame, time = run.frame, run.frame.index.to_numpy()
    figure = Figure(figsize=(11.0, 8.0), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    top.plot(time, frame["carriage_x"], color="black", lw=1.3)
    top.set_ylabel("station of the carriage [m]")
    for support in run.rig.supports:
        x, *_ = support.at
        top.axhline(x, color="tab:brown", lw=0.9, ls="--")
        top.annotate(support.name, (time[0], x), xytext=(3, 3), textcoords="offset points", fontsize="small")
    lines = (("highest_tension", "skyline, highest", "black"), ("mainline_tension", "mainline at its drum", "tab:red"))
    for column, label, colour in (*lines, ("haulback_tension", "haulback", "tab:blue")):
        if float(frame[column].max()) > 0.0:
            middle.plot(time, frame[column] / 1e3, color=colour, lw=1.2, label=label)
    middle.set_ylabel("tension [kN]")
    bottom.plot(time, frame["drum_power"] / 1e3, color="tab:red", lw=1.2, label="mainline drum")
    if float(frame["haulback_power"].abs().max()) > 0.0:
        bottom.plot(
            time, frame["haulback_power"] / 1e3, color="tab:blue", lw=1.2, label="haulback drum (below 0: brakes)"
        )
    bottom.axhline(0.0, color="0.4", lw=0.8)
    bottom.set_ylabel("power [kW]")
    bottom.set_xlabel("time [s]")
    for axis in (middle, bottom):
        axis.legend(loc="upper right", fontsize="small")
    for axis in (top, middle, bottom):
        axis.grid(alpha=0.3)
        for event in run.events.itertuples():
            axis.axvline(float(event.time), color="0.6", lw=0.8, ls=":")
    for event in run.events.itertuples():
        if str(event.event).startswith("payload"):
            top.annotate(
                str(event.event), (float(event.time), float(event.station)), xytext=(5, 5), textcoords="offset points"
            )
    top.set_title(f"{run.rig.name}: inhaul")
    return figure
