"""Profiles keep where they lie: map coordinates of stations to 1 mm, azimuths, GPX files, bad coordinate systems."""

from pathlib import Path

import numpy as np
import pandas as pd
import pyproj
import pytest
import rasterio
from hypothesis import given, settings, strategies as st

import ropeway as rw
from ropeway.components.plan_axis import PlanAxis

START, END = (2600100.0, 1200200.0), (2600400.0, 1200600.0)
"""A line of 500 m with azimuth atan(3/4)."""


def raster(path: Path, crs: str | None, corner: tuple[float, float], cell: float, size: int = 120) -> Path:
    """A plane that rises by 0.2 m a cell to the east, of `size` cells from its upper left corner on."""
    heights = 700.0 + 0.2 * np.broadcast_to(np.arange(size), (size, size)).astype("float64")
    place = rasterio.Affine(cell, 0.0, corner[0], 0.0, -cell, corner[1])
    shape = {"driver": "GTiff", "width": size, "height": size, "count": 1, "dtype": "float64"}
    with rasterio.open(path, "w", crs=crs, transform=place, **shape) as file:
        file.write(heights, 1)
    return path


def test_a_profile_from_a_raster_knows_its_map(tmp_path: Path) -> None:
    dem = raster(tmp_path / "dem.tif", "EPSG:2056", (2600000.0, 1200700.0), 5.0)
    ground = rw.Profile.from_dem(dem, START, END)
    assert (ground.crs, ground.azimuth) == ("EPSG:2056", pytest.approx(np.degrees(np.arctan2(3.0, 4.0))))
    share = ground.station / ground.station[-1]
    expected = np.array(START) + share[:, None] * np.subtract(END, START)
    np.testing.assert_allclose(ground.coordinates[:, :2], expected, atol=1e-4)
    np.testing.assert_allclose(ground.coordinates[:, 2], ground.elevation)
    assert ground.resampled(20.0).map_frame is ground.map_frame


@pytest.mark.parametrize(
    ("crs", "longitude", "latitude"),
    [
        ("EPSG:3857", 11.3, 60.0),
        ("EPSG:3395", 11.3, 60.0),
        ("EPSG:32633", 18.2, 47.6),
        ("EPSG:2992", -120.5, 44.1),
        ("EPSG:2056", 7.8, 46.5),
    ],
)
def test_stations_are_on_the_map_where_the_ground_is(crs: str, longitude: float, latitude: float) -> None:
    """A station on the ground, by the geodesic from the start, has the map coordinates of that point to 1 mm, also
    where the scale of the map changes along the line and its unit is the foot."""
    system = pyproj.CRS(crs)
    way = pyproj.Transformer.from_crs(system.geodetic_crs, system, always_xy=True)
    start, end = way.transform(longitude, latitude), way.transform(longitude + 0.004, latitude + 0.011)
    frame = rw.MapFrame.straight(crs, start, end)
    east, north = frame.to_map(np.linspace(0.0, frame.axis.station[-1], 40))
    back = way.transform(east, north, direction="INVERSE")
    lengths = system.get_geod().inv(np.full(40, longitude), np.full(40, latitude), *back)[2]
    np.testing.assert_allclose(lengths, np.linspace(0.0, frame.axis.station[-1], 40), atol=1e-3)
    if crs == "EPSG:3857":  # on an ellipsoid it has not one scale in all directions
        return
    aside = way.transform(*frame.to_map(500.0, 40.0), direction="INVERSE")
    there = way.transform(*frame.to_map(500.0), direction="INVERSE")
    assert system.get_geod().inv(*there, *aside)[2] == pytest.approx(40.0, abs=1e-3)


@settings(max_examples=60, deadline=None)
@given(x=st.floats(-200.0, 700.0), y=st.floats(-300.0, 300.0), scale=st.floats(0.3, 3.3), turn=st.floats(0.0, 6.28))
def test_places_on_a_straight_axis_are_found_again(x: float, y: float, scale: float, turn: float) -> None:
    ends = [(2.6e6, 1.2e6), (2.6e6 + 500.0 * scale * np.cos(turn), 1.2e6 + 500.0 * scale * np.sin(turn))]
    axis = PlanAxis((0.0, 500.0), *(tuple(float(end[i]) for end in ends) for i in (0, 1)))
    there = axis.place(x, y)
    assert np.hypot(*np.subtract(there, ends[0])) == pytest.approx(scale * np.hypot(x, y), abs=1e-6)
    np.testing.assert_allclose(axis.locate(*there), (x, y), atol=1e-6)


