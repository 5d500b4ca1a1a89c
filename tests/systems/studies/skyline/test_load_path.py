"""The load path against direct integration, published cases, and its mirror image."""

import numpy as np
import pytest

import ropeway as rw
from ropeway.components import catenary
from ropeway.systems.studies.skyline.station_solver import Stations
from support import skyline_oracle as oracle

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
CABLE = oracle.Cable(3.48 * oracle.G, 34.8e6)


def rig(points: list[tuple[float, float]], length: float, **how: object) -> rw.SkylineRig:
    between = [rw.IntermediateSupport(f"s{i}", at=p) for i, p in enumerate(points[1:-1], 1)]
    how.setdefault("carriage", rw.Carriage("carriage", mass=450.0))
    return rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=points[0]),
        supports=between,
        tailspar=rw.TailSpar("tail", at=points[-1]),
        skyline=ROPE,
        length=length,
        **how,  # type: ignore[arg-type]
    )


@pytest.mark.parametrize("holding", ["horizontal", "bisector"])
@pytest.mark.parametrize("station", [12.0, 60.0, 100.0, 155.0, 190.0])
def test_rolling_carriage_against_direct_integration(station: float, holding: str) -> None:
    points = [(0.0, 0.0), (200.0, -20.0)]
    row = rw.load_path(rig(points, 207.0, holding=holding), payload=3000.0, stations=[station]).iloc[0]
    found = oracle.carriage(
        CABLE,
        points,
        207.0,
        0,
        station,
        3450.0 * oracle.G,
        holding=holding,
        z=row.carriage_z + 0.3,
        tension=1.05 * row.skyline_tension,
    )
    assert row.carriage_z == pytest.approx(found.z, rel=1e-8)
    assert row.skyline_tension == pytest.approx(found.left, rel=1e-8)
    assert row.skyline_tension == pytest.approx(found.right, rel=1e-8)
    assert row.headspar_tension == pytest.approx(found.start, rel=1e-8)
    assert row.tailspar_tension == pytest.approx(found.end, rel=1e-8)
    assert row.mainline_pull == pytest.approx(found.holding, rel=1e-8)
    assert row.sag == pytest.approx(-20.0 * station / 200.0 - found.z, rel=1e-8)
    assert row.deflection == pytest.approx(row.sag / 2.0)


@pytest.mark.parametrize("station", [60.0, 130.0])
def test_clamped_carriage_against_direct_integration(station: float) -> None:
    points = [(0.0, 0.0), (200.0, -20.0)]
    clamped = rig(points, 205.0, carriage=rw.Carriage("carriage", mass=450.0, clamped=True))
    row = rw.load_path(clamped, payload=2000.0, stations=[station]).iloc[0]
    found = oracle.carriage(
        CABLE,
        points,
        205.0,
        0,
        station,
        2450.0 * oracle.G,
        holding="clamp",
        z=row.carriage_z + 0.2,
        tension=row.skyline_tension,
    )
    assert row.carriage_z == pytest.approx(found.z, rel=1e-8)
    assert row.skyline_tension == pytest.approx(max(found.left, found.right), rel=1e-8)
    assert row.headspar_tension == pytest.approx(found.start, rel=1e-8)
    assert row.tailspar_tension == pytest.approx(found.end, rel=1e-8)
    assert row.held_by == "clamp"


@pytest.mark.parametrize(("span", "station"), [(0, 70.0), (1, 150.0), (2, 330.0)])
def test_three_spans_against_direct_integration(span: int, station: float) -> None:
    points = [(0.0, 10.0), (120.0, 6.0), (250.0, -8.0), (360.0, -30.0)]
    row = rw.load_path(rig(points, 365.0), payload=2500.0, stations=[station]).iloc[0]
    found = oracle.carriage(
        CABLE,
        points,
        365.0,
        span,
        station,
        2950.0 * oracle.G,
        holding="bisector",
        z=row.carriage_z + 0.1,
        tension=row.skyline_tension,
    )
    assert row.span == span + 1
    assert row.carriage_z == pytest.approx(found.z, rel=1e-8)
    assert row.skyline_tension == pytest.approx(found.left, rel=1e-8)
    assert row.anchor_tension == pytest.approx(found.end, rel=1e-8)
    assert row.mainline_pull == pytest.approx(found.holding, rel=1e-8)


