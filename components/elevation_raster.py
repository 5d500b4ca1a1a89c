"""Elevations along a line over a raster."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropeway.components import check, units
from ropeway.components.errors import InputError
from ropeway.components.map_frame import MapFrame, name_of, thinned, transformed, utm_of
from ropeway.components.map_lengths import as_pyproj, ground_steps, horizontal, vertical_name, vertical_unit
from ropeway.components.plan_axis import PlanAxis

LOWEST, HIGHEST = -450.0, 9000.0
"""Plausible elevations of the ground [m]."""
_LARGE_JUMP, _STEEP = 50.0, 3.0
"""Neighbouring cells are implausible if they differ by more than this [m] and by more than this times their distance.
"""
_JUMP_TO_ZERO, _STEEP_TO_ZERO = 20.0, 2.5
"""The same if one of them is exactly zero, which often means missing data."""
_ASK_JUMP = "Give nodata= if one of them means missing data, or largest_jump= [m] if it is a cliff"


@dataclass(frozen=True)
class Reading:
    """How the user wants a raster to be read; None: as the raster declares.

    `spacing` of stations [m]; `band` (from 1); `unit` of the elevations; `nodata`, the value for missing data;
    `largest_jump` between neighbouring cells of real ground [m]; coordinate system `crs`.
    """

    spacing: float | None = None
    band: int | None = None
    unit: str | None = None
    nodata: float | None = None
    largest_jump: float | None = None
    crs: str | None = None

    def __post_init__(self) -> None:
        for name, unit in (("spacing", "m"), ("largest_jump", "m")):
            if getattr(self, name) is not None:
                check.positive(getattr(self, name), "from_dem", name, unit, infinite=name == "largest_jump")
        if self.band is not None and (isinstance(self.band, bool) or not isinstance(self.band, int)):
            raise InputError(f"from_dem: band is {self.band!r}", "Give the number of a band, from 1")
        if self.unit is not None and not _is_length(self.unit):
            raise InputError(f"from_dem: unit is {self.unit!r}", 'Give a unit of length: "m", "ft", "ftUS"')


def along(
    raster: Any, name: str, start: tuple[float, float], end: tuple[float, float], reading: Reading
) -> tuple[np.ndarray, np.ndarray, MapFrame]:
    """Stations and elevations over a raster, bilinear between the centres of its cells.

    Parameters
    ----------
    raster : rasterio.DatasetReader
    name : str
        Name of the raster, for error messages.
    start, end : tuple of float
        Easting and northing in the raster's coordinate system; longitude and latitude where that is geographic.
    reading : Reading

    Returns
    -------
    station, elevation : ndarray, shape (n,)
        Length on the ground from the start, and elevation [m].
    frame : MapFrame
        Map frame of the line; in UTM over a raster in degrees.

    Raises
    ------
    InputError
        The line leaves the raster or its data, or the meaning of the raster's numbers is unclear.
    """
    band = _band(raster, name, reading.band)
    factor = _metres(raster, name, band, reading.unit)
    _require_places(raster, name)
    if math.dist(start, end) == 0.0:
        raise InputError(f"{name}: start and end are one point", "Give two different points")
    count = _count(raster, name, start, end, reading)
    share = np.linspace(0.0, 1.0, count)
    east = start[0] + share * (end[0] - start[0])
    north = start[1] + share * (end[1] - start[1])
    crs = _system(raster, name, reading.crs)
    station = np.concatenate([[0.0], np.cumsum(ground_steps(name, crs, east, north))])
    row, column = _cells(raster, name, east, north)
    elevation = _elevations(raster, name, band, factor, station, row, column, reading)
    return station, elevation, _frame(name, crs, station, east, north)


def _system(raster: Any, name: str, given: str | None) -> Any:
    """The coordinate system of a raster, or the one given for a raster without any. Raises InputError."""
    if given is None:
        return raster.crs
    if raster.crs is not None and as_pyproj(name, raster.crs) != as_pyproj(name, given):
        raise InputError(f"{name} has a coordinate system of its own, not {given!r}", "Leave crs out")
    return as_pyproj(name, given)


def _frame(name: str, crs: Any, station: np.ndarray, east: np.ndarray, north: np.ndarray) -> MapFrame:
    """Where the line lies on the map."""
    some = thinned(station)
    station, east, north, system = station[some], east[some], north[some], ""
    if crs is not None:
        flat = horizontal(name, crs)
        system = name_of(flat)
        if flat.is_geographic:
            system = utm_of(float(east.mean()), float(north.mean()))
            east, north = (np.asarray(v) for v in transformed(flat, system, east, north))
    axis = PlanAxis(*(tuple(v.tolist()) for v in (station, east, north)))
    return MapFrame(system, axis, "" if crs is None else vertical_name(name, crs))


def _band(raster: Any, name: str, requested: int | None) -> int:
    """The band with the elevations: the requested one, or the only one besides masks. Raises InputError."""
    kinds = [kind.name for kind in raster.colorinterp]
    bands = [i for i, kind in enumerate(kinds, 1) if kind != "alpha"]
    if requested is not None:
        if not 1 <= requested <= raster.count:
            raise InputError(f"{name} has no band {requested}", f"It has {raster.count}")
        band = requested
    elif len(bands) == 1:
        band = bands[0]
    else:
        named = ", ".join(f"{i} ({raster.descriptions[i - 1] or kinds[i - 1]})" for i in bands)
        raise InputError(f"{name} has {len(bands)} bands: {named or 'none'}", "Give the one with elevations as band=")
    if kinds[band - 1] == "palette" or np.dtype(raster.dtypes[band - 1]).kind not in "iuf":
        raise InputError(f"Band {band} of {name} is a picture, or holds no real numbers", "Give a raster of elevations")
    return band


def _metres(raster: Any, name: str, band: int, requested: str | None) -> float:
    """The unit of the elevations in metres. Raises InputError if it is unclear."""
    if requested is not None:
        return units.factor(requested, "m")
    declared = {"its band": raster.units[band - 1] or "", "its coordinate system": vertical_unit(name, raster.crs)}
    for source, unit in declared.items():
        if unit and not _is_length(unit):
            raise InputError(f"Elevations of {name} are in {unit!r}, by {source}", 'Give unit=, such as "m" or "ft"')
    factors = {source: units.factor(unit, "m") for source, unit in declared.items() if unit}
    if len({round(f, 9) for f in factors.values()}) > 1:
        each = ", ".join(f"{declared[source]} by {source}" for source in factors)
        raise InputError(f"Elevations of {name} are in two units: {each}", "Give the right one as unit=")
    if factors:
        return next(iter(factors.values()))
    if raster.crs is not None:
        system = horizontal(name, raster.crs)
        axis = system.axis_info[0]
        if not system.is_geographic and axis.unit_conversion_factor != 1.0:
            raise InputError(
                f"{name} has coordinates in {axis.unit_name!r} and does not declare the unit of its elevations",
                'Give unit="m" or unit="ft"',
            )
    return 1.0


def _is_length(unit: str) -> bool:
    known, metre = units.parse(unit), units.parse("m")
    return known is not None and metre is not None and known.exponents == metre.exponents


def _require_places(raster: Any, name: str) -> None:
    """Raises InputError if a raster has no georeference."""
    if raster.crs is None and raster.transform.is_identity:
        raise InputError(f"{name} has no georeference", "Give a georeferenced raster")
    left, right, bottom, top = _extent(raster)
    if raster.crs is None and max(abs(left), abs(right)) <= 360.0 and max(abs(bottom), abs(top)) <= 90.0:
        size = math.hypot(raster.transform.a, raster.transform.d)
        if size < 0.05:
            raise InputError(
                f"{name} has no coordinate system, and cells of {size:g}",
                "Are these degrees? Add its coordinate system",
            )


def _count(raster: Any, name: str, start: tuple[float, float], end: tuple[float, float], reading: Reading) -> int:
    """Number of stations: `spacing` metres apart, or half a cell. Raises InputError."""
    if reading.spacing is None:
        cell = min(
            math.hypot(raster.transform.a, raster.transform.d), math.hypot(raster.transform.b, raster.transform.e)
        )
        count = 2.0 * math.dist(start, end) / cell
    else:
        ends = np.array([start, end], dtype=float).T
        count = float(ground_steps(name, _system(raster, name, reading.crs), *ends).sum()) / reading.spacing
    check.count(count, name, "stations")
    return max(2, math.ceil(count * (1.0 - 1e-9)) + 1)


def _cells(raster: Any, name: str, east: np.ndarray, north: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Row and column of points, integers at the centres of cells. Raises InputError outside the raster."""
    back = ~raster.transform
    column = back.a * east + back.b * north + back.c - 0.5
    row = back.d * east + back.e * north + back.f - 0.5
    if column.min() < -0.5 or row.min() < -0.5 or column.max() > raster.width - 0.5 or row.max() > raster.height - 0.5:
        left, right, bottom, top = _extent(raster)
        raise InputError(
            f"{name}: the line leaves the raster",
            f"It covers easting {left:.10g} to {right:.10g}, northing {bottom:.10g} to {top:.10g}",
        )
    return row, column


