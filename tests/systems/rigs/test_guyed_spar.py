"""A guyed spar: p-delta, stiff guys, springs, and balance of forces."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import ropeway as rw

G = 9.80665
ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
GUY = rw.Rope(mass_per_length=2.0, axial_stiffness=20e6, breaking_load=380e3)
MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
ANCHORS = {"g1": (-20.0, -12.0, -2.0), "g2": (-20.0, 12.0, -2.0), "g3": (12.0, -20.0, -3.0), "g4": (12.0, 20.0, -3.0)}


def spar(rope: rw.Rope = GUY, pretension: float = 20e3, stiffness: float = math.inf, mass: float = 0.0) -> rw.GuyedSpar:
    guys = tuple(
        rw.Guyline(n, rope=rope, at=at, pretension=pretension, stiffness=stiffness) for n, at in ANCHORS.items()
    )
    return rw.GuyedSpar("head", foot=(0.0, 0.0), height=15.0, guylines=guys, mass=mass)


def rig(head: rw.HeadSpar, mainline: rw.Rope | None = None) -> rw.SkylineRig:
    return rw.standing_skyline(
        None,
        headspar=head,
        tailspar=rw.TailSpar("tail", at=(250.0, -10.0)),
        skyline=ROPE,
        length=255.0,
        mainline=mainline,
        carriage=rw.Carriage("carriage", mass=450.0),
    )


def test_released_without_a_skyline_it_keeps_its_pretension_when_symmetric() -> None:
    square = [(20.0, 0.0, 0.0), (0.0, 20.0, 0.0), (-20.0, 0.0, 0.0), (0.0, -20.0, 0.0)]
    guys = [rw.Guyline(f"g{i}", rope=GUY, at=at, pretension=15e3) for i, at in enumerate(square)]
    mast = rw.GuyedSpar("mast", foot=(0.0, 0.0), height=12.0, guylines=tuple(guys))
    s = rw.System("mast")
    spans = rw.string_guylines(s, mast)
    eq = rw.equilibrium(s)
    assert eq["mast.lean"] == pytest.approx(0.0, abs=1e-9)
    for span in spans:
        assert eq[f"{span.name}.tension_a"] == pytest.approx(15e3, rel=1e-9)
    # Its compression is the downward pull of the guys.
    down = sum(eq[f"{span.name}.vertical_b"] for span in spans)
    assert eq["mast.compression"] == pytest.approx(down, rel=1e-9)


def test_stiff_guys_are_a_fixed_spar() -> None:
    """The deviation is proportional to the guys' compliance: two stiff ones give the limit."""
    stations = [60.0, 125.0, 200.0]
    fixed = rw.load_path(rig(rw.HeadSpar("head", at=(0.0, 15.0))), 2500.0, stations)

    def guyed(stiffness: float) -> pd.DataFrame:
        rope = rw.Rope(mass_per_length=1e-7, axial_stiffness=stiffness, breaking_load=1e9)
        return rw.load_path(rig(spar(rope, pretension=2e5)), 2500.0, stations)

    once, twice = guyed(1e12), guyed(2e12)
    for column in ("carriage_z", "skyline_tension", "headspar_tension", "tailspar_tension", "mainline_pull"):
        np.testing.assert_allclose(once[column], fixed[column], rtol=3e-7)
        np.testing.assert_allclose(2.0 * twice[column] - once[column], fixed[column], rtol=1e-9)
    assert twice.spar_lean.max() < 1e-6


def test_softer_guys_and_anchors_let_the_tension_fall() -> None:
    """The skyline's tension falls with less pretension and with softer anchors."""
    fixed = rw.load_path(rig(rw.HeadSpar("head", at=(0.0, 15.0))), 2500.0, [120.0]).highest_tension[0]
    loss = {}
    for pretension in (5e3, 20e3, 50e3):
        for stiffness in (math.inf, 2e6):
            row = rw.load_path(rig(spar(pretension=pretension, stiffness=stiffness)), 2500.0, [120.0]).iloc[0]
            loss[pretension, stiffness] = 1.0 - row.highest_tension / fixed
    assert loss[5e3, math.inf] > loss[20e3, math.inf] > loss[50e3, math.inf] > 0.0
    for pretension in (5e3, 20e3, 50e3):
        assert loss[pretension, 2e6] > loss[pretension, math.inf]


