"""A carriage that runs over its supports inside an FMU, against rw.inhaul; and what is refused."""

from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

import ropeway as rw
from ropeway.fmu import export
from support.fmus import MAIN, ROPE, Opened, Opener, corridor, skyline

EVERY = 0.73
ALIKE = {
    "carriage_x": "carriage.x",
    "carriage_z": "carriage.z",
    "skyline_tension": "carriage.tension_a",
    "mainline_pull": "carriage.mainline_pull",
    "mainline_tension": "mainline.rope_tension",
    "s1_force": "s1.support_force",
}


def deviation(path: Path, kind: str, found: rw.Inhaul, start: dict[str, float]) -> float:
    """The largest difference of an FMU's run from one in Python, relative."""
    frame = found.frame[~found.frame.index.duplicated()].iloc[:-1]
    run = fmpy.simulate_fmu(
        str(path),
        fmi_type=kind,
        stop_time=frame.index[-1],
        output_interval=EVERY,
        step_size=EVERY,
        start_values=start,
        relative_tolerance=1e-8,
        record_events=False,
    )
    at = [int(np.argmin(np.abs(run["time"] - t))) for t in frame.index]
    assert np.abs(run["time"][at] - frame.index).max() < 1e-9
    columns = [c for c in ALIKE if c in frame]
    assert len(columns) >= 4
    got = np.column_stack([run[ALIKE[c]][at] for c in columns])
    return float(np.abs(got / frame[columns].to_numpy() - 1.0).max())


@pytest.mark.parametrize("name", ["corridor2", "corridor3"])
def test_fmpy_finds_no_problem(name: str, request: pytest.FixtureRequest) -> None:
    path: Path = request.getfixturevalue(name)
    assert validate_fmu(str(path)) == []
    assert path.stat().st_size < 1e6


RUNS = {"corridor2": (corridor(), 2500.0), "corridor3": (corridor(haulback_tension=3e3), 0.0)}


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("corridor2", "CoSimulation"),
        pytest.param("corridor2", "ModelExchange", marks=pytest.mark.slow),
        pytest.param("corridor3", "CoSimulation", marks=pytest.mark.slow),
        ("corridor3", "ModelExchange"),
    ],
)
def test_inwards_over_two_supports_and_outwards_again(name: str, kind: str, request: pytest.FixtureRequest) -> None:
    """Outhaul starts with more mainline wound in: the carriage is taken over the supports when the FMU starts."""
    path: Path = request.getfixturevalue(name)
    rig, payload = RUNS[name]
    run = rw.inhaul(rig, payload=payload, start=345.0, end=150.0, speed=3.0, every=EVERY)
    assert list(run.events["event"]) == ["reaches s2", "leaves s2", "reaches s1", "leaves s1"]
    assert deviation(path, kind, run, {"mainline.speed": -3.0}) < 1e-8
    wound = {"mainline.travel": -210.0}
    first = fmpy.simulate_fmu(str(path), stop_time=EVERY, output_interval=EVERY, start_values=wound)
    start = float(first["carriage.x"][0])
    assert start < 150.0
    run = rw.inhaul(rig, payload=payload, start=start, end=345.0, speed=2.0, every=EVERY)
    assert deviation(path, kind, run, {**wound, "mainline.speed": 2.0}) < 1e-8


def test_events_in_model_exchange(corridor2: Path) -> None:
    run = rw.inhaul(corridor(), payload=2500.0, start=345.0, end=150.0, speed=1.0)
    found = fmpy.simulate_fmu(
        str(corridor2),
        fmi_type="ModelExchange",
        stop_time=200.0,
        start_values={"mainline.speed": -1.0},
        relative_tolerance=1e-8,
    )
    times = found["time"][np.flatnonzero(np.diff(found["time"]) == 0.0)]
    times = np.unique(times)
    times = times[np.diff(times, append=np.inf) > 1e-9]  # the integrator may stop a rounding error before a root
    np.testing.assert_allclose(times, run.events["time"], atol=1e-6)


