"""The payload study: Harvey's exact payloads, governing limits, infeasible corridors."""

from dataclasses import replace

import numpy as np
import pytest

import ropeway as rw
from support import skyline_oracle as oracle

G = 9.80665
ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
GROUND = rw.Profile([0, 100, 200, 260, 300, 400, 500], [100, 85, 70, 75, 65, 50, 52])


PARTS: dict[str, object] = {
    "headspar": rw.HeadSpar("head", station=0.0, height=15.0),
    "supports": [rw.IntermediateSupport("jack", station=260.0, height=9.0)],
    "tailspar": rw.TailSpar("tail", station=480.0, height=8.0),
    "skyline": ROPE,
    "tension": 70e3,
    "carriage": rw.Carriage("carriage", mass=450.0),
}


def corridor(**how: object) -> rw.SkylineRig:
    return rw.standing_skyline(GROUND, **{**PARTS, "mainline": MAIN, **how})  # type: ignore[arg-type]


def lowered(**how: object) -> rw.SkylineRig:
    return rw.live_skyline(GROUND, **{**PARTS, **how})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("drop", "clamped", "rolling"),
    [(0.0, 8977.45581, 8977.45581), (20.0, 8710.64822, 8837.60190), (40.0, 8385.98260, 8467.26049)],
)
def test_exact_payloads_of_harveys_profiles(drop: float, clamped: float, rolling: float) -> None:
    """Harvey 2013, 200 m spans with 0, 10 and 20 % chord slope, 25 m of deflection at mid-span, 19,600 kgf at the
    headspar, rope of 3.48 kgf/m, carriage 150 kg: exact payloads (the printed ones are off by up to 10 %)."""
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=np.inf, breaking_load=3.0 * 19_600 * G)
    ground = rw.Profile([0.0, 100.0, 200.0], [-60.0, -35.0 - drop / 2.0, -60.0 - drop])
    for clamp, exact in ((True, clamped), (False, rolling)):
        live = rw.live_skyline(
            ground,
            headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
            tailspar=rw.TailSpar("tail", at=(200.0, -drop)),
            skyline=rope,
            length=207.0 + drop / 8.0,
            carriage=rw.Carriage("carriage", mass=150.0, clamped=clamp),
            holding="horizontal",
        )
        study = rw.payload(live, safety_factor=3.0, clearance=10.0, stations=[100.0])
        assert study.payload == pytest.approx(exact, rel=2e-9)
        assert study.limiting.limited_by == "skyline tension"
        assert study.limiting.headspar_tension == pytest.approx(19_600 * G, rel=1e-10)
        assert study.limiting.carriage_z == pytest.approx(-25.0 - drop / 2.0, abs=1e-9)


@pytest.mark.parametrize("station", [40.0, 100.0, 170.0])
def test_largest_payload_against_direct_integration(station: float) -> None:
    """Equal tension on both sides, at and off mid-span: under the payload the integrated rope has exactly its safe
    working load at the headspar."""
    points = [(0.0, 0.0), (200.0, -20.0)]
    rig = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=points[0]),
        tailspar=rw.TailSpar("tail", at=points[1]),
        skyline=ROPE,
        length=204.0,
        carriage=rw.Carriage("carriage", mass=450.0),
        holding="horizontal",
    )
    found = rw.payload(rig, safety_factor=3.0, stations=[station]).limiting
    cable = oracle.Cable(3.48 * G, 34.8e6)
    exact = oracle.carriage(
        cable,
        points,
        204.0,
        0,
        station,
        (found.payload + 450.0) * G,
        holding="horizontal",
        z=found.carriage_z + 0.1,
        tension=found.skyline_tension,
    )
    assert max(exact.start, exact.end) == pytest.approx(ROPE.breaking_load / 3.0, rel=1e-8)
    assert exact.left == pytest.approx(exact.right, rel=1e-10)


def test_a_corridor_with_all_limits() -> None:
    rig = corridor()
    study = rw.payload(rig, safety_factor=3.0, clearance=1.0, stations=np.linspace(4.0, 476.0, 100))
    frame = study.frame
    assert (frame.payload > 3500.0).all()
    assert study.limiting.payload == frame.payload.min() == study.payload
    tension = frame[frame.limited_by == "skyline tension"]
    np.testing.assert_allclose(tension.highest_tension, ROPE.breaking_load / 3.0, rtol=1e-9)
    main = frame[frame.limited_by == "mainline tension"]
    assert len(main) > 0
    np.testing.assert_allclose(main.mainline_tension, MAIN.breaking_load / 3.0, rtol=1e-9)
    for _, found in frame.iloc[::9].iterrows():
        again = rw.load_path(rig, found.payload, [found.station]).iloc[0]
        assert again.highest_tension == pytest.approx(found.highest_tension, rel=1e-8)


