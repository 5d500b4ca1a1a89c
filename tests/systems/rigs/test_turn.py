"""A log under a skyline: partial and full suspension along a corridor, and the balance of forces."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ropeway as rw
from ropeway.systems.studies.skyline.station_solver import Stations

G = 9.80665
CORRIDOR = rw.Profile.from_csv(Path(rw.__file__).parent / "examples" / "corridor.csv")
ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)


def rig(dropline: float, terrain: rw.Profile = CORRIDOR, friction: float = 0.6) -> rw.SkylineRig:
    log = rw.Log("log", mass=2000.0, length=10.0, friction=friction)
    return rw.standing_skyline(
        terrain,
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        supports=[rw.IntermediateSupport("jack", station=260.0, height=9.0)],
        tailspar=rw.TailSpar("tail", station=480.0, height=8.0),
        skyline=ROPE,
        tension=70e3,
        mainline=MAIN,
        carriage=rw.Carriage("carriage", mass=450.0),
        turn=rw.Turn(log, dropline=MAIN, length=dropline),
    )


def test_the_corridor_in_partial_and_full_suspension() -> None:
    stations = np.arange(20.0, 480.0, 10.0)
    short, long = (rw.load_path(rig(d), 2500.0, stations) for d in (1.0, 7.0))
    assert set(short.suspension) == {"partial", "full"}
    assert set(long.suspension) == {"partial"}
    # A dragging log loads the skyline less and the mainline more.
    assert (long.highest_tension <= short.highest_tension + 1.0).all()
    full = short[short.suspension == "full"]
    np.testing.assert_allclose(full.dropline_tension, (2500.0 + 0.73 * 1.0) * G, rtol=1e-9)
    np.testing.assert_allclose(full.ground_force, 0.0, atol=1e-6)
    # A free log equals a payload at the carriage with the dropline's weight.
    plain = rw.standing_skyline(
        CORRIDOR,
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        supports=[rw.IntermediateSupport("jack", station=260.0, height=9.0)],
        tailspar=rw.TailSpar("tail", station=480.0, height=8.0),
        skyline=ROPE,
        tension=70e3,
        mainline=MAIN,
        carriage=rw.Carriage("carriage", mass=450.0 + 0.73),
    )
    same = rw.load_path(plain, 2500.0, full.station.to_numpy())
    np.testing.assert_allclose(full.highest_tension, same.highest_tension, rtol=1e-9)
    np.testing.assert_allclose(full.mainline_pull, same.mainline_pull, rtol=1e-8)


@pytest.mark.parametrize("station", [95.0, 150.0, 263.0, 340.0, 455.0])
def test_the_rear_lies_on_the_ground_and_the_log_is_in_balance(station: float) -> None:
    found = Stations(rig(7.0)).solve(station, 2500.0)
    rear = np.array([found["log.rear_x"], found["log.rear_z"]])
    front = np.array([found["log.x"], found["log.z"]])
    assert rear[1] == pytest.approx(CORRIDOR.elevation_at(float(rear[0])), abs=1e-7)
    assert np.linalg.norm(rear - front) == pytest.approx(10.0, rel=1e-9)
    slope = CORRIDOR.slope_at(float(rear[0]))
    assert found["log.ground_slope"] == pytest.approx(slope, rel=1e-9)
    reaction = found["log.normal"] * (np.array([-slope, 1.0]) + 0.6 * np.array([1.0, slope])) / np.hypot(1.0, slope)
    pull = np.array([0.0, 2500.0 * G]) - reaction
    assert found["log.line_pull"] == pytest.approx(np.linalg.norm(pull), rel=1e-8)
    arm = rear - front
    moment = arm[0] * reaction[1] - arm[1] * reaction[0] - 0.5 * arm[0] * 2500.0 * G
    assert moment == pytest.approx(0.0, abs=1e-3)


def test_a_friction_free_log_pulls_less() -> None:
    rough, smooth = (rw.load_path(rig(7.0, friction=f), 2500.0, [100.0]).iloc[0] for f in (0.6, 0.0))
    assert rough.mainline_pull > smooth.mainline_pull + 1000.0


def rig_over(ground: rw.Profile) -> rw.SkylineRig:
    return rw.live_skyline(
        ground,
        headspar=rw.HeadSpar("head", station=0.0, height=20.0),
        tailspar=rw.TailSpar("tail", station=400.0, height=25.0),
        skyline=ROPE,
        tension=90e3,
        mainline=MAIN,
        carriage=rw.Carriage("carriage", mass=450.0),
        turn=rw.Turn(rw.Log("log", mass=2500.0, length=10.0), dropline=MAIN, length=8.0),
    )


def test_a_live_skyline_keeps_the_carriage_over_a_log_at_a_height() -> None:
    ground = rw.Profile([-50.0, 160.0, 500.0], [0.0, -63.0, -100.0])
    path = rw.load_path(rig_over(ground), 2500.0, [100.0, 150.0, 250.0], height=14.0)
    np.testing.assert_allclose(path.carriage_z, ground.elevations(path.carriage_x) + 14.0, atol=1e-9)
    assert (path.suspension == "partial").all()


def test_a_log_pulled_in_is_the_load_path() -> None:
    """Over vertices of the ground, and over the jack."""
    run = rw.inhaul(rig(7.0), payload=2500.0, start=400.0, end=180.0, speed=4.0, every=3.0)
    path = rw.load_path(rig(7.0), 2500.0, run.frame.carriage_x.to_numpy())
    assert len(run.frame) > 15
    for column in ("carriage_z", "skyline_tension", "mainline_pull", "ground_force"):
        np.testing.assert_allclose(run.frame[column], path[column], rtol=1e-6)


def test_payload_study_with_a_log() -> None:
    study = rw.payload(rig(5.0), stations=[60.0, 130.0, 400.0])
    assert (study.frame.payload > 3000.0).all()
    carried = rw.load_path(rig(5.0), study.payload, [60.0, 130.0, 400.0])
    assert (carried.highest_tension <= ROPE.breaking_load / 3.0 * (1.0 + 1e-9)).all()
    assert (carried.mainline_tension <= MAIN.breaking_load / 3.0 * (1.0 + 1e-9)).all()


def test_a_payload_keeps_the_logs_front_clear_and_its_dropline_whole() -> None:
    stations = [60.0, 130.0, 230.0, 400.0]
    free, clear = (rw.payload(rig(7.0), clearance=c, stations=stations).frame for c in (None, 1.0))
    # The rear may drag. A log of almost no mass, with its rear just over the ground, is not a limit.
    assert (clear.payload > 1000.0).all()
    near = free.front_clearance < 1.0
    assert set(clear.limited_by[near]) == {"clearance"}
    np.testing.assert_allclose(clear.front_clearance[near], 1.0, atol=1e-8)
    np.testing.assert_allclose(clear.payload[~near], free.payload[~near], rtol=1e-9)
    weak = replace(MAIN, breaking_load=45e3)
    one = rig(7.0)
    assert one.turn is not None
    limited = rw.payload(replace(one, turn=replace(one.turn, dropline=weak)), stations=[60.0]).limiting
    assert (limited.limited_by, limited.dropline_tension) == ("dropline tension", pytest.approx(15e3, rel=1e-9))


def test_invalid_combinations_with_a_log() -> None:
    with pytest.raises(rw.InputError, match="drags on a terrain"):
        rw.standing_skyline(
            None,
            headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
            tailspar=rw.TailSpar("tail", at=(200.0, -20.0)),
            skyline=ROPE,
            length=207.0,
            carriage=rw.Carriage("carriage", mass=100.0),
            turn=rw.Turn(rw.Log("log", mass=2000.0, length=10.0), dropline=MAIN, length=3.0),
        )
    with pytest.raises(rw.InputError, match="the opposite way"):
        rw.inhaul(rig(3.0), payload=1000.0, start=100.0, end=200.0)
    with pytest.raises(rw.InputError, match="length"):
        rw.Turn(rw.Log("log", mass=2000.0, length=10.0), dropline=MAIN, length=0.0)
