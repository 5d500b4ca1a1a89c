"""Where a line lies on a map: from its own axes to the coordinates of a map, and back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropeway.components import check
from ropeway.components.annotation_checks import Numbers
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.map_lengths import as_pyproj, ground_steps, horizontal, is_local
from ropeway.components.plan_axis import PlanAxis

_PIECE = 50.0
"""Length of the pieces of a line within which a map has one scale [m]: 0.1 mm off in Web Mercator at 60 degrees."""
_NO_CRS = 'Give the coordinate system of the map as crs=, such as "EPSG:2056"'
WGS84 = "EPSG:4326"
"""Longitude and latitude [degrees], as in KML and GPX files."""


@checked
@dataclass(frozen=True)
class MapFrame:
    """Where a line's own axes lie on a map.

    Parameters
    ----------
    crs : str
        Projected coordinate system of the map, as an authority's code ("EPSG:2056") or in WKT; "" where it is unknown.
    axis : PlanAxis
        The line's x axis in eastings and northings of the map. Its stations are lengths on the ground [m], whatever
        the scale of the map.
    heights : str, optional
        Name of the vertical coordinate system, if it is known.

    Raises
    ------
    InputError
        The coordinate system is geographic or unknown to pyproj.

    Examples
    --------
    >>> frame = rw.MapFrame.straight("EPSG:2056", (2600000.0, 1200000.0), (2600300.0, 1200400.0))
    >>> round(frame.azimuth, 3)
    36.87
    """

    crs: str
    axis: PlanAxis
    heights: str = ""

    def __post_init__(self) -> None:
        if self.crs:
            require_projected(self.crs)

    @classmethod
    def straight(cls, crs: str, start: tuple[float, float], end: tuple[float, float], heights: str = "") -> MapFrame:
        """The frame of a line that is straight on the map.

        Parameters
        ----------
        crs : str
            Projected coordinate system, "" if it is unknown.
        start, end : tuple of float
            Easting and northing; stations count from `start`.
        heights : str, optional
            Name of the vertical coordinate system.

        Returns
        -------
        MapFrame
            The frame.

        Raises
        ------
        InputError
            Both points are the same, or the coordinate system is geographic or unknown to pyproj.
        """
        start, end = check.pair(start, "MapFrame", "start"), check.pair(end, "MapFrame", "end")
        if start == end:
            raise InputError("MapFrame: start and end are one point", "Give two different points")
        check.count(math.dist(start, end) / _PIECE, "MapFrame", "pieces", 100_000)
        count = max(2, math.ceil(math.dist(start, end) / _PIECE) + 1)
        east, north = (np.linspace(a, b, count) for a, b in zip(start, end, strict=True))
        return cls.through(crs, east, north, heights)

    @classmethod
    def through(cls, crs: str, easting: np.ndarray, northing: np.ndarray, heights: str = "") -> MapFrame:
        """The frame of a broken line through points of the map.

        Parameters
        ----------
        crs : str
            Projected coordinate system, "" if it is unknown.
        easting, northing : ndarray, shape (n,)
            The points; stations are lengths on the ground from the first one along the line.
        heights : str, optional
            Name of the vertical coordinate system.

        Returns
        -------
        MapFrame
            The frame.

        Raises
        ------
        InputError
            Points that repeat, or a coordinate system that is geographic or unknown to pyproj.
        """
        if np.ndim(easting) != 1 or np.shape(easting) != np.shape(northing):
            raise InputError(
                f"MapFrame has eastings of shape {np.shape(easting)} and northings of shape {np.shape(northing)}",
                "Give as many of each, in a row",
            )
        if crs:
            require_projected(crs)
        known = as_pyproj("MapFrame", crs) if crs else None
        steps = ground_steps("MapFrame", known, np.asarray(easting), np.asarray(northing))
        station = np.concatenate([[0.0], np.cumsum(steps)])
        return cls(crs, PlanAxis(*(tuple(v.tolist()) for v in (station, easting, northing))), heights)

    @property
    def azimuth(self) -> float:
        """Direction of the line from its first to its last point, from grid north [degrees clockwise]."""
        east, north = (v[-1] - v[0] for v in (self.axis.x, self.axis.y))
        return math.degrees(math.atan2(east, north)) % 360.0

    def to_map(self, x: Numbers, y: Numbers = 0.0) -> tuple[Numbers, Numbers]:
        """Map coordinates of places.

        Parameters
        ----------
        x, y : float or ndarray
            Stations, and offsets to the left of the line [m].

        Returns
        -------
        easting, northing : float or ndarray
            In the unit of the map.
        """
        return self.axis.place(*_together(x, y))

    def to_local(self, easting: Numbers, northing: Numbers) -> tuple[Numbers, Numbers]:
        """Places of points of the map.

        Parameters
        ----------
        easting, northing : float or ndarray
            In the unit of the map.

        Returns
        -------
        x, y : float or ndarray
            Station, and offset to the left of the line [m].
        """
        return self.axis.locate(*_together(easting, northing))

    def to_degrees(self, x: Numbers, y: Numbers = 0.0) -> tuple[Numbers, Numbers]:
        """Longitude and latitude (WGS 84) of places.

        Parameters
        ----------
        x, y : float or ndarray
            Stations, and offsets to the left of the line [m].

        Returns
        -------
        longitude, latitude : float or ndarray
            Degrees.

        Raises
        ------
        InputError
            The coordinate system of the map is unknown.
        """
        easting, northing = self.to_map(x, y)
        return transformed(self.require_crs(), WGS84, easting, northing)

    def require_crs(self) -> str:
        """The coordinate system.

        Returns
        -------
        str
            Its name or code.

        Raises
        ------
        InputError
            It is unknown, or the line lies far outside the area where it is used.
        """
        if not self.crs:
            raise InputError("The coordinate system of the map is unknown", _NO_CRS)
        system = horizontal("The map", self.crs)
        if system.is_projected and is_local("The map", system, np.array(self.axis.x), np.array(self.axis.y)):
            raise InputError(
                f"The line lies far outside the area of {self.crs} ({system.name}): its first point is "
                f"{self.axis.x[0]:.6g}, {self.axis.y[0]:.6g}",
                "Give the coordinate system of its points, eastings first; or none where they are local",
            )
        return self.crs


def _together(one: Numbers, other: Numbers) -> tuple[Numbers, Numbers]:
    """Both with one shape. Raises InputError."""
    try:
        np.broadcast_shapes(np.shape(one), np.shape(other))
    except ValueError as error:
        cause = f"MapFrame has coordinates of shapes {np.shape(one)} and {np.shape(other)}"
        raise InputError(cause, "Give as many of each, or one number") from error
    return one, other


def require_projected(crs: str) -> None:
    """Raises InputError for a system without eastings and northings: of degrees, or with axes to the west or south."""
    system = horizontal(f"Coordinate system {crs!r}", crs)
    if system.is_geographic:
        raise InputError(
            f"Coordinate system {crs!r} ({system.name}) is geographic: its coordinates are degrees",
            'Give eastings and northings of a projected one, such as UTM "EPSG:32632"',
        )
    directions = [axis.direction for axis in system.axis_info]
    if "west" in directions or set(directions) == {"east", "south"}:
        raise InputError(
            f"Coordinate system {crs!r} ({system.name}) has axes that point {' and '.join(directions)}",
            "Azimuths need eastings and northings: transform the coordinates, for example to UTM",
        )


def transformed(source: Any, target: Any, x: Numbers, y: Numbers) -> tuple[Numbers, Numbers]:
    """Coordinates of one system in another, east before north in both. Raises InputError where they have none."""
    import pyproj

    try:
        way = pyproj.Transformer.from_crs(horizontal("The map", source), target, always_xy=True)
    except pyproj.exceptions.ProjError as error:
        raise InputError(f"No way is known from {source} to {target}: {error}", "Give another crs") from error
    found = way.transform(x, y)
    if not np.all(np.isfinite(found)):
        raise InputError(f"Points of {source} have no coordinates in {target}", "Check their coordinate system")
    return found


def name_of(system: Any) -> str:
    """A system of pyproj as text: its code where it has one, else WKT."""
    code = system.to_authority()
    return ":".join(code) if code else str(system.to_wkt())


def thinned(station: np.ndarray) -> np.ndarray:
    """Places of stations about every 50 m, first and last among them."""
    count = max(2, math.ceil(float(station[-1] - station[0]) / _PIECE) + 1)
    return np.unique(np.linspace(0, len(station) - 1, count).round().astype(int))


def utm_of(longitude: float, latitude: float) -> str:
    """Code of the UTM zone of a place [degrees]."""
    zone = int((longitude + 180.0) % 360.0 // 6.0) + 1
    return f"EPSG:{(32600 if latitude >= 0.0 else 32700) + zone}"
