"""Exports to GIS and CAD, read again by GDAL, ezdxf, fastkml and gpxpy: coordinates to 1 mm, attributes equal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import ezdxf
import fastkml.validator
import gpxpy
import numpy as np
import pandas as pd
import pyogrio
import pyproj
import pytest

import ropeway as rw
from support import maps

MILLIMETRE = 1e-3


def on_map(points: np.ndarray) -> np.ndarray:
    """Points of a line (n, 3) on the map, by its direction 3 : 4 east to north; LV95 has a scale of 1 there."""
    x, y, z = np.asarray(points, dtype=float).T
    return np.column_stack([maps.START[0] + 0.6 * x - 0.8 * y, maps.START[1] + 0.8 * x + 0.6 * y, z])


def stood(table: pd.DataFrame) -> np.ndarray:
    return on_map(table[["station", "offset", "elevation"]].to_numpy())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The rig with its load path, and the line, in all formats."""
    found = tmp_path_factory.mktemp("gis")
    line = rw.equilibrium(maps.line())
    for ending in ("gpkg", "geojson", "kml", "gpx", "dxf"):
        assert rw.export_gis(maps.rig(), found / f"rig.{ending}", stations=maps.path()) == found / f"rig.{ending}"
        rw.export_gis(line, found / f"line.{ending}")
    for view in ("plan", "profile"):
        rw.export_gis(maps.rig(), found / f"{view}.dxf", stations=maps.path(), view=view)
    return found


def coordinates(shape: Any) -> np.ndarray:
    return np.array(shape.coords)


def require_values(row: Any, expected: pd.Series, columns: list[str]) -> None:
    for column in columns:
        value = expected[column]
        assert row[column] == value if isinstance(value, str) else float(row[column]) == pytest.approx(value, rel=1e-12)


def test_a_geopackage_holds_the_rig(folder: Path) -> None:
    file = folder / "rig.gpkg"
    layers = dict(pyogrio.list_layers(file))
    assert layers == {
        **dict.fromkeys(("rope", "guylines", "carriage_path", "ground"), "LineString Z"),
        **dict.fromkeys(("supports", "anchors", "carriage", "clearance"), "Point Z"),
    }
    assert pyproj.CRS(pyogrio.read_info(file, layer="rope")["crs"]).to_epsg() == 2056
    table, path = rw.places(maps.rig()), maps.path()
    supports = pyogrio.read_dataframe(file, layer="supports").set_index("name")
    anchors = pyogrio.read_dataframe(file, layer="anchors").set_index("name")
    assert (set(supports.index), set(anchors.index)) == ({"head", "jack", "tail"}, {"stump", "g1", "g2"})
    for name, row in pd.concat([supports, anchors]).iterrows():
        np.testing.assert_allclose(coordinates(row.geometry)[0], stood(table.loc[[name]])[0], atol=MILLIMETRE)
        require_values(row, table.loc[name], ["label", "kind", "station", "ground", "height"])
    jack = supports.loc["jack"]
    assert (jack["label"], jack["highest_force"]) == ("Stütze 1", path["jack_force"].max())
    assert anchors.loc["stump", "highest_tension"] == path["anchor_tension"].max()
    assert anchors.loc["g2", "least_tension"] == path["g2_tension"].min()
    carriage = pyogrio.read_dataframe(file, layer="carriage")
    expected = on_map(path[["carriage_x", "carriage_y", "carriage_z"]].to_numpy())
    np.testing.assert_allclose([coordinates(p)[0] for p in carriage.geometry], expected, atol=MILLIMETRE)
    for column in path.columns:
        assert carriage[column].tolist() == path[column].tolist()


