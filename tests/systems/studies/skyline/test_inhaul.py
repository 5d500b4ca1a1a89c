"""A skyline rig over time: statics at every instant, events, power, and rejected arguments."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)


def rig(**how: object) -> rw.SkylineRig:
    parts: dict[str, object] = {
        "supports": [rw.IntermediateSupport("s1", at=(160.0, 40.0)), rw.IntermediateSupport("s2", at=(330.0, -20.0))],
        "mainline": MAIN,
        "haulback": MAIN,
        "haulback_tension": 6e3,
        "carriage": rw.Carriage("carriage", mass=450.0),
    }
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 100.0)),
        tailspar=rw.TailSpar("tail", at=(480.0, -70.0)),
        skyline=ROPE,
        tension=70e3,
        **{**parts, **how},  # type: ignore[arg-type]
    )


@pytest.mark.parametrize(("start", "end"), [(430.0, 40.0), (40.0, 430.0)])
def test_a_full_run_over_two_supports_is_the_load_path(start: float, end: float) -> None:
    run = rw.inhaul(rig(), payload=2500.0, start=start, end=end, speed=3.0, every=4.0)
    frame = run.frame
    assert (frame.carriage_x.iloc[0], frame.carriage_x.iloc[-1]) == pytest.approx((start, end), abs=1e-6)
    path = rw.load_path(rig(), 2500.0, frame.carriage_x.to_numpy())
    assert (path.held_by == "mainline").all()
    for column in ("carriage_z", "skyline_tension", "headspar_tension", "tailspar_tension", "mainline_pull"):
        np.testing.assert_allclose(frame[column], path[column], rtol=1e-6)
    assert [e for e in run.events.event if e.startswith("reaches")] == (
        ["reaches s2", "reaches s1"] if end < start else ["reaches s1", "reaches s2"]
    )
    # Inhaul takes power at the mainline's drum and returns some at the haulback's; outhaul does the reverse.
    sign = 1.0 if end < start else -1.0
    assert (sign * frame.drum_power > 0.0).all()
    assert (sign * frame.haulback_power < 0.0).all()


@pytest.mark.parametrize(
    ("how", "payload"), [({}, 2500.0), ({}, 4000.0), ({"haulback": None, "haulback_tension": None}, 2500.0)]
)
def test_over_shoes_with_a_large_move_of_the_carriage_for_little_rope(how: dict[str, object], payload: float) -> None:
    """Near a shoe, Newton's method from a distant solution fails, or converges to a mainline of negative length."""
    supports = [
        rw.IntermediateSupport(name, at=at, radius=3.0) for name, at in (("s1", (160.0, 40.0)), ("s2", (330.0, -20.0)))
    ]
    run = rw.inhaul(rig(supports=supports, **how), payload=payload, start=430.0, end=60.0, speed=3.0)
    frame = run.frame
    assert run.events.event.tolist() == [f"{what} {name}" for name in ("s2", "s1") for what in ("reaches", "leaves")]
    path = rw.load_path(rig(supports=supports, **how), payload, frame.carriage_x.to_numpy())
    for column in ("carriage_z", "skyline_tension", "headspar_tension", "mainline_pull"):
        np.testing.assert_allclose(frame[column], path[column], rtol=1e-6)


def test_work_of_the_drums_is_the_energy_of_the_load() -> None:
    """Between two times in one span, the drums' work equals the energy gained by load and ropes. With light, stiff
    ropes it is almost only the height of the load."""
    light = rw.Rope(mass_per_length=1e-3, axial_stiffness=1e10, breaking_load=1e6)
    alone = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 100.0)),
        tailspar=rw.TailSpar("tail", at=(300.0, 0.0)),
        skyline=light,
        length=322.0,
        mainline=light,
        carriage=rw.Carriage("carriage", mass=500.0),
    )
    frame = rw.inhaul(alone, payload=2000.0, start=200.0, end=120.0, speed=2.0, every=0.25).frame
    work = np.trapezoid(frame.drum_power, frame.index)
    gained = 2500.0 * 9.80665 * (frame.carriage_z.iloc[-1] - frame.carriage_z.iloc[0])
    assert work == pytest.approx(gained, rel=1e-4)


