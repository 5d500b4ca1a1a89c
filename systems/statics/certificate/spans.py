"""Spans as NumPy sees them: the closed-form elastic cable and the loads on it, for many records at once.

Written for the certificate alone. Arrays have shape (records, ..., spans). A catenary's angle between two points with
vertical components v0 < v1 of the tension, h its horizontal component, is
asinh(v1/h) - asinh(v0/h) = log1p(2 (v1 - v0) / ((T0 + v0) + (T1 - v1))): each bracket is a sum of numbers of one sign,
h^2 over another such sum where it is not, so that nothing cancels, taut or folded.

In weather the weight is a force in any direction: the same about its own axis. The wind follows by vector products, not
as in the equations by projection: e x (u x e) is the part of the wind u across the chord e.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.statics.certificate_layout import ENDS, SPAN, SpanPlaces, WeatherPlaces


class Spans(NamedTuple):
    """What is known of spans: tension vector at the start (records, 3, spans), horizontal tension squared, weight per
    metre, strain coefficients and whether any c2 is not zero, minimum breaking load, unstretched length: at the start,
    now without and with what lies on shoes, chord vector (records, 3, spans) and its length, the coordinates' largest
    size, and the travel at end a with the rope beside it."""

    force: np.ndarray
    horizontal2: np.ndarray
    weight: np.ndarray
    c1: np.ndarray
    c2: np.ndarray
    curved: bool
    breaking_load: np.ndarray
    at_start: np.ndarray
    length: np.ndarray
    whole: np.ndarray
    way: np.ndarray
    chord: np.ndarray
    coordinates: np.ndarray
    travel_a: np.ndarray


def read_spans(places: SpanPlaces, values: np.ndarray, gravity: np.ndarray) -> Spans:
    """Spans out of values (records, all)."""
    found = values.take(places.read, axis=1)
    n, m = len(SPAN), len(SPAN) + len(ENDS)
    force, end_a, end_b = found[:, :3], found[:, n : n + 4], found[:, m : m + 4]
    whole = found[:, 3] + end_a[:, 0] - end_b[:, 0]
    travel_a, length, a, b = end_a[:, 0], whole, end_a[:, 1:], end_b[:, 1:]
    if places.shoes:
        aside_a, aside_b = found[:, n + 4 : n + 7], found[:, m + 4 : m + 7]
        travel_a, length = travel_a + aside_a[:, 0], length + aside_a[:, 0] - aside_b[:, 0]
        a, b = a.copy(), b.copy()
        a[:, 0::2] += aside_a[:, 1:]
        b[:, 0::2] += aside_b[:, 1:]
    way = b - a
    return Spans(
        force=force,
        horizontal2=force[:, 0] * force[:, 0] + force[:, 1] * force[:, 1],
        weight=found[:, 4] * gravity,
        c1=found[:, 5],
        c2=found[:, 6],
        curved=bool(found[:, 6].any()),
        breaking_load=found[:, 7],
        at_start=found[:, 3],
        length=length,
        whole=whole,
        way=way,
        chord=_norm(way),
        coordinates=np.abs(a).reshape(len(a), -1).max(axis=1)[:, None],
        travel_a=travel_a,
    )


def _norm(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (records, 3, spans)."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=1)))


def closures(spans: Spans, found: Shape) -> np.ndarray:
    """How far spans end from their supports [m], (records, spans)."""
    return _norm(found.reach - spans.way)


class LoadsInSpans(NamedTuple):
    """Loads in their spans: distance from the span's start [m], mass [kg] and drag area [m2], (records, slots, spans),
    an empty slot being a load of no mass at the end; `there`: which slots have a load; `lost`: (records, spans) whether
    a span has more loads than slots, or a load that was pinned in another span."""

    distance: np.ndarray
    mass: np.ndarray
    there: np.ndarray
    lost: np.ndarray
    drag: np.ndarray | None = None


def hung(
    places: SpanPlaces,
    values: np.ndarray,
    spans: Spans,
    runs: Sequence[Run],
    passed: Sequence[np.ndarray],
    masses: Sequence[np.ndarray] | None = None,
    *,
    weather: bool = False,
) -> LoadsInSpans | None:
    """Loads of `runs` where their own places on the rope put them; `passed`: for each run the loads beyond each
    support, (records, supports); `masses`: for each run other masses in each record (records, loads). As many slots as
    the fullest span needs; None where there is no load."""
    slots = places.slots_of(passed)
    most = slots.there.shape[1]
    if most == 0:
        return None
    shape = (len(values), most, len(places.names))
    mass, drag = np.zeros(shape), np.zeros(shape) if weather else None
    distance, lost = np.empty(shape), slots.lost
    distance[:] = spans.length[:, None]
    for r, run in enumerate(runs):
        loads = run.loads
        if len(loads.place) == 0:
            continue
        own, load = slots.runs[r]
        full = slots.there[:, :, own]
        before = spans.travel_a[:, own].copy()
        before[:, 1:] -= spans.at_start[:, own][:, :-1].cumsum(axis=1)
        at = loads.place.take(load) + before[:, None]
        if loads.pins:
            pinned = loads.pinned.take(load)
            at = np.where(pinned >= 0, loads.at.take(load), at)
            astray = (full & (pinned >= 0) & (pinned != np.arange(own.stop - own.start))).any(axis=1)
            lost = lost.copy()
            lost[:, own] |= astray
        np.copyto(distance[:, :, own], at, where=full)
        if drag is not None:
            np.multiply(loads.drag.take(load), full, out=drag[:, :, own])
        if masses is None:
            np.multiply(loads.mass.take(load), full, out=mass[:, :, own])
        else:
            record = np.arange(len(values))[:, None, None]
            np.multiply(masses[r][record, load], full, out=mass[:, :, own])
    return LoadsInSpans(distance, mass, slots.there, lost, drag)


class Shape(NamedTuple):
    """Spans as their tension vectors let them hang: where they end, seen from their start, (records, 3, spans); and of
    the pieces between loads: for both ends (2, records, pieces, spans) the vertical component of the tension that pulls
    downwards along the piece's start, upwards along its end, and the tension; and (records, pieces, spans) the length
    and the angle over the weight."""

    reach: np.ndarray
    vertical: np.ndarray
    tension: np.ndarray
    piece: np.ndarray
    angle: np.ndarray


def shape(spans: Spans, loads: LoadsInSpans | None, gravity: np.ndarray) -> Shape:
    """The catenaries from the tension vectors at the spans' starts."""
    records, count = spans.length.shape
    weight, h2, c1 = spans.weight[:, None], spans.horizontal2[:, None], spans.c1[:, None]
    pieces = 1 if loads is None else loads.distance.shape[1] + 1
    vertical = np.empty((2, records, pieces, count))
    if loads is None:
        piece = spans.length[:, None]
        vertical[0] = spans.force[:, None, 2]
    else:
        cuts = np.empty((records, pieces + 1, count))
        cuts[:, 0], cuts[:, 1:-1], cuts[:, -1] = 0.0, loads.distance, spans.length
        piece = cuts[:, 1:] - cuts[:, :-1]
        np.multiply(weight, cuts[:, :-1], out=vertical[0])
        vertical[0] += spans.force[:, None, 2]
        vertical[0, :, 1:] += loads.mass.cumsum(axis=1) * gravity[:, :, None]
    gain = weight * piece
    np.negative(vertical[0] + gain, out=vertical[1])
    tension = np.sqrt(vertical * vertical + h2)
    steep = np.abs(vertical) + tension
    np.divide(h2, steep, out=steep, where=vertical < 0.0)  # the brackets, where they would cancel
    angle = np.log1p(2.0 * gain / (steep[0] + steep[1])) / weight
    both, total = vertical[0] - vertical[1], tension[0] + tension[1]
    across, lift = angle + c1 * piece, 1.0 / total + 0.5 * c1
    if spans.curved:
        c2 = spans.c2[:, None]
        across = across + c2 * (piece / 4.0 * (total + both * both / total) + h2 * angle / 2.0)
        lift = lift + c2 * (total * total - tension[0] * tension[1]) / (3.0 * total)
    reach = np.empty(spans.way.shape)
    np.multiply(spans.force[:, :2], across.sum(axis=1)[:, None], out=reach[:, :2])
    (piece * both * lift).sum(axis=1, out=reach[:, 2])
    return Shape(reach, vertical, tension, piece, angle)