def test_its_rope_is_the_bare_skyline(folder: Path) -> None:
    rope = pyogrio.read_dataframe(folder / "rig.gpkg", layer="rope").set_index("name")
    ends = [coordinates(rope.loc["head_jack"].geometry)[k] for k in (0, -1)]
    stands = stood(rw.places(maps.rig()).loc[["head", "jack"]])
    np.testing.assert_allclose(ends, stands, atol=MILLIMETRE)
    assert rope.loc["head_jack", "tension_a"] == pytest.approx(80e3, rel=1e-9)
    assert rope.loc["jack_tail", "breaking_load"] == maps.ROPE.breaking_load
    low = pyogrio.read_dataframe(folder / "rig.gpkg", layer="clearance").set_index("name")
    path, ground = maps.path(), maps.ground()
    load = low.loc["load_low_2"]
    assert load["clearance"] == path["clearance"].min()
    assert coordinates(load.geometry)[0][2] - ground.elevation_at(350.0) == pytest.approx(load["clearance"], abs=1e-9)
    bare = low.loc["head_jack_low"]
    over = coordinates(bare.geometry)[0][2] - ground.elevation_at(bare["station"])
    assert over == pytest.approx(bare["rope_clearance"], abs=0.02)


def test_a_geopackage_holds_the_line(folder: Path) -> None:
    eq, table = rw.equilibrium(maps.line()), rw.places(maps.line())
    file = folder / "line.gpkg"
    supports = pyogrio.read_dataframe(file, layer="supports").set_index("name")
    anchors = pyogrio.read_dataframe(file, layer="anchors").set_index("name")
    assert (list(supports.index), list(anchors.index)) == (["s1", "c1", "s2"], ["valley", "top"])
    given = pd.DataFrame(maps.SUPPORTS, columns=["name", "x", "y", "z", "kind"]).set_index("name")
    for name, row in supports.iterrows():
        np.testing.assert_allclose(
            coordinates(row.geometry)[0], on_map(given.loc[[name], ["x", "y", "z"]])[0], atol=MILLIMETRE
        )
        for output in ("support_force", "tension_in"):
            assert row[output] == eq[f"{name}.{output}"]
        assert row["height"] == pytest.approx(table.loc[name, "height"])
    loads = pyogrio.read_dataframe(file, layer="loads")
    np.testing.assert_allclose(
        [coordinates(p)[0] for p in loads.geometry], on_map(eq.loads[["x", "y", "z"]]), atol=MILLIMETRE
    )
    rope = pyogrio.read_dataframe(file, layer="rope").set_index("name")
    curve = eq.profile("s1_c1", 41)[["x", "y", "z"]]
    np.testing.assert_allclose(coordinates(rope.loc["s1_c1"].geometry), on_map(curve), atol=MILLIMETRE)
    ground = coordinates(pyogrio.read_dataframe(file, layer="ground").geometry[0])
    np.testing.assert_allclose(ground, maps.ground().coordinates, atol=MILLIMETRE)


@pytest.mark.parametrize("name", ["rig", "line"])
def test_geojson_is_in_degrees_and_says_the_same(folder: Path, name: str) -> None:
    found = pyogrio.read_dataframe(folder / f"{name}.geojson")
    assert found.crs.to_epsg() == 4326
    back = found.to_crs("EPSG:2056").set_index(["layer", "name"])
    for layer in ("rope", "supports", "ground"):
        own = pyogrio.read_dataframe(folder / f"{name}.gpkg", layer=layer).set_index("name")
        for part, row in own.iterrows():
            there = back.loc[(layer, part)]
            np.testing.assert_allclose(coordinates(there.geometry), coordinates(row.geometry), atol=MILLIMETRE)
            known = [c for c in own.columns if c != "geometry" and pd.notna(row[c])]
            require_values(there, row, known)


