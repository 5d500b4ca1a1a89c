"""The mono-cable rig: lines from tables, and rejected tables."""

from pathlib import Path

import pandas as pd
import pytest

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
TABLE = pd.DataFrame(
    [
        ("a", 0, 0, 0, "drum"),
        ("s1", 90, 2, 8, "idler"),
        ("c1", 180, -2, 15, "control"),
        ("s2", 270, 2, 20, "return"),
        ("b", 360, 0, 22, "drum"),
    ],
    columns=["name", "x", "y", "z", "kind"],
)
SETTINGS = {"tension": 45e3, "load_mass": 300.0, "load_spacing": 50.0}


def test_empty_rope_has_the_pretension_everywhere() -> None:
    line = rw.monocable(ROPE, TABLE, tension=45e3)
    eq = rw.equilibrium(line)
    assert eq["a_s1.tension_a"] == pytest.approx(45e3, rel=1e-9)
    for name in ("s1", "c1", "s2"):
        assert eq[f"{name}.differential_tension"] == pytest.approx(0.0, abs=1e-4)
    assert eq["b.rope_tension"] == pytest.approx(45e3 + 3.48 * 9.80665 * 22.0, rel=1e-3)


def test_ends_keep_the_tension_and_the_rope_starts_full() -> None:
    line = rw.monocable(ROPE, TABLE, speed=1.0, **SETTINGS)
    result = rw.simulate(line, until=100.0)
    assert result.frame["a.rope_tension"].to_numpy() == pytest.approx(45e3, rel=1e-10)
    assert len(result.at(0.0).loads) == 7
    assert result.at(0.0).loads["distance"].iloc[0] == pytest.approx(25.0, abs=0.5)


def test_without_a_control_sheave_the_first_drum_drives() -> None:
    result = rw.simulate(rw.monocable(ROPE, TABLE.replace("control", "idler"), speed=0.7, **SETTINGS), until=10.0)
    assert result.frame["a.travel"].iloc[-1] == pytest.approx(7.0)


def test_masses_are_used_in_order() -> None:
    line = rw.monocable(ROPE, TABLE, tension=45e3, load_mass=[100.0, 200.0, 300.0], load_spacing=50.0)
    loads = rw.equilibrium(line).loads.set_index("load")["mass"]
    assert [loads[f"l{i}"] for i in range(1, 8)] == [100.0, 200.0, 300.0, 100.0, 200.0, 300.0, 100.0]


def test_csv_and_frame_agree(tmp_path: Path) -> None:
    TABLE.to_csv(tmp_path / "line.csv", index=False)
    one, two = rw.monocable(ROPE, tmp_path / "line.csv", **SETTINGS), rw.monocable(ROPE, TABLE, **SETTINGS)
    assert rw.equilibrium(one)["c1.tension_in"] == rw.equilibrium(two)["c1.tension_in"]


def with_row(i: int, **values: object) -> pd.DataFrame:
    table = TABLE.astype(object)
    for column, value in values.items():
        table.loc[i, column] = value
    return table


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (with_row(2, kind="pulley"), "line 4: kind of 'c1' is 'pulley'"),
        (with_row(1, z="high"), "line 3, column z: 'high' is not a number"),
        (with_row(1, x=float("nan")), "line 3, column x: the cell is blank"),
        (with_row(2, kind="drum"), "line 4: 'c1' is drum at position 3 of 5"),
        (with_row(0, kind="idler"), "line 2: 'a' is idler at position 1 of 5"),
        (with_row(0, kind="anchor"), "anchored end cannot move"),
        (with_row(2, name="s1"), "'s1'"),
        (with_row(2, name=""), "line 4, column name: a support has no name"),
        (TABLE.drop(columns="kind"), "line 1: no column kind"),
        (TABLE.iloc[:1], "it has 1 support"),
        (with_row(1, x=0, y=0, z=0), "have the same position"),
    ],
)
def test_bad_tables(table: pd.DataFrame, message: str, tmp_path: Path) -> None:
    table.to_csv(tmp_path / "bad.csv", index=False)
    with pytest.raises(rw.InputError) as error:
        rw.monocable(ROPE, tmp_path / "bad.csv", **SETTINGS)
    assert message in str(error.value)
    assert error.value.remedy


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({**SETTINGS, "tension": -1.0}, "tension"),
        ({**SETTINGS, "tension": 1e3}, "too low"),
        ({**SETTINGS, "load_mass": 0.0}, "mass"),
        ({**SETTINGS, "load_mass": []}, "no masses"),
        ({**SETTINGS, "load_spacing": -5.0}, "spacing"),
        ({"tension": 45e3, "load_mass": 300.0}, "one of load_mass and load_spacing"),
    ],
)
def test_bad_settings(settings: dict[str, object], message: str) -> None:
    with pytest.raises(rw.RopewayError, match=message):
        rw.monocable(ROPE, TABLE, **settings)


def test_missing_file() -> None:
    with pytest.raises(rw.InputError, match=r"no file nowhere.csv"):
        rw.monocable(ROPE, "nowhere.csv", **SETTINGS)


def test_drives_and_responses_of_single_supports_in_the_table(tmp_path: Path) -> None:
    rule = rw.ThresholdResponse(low=40e3, high=60e3, increment=0.01)
    table = with_row(2, **{"response.increment": 0.02, "response.high": 66e3})
    table.to_csv(tmp_path / "line.csv", index=False)
    sheave = rw.monocable(ROPE, tmp_path / "line.csv", response=rule, **SETTINGS).components["c1"]
    assert isinstance(sheave, rw.ControlSheave)
    assert sheave.response == rw.ThresholdResponse(low=40e3, high=66e3, increment=0.02)
    with pytest.raises(rw.InputError, match=r"column response\.colour: a response has no 'colour'"):
        rw.monocable(ROPE, with_row(2, **{"response.colour": 1.0}), response=rule, **SETTINGS)
    with pytest.raises(rw.InputError, match="increment"):
        rw.monocable(ROPE, with_row(2, **{"response.increment": 0.0}), response=rule, **SETTINGS)
