"""Figures of a run: tensions and powers over time. matplotlib is imported on use."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ropeway.components.errors import UnknownNameError
from ropeway.components.notebook_figure import new_figure
from ropeway.components.rope import Rope
from ropeway.systems.modelling.dae_model import nearest
from ropeway.systems.results.energy_balance import drive_powers, power
from ropeway.systems.results.limit_lines import ABOVE, LimitLine, draw_limits, limits_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ropeway.systems.results.run_data import RunData

_FIRST = 4
"""Number of idlers shown on a line without control sheaves."""

_SHEAVES = 10
"""Control sheaves with a separate line in a figure of powers; more colours would be indistinguishable."""

_COLOURS = ("tab:red", "tab:purple", "tab:brown", "tab:pink")
"""Colours of the limits of several ropes."""

KWH = 3.6e6
"""One kilowatt-hour [J]."""


def tensions_over_time(result: RunData, components: Sequence[str] | None = None) -> Figure:
    """Tension on both sides of each control sheave over time, against SWL and MBL.

    `components` selects other components; a line without control sheaves shows its first idlers. The upper panel shows
    the range of all spans with nearby limits, the lower panels each sheave in detail. Raises UnknownNameError.
    """
    frame, nodes = result.full_frame, [node for run in result.runs for node in run.nodes]
    if components is None:
        components = list(dict.fromkeys(n.name for n in nodes if n.drive_power is not None))
        sheaves = dict.fromkeys(n.name for n in nodes if f"{n.name}.tension_in" in frame)
        components = components or list(sheaves)[:_FIRST]
    for name in components:
        if f"{name}.tension_in" not in frame:
            raise UnknownNameError(f"{name!r} has no tension_in", nearest(name, list(frame.columns)))
    time = frame.index.to_numpy()
    rows = len(components)
    figure = new_figure(figsize=(10.0, 3.2 + 1.7 * rows), layout="constrained")
    axes = figure.subplots(1 + rows, 1, sharex=True, height_ratios=[1.9] + [1.0] * rows, squeeze=False)[:, 0]
    figure.suptitle(f"{result.model.name}: rope tension")
    _all_spans(axes[0], result, time)
    shown = {node.name: node.label for node in nodes}
    for axis, name in zip(axes[1:], components, strict=True):
        axis.plot(time, frame[f"{name}.tension_in"] / 1e3, lw=1.0, color="tab:blue", label="coming in")
        axis.plot(time, frame[f"{name}.tension_out"] / 1e3, lw=1.0, color="tab:orange", label="going out")
        axis.set_ylabel(f"{shown.get(name, name)} [kN]")
        axis.grid(alpha=0.3)
    if rows:
        axes[1].legend(ncols=2, fontsize="small", **ABOVE)
    axes[-1].set_xlabel("time [s]")
    axes[-1].set_xlim(time[0], time[-1])
    return figure


def _all_spans(axis: Axes, result: RunData, time: np.ndarray) -> None:
    """Highest and lowest tension of all spans, against the limits of their ropes."""
    frame = result.full_frame
    ends = frame.filter(regex=r"\.tension_[ab]$").to_numpy() / 1e3
    highest, lowest = ends.max(axis=1), ends.min(axis=1)
    axis.fill_between(time, lowest, highest, color="tab:blue", alpha=0.25, lw=0)
    axis.plot(time, highest, color="tab:blue", lw=1.2, label="highest of all spans")
    axis.plot(time, lowest, color="tab:cyan", lw=1.2, label="lowest of all spans")
    draw_limits(axis, _ropes(result))
    axis.set_ylabel("tension [kN]")
    axis.legend(ncols=3, fontsize="small", **ABOVE)
    axis.grid(alpha=0.3)


def _ropes(result: RunData) -> list[tuple[float, list[LimitLine]]]:
    """Highest tension [N] of each rope, with its limits."""
    frame = result.full_frame
    spans: dict[Rope, list[tuple[str, list[str]]]] = {span.rope: [] for run in result.runs for span in run.spans}
    for run in result.runs:
        for span in run.spans:
            spans[span.rope].append((run.name, [f"{span.name}.tension_{end}" for end in "ab"]))
    found = []
    for i, (rope, own) in enumerate(spans.items()):
        highest = float(frame[[name for _, names in own for name in names]].max(axis=None))
        found.append((highest, limits_of(rope, own[0][0] if len(spans) > 1 else "", _COLOURS[i % len(_COLOURS)])))
    return found


def power_over_time(result: RunData) -> Figure:
    """Power of each control sheave into the rope over time, and its pulled and recovered energy.

    Raises UnknownNameError for a line without control sheaves.
    """
    table, powers = power(result), drive_powers(result) / 1e3
    if table.empty:
        raise UnknownNameError(f"{result.model.name!r} has no control sheave", "Only driven sheaves have power")
    sheaves = table.drop(index="line")
    figure = new_figure(figsize=(11.0, 5.0), layout="constrained")
    over_time, energies = figure.subplots(1, 2, width_ratios=[2.4, 1.0])
    # The jumps at crossings make a dashed line look solid, so its width marks the sum.
    over_time.plot(powers.index, powers.sum(axis=1), color="0.2", lw=2.0, label="all drives")
    for name in sheaves.index[:_SHEAVES]:
        over_time.plot(powers.index, powers[name], lw=1.0, label=name)
    over_time.axhline(0.0, color="0.3", lw=0.8)
    over_time.set(xlabel="time [s]", ylabel="power into the rope [kW]", xlim=(powers.index[0], powers.index[-1]))
    over_time.legend(fontsize="small", ncols=6, **ABOVE)
    place = np.arange(len(sheaves))
    energies.barh(place, sheaves["pulled"] / KWH, color="tab:blue", label="pulled")
    energies.barh(place, -sheaves["recovered"] / KWH, color="tab:green", label="recovered")
    energies.set_yticks(place, list(sheaves.index), fontsize="small")
    energies.invert_yaxis()
    energies.axvline(0.0, color="0.3", lw=0.8)
    energies.set(xlabel=f"energy over {result.times[-1]:g} s [kWh]")
    energies.legend(fontsize="small", ncols=2, **ABOVE)
    figure.suptitle(f"{result.model.name}: power and energy of the drives")
    for axis in (over_time, energies):
        axis.grid(alpha=0.3)
    return figure