@pytest.mark.parametrize("name", ["rig", "line"])
def test_dxf_in_3d(folder: Path, name: str) -> None:
    document = ezdxf.readfile(folder / f"{name}.dxf")
    audit = document.audit()
    assert (audit.errors, audit.fixes, document.header["$INSUNITS"]) == ([], [], 6)
    space = document.modelspace()
    for layer in ("supports", "anchors"):
        own = pyogrio.read_dataframe(folder / f"{name}.gpkg", layer=layer).set_index("name")
        marks = space.query(f'INSERT[layer=="{layer}"]')
        assert [mark.get_attrib_text("NAME") for mark in marks] == list(own.index)
        for mark, (_, row) in zip(marks, own.iterrows(), strict=True):
            np.testing.assert_allclose(tuple(mark.dxf.insert), coordinates(row.geometry)[0], atol=MILLIMETRE)
            for column in (c for c in own.columns if c != "geometry" and pd.notna(row[c])):
                text = mark.get_attrib_text(column.upper())
                assert text == row[column] if isinstance(row[column], str) else float(text) == row[column]
    rope = pyogrio.read_dataframe(folder / f"{name}.gpkg", layer="rope").set_index("name")
    lines = space.query('POLYLINE[layer=="rope"]')
    assert len(lines) == len(rope)
    for line in lines:
        about = dict(value.split("=", 1) for _, value in line.get_xdata("ROPEWAY") if "=" in str(value))
        row = rope.loc[about["name"]]
        np.testing.assert_allclose([tuple(p) for p in line.points()], coordinates(row.geometry), atol=MILLIMETRE)
        assert float(about["tension_a"]) == row["tension_a"]
    read = pyogrio.read_dataframe(folder / f"{name}.dxf")
    shapes = [coordinates(s) for s in read[(read["Layer"] == "rope")].geometry if s.geom_type == "LineString"]
    expected = [coordinates(s) for s in rope.geometry]
    assert len(shapes) == len(expected)
    for shape, own in zip(shapes, expected, strict=True):
        np.testing.assert_allclose(shape, own, atol=MILLIMETRE)


def test_dxf_in_plan_and_in_profile(folder: Path) -> None:
    table = rw.places(maps.rig())
    flat, upright = (ezdxf.readfile(folder / f"{view}.dxf") for view in ("plan", "profile"))
    for document in (flat, upright):
        assert not document.audit().errors
    places = {m.get_attrib_text("NAME"): m.dxf.insert for m in flat.modelspace().query("INSERT")}
    np.testing.assert_allclose(places["jack"], [*stood(table.loc[["jack"]])[0, :2], 0.0], atol=MILLIMETRE)
    places = {m.get_attrib_text("NAME"): m.dxf.insert for m in upright.modelspace().query("INSERT")}
    np.testing.assert_allclose(places["jack"], [250.0, table.loc["jack", "elevation"], 0.0], atol=MILLIMETRE)
    (ground,) = upright.modelspace().query('LWPOLYLINE[layer=="ground"]')
    terrain = maps.ground()
    np.testing.assert_allclose(
        np.array(ground.get_points("xy")), np.column_stack([terrain.station, terrain.elevation]), atol=MILLIMETRE
    )


@pytest.mark.parametrize("name", ["rig", "line"])
def test_kml_is_valid_and_has_altitudes(folder: Path, name: str) -> None:
    """The schema is OGC's ogckml22.xsd, which fastkml carries."""
    file = folder / f"{name}.kml"
    assert fastkml.validator.validate(file_to_validate=file)
    way = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:2056", always_xy=True)
    (document,) = fastkml.KML.parse(file).features
    folders = {each.name: each.features for each in document.features}
    for layer in ("supports", "anchors", "rope"):
        own = pyogrio.read_dataframe(folder / f"{name}.gpkg", layer=layer).set_index("name")
        read = pyogrio.read_dataframe(file, layer=layer)
        assert read["Name" if "Name" in read else "name"].tolist() == list(own.index)
        for mark, shape, (_, row) in zip(folders[layer], read.geometry, own.iterrows(), strict=True):
            assert mark.kml_geometry.altitude_mode.value == "absolute"
            at = coordinates(shape)
            back = np.column_stack([*way.transform(at[:, 0], at[:, 1]), at[:, 2]])
            np.testing.assert_allclose(back, coordinates(row.geometry), atol=MILLIMETRE)
            data = {element.name: element.value for element in mark.extended_data.elements}
            for column in (c for c in own.columns if c != "geometry" and pd.notna(row[c])):
                text = data[column]
                assert text == row[column] if isinstance(row[column], str) else float(text) == row[column]