def test_sap2000_through_a_clamped_carriage() -> None:
    """SAP2000 verification 7-002 (Michalos and Birnstiel; Jayaraman and Knudson): the joint as a clamped carriage."""
    weight = 46.116733
    rope = rw.Rope(mass_per_length=weight / oracle.G, axial_stiffness=71_838_779.0, breaking_load=1e9)
    s = rw.System("SAP2000 7-002")
    carriage = rw.Carriage("joint", at=(120.0, -35.0), mass=35_585.773 / oracle.G, clamped=True)
    s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), carriage.a, length=125.846952)
    s.string(rope, carriage.b, rw.Anchor("b", at=(304.8, 0.0)), length=186.855263)
    eq = rw.equilibrium(s)
    assert eq["a_joint.horizontal"] == pytest.approx(89_441.265, rel=1e-7)
    assert eq["a_joint.vertical_a"] == pytest.approx(28_695.878, rel=1e-7)
    assert eq["joint_b.vertical_b"] == pytest.approx(21_310.699, rel=1e-7)
    assert eq["a_joint.tension_a"] == pytest.approx(93_931.855, rel=1e-7)
    assert eq["joint_b.tension_b"] == pytest.approx(91_945.015, rel=1e-7)
    assert (eq["joint.x"], eq["joint.z"]) == pytest.approx((121.060605, -34.901497), abs=1e-5)


@pytest.mark.parametrize(("extra", "sag", "tension"), [(0.0, 7.9397, 5000.0), (10.0, 13.9397, 3175.19)])
def test_code_aster_pulley_through_a_saddle(extra: float, sag: float, tension: float) -> None:
    """code_aster R3.08.05 and V6.02.100 (SSNL100): two level 100 m spans over a pulley, 10 m paid in."""
    rope = rw.Rope(mass_per_length=30.0 / oracle.G, axial_stiffness=5e7, breaking_load=1e6)
    s = rw.System("pulley")
    over = [
        rw.HeadSpar("a", at=(0.0, 0.0)),
        rw.IntermediateSupport("pulley", at=(100.0, 0.0)),
        rw.TailSpar("b", at=(200.0, 0.0)),
    ]
    spans = s.string(rope, *over, length=200.00064 if extra == 0.0 else 2 * 105.00032)
    if extra == 0.0:
        eq = rw.equilibrium(s, given={"a.tension": 5000.0}, solve_for="a_pulley.length")
    else:
        eq = rw.equilibrium(s)
    middle = eq.profile(spans[0].name, [eq["a_pulley.length"] / 2.0]).iloc[0]
    assert -middle.z == pytest.approx(sag, abs=6e-4 if extra == 0.0 else 6e-5)
    assert eq["a.tension"] == pytest.approx(tension, abs=0.006)
    assert eq["pulley.tension_in"] == pytest.approx(eq["pulley.tension_out"], rel=1e-12)


def test_forces_on_a_rig_with_a_real_mainline_over_rollers_sum_to_zero() -> None:
    points = [(0.0, 60.0), (240.0, 20.0), (400.0, -40.0)]
    main = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
    held = rig(points, 412.0, mainline=main)
    eq = rw.equilibrium(held.system(1, 300.0, payload=2500.0), given={"carriage.x": 300.0}, solve_for="mainline.travel")
    row = rw.load_path(held, 2500.0, [300.0]).iloc[0]
    assert row.held_by == "mainline"
    assert row.mainline_pull == pytest.approx(eq["carriage.mainline_pull"], rel=1e-10)
    assert row.carriage_z == pytest.approx(eq["carriage.z"], rel=1e-10)
    spans = ("head_s1", "s1_carriage", "carriage_tail")
    lines = ("mainline_s1_mainline", "s1_mainline_carriage")
    skyline = sum(eq[f"{name}.length"] for name in spans)
    mainline = sum(eq[f"{name}.length"] for name in lines)
    assert skyline == pytest.approx(412.0, rel=1e-12)
    up = eq["head_s1.vertical_a"] + eq["mainline_s1_mainline.vertical_a"] + eq["carriage_tail.vertical_b"]
    up += eq["s1.support_force"] + eq["s1_mainline.support_force"]
    weight = (3.48 * skyline + 0.73 * mainline + 2950.0) * oracle.G
    assert up == pytest.approx(weight, rel=1e-10)
    # Rollers and saddle are frictionless: along each rope T + T^2/2EA changes by its weight times the height.
    level = [eq["mainline.rope_tension"], eq["carriage.mainline_pull"]]
    high, low = (t + t * t / (2 * 8e6) for t in level)
    assert high - low == pytest.approx(0.73 * oracle.G * (60.0 - eq["carriage.z"]), rel=1e-8)


def test_mirror_image() -> None:
    points = [(0.0, 10.0), (120.0, 6.0), (250.0, -8.0), (360.0, -30.0)]
    mirrored = [(360.0 - x, z) for x, z in reversed(points)]
    stations = np.array([5.0, 60.0, 119.0, 121.0, 200.0, 300.0, 355.0])
    there = rw.load_path(rig(points, 366.0), 1800.0, stations)
    back = rw.load_path(rig(mirrored, 366.0), 1800.0, 360.0 - stations)
    np.testing.assert_allclose(there.carriage_z, back.carriage_z, rtol=1e-9)
    np.testing.assert_allclose(there.headspar_tension, back.tailspar_tension, rtol=1e-9)
    np.testing.assert_allclose(there.mainline_pull, -back.mainline_pull, rtol=1e-7)


