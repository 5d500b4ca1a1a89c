"""Tables of supports in practice: names, kinds, and values of drives and responses."""

from pathlib import Path

import pandas as pd
import pytest

import ropeway as rw
from ropeway.components.node import Node
from support.drives import hydraulic_drive

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
DRIVE = hydraulic_drive(
    displacement=100e-6,
    gear_ratio=5.0,
    sheave_radius=0.4,
    relief_pressure=300e5,
    pump_flow=2e-3,
    engine_power=40e3,
    inertia=300.0,
)
HEADER = "name;x;y;z;kind"
ENDS = ("Tal;0;0;0;drum", "Berg;270,5;0;14;drum")


def table(
    folder: Path, *rows: str, header: str = HEADER, ends: tuple[str, str] = ENDS, encoding: str = "utf-8"
) -> Path:
    path = folder / "line.csv"
    path.write_text("\n".join([header, ends[0], *rows, ends[1]]) + "\n", encoding=encoding)
    return path


def line(path: Path | pd.DataFrame, **more: object) -> rw.System:
    return rw.monocable(ROPE, path, tension=45e3, **{"speed": 0.0, **more})  # type: ignore[arg-type]


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_any_text_is_a_name(tmp_path: Path, encoding: str) -> None:
    made = line(
        table(tmp_path, "Fußweg Süd;90;0;5,5;Idler", "4b;180;1,5;9;IDLER", "NA;200;1;9;idler", encoding=encoding)
    )
    names = [n for n, c in made.components.items() if isinstance(c, Node)]
    assert names == ["Tal", "Fussweg_Sued", "n4b", "NA", "Berg"]
    labels = [c.label for c in made.components.values() if isinstance(c, Node)]
    assert labels == ["Tal", "Fußweg Süd", "4b", "NA", "Berg"]
    assert rw.equilibrium(made)["n4b_NA.tension_a"] > 40e3
    assert made.components["n4b"].at == (180.0, 1.5, 9.0)


def test_numbers_in_a_frame_are_names() -> None:
    frame = pd.DataFrame(
        {"name": [1.0, 2, 3], "x": [0, 80, 160], "y": 0, "z": [0, 4, 2], "kind": ["drum", "idler", "drum"]}
    )
    assert [c.label for c in line(frame).components.values() if isinstance(c, Node)] == ["1", "2", "3"]


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (
            ("s 1;90;0;5;idler", "s-1;180;0;9;idler"),
            "line 4, column name: 's-1' and 's 1' (line 3) both become the name 's_1'",
        ),
        (("s1;90;0;5;idler", "s1;180;0;9;idler"), "line 4, column name: 's1' is also the name of line 3"),
        ((" ;90;0;5;idler",), "line 3, column name: a support has no name"),
        (("null;90;0;5;roller",), "line 3: kind of 'null' is 'roller'"),
        (("s1;90;0;5,5;idler;",), "line 3: 6 values in a table of 5 columns"),
    ],
)
def test_names_and_kinds_that_are_rejected(tmp_path: Path, rows: tuple[str, ...], words: str) -> None:
    with pytest.raises(rw.InputError) as error:
        line(table(tmp_path, *rows))
    assert words in str(error.value)
    assert "An example: name,x,y,z,kind" in str(error.value)


OWN = "name;x;y;z;kind;{}"


def owned(folder: Path, column: str, value: str, kind: str = "control") -> Path:
    rows = ("s1;90;0;5;idler;", f"c1;180;0;9;{kind};{value}")
    return table(folder, *rows, header=OWN.format(column), ends=("a;0;0;0;drum;", "b;270;0;14;drum;"))