def pulls(spans: Spans, found: Shape, ends: np.ndarray | None = None) -> np.ndarray:
    """Pulls of the ropes on what their ends sit at, (3, records, 2 spans + 1): of ends a, of ends b, and none. `ends`:
    tension vectors at ends b (records, 3, spans) in weather."""
    records, n = spans.length.shape
    force = np.zeros((3, records, 2 * n + 1))
    force[:, :, :n] = spans.force.transpose(1, 0, 2)
    if ends is not None:
        force[:, :, n : 2 * n] = -ends.transpose(1, 0, 2)
        return force
    np.negative(force[:2, :, :n], out=force[:2, :, n : 2 * n])
    force[2, :, n : 2 * n] = found.vertical[1, :, -1]
    return force


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
    warm = weather.expansion[:, None]
    across, lift = warm * angle + c1 * piece, warm / total + 0.5 * c1
    if spans.curved:
        c2 = spans.c2[:, None]
        across = across + c2 * (piece / 4.0 * (total + both * both / total) + h2 * angle / 2.0)
        lift = lift + c2 * (total * total - tension[0] * tension[1]) / (3.0 * total)
    reach = (level * across[:, None] + up[:, :, None] * (piece * both * lift)[:, None]).sum(axis=2)
    return Shape(reach, vertical, tension, piece, angle), end[:, :, -1]
