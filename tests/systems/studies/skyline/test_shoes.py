"""Supports with a shoe of finite radius: the carriage's pull is continuous; balances by direct integration."""

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.components.clearance import least_height
from ropeway.systems.rigs.bare_skyline import bare_tension
from ropeway.systems.studies.skyline.clearances import least_rope_clearance, rope_clearance, rope_pieces
from ropeway.systems.studies.skyline.station_solver import Stations
from support import skyline_oracle as oracle

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
CABLE = oracle.Cable(3.48 * oracle.G, 34.8e6)
MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
POINTS = [(0.0, 100.0), (160.0, 40.0), (330.0, -20.0), (480.0, -70.0)]


def rig(radius: float, **how: object) -> rw.SkylineRig:
    how.setdefault("mainline", MAIN)
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=POINTS[0]),
        supports=[rw.IntermediateSupport(f"s{i}", at=POINTS[i], radius=radius) for i in (1, 2)],
        tailspar=rw.TailSpar("tail", at=POINTS[3]),
        skyline=ROPE,
        tension=70e3,
        carriage=rw.Carriage("carriage", mass=450.0),
        **how,  # type: ignore[arg-type]
    )


def test_the_tension_is_that_of_the_bare_rope_on_its_shoes() -> None:
    supports = [rw.IntermediateSupport(f"s{x:g}", at=(x, z), radius=3.0) for x, z in ((150.0, 12.0), (320.0, -18.0))]
    slack = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        supports=supports,
        tailspar=rw.TailSpar("tail", at=(450.0, -69.0)),
        skyline=ROPE,
        tension=30e3,
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    assert bare_tension(slack) == pytest.approx(30e3, rel=1e-7)


@pytest.mark.parametrize("payload", [0.0, 2500.0])
@pytest.mark.parametrize("how", [{}, {"mainline": None}, {"mainline": None, "holding": "horizontal"}])
def test_the_pull_is_continuous_over_a_shoe(payload: float, how: dict[str, object]) -> None:
    """The largest change between adjacent stations decreases with their distance. The mainline of an empty carriage
    sags so much that it touches the shoe's roller first."""
    held = rig(1.0, **how)
    coarse, fine = (rw.load_path(held, payload, np.arange(159.3, 160.7, step)) for step in (0.02, 0.005))
    assert set(fine.held_by) == {"holding" if "mainline" in how else "mainline"}
    for column in ("mainline_pull", "skyline_tension", "s1_force", "carriage_z"):
        most = [np.abs(np.diff(path[column])).max() for path in (coarse, fine)]
        assert most[1] < 0.3 * most[0], column  # a jump would not decrease
    point = rw.load_path(rig(0.0, **how), payload, [159.9, 160.1])
    assert np.abs(np.diff(point.mainline_pull)[0]) > 5.0 * np.abs(np.diff(coarse.mainline_pull)).max()


