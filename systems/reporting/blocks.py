"""What a report is made of: sections of texts, tables, charts and players. A study's report is a tuple of sections, and
a user can add some of his own."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeAlias

import numpy as np

from ropeway.components.argument_checks import checked


@checked
@dataclass(frozen=True)
class Text:
    """Paragraphs; `warning`: shown as warnings."""

    paragraphs: tuple[str, ...]
    warning: bool = False
    kind: ClassVar[str] = "text"


@checked
@dataclass(frozen=True)
class Table:
    """A table: heads of the columns, and rows of texts; `texts`: how many columns hold words, not numbers."""

    head: tuple[str, ...]
    rows: Sequence[Sequence[str]]
    note: str = ""
    texts: int = 1
    kind: ClassVar[str] = "table"


@checked
@dataclass(frozen=True)
class Chart:
    """An interactive chart. `traces` and `layout` are those of plotly; `name` is unique in its report. `marked`: a line
    at the place of the player is drawn in it."""

    name: str
    traces: Sequence[Mapping[str, Any]]
    layout: Mapping[str, Any]
    note: str = ""
    marked: bool = False
    kind: ClassVar[str] = "chart"

    @property
    def figure(self) -> dict[str, Any]:
        """What plotly draws."""
        layout = {**_LAYOUT, **self.layout}
        if self.marked:
            line = {"color": "#555", "width": 1, "dash": "dot"}
            mark = {
                "type": "line",
                "xref": "x",
                "yref": "paper",
                "x0": None,
                "x1": None,
                "y0": 0,
                "y1": 1,
                "line": line,
            }
            layout["shapes"] = [mark, *layout.get("shapes", ())]
        return {"data": [_clean(trace) for trace in self.traces], "layout": _clean(layout)}


@dataclass(frozen=True)
class Moving:
    """A trace of the player's chart that changes: its place among the traces, and for each frame its points."""

    trace: int
    x: Sequence[np.ndarray]
    y: Sequence[np.ndarray]


@dataclass(frozen=True)
class Player:
    """A chart that moves, with values and events beside it.

    `frames`: a label for each; `moving`: the traces that change; `marks`: where the line in marked charts stands;
    `values`: rows of a label and a text for each frame; `events`: a frame and a text for each; `start`: the frame
    that is shown first.
    """

    chart: Chart
    frames: Sequence[str]
    moving: Sequence[Moving]
    marks: Sequence[float] = ()
    values: Sequence[tuple[str, Sequence[str]]] = ()
    events: Sequence[tuple[int, str]] = ()
    start: int = 0
    kind: ClassVar[str] = "player"

    @property
    def data(self) -> dict[str, Any]:
        """What the player's script reads."""
        return {
            "chart": self.chart.name,
            "frames": list(self.frames),
            "moving": [
                {
                    "trace": m.trace,
                    "x": _packed(m.x),
                    "y": _packed(m.y),
                    "ends": np.cumsum([len(x) for x in m.x]).tolist(),
                }
                for m in self.moving
            ],
            "marks": _clean(list(self.marks)),
            "values": [[label, list(texts)] for label, texts in self.values],
            "events": [[int(frame), text] for frame, text in self.events],
            "start": self.start,
        }


Block: TypeAlias = Text | Table | Chart | Player


@dataclass(frozen=True)
class Section:
    """A part of a report under a title."""

    title: str
    blocks: tuple[Block, ...] = field(default_factory=tuple)


_LAYOUT: Mapping[str, Any] = {
    "height": 340,
    "margin": {"l": 62, "r": 14, "t": 10, "b": 46},
    "legend": {"orientation": "h", "y": -0.2, "yanchor": "top", "x": 0},
    "hovermode": "x unified",
    "template": "none",
    "font": {"family": "system-ui, sans-serif", "size": 12},
    "paper_bgcolor": "white",
    "plot_bgcolor": "white",
}


def axis(title: str, **more: Any) -> dict[str, Any]:
    """An axis with a title."""
    line = {
        "gridcolor": "#e4e4e4",
        "zeroline": False,
        "linecolor": "#999",
        "ticks": "outside",
        "tickcolor": "#999",
        "automargin": True,
    }
    return {"title": {"text": title, "standoff": 8}, **line, **more}


def curve(x: Any, y: Any, name: str, colour: str, **more: Any) -> dict[str, Any]:
    """A line through points; `width`, `dash` and `shown` (in the legend) may be given."""
    line = {"color": colour, "width": more.pop("width", 1.6), "dash": more.pop("dash", "solid")}
    found = {"type": "scatter", "mode": "lines", "x": x, "y": y, "name": name, "line": line}
    return {**found, "showlegend": more.pop("shown", True), **more}


def dots(x: Any, y: Any, name: str, colour: str, **more: Any) -> dict[str, Any]:
    """Marks at points; `size`, `symbol`, `text` and `shown` may be given."""
    marker = {"color": colour, "size": more.pop("size", 8), "symbol": more.pop("symbol", "circle")}
    found = {"type": "scatter", "mode": "markers", "x": x, "y": y, "name": name, "marker": marker}
    return {**found, "showlegend": more.pop("shown", True), **more}


def _packed(arrays: Sequence[np.ndarray]) -> str:
    """Points of all frames as 32-bit numbers in base64."""
    joined = np.concatenate([np.asarray(a, dtype="<f4") for a in arrays]) if arrays else np.zeros(0, dtype="<f4")
    return base64.b64encode(joined.tobytes()).decode()


def _clean(value: Any) -> Any:
    """Values as JSON: seven digits, of map coordinates centimetres, are enough to draw; what is not finite is null."""
    if hasattr(value, "tolist") and not isinstance(value, np.generic):  # an array, or a column of a frame
        return _clean(value.tolist())
    if isinstance(value, Mapping):
        return {key: _clean(v) for key, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_clean(v) for v in value]
    if isinstance(value, (float, np.floating)):
        if not math.isfinite(value):
            return None
        number = float(value)
        return round(number, 2) if abs(number) > 1e5 else float(f"{number:.7g}")
    return value.item() if isinstance(value, np.generic) else value