def test_left_is_where_y_grows() -> None:
    """The line runs east: its left is north."""
    frame = rw.MapFrame("EPSG:2056", PlanAxis((0.0, 100.0), (2.6e6, 2.6001e6), (1.2e6, 1.2e6)))
    np.testing.assert_allclose(frame.to_map(30.0, 4.0), (2600030.0, 1200004.0))
    assert frame.azimuth == pytest.approx(90.0)


def test_points_keep_their_coordinates(tmp_path: Path) -> None:
    at = np.array([[0.0, 0.0, 800.0], [60.0, 80.1, 790.0], [120.0, 160.0, 770.0], [180.0, 240.0, 775.0]])
    at[:, :2] += START
    ground = rw.Profile.from_points(at, "EPSG:2056")
    np.testing.assert_allclose(ground.coordinates, at, atol=1e-6)
    file = tmp_path / "points.csv"
    file.write_text("easting;northing;elevation\n" + "\n".join(";".join(map(str, row)) for row in at))
    np.testing.assert_allclose(rw.Profile.from_points(file, "EPSG:2056").coordinates, at, atol=1e-6)
    straight = rw.Profile.from_points(at, "EPSG:2056", straight=True)
    geod = pyproj.CRS("EPSG:2056").get_geod()
    way = pyproj.Transformer.from_crs("EPSG:2056", "EPSG:4150", always_xy=True)
    (lon0, lat0), (lon1, lat1) = (way.transform(*at[k, :2]) for k in (0, -1))
    assert straight.station[-1] == pytest.approx(geod.inv(lon0, lat0, lon1, lat1)[2], abs=1e-4)
    assert straight.station[1] == pytest.approx(100.08 * straight.station[-1] / 300.0, abs=1e-3)


GPX = """<?xml version="1.0"?><gpx version="1.1" creator="x" xmlns="http://www.topografix.com/GPX/1/1">
<wpt lat="47.1" lon="11.1"><name>car</name></wpt><trk><trkseg>{}</trkseg></trk></gpx>"""


def test_a_track_of_a_receiver(tmp_path: Path) -> None:
    """Its stations are geodesics, its points those of the file; a point that repeats counts once."""
    points = [
        (11.2501, 47.2003, 1204.0),
        (11.2505, 47.2010, 1190.0),
        (11.2505, 47.2010, 1191.0),
        (11.2509, 47.2017, 1188.0),
    ]
    file = tmp_path / "track.gpx"
    file.write_text(GPX.format("".join(f'<trkpt lon="{x}" lat="{y}"><ele>{z}</ele></trkpt>' for x, y, z in points)))
    ground = rw.Profile.from_points(file)
    assert ground.crs == "EPSG:32632"
    kept = np.array([points[k] for k in (0, 1, 3)])
    lengths = pyproj.Geod(ellps="WGS84").inv(*kept[:-1, :2].T, *kept[1:, :2].T)[2]
    np.testing.assert_allclose(np.diff(ground.station), lengths, atol=1e-6)
    degrees = ground.map_frame.to_degrees(ground.station)
    np.testing.assert_allclose(np.transpose(degrees), kept[:, :2], atol=1e-9)
    assert rw.Profile.from_points(file, "EPSG:31254").crs == "EPSG:31254"
    file.write_text(GPX.format('<trkpt lon="11" lat="47"/><trkpt lon="11.1" lat="47"><ele>3</ele></trkpt>'))
    with pytest.raises(rw.InputError, match="point 1 has longitude"):
        rw.Profile.from_points(file)
    file.write_text(GPX.format(""))
    with pytest.raises(rw.InputError, match="no track, route"):
        rw.Profile.from_points(file)


def test_rasters_in_degrees_have_a_frame_in_utm(tmp_path: Path) -> None:
    dem = raster(tmp_path / "dem.tif", "EPSG:4326", (16.40, 48.12), 1.0 / 7200.0)
    ground = rw.Profile.from_dem(dem, (16.402, 48.118), (16.410, 48.110))
    assert ground.crs == "EPSG:32633"
    degrees = np.transpose(ground.map_frame.to_degrees(ground.station[[0, -1]]))
    np.testing.assert_allclose(degrees, [(16.402, 48.118), (16.410, 48.110)], atol=1e-9)


def test_a_compound_system_gives_the_datum_of_heights(tmp_path: Path) -> None:
    dem = raster(tmp_path / "dem.tif", "EPSG:2056+5728", (2600000.0, 1200700.0), 5.0)
    frame = rw.Profile.from_dem(dem, START, END).map_frame
    assert (frame.crs, frame.heights) == ("EPSG:2056", "LN02 height")