def test_clearance_governs_near_the_ground() -> None:
    study = rw.payload(corridor(mainline=None), safety_factor=3.0, clearance=3.5, stations=[95.0, 100.0, 150.0])
    low = study.frame.iloc[1]
    assert low.limited_by == "clearance"
    assert low.clearance == pytest.approx(3.5, abs=1e-9)
    higher = rw.payload(corridor(mainline=None), clearance=3.5, rope_clearance=3.8, stations=[100.0])
    assert higher.limiting.limited_by == "rope clearance"
    assert higher.limiting.rope_clearance == pytest.approx(3.8, abs=1e-9)
    assert study.limiting.payload == study.frame.payload.min()


def test_lift_off_governs_at_a_saddle_in_a_hollow() -> None:
    low = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 20.0)),
        supports=[rw.IntermediateSupport("jack", at=(150.0, -1.0))],
        tailspar=rw.TailSpar("tail", at=(300.0, 0.0)),
        skyline=ROPE,
        tension=40e3,
        carriage=rw.Carriage("carriage", mass=300.0),
    )
    study = rw.payload(low, stations=[225.0])
    assert study.limiting.limited_by == "lift-off at jack"
    assert study.limiting.jack_force <= 1e-6
    assert rw.payload(low, stations=[225.0], lift_off=False).payload > 1000.0


def test_capacities_govern() -> None:
    weak = rw.Tailhold("stump", station=495.0, height=0.0, capacity=110e3)
    rig = corridor(tailspar=rw.TailSpar("tail", station=480.0, height=8.0, tailhold=weak))
    study = rw.payload(rig, stations=[100.0])
    assert study.limiting.limited_by == "capacity of stump"
    assert study.limiting.anchor_tension == pytest.approx(110e3, rel=1e-9)
    jack = rw.IntermediateSupport("jack", station=260.0, height=9.0, capacity=30e3)
    study = rw.payload(corridor(supports=[jack]), stations=[230.0])
    assert study.limiting.limited_by == "capacity of jack"
    head = rw.HeadSpar("head", station=0.0, height=15.0, capacity=120e3)
    assert rw.payload(corridor(headspar=head), stations=[100.0]).limiting.limited_by == "capacity of head"


def test_load_on_a_tailspar_includes_the_haulbacks_drum() -> None:
    tail = rw.TailSpar("tail", station=480.0, height=8.0, capacity=140e3)
    rig = corridor(tailspar=tail, haulback=MAIN, haulback_tension=20e3)
    study = rw.payload(rig, stations=[400.0])
    assert study.limiting.limited_by == "capacity of tail"
    eq = rw.equilibrium(
        rig.system(1, 400.0, payload=study.payload), given={"carriage.x": 400.0}, solve_for="mainline.travel"
    )
    sky = np.array([eq["carriage_tail.force_x"], eq["carriage_tail.force_z"] + 3.48 * G * eq["carriage_tail.length"]])
    haul = np.array([eq["haulback_carriage.force_x"], eq["haulback_carriage.force_z"]])
    assert np.linalg.norm(haul - sky) == pytest.approx(140e3, rel=1e-8)


def test_load_on_a_jack_includes_the_mainline() -> None:
    jack = rw.IntermediateSupport("jack", station=260.0, height=9.0, capacity=30e3)
    study = rw.payload(corridor(supports=[jack]), stations=[330.0])
    assert study.limiting.limited_by == "capacity of jack"
    eq = rw.equilibrium(
        corridor().system(1, 330.0, payload=study.payload), given={"carriage.x": 330.0}, solve_for="mainline.travel"
    )
    up = eq["jack.support_force"] + eq["jack_mainline.support_force"]
    assert eq["jack_mainline.support_force"] > 500.0
    assert eq["jack.bearing_load"] < 29.5e3 < up < 30e3
    # A very small shoe gives the same result.
    shod = rw.payload(corridor(supports=[replace(jack, radius=0.01)]), stations=[330.0])
    assert shod.payload == pytest.approx(study.payload, rel=2e-3)


