"""The state of a station depends only on its case: logs, guyed spars, haulbacks that lift, point saddles."""

from __future__ import annotations

import numpy as np
import pytest

import ropeway as rw

SKY = rw.Rope(mass_per_length=2.9, axial_stiffness=29e6, breaking_load=480e3)
LINE = rw.Rope(mass_per_length=0.8, axial_stiffness=8.5e6, breaking_load=130e3)


def with_log(centre: float, friction: float) -> rw.SkylineRig:
    """Uphill: the carriage runs towards the yarder and the log often leaves the ground."""
    log = rw.Log("log", mass=400.0, length=11.0, friction=friction, centre=centre)
    return rw.standing_skyline(
        rw.Profile([-40, 180, 260, 420], [0, 24, 55, 92]),
        headspar=rw.HeadSpar("head", station=0.0, height=16.0),
        tailspar=rw.TailSpar("tail", station=370.0, height=12.0),
        skyline=SKY,
        tension=75e3,
        mainline=LINE,
        carriage=rw.Carriage("car", mass=280.0),
        turn=rw.Turn(log, LINE, 4.5),
    )


@pytest.mark.parametrize(("centre", "friction"), [(0.4, 0.5), (0.55, 0.3)])
def test_no_log_is_upside_down_and_the_order_of_stations_is_irrelevant(centre: float, friction: float) -> None:
    rig, stations = with_log(centre, friction), np.array([30.0, 190.0, 290.0, 350.0])
    frames = [
        rw.payload(rig, clearance=0.2, stations=order).frame.set_index("station").loc[stations]
        for order in (stations, stations[::-1], stations[[2, 0, 3, 1]])
    ]
    for frame in frames:
        free = frame[frame.suspension == "full"]
        assert (free.front_clearance > free.clearance + 5.0).all()
        np.testing.assert_allclose(frame.payload, frames[0].payload, rtol=1e-7, atol=1e-6)
        assert frame.limited_by.tolist() == frames[0].limited_by.tolist()
    assert len(set(frames[0].suspension)) >= 1


def test_payloads_are_continuous_with_a_haulback_that_lifts_the_empty_carriage() -> None:
    """A live skyline lowered to its clearance has similar payloads at stations 1 m apart."""
    rig = rw.live_skyline(
        rw.Profile([0, 90, 240], [900, 906, 958]),
        headspar=rw.HeadSpar("y", station=20.0, height=13.0),
        tailspar=rw.TailSpar("t", station=235.0, height=10.0),
        skyline=SKY,
        tension=65e3,
        mainline=LINE,
        haulback=LINE,
        haulback_tension=28e3,
        carriage=rw.Carriage("c", mass=380.0, depth=2.5),
    )
    frame = rw.payload(rig, clearance=1.5, stations=np.arange(28.0, 40.0, 2.0)).frame
    assert (frame.payload > 2000.0).all()
    assert np.abs(np.diff(frame.payload)).max() < 0.05 * frame.payload.min()
    assert frame.highest_tension.max() <= SKY.breaking_load / 3.0 * (1.0 + 1e-9)
    alone = rw.payload(rig, clearance=1.5, stations=[36.0]).frame
    assert alone.payload[0] == pytest.approx(frame.payload[4], rel=1e-8)


def test_a_strong_haulback_leaves_no_station_without_payload() -> None:
    """A live skyline at its lowest position has no station with payload 0 between stations with payloads."""
    line = rw.Rope(mass_per_length=0.9, axial_stiffness=9.5e6, breaking_load=155e3)
    rig = rw.live_skyline(
        rw.Profile([-40, 0, 30, 65, 95, 135], [4, 0, 2, 17, 35, 52]),
        headspar=rw.HeadSpar("h", station=0.0, height=13.0),
        tailspar=rw.TailSpar("t", station=95.0, height=10.0),
        skyline=rw.Rope(mass_per_length=1.5, axial_stiffness=15e6, breaking_load=255e3),
        tension=26e3,
        mainline=line,
        haulback=line,
        haulback_tension=41e3,
        haulback_block=rw.Block("b", station=95.0, height=6.0),
        carriage=rw.Carriage("c", mass=640.0),
    )
    frame = rw.payload(rig, clearance=1.5, stations=np.arange(66.0, 70.0)).frame
    assert frame.payload.min() > 2000.0
    np.testing.assert_allclose(np.diff(frame.payload), 33.0, atol=15.0)
    assert frame.limited_by.unique().tolist() == ["skyline tension"]