@pytest.mark.parametrize(
    ("name", "stands"), [("rig", ["head", "jack", "tail"]), ("line", [s[0] for s in maps.SUPPORTS])]
)
def test_gpx_for_staking_out(folder: Path, name: str, stands: list[str]) -> None:
    file = folder / f"{name}.gpx"
    read = gpxpy.parse(file.read_text(encoding="utf-8"))
    assert read.version == "1.1"
    layers = [pyogrio.read_dataframe(folder / f"{name}.gpkg", layer=layer) for layer in ("supports", "anchors")]
    own = pd.concat(layers).set_index("name")
    points = {point.name: point for point in read.waypoints}
    gdal = pyogrio.read_dataframe(file, layer="waypoints").set_index("name")
    way = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:2056", always_xy=True)
    for part, row in own.iterrows():
        point = points[part]
        for at in (
            (point.longitude, point.latitude, point.elevation),
            (*coordinates(gdal.loc[part].geometry)[0][:2], gdal.loc[part, "ele"]),
        ):
            back = (*way.transform(*at[:2]), at[2])
            np.testing.assert_allclose(back, coordinates(row.geometry)[0], atol=MILLIMETRE)
    (route,) = read.routes
    assert [point.name for point in route.points] == stands


def layer_of(file: Path, layer: str) -> pd.DataFrame:
    """A layer of a GeoJSON file, in the line's own coordinate system."""
    found = pyogrio.read_dataframe(file).to_crs("EPSG:2056")
    return found[found["layer"] == layer].dropna(axis=1, how="all").reset_index()


def test_studies_systems_and_results_are_exported(tmp_path: Path) -> None:
    study = rw.Inhaul(maps.rig(), maps.path().rename_axis("time"), pd.DataFrame({"time": [0.0]}))
    carriage = layer_of(rw.export_gis(study, tmp_path / "study.geojson"), "carriage")
    assert carriage["time"].tolist() == [0.0, 1.0, 2.0]
    few = maps.path()[["carriage_x", "carriage_y", "carriage_z", "clearance"]]
    low = layer_of(rw.export_gis(maps.rig(), tmp_path / "few.geojson", stations=few), "clearance")
    assert low["clearance"].min() == few["clearance"].min()
    plan = rw.SupportPlan(maps.rig(), (), True, "", np.nan, 1)
    file = rw.export_gis(plan, tmp_path / "plan.geojson")
    assert (len(layer_of(file, "carriage")), len(layer_of(file, "rope"))) == (0, 3)
    run = rw.simulate(maps.line(), 4.0, every=2.0, progress=False)
    loads = layer_of(rw.export_gis(run, tmp_path / "run.geojson"), "loads")
    expected = on_map(run.at(4.0).loads[["x", "y", "z"]])
    np.testing.assert_allclose([coordinates(p)[0] for p in loads.geometry], expected, atol=MILLIMETRE)
    start = layer_of(rw.export_gis(maps.line(), tmp_path / "line.geojson"), "loads")
    assert np.hypot(*(coordinates(start.geometry[3])[0] - coordinates(loads.geometry[3])[0])[:2]) > 1.0


def test_a_running_skyline_is_exported_with_its_carriage(tmp_path: Path) -> None:
    rig = rw.running_skyline(
        maps.ground(), headspar=rw.HeadSpar("head", station=10.0, height=15.0),
        tailspar=rw.TailSpar("tail", station=300.0, height=12.0), haulback=maps.ROPE, mainline=maps.MAINLINE,
        tension=60e3, carriage=rw.Carriage("carriage", mass=350.0),
    )  # fmt: skip
    rope = layer_of(rw.export_gis(rig, tmp_path / "rig.geojson"), "rope")
    assert set(rope["from"]) | set(rope["to"]) >= {"haulback", "carriage", "tail"}
    assert rope["tension_a"].max() == pytest.approx(60e3, rel=0.05)


