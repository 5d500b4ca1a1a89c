"""Ropes: constructors, stretch laws, the table of named ropes."""

from __future__ import annotations

import math

import pytest

import ropeway as rw
from ropeway.components.rope import CONSTRUCTIONS

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24.0e6, breaking_load=450.3e3)

# EN 12385-4: W, C, K
FACTORS = {
    "6x19 IWRC": (0.400, 0.449, 0.356),
    "6x36 IWRC": (0.409, 0.460, 0.356),
    "6x19 FC": (0.359, 0.384, 0.330),
    "6x36 FC": (0.367, 0.393, 0.330),
}

# mm, kg/m, kN
QUOTED = {
    "compacted skyline 20": (20.0, 1.98, 356.0, "SEILAPLAN"),
    "compacted skyline 22": (22.0, 2.37, 424.0, "SEILAPLAN"),
    "6x19 EEIP 19": (19.05, 1.4, 256.3, "Lyons 2008"),
    "6x19 EEIP 25": (25.4, 2.4, 450.3, "Lyons 2008"),
    "RHOL-IWRC 29": (28.6, 3.48, 576.6, "Harvey 2013"),
}


def test_all_constructions_are_there() -> None:
    assert {name: (c.mass, c.area, c.strength) for name, c in CONSTRUCTIONS.items()} == FACTORS


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


def test_the_table_is_complete() -> None:
    table = rw.ropes()
    assert set(table.index) == set(QUOTED)
    assert table.notna().all(axis=None)


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