def test_a_payload_drop_is_an_event() -> None:
    run = rw.inhaul(rig(), payload=2500.0, start=300.0, end=200.0, speed=2.0, every=5.0, changes=[(12.0, 0.0)])
    at_drop = run.frame.loc[12.0]
    assert list(at_drop.payload) == [2500.0, 0.0]
    assert at_drop.carriage_z.iloc[1] > at_drop.carriage_z.iloc[0] + 1.0
    after = run.frame[run.frame.payload == 0.0]
    path = rw.load_path(rig(), 0.0, after.carriage_x.to_numpy())
    np.testing.assert_allclose(after.highest_tension, path.highest_tension, rtol=1e-6)
    assert "payload 0 kg" in set(run.events.event)


def test_a_carriage_with_inertia_swings_about_its_inhaul_in_balance() -> None:
    run = {"payload": 2500.0, "start": 260.0, "end": 246.0, "speed": 2.0, "every": 0.25, "changes": [(3.0, 0.0)]}
    quasi = rw.inhaul(rig(), **run).frame  # type: ignore[arg-type]
    frame = rw.inhaul(rig(), **run, inertia=rw.Inertia(), tolerance=1e-6).frame  # type: ignore[arg-type]
    before, after = frame[frame.payload > 0.0], frame[frame.payload == 0.0]
    np.testing.assert_allclose(before.carriage_x, quasi[quasi.payload > 0.0].carriage_x, atol=0.02)
    np.testing.assert_allclose(before.highest_tension, quasi[quasi.payload > 0.0].highest_tension, rtol=2e-3)
    # The payload leaves the carriage where it is; without its weight it rebounds beyond its height in balance.
    still = ["carriage_x", "carriage_z", "highest_tension", "carriage_speed"]
    assert after[still].iloc[0].to_numpy() == pytest.approx(before[still].iloc[-1].to_numpy(), rel=1e-6)
    assert after.carriage_z.max() > quasi[quasi.payload == 0.0].carriage_z.max() + 2.0
    assert after.highest_tension.min() < 0.9 * quasi.highest_tension.min()


def test_a_carriage_with_inertia_over_a_saddle_is_the_same_in_compiled_code() -> None:
    run = {"payload": 900.0, "start": 165.0, "end": 150.0, "every": 0.5, "changes": [(3.0, 800.0)], "tolerance": 1e-7}
    one, other = (
        rw.inhaul(rig(), **run, inertia=rw.Inertia(), compiled=compiled)  # type: ignore[arg-type]
        for compiled in (False, True)
    )
    pd.testing.assert_frame_equal(one.events, other.events, rtol=1e-6)
    assert one.events.event.tolist() == ["reaches s1", "leaves s1", "payload 800 kg"]
    pd.testing.assert_frame_equal(one.frame, other.frame, rtol=1e-4, atol=1e-6)


def test_rope_nodes_are_refused_in_an_inhaul() -> None:
    with pytest.raises(rw.InputError, match="nodes=3"):
        rw.inhaul(rig(), payload=900.0, start=44.0, end=40.0, inertia=rw.Inertia(nodes=3))


FLAT = rw.standing_skyline(
    None,
    headspar=rw.HeadSpar("head", at=(0.0, 10.0)),
    tailspar=rw.TailSpar("tail", at=(300.0, 0.0)),
    skyline=ROPE,
    tension=60e3,
    mainline=MAIN,
    carriage=rw.Carriage("carriage", mass=450.0),
)


def test_a_carriage_that_runs_ahead_stops_the_run_with_its_rows() -> None:
    with pytest.raises(rw.SimulationError, match=r"stops at station .* would have to push") as error:
        rw.inhaul(FLAT, payload=2000.0, start=60.0, end=280.0, speed=2.0, every=2.0)
    run = error.value.result
    assert isinstance(run, rw.Inhaul)
    assert run.frame.index[-1] == error.value.time
    last = run.frame.carriage_x.iloc[-1]
    assert rw.load_path(FLAT, 2000.0, [last, last + 0.2]).held_by.tolist() == ["mainline", "clamp"]
    # With more payload from an earlier time on, it reaches its end.
    on = rw.inhaul(FLAT, payload=2000.0, start=60.0, end=last + 5.0, speed=2.0, every=5.0, changes=[(70.0, 4000.0)])
    assert on.frame.carriage_x.iloc[-1] == pytest.approx(last + 5.0, abs=1e-6)


