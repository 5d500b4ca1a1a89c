"""DXF drawings in 3-D, in plan and in profile, written by ezdxf."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np

from ropeway.components.errors import InputError
from ropeway.systems.exchange.gis_features import Drawing, Feature

View = Literal["3d", "plan", "profile"]
"""What a drawing shows: points of the map with their heights; the map alone; heights over stations."""

_COLOURS = {
    "ground": 33, "rope": 1, "guylines": 30, "supports": 5, "anchors": 6, "carriage": 3, "carriage_path": 3,
    "loads": 3, "clearance": 2,
}  # fmt: skip
"""AutoCAD's colour of each layer."""
_METRES, _FEET, _US_FEET = 6, 2, 21
_UNITS = {1.0: _METRES, 0.3048: _FEET, 1200.0 / 3937.0: _US_FEET}
"""Codes of $INSUNITS by the unit [m]."""
_TEXT, _MARK = 1.5, 0.75
"""Height of texts, and half the width of the mark of a point [m]."""
_APP = "ROPEWAY"


def write_dxf(drawing: Drawing, path: Path, view: View) -> None:
    """Layers as those of the drawing. A point is a block with its attributes, a line has its own as extended data."""
    try:
        from ezdxf.filemanagement import new
    except ImportError as error:
        raise InputError("Writing a DXF needs ezdxf", "pip install ropeway[gis]") from error
    unit = 1.0 if view == "profile" else drawing.unit
    document = new("R2010", setup=False)
    known = [code for size, code in _UNITS.items() if abs(size - unit) < 1e-9]
    document.header["$INSUNITS"] = known[0] if known else 0
    document.header.custom_vars.append("coordinate system", f"{drawing.frame.crs[:200]} {drawing.system}"[:250])
    document.header.custom_vars.append("view", view)
    document.appids.add(_APP)
    space = document.modelspace()
    for layer, features in drawing.layers.items():
        document.layers.add(layer, color=_COLOURS.get(layer, 7))
        keys = sorted({key for feature in features for key in feature.attributes})
        if features[0].is_point:
            _define(document, layer, keys, unit)
        for feature in features:
            at = _seen(drawing, feature, view, unit)
            if feature.is_point:
                _insert(space, layer, feature, at[0])
            else:
                _draw(space, layer, feature, at, view)
    document.saveas(path)


def _seen(drawing: Drawing, feature: Feature, view: View, unit: float) -> np.ndarray:
    """The points of a feature in a view, (n, 3)."""
    if view == "profile":
        return np.column_stack([drawing.in_profile(feature), np.zeros(len(feature.points))])
    at = drawing.on_map(feature)
    at[:, 2] = 0.0 if view == "plan" else at[:, 2] / unit
    return at


def _draw(space: Any, layer: str, feature: Feature, at: np.ndarray, view: View) -> None:
    """A polyline, with its name and attributes as extended data."""
    about = {"layer": layer}
    line = (
        space.add_polyline3d(at, dxfattribs=about)
        if view == "3d"
        else space.add_lwpolyline(at[:, :2], dxfattribs=about)
    )
    texts = [f"name={feature.name}", *(f"{key}={value!r}" for key, value in feature.attributes.items())]
    line.set_xdata(_APP, [(1000, text[:255]) for text in texts])


def _define(document: Any, layer: str, keys: list[str], unit: float) -> None:
    """The block of a layer of points: a cross, the name beside it, attributes that are not shown."""
    block, half, height = document.blocks.new(layer), _MARK / unit, _TEXT / unit
    block.add_line((-half, 0.0), (half, 0.0))
    block.add_line((0.0, -half), (0.0, half))
    block.add_attdef("NAME", (half, half), dxfattribs={"height": height})
    for k, key in enumerate(keys, 1):
        hidden = {"height": height, "flags": 1}
        block.add_attdef(key.upper(), (half, half - 1.5 * k * height), dxfattribs=hidden)


def _insert(space: Any, layer: str, feature: Feature, at: np.ndarray) -> None:
    mark = space.add_blockref(layer, at, dxfattribs={"layer": layer})
    mark.add_auto_attribs(
        {"NAME": feature.name, **{key.upper(): _text(value) for key, value in feature.attributes.items()}}
    )


def _text(value: float | str) -> str:
    return value if isinstance(value, str) else repr(float(value))