def test_six_spans_and_two_hundred_stations() -> None:
    heights = [0.0, 3.0, -2.0, 4.0, 0.0, 5.0, -1.0]
    points = [(100.0 * i, z) for i, z in enumerate(heights)]
    path = rw.load_path(rig(points, 603.0), 1500.0, np.linspace(2.0, 598.0, 200))
    assert len(path) == 200
    assert (path.carriage_x - np.linspace(2.0, 598.0, 200)).abs().max() <= 0.021
    assert path.notna().drop(columns=["clearance", "rope_clearance"]).all().all()
    # Equal tension throughout the rope, except for its weight times the difference in height.
    w = 3.48 * oracle.G
    high = path.headspar_tension + path.headspar_tension**2 / (2 * 34.8e6)
    low = path.tailspar_tension + path.tailspar_tension**2 / (2 * 34.8e6)
    np.testing.assert_allclose(high - low, w * (points[0][1] - points[-1][1]), rtol=1e-7)


def test_capstan_friction_holds_rope_back() -> None:
    points = [(0.0, 0.0), (150.0, 2.0), (320.0, -6.0)]

    def tensions(friction: float) -> tuple[float, float]:
        rough = rw.standing_skyline(
            None,
            headspar=rw.HeadSpar("head", at=points[0]),
            supports=[rw.IntermediateSupport("jack", at=points[1], friction=friction)],
            tailspar=rw.TailSpar("tail", at=points[2]),
            skyline=ROPE,
            length=323.5,
            carriage=rw.Carriage("carriage", mass=450.0),
        )
        eq = rw.equilibrium(rough.system(0, 75.0, payload=2500.0))
        ratio = np.log(eq["jack.tension_in"] / eq["jack.tension_out"])
        assert ratio == pytest.approx(friction * eq["jack.wrap"], rel=1e-9, abs=1e-12)
        return eq["jack.tension_in"], eq["jack.tension_out"]

    smooth, rough = tensions(0.0), tensions(0.15)
    assert smooth[0] == pytest.approx(smooth[1], rel=1e-12)
    assert rough[1] < smooth[0] < rough[0]


@pytest.mark.parametrize("guyed", [False, True])
def test_friction_counts_from_the_bare_rope_at_any_station(guyed: bool) -> None:
    """Before, on and after a shoe; with the drum at the foot of a guyed spar."""
    points = [(0.0, 15.0), (150.0, 12.0), (320.0, 4.0), (450.0, -9.0)]
    guys = tuple(
        rw.Guyline(f"g{i}", rope=ROPE, at=at, pretension=20e3)
        for i, at in enumerate([(-20.0, -12.0, -2.0), (-20.0, 12.0, -2.0), (12.0, -20.0, -3.0), (12.0, 20.0, -3.0)])
    )
    spar = rw.GuyedSpar("head", foot=(0.0, 0.0), height=15.0, guylines=guys)
    rough = rw.live_skyline(
        None,
        headspar=spar if guyed else rw.HeadSpar("head", at=points[0]),
        supports=[
            rw.IntermediateSupport("shod", at=points[1], radius=1.5),
            rw.IntermediateSupport("rough", at=points[2], friction=0.1),
        ],
        tailspar=rw.TailSpar("tail", at=points[3]),
        skyline=ROPE,
        length=452.5,
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    bare = rw.System("bare")
    ends = [rw.Anchor("a", at=points[0]), rw.Anchor("b", at=points[3])]
    blocks = [rw.Block(f"b{i}", at=points[i]) for i in (1, 2)]
    *_, last = bare.string(ROPE, ends[0], *blocks, ends[1], length=452.5)
    distance = rw.equilibrium(bare)[f"{last.name}.length"]
    places, stations = set(), Stations(rough)
    for station in (40.0, 149.2, 150.0, 150.3, 152.0, 200.0):
        found = stations.solve(station, 2500.0)
        places.add((found.at.span, found.at.on))
        assert found["rough.travel"] - found["rough.grip"] == pytest.approx(
            found["rough_tail.length"] - distance, abs=1e-8
        )
    assert places == {(0, None), (0, 0), (1, None)}


@pytest.mark.parametrize(("payload", "distance"), [(5000.0, 0.2), (8000.0, 0.02), (10_000.0, 0.03)])
def test_a_station_close_to_a_saddle_is_solved_directly(payload: float, distance: float) -> None:
    """The mainline pulls hard there and geometry is a poor guess. Continuation from mid-span gives the same state."""
    points = [(0.0, 100.0), (160.0, 40.0), (330.0, -20.0), (480.0, -70.0)]
    main = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
    direct, continued = (
        rw.load_path(rig(points, 508.4341828211807, mainline=main), payload, stations).iloc[-1]
        for stations in ([160.0 + distance], np.linspace(230.0, 160.0 + distance, 30))
    )
    assert direct.held_by == continued.held_by == "mainline"
    assert direct.carriage_z == pytest.approx(continued.carriage_z, abs=1e-8)


def test_design_scripts_run_as_written() -> None:
    bare = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
        tailspar=rw.TailSpar("tail", at=(200.0, -20.0)),
        skyline=ROPE,
        length=207.0,
        carriage=rw.Carriage("carriage", mass=0.0),
        holding="horizontal",
    )
    path = rw.load_path(bare, payload=0.0, stations=[50, 100, 150])
    assert (path.sag > 0.0).all()
    assert path.mainline_pull.abs().max() < 1e-6


