"""Profiles from a raster of elevations."""

import builtins
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyproj
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
    with pytest.raises(rw.InputError, match="not a raster"):
        rw.Profile.from_dem(tmp_path / "none.tif", (1010.0, 1990.0), (1020.0, 1980.0))


ANYWHERE = ((2601000.0, 1199000.0), "EPSG:2056")


def tilted(
    path: Path, crs: str | None, origin: tuple[float, float], cell: float, *, turned: float = 0.0, **told: Any
) -> Path:
    """A raster of 60 by 50 cells around an origin: 700 + 3 for each cell to the east, - 2 for each to the north."""
    heights = 700.0 + 3.0 * (np.arange(60)[None, :] - 30.0) + 2.0 * (np.arange(50)[:, None] - 25.0)
    place = rasterio.Affine.translation(*origin) @ rasterio.Affine.rotation(turned) @ rasterio.Affine.scale(cell, -cell)
    place = place @ rasterio.Affine.translation(-30.5, -25.5)
    own = {key: told.pop(key) for key in ("scales", "offsets", "units", "descriptions") if key in told}
    values = np.asarray(told.pop("values", heights))
    bands = values if values.ndim == 3 else values[None]
    profile = {
        "driver": "GTiff",
        "width": 60,
        "height": 50,
        "count": len(bands),
        "dtype": bands.dtype,
        "transform": place,
    }
    with rasterio.open(path, "w", crs=crs, **profile, **told) as file:
        file.write(bands)
        for key, value in own.items():
            setattr(file, key, value)
    return path


def read(path: Path, origin: tuple[float, float], cell: float, **more: Any) -> rw.Profile:
    """Along 20 cells to the east and 10 to the north."""
    return rw.Profile.from_dem(path, origin, (origin[0] + 20.0 * cell, origin[1] + 10.0 * cell), **more)


@pytest.mark.parametrize(
    ("crs", "longitude", "latitude", "cell"),
    [
        ("EPSG:3857", 11.3, 47.2, 12.0),
        ("EPSG:3395", -122.4, 45.1, 9.0),
        ("EPSG:3413", -40.0, 62.0, 25.0),
        ("EPSG:32633", 15.0, 47.6, 10.0),
        ("EPSG:32611", -112.5, 49.0, 30.0),
        ("EPSG:2056", 7.8, 46.5, 2.0),
        ("EPSG:4326", 16.4, 48.1, 1.0 / 3600.0),
        ("EPSG:2992", -120.5, 44.1, 33.0),
        ("EPSG:3035", 25.0, 61.0, 25.0),
    ],
)
def test_stations_are_lengths_on_the_ground(
    tmp_path: Path, crs: str, longitude: float, latitude: float, cell: float
) -> None:
    system = pyproj.CRS(crs)
    there = pyproj.Transformer.from_crs(system.geodetic_crs, system, always_xy=True)
    origin = there.transform(longitude, latitude)
    end = there.transform(origin[0] + 20.0 * cell, origin[1] + 10.0 * cell, direction="INVERSE")
    ground = read(tilted(tmp_path / "dem.tif", crs, origin, cell), origin, cell, unit="m", spacing=5.0)
    expected = system.get_geod().inv(longitude, latitude, *end)[2]
    assert ground.station[-1] == pytest.approx(expected, rel=1e-7)
    assert np.diff(ground.station).max() == pytest.approx(5.0, abs=0.2)
    np.testing.assert_allclose(ground.elevation[[0, -1]], [700.0, 740.0], rtol=1e-7)
    np.testing.assert_allclose(np.diff(ground.elevation) / np.diff(ground.station), 40.0 / expected, rtol=1e-3)


def test_web_mercator_against_its_closed_form(tmp_path: Path) -> None:
    """On its sphere's parallel the map is 1 / cos(latitude) too long, on the ellipsoid's it is N cos / a."""
    north, a, e2 = 6_200_000.0, 6378137.0, 0.00669437999014
    latitude = 2.0 * np.arctan(np.exp(north / a)) - np.pi / 2.0
    path = tilted(tmp_path / "dem.tif", "EPSG:3857", (900_000.0, north), 10.0)
    ground = rw.Profile.from_dem(path, (900_000.0, north), (900_200.0, north))
    scale = np.cos(latitude) / np.sqrt(1.0 - e2 * np.sin(latitude) ** 2)
    assert ground.station[-1] == pytest.approx(200.0 * scale, rel=1e-7)


