"""Spans in weather as NumPy sees them: the closed form for a force in any direction, written for the certificate alone.

Without weather `certificate_spans` does the same with less work. The wind follows from the parameters of the model by
vector products, not as in the equations by projection: e x (u x e) is the part of the wind u across the chord e.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ropeway.systems.statics.certificate_layout import WeatherPlaces
from ropeway.systems.statics.certificate_spans import LoadsInSpans, Shape, Spans


class WindAndIce(NamedTuple):
    """Force on each unstretched metre of spans (records, 3, spans) [N/m]; length without tension over that when strung
    (records, spans); wind pressure in its direction (records, 3, 1) [Pa]."""

    force: np.ndarray
    expansion: np.ndarray
    wind: np.ndarray


def read_weather(places: WeatherPlaces, values: np.ndarray, spans: Spans, gravity: np.ndarray) -> WindAndIce:
    """The weather of values (records, all)."""
    temperature, pressure, coming, strung, thickness, density, north = values[:, places.shared].T[:, :, None]
    diameter, expansion, drag = (values.take(places.of_rope[i], axis=1) for i in range(3))
    azimuth = np.deg2rad(180.0 + coming - north)  # that the wind blows towards
    blows = np.stack([np.sin(azimuth), np.cos(azimuth), 0.0 * azimuth], axis=1)
    chord = spans.way / spans.chord[:, None]
    twisted = np.cross(np.broadcast_to(blows, chord.shape), chord, axis=1)
    across = np.cross(chord, twisted, axis=1)
    sine = np.sqrt((twisted * twisted).sum(axis=1))
    outer = diameter + 2.0 * thickness
    force = (drag * pressure * outer * sine)[:, None] * across
    # A ring of ice: pi/4 (outer^2 - diameter^2).
    force[:, 2] -= spans.weight + density * gravity * np.pi / 4.0 * (outer * outer - diameter * diameter)
    return WindAndIce(force, 1.0 + expansion * (temperature - strung), pressure[:, None] * blows)


def shape_in_weather(
    spans: Spans, loads: LoadsInSpans | None, weather: WindAndIce, gravity: np.ndarray
) -> tuple[Shape, np.ndarray]:
    """The catenaries from the tension vectors at the spans' starts, about the direction of the force on the rope; and
    the tension vectors at their ends (records, 3, spans)."""
    records, count = spans.length.shape
    size = np.sqrt((weather.force * weather.force).sum(axis=1))
    up = -weather.force / size[:, None]
    pieces = 1 if loads is None else loads.distance.shape[1] + 1
    cuts = np.zeros((records, pieces + 1, count))
    cuts[:, -1] = spans.length
    jumps = np.zeros((records, 3, pieces, count))  # of the tension vector at the start of each piece
    if loads is not None:
        cuts[:, 1:-1] = loads.distance
        if loads.drag is not None:
            jumps[:, :, 1:] -= weather.wind[:, :, None] * loads.drag[:, None]
        jumps[:, 2, 1:] += loads.mass * gravity[:, :, None]
    piece = cuts[:, 1:] - cuts[:, :-1]
    start = spans.force[:, :, None] - weather.force[:, :, None] * cuts[:, None, :-1] + jumps.cumsum(axis=2)
    end = start - weather.force[:, :, None] * piece[:, None]
    v0, v1 = ((vector * up[:, :, None]).sum(axis=1) for vector in (start, end))
    level = start - v0[:, None] * up[:, :, None]
    h2 = (level * level).sum(axis=1)
    vertical = np.stack([v0, -v1])
    tension = np.sqrt(np.stack([(start * start).sum(axis=1), (end * end).sum(axis=1)]))
    steep = np.abs(vertical) + tension
    np.divide(h2, steep, out=steep, where=vertical < 0.0)
    gain = size[:, None] * piece
    angle = np.log1p(2.0 * gain / (steep[0] + steep[1])) / size[:, None]
    both, total, c1 = v0 + v1, tension[0] + tension[1], spans.c1[:, None]
    across, lift = angle + c1 * piece, 1.0 / total + 0.5 * c1
    if spans.curved:
        c2 = spans.c2[:, None]
        across = across + c2 * (piece / 4.0 * (total + both * both / total) + h2 * angle / 2.0)
        lift = lift + c2 * (total * total - tension[0] * tension[1]) / (3.0 * total)
    reach = (level * across[:, None] + up[:, :, None] * (piece * both * lift)[:, None]).sum(axis=2)
    return Shape(reach * weather.expansion[:, None], vertical, tension, piece, angle), end[:, :, -1]
