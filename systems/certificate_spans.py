"""Spans as NumPy sees them: the closed-form elastic cable and the loads on it, for many records at once.

Written for the certificate alone. Arrays have shape (records, spans, ...). A catenary's angle between two points with
vertical components v0 < v1 of the tension, h its horizontal component, is
asinh(v1/h) - asinh(v0/h) = log1p(2 (v1 - v0) / ((T0 + v0) + (T1 - v1))): each bracket is a sum of numbers of one sign,
h^2 over another such sum where it is not, so that nothing cancels, taut or folded.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ropeway.systems.certificate_layout import ENDS, SPAN, SpanPlaces
from ropeway.systems.run import Run


class Spans(NamedTuple):
    """What is known of spans: tension vector at the start (records, 3, spans), horizontal tension squared, weight per
    metre, strain coefficients, minimum breaking load, unstretched length, chord vector (records, 3, spans) and its
    length, the coordinates' largest size, and the travel at end a with the rope beside it."""

    force: np.ndarray
    horizontal2: np.ndarray
    weight: np.ndarray
    c1: np.ndarray
    c2: np.ndarray
    breaking_load: np.ndarray
    length: np.ndarray
    way: np.ndarray
    chord: np.ndarray
    coordinates: np.ndarray
    travel_a: np.ndarray


def read_spans(places: SpanPlaces, values: np.ndarray, gravity: np.ndarray) -> Spans:
    """Spans out of values (records, all)."""
    found = values[:, places.read]
    n, m = len(SPAN), len(SPAN) + len(ENDS)
    force, end_a, end_b = found[:, :3], found[:, n : n + 4], found[:, m : m + 4]
    travel_a, travel_b, a, b = end_a[:, 0], end_b[:, 0], end_a[:, 1:], end_b[:, 1:]
    if places.shoes:
        aside_a, aside_b = found[:, n + 4 : n + 7], found[:, m + 4 : m + 7]
        travel_a, travel_b = travel_a + aside_a[:, 0], travel_b + aside_b[:, 0]
        a, b = a.copy(), b.copy()
        a[:, 0::2] += aside_a[:, 1:]
        b[:, 0::2] += aside_b[:, 1:]
    way = b - a
    return Spans(
        force=force,
        horizontal2=force[:, 0] ** 2 + force[:, 1] ** 2,
        weight=found[:, 4] * gravity,
        c1=found[:, 5],
        c2=found[:, 6],
        breaking_load=found[:, 7],
        length=found[:, 3] + travel_a - travel_b,
        way=way,
        chord=np.sqrt(way[:, 0] ** 2 + way[:, 1] ** 2 + way[:, 2] ** 2),
        coordinates=np.abs(a).max(axis=(1, 2), initial=0.0)[:, None],
        travel_a=travel_a,
    )


class Hung(NamedTuple):
    """Loads in their spans: distance from the span's start [m] and mass [kg], (records, spans, slots), an empty slot
    being a load of no mass at the end; `there`: which slots have a load; `lost`: (records, spans) whether a span has
    more loads than slots, or a load that was pinned in another span."""

    distance: np.ndarray
    mass: np.ndarray
    there: np.ndarray
    lost: np.ndarray


def hung(
    places: SpanPlaces,
    values: np.ndarray,
    spans: Spans,
    runs: Sequence[Run],
    passed: Sequence[np.ndarray],
) -> Hung | None:
    """Loads of `runs` where their own places on the rope put them; `passed`: for each run the loads beyond each
    support, (records, supports). As many slots as the fullest span needs; None where there is no load."""
    counts = [beyond[:, :-1] - beyond[:, 1:] for beyond in passed]
    most = max((int(count.max()) for count in counts), default=0)
    if most == 0:
        return None
    shape = (*spans.length.shape, most)
    distance, mass = np.empty(shape), np.zeros(shape)
    distance[:] = spans.length[:, :, None]
    there, lost = np.zeros(shape, dtype=bool), np.zeros(spans.length.shape, dtype=bool)
    slot = np.arange(most)
    for r, run in enumerate(runs):
        loads = run.loads
        if len(loads.place) == 0:
            continue
        own = slice(places.runs[r], places.runs[r + 1])
        lost[:, own] = counts[r] > places.slot_counts[own]
        full = slot < counts[r][:, :, None]
        load = np.where(full, passed[r][:, :-1, None] - 1 - slot, 0)
        starts = np.zeros((len(values), own.stop - own.start))
        np.cumsum(values[:, places.read[3, own][:-1]], axis=1, out=starts[:, 1:])
        at = loads.place[load] + (spans.travel_a[:, own] - starts)[:, :, None]
        if loads.pinned.max() >= 0:
            pinned = loads.pinned[load]
            at = np.where(pinned >= 0, loads.at[load], at)
            lost[:, own] |= (full & (pinned >= 0) & (pinned != np.arange(own.stop - own.start)[:, None])).any(axis=2)
        np.copyto(distance[:, own], at, where=full)
        np.copyto(mass[:, own], loads.mass[load], where=full)
        there[:, own] = full
    return Hung(distance, mass, there, lost)