def test_forces_at_the_top_balance_along_the_leaning_mast() -> None:
    head = spar(pretension=10e3, mass=2000.0)
    held = rig(head, MAIN)
    eq = rw.equilibrium(held.system(0, 120.0, payload=2500.0), given={"carriage.x": 120.0}, solve_for="mainline.travel")
    top = np.array([eq[f"head.{a}"] for a in "xyz"])
    assert np.linalg.norm(top) == pytest.approx(15.0, rel=1e-12)

    def pull(span: str, mass: float, end: str) -> np.ndarray:
        start = np.array([eq[f"{span}.force_{a}"] for a in "xyz"])
        return start if end == "a" else -(start + np.array([0.0, 0.0, mass * G * eq[f"{span}.length"]]))

    total = pull("head_carriage", 3.48, "a") + np.array([0.0, 0.0, -1000.0 * G])
    total += pull("line_mainline_head", 0.73, "b") + pull("line_head_carriage", 0.73, "a")
    total += sum(pull(f"{name}_head", 2.0, "b") for name in ANCHORS)
    np.testing.assert_allclose(total, -eq["head.compression"] * top / 15.0, atol=1e-5)
    assert eq["line_mainline_head.tension_b"] == pytest.approx(eq["line_head_carriage.tension_a"], rel=1e-12)
    assert eq["head.lean"] > 0.01


def tailspar(rope: rw.Rope = GUY, pretension: float = 20e3, **how: object) -> rw.GuyedSpar:
    anchors = [(270.0, -12.0, -16.0), (270.0, 12.0, -16.0), (238.0, -20.0, -17.0), (238.0, 20.0, -17.0)]
    guys = tuple(rw.Guyline(f"t{i}", rope=rope, at=at, pretension=pretension) for i, at in enumerate(anchors))
    return rw.GuyedSpar("tail", foot=(250.0, -22.0), height=12.0, guylines=guys, **how)  # type: ignore[arg-type]


GROUND = rw.Profile([-30.0, 0.0, 100.0, 200.0, 250.0, 300.0], [-2.0, 0.0, -45.0, -48.0, -22.0, -22.0])


def of_kind(kind: str, head: rw.HeadSpar, tail: rw.TailSpar | rw.GuyedSpar) -> rw.SkylineRig:
    carriage = rw.Carriage("carriage", mass=450.0)
    if kind == "running":
        return rw.running_skyline(
            GROUND, headspar=head, tailspar=tail, haulback=MAIN, mainline=MAIN, tension=30e3, carriage=carriage
        )
    make = {"live": rw.live_skyline, "gravity": rw.gravity_skyline, "standing": rw.standing_skyline}[kind]
    return make(  # type: ignore[operator, no-any-return]
        GROUND, headspar=head, tailspar=tail, skyline=ROPE, tension=60e3, mainline=MAIN, carriage=carriage
    )


@pytest.mark.parametrize("kind", ["live", "gravity", "running"])
def test_stiff_guys_on_both_spars_of_a_lowered_skyline_are_fixed_spars(kind: str) -> None:
    """At a given height of the carriage the position of the drum is irrelevant."""
    stations = [60.0, 125.0, 200.0]
    fixed = of_kind(kind, rw.HeadSpar("head", at=(0.0, 15.0)), rw.TailSpar("tail", at=(250.0, -10.0)))
    there = rw.load_path(fixed, 1000.0, stations, height=12.0)

    def guyed(stiffness: float) -> pd.DataFrame:
        rope = rw.Rope(mass_per_length=1e-7, axial_stiffness=stiffness, breaking_load=1e9)
        rig = of_kind(kind, spar(rope, pretension=2e5), tailspar(rope, pretension=2e5))
        return rw.load_path(rig, 1000.0, stations, height=12.0)

    once, twice = guyed(1e12), guyed(2e12)
    for column in ("skyline_tension", "headspar_tension", "tailspar_tension", "mainline_pull"):
        if kind == "running" and column == "headspar_tension":
            continue  # that of the drum at the spar's foot
        np.testing.assert_allclose(2.0 * twice[column] - once[column], there[column], rtol=1e-9)


def test_a_live_skyline_at_rest_is_the_standing_one_but_for_the_rope_down_to_its_drum() -> None:
    fixed = rw.TailSpar("tail", at=(250.0, -10.0))
    rig = of_kind("standing", spar(), fixed)
    live = rw.load_path(of_kind("live", spar(), fixed), 2500.0, [120.0]).iloc[0]
    # The load stretches this rope of 15 m; its stretch enters the span.
    given = 15.0 * (ROPE.strain.at(live.headspar_tension) - ROPE.strain.at(60e3))
    standing = rw.load_path(replace(rig, length=(rig.length or 0.0) + given), 2500.0, [120.0]).iloc[0]
    assert live.skyline_tension == pytest.approx(standing.skyline_tension, rel=2e-4)
    # The drum's rope presses the spar down as well, about with its own tension.
    assert live.spar_compression == pytest.approx(standing.spar_compression + live.headspar_tension, rel=0.01)


