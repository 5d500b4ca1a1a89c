"""Heights of ropes and lines above a terrain profile."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np

from ropeway.components.catenary import Uniform, segment
from ropeway.components.rope_piece import Piece


class GroundLine(Protocol):
    """Ground that is straight between stations: a `Profile`."""

    @property
    def station(self) -> np.ndarray:
        """Stations [m], increasing."""

    @property
    def elevation(self) -> np.ndarray:
        """Elevations there [m]."""

    def elevations(self, stations: float | np.ndarray) -> np.ndarray:
        """Elevations at stations [m], NaN outside."""


class Clearance(NamedTuple):
    """Smallest height above the ground [m], and its station [m]."""

    height: float
    station: float


def under_line(ground: GroundLine, line: np.ndarray) -> Clearance:
    """`Profile.clearance_of_line` without its check of arguments: of a line through points (n, 2)."""
    line = line[np.argsort(line[:, 0], kind="stable")]
    x = np.union1d(line[:, 0], ground.station[(ground.station > line[0, 0]) & (ground.station < line[-1, 0])])
    height = np.interp(x, line[:, 0], line[:, 1]) - ground.elevations(x)
    if np.all(np.isnan(height)):
        return Clearance(math.inf, math.nan)
    k = int(np.nanargmin(height))
    return Clearance(float(height[k]), float(x[k]))


def least_height(ground: GroundLine, piece: Piece) -> Clearance:
    """`Profile.clearance` without its check of arguments, for repeated calls."""
    fx, fy, v0 = piece.force
    total, _, _ = segment(piece.force, piece.weight, piece.length, piece.strain).reach
    x0, z0 = piece.start
    low, high = max(x0, ground.station[0]), min(x0 + total, ground.station[-1])
    if not low <= high:
        return Clearance(math.inf, math.nan)
    slopes = np.diff(ground.elevation) / np.diff(ground.station)
    if isinstance(piece.weight, Uniform):  # where the tension has the slope of the ground
        gain_x, _, gain_z = piece.weight.added((0.0, 0.0, 0.0), piece.weight.size)
        parallel = np.clip((slopes * fx - v0) / (gain_z - slopes * gain_x), 0.0, piece.length)
    else:
        parallel = np.clip((slopes * abs(fx) - v0) / piece.weight, 0.0, piece.length)
    inside = ground.station[(ground.station > low) & (ground.station < high)]
    along = np.concatenate([parallel, piece.distances(np.array([low, *inside, high]), float(total))])
    reach = segment((fx, fy, v0), piece.weight, along, piece.strain).reach
    x = x0 + reach[0]
    height = z0 + reach[2] - np.interp(x, ground.station, ground.elevation)
    height[: len(parallel)][(x[: len(parallel)] < low) | (x[: len(parallel)] > high)] = np.inf
    k = int(np.argmin(height))
    return Clearance(float(height[k]), float(x[k]))


class Spanned(NamedTuple):
    """Load-free pieces of rope in a corridor, towards increasing x: their starts and ends (x, z), shapes (n, 2) [m],
    and the tension vectors there (n, 3) [N]."""

    start: np.ndarray
    end: np.ndarray
    force: np.ndarray
    force_at_end: np.ndarray


def above_tangents(ground: GroundLine, ropes: Spanned) -> np.ndarray:
    """Smallest heights (n,) above the ground of the tangents at the start and the end of each piece [m].

    A rope is above both tangents. inf if there is no ground below; -inf where wind along the rope bends it upwards.
    """
    station, elevation = ground.station, ground.elevation
    (x0, z0), (x1, z1) = ropes.start.T[:, :, None], ropes.end.T[:, :, None]
    low, high = np.maximum(x0, station[0]), np.minimum(x1, station[-1])
    with np.errstate(all="ignore"):
        a, b = ropes.force[:, 2:] / ropes.force[:, :1], ropes.force_at_end[:, 2:] / ropes.force_at_end[:, :1]
        crossing = np.minimum(np.maximum((z0 - z1 + b * x1 - a * x0) / (b - a), low), high)
        ends = np.concatenate([low, crossing, high], axis=1)
        at_ends, over = (np.maximum(z0 + a * (x - x0), z1 + b * (x - x1)) for x in (ends, station))
    over -= elevation
    over[(station < low) | (station > high)] = math.inf
    least = np.minimum((at_ends - np.interp(ends, station, elevation)).min(axis=1), over.min(axis=1))
    hangs = (b > a) & (ropes.force_at_end[:, :1] > 0.0)
    return np.asarray(np.where((low <= high)[:, 0], np.where(hangs[:, 0], least, -math.inf), math.inf))


def deflection(sag: float, span: float) -> float:
    """Deflection in percent of the horizontal span."""
    return 100.0 * sag / span