class Shape(NamedTuple):
    """Spans as their tension vectors let them hang: where they end, seen from their start, (records, 3, spans); the
    vertical component of the tension at the end; and for the pieces between loads, (records, spans, pieces), the
    vertical components and tensions at both ends, their length and the angle over the weight."""

    reach: np.ndarray
    vertical_b: np.ndarray
    v0: np.ndarray
    v1: np.ndarray
    t0: np.ndarray
    t1: np.ndarray
    piece: np.ndarray
    angle: np.ndarray


def shape(spans: Spans, loads: Hung | None, gravity: np.ndarray) -> Shape:
    """The catenaries from the tension vectors at the spans' starts."""
    weight, h2 = spans.weight[:, :, None], spans.horizontal2[:, :, None]
    c1 = spans.c1[:, :, None]
    if loads is None:
        piece, v0 = spans.length[:, :, None], spans.force[:, 2, :, None]
        gain = weight * piece
    else:
        n = loads.distance.shape[2]
        cuts = np.empty((*spans.length.shape, n + 2))
        cuts[:, :, 0], cuts[:, :, 1:-1], cuts[:, :, -1] = 0.0, loads.distance, spans.length
        piece = cuts[:, :, 1:] - cuts[:, :, :-1]
        gain = weight * piece
        v0 = weight * cuts[:, :, :-1]
        v0 += spans.force[:, 2, :, None]
        v0[:, :, 1:] += loads.mass.cumsum(axis=2) * gravity[:, :, None]
    v1 = v0 + gain
    t0, t1 = np.sqrt(h2 + v0 * v0), np.sqrt(h2 + v1 * v1)
    steep0, steep1 = t0 + np.abs(v0), t1 + np.abs(v1)
    brackets = np.where(v0 >= 0.0, steep0, h2 / steep0) + np.where(v1 <= 0.0, steep1, h2 / steep1)
    angle = np.log1p(2.0 * gain / brackets) / weight
    both = v0 + v1
    across, lift = angle + c1 * piece, 1.0 / (t0 + t1) + 0.5 * c1
    if spans.c2.any():
        c2 = spans.c2[:, :, None]
        across = across + c2 * (piece / 4.0 * (t0 + t1 + both * both / (t0 + t1)) + h2 * angle / 2.0)
        lift = lift + c2 * (t0 * t0 + t0 * t1 + t1 * t1) / (3.0 * (t0 + t1))
    total = across.sum(axis=2)
    reach = np.empty_like(spans.force)
    reach[:, :2] = spans.force[:, :2] * total[:, None]
    reach[:, 2] = (piece * both * lift).sum(axis=2)
    return Shape(reach, v1[:, :, -1], v0, v1, t0, t1, piece, angle)


def pulls(spans: Spans, found: Shape) -> np.ndarray:
    """Pulls of the ropes on what their ends sit at, (3, records, 2 spans + 1): of ends a, of ends b, and none."""
    n = spans.length.shape[1]
    force = np.zeros((3, len(spans.length), 2 * n + 1))
    force[:, :, :n] = spans.force.transpose(1, 0, 2)
    force[:2, :, n : 2 * n] = -force[:2, :, :n]
    force[2, :, n : 2 * n] = -found.vertical_b
    return force
