"""Forces on supports: each row balances, all supports together carry the weight and the wind."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.results.support_rows import roller_force
from support.lines import random_line

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3, diameter=0.0286)
STORM = rw.Environment("storm", temperature=-8.0, ice_thickness=0.006, wind_pressure=350.0, wind_from=215.0)
GRAVITY = 9.80665


def zig_zag(drag_area: float = 0.0) -> rw.System:
    """Five spans in 3-D over idlers, a hold-down and a control sheave, full of loads."""
    rows = [
        ("a", 0, 0, 0, "drum"), ("s1", 90, 12, 9, "idler"), ("c", 180, -5, 6, "control"), ("s2", 270, 8, 21, "idler"),
        ("s3", 330, 0, 32, "idler"), ("b", 420, 3, 35, "drum"),
    ]  # fmt: skip
    supports = pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])
    return rw.monocable(
        ROPE, supports, tension=50e3, load_mass=[250.0, 180.0], load_spacing=45.0, load_drag_area=drag_area
    )


def ring() -> rw.System:
    rows = [
        ("w", 0, 0, 8, "control"), ("s", 90, 4, 12, "idler"), ("r", 180, 0, 9, "return"), ("t", 90, -4, 12, "idler"),
    ]  # fmt: skip
    supports = pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])
    return rw.endless(ROPE, supports, tension=40e3, load_mass=120.0, load_spacing=50.0)


def carried(line: rw.Equilibrium, drag_area: float = 0.0, weather: rw.Environment | None = None) -> np.ndarray:
    """Weight and wind on ropes and loads [N]."""
    total = np.array([0.0, 0.0, -GRAVITY * line.loads["mass"].sum()])
    for run in line.runs:
        for span in run.spans:
            length = line[f"{span.name}.length"]
            if weather is None:
                total[2] -= GRAVITY * span.rope.mass_per_length * length
            else:
                total += [length * line[f"{span.name}.load_{axis}"] for axis in "xyz"]
    if weather is not None:
        towards, pressure = np.radians(line["wind_from"]), line["wind_pressure"]
        total[:2] -= len(line.loads) * drag_area * pressure * np.array([np.sin(towards), np.cos(towards)])
    return total


@pytest.mark.parametrize("weather", [None, STORM], ids=["calm", "storm"])
def test_rows_balance_and_add_up_to_weight_and_wind(weather: rw.Environment | None) -> None:
    line = rw.equilibrium(zig_zag(0.9), environment=weather)
    table = rw.support_table(line, rollers={"s1": 8})
    assert table["support"].tolist() == ["a", "s1", "c", "s2", "s3", "b"]
    for row in table.itertuples():
        tension = np.nanmax([row.tension_in, row.tension_out])
        before, after = (
            np.array([np.cos(angle), np.sin(angle)]) * size if np.isfinite(angle) else np.zeros(2)
            for angle, size in ((row.angle_in, row.tension_in), (row.angle_out, row.tension_out))
        )
        # Tangents and tensions of both sides give the resultant: vertically, and in plan with the turn.
        assert row.vertical_force == pytest.approx(before[1] - after[1], abs=1e-9 * tension)
        if np.isfinite(row.turn):
            across = np.sqrt(before[0] ** 2 + after[0] ** 2 - 2.0 * before[0] * after[0] * np.cos(row.turn))
            assert row.horizontal_force == pytest.approx(across, abs=1e-9 * tension)
        assert row.bearing_load == pytest.approx(
            np.linalg.norm([row.resultant_x, row.resultant_y, row.resultant_z]), abs=1e-9 * tension
        )
        if f"{row.support}.wrap" in line.model.y.index:  # the model's own outputs, by other equations
            for mine, its in (("bearing_load", "bearing_load"), ("vertical_force", "support_force")):
                assert getattr(row, mine) == pytest.approx(line[f"{row.support}.{its}"], abs=1e-9 * tension)
            assert row.wrap == pytest.approx(line[f"{row.support}.wrap"], abs=1e-9)
            assert row.differential_tension == pytest.approx(line[f"{row.support}.differential_tension"], abs=1e-4)
    total = table[["resultant_x", "resultant_y", "resultant_z"]].sum().to_numpy()
    assert total == pytest.approx(carried(line, 0.9, weather), abs=1e-9 * 50e3)
    control = table.set_index("support").loc["c"]
    assert control["drive_force"] == pytest.approx(line["c.drive_force"])
    assert table["drive_force"].notna().sum() == 1
    assert table.attrs["units"]["bearing_load"] == "N"


@pytest.mark.parametrize("seed", [8, 13, 21])
def test_forces_on_supports_of_random_lines_against_direct_integration(seed: int) -> None:
    """In 3-D, over idlers, control sheaves, drums and anchors."""
    case = random_line(seed, most=8)
    table = rw.support_table(case.system())
    zero = np.zeros((1, 3))
    exact = np.vstack([case.start, zero]) - np.vstack([zero, case.end])
    found = table[["resultant_x", "resultant_y", "resultant_z"]].to_numpy()
    assert found == pytest.approx(exact, abs=1e-7 * np.abs(case.start).max())
    assert found.sum(axis=0)[:2] == pytest.approx([0.0, 0.0], abs=1e-9 * np.abs(case.start).max())


def test_the_ring_of_an_endless_rope_has_each_wheel_once() -> None:
    line = rw.equilibrium(ring())
    table = rw.support_table(line).set_index("support")
    assert list(table.index) == ["w", "s", "r", "t"]
    assert table.loc["w", "bearing_load"] == pytest.approx(line["w.bearing_load"], rel=1e-10)
    total = table[["resultant_x", "resultant_y", "resultant_z"]].sum().to_numpy()
    assert total == pytest.approx(carried(line), abs=1e-5)
    assert table["least_force"].isna().tolist() == [True, False, True, False]  # drive and return hold it anyway


def test_rollers_share_the_wrap() -> None:
    """n rollers under an equal tension T each turn the rope by wrap / n: 2 T sin(wrap / 2 n)."""
    tension, wrap = 47e3, 0.31
    bearing = 2.0 * tension * np.sin(wrap / 2.0)
    for count in (1, 2, 8):
        found = roller_force(np.array(bearing), np.array(wrap), count)
        assert found == pytest.approx(2.0 * tension * np.sin(wrap / (2.0 * count)), rel=1e-14)
    assert roller_force(np.array(300.0), np.array(0.0), 4) == 75.0
    with pytest.raises(rw.UnknownNameError, match="no support 's9'"):
        rw.support_table(zig_zag(), rollers={"s9": 2})
    with pytest.raises(rw.InputError, match="'s1' has 0"):
        rw.support_table(zig_zag(), rollers={"s1": 0})


@pytest.mark.parametrize(("middle", "hold_down"), [(-5.0, False), (-9.0, True)])
def test_the_reserve_is_the_tension_at_which_the_rope_leaves(middle: float, hold_down: bool) -> None:
    """A sheave in a hollow: the empty rope strung with `reserve` times its horizontal tension (for a hold-down divided
    by it) has no force there. Beams with the same weight: exact but for the change of the rope's length."""

    def strung(tension: float) -> tuple[rw.Equilibrium, pd.Series]:
        s = rw.System("hollow")
        nodes = (
            rw.Anchor("a", at=(0, 0)),
            rw.Sheave("s", at=(100, middle), hold_down=hold_down),
            rw.Anchor("b", at=(220, 0)),
        )
        s.string(ROPE, *nodes, tension=tension)
        line = rw.equilibrium(s)
        return line, rw.support_table(line).set_index("support").loc["s"]

    line, row = strung(20e3 if not hold_down else 60e3)
    assert (row["vertical_force"] > 0.0) != hold_down
    assert row["lift_off_reserve"] > 1.0
    assert row["least_force"] == pytest.approx(abs(row["vertical_force"]))
    factor = 1.0 / row["lift_off_reserve"] if hold_down else row["lift_off_reserve"]
    _, leaving = strung(line["a_s.horizontal"] * factor)
    assert abs(leaving["vertical_force"]) < 0.03 * abs(row["vertical_force"])
    assert leaving["lift_off_reserve"] == pytest.approx(1.0, abs=0.03)


def test_a_rope_on_a_ridge_never_leaves() -> None:
    table = rw.support_table(rw.equilibrium(zig_zag())).set_index("support")
    assert np.isinf(table.loc["s1", "lift_off_reserve"])
    assert np.isnan(table.loc["a", "lift_off_reserve"])


def test_the_table_is_written_with_its_units(tmp_path: object) -> None:
    path = rw.write_table(rw.support_table(zig_zag()), f"{tmp_path}/supports.csv")
    head = path.read_text().splitlines()[0].split(",")
    assert head[:4] == ["support", "kind", "rope", "angle_in [rad]"]
    assert {"roller_force [N]", "lift_off_reserve"} <= set(head)
