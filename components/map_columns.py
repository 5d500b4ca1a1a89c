"""Columns of tables in map coordinates: in the unit of the map, whatever unit their header has."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components import table, units
from ropeway.components.map_frame import require_projected
from ropeway.components.map_lengths import horizontal

_SAME = 1e-4
"""Relative difference of international feet, feet of the US survey and others."""


def in_map_unit(read: table.Table, crs: str, keys: Sequence[str], height: str, values: np.ndarray) -> np.ndarray:
    """Eastings and northings in the unit of a map.

    Parameters
    ----------
    read : Table
        The table.
    crs : str
        Coordinate system of the map; "" for metres.
    keys : sequence of str
        The columns of eastings and northings.
    height : str
        The column of heights.
    values : ndarray, shape (rows, columns)
        Numbers of `keys` as the table gives them: in metres where the header has a unit, else in that of the map.

    Returns
    -------
    ndarray, shape (rows, columns)

    Raises
    ------
    InputError
        The map is in degrees; or it is not in metres, and the heights have no unit.
    """
    if not crs:
        return values
    require_projected(crs)
    axis = horizontal(f"Coordinate system {crs!r}", crs).axis_info[0]
    symbols = [read.units[read.keys.index(key)] for key in (*keys, height)]
    if axis.unit_conversion_factor != 1.0 and not symbols[-1]:
        raise read.error(
            f"its map is in {axis.unit_name}, and the column has no unit",
            f"Name it {height} [ft] or {height} [m]",
            table.HEADER,
            height,
        )
    return values / [_size(symbol, axis.unit_conversion_factor) for symbol in symbols[:-1]]


def _size(symbol: str, of_map: float) -> float:
    """Length of the unit of a map [m]; 1 for a column without a unit. The feet of a header are those of its map."""
    own = units.to_si(symbol)[1]
    return 1.0 if not symbol else own if abs(own / of_map - 1.0) < _SAME else of_map