def test_a_mainline_is_tightest_at_a_carriage_above_its_drum() -> None:
    rig = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
        tailspar=rw.TailSpar("tail", at=(300.0, 120.0)),
        skyline=ROPE,
        tension=80e3,
        mainline=MAIN,
        haulback=MAIN,
        haulback_tension=20e3,
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    row = rw.load_path(rig, 0.0, [200.0]).iloc[0]
    low, high = (t + t * t / 2.0 / 8e6 for t in (row.mainline_tension, row.mainline_highest))
    assert high - low == pytest.approx(0.73 * G * row.carriage_z, rel=1e-9)
    assert row.mainline_highest == pytest.approx(row.mainline_pull, rel=1e-12)
    weak = replace(MAIN, breaking_load=1.5 * (row.mainline_tension + row.mainline_highest))
    study = rw.payload(replace(rig, mainline=weak), stations=[200.0])
    assert (study.payload, study.limiting.limited_by) == (0.0, "mainline tension")


def test_representations_are_short() -> None:
    study = rw.payload(corridor(), stations=[100.0])
    assert repr(GROUND) == "<Profile of 7 points, 0 to 500 m>"
    assert repr(study.rig) == "<SkylineRig 'standing skyline': head at 0 m, jack at 260 m, tail at 480 m>"
    assert repr(study).endswith("kg, limited at 100 m by skyline tension>")


def test_an_infeasible_corridor_is_a_result() -> None:
    study = rw.payload(corridor(), clearance=30.0, stations=[100.0, 200.0])
    assert study.payload == 0.0
    assert "clearance" in study.limiting.limited_by
    tight = rw.payload(corridor(tension=300e3), safety_factor=3.0, stations=[100.0])
    assert (tight.payload, tight.limiting.limited_by) == (0.0, "skyline tension")


def test_live_and_running_skylines_keep_the_clearance() -> None:
    live = lowered(supports=[], tailspar=rw.TailSpar("tail", station=240.0, height=10.0), mainline=MAIN)
    double = rw.Rope(mass_per_length=1.4, axial_stiffness=15e6, breaking_load=256e3)
    running = rw.running_skyline(
        GROUND,
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        tailspar=rw.TailSpar("tail", station=240.0, height=10.0),
        haulback=double,
        mainline=double,
        tension=40e3,
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    for rig in (live, running):
        study = rw.payload(rig, safety_factor=3.0, clearance=2.0, stations=[30.0, 80.0, 120.0, 200.0])
        frame = study.frame
        np.testing.assert_allclose(frame.clearance, 2.0, atol=1e-9)
        assert (frame.payload > 500.0).all()
        assert set(frame.limited_by) <= {"skyline tension", "haulback tension", "mainline tension"}
        path = rw.load_path(rig, 500.0, [30.0, 120.0], height=4.0)
        np.testing.assert_allclose(path.clearance, 4.0, atol=1e-9)


def test_a_height_above_the_chord_is_an_error() -> None:
    live = lowered(supports=[], tailspar=rw.TailSpar("tail", station=240.0, height=10.0))
    study = rw.payload(live, clearance=60.0, stations=[120.0])
    assert (study.payload, study.limiting.limited_by) == (0.0, "clearance")
    with pytest.raises(rw.OutOfReachError, match=r"the chord of its span is at 99\.1667 m"):
        rw.load_path(live, 1000.0, [120.0], height=60.0)


def test_lowest_position_of_a_live_skyline_over_a_jack() -> None:
    """Next to the saddle no tension lowers the carriage to the clearance: it stays higher and carries a payload."""
    live = lowered()
    study = rw.payload(live, clearance=1.0, stations=[100.0, 259.0, 260.0, 261.0, 380.0])
    assert (study.frame.payload > 2000.0).all()
    assert study.frame.clearance[[0, 4]].to_numpy() == pytest.approx(1.0, abs=1e-9)
    assert (study.frame.clearance[1:4] > 2.0).all()
    assert study.frame.highest_tension.max() <= 576.6e3 / 3.0 * (1.0 + 1e-9)
    # Slightly lower the empty carriage has no equilibrium.
    lowest = study.frame.clearance[1]
    rw.load_path(live, 0.0, [259.0], height=lowest)
    with pytest.raises(rw.EquilibriumError):
        rw.load_path(live, 0.0, [259.0], height=lowest - 0.05)
    # The figure has the same heights: the payload of the corridor keeps the limit at all stations.
    (line,) = (line for line in study.plot().axes[2].lines if line.get_label() == "skyline, highest")
    assert np.max(line.get_ydata()) == pytest.approx(576.6 / 3.0, rel=1e-6)


def test_gravity_skyline_needs_its_carriage_to_run_out() -> None:
    def rig(tail: float) -> rw.SkylineRig:
        return rw.gravity_skyline(
            rw.Profile([0.0, 150.0, 300.0], [0.0, -60.0 + tail / 2.0, tail]),
            headspar=rw.HeadSpar("head", station=0.0, height=15.0),
            tailspar=rw.TailSpar("tail", station=300.0, height=10.0),
            skyline=ROPE,
            mainline=MAIN,
            tension=60e3,
            carriage=rw.Carriage("carriage", mass=450.0),
        )

    steep = rw.payload(rig(-120.0), clearance=15.0, stations=[100.0, 200.0])
    assert (steep.frame.payload > 1000.0).all()
    flat = rw.payload(rig(0.0), clearance=15.0, stations=[250.0])
    assert (flat.payload, flat.limiting.limited_by) == (0.0, "does not run out by gravity")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tailspar": rw.TailSpar("tail", at=(480.0, 0.0))}, "below the ground"),
        ({"tailspar": rw.TailSpar("tail", station=520.0, height=8.0)}, "outside the profile"),
        ({"tailspar": rw.TailSpar("tail", station=100.0, height=8.0)}, "order of their stations"),
        ({"tension": None, "length": 400.0}, "minimum breaking load"),
        ({"tension": 1e6}, "minimum breaking load"),
        ({"tension": 70e3, "length": 500.0}, "either length or tension"),
        ({"haulback": MAIN}, "haulback_tension"),
    ],
)
def test_bad_rigs_are_rejected(change: dict[str, object], words: str) -> None:
    with pytest.raises(rw.InputError, match=words) as error:
        corridor(**change)
    assert error.value.remedy