def test_coordinates_far_outside_the_area_of_use_are_local(tmp_path: Path) -> None:
    ground = read(tilted(tmp_path / "dem.tif", "EPSG:2056", (500.0, 700.0), 2.0), (500.0, 700.0), 2.0)
    assert ground.station[-1] == pytest.approx(np.hypot(40.0, 20.0), rel=1e-12)


@pytest.mark.parametrize("turned", [25.0, 130.0, -90.0, 180.0])
def test_rotated_rasters(tmp_path: Path, turned: float) -> None:
    origin, crs = ANYWHERE
    path = tilted(tmp_path / "dem.tif", crs, origin, 5.0, turned=turned)
    along = np.deg2rad(turned)
    end = (origin[0] + 60.0 * np.cos(along), origin[1] + 60.0 * np.sin(along))
    ground = rw.Profile.from_dem(path, origin, end)
    np.testing.assert_allclose(ground.elevation, 700.0 + 3.0 * ground.station / 5.0, rtol=1e-9)
    with pytest.raises(rw.InputError, match="leaves the raster"):
        rw.Profile.from_dem(path, origin, (origin[0] + 600.0, origin[1]))


@pytest.mark.parametrize(
    ("told", "crs", "factor", "offset"),
    [
        ({"scales": (0.25,)}, "EPSG:2056", 0.25, 0.0),
        ({"scales": (0.5,), "offsets": (120.0,)}, "EPSG:2056", 0.5, 120.0),
        ({"units": ("foot",)}, "EPSG:2056", 0.3048, 0.0),
        ({"units": ("US survey foot",)}, "EPSG:2056", 1200.0 / 3937.0, 0.0),
        ({"units": ("Metre",)}, "EPSG:2056", 1.0, 0.0),
        ({"units": ("dm",), "offsets": (40.0,)}, "EPSG:2056", 0.1, 4.0),
        ({}, "EPSG:2056+8228", 0.3048, 0.0),
        ({}, "EPSG:2056+5728", 1.0, 0.0),
    ],
)
def test_declared_scale_offset_and_unit(
    tmp_path: Path, told: dict[str, Any], crs: str, factor: float, offset: float
) -> None:
    origin = ANYWHERE[0]
    ground = read(tilted(tmp_path / "dem.tif", crs, origin, 10.0, **told), origin, 10.0)
    np.testing.assert_allclose(ground.elevation[[0, -1]], offset + factor * np.array([700.0, 740.0]), rtol=1e-9)


def holes(value: float, dtype: str = "float32", base: float = 700.0) -> np.ndarray:
    heights = np.full((50, 60), base) + np.arange(60)[None, :]
    heights[15:22, 38:45] = value
    return heights.astype(dtype)


@pytest.mark.parametrize(
    ("values", "told"),
    [
        (holes(-9999.0), {}),
        (holes(-32768, "int16"), {}),
        (holes(-3.4028235e38), {}),
        (holes(0.0), {}),
        (holes(0.0, base=90.0), {}),
        (holes(65535, "uint16"), {}),
        (holes(65535, "uint16", 7000.0), {"scales": (0.1,)}),
        (holes(np.nan), {}),
        (holes(-9999.0), {"units": ("ft",)}),
        (np.full((50, 60), -9999.0), {}),
    ],
)
def test_undeclared_missing_data_are_errors(tmp_path: Path, values: np.ndarray, told: dict[str, Any]) -> None:
    origin, crs = ANYWHERE
    path = tilted(tmp_path / "dem.tif", crs, origin, 8.0, values=values, **told)
    with pytest.raises(rw.InputError, match=r"elevation|neighbouring cells|no data") as error:
        read(path, origin, 8.0)
    assert "station" in error.value.cause
    if not np.isnan(values).any() and values.min() >= -1e38:
        assert "nodata=" in error.value.remedy
        with pytest.raises(rw.InputError, match="no data at station"):
            read(path, origin, 8.0, nodata=float(values[18, 40]))


def test_largest_jump_accepts_a_cliff(tmp_path: Path) -> None:
    origin, crs = ANYWHERE
    path = tilted(tmp_path / "dem.tif", crs, origin, 5.0, values=holes(900.0))
    with pytest.raises(rw.InputError, match=r"neighbouring cells of 7\d\d m and 900 m"):
        read(path, origin, 5.0)
    assert read(path, origin, 5.0, largest_jump=250.0).elevation.max() == pytest.approx(900.0)