def test_clearance_of_all_ropes_against_sampled_ones() -> None:
    """Also for a haulback that returns from its block near the tailspar to the carriage."""
    ground = rw.Profile([-10.0, 60.0, 120.0, 200.0, 260.0], [0.0, -12.0, -9.0, -14.0, 0.0])
    line = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
    rig = rw.standing_skyline(
        ground,
        headspar=rw.HeadSpar("head", at=(0.0, 15.0)),
        tailspar=rw.TailSpar("tail", at=(250.0, 12.0)),
        skyline=ROPE,
        length=253.5,
        mainline=line,
        haulback=line,
        haulback_tension=4e3,
        haulback_block=rw.Block("block", at=(250.0, 6.0)),
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    path = rw.load_path(rig, 2000.0, [90.0]).iloc[0]
    solved = Stations(rig).solve(90.0, 2000.0)
    least = {"skyline": np.inf, "mainline": np.inf, "haulback": np.inf}
    for r, (run, role) in enumerate(zip(solved.at.model.runs, solved.at.roles, strict=True)):
        for k, span in enumerate(run.spans):
            start, force = solved.start(r, k), solved.at.curve(solved.point, k, r)
            ds = np.linspace(0.0, solved[f"{span.name}.length"], 100_001)
            weight = run.rope.mass_per_length * rig.gravity
            rope = catenary.profile(force, weight, run.rope.strain, float(ds[-1]), (), (), ds).reach
            x, z = start[0] + rope[:, 0], start[2] + rope[:, 2]
            least[role] = min(least[role], float((z - ground.elevations(x)).min()))
    for role, column in (("skyline", "rope"), ("mainline", "mainline"), ("haulback", "haulback")):
        assert path[f"{column}_clearance"] == pytest.approx(least[role], abs=2e-4)
    assert len(set(least.values())) == 3


@pytest.mark.parametrize("radius", [0.0, 3.0])
def test_a_live_skyline_of_a_given_length_is_a_standing_one(radius: float) -> None:
    """Its drum is at rest, so the rope length does not depend on the carriage."""
    stations = [430.0, 345.0, 331.0, 320.0, 250.0, 170.0, 159.0, 50.0]
    paths = [
        rw.load_path(
            make(
                None,
                headspar=rw.HeadSpar("head", at=(0.0, 100.0)),
                supports=[
                    rw.IntermediateSupport("s1", at=(160.0, 40.0), radius=radius),
                    rw.IntermediateSupport("s2", at=(330.0, -20.0), radius=radius),
                ],
                tailspar=rw.TailSpar("tail", at=(480.0, -70.0)),
                skyline=ROPE,
                tension=70e3,
                mainline=rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3),
                carriage=rw.Carriage("carriage", mass=450.0),
            ),
            2500.0,
            stations,
        )
        for make in (rw.live_skyline, rw.standing_skyline)
    ]
    for column in ("carriage_z", "skyline_tension", "headspar_tension", "mainline_pull"):
        np.testing.assert_allclose(paths[0][column], paths[1][column], rtol=1e-9)


def test_a_rope_above_its_breaking_load_is_warned_of_once() -> None:
    weak = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=60e3)
    spars = {"headspar": rw.HeadSpar("head", at=(0.0, 15.0)), "tailspar": rw.TailSpar("tail", at=(300.0, -20.0))}
    line = rw.standing_skyline(None, **spars, skyline=weak, tension=20e3, carriage=rw.Carriage("carriage", mass=400.0))
    with pytest.warns(rw.RopewayWarning, match="with the carriage at 150 m is 1") as told:
        path = rw.load_path(line, 2500.0, [60.0, 150.0])
    assert len(told) == 1
    assert f"is {path['highest_tension'].max() / 60e3:.3g} times" in str(told[0].message)
    with pytest.warns(rw.RopewayWarning, match="breaking load"):
        rw.set_up(line, station=150.0, payload=2500.0, deflection=5.5)