def test_one_step_is_as_good_as_many(corridor3: Path, open_fmu: Opener) -> None:
    names = ["carriage.x", "carriage.z", "carriage.tension_a", "mainline.rope_tension"]
    ends = []
    for steps in (1, 20, 400):
        one = hauled(open_fmu, corridor3)
        ends.append(one.run(0.0, 200.0, 200.0 / steps, names)[-1])
    np.testing.assert_allclose(ends[1:], [ends[0]] * 2, rtol=1e-9)


def test_a_rope_that_breaks_within_a_long_step_is_reported(tmp_path: Path, open_fmu: Opener) -> None:
    """The skyline's tension is highest in mid-span, and below the limit again before the support."""
    frame = rw.inhaul(corridor(), payload=2500.0, start=315.0, end=190.0, speed=1.0).frame
    limit = 0.2 * frame.highest_tension.min() + 0.8 * frame.highest_tension.max()
    above = (frame.highest_tension > limit).to_numpy()
    assert not above[0]
    assert not above[-1]
    rig = replace(corridor(), skyline=replace(ROPE, breaking_load=limit))
    one = hauled(open_fmu, export(rig, tmp_path / "breaks.fmu", station=315.0, payload=2500.0))
    one.step(0.0, frame.index[-1])
    told = [float(text.split("t = ")[1].split(" s")[0]) for text in one.log if "skyline.tension_above_MBL" in text]
    assert told == pytest.approx([frame.index[np.argmax(above)]], abs=2.0)


def hauled(open_fmu: Opener, path: Path, speed: float = -1.0, **more: float) -> Opened:
    """Initialised, with the drum's speed."""
    one = open_fmu(path)
    one.set(mainline__speed=speed, **more)
    one.initialize()
    return one


@pytest.mark.parametrize("name", ["corridor2", "corridor3"])
def test_backwards_over_a_support_and_forwards_again(
    name: str, open_fmu: Opener, request: pytest.FixtureRequest
) -> None:
    names = ["carriage.x", "carriage.tension_a", "s2.support_force"]
    one, two = (hauled(open_fmu, request.getfixturevalue(name)) for _ in range(2))
    one.run(0.0, 16.0, 0.5, names)
    state = one.save()
    first = one.run(16.0, 30.0, 0.5, names)
    one.restore(state)
    assert np.array_equal(one.run(16.0, 30.0, 0.5, names), first)
    if two.three:
        restored = two.fmu.deserializeFMUState(one.fmu.serializeFMUState(state))
    else:
        restored = two.fmu.deSerializeFMUstate(one.fmu.serializeFMUstate(state))
    two.restore(restored)
    assert np.array_equal(two.run(16.0, 30.0, 0.5, names), first)


def test_other_payloads(corridor2: Path, open_fmu: Opener) -> None:
    for payload in (0.0, 1500.0):
        one = open_fmu(corridor2)
        one.set(carriage__payload=payload, mainline__speed=-3.0)
        one.initialize()
        start = one.get("carriage.x")[0]  # it hangs higher or lower on a mainline of the same length
        run = rw.inhaul(corridor(), payload=payload, start=start, end=150.0, speed=3.0, every=EVERY)
        begin = {"carriage.payload": payload, "mainline.speed": -3.0}
        assert deviation(corridor2, "CoSimulation", run, begin) < 1e-8