def test_steep_ground_is_accepted(tmp_path: Path) -> None:
    """A face of 65 degrees in cells of 25 m, and the sea at its foot."""
    origin, crs = ANYWHERE
    heights = np.clip((np.arange(60)[None, :] - 35.0) * 53.0, 0.0, None) * np.ones((50, 1))
    ground = read(tilted(tmp_path / "dem.tif", crs, origin, 25.0, values=heights), origin, 25.0)
    assert ground.elevation.max() == pytest.approx(53.0 * 15.0, rel=1e-9)


def test_several_bands(tmp_path: Path) -> None:
    origin, crs = ANYWHERE
    two = np.stack([holes(740.0), 2.0 * holes(740.0)])
    path = tilted(tmp_path / "two.tif", crs, origin, 5.0, values=two, descriptions=("ground", "canopy"))
    with pytest.raises(rw.InputError, match=r"2 bands: 1 \(ground\), 2 \(canopy\)\. .*band="):
        read(path, origin, 5.0)
    assert read(path, origin, 5.0, band=2).elevation[0] == pytest.approx(1460.0)
    with pytest.raises(rw.InputError, match="no band 3"):
        read(path, origin, 5.0, band=3)
    masked = tilted(tmp_path / "masked.tif", crs, origin, 5.0, values=np.stack([holes(740.0), np.full((50, 60), 255)]))
    with rasterio.open(masked, "r+") as file:
        file.colorinterp = (rasterio.enums.ColorInterp.gray, rasterio.enums.ColorInterp.alpha)
    assert read(masked, origin, 5.0).elevation[0] == pytest.approx(730.0)


def test_unclear_units_are_errors(tmp_path: Path) -> None:
    origin, crs = ANYWHERE
    feet = tilted(tmp_path / "feet.tif", "EPSG:2992", (4e6, 1e6), 30.0)
    with pytest.raises(rw.InputError, match=r"'foot'.*unit="):
        read(feet, (4e6, 1e6), 30.0)
    assert read(feet, (4e6, 1e6), 30.0, unit="ft").elevation[0] == pytest.approx(700.0 * 0.3048)
    with pytest.raises(rw.InputError, match=r"in 'cubits', by its band\. .*unit="):
        read(tilted(tmp_path / "cubits.tif", crs, origin, 5.0, units=("cubits",)), origin, 5.0)
    both = tilted(tmp_path / "both.tif", "EPSG:2056+8228", origin, 5.0, units=("m",))
    with pytest.raises(rw.InputError, match=r"two units.*unit="):
        read(both, origin, 5.0)
    with pytest.raises(rw.InputError, match="degrees"):
        read(tilted(tmp_path / "degrees.tif", None, (16.0, 48.0), 1e-4), (16.0, 48.0), 1e-4)
    with pytest.raises(rw.InputError, match="depths"):
        read(tilted(tmp_path / "depths.tif", "EPSG:2056+5715", origin, 5.0), origin, 5.0)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"band": True}, "band is True"),
        ({"unit": "kg"}, "unit is 'kg'"),
        ({"spacing": 0.0}, "spacing"),
        ({"spacing": 1e-9}, "stations"),
        ({"largest_jump": -1.0}, "largest_jump"),
    ],
)
def test_bad_readings(tmp_path: Path, more: dict[str, Any], words: str) -> None:
    origin, crs = ANYWHERE
    with pytest.raises(rw.InputError, match=words):
        read(tilted(tmp_path / "dem.tif", crs, origin, 5.0), origin, 5.0, **more)


def test_without_pyproj_the_remedy_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    origin, crs = ANYWHERE
    path = tilted(tmp_path / "dem.tif", crs, origin, 5.0)
    monkeypatch.setitem(sys.modules, "pyproj", None)
    with pytest.raises(rw.InputError, match=r"ropeway\[gis\]"):
        read(path, origin, 5.0)


def test_without_rasterio_the_remedy_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    load = builtins.__import__

    def missing(name: str, *args: Any, **kwargs: Any) -> Any:
        if name == "rasterio":
            raise ImportError(name)
        return load(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(rw.InputError, match=r"ropeway\[gis\]"):
        rw.Profile.from_dem(tmp_path / "dem.tif", (0.0, 0.0), (1.0, 1.0))
