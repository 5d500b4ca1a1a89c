"""Common sections of reports of a rig: inputs, supports, anchors, staking-out list, rope lengths and set-up."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np
import pandas as pd

from ropeway.components.errors import EquilibriumError, SlackRopeError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.map_frame import MapFrame
from ropeway.components.rope import Rope
from ropeway.systems.exchange.places import places
from ropeway.systems.reporting.blocks import Chart, Section, Table, axis, curve, dots
from ropeway.systems.reporting.document import values_of
from ropeway.systems.reporting.style import Style
from ropeway.systems.results.result_report import ropes_table
from ropeway.systems.rigs.bare_skyline import bare_tension
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.rigs.stringing_table import report_table

TENSIONS = (
    ("highest_tension", "skyline", "#111"), ("mainline_highest", "mainline", "#d62728"),
    ("haulback_highest", "haulback", "#1f77b4"), ("dropline_tension", "dropline", "#2ca02c"),
)  # fmt: skip
"""Columns of tensions, with their rope and its colour."""


def inputs(
    rig: SkylineRig, style: Style, factors: tuple[float | None, float | None], more: Sequence[tuple[str, str]]
) -> Section:
    """The declared rig. `factors` are safety factors of the skyline and of the other ropes; None: each rope's own."""
    rows = [(style.text("kind"), f"{rig.kind.name} skyline"), *more]
    if rig.tension is not None:
        rows.append((style.text("pretension"), style.value(rig.tension, "force")))
    if rig.haulback_tension is not None:
        rows.append((style.text("haulback_tension"), style.value(rig.haulback_tension, "force")))
    rows += [
        (style.text("carriage_mass"), style.value(rig.carriage.mass, "mass")),
        (style.text("load_depth"), style.value(rig.carriage.depth, "length")),
        (style.text("gravity"), f"{rig.gravity:g} m/s²"),
    ]
    if rig.environment is not None:
        rows.append((style.text("weather"), rig.environment.words))
    ropes = [(style.text(use), rope, _factor(rope, use, factors)) for use, rope in ropes_of(rig)]
    return Section(style.text("inputs"), (values_of(rows, style), ropes_table(ropes, style)))


def ropes_of(rig: SkylineRig) -> list[tuple[str, Rope]]:
    """The ropes of a rig by use, with equal guylines once."""
    found: list[tuple[str, Rope]] = [(rig.kind.carrying_rope, rig.skyline)]
    for use, rope in (("mainline", rig.mainline), ("haulback", rig.haulback)):
        if rope is not None:
            found.append((use, rope))
    if rig.turn is not None:
        found.append(("dropline", rig.turn.dropline))
    for spar in (rig.headspar, rig.tailspar):
        if isinstance(spar, GuyedSpar):
            found += [("guyline", rope) for rope in dict.fromkeys(guy.rope for guy in spar.guylines)]
    return found


def _factor(rope: Rope, use: str, factors: tuple[float | None, float | None]) -> float:
    first, others = factors
    factor = first if rope is not None and use == "skyline" else others
    return rope.safety_factor if factor is None else factor


def supports(rig: SkylineRig, frame: pd.DataFrame, style: Style) -> Section:
    """Spars and supports: heights, break angles and forces over all rows, saddles."""
    rows = []
    for node in rig.stands:
        x, _, z = node.at
        ground = None if rig.terrain is None else float(rig.terrain.elevations(x))
        low, high = _range(frame, f"{node.name}_force")
        least, most = _range(frame, f"{node.name}_break_angle")
        saddle = _saddle(node, style) if isinstance(node, IntermediateSupport) else ""
        rows.append(
            (
                node.name, style.number(x, "length"), style.number(ground, "length"),
                style.number(None if ground is None else z - ground, "length"), style.number(z, "length"),
                style.number(least, "angle", "down"), style.number(most, "angle", "up"),
                style.number(high, "force", "up"), style.number(low, "force", "down"),
                style.number(getattr(node, "capacity", None), "force", "down"), saddle,
            )
        )  # fmt: skip
    head = (
        style.text("support"), style.head("station", "length"), style.head("ground_elevation", "length"),
        style.head("height", "length"), style.head("top", "length"), style.head("least_break_angle", "angle"),
        style.head("largest_break_angle", "angle"), style.head("highest_force", "force"),
        style.head("lowest_force", "force"), style.head("capacity", "force"), style.text("saddle"),
    )  # fmt: skip
    return Section(style.text("supports"), (Table(head, rows),))


def _range(frame: pd.DataFrame, column: str) -> tuple[float | None, float | None]:
    """Lowest and highest value of a column; None without values."""
    if column not in frame or frame[column].isna().all():
        return None, None
    return float(frame[column].min()), float(frame[column].max())


def _saddle(support: IntermediateSupport, style: Style) -> str:
    shape = style.text("saddle_point")
    if support.radius > 0.0:
        shape = style.text("saddle_radius", radius=style.value(support.radius, "short_length"))
    if support.friction > 0.0:
        shape += f", {style.text('saddle_friction', friction=f'{support.friction:g}')}"
    return shape


