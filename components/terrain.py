"""A terrain profile along a corridor: piecewise linear ground, and the clearance of ropes and loads above it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ropeway.components import check, table
from ropeway.components.accepted_values import RefusedError
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import segment
from ropeway.components.errors import InputError
from ropeway.components.rope_piece import Piece

_STATIONS = table.TableLayout({"station": "m", "elevation": "m"}, "station,elevation\n0,846.4\n10,840.1")
_COORDINATES = table.TableLayout(
    dict.fromkeys("xyz", "m"), "x,y,z\n2600030.5,1200300.0,846.4\n2600040.1,1200302.5,840.1"
)


class Clearance(NamedTuple):
    """Smallest height above the ground [m], and its station [m]."""

    height: float
    station: float


@checked
@dataclass(frozen=True, eq=False)
class Profile:
    """The ground along a corridor, straight between its points.

    Parameters
    ----------
    station : array_like
        Stations [m], increasing.
    elevation : array_like
        Elevations at these stations [m].

    Raises
    ------
    InputError
        Unequal numbers of values, values that are not finite, or stations that do not increase.
    """

    station: np.ndarray
    elevation: np.ndarray

    def __init__(self, station: ArrayLike, elevation: ArrayLike) -> None:
        x, z = np.array(station, dtype=float), np.array(elevation, dtype=float)
        if x.ndim != 1 or x.shape != z.shape or len(x) < 2:
            raise InputError(
                f"Profile has stations of shape {x.shape} and elevations of shape {z.shape}",
                "Give as many elevations as stations, at least two",
            )
        if not np.all(np.isfinite(x)) or not np.all(np.isfinite(z)):
            raise InputError("Profile holds a value that is not finite", "Remove NaN and inf")
        if np.any(np.diff(x) <= 0.0):
            k = int(np.argmax(np.diff(x) <= 0.0))
            raise InputError(f"Profile stations do not increase: {x[k + 1]:g} m after {x[k]:g} m", "Sort them")
        object.__setattr__(self, "station", x)
        object.__setattr__(self, "elevation", z)

    def __repr__(self) -> str:
        return f"<Profile of {len(self.station)} points, {self.station[0]:g} to {self.station[-1]:g} m>"

    @classmethod
    def _from_given(cls, value: object) -> Profile:
        """A profile as users give it: itself, or what `from_csv` reads. Raises RefusedError, InputError."""
        if isinstance(value, Profile):
            return value
        if isinstance(value, (str, Path, pd.DataFrame)):
            return cls.from_csv(value)
        raise RefusedError(value, "a Profile, or its table as a path or a DataFrame")

    @classmethod
    def from_csv(cls, path: table.Source) -> Profile:
        """A profile from a table, see `docs/files.md`.

        Parameters
        ----------
        path : str, Path or DataFrame
            A table with columns station and elevation [m]; or with columns x, y, z [m], the vertices of a line in map
            coordinates, whose station is the horizontal length along it. Other columns are ignored.

        Returns
        -------
        Profile
            The profile.

        Raises
        ------
        InputError
            The table is invalid; the message has file, line and column.
        """
        read = table.read(path, _STATIONS, _COORDINATES)
        if read.layout is _STATIONS:
            station, elevation = read.numbers("station", "elevation").T
        else:
            x, y, elevation = read.numbers("x", "y", "z").T
            station = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
            in_degrees = np.abs(x).max() <= 180.0 and np.abs(y).max() <= 90.0
            if in_degrees and np.ptp(elevation) > 20.0 * station[-1]:
                raise read.error(
                    f"{station[-1]:g} m long and {np.ptp(elevation):g} m high", "Are x and y in degrees? Give metres"
                )
        read.require_increase(station, "station", "m")
        if len(read) < 2:
            raise read.error("it has 1 point", "Give at least two")
        return cls(station, elevation)

    @classmethod
    def from_dem(
        cls,
        path: str | Path,
        start: tuple[float, float],
        end: tuple[float, float],
        spacing: float | None = None,
        *,
        band: int | None = None,
        unit: str | None = None,
        nodata: float | None = None,
        largest_jump: float | None = None,
    ) -> Profile:
        """A profile along a straight line over an elevation raster, see `docs/files.md`; needs the extra `gis`.

        Parameters
        ----------
        path : str or Path
            The raster.
        start, end : tuple of float
            Easting and northing in the raster's coordinate system; longitude and latitude [degrees] if it is
            geographic.
        spacing : float, optional
            Approximate distance between stations [m]; by default half a cell.
        band : int, optional
            The band with the elevations, from 1; required if there are several.
        unit : str, optional
            Unit of the elevations, such as "m" or "ft"; by default that of the band or of the vertical coordinate
            system.
        nodata : float, optional
            A value for missing data, in addition to the one that the raster declares.
        largest_jump : float, optional
            Largest plausible difference between neighbouring cells [m]; by default 50 m and three times their distance.

        Returns
        -------
        Profile
            The profile, from start to end.

        Raises
        ------
        InputError
            The line leaves the raster or its data, or the meaning of the raster's numbers is unclear.
        """
        try:
            import rasterio
        except ImportError as error:
            raise InputError("Reading a raster needs rasterio", "pip install ropeway[gis]") from error
        from ropeway.components.elevation_raster import Reading, along

        reading = Reading(spacing, band, unit, nodata, largest_jump)
        start, end = check.pair(start, "from_dem", "start"), check.pair(end, "from_dem", "end")
        try:
            raster = rasterio.open(path)
        except (rasterio.errors.RasterioIOError, rasterio.errors.NotGeoreferencedWarning, TypeError) as error:
            raise InputError(f"{path} is not a raster: {error}", "Give the path of a raster of elevations") from error
        with raster:
            return cls(*along(raster, str(path), start, end, reading))

    def elevation_at(self, station: float) -> float:
        """Elevation at a station.

        Parameters
        ----------
        station : float
            Station [m].

        Returns
        -------
        float
            Elevation [m].

        Raises
        ------
        InputError
            The station is outside the profile.
        """
        if not self.station[0] <= station <= self.station[-1]:
            raise InputError(
                f"Station {station:g} m is outside the profile",
                f"It runs from {self.station[0]:g} m to {self.station[-1]:g} m",
            )
        return float(np.interp(station, self.station, self.elevation))

    def elevations(self, stations: float | np.ndarray) -> np.ndarray:
        """Elevations at stations.

        Parameters
        ----------
        stations : float or ndarray
            Stations [m].

        Returns
        -------
        ndarray
            Elevations [m], NaN outside the profile.
        """
        return np.asarray(np.interp(stations, self.station, self.elevation, left=np.nan, right=np.nan))

    def slope_at(self, station: float) -> float:
        """Slope of the ground at a station; at a vertex that of the segment after it.

        Parameters
        ----------
        station : float
            Station [m].

        Returns
        -------
        float
            Rise over run.

        Raises
        ------
        InputError
            The station is outside the profile.
        """
        self.elevation_at(station)
        k = min(int(np.searchsorted(self.station, station, side="right")) - 1, len(self.station) - 2)
        return float(np.diff(self.elevation[k : k + 2])[0] / np.diff(self.station[k : k + 2])[0])

    def vertex_at(self, station: float) -> tuple[float, float, float, float, float]:
        """The vertex nearest to a station.

        Parameters
        ----------
        station : float
            Station [m].

        Returns
        -------
        station, elevation, before, after, half : float
            Position of the vertex [m], slopes before and after it (rise over run; at an end that of the outermost
            segment), half the length of its shorter segment [m].
        """
        k = int(np.argmin(np.abs(self.station - station)))
        last = len(self.station) - 2
        around = [max(k - 1, 0), min(k, last)]
        runs = np.diff(self.station)[around]
        before, after = np.diff(self.elevation)[around] / runs
        return float(self.station[k]), float(self.elevation[k]), float(before), float(after), 0.5 * float(runs.min())

    def chord_slope(self, start: float, end: float) -> float:
        """Slope of the straight line between the ground at two stations.

        Parameters
        ----------
        start, end : float
            Stations [m].

        Returns
        -------
        float
            Rise over run.

        Raises
        ------
        InputError
            Equal stations, or one outside the profile.
        """
        if start == end:
            raise InputError(f"Both stations are {start:g} m", "Give two different ones")
        return (self.elevation_at(end) - self.elevation_at(start)) / (end - start)

    def resampled(self, spacing: float) -> Profile:
        """The profile at equidistant stations, with its first and last.

        Parameters
        ----------
        spacing : float
            Approximate distance of the stations [m].

        Returns
        -------
        Profile
            The resampled profile.

        Raises
        ------
        InputError
            A spacing that is not positive, or too small.
        """
        check.positive(spacing, "Profile", "spacing", "m")
        check.count((self.station[-1] - self.station[0]) / spacing, "Profile.resampled", "stations", 1_000_000)
        count = max(2, round((self.station[-1] - self.station[0]) / spacing) + 1)
        stations = np.linspace(self.station[0], self.station[-1], count)
        return Profile(stations, self.elevations(stations))

    def clearance(self, piece: Piece) -> Clearance:
        """Smallest height of a piece of rope above the ground.

        Exact: it is at the ends, above a vertex of the ground, or where the rope is parallel to the ground.

        Parameters
        ----------
        piece : Piece
            A load-free piece of rope.

        Returns
        -------
        Clearance
            Height and station [m]; (inf, nan) if there is no ground below.
        """
        return least_height(self, piece)

    def clearance_of_line(self, points: Sequence[tuple[float, float]] | np.ndarray) -> Clearance:
        """Smallest height of a polygonal line above the ground, exact.

        Parameters
        ----------
        points : sequence of tuple of float
            Its vertices (x, z) [m], one or more.

        Returns
        -------
        Clearance
            Height and station [m]; (inf, nan) if there is no ground below.

        Raises
        ------
        InputError
            No points.
        """
        line = np.asarray(points, dtype=float).reshape(-1, 2)
        if not len(line):
            raise InputError("The line has no points", "Give one or more (x, z)")
        line = line[np.argsort(line[:, 0], kind="stable")]
        x = np.union1d(line[:, 0], self.station[(self.station > line[0, 0]) & (self.station < line[-1, 0])])
        height = np.interp(x, line[:, 0], line[:, 1]) - self.elevations(x)
        if np.all(np.isnan(height)):
            return Clearance(math.inf, math.nan)
        k = int(np.nanargmin(height))
        return Clearance(float(height[k]), float(x[k]))


ProfileSource = Profile | table.Source
"""A profile, or the table of one with station and elevation [m]: its path or a DataFrame."""


def profile_of(ground: ProfileSource | None) -> Profile | None:
    """The profile that an argument stands for. Raises RefusedError, InputError."""
    return None if ground is None else Profile._from_given(ground)


def least_height(ground: Profile, piece: Piece) -> Clearance:
    """`Profile.clearance` without its check of arguments, for repeated calls."""
    fx, fy, v0 = piece.force
    total, _, _ = segment(piece.force, piece.weight, piece.length, piece.strain).reach
    x0, z0 = piece.start
    low, high = max(x0, ground.station[0]), min(x0 + total, ground.station[-1])
    if not low <= high:
        return Clearance(math.inf, math.nan)
    slopes = np.diff(ground.elevation) / np.diff(ground.station)
    parallel = np.clip((slopes * abs(fx) - v0) / piece.weight, 0.0, piece.length)
    inside = ground.station[(ground.station > low) & (ground.station < high)]
    along = np.concatenate([parallel, piece.distances(np.array([low, *inside, high]), float(total))])
    reach = segment((fx, fy, v0), piece.weight, along, piece.strain).reach
    x = x0 + reach[0]
    height = z0 + reach[2] - np.interp(x, ground.station, ground.elevation)
    height[: len(parallel)][(x[: len(parallel)] < low) | (x[: len(parallel)] > high)] = np.inf
    k = int(np.argmin(height))
    return Clearance(float(height[k]), float(x[k]))


def above_tangents(ground: Profile, piece: Piece, end: tuple[float, float]) -> float:
    """Smallest height above the ground of the tangents at a piece's start and `end` (x, z) [m].

    The rope is above both tangents. inf if there is no ground below.
    """
    (x0, z0), (x1, z1), force = piece.start, end, piece.force
    low, high = max(x0, ground.station[0]), min(x1, ground.station[-1])
    if not low <= high:
        return math.inf
    a, b = force[2] / force[0], (force[2] + piece.weight * piece.length) / force[0]
    crossing = (z0 - z1 + b * x1 - a * x0) / (b - a)
    inside = ground.station[(ground.station > low) & (ground.station < high)]
    x = np.array([low, min(max(crossing, low), high), high, *inside])
    line = np.maximum(z0 + a * (x - x0), z1 + b * (x - x1))
    return float((line - np.interp(x, ground.station, ground.elevation)).min())


def deflection(sag: float, span: float) -> float:
    """Deflection in percent of the horizontal span."""
    return 100.0 * sag / span