def saddle() -> rw.SkylineRig:
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("a", at=(30, 800.0)),
        supports=[rw.IntermediateSupport("s", at=(95, 783.0))],
        tailspar=rw.TailSpar("e", at=(190, 755.0)),
        skyline=SKY,
        tension=75e3,
        mainline=LINE,
        carriage=rw.Carriage("c", mass=550.0),
    )


def test_a_carriage_runs_over_a_point_saddle_to_where_its_mainline_holds_it() -> None:
    """A heavier carriage runs farther; above some load the mainline holds no carriage near the saddle."""
    left = []
    for payload in (2400.0, 3300.0, 4200.0):
        run = rw.inhaul(saddle(), payload=float(payload), start=105.0, end=85.0, every=4.0)
        left.append(float(run.events[run.events.event == "leaves s"].station.iloc[0]))
    assert all(np.diff(left) < 0.0), left
    assert 95.0 - left[-1] > 0.5


def test_a_payload_that_cannot_be_hauled_has_a_remark_with_a_remedy() -> None:
    rig = rw.standing_skyline(
        rw.Profile([0, 150, 320], [0, -10, 30]),
        headspar=rw.HeadSpar("head", station=5.0, height=14.0),
        tailspar=rw.TailSpar("tail", station=310.0, height=12.0),
        skyline=SKY,
        tension=60e3,
        mainline=LINE,
        carriage=rw.Carriage("car", mass=400.0),
    )
    study = rw.payload(rig, clearance=1.0, stations=np.arange(40.0, 300.0, 40.0))
    assert not study.hauled
    assert f"not hauled at {len(study.not_hauled)} of 7 stations" in repr(study)
    needed = study.haulback_needed
    assert needed is not None
    held = {
        share: rw.standing_skyline(
            rig.terrain, headspar=rig.headspar, tailspar=rig.tailspar, skyline=SKY, tension=60e3, mainline=LINE,
            haulback=LINE, haulback_tension=share * needed, carriage=rig.carriage,
        )
        for share in (0.9, 1.0)
    }  # fmt: skip
    by = {share: set(rw.load_path(one, study.payload, study.frame.station).held_by) for share, one in held.items()}
    assert by[1.0] == {"mainline"}
    assert "clamp" in by[0.9]
    assert any("haulback" in remark for remark in study.remarks)


def test_a_bare_rope_under_the_ground_has_a_remark() -> None:
    rig = rw.standing_skyline(
        rw.Profile([0, 100, 150, 300], [0, 6, 18, 0]),
        headspar=rw.HeadSpar("head", station=2.0, height=10.0),
        tailspar=rw.TailSpar("tail", station=298.0, height=10.0),
        skyline=SKY,
        tension=60e3,
        carriage=rw.Carriage("car", mass=400.0),
    )
    study = rw.payload(rig, clearance=1.0, stations=[80.0, 150.0])
    bare = study.bare_rope
    assert bare is not None
    assert bare.station == pytest.approx(150.0, abs=1.0)
    assert bare.height == pytest.approx(-13.0, abs=0.2)
    assert any("under the ground at station 150.0 m" in remark for remark in study.remarks)
    assert not any("Load or rope" in remark for remark in study.remarks)
    free = rw.payload(rig, stations=[40.0, 80.0, 150.0])
    depth = -free.frame[["clearance", "rope_clearance"]].min(axis=1)
    (remark,) = [remark for remark in free.remarks if remark.startswith("Load or rope")]
    assert f"at {(depth > 0.0).sum()} of 3 stations" in remark
    assert float(remark.split("by up to ")[1].split(" m")[0]) == pytest.approx(depth.max() + 0.05, abs=0.051)