def anchors(rig: SkylineRig, frame: pd.DataFrame, style: Style) -> Section:
    """Anchors with their highest tensions over all rows."""
    rows: list[tuple[str, ...]] = []

    def add(name: str, kind: str, at: Sequence[float], columns: Sequence[str], capacity: float | None) -> None:
        highest = max((v for c in columns if (v := _range(frame, c)[1]) is not None), default=None)
        rows.append(
            (
                name, kind, style.number(at[0], "length"), style.number(at[1], "length"), style.number(at[2], "length"),
                style.number(highest, "force", "up"), style.number(capacity, "force", "down"),
            )
        )  # fmt: skip

    head, tail, hold = rig.headspar, rig.tailspar, rig.tailspar.tailhold
    for spar, column, prefix in ((head, "headspar_tension", "spar"), (tail, "tailspar_tension", "tailspar")):
        add(spar.name, type(spar).__name__, spar.at, (column,), spar.capacity)
        if isinstance(spar, GuyedSpar):
            add(spar.name, style.text("compression"), spar.foot, (f"{prefix}_compression",), spar.capacity)
            for guy in spar.guylines:
                add(guy.name, style.text("guyline"), guy.at, (f"{guy.name}_tension",), None)
    if hold is not None:
        add(hold.name, type(hold).__name__, hold.at, ("anchor_tension",), hold.capacity)
    unit = style.shown("length").unit
    names = (
        style.text("anchor"), style.text("kind"), *(f"{a} [{unit}]" for a in "xyz"),
        style.head("highest_tension", "force"), style.head("capacity", "force"),
    )  # fmt: skip
    return Section(style.text("anchors"), (Table(names, rows, texts=2),))


def set_up(rig: SkylineRig, style: Style) -> Section:
    """Rope lengths, and the tension of the bare rope."""
    chord = float(np.linalg.norm(np.diff(rig.points, axis=0), axis=1).sum())
    reach = float(np.linalg.norm(np.diff(rig.points[: rig.spans + 1], axis=0), axis=1).sum())
    rows = [(style.text("chord"), style.value(chord, "length", "up"))]
    if rig.length is not None:
        rows.append((style.text("unstretched"), style.value(rig.length, "short_length")))
    if rig.kind.keeps_length:
        rows.append((style.text("bare_tension"), style.value(bare_tension(rig), "force")))
    if rig.pulled:
        rows.append((style.text("mainline_needed"), style.value(reach, "length", "up")))
    if rig.haulback is not None or not rig.kind.keeps_length:
        rows.append((style.text("haulback_needed"), style.value(2.0 * reach, "length", "up")))
    return Section(style.text("set_up"), (values_of(rows, style), *_stringing(rig, style)))


def _stringing(rig: SkylineRig, style: Style) -> tuple[Table, ...]:
    """The stringing table of the bare skyline; none of a rope whose drum keeps its tension, or that would be slack."""
    if not rig.kind.keeps_length:
        return ()
    try:
        return (report_table(rig, style),)
    except (EquilibriumError, SlackRopeError):
        return ()


def staking(rig: SkylineRig, style: Style) -> list[Section]:
    """Staking-out list: map coordinates if known, directions and distances."""
    table = places(rig)
    columns: list[tuple[str, str, str | None, Any]] = [
        ("label", "name", None, None), ("kind", "kind", None, None), ("easting", "easting", "map", "near"),
        ("northing", "northing", "map", "near"), ("elevation", "elevation", "short_length", "near"),
        ("seen_from", "from", None, None), ("azimuth", "azimuth", "degrees", "near"),
        ("distance", "distance", "short_length", "near"), ("slope_distance", "slope_distance", "short_length", "near"),
    ]  # fmt: skip
    known = [c for c in columns if c[0] in table]
    rows = [tuple(_cell(row[name], quantity, style) for name, _, quantity, _ in known) for _, row in table.iterrows()]
    heads = [style.head(label, None if quantity == "map" else quantity) for _, label, quantity, _ in known]
    list_section = Section(style.text("staking"), (Table(tuple(heads), rows, style.text("azimuth_note"), texts=2),))
    return [list_section] if rig.map_frame is None else [_map(rig, table, style), list_section]


def _cell(value: Any, quantity: str | None, style: Style) -> str:
    if value is None or (not isinstance(value, str) and pd.isna(value)):
        return "-"
    if quantity is None:
        return str(value)
    return f"{float(value):.2f}" if quantity == "map" else style.number(value, quantity)


def _map(rig: SkylineRig, table: pd.DataFrame, style: Style) -> Section:
    """The corridor in map coordinates, to scale."""
    frame, x = cast(MapFrame, rig.map_frame), rig.points[:, 0]
    line = curve(
        *frame.to_map(np.linspace(x.min(), x.max(), 60)), style.text("line"), "#111", width=2.0, hoverinfo="skip"
    )
    names = [str(label) for label in table["label"]]
    marks = dots(
        table["easting"], table["northing"], style.text("supports"), "#7a5230", text=names, mode="markers+text",
        textposition="top center", hoverinfo="text+x+y",
    )  # fmt: skip
    axes = {
        "height": 460, "hovermode": "closest",
        "xaxis": axis(style.text("easting"), tickformat=".0f"),
        "yaxis": axis(style.text("northing"), tickformat=".0f", scaleanchor="x", scaleratio=1.0),
    }  # fmt: skip
    return Section(style.text("map"), (Chart("map", [line, marks], axes, frame.crs[:80]),))


def stations_table(
    frame: pd.DataFrame, columns: Sequence[tuple[str, str, str | None, Any]], style: Style, texts: int = 1
) -> Table:
    """Rows of a frame. `columns` gives the name in the frame, label, quantity (None for text) and direction of
    rounding."""
    known = [c for c in columns if c[0] in frame and (c[2] is None or frame[c[0]].fillna(0.0).any())]
    rows = [
        tuple(
            str(row[name]) if quantity is None else style.number(row[name], quantity, side)
            for name, _, quantity, side in known
        )
        for _, row in frame.iterrows()
    ]
    return Table(tuple(style.head(label, quantity) for _, label, quantity, _ in known), rows, texts=texts)
