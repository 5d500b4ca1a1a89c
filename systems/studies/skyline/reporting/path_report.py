"""Reports of a load path and of an inhaul."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.systems.reporting.blocks import Chart, Section, Table, axis, curve
from ropeway.systems.reporting.document import Project, ReportOptions, warnings_of, write_report
from ropeway.systems.reporting.style import Style, Units
from ropeway.systems.results.result_report import limit_curves
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.skyline.reporting import rig_sections
from ropeway.systems.studies.skyline.reporting.rig_player import FRAMES, Places, rig_player
from ropeway.systems.studies.skyline.reporting.rig_sections import TENSIONS

_OWN = (None, None)
"""Safety factors of skyline and other ropes; None: each rope's own."""
_COLUMNS: tuple[tuple[str, str, str | None, Any], ...] = (
    ("station", "station", "length", "near"),
    ("held_by", "held_by", None, None),
    ("highest_tension", "skyline", "force", "up"),
    ("headspar_tension", "pretension_head", "force", "up"),
    ("mainline_highest", "mainline", "force", "up"),
    ("haulback_highest", "haulback", "force", "up"),
    ("sag", "largest_sag", "short_length", "near"),
    ("deflection", "deflection", "deflection", "near"),
    ("clearance", "clearance", "length", "down"),
    ("rope_clearance", "rope_clearance", "length", "down"),
)


@checked
def load_path_report(
    rig: SkylineRig,
    payload: float,
    frame: pd.DataFrame,
    path: str | Path,
    *,
    project: Project | None = None,
    units: Units = "metric",
    labels: Mapping[str, str] | None = None,
    more: Sequence[Section] = (),
) -> Path:
    """Write the report of a load path.

    Parameters
    ----------
    rig : SkylineRig
        The rig.
    payload : float
        Payload of the load path [kg].
    frame : DataFrame
        Load path from `rw.load_path(rig, payload)`.
    path : str or Path
        Path of an HTML file, or of a PDF printed by a browser; needs the extra `report`.
    project : Project, optional
        Title, place, client, author and a remark.
    units : {"metric", "imperial"}, default "metric"
        System of units.
    labels : mapping, optional
        Replacements for words in `ropeway.systems.reporting.labels.ENGLISH`, by key.
    more : sequence of Section, optional
        Additional sections at the end.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        The frame is not a load path.
    WriteError
        The file could not be written.

    Examples
    --------
    >>> path = rw.load_path(rig, 2500.0, [100.0, 200.0])
    >>> rw.load_path_report(rig, 2500.0, path, "path.html").name
    'path.html'
    """
    if not {"station", "carriage_z", "highest_tension"} <= set(frame.columns):
        raise InputError("The frame is not a load path", "Give the frame of rw.load_path(rig, payload)")
    options = ReportOptions(project, units, labels, more)
    style = options.style
    loaded = frame.assign(payload=payload)
    title = f"{rig.name}: {style.text('load_path')} {style.text('with_payload', payload=style.value(payload, 'mass'))}"
    given = [(style.text("payload"), style.value(payload, "mass"))]
    sections = [
        warnings_of(list(_warnings(rig, loaded, style)), style),
        rig_sections.inputs(rig, style, _OWN, given),
        Section(
            style.text("profile"), (_player(rig, loaded, style, "station"), _tensions(rig, loaded, style, "station"))
        ),
        *_common(rig, loaded, style),
        Section(style.text("load_path"), (rig_sections.stations_table(loaded, _COLUMNS, style),)),
    ]
    return write_report(path, title, sections, options)


def inhaul_sections(rig: SkylineRig, frame: pd.DataFrame, events: pd.DataFrame, style: Style) -> list[Section]:
    """The sections of an inhaul's report."""
    rows = [
        (style.number(e.time, "time"), str(e.event), style.number(e.station, "length")) for e in events.itertuples()
    ]
    head = (style.head("time", "time"), style.text("event"), style.head("station", "length"))
    return [
        warnings_of(list(_warnings(rig, frame, style)), style),
        rig_sections.inputs(rig, style, _OWN, [(style.text("duration"), style.value(frame.index[-1], "time"))]),
        Section(
            style.text("inhaul"),
            (_player(rig, frame, style, "time", events), _tensions(rig, frame, style, "time"), _powers(frame, style)),
        ),
        *_common(rig, frame, style),
        Section(style.text("events"), (Table(head, rows),)),
    ]


def _common(rig: SkylineRig, frame: pd.DataFrame, style: Style) -> list[Section]:
    return [
        rig_sections.supports(rig, frame, style),
        rig_sections.anchors(rig, frame, style),
        *rig_sections.staking(rig, style),
        rig_sections.set_up(rig, style),
    ]


