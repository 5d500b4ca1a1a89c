"""Profiles from points in map coordinates: arrays, tables, GPX files."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pandas as pd

from ropeway.components import table
from ropeway.components.errors import InputError, RopewayWarning
from ropeway.components.map_columns import in_map_unit
from ropeway.components.map_frame import WGS84, MapFrame, require_projected, transformed, utm_of

LAYOUTS = tuple(
    table.TableLayout(
        dict.fromkeys(keys, "m"), f"{','.join(keys)}\n2600030.5,1200300.0,846.4\n2600040.1,1200302.5,840.1"
    )
    for keys in (("x", "y", "z"), ("easting", "northing", "elevation"))
)
"""Tables of points."""
_CROOKED = 0.01
"""A broken line that is longer than the straight one by more than this part is not the corridor of a rope."""


@dataclass(frozen=True)
class Points:
    """Points along a corridor: `name` of where they come from, for errors; coordinates shape (n, 3)."""

    name: str
    crs: str
    at: np.ndarray

    def __post_init__(self) -> None:
        if len(self.at) < 2:
            raise InputError(f"{self.name}: it has {len(self.at)} point", "Give at least two")
        station, height = np.hypot(*np.ptp(self.at[:, :2], axis=0)), np.ptp(self.at[:, 2])
        if np.abs(self.at[:, 0]).max() <= 180.0 and np.abs(self.at[:, 1]).max() <= 90.0 and height > 20.0 * station:
            raise InputError(
                f"{self.name}: {station:g} m long and {height:g} m high", "Are x and y in degrees? Give metres"
            )

    def warn_crooked(self) -> None:
        """A RopewayWarning where the broken line is longer than a straight one."""
        along = np.hypot(*np.diff(self.at[:, :2], axis=0).T).sum()
        direct = math.dist(self.at[0, :2], self.at[-1, :2])
        if along > (1.0 + _CROOKED) * direct:
            warnings.warn(
                f"{self.name}: the line through its points is {along:.1f} long, the straight one from the first to the "
                f"last {direct:.1f}. A rope hangs in one plane: straight=True projects the points",
                RopewayWarning,
                stacklevel=4,
            )

    def profile(self, *, straight: bool = False) -> tuple[np.ndarray, np.ndarray, MapFrame]:
        """Stations, elevations and the frame of the corridor. Raises InputError."""
        east, north, elevation = self.at.T
        ends = [0, -1]
        if np.hypot(*np.ptp(self.at[ends, :2], axis=0)) == 0.0:
            raise InputError(f"{self.name}: its first and its last point are one", "Give points along a corridor")
        if straight:
            start, end = ((float(east[k]), float(north[k])) for k in ends)
            frame = MapFrame.straight(self.crs, start, end)
            station = np.asarray(frame.to_local(east, north)[0])
        else:
            frame = MapFrame.through(self.crs, east, north)
            station = np.array(frame.axis.station)
        falls = np.flatnonzero(np.diff(station) <= 0.0)
        if len(falls):
            k = int(falls[0])
            raise InputError(
                f"{self.name}: point {k + 2} is at station {station[k + 1]:.2f} m, point {k + 1} before it at "
                f"{station[k]:.2f} m",
                "Give the points in their order along the corridor",
            )
        return station, elevation, frame


def read(source: table.Source | Sequence[Sequence[float]] | np.ndarray, crs: str | None) -> Points:
    """Points from an array, a table or a GPX file. Raises InputError."""
    if crs is not None:
        require_projected(crs)
    if isinstance(source, str | Path) and Path(source).suffix.lower() == ".gpx":
        return _of_gpx(Path(source), crs)
    if isinstance(source, str | Path | pd.DataFrame):
        return of_table(table.read(source, *LAYOUTS), crs or "")
    try:
        at = np.array(source, dtype=float)
    except ValueError:
        at = np.empty(0)
    if at.ndim != 2 or at.shape[1] != 3 or not np.all(np.isfinite(at)):
        raise InputError(
            f"Points have the shape {at.shape}, or values that are not finite", "Give easting, northing and elevation"
        )
    return Points("The array of points", crs or "", at)


def of_table(read: table.Table, crs: str) -> Points:
    """Points of a table. Raises InputError with the line of points that repeat."""
    if len(read) < 2:
        raise read.error("it has 1 point", "Give at least two")
    keys = list(read.layout.columns)
    at = read.numbers(*keys)
    at[:, :2] = in_map_unit(read, crs, keys[:2], keys[2], at[:, :2])
    flat = np.hypot(*np.diff(at[:, :2], axis=0).T)
    read.require_increase(np.concatenate([[0.0], np.cumsum(flat)]), "station", "m")
    return Points(read.source, crs, at)


def _of_gpx(path: Path, crs: str | None) -> Points:
    """Points of the first track of a GPX file, else of its first route, else its waypoints; those that repeat count
    once. Raises InputError."""
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise InputError(f"{path} cannot be read as GPX: {error}", "Give the path of a GPX file") from error
    for kind, point in (("trk", "trkpt"), ("rte", "rtept"), ("gpx", "wpt")):
        for one in root.iter():
            found = [p for p in one.iter() if _tag(p) == point] if _tag(one) == kind else []
            if len(found) > 1:
                return _in_metres(path, np.array([_gpx_point(path, k, p) for k, p in enumerate(found, 1)]), crs)
    raise InputError(f"{path} has no track, route or waypoints of two points", "Give a GPX file with one")


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _gpx_point(path: Path, number: int, element: ElementTree.Element) -> tuple[float, float, float]:
    """Longitude, latitude [degrees] and elevation [m]. Raises InputError."""
    texts = [element.get("lon"), element.get("lat"), *(e.text for e in element if _tag(e) == "ele")]
    try:
        longitude, latitude, elevation = (float(text or "") for text in texts)
    except ValueError as error:
        raise InputError(
            f"{path}: point {number} has longitude, latitude and elevation {', '.join(map(str, texts))}",
            "Give each point numbers for its lon, lat and ele",
        ) from error
    return longitude, latitude, elevation


def _in_metres(path: Path, degrees: np.ndarray, crs: str | None) -> Points:
    """Points in a projected system, by default the UTM zone of the first one."""
    degrees = degrees[np.concatenate([[True], np.any(np.diff(degrees[:, :2], axis=0) != 0.0, axis=1)])]
    target: Any = crs or utm_of(*degrees[0, :2])
    east, north = transformed(WGS84, target, degrees[:, 0], degrees[:, 1])
    return Points(str(path), target, np.column_stack([east, north, degrees[:, 2]]))
