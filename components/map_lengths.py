"""Ground lengths between points on a map, from degrees or from coordinates of a projection with its scale error."""

from __future__ import annotations

from typing import Any

import numpy as np

from ropeway.components.errors import InputError

_BEYOND = 10.0
"""Coordinates farther than this outside the area of use of their system are treated as local [degrees]."""
_REPROJECT = 'Use a metric coordinate system, such as UTM "EPSG:32632"'


def ground_steps(name: str, crs: Any, east: np.ndarray, north: np.ndarray) -> np.ndarray:
    """Lengths between successive points of a map.

    Parameters
    ----------
    name : str
        Name of the map, for error messages.
    crs : rasterio.crs.CRS or None
        Coordinate system of the points; None: metres.
    east, north : ndarray, shape (n,)
        The points, longitude and latitude in degrees where the system is geographic.

    Returns
    -------
    ndarray, shape (n - 1,)
        Geodesics on the ellipsoid of the system [m]. Coordinates that are invalid in that system are treated as local:
        plane distances.

    Raises
    ------
    InputError
        The system defines no lengths, or pyproj is not installed.
    """
    flat = np.hypot(np.diff(east), np.diff(north))
    if crs is None:
        return flat
    system = horizontal(name, crs)
    if system.is_geographic:
        if np.abs(north).max() > 90.0 or np.abs(east).max() > 360.0:
            raise InputError(f"{name} is in degrees, start or end is not", "Give (longitude, latitude) in degrees")
        longitude, latitude = east, north
    else:
        metres = flat * float(system.axis_info[0].unit_conversion_factor)
        if system.is_engineering:
            return metres
        if is_local(name, system, east, north):
            return metres
        longitude, latitude = _degrees(name, system, east, north)
    geod = system.get_geod()
    return np.asarray(geod.inv(longitude[:-1], latitude[:-1], longitude[1:], latitude[1:])[2], dtype=float)


def horizontal(name: str, crs: Any) -> Any:
    """The horizontal part of a raster's coordinate system, as pyproj's. Raises InputError."""
    system = as_pyproj(name, crs)
    while system.is_compound or system.is_bound:
        system = system.sub_crs_list[0] if system.is_compound else system.source_crs
    units = {axis.unit_name for axis in system.axis_info if axis.direction not in ("up", "down")}
    if not (system.is_projected or system.is_geographic or system.is_engineering) or len(units) != 1:
        raise InputError(f"{name} has the coordinate system {system.name!r}", _REPROJECT)
    if system.is_geographic and units != {"degree"}:
        raise InputError(f"{name} is in {units.pop()}", _REPROJECT)
    return system


def vertical_unit(name: str, crs: Any) -> str:
    """Symbol of the unit of heights in a raster's coordinate system, "" if undefined. Raises InputError for depths."""
    if crs is None:
        return ""
    for axis in as_pyproj(name, crs).axis_info:
        if axis.direction == "down":
            raise InputError(
                f"{name} contains depths according to its coordinate system", "Give a raster of elevations"
            )
        if axis.direction == "up":
            return str(axis.unit_name)
    return ""


def vertical_name(name: str, crs: Any) -> str:
    """Name of the vertical part of a coordinate system, "" where there is none. Raises InputError."""
    parts = as_pyproj(name, crs).sub_crs_list
    return next((str(part.name) for part in parts if part.is_vertical), "")


def as_pyproj(name: str, crs: Any) -> Any:
    """A raster's coordinate system as pyproj's. Raises InputError."""
    try:
        import pyproj
    except ImportError as error:
        raise InputError(f"Lengths in {name} need pyproj", "pip install ropeway[gis]") from error
    try:
        return pyproj.CRS.from_user_input(crs)
    except pyproj.exceptions.CRSError as error:
        raise InputError(f"{name} has a coordinate system that cannot be read: {error}", _REPROJECT) from error


def _degrees(name: str, system: Any, east: np.ndarray, north: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Longitudes and latitudes of points; infinite for invalid coordinates."""
    import pyproj

    around = system.geodetic_crs
    if {axis.unit_name for axis in around.axis_info} - {"metre"} != {"degree"}:
        raise InputError(f"{name} has the coordinate system {system.name!r}", _REPROJECT)
    longitude, latitude = pyproj.Transformer.from_crs(system, around, always_xy=True).transform(east, north)
    return np.asarray(longitude, dtype=float), np.asarray(latitude, dtype=float)


def is_local(name: str, system: Any, east: np.ndarray, north: np.ndarray) -> bool:
    """Whether points are invalid, or far outside the area of use of a projected system of pyproj. Raises InputError."""
    import pyproj

    longitude, latitude = _degrees(name, system, east, north)
    if not np.all(np.isfinite(longitude)) or not np.all(np.isfinite(latitude)):
        return True
    code = system.to_epsg()
    area = system.area_of_use if code is None else pyproj.CRS.from_epsg(code).area_of_use
    if area is None:
        return False
    eastward = (longitude - area.west) % 360.0
    wide = (area.east - area.west) % 360.0 or 360.0
    beyond = np.minimum(np.maximum(eastward - wide, 0.0), 360.0 - eastward)
    above = np.maximum(np.maximum(area.south - latitude, latitude - area.north), 0.0)
    return bool(np.maximum(beyond, above).max() > _BEYOND)
