"""KML and GPX: longitude, latitude and altitude in XML."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ropeway.systems.exchange.gis_features import Drawing, Feature

_KML = "http://www.opengis.net/kml/2.2"
_GPX = "http://www.topografix.com/GPX/1/1"
_COLOURS = {"ground": "ff336699", "rope": "ff0000ff", "guylines": "ff0080ff", "carriage_path": "ff00aa00"}
"""Of lines in KML, as alpha, blue, green, red."""
_STAKED = ("supports", "anchors", "clearance")
"""Layers that are waypoints of a GPX file."""


def write_kml(drawing: Drawing, path: Path) -> None:
    """A folder for each layer, heights as absolute altitudes, attributes as extended data."""
    root = Element("kml", xmlns=_KML)
    document = SubElement(root, "Document")
    _text(document, "name", drawing.name)
    for layer in drawing.layers:
        if layer in _COLOURS:
            line = SubElement(SubElement(document, "Style", id=layer), "LineStyle")
            _text(line, "color", _COLOURS[layer])
            _text(line, "width", "2")
    for layer, features in drawing.layers.items():
        folder = SubElement(document, "Folder")
        _text(folder, "name", layer)
        for feature in features:
            _placemark(folder, drawing, feature)
    _save(root, path)


def _placemark(folder: Element, drawing: Drawing, feature: Feature) -> None:
    mark = SubElement(folder, "Placemark")
    _text(mark, "name", feature.name)
    if feature.layer in _COLOURS:
        _text(mark, "styleUrl", f"#{feature.layer}")
    if feature.attributes:
        data = SubElement(mark, "ExtendedData")
        for key, value in feature.attributes.items():
            _text(SubElement(data, "Data", name=key), "value", _value(value))
    shape = SubElement(mark, "Point" if feature.is_point else "LineString")
    _text(shape, "altitudeMode", "absolute")
    at = drawing.in_degrees(feature)
    _text(shape, "coordinates", " ".join(f"{x:.9f},{y:.9f},{z:.4f}" for x, y, z in at))


def write_gpx(drawing: Drawing, path: Path) -> None:
    """Waypoints for staking out supports, anchors and the lowest places, and the line over the supports as a route."""
    root = Element("gpx", version="1.1", creator="ropeway", xmlns=_GPX)
    _text(SubElement(root, "metadata"), "name", drawing.name)
    for layer in _STAKED:
        for feature in drawing.layers.get(layer, []):
            mark = _point(root, "wpt", drawing.in_degrees(feature)[0])
            _text(mark, "name", feature.name)
            _text(mark, "desc", "; ".join(f"{key} {_value(value)}" for key, value in feature.attributes.items()))
            _text(mark, "sym", "Flag, Blue")
            _text(mark, "type", layer)
    route = SubElement(root, "rte")
    _text(route, "name", drawing.name)
    stands = [f for layer in ("supports", "anchors") for f in drawing.layers.get(layer, []) if f.name in drawing.route]
    for feature in sorted(stands, key=lambda f: drawing.route.index(f.name)):
        _text(_point(route, "rtept", drawing.in_degrees(feature)[0]), "name", feature.name)
    _save(root, path)


def _point(parent: Element, tag: str, at: np.ndarray) -> Element:
    mark = SubElement(parent, tag, lat=f"{at[1]:.9f}", lon=f"{at[0]:.9f}")
    _text(mark, "ele", f"{at[2]:.4f}")
    return mark


def _text(parent: Element, tag: str, text: str) -> None:
    """A child with a text, without characters that XML cannot hold."""
    SubElement(parent, tag).text = "".join(c for c in text if c.isprintable() or c in "\t\n")


def _value(value: float | str) -> str:
    return value if isinstance(value, str) else repr(float(value))


def _save(root: Element, path: Path) -> None:
    tree = ElementTree.ElementTree(root)
    ElementTree.indent(tree)
    tree.write(path, encoding="utf-8", xml_declaration=True)
