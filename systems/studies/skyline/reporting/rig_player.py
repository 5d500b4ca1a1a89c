"""The player of a report: a rig to scale with its carriage at successive stations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropeway.components import catenary
from ropeway.components.errors import EquilibriumError
from ropeway.systems.reporting.blocks import Chart, Moving, Player, axis, curve, dots
from ropeway.systems.reporting.style import Style
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.statics.line_state import span_rope
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.station_solver import Stations

FRAMES = 150
"""Largest number of carriage stations."""
_POINTS = 24
"""Points of a span's curve."""
_WIDTH = 724
"""Width of the drawing [px]."""
_COLOURS = {"skyline": "#111", "mainline": "#d62728", "haulback": "#1f77b4", "dropline": "#2ca02c", "": "#888"}


@dataclass(frozen=True)
class Places:
    """Positions of the carriage to show: `stations` [m], `payloads` [kg], and `heights` z [m] if the yarder sets them.
    `frames` has a label for each; `values` and `events` are those of a player; `start` is the first one shown."""

    stations: np.ndarray
    payloads: np.ndarray
    heights: np.ndarray | None
    frames: Sequence[str]
    values: Sequence[tuple[str, Sequence[str]]]
    marks: Sequence[float]
    events: Sequence[tuple[int, str]] = ()
    start: int = 0


def rig_player(rig: SkylineRig, places: Places, style: Style) -> Player:
    """The rig at all positions; ropes are omitted without an equilibrium."""
    solver = Stations(rig, by_height=places.heights is not None)
    found: list[Solved | None] = []
    for i, (x, mass) in enumerate(zip(places.stations, places.payloads, strict=True)):
        try:
            z = None if places.heights is None else float(places.heights[i])
            found.append(certified([solver.solve(float(x), float(mass), z)])[0])
        except EquilibriumError:
            found.append(None)
    roles = [r for r in _COLOURS if any(one is not None and r in one.at.roles for one in found)]
    moving: list[list[tuple[np.ndarray, np.ndarray]]] = [[] for _ in range(len(roles) + 2)]
    for one in found:
        shapes = {} if one is None else _ropes(one)
        for kept, role in zip(moving, roles, strict=False):
            kept.append(shapes.get(role, (np.zeros(0), np.zeros(0))))
        for kept, points in zip(moving[-2:], _carriage(one), strict=True):
            kept.append(points)
    still = _still(rig, style)
    traces = [
        *(
            curve([], [], _name(rig, role, style), _COLOURS[role], width=2.2 if role == "skyline" else 1.2)
            for role in roles
        ),
        curve([], [], style.text("load"), "#7a4a1c", width=3.0, hoverinfo="skip"),
        dots([], [], style.text("carriage"), "#111", symbol="square", size=10, hoverinfo="x+y"),
    ]
    return Player(
        Chart("profile", [*still, *traces], _layout(rig, found, style)),
        places.frames,
        [
            Moving(len(still) + k, *([style.scaled(p[i], "length") for p in own] for i in (0, 1)))
            for k, own in enumerate(moving)
        ],
        marks=places.marks,
        values=places.values,
        events=places.events,
        start=places.start,
    )


def _name(rig: SkylineRig, role: str, style: Style) -> str:
    return style.text(rig.kind.carrying_rope if role == "skyline" else role or "guyline")


def _ropes(solved: Solved) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Curves of the ropes by role: stations and heights [m], with NaN between spans."""
    model = solved.at.model
    parts: dict[str, list[np.ndarray]] = {}
    for r, run in enumerate(model.runs):
        for k, span in enumerate(run.spans):
            length = solved[f"{span.name}.length"]
            along = np.linspace(0.0, length, _POINTS)
            force = solved.at.curve(solved.point, k, r)
            rope = span_rope(model, run, k, solved.__getitem__)
            reach = catenary.profile(force, *rope, length, (), (), along).reach
            own = parts.setdefault(solved.at.roles[r], [])
            own += [(solved.start(r, k) + reach)[:, [0, 2]], np.full((1, 2), np.nan)]
    joined = {role: np.concatenate(own) for role, own in parts.items()}
    return {role: (points[:, 0], points[:, 1]) for role, points in joined.items()}


def _carriage(solved: Solved | None) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """The load under the carriage, or the log, as a line, and the carriage as a point."""
    if solved is None:
        return (np.zeros(0), np.zeros(0)), (np.zeros(0), np.zeros(0))
    rig, name = solved.at.rig, solved.at.rig.carriage.name
    x, z = solved[f"{name}.x"], solved[f"{name}.z"]
    load = np.array([x, x]), np.array([z, z - rig.carriage.depth])
    if rig.turn is not None:
        log = rig.turn.log.name
        load = tuple(np.array([solved[f"{log}.{a}"], solved[f"{log}.rear_{a}"]]) for a in "xz")  # type: ignore[assignment]
    return load, (np.array([x]), np.array([z]))


def _still(rig: SkylineRig, style: Style) -> list[dict[str, Any]]:
    """Ground, spars and supports."""
    found = []
    if rig.terrain is not None:
        x, z = (style.scaled(v, "length") for v in (rig.terrain.station, rig.terrain.elevation))
        found.append(curve(x, z, style.text("ground"), "#8a7f6a", hoverinfo="x+y"))
    places = [node.at for node in rig.stands]
    feet = [z if rig.terrain is None else float(rig.terrain.elevations(x)) for x, _, z in places]
    gap = [None]
    xs = [v for x, _, _ in places for v in (*style.scaled([x, x], "length"), *gap)]
    zs = [v for (_, _, z), foot in zip(places, feet, strict=True) for v in (*style.scaled([foot, z], "length"), *gap)]
    found.append(curve(xs, zs, style.text("supports"), "#7a5230", width=4.0, hoverinfo="skip"))
    tops = {i: style.scaled([place[i] for place in places], "length") for i in (0, 2)}
    names = [node.label for node in rig.stands]
    found.append(
        dots(
            tops[0], tops[2], style.text("supports"), "#7a5230", size=6, text=names, mode="markers+text",
            textposition="top center", shown=False, hoverinfo="text+x+y",
        )
    )  # fmt: skip
    return found


def _layout(rig: SkylineRig, found: Sequence[Solved | None], style: Style) -> dict[str, Any]:
    """Layout to scale, with the height that this requires."""
    x = rig.points[:, 0]
    width = float(np.ptp(x))
    name = rig.carriage.name
    heights = [*rig.points[:, 2], *(one[f"{name}.z"] - rig.carriage.depth for one in found if one is not None)]
    if rig.terrain is not None:
        near = (rig.terrain.station > x.min() - 0.03 * width) & (rig.terrain.station < x.max() + 0.03 * width)
        heights += list(rig.terrain.elevation[near])
    low, high = min(heights) - 0.02 * width, max(heights) + 0.06 * width
    ranges = ([x.min() - 0.03 * width, x.max() + 0.03 * width], [low, high])
    horizontal, vertical = (style.scaled(r, "length").tolist() for r in ranges)
    height = float(np.clip(_WIDTH * (high - low) / (1.06 * width), 170.0, 700.0))
    return {
        "height": height + 110.0,
        "hovermode": "closest",
        "xaxis": axis(style.head("station", "length"), range=horizontal, constrain="domain"),
        "yaxis": axis(style.head("elevation", "length"), range=vertical, scaleanchor="x", scaleratio=1.0),
    }
