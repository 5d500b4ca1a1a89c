"""Random rasters anywhere on the earth: elevations of a plane, and stations that are geodesics."""

from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import pytest
import rasterio

import ropeway as rw

SYSTEMS = {  # longitudes and latitudes of their places
    "EPSG:4326": ((-179.0, 179.0), (-75.0, 75.0)),
    "EPSG:3857": ((-179.0, 179.0), (-80.0, 80.0)),
    "EPSG:3395": ((-179.0, 179.0), (-79.0, 79.0)),
    "EPSG:32633": ((10.0, 20.0), (1.0, 80.0)),
    "EPSG:32719": ((-74.0, -64.0), (-70.0, -1.0)),
    "EPSG:3413": ((-179.0, 179.0), (52.0, 85.0)),
    "EPSG:3031": ((-179.0, 179.0), (-85.0, -62.0)),
    "EPSG:3035": ((-5.0, 30.0), (38.0, 68.0)),
    "EPSG:2056": ((6.0, 10.4), (45.9, 47.7)),
    "EPSG:31287": ((9.6, 17.0), (46.5, 49.0)),
    "EPSG:2263": ((-74.2, -71.9), (40.5, 41.3)),
}
UNITS = {"": 1.0, "m": 1.0, "ft": 0.3048, "US survey foot": 1200.0 / 3937.0, "cm": 0.01}


@pytest.mark.slow
def test_rasters(campaign: Any, tmp_path: Path) -> None:
    for seed in range(campaign.size(400)):
        rng = np.random.default_rng([campaign.seed, seed])
        code = str(rng.choice(list(SYSTEMS)))
        (west, east), (south, north) = SYSTEMS[code]
        longitude, latitude = rng.uniform(west, east), rng.uniform(south, north)
        system = pyproj.CRS(code)
        there = pyproj.Transformer.from_crs(system.geodetic_crs, system, always_xy=True)
        origin = there.transform(longitude, latitude)
        cell = float(rng.uniform(2.0, 30.0)) / (1e5 if system.is_geographic else 1.0)
        turn = float(rng.choice([0.0, rng.uniform(0.0, 360.0)]))
        shift, scale = rasterio.Affine.translation, rasterio.Affine.scale
        place = shift(*origin) @ rasterio.Affine.rotation(turn) @ scale(cell, cell * rng.choice([-1.0, 1.0]))
        place = place @ shift(-20.5, -15.5)
        unit = str(rng.choice(list(UNITS)))
        size, offset = float(rng.uniform(0.05, 2.0)), float(rng.uniform(-100.0, 100.0))
        base, across, down = rng.uniform(400.0, 3000.0), rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0)
        heights = base + across * (np.arange(41)[None, :] - 20.0) + down * (np.arange(31)[:, None] - 15.0)
        raw = (heights / UNITS[unit] - offset) / size
        path = tmp_path / "dem.tif"
        about = {"driver": "GTiff", "width": 41, "height": 31, "count": 1, "dtype": "float64", "transform": place}
        with rasterio.open(path, "w", crs=code, **about) as file:
            file.write(raw, 1)
            file.scales, file.offsets = (size,), (offset,)
            if unit:
                file.units = (unit,)
        column, row = rng.uniform(-20.0, 20.0), rng.uniform(-15.0, 15.0)
        end = (
            place.a * (column + 20.5) + place.b * (row + 15.5) + place.c,
            place.d * (column + 20.5) + place.e * (row + 15.5) + place.f,
        )
        asks = code == "EPSG:2263" and not unit
        if asks:
            with pytest.raises(rw.InputError, match="unit="):
                rw.Profile.from_dem(path, origin, end)
        ground = rw.Profile.from_dem(path, origin, end, unit="m" if asks else None)
        expected = base + np.array([0.0, across * column + down * row])
        note = f"seed {seed}: {code} at {longitude:.3f}, {latitude:.3f}"
        np.testing.assert_allclose(ground.elevation[[0, -1]], expected, rtol=1e-8, err_msg=note)
        degrees = there.transform(*end, direction="INVERSE")
        length = system.get_geod().inv(longitude, latitude, *degrees)[2]
        # PROJ's inverse of an equal-area projection is good to half a millimetre.
        np.testing.assert_allclose(ground.station[-1], length, rtol=1e-6, atol=1e-3, err_msg=note)