def test_rasters_that_do_not_say_their_system(tmp_path: Path) -> None:
    dem = raster(tmp_path / "dem.tif", None, (2600000.0, 1200700.0), 5.0)
    ground = rw.Profile.from_dem(dem, START, END)
    assert ground.crs == ""
    with pytest.raises(rw.InputError, match="system of the map is unknown"):
        ground.map_frame.to_degrees(0.0)
    assert rw.Profile.from_dem(dem, START, END, crs="EPSG:2056").crs == "EPSG:2056"
    told = raster(tmp_path / "told.tif", "EPSG:2056", (2600000.0, 1200700.0), 5.0)
    with pytest.raises(rw.InputError, match="of its own"):
        rw.Profile.from_dem(told, START, END, crs="EPSG:21781")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: rw.MapFrame.straight("EPSG:4326", (7.0, 46.0), (7.1, 46.0)), "geographic"),
        (lambda: rw.Profile.from_points([[7.0, 46.0, 800.0], [7.1, 46.0, 810.0]], "EPSG:4326"), "geographic"),
        (lambda: rw.MapFrame.straight("EPSG:99999", START, END), "cannot be read"),
        (lambda: rw.MapFrame.straight("EPSG:2053", (-90e3, 33e5), (-89e3, 33e5)), "point west and south"),
        (lambda: rw.MapFrame.straight("EPSG:5513", (1.04e6, 7.4e5), (1.05e6, 7.4e5)), "point south and west"),
        (lambda: rw.MapFrame.straight("EPSG:2056", START, START), "one point"),
        (lambda: rw.Profile.from_points([[0.0, 0.0, 1.0]], "EPSG:2056"), "at least two"),
        (lambda: rw.Profile.from_points([[0.0, 0.0], [9.0, 1.0]], "EPSG:2056"), "easting, northing and elevation"),
        (
            lambda: rw.Profile.from_points([[*START, 0.0], [*END, 1.0], [*START, 0.0]], "EPSG:2056", straight=True),
            "one",
        ),
        (lambda: rw.Profile([0.0, 9.0], [1.0, 2.0]).azimuth, "no map coordinates"),
        (lambda: PlanAxis((0.0, 9.0), (1.0, 1.0), (2.0, 2.0)), "does not go on"),
    ],
)
def test_bad_maps_are_refused(call, words: str) -> None:
    with pytest.raises(rw.InputError, match=words):
        call()


@pytest.mark.parametrize("unit", ["", " [ft]", " [ftUS]", " [m]", " [yd]"])
def test_columns_are_in_the_unit_of_their_map(unit: str) -> None:
    """California's zones are in feet of the US survey: those of a header are the same."""
    size = {"": 1.0, " [ft]": 1.0, " [ftUS]": 1.0, " [m]": 3937.0 / 1200.0, " [yd]": 3.0 * 0.3048 * 3937.0 / 1200.0}[
        unit
    ]
    east, north = np.array([6.0e6, 6.0003e6]), np.array([2.1e6, 2.1004e6])
    table = pd.DataFrame({f"easting{unit}": east / size, f"northing{unit}": north / size, "elevation [ft]": [0.0, 9.0]})
    ground = rw.Profile.from_points(table, "EPSG:2227")
    assert ground.coordinates[:, :2] == pytest.approx(np.column_stack([east, north]), abs=1e-6)
    assert ground.elevation == pytest.approx([0.0, 2.7432])
    named = table.assign(name=["a", "b"], kind="drum").rename(columns={"elevation [ft]": "z [ft]"})
    line = rw.monocable(rw.Rope.named("RHOL-IWRC 29"), named, tension=45e3, speed=0.0, crs="EPSG:2227")
    assert line.map_frame.to_map(ground.station[-1]) == pytest.approx((6.0003e6, 2.1004e6), abs=1e-6)
    with pytest.raises(rw.InputError, match=r"column elevation: its map is in US survey foot.*elevation \[ft\]"):
        rw.Profile.from_points(table.rename(columns={"elevation [ft]": "elevation"}), "EPSG:2227")


def test_points_far_outside_their_system_have_no_place() -> None:
    old = rw.Profile.from_points([[6e5, 2e5, 800.0], [6.003e5, 2.004e5, 700.0]], "EPSG:2056")  # those of EPSG:21781
    assert old.station[-1] == pytest.approx(500.0)
    with pytest.raises(rw.InputError, match="far outside the area of EPSG:2056"):
        old.map_frame.to_degrees(0.0)


def test_crooked_points_are_warned_of() -> None:
    at = [[2.6e6, 1.2e6, 800.0], [2.6e6 + 100.0, 1.2e6 + 30.0, 790.0], [2.6e6 + 200.0, 1.2e6, 780.0]]
    with pytest.warns(rw.RopewayWarning, match="one plane"):
        rw.Profile.from_points(at, "EPSG:2056")
    assert rw.Profile.from_points(at, "EPSG:2056", straight=True).station[1] == pytest.approx(100.0, abs=0.02)
