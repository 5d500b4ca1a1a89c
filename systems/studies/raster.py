"""Elevations along a line over a raster."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ropeway.components import check
from ropeway.components.errors import InputError

_REPROJECT = "Reproject the raster to a metric coordinate system"


def along(
    raster: Any, name: str, start: tuple[float, float], end: tuple[float, float], spacing: float | None
) -> tuple[np.ndarray, np.ndarray]:
    """Stations and elevations [m] of an open rasterio data set between two points, bilinear between the
    centres of its cells. Raises InputError where there are no data."""
    length = math.dist(start, end)
    if length == 0.0:
        raise InputError(f"{name}: start and end are one point", "Give two different points")
    step = spacing if spacing is not None else min(abs(raster.transform.a), abs(raster.transform.e)) / 2.0
    check.positive(step, name, "spacing", "m")
    check.count(length / step, name, "stations")
    if raster.crs is not None and raster.crs.is_geographic:
        raise InputError(f"{name} is in degrees", _REPROJECT)
    if raster.crs is not None and raster.crs.is_projected and raster.crs.linear_units_factor[1] != 1.0:
        raise InputError(f"{name} is in a unit named {raster.crs.linear_units!r}", _REPROJECT)
    station = np.linspace(0.0, length, max(2, math.ceil(length / step) + 1))
    share = station / length
    east = start[0] + share * (end[0] - start[0])
    north = start[1] + share * (end[1] - start[1])
    back = ~raster.transform
    column = back.a * east + back.b * north + back.c - 0.5
    row = back.d * east + back.e * north + back.f - 0.5
    if column.min() < -0.5 or row.min() < -0.5 or column.max() > raster.width - 0.5 or row.max() > raster.height - 0.5:
        left, bottom, right, top = raster.bounds
        raise InputError(
            f"{name}: the line leaves the raster",
            f"It covers easting {left:.0f} to {right:.0f}, northing {bottom:.0f} to {top:.0f}",
        )
    band = raster.read(1, masked=True).astype(float).filled(np.nan)
    i = np.clip(np.floor(row).astype(int), 0, max(raster.height - 2, 0))
    j = np.clip(np.floor(column).astype(int), 0, max(raster.width - 2, 0))
    di, dj = np.clip(row - i, 0.0, 1.0), np.clip(column - j, 0.0, 1.0)
    i1, j1 = np.minimum(i + 1, raster.height - 1), np.minimum(j + 1, raster.width - 1)
    elevation = (1 - di) * ((1 - dj) * band[i, j] + dj * band[i, j1]) + di * (
        (1 - dj) * band[i1, j] + dj * band[i1, j1]
    )
    if np.any(np.isnan(elevation)):
        raise InputError(
            f"{name}: no data at station {station[int(np.argmax(np.isnan(elevation)))]:g} m", "Choose another line"
        )
    return station, elevation
