"""A terrain profile along a corridor: piecewise linear ground, and how far ropes and loads are above it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ropeway.components import check, profile_points, table
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Strain, Vector, segment
from ropeway.components.errors import InputError
from ropeway.components.map_frame import MapFrame

_STATIONS = table.TableLayout({"station": "m", "elevation": "m"}, "station,elevation\n0,846.4\n10,840.1")


class Clearance(NamedTuple):
    """Least height over the ground [m], and the station where it is [m]."""

    height: float
    station: float


class Piece(NamedTuple):
    """A load-free rope piece in a corridor: its start (x, z) [m], tension vector there [N], weight [N/m],
    unstretched length [m] and strain law. It runs towards growing x."""

    start: tuple[float, float]
    force: Vector
    weight: float
    length: float
    strain: Strain


@checked
@dataclass(frozen=True, eq=False)
class Profile:
    """The ground along a corridor: `station` [m], increasing, and `elevation` [m] there, straight between.

    `map_frame`: where it lies on a map, None where that is unknown. Raises InputError.
    """

    station: np.ndarray
    elevation: np.ndarray
    map_frame: MapFrame | None

    def __init__(self, station: ArrayLike, elevation: ArrayLike, map_frame: MapFrame | None = None) -> None:
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
        object.__setattr__(self, "map_frame", map_frame)

    def __repr__(self) -> str:
        return f"<Profile of {len(self.station)} points, {self.station[0]:g} to {self.station[-1]:g} m>"

    @classmethod
    def from_csv(cls, path: table.Source) -> Profile:
        """From a table, see `docs/files.md`.

        Parameters
        ----------
        path : str, Path or DataFrame
            With columns station and elevation [m]; or with those of `from_points`. Other columns are left alone.

        Raises
        ------
        InputError
            With file, line and column.
        """
        read = table.read(path, _STATIONS, *profile_points.LAYOUTS)
        if read.layout is not _STATIONS:
            return cls(*profile_points.of_table(read, "").profile())
        station, elevation = read.numbers("station", "elevation").T
        read.require_increase(station, "station", "m")
        if len(read) < 2:
            raise read.error("it has 1 point", "Give at least two")
        return cls(station, elevation)

    @classmethod
    def from_points(
        cls,
        points: table.Source | Sequence[Sequence[float]] | np.ndarray,
        crs: str | None = None,
        *,
        straight: bool = False,
    ) -> Profile:
        """Along surveyed points, see `docs/gis.md`.

        Parameters
        ----------
        points : str, Path, DataFrame or array, shape (n, 3)
            Easting, northing and elevation [m] of points along the corridor: an array, a table with columns easting,
            northing, elevation or x, y, z, or a GPX file with a track, a route or waypoints (extra `gis`).
        crs : str, optional
            Projected coordinate system of the points, such as "EPSG:2056"; of a GPX file the one that it is brought
            to, by default its UTM zone. Without one nothing can be exported to a map.
        straight : bool, default False
            Stations are along the straight line from the first to the last point, and points beside it are projected
            onto it; otherwise they are along the broken line through all points.

        Raises
        ------
        InputError
            With file, line and column; for a geographic coordinate system.

        Warns
        -----
        RopewayWarning
            The broken line is more than 1 % longer than the straight one: a rope hangs in one plane.
        """
        found = profile_points.read(points, crs)
        if not straight:
            found.warn_crooked()
        return cls(*found.profile(straight=straight))

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
        crs: str | None = None,
    ) -> Profile:
        """From a raster of elevations, see `docs/files.md`; needs the extra `gis`.

        Parameters
        ----------
        path : str or Path
        start, end : tuple of float
            Easting and northing in the raster's coordinate system; longitude and latitude [degrees] where that is
            geographic.
        spacing : float, optional
            Of the stations on the ground [m], about; by default half a cell.
        band : int, optional
            The one with the elevations, from 1; needed where there are several.
        unit : str, optional
            Of the elevations, such as "m" or "ft"; by default that of the band or of the vertical coordinate system.
        nodata : float, optional
            A value that stands for no data, besides the one that the raster declares.
        largest_jump : float, optional
            Between neighbouring cells [m], above which they are no ground; by default 50 m and three cells.
        crs : str, optional
            Coordinate system of a raster that does not say its own, such as "EPSG:2056".

        Raises
        ------
        InputError
            The line leaves the raster or its data; or the raster leaves open what its numbers are.
        """
        try:
            import rasterio
        except ImportError as error:
            raise InputError("Reading a raster needs rasterio", "pip install ropeway[gis]") from error
        from ropeway.components.elevation_raster import Reading, along

        reading = Reading(spacing, band, unit, nodata, largest_jump, crs)
        start, end = check.pair(start, "from_dem", "start"), check.pair(end, "from_dem", "end")
        try:
            raster = rasterio.open(path)
        except (rasterio.errors.RasterioIOError, rasterio.errors.NotGeoreferencedWarning, TypeError) as error:
            raise InputError(f"{path} is no raster: {error}", "Give the path of a raster of elevations") from error
        with raster:
            return cls(*along(raster, str(path), start, end, reading))

    @property
    def crs(self) -> str:
        """Coordinate system of the map that it lies on, "" where it is unknown."""
        return "" if self.map_frame is None else self.map_frame.crs

    @property
    def azimuth(self) -> float:
        """Direction of the corridor from grid north [degrees clockwise]. Raises InputError without a map."""
        return self.require_map().azimuth

    @property
    def coordinates(self) -> np.ndarray:
        """Easting, northing and elevation of every station, shape (n, 3). Raises InputError without a map."""
        return np.column_stack([*self.require_map().to_map(self.station), self.elevation])

    def require_map(self) -> MapFrame:
        """Where it lies on a map. Raises InputError where that is unknown."""
        if self.map_frame is None:
            raise InputError(
                f"{self!r} has no map coordinates", "Make it with from_dem or from_points, or give it a map_frame"
            )
        return self.map_frame

    def elevation_at(self, station: float) -> float:
        """Elevation [m] at a station [m]. Raises InputError outside the profile."""
        if not self.station[0] <= station <= self.station[-1]:
            raise InputError(
                f"Station {station:g} m is outside the profile",
                f"It runs from {self.station[0]:g} m to {self.station[-1]:g} m",
            )
        return float(np.interp(station, self.station, self.elevation))

    def elevations(self, stations: float | np.ndarray) -> np.ndarray:
        """Elevations [m] at stations [m], NaN outside the profile."""
        return np.asarray(np.interp(stations, self.station, self.elevation, left=np.nan, right=np.nan))

    def slope_at(self, station: float) -> float:
        """Slope of the ground (rise over run) at a station; at a vertex that of the segment after it. Raises
        InputError outside the profile."""
        self.elevation_at(station)
        k = min(int(np.searchsorted(self.station, station, side="right")) - 1, len(self.station) - 2)
        return float(np.diff(self.elevation[k : k + 2])[0] / np.diff(self.station[k : k + 2])[0])

    def vertex_at(self, station: float) -> tuple[float, float, float, float, float]:
        """The vertex nearest to a station (station, elevation), the slopes before and after it, beyond the profile's
        ends those of its outermost segments, and half the shorter of its two segments [m]."""
        k = int(np.argmin(np.abs(self.station - station)))
        last = len(self.station) - 2
        around = [max(k - 1, 0), min(k, last)]
        runs = np.diff(self.station)[around]
        before, after = np.diff(self.elevation)[around] / runs
        return float(self.station[k]), float(self.elevation[k]), float(before), float(after), 0.5 * float(runs.min())

    def chord_slope(self, start: float, end: float) -> float:
        """Slope of the straight line between the ground at two stations (rise over run). Raises InputError."""
        if start == end:
            raise InputError(f"Both stations are {start:g} m", "Give two different ones")
        return (self.elevation_at(end) - self.elevation_at(start)) / (end - start)

    def resampled(self, spacing: float) -> Profile:
        """At even stations about `spacing` metres apart, first and last kept."""
        check.positive(spacing, "Profile", "spacing", "m")
        check.count((self.station[-1] - self.station[0]) / spacing, "Profile.resampled", "stations", 1_000_000)
        count = max(2, round((self.station[-1] - self.station[0]) / spacing) + 1)
        stations = np.linspace(self.station[0], self.station[-1], count)
        return Profile(stations, self.elevations(stations), self.map_frame)

    def clearance(self, piece: Piece) -> Clearance:
        """Least height of a rope piece over the ground, exact: at the ends, over the ground's vertices, and
        where the rope is parallel to the ground between them. (inf, nan) where there is no ground below."""
        return least_height(self, piece)

    def clearance_of_line(self, points: Sequence[tuple[float, float]] | np.ndarray) -> Clearance:
        """Least height of a broken line through `points` (x, z) [m] over the ground, exact; a single point
        too. (inf, nan) where there is no ground below."""
        line = np.asarray(points, dtype=float).reshape(-1, 2)
        if not len(line):
            raise InputError("The line has no points", "Give one or more (x, z)")
        return under_line(self, line)


def under_line(ground: Profile, line: np.ndarray) -> Clearance:
    """`Profile.clearance_of_line` without its check of arguments: of a line through points (n, 2)."""
    line = line[np.argsort(line[:, 0], kind="stable")]
    x = np.union1d(line[:, 0], ground.station[(ground.station > line[0, 0]) & (ground.station < line[-1, 0])])
    height = np.interp(x, line[:, 0], line[:, 1]) - ground.elevations(x)
    if np.all(np.isnan(height)):
        return Clearance(math.inf, math.nan)
    k = int(np.nanargmin(height))
    return Clearance(float(height[k]), float(x[k]))


def least_height(ground: Profile, piece: Piece) -> Clearance:
    """`Profile.clearance` without its check of arguments, for the many calls of a search."""
    fx, fy, v0 = piece.force
    total, _, _ = segment(piece.force, piece.weight, piece.length, piece.strain).reach
    x0, z0 = piece.start
    low, high = max(x0, ground.station[0]), min(x0 + total, ground.station[-1])
    if not low <= high:
        return Clearance(math.inf, math.nan)
    slopes = np.diff(ground.elevation) / np.diff(ground.station)
    parallel = np.clip((slopes * abs(fx) - v0) / piece.weight, 0.0, piece.length)
    inside = ground.station[(ground.station > low) & (ground.station < high)]
    along = np.concatenate([parallel, _distances(piece, np.array([low, *inside, high]), float(total))])
    reach = segment((fx, fy, v0), piece.weight, along, piece.strain).reach
    x = x0 + reach[0]
    height = z0 + reach[2] - np.interp(x, ground.station, ground.elevation)
    height[: len(parallel)][(x[: len(parallel)] < low) | (x[: len(parallel)] > high)] = np.inf
    k = int(np.argmin(height))
    return Clearance(float(height[k]), float(x[k]))


def above_tangents(ground: Profile, piece: Piece, end: tuple[float, float]) -> float:
    """Least height over the ground [m] of the tangents at a piece's start and `end` (x, z) [m]: the rope
    lies above both. inf where there is no ground below."""
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


def _distances(piece: Piece, x: np.ndarray, total: float) -> np.ndarray:
    """Unstretched distances from the start of a piece, which reaches over `total`, at which it is over `x`: Newton's
    method, kept inside the piece."""
    fx, fy, v0 = piece.force
    flat, wanted = math.hypot(fx, fy), x - piece.start[0]
    # The first guess is exact without stretch: equal shares of the angle asinh(v / h).
    first, last = (math.asinh(v / flat) for v in (v0, v0 + piece.weight * piece.length))
    share = np.clip(wanted / total, 0.0, 1.0)
    d = np.clip((flat * np.sinh(first + share * (last - first)) - v0) / piece.weight, 0.0, piece.length)
    for _ in range(50):
        reach = segment((fx, fy, v0), piece.weight, d, piece.strain).reach[0]
        tension = np.hypot(flat, v0 + piece.weight * d)
        rate = fx / tension + fx * (piece.strain.c1 + piece.strain.c2 * tension)
        move = (wanted - reach) / rate
        d = np.clip(d + move, 0.0, piece.length)
        # Convergence is quadratic: after a move of 1e-8 nothing is left but rounding.
        if np.abs(move).max(initial=0.0) <= 1e-8 * (1.0 + abs(total)):
            break
    return d


def deflection(sag: float, span: float) -> float:
    """Deflection in percent of the horizontal span."""
    return 100.0 * sag / span