def _warnings(rig: SkylineRig, frame: pd.DataFrame, style: Style) -> Iterator[str]:
    """Warnings: ropes above their safe working load, supports with lift-off."""
    ropes = dict(rig_sections.ropes_of(rig))
    for column, label, _ in TENSIONS:
        rope = ropes.get(label, rig.skyline if label == "skyline" else None)
        if rope is None or column not in frame:
            continue
        highest = float(frame[column].max())
        for key, limit in (("above_mbl", rope.breaking_load), ("above_swl", rope.safe_working_load)):
            if highest > limit:
                values = {"tension": style.value(highest, "force", "up"), "limit": style.value(limit, "force", "down")}
                yield style.text(key, what=style.text(label), **values)
                break
    for support in rig.supports:
        if f"{support.name}_force" in frame and float(frame[f"{support.name}_force"].min()) < 0.0:
            yield style.text("lifts_off", support=support.name)
    for column in ("clearance", "rope_clearance", "mainline_clearance", "haulback_clearance"):
        if column in frame and float(frame[column].min()) < 0.0:
            height = style.value(frame[column].min(), "length", "down")
            yield style.text("below_ground", what=style.text(column), height=height)


def _player(rig: SkylineRig, frame: pd.DataFrame, style: Style, over: str, events: pd.DataFrame | None = None) -> Any:
    """The carriage along its path, over stations or over time."""
    shown = frame[frame["carriage_z"].notna()]
    shown = shown.iloc[np.unique(np.linspace(0, len(shown) - 1, min(FRAMES, len(shown))).astype(int))]
    marks = shown.index.to_numpy(float) if over == "time" else shown["station"].to_numpy(float)
    quantity = "time" if over == "time" else "length"
    values = [(style.text("payload"), [style.value(v, "mass") for v in shown["payload"]])]
    if over == "time":
        values.append((style.text("station"), [style.value(v, "length") for v in shown["carriage_x"]]))
    for column, label, _ in TENSIONS:
        if column in shown and shown[column].max() > 0.0:
            values.append((style.text(label), [style.value(v, "force", "up") for v in shown[column]]))
    if "clearance" in shown and shown["clearance"].notna().any():
        values.append((style.text("clearance"), [style.value(v, "length", "down") for v in shown["clearance"]]))
    happened: list[tuple[int, str]] = []
    if events is not None:
        frames = np.minimum(np.searchsorted(marks, events["time"].to_numpy(float)), len(marks) - 1)
        texts = [f"{style.value(e.time, 'time')}: {e.event}" for e in events.itertuples()]
        happened = list(zip(frames.tolist(), texts, strict=True))
    x = shown["carriage_x"].to_numpy(float)
    heights = None if not rig.kind.sets_height or over == "time" else shown["carriage_z"].to_numpy(float)
    labels = [f"{style.text(over)} {style.value(m, quantity)}" for m in marks]
    places = Places(
        x, shown["payload"].to_numpy(float), heights, labels, values, style.scaled(marks, quantity).tolist(), happened
    )
    return rig_player(rig, places, style)


def _tensions(rig: SkylineRig, frame: pd.DataFrame, style: Style, over: str) -> Chart:
    ropes, traces = dict(rig_sections.ropes_of(rig)), []
    quantity = "time" if over == "time" else "length"
    x = style.scaled(frame.index if over == "time" else frame["station"], quantity)
    for column, label, colour in TENSIONS:
        rope = ropes.get(label, rig.skyline if label == "skyline" else None)
        if rope is None or column not in frame or not frame[column].max() > 0.0:
            continue
        traces.append(curve(x, style.scaled(frame[column], "force"), style.text(label), colour))
        limits = limit_curves(rope, rope.safety_factor, style.text(label), (float(x[0]), float(x[-1])), style)
        traces += [{**limit, "line": {**limit["line"], "color": colour}} for limit in limits]
    axes = {"xaxis": axis(style.head(over, quantity)), "yaxis": axis(style.head("tension", "force"))}
    return Chart("tensions", traces, axes, marked=True)


def _powers(frame: pd.DataFrame, style: Style) -> Chart:
    x = style.scaled(frame.index, "time")
    traces = [curve(x, style.scaled(frame["drum_power"], "power"), style.text("mainline"), "#d62728")]
    if float(frame["haulback_power"].abs().max()) > 0.0:
        traces.append(curve(x, style.scaled(frame["haulback_power"], "power"), style.text("haulback"), "#1f77b4"))
    axes = {"xaxis": axis(style.head("time", "time")), "yaxis": axis(style.head("power", "power")), "height": 260}
    return Chart("powers", traces, axes, marked=True)