@pytest.mark.parametrize("hold", [None, rw.Tailhold("stump", at=(275.0, -21.0))])
def test_a_guyed_tailspar_balances_along_its_mast(hold: rw.Tailhold | None) -> None:
    held = of_kind("standing", rw.HeadSpar("head", at=(0.0, 15.0)), tailspar(tailhold=hold))
    given = {"carriage.x": 120.0}
    eq = rw.equilibrium(held.system(0, 120.0, payload=2500.0), given=given, solve_for="mainline.travel")
    foot = np.array([250.0, 0.0, -22.0])
    along = np.array([eq[f"tail.{a}"] for a in "xyz"]) - foot
    assert np.linalg.norm(along) == pytest.approx(12.0, rel=1e-12)
    total = np.zeros(3)
    for span, mass, end in [("carriage_tail", 3.48, "b"), *((f"t{i}_tail", 2.0, "b") for i in range(4))] + (
        [("tail_stump", 3.48, "a")] if hold else []
    ):
        force = np.array([eq[f"{span}.force_{a}"] for a in "xyz"])
        total += force if end == "a" else -(force + np.array([0.0, 0.0, mass * G * eq[f"{span}.length"]]))
    np.testing.assert_allclose(total, -eq["tail.compression"] * along / 12.0, atol=1e-5)
    row = rw.load_path(held, 2500.0, [120.0]).iloc[0]
    assert row.tailspar_compression == pytest.approx(eq["tail.compression"], rel=1e-9)
    assert row.t0_tension == pytest.approx(eq["t0_tail.tension_b"], rel=1e-9)
    if hold:
        assert eq["tail_stump.tension_a"] == pytest.approx(eq["carriage_tail.tension_b"], rel=1e-12)


def test_payload_is_limited_by_a_guyline() -> None:
    weak = rw.Rope(mass_per_length=1.0, axial_stiffness=12e6, breaking_load=180e3)
    study = rw.payload(rig(spar(weak)), stations=[120.0])
    assert study.limiting.limited_by.startswith("guyline g")
    back = study.limiting[["g1_tension", "g2_tension"]].max()
    assert back == pytest.approx(60e3, rel=1e-8)


def test_an_unstable_spar_is_reported() -> None:
    """Guylines behind a spar and almost in line with the skyline do not hold it sideways."""

    def narrow(half: float) -> rw.SkylineRig:
        anchors = {"g1": (-22.0, -half, 0.0), "g2": (-20.0, half, 0.0)}
        guys = tuple(rw.Guyline(name, rope=GUY, at=at, pretension=20e3) for name, at in anchors.items())
        return rig(rw.GuyedSpar("head", foot=(0.0, 0.0), height=15.0, mass=2000.0, guylines=guys))

    with pytest.raises(rw.OutOfReachError, match="would topple") as error:
        rw.load_path(narrow(0.5), 2500.0, [120.0])
    assert "Spread" in error.value.remedy
    with pytest.raises(rw.EquilibriumError, match="unstable"):
        rw.equilibrium(narrow(0.5).system(0, 120.0, payload=2500.0))
    row = rw.payload(narrow(0.5), stations=[120.0]).limiting
    assert (row.payload, row.limited_by) == (0.0, "guylines of head")
    assert rw.load_path(narrow(8.0), 2500.0, [120.0]).spar_lean.iloc[0] < 0.3


def test_an_ideal_haulback_at_a_guyed_tailspar_is_rejected() -> None:
    fixed = of_kind("standing", rw.HeadSpar("head", at=(0.0, 15.0)), rw.TailSpar("tail", at=(250.0, -10.0)))
    parts = {"headspar": fixed.headspar, "skyline": ROPE, "tension": 60e3, "mainline": MAIN, "carriage": fixed.carriage}
    with pytest.raises(rw.InputError, match="is guyed") as error:
        rw.standing_skyline(GROUND, tailspar=tailspar(), haulback=MAIN, haulback_tension=5e3, **parts)  # type: ignore[arg-type]
    assert "haulback_block" in error.value.remedy


def test_bad_spars_are_rejected() -> None:
    with pytest.raises(rw.InputError, match="below the ground"):
        of_kind("standing", spar(), replace(tailspar(), foot=(250.0, -60.0), at=()))
    guys = (rw.Guyline("g1", rope=GUY, at=(1.0, 2.0, 0.0), pretension=1e3),)
    with pytest.raises(rw.InputError, match="two or more"):
        rw.GuyedSpar("head", foot=(0.0, 0.0), height=15.0, guylines=guys)
    with pytest.raises(rw.InputError, match="one name"):
        rw.GuyedSpar("head", foot=(0.0, 0.0), height=15.0, guylines=guys * 2)
    with pytest.raises(rw.InputError, match="Block"):
        rw.GuyedSpar("head", foot=(0.0, 0.0), height=15.0, guylines=guys, blocks=("main line",))
    with pytest.raises(rw.InputError, match="no height"):
        rw.GuyedSpar("head", foot=(0.0, 0.0), guylines=guys)
    with pytest.raises(rw.InputError, match="breaking load"):
        rw.Guyline("g", rope=GUY, at=(1.0, 0.0), pretension=1e6)
    with pytest.raises(rw.InputError, match="stiffness"):
        rw.Guyline("g", rope=GUY, at=(1.0, 0.0), pretension=1e3, stiffness=-1.0)
