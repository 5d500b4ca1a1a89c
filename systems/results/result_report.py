"""The report of a simulation: ropes, supports, tensions over time, and an animation of the line with its loads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ropeway.components.node import Node
from ropeway.components.rope import Rope
from ropeway.systems.reporting.blocks import Block, Chart, Moving, Player, Section, Table, axis, curve, dots
from ropeway.systems.reporting.document import values_of, warnings_of
from ropeway.systems.reporting.style import Style
from ropeway.systems.results.energy_balance import power
from ropeway.systems.results.summary import Summary, each_node

if TYPE_CHECKING:
    from ropeway.systems.modelling.rope_path import Run
    from ropeway.systems.results.run_data import RunData
    from ropeway.systems.statics.equilibrium import Equilibrium

FRAMES = 150
"""Largest number of frames of a player."""
MOST_EVENTS, MOST_POINTS = 120, 1200
"""Largest numbers of events in a list, and of points of a curve."""
_POINTS = 7
"""Points of a span's curve in addition to its loads."""
_SHEAVES = 8
"""Largest number of control sheaves with a separate curve."""
_COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#9467bd", "#8c564b", "#e377c2", "#bcbd22", "#17becf")


def sections_of(result: RunData, summary: Summary, style: Style) -> list[Section]:
    """The sections of a run's report."""
    player, tensions = line_player(result, style), tensions_chart(result, style)
    return [
        warnings_of(list(_warnings(result, summary, style)), style),
        Section(style.text("inputs"), (values_of(_inputs(result, style), style), ropes_table(ropes_in(result), style))),
        Section(style.text("simulation"), (player, tensions)),
        Section(style.text("supports"), (_supports(result, summary, style),)),
        Section(style.text("spans"), (_spans(summary, style),)),
        *_drives(result, style),
        Section(style.text("staking"), tuple(_legs(run, style) for run in result.runs)),
        Section(style.text("events"), _events(result, style)),
    ]


def ropes_table(ropes: Sequence[tuple[str, Rope, float]], style: Style) -> Table:
    """Ropes by use with the applicable safety factor; limits are rounded down."""
    head = (
        style.text("use"), style.text("rope"), style.head("diameter", "diameter"),
        style.head("mass_per_length", "mass_per_length"), style.head("stiffness", "stiffness"),
        style.head("breaking_load", "force"), style.text("safety_factor"), style.head("working_load", "force"),
    )  # fmt: skip
    rows = [
        (
            use, rope.name, style.number(rope.diameter, "diameter"),
            style.number(rope.mass_per_length, "mass_per_length"), style.number(rope.axial_stiffness, "stiffness"),
            style.number(rope.breaking_load, "force", "down"), style.number(factor, "number", "up"),
            style.number(rope.breaking_load / factor, "force", "down"),
        )
        for use, rope, factor in ropes
    ]  # fmt: skip
    return Table(head, rows, texts=2)


def limit_curves(rope: Rope, factor: float, name: str, span: tuple[float, float], style: Style) -> list[dict[str, Any]]:
    """Horizontal lines at the safe working load and the breaking load, between two abscissas."""
    found = []
    for key, value, dash in (("swl_of", rope.breaking_load / factor, "dash"), ("mbl_of", rope.breaking_load, "dot")):
        level = style.scaled([value, value], "force")
        more = {"dash": dash, "width": 1.2, "hoverinfo": "skip"}
        if key == "mbl_of":
            more["visible"] = "legendonly"
        found.append(curve(list(span), level, style.text(key, name=name), "#d62728", **more))
    return found


def ropes_in(result: RunData) -> list[tuple[str, Rope, float]]:
    """The ropes of a run, named by their ends, with their safety factors."""
    found: dict[Rope, str] = {}
    for run in result.runs:
        for span in run.spans:
            found.setdefault(span.rope, run.name)
    return [(use, rope, rope.safety_factor) for rope, use in found.items()]


def _inputs(result: RunData, style: Style) -> list[tuple[str, str]]:
    rows = [(style.text("line"), result.model.name)]
    for run in result.runs:
        loads = run.loads.mass[run.loads.mass > 0.0]
        chord = float(np.linalg.norm(np.diff(run.points, axis=0), axis=1).sum())
        masses = [style.value(m, "mass") for m in (loads.min(), loads.max())] if len(loads) else []
        rows += [
            (f"{style.text('spans')} ({run.name})", str(len(run.spans))),
            (style.text("chord"), style.value(chord, "length")),
            (
                style.text("loads"),
                f"{len(loads)}: {' - '.join(dict.fromkeys(masses))}" if masses else style.text("none"),
            ),
        ]
    environment = result.model.system.environment
    return [
        *rows,
        (style.text("duration"), style.value(result.times[-1], "time")),
        (style.text("gravity"), f"{result.model.system.gravity:g} m/s²"),
        *(() if environment is None else ((style.text("weather"), environment.words),)),
    ]