def _elevations(
    raster: Any,
    name: str,
    band: int,
    factor: float,
    station: np.ndarray,
    row: np.ndarray,
    column: np.ndarray,
    reading: Reading,
) -> np.ndarray:
    """Elevations [m] between the centres of cells. Raises InputError where data are missing."""
    i = np.clip(np.floor(row).astype(int), 0, max(raster.height - 2, 0))
    j = np.clip(np.floor(column).astype(int), 0, max(raster.width - 2, 0))
    di, dj = np.clip(row - i, 0.0, 1.0), np.clip(column - j, 0.0, 1.0)
    i1, j1 = np.minimum(i + 1, raster.height - 1), np.minimum(j + 1, raster.width - 1)
    window = ((int(i.min()), int(i1.max()) + 1), (int(j.min()), int(j1.max()) + 1))
    raw = raster.read(band, window=window, masked=True).astype(float).filled(np.nan)
    if reading.nodata is not None:
        raw[raw == reading.nodata] = np.nan
    # The four cell centres around each point: own, right, below, below right.
    corners = [raw[a - window[0][0], b - window[1][0]] for a, b in ((i, j), (i, j1), (i1, j), (i1, j1))]
    heights = factor * (raster.scales[band - 1] * np.array(corners) + raster.offsets[band - 1])
    if np.any(~np.isfinite(heights)):
        k = int(np.argmax(np.any(~np.isfinite(heights), axis=0)))
        raise InputError(f"{name}: no data at station {station[k]:g} m", "Choose another line")
    _require_plausible(raster, name, station, heights, np.array(corners), reading.largest_jump)
    weights = np.array([(1 - di) * (1 - dj), (1 - di) * dj, di * (1 - dj), di * dj])
    return np.asarray((weights * heights).sum(axis=0), dtype=float)