@pytest.mark.parametrize(
    ("column", "value", "found"),
    [
        ("drive.relief_pressure", "2,5e7", 2.5e7),
        ("Drive.Engine_Power", "30000", 30e3),
        ("drive.recovers", "no", False),
        ("drive.recovers", "1", True),
    ],
)
def test_values_of_a_drive(tmp_path: Path, column: str, value: str, found: object) -> None:
    sheave = line(owned(tmp_path, column, value), drive=DRIVE).components["c1"]
    assert isinstance(sheave, rw.ControlSheave)
    assert getattr(sheave.drive, column.casefold().removeprefix("drive.")) == found
    assert type(getattr(sheave.drive, column.casefold().removeprefix("drive."))) is type(found)


@pytest.mark.parametrize(
    ("column", "value", "kind", "words"),
    [
        (
            "drive.engine_pwer",
            "",
            "control",
            "line 1, column drive.engine_pwer: a drive has no 'engine_pwer'. Did you mean drive.engine_power?",
        ),
        ("response.colour", "1", "control", "a response has no 'colour'"),
        ("drive.engine_power", "3e4", "idler", "line 4, column drive.engine_power: 'c1' is not a control sheave"),
        (
            "response.increment",
            "0,02",
            "control",
            "line 4, column response.increment: the response of 'c1' has no values",
        ),
        ("drive.engine_power", "much", "control", "line 4, column drive.engine_power: 'much' is not a number"),
    ],
)
def test_values_without_a_use_are_rejected(tmp_path: Path, column: str, value: str, kind: str, words: str) -> None:
    with pytest.raises(rw.InputError) as error:
        line(owned(tmp_path, column, value, kind), drive=DRIVE)
    assert words in str(error.value)


def test_an_ideal_drive_has_no_values(tmp_path: Path) -> None:
    with pytest.raises(rw.InputError, match="it is ideal"):
        line(owned(tmp_path, "drive.engine_power", "3e4"))


def test_drives_are_named_as_in_the_table(tmp_path: Path) -> None:
    path = table(tmp_path, "Stütze 1;90;0;5;control")
    for name in ("Stütze 1", "Stuetze_1"):
        assert line(path, drive={name: DRIVE}).components["Stuetze_1"].drive == DRIVE  # type: ignore[attr-defined]
    with pytest.raises(rw.InputError, match="'Stütze' is not a control sheave"):
        line(path, drive={"Stütze": DRIVE})


def test_endless_lines_take_the_same_tables(tmp_path: Path) -> None:
    rows = [
        "Antrieb;0;0;0;Control;2,8e7",
        "Stütze hin;100;0;5;idler;",
        "Umlenkung;200;1,5;6;return;",
        "Stütze her;100;3;5;idler;",
    ]
    path = tmp_path / "loop.csv"
    path.write_text("\n".join([OWN.format("drive.relief_pressure"), *rows]), encoding="latin-1")
    made = rw.endless(ROPE, path, tension=45e3, speed=0.5, drive=DRIVE, load_mass=50.0, load_spacing=40.0)
    assert made.components["Antrieb"].drive.relief_pressure == 2.8e7  # type: ignore[attr-defined]
    assert made.components["Stuetze_hin"].label == "Stütze hin"  # type: ignore[attr-defined]
    path.write_text(path.read_text("latin-1").replace("drive.relief_pressure", "response.increment"))
    with pytest.raises(rw.InputError, match="response of 'Antrieb'"):
        rw.endless(ROPE, path, tension=45e3, drive=DRIVE)


def test_a_table_of_the_terrain_is_rejected_at_once() -> None:
    frame = pd.DataFrame({"name": range(30_000), "x": range(30_000), "y": 0, "z": 0, "kind": "idler"})
    with pytest.raises(rw.InputError, match=r"30000 supports.*terrain"):
        line(frame)


@pytest.mark.parametrize("spacing", [1e-9, 1e-300, 0.005])
def test_a_spacing_too_small_is_rejected_before_loads_are_created(tmp_path: Path, spacing: float) -> None:
    with pytest.raises(rw.InputError, match=r"feed would make .* loads"):
        line(table(tmp_path, "s1;90;0;5;idler"), load_mass=1.0, load_spacing=spacing)
