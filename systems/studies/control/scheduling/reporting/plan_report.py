"""The report of a schedule plan."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ropeway.systems.reporting.blocks import Block, Chart, Section, Table, axis, curve
from ropeway.systems.reporting.document import values_of, warnings_of
from ropeway.systems.reporting.style import Side, Style
from ropeway.systems.results.result_report import line_player, ropes_in, ropes_table, tensions_chart
from ropeway.systems.studies.control.scheduling.limits import UNITS

if TYPE_CHECKING:
    from ropeway.systems.studies.control.scheduling.plan_data import PlanData

_ROWS = 61
"""Most rows of the table of speeds."""
_COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#9467bd", "#8c564b", "#e377c2", "#bcbd22", "#17becf")
_QUANTITIES = {"N": "force", "W": "power", "m/s": "speed", "m/s2": "acceleration"}


def sections_of(plan: PlanData, style: Style) -> list[Section]:
    """The sections of the report."""
    rows = [
        (style.text("line"), plan.line.name),
        (style.text("duration"), style.value(plan.until, "time")),
        (style.text("minimised"), ", ".join(plan.weights)),
    ]
    warnings = [] if plan.better else [style.text("not_better")]
    return [
        Section(style.text("objectives"), (_objectives(plan, style),)),
        warnings_of(warnings, style),
        Section(style.text("inputs"), (values_of(rows, style), ropes_table(ropes_in(plan.result), style))),
        Section(
            style.text("speeds"),
            (_speeds(plan, style), line_player(plan.result, style), tensions_chart(plan.result, style)),
        ),
        Section(style.text("active_limits"), (_limits(plan, style),)),
        Section(style.text("schedule_table"), (_table(plan, style),)),
    ]


def _objectives(plan: PlanData, style: Style) -> Table:
    """Objectives of the plan beside those of the line's own speeds."""
    runs = {"constant": plan.constant, "balanced": plan.balanced, "planned": plan.objectives}
    known = {name: values for name, values in runs.items() if values is not None}
    rows = []
    for objective in plan.objectives:
        quantity = "energy" if objective == "energy" else "force"
        side: Side = "up"
        rows.append((objective, *(style.value(values[objective], quantity, side) for values in known.values())))
    return Table((style.text("quantity"), *(style.text(name) for name in known)), rows)


def _speeds(plan: PlanData, style: Style) -> Chart:
    traces = []
    for k, (name, schedule) in enumerate(plan.schedules.items()):
        speeds = style.scaled(schedule.speeds, "speed")
        traces.append(curve(np.array(schedule.times), speeds, name, _COLOURS[k % len(_COLOURS)]))
    axes = {"xaxis": axis(style.head("time", "time")), "yaxis": axis(style.head("speed", "speed")), "height": 280}
    return Chart("speeds", traces, axes, marked=True)


def _limits(plan: PlanData, style: Style) -> Block:
    rows = []
    for (limit, at), row in zip(plan.active.index, plan.active.itertuples(), strict=True):
        quantity = _QUANTITIES.get(UNITS[limit])
        bound = f"{row.bound:g} {UNITS[limit]}".rstrip() if quantity is None else style.value(row.bound, quantity)
        rows.append((limit, at, bound, str(row.times), f"{row.cost:.3g}"))
    head = (*(style.text(k) for k in ("limit", "component", "bound", "count", "cost")),)
    return Table(head, rows, texts=2)


def _table(plan: PlanData, style: Style) -> Table:
    frame = plan.frame
    frame = frame.iloc[np.unique(np.linspace(0, len(frame) - 1, min(_ROWS, len(frame))).astype(int))]
    unit = style.shown("speed").unit
    head = (style.head("time", "time"), *(f"{name} [{unit}]" for name in plan.schedules))
    rows = [
        (style.number(time, "time"), *(style.number(v, "speed") for v in values))
        for time, values in zip(frame.index, frame.to_numpy(), strict=True)
    ]
    return Table(head, rows)
