"""Picture of an inhaul over time. matplotlib is imported when it is drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from ropeway.components.notebook_figure import new_figure
from ropeway.components.rope import Rope
from ropeway.systems.results.limit_lines import ABOVE, LimitLine, draw_limits, limits_of
from ropeway.systems.rigs.skyline_rig import SkylineRig

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def inhaul_figure(rig: SkylineRig, frame: pd.DataFrame, events: pd.DataFrame) -> Figure:
    """Station of the carriage, rope tensions against their safe working loads, and drum power over time."""
    figure = new_figure(figsize=(11.0, 8.4), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    _carriage(top, rig, frame, events)
    _tensions(middle, rig, frame)
    _powers(bottom, frame)
    bottom.set_xlabel("time [s]")
    for axis in (top, middle, bottom):
        axis.grid(alpha=0.3)
        for event in events.itertuples():
            axis.axvline(float(event.time), color="0.6", lw=0.8, ls=":")
    figure.suptitle(f"{rig.name}: inhaul")
    return figure


def _carriage(axis: Axes, rig: SkylineRig, frame: pd.DataFrame, events: pd.DataFrame) -> None:
    """Station of the carriage, supports, and changes of the payload."""
    time = frame.index.to_numpy()
    axis.plot(time, frame["carriage_x"], color="black", lw=1.3)
    axis.set_ylabel("station of the carriage [m]")
    for support in rig.supports:
        x, *_ = support.at
        axis.axhline(x, color="tab:brown", lw=0.9, ls="--")
        axis.annotate(support.name, (time[0], x), xytext=(3, 3), textcoords="offset points", fontsize="small")
    for event in events.itertuples():
        if str(event.event).startswith(("payload", "beyond")):
            place = (float(event.time), float(event.station))
            axis.annotate(str(event.event), place, xytext=(5, 5), textcoords="offset points", fontsize="small")


def _tensions(axis: Axes, rig: SkylineRig, frame: pd.DataFrame) -> None:
    """Highest tensions of the ropes, against the safe working load of each."""
    ropes: tuple[tuple[str, str, str, str, Rope | None], ...] = (
        ("skyline", "highest_tension", "skyline, highest", "black", rig.skyline),
        ("mainline", "mainline_tension", "mainline at its drum", "tab:red", rig.mainline),
        ("haulback", "haulback_tension", "haulback", "tab:blue", rig.haulback),
    )
    found: list[tuple[float, list[LimitLine]]] = []
    for name, column, label, colour, rope in ropes:
        if float(frame[column].max()) > 0.0:
            axis.plot(frame.index, frame[column] / 1e3, color=colour, lw=1.2, label=label)
            limits = [] if rope is None else limits_of(rope, name, colour)[:1]
            found.append((float(frame[column].max()), limits))
    draw_limits(axis, found)
    axis.set_ylabel("tension [kN]")
    axis.legend(fontsize="small", ncols=4, **ABOVE)


def _powers(axis: Axes, frame: pd.DataFrame) -> None:
    """Powers of the drums."""
    axis.plot(frame.index, frame["drum_power"] / 1e3, color="tab:red", lw=1.2, label="mainline drum")
    if float(frame["haulback_power"].abs().max()) > 0.0:
        label = "haulback drum (below 0: brakes)"
        axis.plot(frame.index, frame["haulback_power"] / 1e3, color="tab:blue", lw=1.2, label=label)
    axis.axhline(0.0, color="0.4", lw=0.8)
    axis.set_ylabel("power [kW]")
    axis.legend(fontsize="small", ncols=2, **ABOVE)
