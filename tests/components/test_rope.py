"""Ropes: constructors, stretch laws, the table of named ropes."""

from __future__ import annotations

import math
from pathlib import Path

import pandas as pd
import pytest

import ropeway as rw
from ropeway.components.rope_catalogue import SIZES, constructions

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24.0e6, breaking_load=450.3e3)

# EN 12385-4: W, C, K
FACTORS = {
    "6x19 IWRC": (0.400, 0.449, 0.356),
    "6x36 IWRC": (0.409, 0.460, 0.356),
    "6x19 FC": (0.359, 0.384, 0.330),
    "6x36 FC": (0.367, 0.393, 0.330),
    "6x7 FC": (0.345, 0.369, 0.332),
    "6x7 IWRC": (0.384, 0.432, 0.359),
    "8x36 IWRC": (0.417, 0.468, 0.356),
}

# mm, kg/m, kN
QUOTED = {
    "compacted skyline 20": (20.0, 1.98, 356.0, "SEILAPLAN, parameter set MSK 3t 20/11/8mm"),
    "compacted skyline 22": (22.0, 2.37, 424.0, "SEILAPLAN, Standardparameter"),
    "6x19 EEIP 19": (19.05, 1.4, 256.3, "Lyons 2008"),
    "6x19 EEIP 25": (25.4, 2.4, 450.3, "Lyons 2008"),
    "RHOL-IWRC 29": (28.6, 3.48, 576.6, "Harvey 2013"),
}


def test_all_constructions_are_there() -> None:
    assert {name: (c.mass, c.area, c.strength) for name, c in constructions().items()} == FACTORS


@pytest.mark.parametrize("grade", [1770.0, 1960.0, 2160.0])
@pytest.mark.parametrize("construction", FACTORS)
def test_from_construction(construction: str, grade: float) -> None:
    w, c, k = FACTORS[construction]
    rope = rw.Rope.from_construction(construction, 0.022, grade, modulus=100e9)
    assert rope.mass_per_length == pytest.approx(w * 22.0**2 / 100.0)
    assert rope.axial_stiffness == pytest.approx(100e9 * c * 22.0**2 * 1e-6)
    assert rope.breaking_load == pytest.approx(k * 22.0**2 * grade / 1000.0 * 1e3)
    assert rope.diameter == 0.022


def test_the_modulus_is_lyons() -> None:
    rope = rw.Rope.from_construction("6x19 IWRC", 0.01905, 2160.0)
    assert rope.axial_stiffness == pytest.approx(93.1e9 * 0.449 * 19.05**2 * 1e-6)


@pytest.mark.parametrize("name", QUOTED)
def test_named_ropes(name: str) -> None:
    diameter, mass, strength, source = QUOTED[name]
    rope = rw.Rope.named(name)
    row = rw.ropes().loc[name]
    for one in (rope, row):
        assert one.mass_per_length == mass
        assert one.breaking_load == pytest.approx(strength * 1e3)
        assert one.diameter == pytest.approx(diameter / 1e3)
    assert row.source == source
    assert row.axial_stiffness == rope.axial_stiffness
    assert 0.8e7 < rope.axial_stiffness / rope.mass_per_length < 1.2e7


def test_the_catalogue_is_complete_and_has_its_sources() -> None:
    table = rw.ropes()
    assert set(QUOTED) <= set(table.index)
    assert table.index.is_unique
    assert table.notna().all(axis=None)
    assert (table["source"].str.len() > 5).all()
    assert table["diameter"].between(0.008, 0.04).all()
    by_factors = table[table["use"] == "EN 12385-4"]
    assert len(by_factors) == 17 * len(SIZES) >= 60
    assert table.attrs["units"]["axial_stiffness"] == "N"
    for name in table.index:
        assert rw.Rope.named(name).name == name