def _warnings(result: RunData, summary: Summary, style: Style) -> Iterator[str]:
    """Warnings: tensions above limits, and undesired events."""
    for run in result.runs:
        for rope in dict.fromkeys(span.rope for span in run.spans):
            own = summary.spans.loc[[s.name for s in run.spans if s.rope == rope], "highest_tension"]
            highest = float(own.max())
            for key, limit in (("above_mbl", rope.breaking_load), ("above_swl", rope.safe_working_load)):
                if highest > limit:
                    tension, allowed = style.value(highest, "force", "up"), style.value(limit, "force", "down")
                    yield style.text(key, what=str(own.idxmax()), tension=tension, limit=allowed)
                    break
    events = result.events
    bad = {event for event in result.model.limits.events if not event.startswith("tension above")} | {"load held"}
    for event, rows in events[events["event"].isin(bad)].groupby("event", sort=False):
        first = rows.iloc[0]
        time = style.value(first["time"], "time")
        yield style.text("happened", event=event, count=len(rows), component=first["component"], time=time)


def line_player(result: RunData, style: Style) -> Player:
    """The moving line with its loads."""
    grid = np.flatnonzero(result.on_grid)
    chosen = grid[np.unique(np.linspace(0, len(grid) - 1, min(FRAMES, len(grid))).astype(int))].tolist()
    ropes: list[list[np.ndarray]] = [[], []]
    loads: list[list[np.ndarray]] = [[], []]
    for i in chosen:
        for kept, found in zip((ropes, loads), shape_of(result.record(i)), strict=True):
            for own, points in zip(kept, found, strict=True):
                own.append(style.scaled(points, "length"))
    times, frame = result.times[chosen], result.full_frame.iloc[chosen]
    ends = frame.filter(regex=r"\.tension_[ab]$")
    highest, lowest = ends.max(axis=1), ends.min(axis=1)
    values = [
        (style.text("highest_of_all"), [style.value(v, "force", "up") for v in highest]),
        (style.text("lowest_of_all"), [style.value(v, "force", "down") for v in lowest]),
        *(
            (
                style.text("coming_in", name=node.label),
                [style.value(v, "force", "up") for v in frame[f"{node.name}.tension_in"]],
            )
            for node in _driven(result)
        ),
    ]
    chart = Chart("line", [*_still(result, style), *_moving_traces(style)], _layout(result, style))
    still = len(chart.traces) - 2
    return Player(
        chart,
        [f"{style.text('time')} {style.value(t, 'time')}" for t in times],
        [Moving(still, ropes[0], ropes[1]), Moving(still + 1, loads[0], loads[1])],
        marks=[float(t) for t in times],
        values=values,
        events=_player_events(result, times, style),
    )


def _player_events(result: RunData, times: np.ndarray, style: Style) -> list[tuple[int, str]]:
    events = result.events[~result.events["event"].str.startswith("crossing")].head(MOST_EVENTS)
    frames = np.minimum(np.searchsorted(times, events["time"].to_numpy(dtype=float)), len(times) - 1)
    texts = [f"{style.value(e.time, 'time')}: {e.event}, {e.component}" for e in events.itertuples()]
    return list(zip(frames.tolist(), texts, strict=True))


