"""Profiles from a raster of elevations."""

import builtins
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio

import ropeway as rw


def write(path: Path, heights: np.ndarray, crs: str = "EPSG:2056", cell: float = 2.0) -> Path:
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        height=heights.shape[0],
        width=heights.shape[1],
        count=1,
        dtype="float64",
        crs=crs,
        transform=rasterio.Affine(cell, 0.0, 1000.0, 0.0, -cell, 2000.0),
        nodata=-9999.0,
    ) as file:
        file.write(heights, 1)
    return path


def plane(rows: int = 60, columns: int = 80) -> np.ndarray:
    """Elevation 500 + 0.3 (east - 1000) - 0.2 (north - 1900) at the centres of cells of 2 m."""
    east = 1000.0 + 2.0 * (np.arange(columns) + 0.5)
    north = 2000.0 - 2.0 * (np.arange(rows) + 0.5)
    return 500.0 + 0.3 * (east[None, :] - 1000.0) - 0.2 * (north[:, None] - 1900.0)


def test_a_plane_is_read_exactly(tmp_path: Path) -> None:
    ground = rw.Profile.from_dem(write(tmp_path / "dem.tif", plane()), (1010.0, 1990.0), (1130.0, 1900.0), spacing=3.0)
    assert ground.station[-1] == pytest.approx(150.0)
    share = ground.station / 150.0
    expected = 500.0 + 0.3 * (10.0 + 120.0 * share) - 0.2 * (90.0 - 90.0 * share)
    np.testing.assert_allclose(ground.elevation, expected, rtol=1e-12)
    half = rw.Profile.from_dem(tmp_path / "dem.tif", (1010.0, 1990.0), (1130.0, 1900.0))
    assert np.diff(half.station).max() == pytest.approx(1.0)


def test_bad_lines_are_refused(tmp_path: Path) -> None:
    hole = plane()
    hole[20:30, 20:30] = -9999.0
    path = write(tmp_path / "dem.tif", hole)
    with pytest.raises(rw.InputError, match="leaves the raster"):
        rw.Profile.from_dem(path, (1010.0, 1990.0), (1300.0, 1900.0))
    with pytest.raises(rw.InputError, match="no data at station"):
        rw.Profile.from_dem(path, (1010.0, 1990.0), (1100.0, 1920.0))
    with pytest.raises(rw.InputError, match="one point"):
        rw.Profile.from_dem(path, (1010.0, 1990.0), (1010.0, 1990.0))
    with pytest.raises(rw.InputError, match="in degrees"):
        rw.Profile.from_dem(write(tmp_path / "wgs.tif", plane(), "EPSG:4326"), (1010.0, 1990.0), (1020.0, 1980.0))
    with pytest.raises(rw.InputError, match="'foot'"):
        rw.Profile.from_dem(write(tmp_path / "feet.tif", plane(), "EPSG:2992"), (1010.0, 1990.0), (1020.0, 1980.0))
    with pytest.raises(rw.InputError, match="no raster"):
        rw.Profile.from_dem(tmp_path / "none.tif", (1010.0, 1990.0), (1020.0, 1980.0))


def test_without_rasterio_the_remedy_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    load = builtins.__import__

    def missing(name: str, *args: Any, **kwargs: Any) -> Any:
        if name == "rasterio":
            raise ImportError(name)
        return load(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(rw.InputError, match=r"ropeway\[gis\]"):
        rw.Profile.from_dem(tmp_path / "dem.tif", (0.0, 0.0), (1.0, 1.0))
