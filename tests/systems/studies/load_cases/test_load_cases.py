"""Load cases of lines and rigs: each is the equilibrium that a user would solve, and the tables name what governs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.studies.load_cases.loadings import loaded, masses_of
from ropeway.systems.studies.skyline.station_solver import Stations
from ropeway.systems.studies.skyline.support_states import support_states

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3, diameter=0.0286)
MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3, diameter=0.0125)
GROUND = rw.Profile([0, 100, 200, 260, 300, 400, 500], [100, 85, 70, 75, 65, 50, 52])
CALM = rw.Environment("calm")
COLD = rw.Environment("cold", temperature=-25.0)
ICED = rw.Environment("iced", temperature=-5.0, ice_thickness=0.012)
STORM = rw.Environment("storm", wind_pressure=400.0, wind_from=0.0)
LOW = rw.Profile([-20.0, 700.0], [-12.0, 12.0])


def line(**how: object) -> rw.System:
    rows = [("a", 0.0, 0.0, 0.0, "drum")]
    rows += [
        (f"s{k}", 95.0 * k, 3.0 * (k % 2), 5.0 * k + (k % 3), "control" if k == 3 else "idler") for k in range(1, 6)
    ]
    rows += [("b", 570.0, 0.0, 30.0, "drum")]
    supports = pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])
    given = {"load_mass": 260.0, "load_spacing": 40.0, "load_drag_area": 0.7, **how}
    return rw.monocable(ROPE, supports, tension=45e3, **given)  # type: ignore[arg-type]


def rig(**how: object) -> rw.SkylineRig:
    given = {"mainline": MAIN, "tension": 70e3, "carriage": rw.Carriage("carriage", mass=450.0, payload=2000.0), **how}
    return rw.standing_skyline(
        GROUND,
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        supports=[rw.IntermediateSupport("jack", station=260.0, height=9.0)],
        tailspar=rw.TailSpar("tail", station=480.0, height=8.0),
        skyline=ROPE,
        **given,  # type: ignore[arg-type]
    )


@pytest.fixture(scope="module")
def cases() -> rw.LoadCases:
    return rw.load_cases(line(terrain=LOW), [CALM, COLD, ICED, STORM])


def test_each_case_is_the_equilibrium_of_its_line(cases: rw.LoadCases) -> None:
    assert len(cases.cases) == 16
    system = line(terrain=LOW)
    for case in cases.cases[::5]:
        alone = rw.equilibrium(loaded(system, case.loading, {}), environment=case.environment)
        found = cases.states[case.name]
        assert isinstance(found, rw.Equilibrium)
        assert found.certificate["holds"].all()
        for name in ("a_s1.tension_a", "s3_s4.tension_b", "s2.bearing_load", "s5_b.length"):
            assert found[name] == pytest.approx(alone[name], rel=1e-10)
        assert found.loads["x"].to_numpy() == pytest.approx(alone.loads["x"].to_numpy(), abs=1e-7)
        own = cases.supports[cases.supports["case"] == case.name].set_index("support")
        assert own["vertical_force"].to_numpy() == pytest.approx(
            rw.support_table(alone)["vertical_force"].to_numpy(), abs=1e-5
        )


def test_the_row_of_a_case_has_the_extremes_of_its_ropes_and_supports(cases: rw.LoadCases) -> None:
    row, state = cases.frame.loc["iced, full"], cases.states["iced, full"]
    assert isinstance(state, rw.Equilibrium)
    ends = {name: state[name] for name in state.model.y.names if name.endswith((".tension_a", ".tension_b"))}
    assert row["highest_tension"] == pytest.approx(max(ends.values()), rel=1e-9)
    assert row["lowest_tension"] == pytest.approx(min(ends.values()), rel=1e-9)
    assert row["safety"] == pytest.approx(ROPE.breaking_load / row["highest_tension"])
    assert row["utilisation"] == pytest.approx(row["safety_factor"] / row["safety"])
    heights = state.clearance[["rope_clearance", "load_clearance"]].min(axis=1)
    assert (row["least_clearance"], row["least_clearance_at"]) == (pytest.approx(heights.min()), heights.idxmin())
    forces = rw.support_table(state).set_index("support")
    assert row["least_force"] == pytest.approx(forces["least_force"].min())
    assert row["least_force_at"] == forces["least_force"].idxmin()


def test_governing_cases_and_by_how_much(cases: rw.LoadCases) -> None:
    """Cold gives the highest tension, ice and loads the least clearance, an empty rope the least support force."""
    found = cases.governing.set_index(["name", "quantity"])
    tension = found.loc[("a ... b", "highest_tension")]
    ranked = cases.frame["highest_tension"].round(3).sort_values(ascending=False, kind="stable")
    assert (tension["case"], tension["next_case"]) == tuple(ranked.index[:2])
    assert tension["by"] == pytest.approx(ranked.iloc[0] - ranked.iloc[1], abs=1e-3)
    assert tension["share"] == pytest.approx(ranked.iloc[0] / ranked.iloc[1] - 1.0, abs=1e-7)
    least = found.loc[("s4", "least_force")]
    own = cases.supports[cases.supports["support"] == "s4"].set_index("case")["least_force"].sort_values()
    assert least["value"] == pytest.approx(own.iloc[0])
    assert least["by"] == pytest.approx(own.iloc[1] - own.iloc[0], abs=1e-5)
    assert cases.clearances is not None
    clear = cases.clearances[cases.clearances["span"] == "s1_s2"].set_index("case")["rope_clearance"]
    assert clear[found.loc[("s1_s2", "rope_clearance"), "case"]] == pytest.approx(clear.min(), abs=1e-6)
    assert set(found["extreme"]) == {"highest", "lowest"}


def test_loadings_of_a_feed() -> None:
    (run,) = rw.assemble(line()).runs
    count = sum(run.loads.place >= 0.0)
    assert masses_of(run, "full", {}).sum() == run.loads.mass.sum()
    assert not masses_of(run, "empty", {}).any()
    half = masses_of(run, "one side", {})[:count]
    assert (half > 0.0).sum() == pytest.approx(count / 2, abs=1)
    assert np.all(np.diff(half) >= 0.0)  # the loads behind the middle, foremost first
    second = masses_of(run, "every second", {})
    assert np.array_equal(second > 0.0, np.arange(len(second)) % 2 == 0)
    given = masses_of(run, "mine", {"mine": [100.0, 0.0, 50.0]})
    assert given[:4].tolist() == [100.0, 0.0, 50.0, 100.0]
    assert masses_of(run, "mine", {"mine": {"l2": 0.0}})[:3].tolist() == [260.0, 0.0, 260.0]


def test_one_side_of_a_line_that_turns_back() -> None:
    rows = [
        ("w", 0.0, 0.0, 8.0, "control"), ("s", 90.0, 4.0, 12.0, "idler"), ("r", 180.0, 0.0, 9.0, "return"),
        ("t", 90.0, -4.0, 12.0, "idler"),
    ]  # fmt: skip
    ring = rw.endless(
        ROPE,
        pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"]),
        tension=40e3,
        load_mass=120.0,
        load_spacing=30.0,
    )
    found = rw.load_cases(ring, [CALM], loadings=["one side", "empty"])
    state = found.states["calm, one side"]
    assert isinstance(state, rw.Equilibrium)
    assert set(state.loads["span"]) == {"w_s", "s_r"}
    empty = found.states["calm, empty"]
    assert isinstance(empty, rw.Equilibrium)
    assert len(empty.loads) == 0


def test_hung_loads_and_a_loading_of_the_user() -> None:
    s = rw.System("hung")
    nodes = rw.Anchor("a", at=(0, 0)), rw.Sheave("m", at=(110, 9)), rw.Anchor("b", at=(230, 4))
    spans = s.string(ROPE, *nodes, length=233.0)
    s.hang(rw.Load("one", 400.0), spans[0], at=60.0)
    s.hang(rw.Load("two", 300.0), spans, at=170.0)
    mine: dict[str, Any] = {"empty": "empty", "second only": {"one": 0.0}}
    found = rw.load_cases(s, [CALM, COLD], loadings=mine)
    alone = s.copy()
    alone.hung = alone.hung[1:]
    wanted = rw.equilibrium(alone, environment=COLD)
    assert found.frame.loc["cold, second only", "highest_tension"] == pytest.approx(
        max(wanted[f"{span.name}.tension_{end}"] for span in spans for end in "ab"), rel=1e-10
    )
    assert found.states["cold, second only"]["two.z"] == pytest.approx(wanted["two.z"])
    with pytest.raises(rw.UnknownNameError, match="no load 'three'"):
        rw.load_cases(s, [CALM], loadings={"mine": {"three": 1.0}})


def test_cases_of_a_table_with_units_and_a_safety_factor_of_their_own(tmp_path: Path) -> None:
    path = tmp_path / "cases.csv"
    path.write_text(
        "name,temperature [degC],ice_thickness [mm],wind_pressure [Pa],wind_from,loading,safety_factor\n"
        "calm,,,,,,\niced,-5,12,,,full,\nout of operation,,,800,90,empty,2.0\n"
    )
    found = rw.load_cases(line(), path, loadings=["empty", "full"], safety_factor=3.5)
    assert list(found.frame.index) == ["calm, empty", "calm, full", "iced", "out of operation"]
    assert found.frame["ice_thickness"].tolist() == [0.0, 0.0, 0.012, 0.0]
    assert found.frame["temperature"].tolist() == [15.0, 15.0, -5.0, 15.0]
    assert found.frame["safety_factor"].tolist() == [3.5, 3.5, 3.5, 2.0]
    direct = rw.load_cases(line(), [ICED], loadings=["full"])
    assert found.frame.loc["iced", "highest_tension"] == pytest.approx(
        direct.frame["highest_tension"].iloc[0], rel=1e-12
    )


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("name,ice\nx,1\n", "no quantity 'ice'"),
        ("name,ice_thickness\nx,-0.01\n", "line 2.*ice_thickness is -0.01"),
        ("name,wind_pressure,wind_speed\nx,100,10\n", "wind_pressure and wind_speed"),
        ("name,temperature\n,5\n", "has no name"),
        ("name,temperature\nx,5\nx,6\n", "Two load cases are named 'x'"),
        ("name,loading\nx,half\n", "no loading 'half'"),
        ("name,loading\nx,full\n", "thin|diameter"),
    ],
)
def test_invalid_tables(table: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "cases.csv"
    path.write_text(table)
    thin = rw.System("thin")
    thin.string(MAIN if "diameter" not in message else rw.Rope(0.73, 8e6, 120e3), rw.Anchor("a", at=(0, 0)),
                rw.Anchor("b", at=(90, 0)), length=90.3)  # fmt: skip
    if "diameter" in message:
        path.write_text("name,wind_pressure\nx,300\n")
    with pytest.raises(rw.InputError, match=message):
        rw.load_cases(thin, path, loadings=["empty"])


def test_wrong_arguments() -> None:
    with pytest.raises(rw.InputError, match="Two load cases"):
        rw.load_cases(line(), [CALM, CALM], loadings=["full"])
    with pytest.raises(rw.InputError, match="no load case"):
        rw.load_cases(line(), [])
    with pytest.raises(rw.InputError, match="those of a rig"):
        rw.load_cases(line(), [CALM], payload=900.0)
    with pytest.raises(rw.InputError, match="Leave out cases"):
        rw.support_table(rw.equilibrium(line()), [CALM])
    with pytest.raises(rw.UnknownNameError, match="no loading 'one side'"):
        rw.load_cases(rig(), [CALM], loadings=["one side"])


@pytest.fixture(scope="module")
def of_rig() -> rw.LoadCases:
    return rw.load_cases(rig(), [CALM, ICED], stations=[60.0, 200.0, 259.95, 400.0])


def test_a_rig_in_each_case_is_its_load_path(of_rig: rw.LoadCases) -> None:
    path = rw.load_path(rig(), 2000.0, [60.0, 200.0, 259.95, 400.0], environment=ICED)
    row = of_rig.frame.loc["iced, full"]
    assert row["highest_tension"] == pytest.approx(path["highest_tension"].max(), rel=1e-9)
    assert row["least_clearance"] == pytest.approx(path[["rope_clearance", "clearance"]].min().min(), abs=1e-6)
    found = of_rig.states["iced, full"]
    assert isinstance(found, pd.DataFrame)
    assert found["carriage_z"].to_numpy() == pytest.approx(path["carriage_z"].to_numpy(), abs=1e-7)
    jack = of_rig.supports.query("case == 'iced, full' and support == 'jack' and rope == 'skyline'").set_index(
        "extreme"
    )
    assert jack.loc["highest bearing load", "station"] == 259.95
    assert jack.loc["least vertical force", "vertical_force"] == pytest.approx(path["jack_force"].min(), rel=1e-9)
    assert jack.loc["largest break angle", "break_angle"] == pytest.approx(path["jack_break_angle"].max(), rel=1e-9)
    assert (of_rig.governing.query("name == 'skyline' and quantity == 'utilisation'")["case"] == "iced, full").all()


@pytest.mark.parametrize(("radius", "stations"), [(0.0, (100.0, 330.0)), (3.0, (100.0, 260.0, 261.0, 330.0))])
def test_supports_of_a_rig_carry_everything(radius: float, stations: tuple[float, ...]) -> None:
    """At each place the rows of all ropes add up to the weight of ropes, carriage and payload: also on a shoe, whose
    row has the carriage and all ropes that lie on it."""
    jack = rw.IntermediateSupport("jack", station=260.0, height=9.0, radius=radius)
    shod = rw.standing_skyline(
        GROUND,
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        supports=[jack],
        tailspar=rw.TailSpar("tail", station=480.0, height=8.0),
        skyline=ROPE,
        tension=70e3,
        mainline=MAIN,
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    solver = Stations(shod)
    solved = [solver.solve(station, 1500.0) for station in stations]
    assert [one.held_by for one in solved] == ["mainline"] * len(stations)
    rows = support_states(solved)
    for state, one in enumerate(solved):
        own = rows[(rows["state"] == state) & (rows["rope"] != "all")]
        ropes = sum(
            run.rope.mass_per_length * one[f"{span.name}.length"] for run in one.at.model.runs for span in run.spans
        )
        weight = 9.80665 * (ropes + 1950.0)
        total = own[["resultant_x", "resultant_y", "resultant_z"]].sum().to_numpy()
        assert total == pytest.approx([0.0, 0.0, -weight], abs=1e-9 * 150e3)
        sums = rows[(rows["state"] == state) & (rows["rope"] == "all")].set_index("support")
        for support in ("head", "jack"):
            parts = own.loc[own["support"] == support, "vertical_force"].sum()
            assert sums.loc[support, "vertical_force"] == pytest.approx(parts, rel=1e-12)


def test_supports_of_a_rig_bear_the_wind() -> None:
    """Across the corridor too: ropes with ice, the carriage, and what each support takes of it."""
    weather = rw.Environment("storm", temperature=-5.0, ice_thickness=0.005, wind_pressure=250.0, wind_from=20.0)
    rigged = rig(carriage=rw.Carriage("carriage", mass=450.0, drag_area=3.0)).in_weather(weather)
    solved = Stations(rigged).solve(330.0, 1500.0)
    assert solved.held_by == "mainline"
    towards = np.radians(20.0)
    wanted = np.array([-np.sin(towards), -np.cos(towards), 0.0]) * 3.0 * 250.0 - [0.0, 0.0, 1950.0 * 9.80665]
    for run in solved.at.model.runs:
        for span in run.spans:
            wanted += [solved[f"{span.name}.length"] * solved[f"{span.name}.load_{axis}"] for axis in "xyz"]
    rows = support_states([solved])
    total = rows.loc[rows["rope"] != "all", ["resultant_x", "resultant_y", "resultant_z"]].sum().to_numpy()
    assert total == pytest.approx(wanted, abs=1e-9 * 150e3)
    assert abs(total[1]) > 3000.0


def test_a_table_of_a_rig_has_its_extreme_states(of_rig: rw.LoadCases) -> None:
    table = rw.support_table(rig(), [CALM], payload=2000.0, stations=[60.0, 200.0, 259.95, 400.0], rollers={"jack": 3})
    again = rw.support_table(of_rig, rollers={"jack": 3})
    own = again[again["case"] == "calm, full"].reset_index(drop=True)
    pd.testing.assert_frame_equal(table[table["case"] == "calm, full"].reset_index(drop=True), own, rtol=1e-8)
    jack = own[(own["support"] == "jack") & (own["rope"] == "skyline")]
    assert (jack["least_force"] == jack["vertical_force"].min()).all()
    assert (jack["roller_force"] < jack["bearing_load"] / 2.9).all()


def test_picture_and_report(cases: rw.LoadCases, of_rig: rw.LoadCases, tmp_path: Path) -> None:
    most = math.ceil(100.0 * cases.frame["utilisation"].max())
    assert f"{most} % of the tension allowed" in repr(cases)
    for study in (cases, of_rig):
        panels = study.plot().axes
        assert len(panels) == (5 if study is cases else 4)
        page = study.report(tmp_path / "cases.html").read_text()
        assert all(text in page for text in ("Governing cases", "iced, full", "Reserve against lift-off"))
    assert "16 cases" in repr(cases)


def test_cases_are_saved_and_run_from_a_file(tmp_path: Path) -> None:
    short = rw.System("short")
    nodes = rw.Anchor("a", at=(0, 0)), rw.Sheave("m", at=(110, 9)), rw.Anchor("b", at=(230, 4))
    short.string(ROPE, *nodes, length=231.0)
    found = rw.load_cases(short, [CALM, rw.LoadCase("cold", COLD, "empty", 2.0)], loadings=["full"])
    again = rw.load(rw.save(found, tmp_path / "cases.zip"))
    pd.testing.assert_frame_equal(again.governing, found.governing)
    assert again.states["cold"]["a_m.tension_a"] == found.states["cold"]["a_m.tension_a"]
    inputs = rw.StudyInputs("load_cases", short, {"cases": [CALM, rw.LoadCase("cold", COLD)], "loadings": ["empty"]})
    study = rw.run_study(rw.load(rw.save(inputs, tmp_path / "inputs.json")))
    assert list(study.frame.index) == ["calm", "cold"]