def test_ropes_by_factors() -> None:
    """The values that API 9A prints for 6x7 with a fibre core: mass [kg/100 m], strength in grade 1770 [kN]."""
    table = rw.ropes()
    for mm, mass, strength in ((8, 22.1, 37.6), (16, 88.3, 150.0), (28, 270.0, 461.0), (40, 552.0, 940.0)):
        row = table.loc[f"6x7 FC {mm} 1770"]
        assert row.mass_per_length * 100.0 == pytest.approx(mass, rel=3e-3)
        assert row.breaking_load / 1e3 == pytest.approx(strength, rel=3e-3)
    light, heavy = table.loc["HMPE 20"], table.loc["6x19 IWRC 20 1960"]
    assert light.mass_per_length < heavy.mass_per_length / 7.0
    assert light.breaking_load > 0.8 * heavy.breaking_load


def test_ropes_of_ones_own(tmp_path: Path) -> None:
    csv, toml = tmp_path / "ropes.csv", tmp_path / "ropes.toml"
    csv.write_text("name,diameter [mm],mass_per_length [lb/ft],breaking_load [kip]\nours,25.4,1.85,103.4\n")
    toml.write_text('[[rope]]\nname = "thin"\n"diameter [mm]" = 11\nmass_per_length = 0.5\n"breaking_load [kN]" = 99\n'
                    'axial_stiffness = 5e6\nsource = "tag on the drum"\n')  # fmt: skip
    table = rw.ropes(csv, toml)
    assert list(table.index[:2]) == ["ours", "thin"]
    ours, thin = rw.Rope.named("ours", catalogue=csv), rw.Rope.named("thin", catalogue=toml)
    assert ours.mass_per_length == pytest.approx(1.85 * rw.units.POUND_PER_FOOT)
    assert ours.breaking_load == pytest.approx(103.4 * rw.units.KIP)
    assert ours.axial_stiffness == pytest.approx(93.1e9 * ours.mass_per_length / 9300.0)
    assert (thin.axial_stiffness, thin.diameter, table.loc["thin", "source"]) == (5e6, 0.011, "tag on the drum")
    csv.write_text("name,diameter,mass_per_length,breaking_load\nours,0.02,-1,1e5\n")
    with pytest.raises(rw.InputError, match=r"ropes.csv, line 2, column mass_per_length: 'ours': mass_per"):
        rw.ropes(csv)
    toml.write_text("[[rope]\n")
    with pytest.raises(rw.InputError, match=r"ropes.toml"):
        rw.ropes(toml)
    with pytest.raises(rw.UnknownNameError, match=r"Near are .*'RHOL-IWRC 29'"):
        rw.Rope.named("RHOL-IWRC 28")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name,diameter,mass_per_length,breaking_load\nA,0.02,2,3e5\nB,0.02,2,3e5\nA,0.022,2,4e5\n",
         "line 4, column name: 'A' is also in line 2"),
        ("name,diameter,mass_per_length,breaking_load,axial_stifness [MN]\nA,0.02,2,3e5,20\n", "Is it axial_stiffness"),
        ("name,diameter,mass_per_length,breaking_load,Modulus [GPa],elastic_modulus\nA,0.02,2,3e5,100,1\n", ""),
    ],
)  # fmt: skip
def test_names_and_columns_of_a_table_of_ones_own(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "own.csv").write_text(text)
    if words:
        with pytest.raises(rw.InputError, match=words):
            rw.ropes(tmp_path / "own.csv")
    else:
        assert rw.ropes(tmp_path / "own.csv").loc["A", "axial_stiffness"] == pytest.approx(100e9 * 2.0 / 9300.0)


def test_weather_of_a_rope_of_ones_own() -> None:
    own = pd.DataFrame({"name": ["A", "B"], "diameter": 0.02, "mass_per_length": 2.0, "breaking_load": 3e5,
                        "thermal_expansion": [1.2e-5, None], "Drag_Coefficient": [None, 0.9]})  # fmt: skip
    one, other = (rw.Rope.named(name, catalogue=own) for name in "AB")
    assert (one.thermal_expansion, one.drag_coefficient) == (1.2e-5, 1.1)
    assert (other.thermal_expansion, other.drag_coefficient) == (11.5e-6, 0.9)