def test_bad_arguments_are_rejected() -> None:
    rig = corridor()
    with pytest.raises(rw.InputError, match="payload"):
        rw.load_path(rig, -1.0, [100.0])
    with pytest.raises(rw.InputError, match="outside the skyline"):
        rw.load_path(rig, 1.0, [500.0])
    for wrong in ([], "abc", [[100.0]], [None]):
        with pytest.raises(rw.InputError, match="station"):
            rw.load_path(rig, 1.0, wrong)  # type: ignore[arg-type]
        with pytest.raises(rw.InputError, match="station"):
            rw.payload(rig, stations=wrong)  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="cannot be lowered or raised"):
        rw.load_path(rig, 1.0, [100.0], height=3.0)
    with pytest.raises(rw.InputError, match="safety_factor"):
        rw.payload(rig, safety_factor=0.0)
    with pytest.raises(rw.InputError, match="stands 2 m below"):
        rw.TailSpar("tail", station=1.0, height=-2.0)
    with pytest.raises(rw.InputError, match="no position"):
        rw.TailSpar("tail")


def guyed(heights: float, behind: float) -> rw.SkylineRig:
    """A rig with a guyed headspar; its guylines have anchors at a height z and a distance behind it [m]."""
    guy = rw.Rope(mass_per_length=2.0, axial_stiffness=20e6, breaking_load=250e3)
    guys = tuple(
        rw.Guyline(f"g{i}", rope=guy, at=(-behind, y, heights), pretension=10e3) for i, y in enumerate((-12.0, 12.0), 1)
    )
    head = rw.GuyedSpar("head", foot=(0.0, 0.0), height=15.0, guylines=guys)
    return rw.standing_skyline(
        None,
        headspar=head,
        tailspar=rw.TailSpar("tail", at=(250.0, 60.0)),
        skyline=ROPE,
        length=262.0,
        carriage=rw.Carriage("carriage", mass=450.0),
    )


def test_the_first_of_symmetric_guylines_governs() -> None:
    frame = rw.payload(guyed(-2.0, 20.0), safety_factor=3.0, stations=np.linspace(20.0, 230.0, 15)).frame
    assert set(frame.limited_by) == {"guyline g1"}


def test_a_guyed_spar_must_stay_on_its_foot() -> None:
    """Its anchors are above its top and the skyline rises: a small load lifts it."""
    rig = guyed(40.0, 15.0)
    frame = rw.payload(rig, safety_factor=3.0, stations=[40.0]).frame
    assert (frame.payload[0], frame.limited_by[0]) == (0.0, "lift-off of head")
    assert rw.load_path(rig, 0.0, [40.0]).spar_compression[0] < 0.0
    assert rw.payload(rig, safety_factor=3.0, stations=[40.0], lift_off=False).frame.limited_by[0] != "lift-off of head"
