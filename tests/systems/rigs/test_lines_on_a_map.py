"""Lines in map coordinates and over their ground: the same line as in local axes, heights over the ground."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from support import maps

LOADED = {"tension": 45e3, "load_mass": 180.0, "load_spacing": 45.0}


def local() -> pd.DataFrame:
    return pd.DataFrame(maps.SUPPORTS, columns=["name", "x", "y", "z", "kind"])


def test_a_line_in_map_coordinates_equals_one_in_local_axes() -> None:
    on_map, own = rw.equilibrium(maps.line()), rw.equilibrium(rw.monocable(maps.ROPE, local(), **LOADED))
    values, expected = on_map.frame["value"].to_numpy(), own.frame["value"].to_numpy()
    np.testing.assert_allclose(values, expected, rtol=1e-6, atol=1e-3)
    frame = on_map.model.system.map_frame
    assert frame.azimuth == pytest.approx(np.degrees(np.arctan2(3.0, 4.0)), abs=1e-4)
    east, north = frame.to_map(on_map["s1.x"] if "s1.x" in on_map.model.p.index else 118.0, 6.0)
    table = maps.supports().set_index("name")
    np.testing.assert_allclose((east, north), table.loc["s1", ["easting", "northing"]].to_numpy(float), atol=1e-3)


def test_the_coordinate_system_is_recognised_in_the_table(tmp_path) -> None:
    table = maps.supports().assign(crs=["EPSG:2056", *[""] * 4])
    table.to_csv(tmp_path / "line.csv", index=False)
    assert rw.monocable(maps.ROPE, tmp_path / "line.csv", tension=45e3).map_frame.crs == "EPSG:2056"
    with pytest.raises(rw.InputError, match=r"EPSG:2056 and in EPSG:21781"):
        rw.monocable(maps.ROPE, table.assign(crs=["EPSG:21781", "EPSG:2056", "", "", ""]), tension=45e3)
    one_point = maps.supports().assign(easting=2.6e6, northing=1.2e6)
    with pytest.raises(rw.InputError, match="one point of the map"):
        rw.monocable(maps.ROPE, one_point, tension=45e3, crs="EPSG:2056")


def test_heights_over_the_ground_are_those_of_many_points() -> None:
    eq, ground = rw.equilibrium(maps.line()), maps.ground()
    for span, row in eq.clearance.iterrows():
        curve = eq.profile(span, 4001)
        # The terrain follows the line's axis and is level across it.
        over = curve["z"].to_numpy() - ground.elevations(curve["x"].to_numpy())
        assert row["rope_clearance"] == pytest.approx(over.min(), abs=5e-3)
        loads = eq.loads[eq.loads["span"] == span]
        assert row["load_clearance"] == pytest.approx((loads["z"] - ground.elevations(loads["x"])).min(), abs=1e-4)


def test_a_run_reports_where_it_falls_below_its_clearance() -> None:
    line = rw.monocable(maps.ROPE, maps.supports(), **LOADED, crs="EPSG:2056", terrain=maps.ground(), clearance=7.5)
    run = rw.simulate(line, 40.0, every=2.0, progress=False)
    lowest = run.clearance.loc["valley_s1"]
    records = [run.record(i).clearance.loc["valley_s1", "rope_clearance"] for i in range(0, len(run.records), 5)]
    assert lowest["rope_clearance"] <= min(records) + 0.02
    assert lowest["rope_clearance"] == pytest.approx(
        run.at(lowest["time"]).clearance.loc["valley_s1", "rope_clearance"]
    )
    below = run.events[run.events["event"] == "below clearance"]
    assert set(below["component"]) == {"valley_s1"}
    assert (below["value"] < 7.5).all()
    assert f"in valley_s1 at {lowest['time']:.1f} s" in str(run.summary())


def test_ground_of_lines_in_their_own_axes() -> None:
    """Stations count along the line, over its supports."""
    line = rw.monocable(maps.ROPE, local().assign(x=lambda t: t["x"] + 50.0), tension=45e3, terrain=maps.ground())
    eq = rw.equilibrium(line)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(local()[["x", "y"]].to_numpy(), axis=0).T))])
    table = rw.places(eq)
    np.testing.assert_allclose(table["ground"], maps.ground().elevations(along), atol=1e-9)


ENDLESS = [
    ("w", 0.0, 0.0, 872.0, "control"),
    ("out", 150.0, 2.0, 830.0, "idler"),
    ("r", 400.0, 0.0, 775.0, "return"),
    ("back", 150.0, -2.0, 832.0, "idler"),
]


def test_ground_under_both_directions_of_an_endless_line() -> None:
    supports = pd.DataFrame(ENDLESS, columns=["name", "x", "y", "z", "kind"])
    line = rw.endless(maps.ROPE, supports, tension=45e3, load_mass=150.0, load_spacing=60.0, terrain=maps.ground())
    table = rw.places(line)
    assert table.loc["back", "ground"] == pytest.approx(table.loc["out", "ground"], abs=0.02)
    run = rw.simulate(line, 3.0, every=3.0, progress=False)
    eq = run.record(len(run.records) - 1)
    for span in ("r_back", "out_r"):
        curve = eq.profile(span, 2001)
        over = curve["z"].to_numpy() - maps.ground().elevations(np.hypot(curve["x"], curve["y"]).to_numpy())
        assert eq.clearance.loc[span, "rope_clearance"] == pytest.approx(over.min(), abs=0.05)
    exact = [low.height for low in eq.heights_over_ground(801)]
    np.testing.assert_allclose(run.heights[-1], exact, atol=2e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"terrain": rw.Profile([0.0, 300.0], [700.0, 690.0])}, "'s2' at station .* outside the terrain"),
        ({"terrain": rw.Profile([0.0, 500.0], [870.0, 690.0])}, "'valley' at z = 866 m lies below the ground"),
        ({"clearance": 3.0}, "no terrain to clear"),
        ({"terrain": rw.Profile([0.0, 500.0], [1.0, 2.0], rw.MapFrame.straight("EPSG:32632", maps.START, maps.END)),
          "supports": maps.supports(), "crs": "EPSG:2056"}, "its terrain in EPSG:32632"),
    ],
)  # fmt: skip
def test_bad_grounds_are_rejected(change: dict, words: str) -> None:
    arguments = {"supports": local(), **change}
    with pytest.raises(rw.InputError, match=words):
        rw.monocable(maps.ROPE, arguments.pop("supports"), tension=45e3, **arguments)
    with pytest.raises(rw.InputError, match="has no ground"):
        rw.equilibrium(rw.monocable(maps.ROPE, local(), tension=45e3)).heights_over_ground()


def test_the_figure_shows_ground_and_map() -> None:
    run = rw.simulate(maps.line(), 1.0, every=1.0, progress=False)
    axes = run.plot_line().axes
    (ground,) = [
        line for line in axes[-1 if axes[-1].get_xlabel() == "" else 0].get_lines() if line.get_label() == "ground"
    ] or [line for axis in axes for line in axis.get_lines() if line.get_label() == "ground"]
    assert np.nanmax(np.abs(ground.get_ydata() - maps.ground().elevations(ground.get_xdata()))) < 1.0
    assert any("EPSG:2056" in axis.get_title() for axis in axes)