def test_machines(tmp_path: Path) -> None:
    assert rw.yarders().loc["Koller K602 with extension", "tower_height"] == pytest.approx(45.0 * rw.units.FOOT)
    assert rw.yarders()["source"].str.len().gt(5).all()
    assert list(rw.carriages().columns) == ["mass", "payload", "source"]
    own = tmp_path / "carriages.csv"
    own.write_text("name,mass [lb],source\nold one,1000,weighed\n")
    row = rw.carriages(own).loc["old one"]
    assert row["mass"] == pytest.approx(1000.0 * rw.units.POUND)
    assert math.isnan(row["payload"])


def test_units_of_scripts() -> None:
    units = rw.units
    assert (0.3048, 0.45359237, pytest.approx(1609.344)) == (units.FOOT, units.POUND, units.MILE)
    assert pytest.approx(4448.2216152605) == units.KIP
    assert pytest.approx(9806.65) == units.TONNE_FORCE
    assert pytest.approx(907.18474) == units.SHORT_TON
    assert pytest.approx(745.69987158) == units.HORSEPOWER


def test_safe_working_load() -> None:
    assert ROPE.safe_working_load == pytest.approx(450.3e3 / 3.0)
    assert rw.Rope.named("6x19 EEIP 25", safety_factor=2.5).safe_working_load == pytest.approx(450.3e3 / 2.5)


def test_elastic_strain() -> None:
    assert ROPE.strain.at(60e3) == pytest.approx(60e3 / 24.0e6)
    assert ROPE.strain.potential(60e3) == pytest.approx(60e3 + 60e3**2 / (2.0 * 24.0e6))


def test_construction_strain() -> None:
    """Lyons 2008, eq. 14: T/EA + 0.0414 (T/MBL)^2."""
    rope = rw.Rope(mass_per_length=2.4, axial_stiffness=24.0e6, breaking_load=450.3e3, stretch=rw.ConstructionStretch())
    assert rope.strain.at(150.1e3) == pytest.approx(150.1e3 / 24.0e6 + 0.0414 / 9.0)
    stiff = rw.Rope(
        mass_per_length=2.4, axial_stiffness=math.inf, breaking_load=450.3e3, stretch=rw.ConstructionStretch(0.09)
    )
    assert stiff.strain.at(150.1e3) == pytest.approx(0.01)


def test_ropes_are_values() -> None:
    assert rw.Rope(mass_per_length=2.4, axial_stiffness=24.0e6, breaking_load=450.3e3) == ROPE
    with pytest.raises(AttributeError):
        ROPE.mass_per_length = 1.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mass_per_length": 3480.0}, r"mass_per_length is 3480\.0 kg/m, which no rope has.*kg/km"),
        ({"axial_stiffness": 34.8}, r"axial_stiffness is 34\.8 N.*MN"),
        ({"axial_stiffness": 34.8e3}, r"axial_stiffness is 34800\.0 N.*kN"),
        ({"breaking_load": 576.6}, r"breaking_load is 576\.6 N.*kN"),
        ({"diameter": 28.6}, r"diameter is 28\.6 m.*mm"),
    ],
)
def test_data_sheet_units_are_errors(change: dict[str, float], words: str) -> None:
    real = {"mass_per_length": 3.48, "axial_stiffness": 34.8e6, "breaking_load": 576.6e3, "diameter": 0.0286}
    with pytest.raises(rw.InputError, match=words):
        rw.Rope(**{**real, **change})  # type: ignore[arg-type]
    assert rw.Rope(**real).safe_working_load == pytest.approx(192.2e3)  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="mm"):
        rw.Rope.from_construction("6x19 IWRC", 26.0)