def test_maps_in_feet_are_drawn_in_feet(tmp_path: Path) -> None:
    """Oregon's Lambert is in international feet, its scale there 0.99986 and less."""
    frame = rw.MapFrame.straight("EPSG:2992", (500_000.0, 800_000.0), (501_000.0, 800_000.0))
    terrain = rw.Profile([0.0, 300.0], [100.0, 90.0], frame)
    rig = rw.standing_skyline(
        terrain, headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        tailspar=rw.TailSpar("tail", station=300.0, height=9.0),
        skyline=maps.ROPE, tension=60e3, carriage=rw.Carriage("carriage", mass=350.0),
    )  # fmt: skip
    document = ezdxf.readfile(rw.export_gis(rig, tmp_path / "rig.dxf"))
    assert document.header["$INSUNITS"] == 2
    head, tail = (tuple(mark.dxf.insert) for mark in document.modelspace().query('INSERT[layer=="supports"]'))
    assert head == pytest.approx((500_000.0, 800_000.0, 115.0 / 0.3048))
    assert tail[0] - head[0] == pytest.approx(300.0 / 0.3048, rel=5e-4)


def test_bad_exports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = maps.rig()
    with pytest.raises(rw.InputError, match=r"ends in '\.shp'.*\.gpkg"):
        rw.export_gis(rig, tmp_path / "rig.shp")
    for ending in ("dxf", "gpkg", "kml"):
        with pytest.raises(rw.WriteError, match="no folder"):
            rw.export_gis(rig, tmp_path / "nowhere" / f"rig.{ending}")
        (tmp_path / f"folder.{ending}").mkdir()
        with pytest.raises(rw.WriteError, match="cannot be written"):
            rw.export_gis(rig, tmp_path / f"folder.{ending}")
    with pytest.raises(rw.InputError, match="no column carriage_x"):
        rw.export_gis(rig, tmp_path / "rig.gpkg", stations=pd.DataFrame({"station": [1.0]}))
    local = rw.monocable(maps.ROPE, pd.DataFrame(maps.SUPPORTS, columns=["name", "x", "y", "z", "kind"]), tension=45e3)
    with pytest.raises(rw.InputError, match="no map coordinates"):
        rw.export_gis(local, tmp_path / "line.gpkg")
    unknown = rw.monocable(maps.ROPE, maps.supports(), tension=45e3)
    with pytest.raises(rw.InputError, match="system of the map is unknown"):
        rw.export_gis(unknown, tmp_path / "line.dxf")
    with pytest.raises(rw.InputError, match="geographic"):
        rw.monocable(maps.ROPE, maps.supports(), tension=45e3, crs="EPSG:4326")
    monkeypatch.setitem(__import__("sys").modules, "geopandas", None)
    with pytest.raises(rw.InputError, match=r"needs geopandas.*ropeway\[gis\]"):
        rw.export_gis(rig, tmp_path / "rig.gpkg")
    assert [p for p in tmp_path.iterdir() if not p.is_dir()] == []


def test_places_are_staked_out_from_the_foot_of_a_spar() -> None:
    table, ground = rw.places(maps.rig()), maps.ground()
    g1 = table.loc["g1"]
    foot, anchor = on_map([[10.0, 0.0, ground.elevation_at(10.0)], [-22.0, 14.0, 857.0]])
    east, north, rise = anchor - foot
    assert g1["azimuth"] == pytest.approx(np.degrees(np.arctan2(east, north)) % 360.0, abs=1e-4)
    assert g1["slope_distance"] == pytest.approx(np.sqrt(east**2 + north**2 + rise**2), abs=MILLIMETRE)
    assert (g1["seen_from"], table.loc["stump", "seen_from"], g1["kind"]) == ("head", "tail", "guyline anchor")
    jack = table.loc["jack"]
    chord = (240.0, ground.elevation_at(250.0) - ground.elevation_at(10.0))
    assert jack["slope_distance"] == pytest.approx(np.hypot(*chord), abs=MILLIMETRE)
    without = rw.standing_skyline(
        None, headspar=rw.HeadSpar("head", at=(0.0, 0.0)), tailspar=rw.TailSpar("tail", at=(200.0, -20.0)),
        skyline=maps.ROPE, length=207.0, carriage=rw.Carriage("carriage", mass=0.0),
    )  # fmt: skip
    tail = rw.places(without).loc["tail"]
    assert (tail["azimuth"], tail["slope_distance"]) == (0.0, pytest.approx(np.hypot(200.0, 20.0)))
    assert "easting" not in rw.places(without)
    with pytest.raises(rw.InputError, match="no supports"):
        rw.places(rw.System("empty"))
