"""The report of a run of FMUs: all outputs over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.table_writer import plain
from ropeway.systems.reporting.blocks import Chart, Moving, Player, Section, Table, axis, curve, dots
from ropeway.systems.reporting.document import Project, ReportOptions, values_of, warnings_of, write_report
from ropeway.systems.reporting.style import Style, Units
from ropeway.systems.results.result_report import thinned

_FRAMES, _CHARTS, _CURVES = 200, 8, 10
"""Most frames of the player, charts, and curves of a chart."""
_COLOURS = (
    "#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf",
)  # fmt: skip


@checked
def run_report(
    frame: pd.DataFrame,
    path: str | Path,
    *,
    project: Project | None = None,
    units: Units = "metric",
    labels: Mapping[str, str] | None = None,
    more: Sequence[Section] = (),
) -> Path:
    """Write the report of a run of FMUs.

    Parameters
    ----------
    frame : DataFrame
        As `rw.fmu.CoSimulation.run` returns it: outputs over time [s].
    path : str or Path
        HTML, or PDF by a browser's print; needs the extra `report`.
    project : Project, optional
        Title, place, client, author and a remark.
    units : {"metric", "imperial"}, default "metric"
        Outputs keep the units of their FMUs.
    labels : mapping, optional
        Words in place of those of `ropeway.systems.reporting.labels.ENGLISH`, by key.
    more : sequence of Section, optional
        Sections of your own after the others.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        The frame has no numbers.
    WriteError
        The file could not be written.

    Examples
    --------
    >>> master = rw.fmu.CoSimulation(step=1.0)
    >>> part = master.add("span", "span.fmu")
    >>> rw.fmu.run_report(master.run(5.0), "run.html").name
    'run.html'
    """
    options = ReportOptions(project, units, labels, more)
    style = options.style
    numbers = frame.select_dtypes(["number", "bool"]).astype(float)
    if numbers.empty or frame.index.dtype.kind != "f":
        raise InputError("The frame holds no outputs over time", "Give what rw.fmu.CoSimulation.run returns")
    known = dict(frame.attrs.get("units", {}))
    groups: dict[str, list[str]] = {}
    for name in numbers.columns:
        groups.setdefault(str(known.get(name, "1")), []).append(str(name))
    ended = frame.attrs.get("ended")
    warnings = [style.text("ended", why=ended)] if ended else []
    warnings += [f"{name}: {reason}" for name, reason in dict(frame.attrs.get("left_out", {})).items()]
    first, last = float(frame.index[0]), float(frame.index[-1])
    rows = [(style.text("duration"), style.value(last - first, "time")), (style.text("records"), str(len(frame)))]
    charts = [_chart(k, numbers, unit, names, style) for k, (unit, names) in enumerate(groups.items())][:_CHARTS]
    sections = [
        warnings_of(warnings, style),
        Section(style.text("inputs"), (values_of(rows, style),)),
        Section(style.text("cosimulation"), (_player(numbers, groups, known, style), *charts[1:])),
        Section(style.text("outputs"), (_table(numbers, known, style),)),
    ]
    return write_report(path, style.text("cosimulation"), sections, options)


def _chart(k: int, frame: pd.DataFrame, unit: str, names: list[str], style: Style) -> Chart:
    """Outputs of one unit over time."""
    drawn = thinned(frame[names[:_CURVES]])
    time = drawn.index.to_numpy(dtype=float)
    traces = [curve(time, drawn[n].to_numpy(), n, _COLOURS[i], width=1.3) for i, n in enumerate(names[:_CURVES])]
    label = f"[{unit}]" if unit not in ("1", "") else "[-]"
    axes = {"xaxis": axis(style.head("time", "time")), "yaxis": axis(label), "height": 300}
    return Chart(f"outputs{k}", traces, axes, marked=k > 0)


def _player(frame: pd.DataFrame, groups: dict[str, list[str]], units: dict[Any, str], style: Style) -> Player:
    """The outputs of the first unit with a point that moves on each curve, and all values beside."""
    unit, names = next(iter(groups.items()))
    chosen = np.unique(np.linspace(0, len(frame) - 1, min(_FRAMES, len(frame))).astype(int))
    shown, names = frame.iloc[chosen], names[:_CURVES]
    times = shown.index.to_numpy(dtype=float)
    chart = _chart(0, frame, unit, names, style)
    points = [np.array([row[name] for name in names]) for _, row in shown.iterrows()]
    still = len(chart.traces)
    marks = dots([], [], style.text("now"), "#111", size=7, shown=False, hoverinfo="skip")
    quiet = plain(shown, units=False)
    listed = [name for own in groups.values() for name in own][: 2 * _CURVES]
    return Player(
        Chart(chart.name, [*chart.traces, marks], {**chart.layout, "height": 380}),
        [f"{style.text('time')} {style.value(t, 'time')}" for t in times],
        [Moving(still, [np.full(len(names), t) for t in times], points)],
        marks=times.tolist(),
        values=[(name, [_text(v, units.get(name, "")) for v in quiet[name]]) for name in listed],
    )


def _text(value: float, unit: str) -> str:
    return f"{value:.6g} {unit}".rstrip() if unit != "1" else f"{value:.6g}"


def _table(frame: pd.DataFrame, units: dict[Any, str], style: Style) -> Table:
    rows = [
        (name, units.get(name, ""), *(f"{v:.6g}" for v in (own.iloc[0], own.iloc[-1], own.min(), own.max())))
        for name, own in frame.items()
    ]
    return Table(tuple(style.text(k) for k in ("output", "unit", "first", "last", "lowest", "highest")), rows, texts=2)