@pytest.mark.parametrize(("radius", "haulback"), [(0.0, 10e3), (0.5, 14e3), (1.5, 10e3), (1.5, 14e3)])
def test_a_carriage_that_runs_ahead_at_a_support_stops_there(radius: float, haulback: float) -> None:
    """Downhill over a support, with a haulback that brakes too little beyond it."""
    steep = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
        supports=[rw.IntermediateSupport("jack", at=(170.0, 54.0), radius=radius)],
        tailspar=rw.TailSpar("tail", at=(450.0, 136.0)),
        skyline=ROPE,
        tension=90e3,
        mainline=MAIN,
        haulback=MAIN,
        haulback_tension=haulback,
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    with pytest.raises(rw.SimulationError, match=r"stops at station .* would have to push") as error:
        rw.inhaul(steep, payload=2500.0, start=200.0, end=60.0, speed=3.0, every=1.0)
    run = error.value.result
    assert isinstance(run, rw.Inhaul)
    assert error.value.time == pytest.approx(run.frame.index[-1], abs=1.0)
    last = run.frame.iloc[-1]
    assert last.carriage_x == pytest.approx(170.0, abs=0.7)  # at the saddle, or at the edge of its shoe
    assert last.carriage_z == pytest.approx(rw.load_path(steep, 2500.0, [last.carriage_x]).carriage_z[0], abs=1e-3)


def test_a_run_from_a_point_saddle_starts_next_to_it() -> None:
    frame = rw.inhaul(rig(), payload=2000.0, start=160.0, end=120.0, every=5.0).frame
    assert frame.carriage_x.iloc[0] == pytest.approx(rw.load_path(rig(), 2000.0, [160.0]).carriage_x.iloc[0])


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"speed": 0.0}, "speed"),
        ({"payload": -1.0}, "payload"),
        ({"changes": [(5.0, 1.0), (3.0, 1.0)]}, "changes"),
        ({"start": 700.0}, "outside the skyline"),
    ],
)
def test_bad_arguments_are_rejected(how: dict[str, object], words: str) -> None:
    arguments: dict[str, object] = {"payload": 100.0, "start": 300.0, "end": 200.0, **how}
    with pytest.raises(rw.InputError, match=words):
        rw.inhaul(rig(), **arguments)  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="no mainline"):
        rw.inhaul(rig(mainline=None, haulback=None, haulback_tension=None), payload=1.0, start=300.0, end=200.0)


@pytest.mark.parametrize("radius", [0.0, 1.5])
def test_exceeded_limits_are_events(radius: float) -> None:
    """At the first row beyond each limit, also over supports and shoes."""
    rig = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 22.0)),
        supports=[
            rw.IntermediateSupport("s1", at=(150.0, -38.0), radius=radius, capacity=20e3),
            rw.IntermediateSupport("s2", at=(260.0, -88.0), radius=radius),
        ],
        tailspar=rw.TailSpar("tail", at=(400.0, -160.0)),
        skyline=replace(ROPE, breaking_load=400e3),
        tension=120e3,
        mainline=MAIN,
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    run = rw.inhaul(rig, payload=800.0, start=380.0, end=20.0, speed=3.0, every=1.0, changes=[(40.0, 2500.0)])
    over = run.frame.highest_tension > rig.skyline.safe_working_load
    begins = over & ~over.shift(fill_value=False)
    reported = run.events.set_index("event")
    assert begins.sum() > 1
    assert reported.time["beyond skyline tension"].to_list() == begins.index[begins].to_list()
    first = int(np.searchsorted(run.frame.index, reported.time["beyond capacity of s1"]))
    most = rw.payload(rig, safety_factor=1.0, stations=run.frame.carriage_x.iloc[first - 1 : first + 1]).frame
    assert most.limited_by.iloc[1] == "capacity of s1"
    assert most.payload.iloc[0] > 2500.0 > most.payload.iloc[1]