def shape_of(line: Equilibrium) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Distances along the line and heights of ropes (NaN between spans) and of loads."""
    along = {}
    curves = []
    for r, run in enumerate(line.runs):
        points = line.points(r)
        at = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points[:, :2], axis=0).T))])
        for k, span in enumerate(run.spans):
            along[span.name] = (at[k], *points[k, :2])
            shape = line.profile(span.name, _POINTS)[["x", "y", "z"]].to_numpy()
            curves.append(np.column_stack([_distances(shape[:, :2], *along[span.name]), shape[:, 2]]))
            curves.append(np.full((1, 2), np.nan))
    loads = line.loads
    starts = np.array([along[span] for span in loads["span"]]).reshape(-1, 3)
    places = loads[["x", "y"]].to_numpy(dtype=float)
    hung = starts[:, 0] + np.hypot(*(places - starts[:, 1:]).T)
    rope = np.concatenate(curves)
    return (rope[:, 0], rope[:, 1]), (hung, loads["z"].to_numpy(dtype=float))


def _distances(points: np.ndarray, along: float, x: float, y: float) -> np.ndarray:
    return np.asarray(along + np.hypot(points[:, 0] - x, points[:, 1] - y))


def _still(result: RunData, style: Style) -> list[dict[str, Any]]:
    """Supports, by their kind."""
    kinds: dict[str, list[tuple[float, float, str]]] = {}
    for run in result.runs:
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(run.points[:, :2], axis=0).T))])
        for node, x in zip(run.nodes, along.tolist(), strict=True):
            _, _, height = node.at
            kinds.setdefault(node.role, []).append((x, height, node.label))
    symbols = {"control sheave": "square", "drum": "diamond", "anchor": "triangle-up"}
    colours = {"control sheave": "#d62728", "drum": "#9467bd", "anchor": "#8c564b"}
    found = []
    for kind, places in kinds.items():
        x, z = (style.scaled([p[i] for p in places], "length") for i in (0, 1))
        symbol, colour = symbols.get(kind, "circle"), colours.get(kind, "#888")
        found.append(dots(x, z, kind, colour, symbol=symbol, text=[p[2] for p in places], hoverinfo="text+name"))
    return found


def _moving_traces(style: Style) -> list[dict[str, Any]]:
    rope = curve([], [], style.text("rope"), "#1f77b4", width=1.4, hoverinfo="skip", connectgaps=False)
    return [rope, dots([], [], style.text("loads"), "#2ca02c", size=7, hoverinfo="x+y")]


def _layout(result: RunData, style: Style) -> dict[str, Any]:
    points = np.vstack([run.points for run in result.runs])
    low, high = style.scaled([points[:, 2].min(), points[:, 2].max()], "length")
    room = 0.1 * (high - low) + 0.005 * float(style.scaled(np.ptp(points[:, 0]), "length")) + 2.0
    return {
        "height": 380,
        "hovermode": "closest",
        "xaxis": axis(style.head("along", "length")),
        "yaxis": axis(style.head("height", "length"), range=[low - room, high + room]),
    }


def tensions_chart(result: RunData, style: Style) -> Chart:
    """Highest and lowest tension of all spans and those of the control sheaves over time, against the limits."""
    frame = thinned(result.full_frame)
    ends, time = frame.filter(regex=r"\.tension_[ab]$"), frame.index.to_numpy()
    traces = [
        curve(time, style.scaled(ends.max(axis=1), "force"), style.text("highest_of_all"), "#222", width=1.8),
        curve(time, style.scaled(ends.min(axis=1), "force"), style.text("lowest_of_all"), "#999"),
    ]
    for node, colour in zip(_driven(result), _COLOURS, strict=False):
        values = style.scaled(frame[f"{node.name}.tension_in"], "force")
        traces.append(curve(time, values, style.text("coming_in", name=node.label), colour, width=1.1))
    for use, rope, factor in ropes_in(result):
        traces += limit_curves(rope, factor, use, (float(time[0]), float(time[-1])), style)
    axes = {"xaxis": axis(style.head("time", "time")), "yaxis": axis(style.head("tension", "force"))}
    return Chart("tensions", traces, axes, marked=True)


def thinned(frame: pd.DataFrame) -> pd.DataFrame:
    """A frame reduced to the rows of a drawing; the extremes of the omitted rows are kept."""
    step = -(-len(frame) // MOST_POINTS)
    if step <= 1:
        return frame
    numbers = frame.select_dtypes("number")
    groups = np.arange(len(frame)) // step
    pairs = [numbers.groupby(groups).max(), numbers.groupby(groups).min()]
    starts = frame.index[::step]
    halves = starts + 0.5 * np.diff(frame.index[: step + 1])[0] * step / 2.0
    for part, index in zip(pairs, (starts, halves), strict=True):
        part.index = pd.Index(index, name=frame.index.name)
    found = pd.concat(pairs).sort_index(kind="stable")
    found.attrs = {}
    return found


def _driven(result: RunData) -> list[Node]:
    """Control sheaves, up to the number that a chart shows."""
    nodes = [
        n for n in each_node(result.runs) if n.drive_speed is not None and f"{n.name}.tension_in" in result.full_frame
    ]
    return nodes[:_SHEAVES]


def _supports(result: RunData, summary: Summary, style: Style) -> Table:
    frame, rows = result.full_frame, list[tuple[str, ...]]()
    for node in each_node(result.runs):
        own = summary.supports.loc[node.name]
        force = frame.get(f"{node.name}.bearing_load", frame.get(f"{node.name}.tension"))
        turn = frame.get(f"{node.name}.wrap")
        low, high = (None, None) if force is None else (force.min(), force.max())
        rows.append(
            (
                node.label, node.role, *(style.number(v, "length") for v in node.at),
                style.number(None if turn is None else turn.abs().max(), "angle"),
                style.number(high, "force", "up"), style.number(low, "force", "down"),
                style.number(own["highest_tension"], "force", "up"),
            )
        )  # fmt: skip
    head = (
        style.text("support"), style.text("kind"), "x [m]", "y [m]", "z [m]", style.head("break_angle", "angle"),
        style.head("highest_force", "force"), style.head("lowest_force", "force"),
        style.head("highest_tension", "force"),
    )  # fmt: skip
    unit = style.shown("length").unit
    heads = [h.replace("[m]", f"[{unit}]") for h in head]
    frame_of_map = result.model.system.map_frame
    if frame_of_map is not None:
        heads += [style.text("easting"), style.text("northing")]
        points = np.array([node.at for node in each_node(result.runs)])
        places = np.column_stack(frame_of_map.to_map(points[:, 0], points[:, 1]))
        rows = [(*row, *(f"{v:.2f}" for v in place)) for row, place in zip(rows, places.tolist(), strict=True)]
    return Table(tuple(heads), rows, texts=2)


def _spans(summary: Summary, style: Style) -> Table:
    head = (
        style.text("span"), style.head("highest_tension", "force"), style.head("share_of_swl", "percent"),
        style.head("lowest_tension", "force"), style.head("largest_sag", "short_length"),
    )  # fmt: skip
    rows = [
        (
            str(name), style.number(row["highest_tension"], "force", "up"),
            style.number(row["over_SWL"], "percent", "up"), style.number(row["lowest_tension"], "force", "down"),
            style.number(row["largest_sag"], "short_length", "up"),
        )
        for name, row in summary.spans.iterrows()
    ]  # fmt: skip
    return Table(head, rows)


def _drives(result: RunData, style: Style) -> list[Section]:
    table = power(result)
    if table.empty:
        return []
    head = (
        style.text("name"), style.head("mean_power", "power"), style.head("highest_power", "power"),
        style.head("pulled", "energy"), style.head("recovered", "energy"),
    )  # fmt: skip
    rows = [
        (
            str(name), style.number(row["mean"], "power"), style.number(row["highest"], "power", "up"),
            style.number(row["pulled"], "energy", "up"), style.number(row["recovered"], "energy", "down"),
        )
        for name, row in table.iterrows()
    ]  # fmt: skip
    return [Section(style.text("drives"), (Table(head, rows),))]


def _legs(run: Run, style: Style) -> Block:
    """Legs from each support to the next one: direction, distances and height difference."""
    rows = []
    for one, other in zip(run.nodes[:-1], run.nodes[1:], strict=True):
        way = np.subtract(other.at, one.at)
        flat = float(np.hypot(way[0], way[1]))
        direction = float(np.degrees(np.arctan2(way[0], way[1])) % 360.0) if flat > 0.0 else None
        rows.append(
            (
                one.label, other.label, style.number(direction, "degrees"), style.number(flat, "short_length"),
                style.number(float(np.linalg.norm(way)), "short_length"), style.number(float(way[2]), "short_length"),
            )
        )  # fmt: skip
    head = (
        style.text("from"), style.text("support"), style.head("azimuth", "degrees"),
        style.head("distance", "short_length"), style.head("slope_distance", "short_length"),
        style.head("rise", "short_length"),
    )  # fmt: skip
    return Table(head, rows, style.text("azimuth_xy_note"), texts=2)


def _events(result: RunData, style: Style) -> tuple[Table, Table]:
    """Counts of events, and a list of all events except crossings."""
    events = result.events
    counts = [(str(event), str(count)) for event, count in events["event"].value_counts().items()]
    listed = events[~events["event"].str.startswith("crossing")]
    shown = listed.head(MOST_EVENTS)
    rows = [(style.number(e.time, "time"), str(e.event), str(e.component), str(e.load)) for e in shown.itertuples()]
    head = (style.head("time", "time"), style.text("event"), style.text("component"), style.text("load"))
    left_out = style.text("events_left_out", count=len(shown), all=len(listed)) if len(shown) < len(listed) else ""
    return Table((style.text("event"), style.text("count")), counts), Table(head, rows, left_out, texts=4)
