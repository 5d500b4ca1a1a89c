"""The parabola: a taut rope as a string with the shear of a simple beam. Used for initial guesses only.

The stretched length of a rope exceeds its chord by S/(2 T^2), where S is the integral of the squared beam shear along
the chord. It adds up over spans with one tension.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ropeway.components.catenary import Strain


class Chords(NamedTuple):
    """Chords between supports: each of shape (n,) [m]; `middle`: height of mid-chord over the first support."""

    length: np.ndarray
    horizontal: np.ndarray
    rise: np.ndarray
    middle: np.ndarray

    @classmethod
    def between(cls, points: np.ndarray) -> Chords:
        """From support positions of shape (n + 1, 3)."""
        d = np.diff(points, axis=0)
        middle = (points[:-1, 2] + points[1:, 2]) / 2.0 - points[0, 2]
        return cls(np.linalg.norm(d, axis=1), np.hypot(d[:, 0], d[:, 1]), d[:, 2], middle)


class Beam(NamedTuple):
    """A span as a simple beam, shapes (n,): upward reaction at its start [N] and the integral of the squared
    shear across the chord [N2 m]."""

    reaction: np.ndarray
    shear: np.ndarray


def beam(chords: Chords, weight: float, lengths: np.ndarray, distances: np.ndarray, loads: np.ndarray) -> Beam:
    """Beam values of spans of unstretched `lengths` (n,) with `loads` [N] (n, k) at `distances` [m] (n, k)."""
    place = np.clip(distances / lengths[:, None], 0.0, 1.0)
    total = weight * lengths
    reaction = total / 2.0 + np.sum(loads * (1.0 - place), axis=1)
    order = np.argsort(place, axis=1, kind="stable")
    place, force = np.take_along_axis(place, order, 1), np.take_along_axis(loads, order, 1)
    n = len(lengths)
    start = np.concatenate([np.zeros((n, 1)), place], axis=1)
    end = np.concatenate([place, np.ones((n, 1))], axis=1)
    carried = np.concatenate([np.zeros((n, 1)), np.cumsum(force, axis=1)], axis=1)
    q0 = reaction[:, None] - carried - total[:, None] * start
    q1 = reaction[:, None] - carried - total[:, None] * end
    square = np.sum((end - start) * (q0 * q0 + q0 * q1 + q1 * q1) / 3.0, axis=1) * chords.length
    return Beam(reaction, square * (chords.horizontal / chords.length) ** 2)


def tensions(chords: Chords, weight: float, spans: Beam, reference: np.ndarray | float) -> np.ndarray:
    """Mean tension of each span [N] from the tension at the height of the first support, with a lower bound from the
    weight of the rope."""
    floor = 0.05 * spans.reaction + 0.5 * weight * np.abs(chords.rise)
    return np.maximum(reference + weight * chords.middle, floor)


def rope_lengths(chords: Chords, spans: Beam, strain: Strain, tension: np.ndarray) -> np.ndarray:
    """Unstretched lengths of spans at their mean tensions [m]."""
    return (chords.length + spans.shear / (2.0 * tension**2)) / (1.0 + strain.at(tension))


def common_tension(
    chords: Chords, weight: float, spans: Beam, strain: Strain, total: np.ndarray, group: np.ndarray
) -> np.ndarray:
    """Tension at the height of the first support [N] of each group of spans with one rope of unstretched length `total`
    (groups,); `group` (n,) is the group of each span. Bisection to a relative error of 1e-6."""
    count = len(total)
    low = np.full(count, 1e-3)
    high = np.full(count, 1e9)
    for _ in range(26):
        middle = np.sqrt(low * high)
        lengths = rope_lengths(chords, spans, strain, tensions(chords, weight, spans, middle[group]))
        too_long = np.bincount(group, lengths, minlength=count) > total
        low, high = np.where(too_long, middle, low), np.where(too_long, high, middle)
    return np.asarray(np.sqrt(low * high))
