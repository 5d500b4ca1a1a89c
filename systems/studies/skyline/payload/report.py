"""The report of a payload study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ropeway.systems.reporting.blocks import Chart, Section, Text, axis, curve, dots
from ropeway.systems.reporting.document import warnings_of
from ropeway.systems.reporting.style import Style
from ropeway.systems.results.result_report import limit_curves
from ropeway.systems.studies.skyline.reporting import rig_sections
from ropeway.systems.studies.skyline.reporting.rig_player import FRAMES, Places, rig_player
from ropeway.systems.studies.skyline.reporting.rig_sections import TENSIONS

if TYPE_CHECKING:
    from ropeway.systems.studies.skyline.payload.data import PayloadData

_COLOURS = ("#1f77b4", "#ff7f0e", "#9467bd", "#bcbd22", "#e377c2", "#17becf", "#8c564b", "#2ca02c")


def sections_of(study: PayloadData, style: Style) -> list[Section]:
    """The sections of the report."""
    rig, frame = study.rig, study.frame
    clearance = style.text("none") if study.clearance is None else style.value(study.clearance, "length")
    given = [(style.text("clearance_asked"), clearance)]
    if study.saddle_angle is not None:
        least, most = study.saddle_angle
        angles = f"{style.value(least, 'angle', 'up')} - {style.value(most, 'angle', 'down')}"
        given.append((style.text("saddle_angle_asked"), angles))
    if study.roller_force is not None:
        given.append((style.text("roller_force_asked"), style.value(study.roller_force, "force", "down")))
    return [
        Section(style.text("payload"), (Text((_headline(study, style),)),)),
        warnings_of(study.remarks_in(style), style),
        rig_sections.inputs(rig, style, (study.safety_factor, study.mainline_safety_factor), given),
        Section(style.text("profile"), (_player(study, style),)),
        Section(style.text("payload_by_station"), (_payloads(study, style), tensions(study, style))),
        rig_sections.supports(rig, frame, style),
        rig_sections.anchors(rig, frame, style),
        *rig_sections.staking(rig, style),
        rig_sections.set_up(rig, style),
        Section(style.text("stations"), (rig_sections.stations_table(frame, _COLUMNS, style),)),
    ]


_COLUMNS: tuple[tuple[str, str, str | None, Any], ...] = (
    ("station", "station", "length", "near"),
    ("payload", "payload", "mass", "down"),
    ("limited_by", "limited_by", None, None),
    ("held_by", "held_by", None, None),
    ("highest_tension", "skyline", "force", "up"),
    ("mainline_highest", "mainline", "force", "up"),
    ("haulback_highest", "haulback", "force", "up"),
    ("deflection", "deflection", "deflection", "near"),
    ("clearance", "clearance", "length", "down"),
    ("rope_clearance", "rope_clearance", "length", "down"),
)


def _headline(study: PayloadData, style: Style) -> str:
    worst = study.limiting
    key = "corridor_payload" if study.payload > 0.0 else "no_payload"
    station, limit = style.value(worst["station"], "length"), str(worst["limited_by"])
    return style.text(key, payload=style.value(study.payload, "mass", "down"), station=station, limit=limit)


def _player(study: PayloadData, style: Style) -> Any:
    """The rig with its carriage at all stations, each with its largest payload."""
    frame = study.frame
    places = frame[frame["carriage_z"].notna()] if "carriage_z" in frame else frame
    places = places.iloc[np.unique(np.linspace(0, len(places) - 1, min(FRAMES, len(places))).astype(int))]
    values = [
        (style.text("payload"), [style.value(v, "mass", "down") for v in places["payload"]]),
        (style.text("limited_by"), list(map(str, places["limited_by"]))),
    ]
    for column, label, _ in TENSIONS:
        if column in places and places[column].max() > 0.0:
            values.append((style.text(label), [style.value(v, "force", "up") for v in places[column]]))
    for column in ("clearance", "rope_clearance"):
        if column in places and places[column].notna().any():
            values.append((style.text(column), [style.value(v, "length", "down") for v in places[column]]))
    stations = places["station"].to_numpy(float)
    return rig_player(
        study.rig,
        Places(
            stations,
            places["payload"].to_numpy(float),
            places["carriage_z"].to_numpy(float) if study.lowered else None,
            [f"{style.text('station')} {style.value(x, 'length')}" for x in stations],
            values,
            style.scaled(stations, "length").tolist(),
            start=int(np.argmin(np.abs(stations - float(study.limiting["station"])))),
        ),
        style,
    )


def _payloads(study: PayloadData, style: Style) -> Chart:
    """Payload by station, in the colour of its limit."""
    frame = study.frame
    x, y = style.scaled(frame["station"], "length"), style.scaled(frame["payload"], "mass")
    traces = [curve(x, y, style.text("payload"), "#bbb", width=1.0, shown=False, hoverinfo="skip")]
    for k, (limit, part) in enumerate(frame.groupby("limited_by", sort=False)):
        at, mass = style.scaled(part["station"], "length"), style.scaled(part["payload"], "mass")
        traces.append(dots(at, mass, f"{style.text('limited_by')} {limit}", _COLOURS[k % len(_COLOURS)], size=6))
    level = style.scaled([study.payload, study.payload], "mass")
    name = style.value(study.payload, "mass", "down")
    traces.append(curve(x[[0, -1]], level, name, "#111", width=1.0, dash="dash"))
    carried = y[y > 0.0] if np.any(y > 0.0) else np.ones(1)  # a station beside a support may carry many times more
    top = max(1.25 * float(np.quantile(carried, 0.9)), 1.5 * float(level[0]))
    axes = {
        "xaxis": axis(style.head("station", "length"), range=_range(study, style)),
        "yaxis": axis(style.head("payload", "mass"), range=[0.0, top]),
        "hovermode": "closest",
    }
    return Chart("payloads", traces, axes, marked=True)


def tensions(study: PayloadData, style: Style) -> Chart:
    """Highest tensions by station under its largest payload, against the safe working loads."""
    frame, rig = study.frame, study.rig
    x = style.scaled(frame["station"], "length")
    traces, ropes = [], dict(rig_sections.ropes_of(rig))
    for column, label, colour in TENSIONS:
        rope = ropes.get(label, rig.skyline if label == "skyline" else None)
        if rope is None or column not in frame or not frame[column].max() > 0.0:
            continue
        factor = study.safety_factor if label == "skyline" else study.mainline_safety_factor
        traces.append(curve(x, style.scaled(frame[column], "force"), style.text(label), colour))
        limits = limit_curves(rope, factor, style.text(label), (float(x[0]), float(x[-1])), style)
        traces += [{**limit, "line": {**limit["line"], "color": colour}} for limit in limits]
    axes = {
        "xaxis": axis(style.head("station", "length"), range=_range(study, style)),
        "yaxis": axis(style.head("tension", "force")),
    }
    return Chart("tensions", traces, axes, marked=True)


def _range(study: PayloadData, style: Style) -> list[float]:
    x = study.rig.points[:, 0]
    room = 0.03 * float(np.ptp(x))
    return [float(v) for v in style.scaled([x.min() - room, x.max() + room], "length")]