def test_the_pull_is_continuous_under_a_guyed_spar_too() -> None:
    """At one point of a shoe the carriage would jump with the drum at rest: its own balance is unstable there, not that
    of the spar."""
    anchors = {"g1": (-25.0, -15.0), "g2": (-25.0, 15.0), "g3": (20.0, 18.0), "g4": (20.0, -18.0)}
    rope = rw.Rope(mass_per_length=2.0, axial_stiffness=20e6, breaking_load=400e3)
    guys = tuple(rw.Guyline(name, rope=rope, at=(*at, 85.0), pretension=15e3) for name, at in anchors.items())
    held = rw.standing_skyline(
        None,
        headspar=rw.GuyedSpar("head", foot=(0.0, 85.0), height=15.0, guylines=guys),
        supports=[rw.IntermediateSupport("jack", at=(260.0, 24.0), radius=1.5)],
        tailspar=rw.TailSpar("tail", at=(480.0, -37.0)),
        skyline=ROPE,
        tension=70e3,
        mainline=MAIN,
        haulback=MAIN,
        haulback_tension=8e3,
        haulback_block=rw.Block("block", at=(482.0, -43.0)),
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    path = rw.load_path(held, 1500.0, np.arange(259.5, 260.5, 0.02))
    assert np.abs(np.diff(path.mainline_pull, 2)).max() < 60.0
    assert len(rw.inhaul(held, payload=1500.0, start=262.0, end=258.0).events) == 2


def test_a_small_radius_converges_to_a_point() -> None:
    stations = [40.0, 150.0, 170.0, 300.0, 400.0]
    there = rw.load_path(rig(0.0), 2500.0, stations)
    small = [rw.load_path(rig(radius), 2500.0, stations) for radius in (1e-2, 1e-3)]
    for column in ("carriage_z", "skyline_tension", "mainline_pull", "s1_force"):
        error = [np.abs(path[column] / there[column] - 1.0).max() for path in small]
        assert error[1] < 0.11 * error[0]  # first order in the radius
        # Extrapolated to zero radius, with a second-order error.
        limit = (10.0 * small[1][column] - small[0][column]) / 9.0
        np.testing.assert_allclose(limit, there[column], rtol=1e-9)


@pytest.mark.parametrize("station", [159.6, 159.8, 160.0, 160.2])
def test_on_the_shoe_against_direct_integration(station: float) -> None:
    """Each integrated rope piece ends on the shoe and tangent to it. The moments of rope ends and load about the centre
    of the shoe balance, as the shoe itself has no moment."""
    found = Stations(rig(1.0)).solve(station, 2500.0)
    support = found.at.rig.supports[0]
    assert found.at.on == 0
    assert found["carriage.shoe_force"] > 0.0
    place = np.array([found["carriage.x"], found["carriage.z"]])
    assert np.hypot(*(place - support.centre)) == pytest.approx(1.0, abs=1e-11)
    moment = -2950.0 * oracle.G * (place[0] - support.centre[0])
    total = 0.0
    for r, role in enumerate(found.at.roles):
        run = found.at.model.runs[r]
        weight, stiffness = run.rope.mass_per_length * oracle.G, 1.0 / run.rope.strain.c1
        cable = oracle.Cable(weight, stiffness)
        for k, span in enumerate(run.spans):
            if "carriage" not in (run.nodes[k].name, run.nodes[k + 1].name):
                continue
            start, force = found.start(r, k)[[0, 2]], np.array(found.at.curve(found.point, k, r))[[0, 2]]
            end, last = cable.run(start, force, found[f"{span.name}.length"])
            leaves = run.nodes[k].name == "carriage"
            at, pull = (start, force) if leaves else (end, -last)
            arm = at - support.centre
            assert np.hypot(*arm) == pytest.approx(1.0, abs=1e-9)
            moment += arm[0] * pull[1] - arm[1] * pull[0]
            if role == "skyline":
                total += found[f"{span.name}.length"]
                if np.hypot(*(at - place)) > 1e-9:  # it touches the shoe, and leaves it tangentially
                    assert arm @ pull == pytest.approx(0.0, abs=1e-4)
                    arc = np.arccos(np.clip(arm @ (place - support.centre), -1.0, 1.0))
                    total += arc / (1.0 + np.hypot(*pull) / stiffness)
    assert moment == pytest.approx(0.0, abs=1e-3)
    # The skyline's length: the pieces at the carriage, the rope on the shoe, and the other spans.
    total += found["s2_tail.length"]
    total += found["s2.a_rope"] - found["s2.b_rope"]
    assert total == pytest.approx(found.at.rig.length, abs=1e-8)


def test_a_rope_over_a_shoe_against_direct_integration() -> None:
    shoe = rw.IntermediateSupport("jack", at=(100.0, 15.0), radius=2.0, slope=0.03)
    s = rw.System("shoe")
    s.string(ROPE, rw.HeadSpar("a", at=(0.0, 0.0)), shoe, rw.TailSpar("b", at=(200.0, -5.0)), length=203.6)
    eq = rw.equilibrium(s)
    centre, length = np.array(shoe.centre), eq["a_jack.length"] + eq["jack_b.length"]
    force = np.array([eq["a_jack.horizontal"], -eq["a_jack.vertical_a"]])
    on, last = CABLE.run(np.zeros(2), force, eq["a_jack.length"])
    assert np.hypot(*(on - centre)) == pytest.approx(2.0, abs=1e-10)
    assert (on - centre) @ last == pytest.approx(0.0, abs=1e-5)
    shape = eq.profile("jack_b", [0.0, eq["jack_b.length"]])
    np.testing.assert_allclose(shape[["x", "z"]].iloc[-1], [200.0, -5.0], atol=1e-9)
    tension = np.hypot(*last)
    way = -np.array([eq["jack_b.horizontal"], eq["jack_b.vertical_b"]])  # from b backwards
    back, first = CABLE.run(np.array([-200.0, -5.0]), np.array([-way[0], way[1]]), eq["jack_b.length"])
    off = np.array([-back[0], back[1]])
    assert np.hypot(*(off - centre)) == pytest.approx(2.0, abs=1e-9)
    assert np.hypot(*first) == pytest.approx(tension, rel=1e-12)
    turned = np.arccos((on - centre) @ (off - centre) / 4.0)
    assert eq["jack.wrap"] == pytest.approx(turned, rel=1e-9)
    assert length + 2.0 * turned / (1.0 + tension / 34.8e6) == pytest.approx(203.6, abs=1e-9)


@pytest.mark.parametrize(("start", "end"), [(345.0, 150.0), (150.0, 345.0)])
def test_a_run_over_shoes_is_the_load_path(start: float, end: float) -> None:
    held = rig(3.0, haulback=MAIN, haulback_tension=6e3)
    run = rw.inhaul(held, payload=2500.0, start=start, end=end, speed=1.0, every=0.4)
    frame = run.frame
    assert (frame.carriage_x.diff().dropna() * np.sign(end - start) > 0.0).all()
    on = frame[(frame.carriage_x - 160.0).abs() < 0.5]
    assert len(on) >= 2
    some = pd.concat([frame.iloc[::5], on])
    path = rw.load_path(held, 2500.0, some.carriage_x.to_numpy())
    for column in ("carriage_z", "skyline_tension", "headspar_tension", "mainline_pull", "s1_force"):
        np.testing.assert_allclose(some[column], path[column], rtol=1e-6)
    order = ["s2", "s1"] if end < start else ["s1", "s2"]
    assert list(run.events.event) == [f"{what} {name}" for name in order for what in ("reaches", "leaves")]


def test_with_a_long_mainline_the_carriage_jumps_over_a_small_shoe() -> None:
    """350 m of mainline stretch by 0.5 m with the change of the pull, more than the width of the shoe."""
    held = rig(1.0, haulback=MAIN, haulback_tension=6e3)
    run = rw.inhaul(held, payload=2500.0, start=345.0, end=300.0, speed=1.0, every=0.5)
    assert list(run.events.event) == ["reaches s2", "leaves s2"]
    path = rw.load_path(held, 2500.0, run.frame.carriage_x.to_numpy())
    np.testing.assert_allclose(run.frame.mainline_pull, path.mainline_pull, rtol=1e-6)


def test_payload_and_clamped_carriage_over_a_shoe() -> None:
    study = rw.payload(rig(1.0), safety_factor=3.0, stations=[159.5, 160.0, 160.5])
    assert (study.frame.payload > 1000.0).all()
    steps = rw.load_path(rig(1.0), study.frame.payload.iloc[1], [160.0]).iloc[0]
    assert steps.mainline_tension == pytest.approx(120e3 / 3.0, rel=1e-6)
    clamped = rig(1.0, mainline=None)
    clamped = rw.standing_skyline(
        None,
        headspar=clamped.headspar,
        supports=clamped.supports,
        tailspar=clamped.tailspar,
        skyline=ROPE,
        tension=70e3,
        carriage=rw.Carriage("carriage", mass=450.0, clamped=True),
    )
    rows = rw.load_path(clamped, 2500.0, np.arange(159.4, 160.6, 0.02))
    assert np.abs(np.diff(rows.skyline_tension)).max() < 1e3
    np.testing.assert_allclose(rows.carriage_x, rows.station, atol=1e-9)


@pytest.mark.parametrize(
    ("how", "words"),
    [({"radius": -1.0}, "radius"), ({"radius": 1.0, "slope": np.nan}, "slope")],
)
def test_bad_shoes_are_rejected(how: dict[str, float], words: str) -> None:
    with pytest.raises(rw.InputError, match=words):
        rw.IntermediateSupport("jack", at=(0.0, 0.0), **how)
    with pytest.raises(rw.InputError, match="radius and friction"):
        rw.standing_skyline(
            None,
            headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
            supports=[rw.IntermediateSupport("jack", at=(100.0, 5.0), radius=1.0, friction=0.1)],
            tailspar=rw.TailSpar("tail", at=(200.0, 0.0)),
            skyline=ROPE,
            tension=50e3,
            carriage=rw.Carriage("carriage", mass=450.0),
        )


def test_lower_bound_of_the_clearance_over_shoes() -> None:
    """The bound of a payload search counts from the rope's contact with a shoe, not from the start of the next span."""
    ground = rw.Profile([0.0, 90.0, 150.0, 240.0], [30.0, 26.0, 14.0, 8.0])
    rig = rw.standing_skyline(
        ground,
        headspar=rw.HeadSpar("head", station=0.0, height=11.0),
        supports=[rw.IntermediateSupport("s1", station=130.0, height=10.0, radius=3.0)],
        tailspar=rw.TailSpar("tail", station=240.0, height=12.0),
        skyline=rw.Rope(mass_per_length=2.1, axial_stiffness=22e6, breaking_load=360e3),
        carriage=rw.Carriage("carriage", mass=300.0),
        tension=55e3,
    )
    stations = Stations(rig)
    for station in (40.0, 100.0, 131.0, 180.0):
        found = stations.solve(station, 900.0)
        heights = [least_height(ground, piece).height for piece in rope_pieces(found, "skyline")]
        assert least_rope_clearance(found, ground) <= min(heights) + 1e-9
        assert rope_clearance(found, ground) == pytest.approx(min(heights), abs=1e-12)