def test_directional_derivatives_on_a_shoe(corridor2: Path, open_fmu: Opener) -> None:
    one = hauled(open_fmu, corridor2, -1.0, mainline__travel=-17.5)
    names = ["carriage.x", "carriage.tension_a", "s2.support_force"]
    unknown = [one.references[n] for n in names]
    exact = one.fmu.getDirectionalDerivative(unknown, [one.references["carriage.payload"]], [1.0])
    around = []
    for payload in (2499.9, 2500.1):
        near = hauled(open_fmu, corridor2, -1.0, mainline__travel=-17.5, carriage__payload=payload)
        around.append(near.get(*names))
    np.testing.assert_allclose(exact, np.diff(around, axis=0)[0] / 0.2, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(("speed", "x"), [(-1.0, 0.0), (1.0, 480.0)])
def test_the_end_of_the_path_is_an_error(speed: float, x: float, corridor3: Path, open_fmu: Opener) -> None:
    one = hauled(open_fmu, corridor3, speed)
    with pytest.raises(FMICallException) as caught:
        one.run(0.0, 1000.0, 1.0, ["carriage.x"])
    assert caught.value.status == 3
    assert "carriage is at the end of its path" in one.log[-1]
    time, last = one.get("time", "carriage.x")
    assert last == pytest.approx(x, abs=1.1)
    one.set(mainline__speed=-speed)
    one.step(time, 1.0)  # back is free


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rig", "payload", "start", "end"),
    [
        (corridor(rw.live_skyline), 2500.0, 345.0, 150.0),
        (corridor(haulback_block=rw.Block("block", at=(470.0, 0.0, -60.0))), 500.0, 150.0, 345.0),
        (corridor(supports=[], haulback=None, haulback_tension=None), 500.0, 300.0, 100.0),
        (corridor(haulback=None, haulback_tension=None), 0.0, 345.0, 120.0),
    ],
    ids=["live", "haulback over a block", "one span", "runs over its shoes at once"],
)
def test_other_rigs(rig: rw.SkylineRig, payload: float, start: float, end: float, tmp_path: Path) -> None:
    path = export(rig, tmp_path / "rig.fmu", "3.0", station=start, payload=payload)
    assert validate_fmu(str(path)) == []
    run = rw.inhaul(rig, payload=payload, start=start, end=end, speed=2.0, every=EVERY)
    for kind in ("CoSimulation", "ModelExchange"):
        assert deviation(path, kind, run, {"mainline.speed": 2.0 if end > start else -2.0}) < 1e-8, kind


def small_shoe() -> rw.SkylineRig:
    return corridor(supports=[rw.IntermediateSupport("jack", at=(160.0, 40.0), radius=0.5)])


def point_saddle() -> rw.SkylineRig:
    return corridor(supports=[rw.IntermediateSupport("jack", at=(160.0, 40.0))])


def on_ground() -> rw.SkylineRig:
    log = rw.Log("log", length=8.0, mass=1000.0, moving=-1)
    return rw.standing_skyline(
        rw.Profile([0.0, 240.0, 480.0], [0.0, -30.0, -90.0]),
        headspar=rw.HeadSpar("head", station=0.0, height=20.0),
        tailspar=rw.TailSpar("tail", station=480.0, height=20.0),
        skyline=MAIN,
        tension=20e3,
        mainline=MAIN,
        carriage=rw.Carriage("carriage", mass=450.0),
        turn=rw.Turn(log, MAIN, 6.0),
    )


@pytest.mark.parametrize(
    ("rig", "how", "cause"),
    [
        (point_saddle, {}, "point saddle of 'jack'"),
        (small_shoe, {"payload": 2500.0, "station": 345.0}, "neither rolls over the shoe of 'jack'"),
        (lambda: corridor(mainline=None), {}, "no mainline"),
        (on_ground, {}, "varying ground"),
        (corridor, {"station": 500.0}, "outside the skyline"),
        (corridor, {"payload": -1.0}, "payload"),
        (skyline, {"station": 100.0}, "skyline rigs only"),
    ],
)
def test_rejected_input(rig: object, how: dict[str, float], cause: str, tmp_path: Path) -> None:
    with pytest.raises(rw.InputError, match=cause):
        export(rig(), tmp_path / "rig.fmu", platforms=(), **how)  # type: ignore[operator, arg-type]