def _require_plausible(
    raster: Any,
    name: str,
    station: np.ndarray,
    heights: np.ndarray,
    raw: np.ndarray,
    largest_jump: float | None,
) -> None:
    """Raises InputError for implausible elevations, such as undeclared values for missing data.

    `heights`, `raw`: at the four cell centres around each station, in metres and as in the raster.
    """
    wrong = (heights < LOWEST) | (heights > HIGHEST)
    if np.any(wrong):
        corner, k = (int(v[0]) for v in np.nonzero(wrong))
        raise InputError(
            f"{name}: elevation {heights[corner, k]:.6g} m at station {station[k]:g} m (value {raw[corner, k]:.7g})",
            f"Give nodata={raw[corner, k]:.7g} if that means missing data, or unit= if its numbers are not metres",
        )
    cell = _cell_on_ground(raster, name)
    for one, other in ((0, 1), (0, 2), (1, 3), (2, 3)):
        jump = np.abs(heights[one] - heights[other])
        if largest_jump is not None:
            large = jump > largest_jump
        else:
            zero = (raw[one] == 0.0) | (raw[other] == 0.0)
            large = (jump > _LARGE_JUMP) & (jump > _STEEP * cell)
            large |= zero & (jump > _JUMP_TO_ZERO) & (jump > _STEEP_TO_ZERO * cell)
        if np.any(large):
            k = int(np.argmax(large))
            raise InputError(
                f"{name}: neighbouring cells of {heights[one, k]:g} m and {heights[other, k]:g} m at station "
                f"{station[k]:g} m (values {raw[one, k]:.7g} and {raw[other, k]:.7g})",
                _ASK_JUMP,
            )


def _cell_on_ground(raster: Any, name: str) -> float:
    """The longer side of a cell in the middle of the raster [m]."""
    column, row = raster.width / 2.0, raster.height / 2.0
    sides = []
    for right, down in ((1.0, 0.0), (0.0, 1.0)):
        ends = [_point(raster, column, row), _point(raster, column + right, row + down)]
        sides.append(float(ground_steps(name, raster.crs, *np.array(ends).T).sum()))
    return max(sides)


def _extent(raster: Any) -> tuple[float, float, float, float]:
    """Smallest and largest easting, smallest and largest northing, also of a rotated raster."""
    corners = [_point(raster, c, r) for c in (0.0, raster.width) for r in (0.0, raster.height)]
    east, north = zip(*corners, strict=True)
    return min(east), max(east), min(north), max(north)


def _point(raster: Any, column: float, row: float) -> tuple[float, float]:
    """Easting and northing of a point in the raster."""
    t = raster.transform
    return t.a * column + t.b * row + t.c, t.d * column + t.e * row + t.f
