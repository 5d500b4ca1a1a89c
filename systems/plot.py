"""Pictures of a line and of its tensions. matplotlib is imported when one is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ropeway.components.anchor import Anchor
from ropeway.components.control_sheave import ControlSheave
from ropeway.components.drum import Drum
from ropeway.components.errors import UnknownNameError
from ropeway.components.sheave import Sheave
from ropeway.systems.equilibrium import Equilibrium
from ropeway.systems.model import nearest

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ropeway.systems.result import Result

_MARKS = {
    ControlSheave: ("control sheave", "s", "tab:red"),
    Sheave: ("idler sheave", "o", "0.35"),
    Drum: ("drum", "D", "tab:purple"),
    Anchor: ("anchor", "^", "tab:brown"),
}


def tensions_over_time(result: Result, components: Sequence[str] | None = None) -> Figure:
    """Tension on both sides of each control sheave (or of `components`, or of the first idlers where there is no
    control sheave) over time, against SWL and MBL.

    Above the whole scale up to the MBL with the range of all spans, below each sheave in detail. Raises
    UnknownNameError.
    """
    from matplotlib.figure import Figure

    frame, run = result.full_frame, result.runs[0]
    if components is None:
        components = [n.name for n in run.nodes if isinstance(n, ControlSheave)]
        components = components or [n.name for n in run.nodes if f"{n.name}.tension_in" in frame][:4]
    for name in components:
        if f"{name}.tension_in" not in frame:
            raise UnknownNameError(f"{name!r} has no tension_in", nearest(name, list(frame.columns)))
    time = frame.index.to_numpy()
    rows = len(components)
    figure = Figure(figsize=(10.0, 3.0 + 1.7 * rows), layout="constrained")
    axes = figure.subplots(1 + rows, 1, sharex=True, height_ratios=[1.7] + [1.0] * rows, squeeze=False)[:, 0]
    _against_limits(axes[0], result, time)
    axes[0].set_title(f"{result.model.name}: rope tension")
    for axis, name in zip(axes[1:], components, strict=True):
        axis.plot(time, frame[f"{name}.tension_in"] / 1e3, lw=1.0, color="tab:blue", label="coming in")
        axis.plot(time, frame[f"{name}.tension_out"] / 1e3, lw=1.0, color="tab:orange", label="going out")
        axis.set_ylabel(f"{name} [kN]")
        axis.grid(alpha=0.3)
    if rows:  # above the picture: inside it would lie on the lines
        above = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.1, "frameon": False}
        axes[1].legend(ncols=2, fontsize="small", **above)
    axes[-1].set_xlabel("time [s]")
    axes[-1].set_xlim(time[0], time[-1])
    return figure


def _against_limits(axis: Axes, result: Result, time: np.ndarray) -> None:
    frame, rope = result.full_frame, result.runs[0].rope
    ends = frame.filter(regex=r"\.tension_[ab]$").to_numpy() / 1e3
    axis.fill_between(time, ends.min(axis=1), ends.max(axis=1), color="tab:blue", alpha=0.35, lw=0)
    axis.plot(time, ends.max(axis=1), color="tab:blue", lw=1.0, label="highest and lowest tension of all spans")
    for value, label, style in (
        (rope.breaking_load, "MBL", "-"),
        (rope.safe_working_load, f"SWL (MBL / {rope.safety_factor:g})", "--"),
    ):
        axis.axhline(value / 1e3, color="tab:red", ls=style, lw=1.3)
        axis.annotate(
            f"{label} {value / 1e3:.0f} kN",
            (time[0], value / 1e3),
            xytext=(4, -3),
            textcoords="offset points",
            va="top",
            color="tab:red",
            fontsize="small",
        )
    axis.set_ylim(0.0, 1.08 * rope.breaking_load / 1e3)
    axis.set_ylabel("tension [kN]")
    axis.legend(loc="center right", fontsize="small")
    axis.grid(alpha=0.3)


def power_over_time(result: Result) -> Figure:
    """Power of each control sheave into the rope over time; energy that each has pulled and recovered.

    Raises UnknownNameError when the line has no control sheave.
    """
    from matplotlib.figure import Figure

    table, frame = result.power(), result.full_frame
    if table.empty:
        raise UnknownNameError(f"{result.model.name!r} has no control sheave", "Only driven sheaves have power")
    sheaves = table.drop(index="line")
    figure = Figure(figsize=(11.0, 5.0), layout="constrained")
    over_time, energies = figure.subplots(1, 2, width_ratios=[2.4, 1.0])
    for name in sheaves.index[:10]:
        over_time.plot(frame.index, frame[f"{name}.power"] / 1e3, lw=1.0, label=name)
    over_time.plot(
        frame.index,
        frame[[f"{n}.power" for n in sheaves.index]].sum(axis=1) / 1e3,
        color="0.2",
        lw=1.2,
        ls="--",
        label="line",
    )
    over_time.set(xlabel="time [s]", ylabel="power into the rope [kW]", title=f"{result.model.name}: power")
    over_time.legend(fontsize="small", ncols=3)
    place = np.arange(len(sheaves))
    energies.barh(place, sheaves["pulled"] / 1e3, color="tab:blue", label="pulled")
    energies.barh(place, -sheaves["recovered"] / 1e3, color="tab:green", label="recovered")
    energies.set_yticks(place, list(sheaves.index), fontsize="small")
    energies.invert_yaxis()
    energies.axvline(0.0, color="0.3", lw=0.8)
    energies.set(xlabel="energy [kJ]", title="energy")
    energies.legend(fontsize="small")
    for axis in (over_time, energies):
        axis.grid(alpha=0.3)
    return figure


def line_profile(line: Equilibrium) -> Figure:
    """Elevation with rope, loads and supports, tension along the rope, and plan of a line at one time."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 8.0), layout="constrained")
    elevation, tension, plan = figure.subplots(3, 1, sharex=True, height_ratios=[2.2, 1.3, 0.9])
    for r, run in enumerate(line.runs):
        points = line.points(r)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points[:, :2], axis=0).T))])
        rope = run.rope
        curves = []
        for k, span in enumerate(run.spans):
            curve = line.profile(span.name, 60)
            reach = np.hypot(curve["x"] - points[k, 0], curve["y"] - points[k, 1])
            curves.append((along[k] + reach, curve))
        for x, curve in curves:
            elevation.plot(x, curve["z"], color="tab:blue", lw=1.4)
            tension.plot(x, curve["tension"] / 1e3, color="tab:blue", lw=1.2)
            plan.plot(x, curve["y"], color="tab:blue", lw=1.2)
        ground = max(8.0, 0.04 * float(np.ptp(points[:, 2])))
        for kind, (label, mark, colour) in _MARKS.items():
            of_kind = [k for k, node in enumerate(run.nodes) if isinstance(node, kind)]
            if of_kind:
                style = {"color": colour, "marker": mark, "ls": "", "ms": 6, "zorder": 3}
                elevation.plot(along[of_kind], points[of_kind, 2], label=label, **style)
                plan.plot(along[of_kind], points[of_kind, 1], **style)
            for k in of_kind:
                elevation.plot([along[k]] * 2, [points[k, 2], points[k, 2] - ground], color="0.6", lw=1.5, zorder=1)
                if kind is not Sheave:
                    elevation.annotate(
                        run.nodes[k].label,
                        (along[k], points[k, 2]),
                        xytext=(0, 8),
                        textcoords="offset points",
                        ha="center",
                        fontsize="small",
                        color=colour,
                    )
        loads = line.loads[line.loads["span"].isin([s.name for s in run.spans])]
        if len(loads):
            k = loads["span"].map({s.name: i for i, s in enumerate(run.spans)}).to_numpy(dtype=int)
            x = along[k] + np.hypot(loads["x"] - points[k, 0], loads["y"] - points[k, 1])
            size = 14.0 + 26.0 * loads["mass"] / loads["mass"].max()
            elevation.scatter(x, loads["z"], s=size, color="tab:green", zorder=4, label="load", marker="v")
            plan.scatter(x, loads["y"], s=12, color="tab:green", zorder=4, marker="v")
        tension.axhline(rope.safe_working_load / 1e3, color="tab:red", ls="--", lw=1.2)
        tension.annotate(
            f"SWL {rope.safe_working_load / 1e3:.0f} kN (MBL {rope.breaking_load / 1e3:.0f} kN)",
            (0.0, rope.safe_working_load / 1e3),
            xytext=(4, -3),
            textcoords="offset points",
            va="top",
            color="tab:red",
            fontsize="small",
        )
    elevation.set_ylabel("height [m]")
    elevation.legend(loc="upper left", ncols=5, fontsize="small")
    elevation.margins(x=0.02, y=0.14)
    figure.draw_without_rendering()
    box = elevation.get_window_extent()
    scale = (np.ptp(elevation.get_xlim()) / box.width) / (np.ptp(elevation.get_ylim()) / box.height)
    elevation.set_title(f"{line.model.name} at t = {line.point.t:g} s (heights {scale:.1f} times exaggerated)")
    tension.set_ylim(bottom=0.0)
    tension.set_ylabel("tension [kN]")
    plan.set_ylabel("y [m]")
    plan.set_xlabel("horizontal distance along the line [m]")
    for axis in (elevation, tension, plan):
        axis.grid(alpha=0.3)
    return figure
