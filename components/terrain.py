"""A terrain profile along a corridor: piecewise linear ground, and the clearance of ropes and loads above it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ropeway.components import check, profile_points, table
from ropeway.components.accepted_values import RefusedError
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.map_frame import MapFrame
from ropeway.components.notebook_figure import new_figure
from ropeway.components.profile_geometry import ProfileGeometry

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STATIONS = table.TableLayout({"station": "m", "elevation": "m"}, "station,elevation\n0,846.4\n10,840.1")


@checked
@dataclass(frozen=True, eq=False)
class Profile(ProfileGeometry):
    """The ground along a corridor, straight between its points.

    Parameters
    ----------
    station : array_like
        Stations [m], increasing.
    elevation : array_like
        Elevations at these stations [m].
    map_frame : MapFrame, optional
        Where the corridor lies on a map.

    Raises
    ------
    InputError
        Unequal numbers of values, values that are not finite, or stations that do not increase.

    Examples
    --------
    >>> ground = rw.Profile([0.0, 50.0, 120.0], [3.0, 5.0, -4.0])
    >>> float(ground.elevation_at(25.0))
    4.0
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
            A table with columns station and elevation [m]; or with those of `from_points`. Other columns are
            ignored.

        Returns
        -------
        Profile
            The profile.

        Raises
        ------
        InputError
            The table is invalid; the message has file, line and column.
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
        crs : str, optional
            Coordinate system of a raster that does not declare one, such as "EPSG:2056".

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

        reading = Reading(spacing, band, unit, nodata, largest_jump, crs)
        start, end = check.pair(start, "from_dem", "start"), check.pair(end, "from_dem", "end")
        try:
            raster = rasterio.open(path)
        except (rasterio.errors.RasterioIOError, rasterio.errors.NotGeoreferencedWarning, TypeError) as error:
            raise InputError(f"{path} is not a raster: {error}", "Give the path of a raster of elevations") from error
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
        """The position of the profile on a map.

        Returns
        -------
        MapFrame
            Origin, azimuth and coordinate system.

        Raises
        ------
        InputError
            It is unknown.
        """
        if self.map_frame is None:
            raise InputError(
                f"{self!r} has no map coordinates", "Make it with from_dem or from_points, or give it a map_frame"
            )
        return self.map_frame

    def plot(self) -> Figure:
        """Plot the ground to scale.

        Returns
        -------
        matplotlib.figure.Figure
        """
        figure = new_figure(figsize=(10.0, 3.6), layout="constrained")
        axis = figure.subplots()
        axis.fill_between(self.station, self.elevation, self.elevation.min(), color="0.88", lw=0)
        axis.plot(self.station, self.elevation, color="0.35", lw=1.3)
        axis.set(xlabel="station [m]", ylabel="elevation [m]")
        axis.set_aspect("equal", adjustable="datalim")
        axis.grid(alpha=0.3)
        return figure

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
        return Profile(stations, self.elevations(stations), self.map_frame)


ProfileSource = Profile | table.Source
"""A profile, or the table of one with station and elevation [m]: its path or a DataFrame."""


def profile_of(ground: ProfileSource | None) -> Profile | None:
    """The profile that an argument stands for. Raises RefusedError, InputError."""
    return None if ground is None else Profile._from_given(ground)
