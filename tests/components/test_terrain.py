"""Terrain profiles: reading, slopes, and clearance with tangent points inside a segment."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import ropeway as rw
from ropeway.components.catenary import Strain, profile
from ropeway.components.rope_piece import Piece

GROUND = rw.Profile([0.0, 50.0, 120.0, 200.0], [10.0, -5.0, 0.0, -20.0])


def test_slopes_and_elevations() -> None:
    assert GROUND.elevation_at(25.0) == pytest.approx(2.5)
    assert GROUND.slope_at(25.0) == pytest.approx(-0.3)
    assert GROUND.slope_at(50.0) == pytest.approx(5.0 / 70.0)
    assert GROUND.slope_at(200.0) == pytest.approx(-0.25)
    assert GROUND.chord_slope(0.0, 200.0) == pytest.approx(-0.15)
    fine = GROUND.resampled(10.0)
    assert len(fine.station) == 21
    np.testing.assert_allclose(fine.elevation, GROUND.elevations(fine.station))


@settings(max_examples=60, deadline=None)
@given(
    fx=st.floats(2e3, 1e5),
    aside=st.floats(-0.5, 0.5),
    slope=st.floats(-0.8, 0.4),
    length=st.floats(20.0, 130.0),
    height=st.floats(-5.0, 40.0),
    start=st.floats(1.0, 60.0),
)
def test_clearance_is_the_least_of_many_points(
    fx: float, aside: float, slope: float, length: float, height: float, start: float
) -> None:
    strain = Strain(1.0 / 30e6, 0.0)
    piece = Piece((start, height), (fx, fx * aside, fx * slope), 34.0, length, strain)
    found = GROUND.clearance(piece)
    curve = profile(piece.force, 34.0, strain, length, (), (), np.linspace(0.0, length, 20001))
    x, z = start + curve.reach[:, 0], height + curve.reach[:, 2]
    over = z - GROUND.elevations(x)
    assert found.height <= np.nanmin(over) + 1e-9
    assert found.height == pytest.approx(np.nanmin(over), abs=2e-3)


def test_tangent_point_inside_a_segment() -> None:
    """A rope that clears both ends of a long even slope and dips towards it between them."""
    ground = rw.Profile([0.0, 200.0], [0.0, -60.0])
    strain = Strain(0.0, 0.0)
    a, weight, d = 250.0, 30.0, 120.0
    force = (a * weight, 0.0, a * weight * -0.6)
    found = ground.clearance(Piece((20.0, 14.0), force, weight, d, strain))
    # The rope is a*cosh(u) with slope sinh(u): parallel to the ground where sinh(u) = -0.3.
    u0, u1 = np.arcsinh(-0.6), np.arcsinh(-0.3)
    x, z = 20.0 + a * (u1 - u0), 14.0 + a * (np.cosh(u1) - np.cosh(u0))
    assert found.station == pytest.approx(x, rel=1e-12)
    assert found.height == pytest.approx(z + 0.3 * x, rel=1e-10)


def test_clearance_of_a_broken_line() -> None:
    assert GROUND.clearance_of_line([(100.0, 10.0), (140.0, 2.0)]).height == pytest.approx(6.0)
    assert GROUND.clearance_of_line([(100.0, 10.0), (140.0, 3.0)]).station == pytest.approx(120.0)


def test_from_csv(tmp_path: Path) -> None:
    file = tmp_path / "corridor.csv"
    file.write_text("station,elevation,remark\n0,10,\n5.5,9,stream\n20,12,\n")
    ground = rw.Profile.from_csv(file)
    np.testing.assert_allclose(ground.station, [0.0, 5.5, 20.0])
    np.testing.assert_allclose(ground.elevation, [10.0, 9.0, 12.0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("station,height\n0,1\n", "line 1: no column elevation"),
        ("station,elevation\n0,1\n5,x\n", "line 3"),
        ("station,elevation\n0,1\n5,2\n5,3\n", "line 4"),
        ("station,elevation\n0,1\n5\n", "line 3"),
        ("station,elevation\n0,nan\n5,2\n", "line 2"),
        ("station,elevation\n0,1\n", "1 point"),
        ("x,y,z\n0,0,5\n3,4,6\n3,4,7\n", "line 4: station does not increase: 5 m after 5 m"),
        ("x,y,z\n7.91,46.21,1400\n7.92,46.22,1350\n", "degrees"),
        ("x,y\n0,0\n3,4\n", "line 1: no column"),
    ],
)
def test_bad_files_are_refused_by_line(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "corridor.csv"
    file.write_text(text)
    with pytest.raises(rw.InputError, match=words):
        rw.Profile.from_csv(file)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_lines_in_map_coordinates(tmp_path: Path, encoding: str) -> None:
    """A bend to the left: the station is the horizontal length."""
    file = tmp_path / "map.csv"
    text = "X;Y;Z;Bemerkung\n2'600'000,5;1'200'000;846,4;Stra\u00dfe\n"
    text += "2'600'003,5;1'200'004;840;\n2'599'991,5;1'200'009;835,25;\n"
    file.write_text(text, encoding=encoding)
    ground = rw.Profile.from_csv(file)
    np.testing.assert_allclose(ground.station, [0.0, 5.0, 18.0])
    np.testing.assert_allclose(ground.elevation, [846.4, 840.0, 835.25])


def test_bad_profiles_are_refused() -> None:
    with pytest.raises(rw.InputError, match="no file"):
        rw.Profile.from_csv("nowhere.csv")
    with pytest.raises(rw.InputError, match="do not increase"):
        rw.Profile([0.0, 2.0, 1.0], [0.0, 0.0, 0.0])
    with pytest.raises(rw.InputError, match="shape"):
        rw.Profile([0.0, 2.0], [0.0])
    with pytest.raises(rw.InputError, match="finite"):
        rw.Profile([0.0, np.nan], [0.0, 1.0])
    with pytest.raises(rw.InputError, match="outside the profile"):
        GROUND.elevation_at(300.0)
