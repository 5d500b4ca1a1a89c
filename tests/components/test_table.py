"""Tables as people write them: the same numbers, or an error that says where and what."""

from __future__ import annotations

import codecs
import math
import re
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest
from hypothesis import example, given, strategies as st

import ropeway as rw
from ropeway.components import table
from ropeway.components.identifier import identifier

GROUND = table.TableLayout({"station": "m", "elevation": "m", "remark": None}, "station,elevation,remark\n0,846.4,road")
ROWS = [(0.0, 1846.25, "Bach"), (12.5, 1840.5, 'Weg "alt"'), (1033.75, 1790.0, "Höhe; oben, links")]


def read(path: Path) -> list[tuple[float, float, str]]:
    found = table.read(path, GROUND)
    values = found.numbers("station", "elevation")
    return [(*row, text) for row, text in zip(values.tolist(), found.texts("remark"), strict=True)]


def number(value: float, mark: str, groups: str) -> str:
    """A number with a decimal mark, its thousands set apart."""
    whole, _, part = f"{value:,.6f}".rstrip("0").rstrip(".").partition(".")
    return whole.replace(",", groups) + (mark + part if part else "")


def quoted(text: str, separator: str) -> str:
    return '"' + text.replace('"', '""') + '"' if separator in text or '"' in text else text


def write(rows: list[tuple[float, float, str]], separator: str, mark: str, groups: str = "", pad: str = "") -> str:
    lines = [["Station", "ELEVATION", "Remark"]]
    lines += [[number(a, mark, groups), number(b, mark, groups), text] for a, b, text in rows]
    return "".join(separator.join(pad + quoted(c, separator) + pad for c in line) + "\n" for line in lines)


ENCODINGS = ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "latin-1", "cp1252"]
SEPARATORS = [",", ";", "\t", "|"]


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("separator", SEPARATORS)
@pytest.mark.parametrize(
    ("mark", "groups"), [(".", ""), (",", ""), (".", "'"), (",", "."), (",", " "), (".", ","), (",", "\xa0")]
)
def test_one_table_in_many_dialects(tmp_path: Path, encoding: str, separator: str, mark: str, groups: str) -> None:
    path = tmp_path / "ground.csv"
    path.write_bytes(write(ROWS, separator, mark, groups, " " if separator != "\t" else "").encode(encoding))
    assert read(path) == ROWS


DECIMALS = st.decimals(-99999, 99999, places=3).map(float)
DIALECT = st.tuples(
    st.sampled_from(SEPARATORS), st.sampled_from(".,"), st.sampled_from(["", "'", "\u2019", " ", "\u202f", "other"])
)


@given(rows=st.lists(st.tuples(DECIMALS, DECIMALS), min_size=1, max_size=5), dialect=DIALECT)
@example(rows=[(1.234, 5.678)], dialect=(";", ".", ""))
@example(rows=[(1234.0, 5.0)], dialect=(";", ",", "other"))
@example(rows=[(1234.0, 5.5)], dialect=("|", ",", "other"))
def test_never_another_number(
    rows: list[tuple[float, float]], dialect: tuple[str, str, str], tmp_path_factory: pytest.TempPathFactory
) -> None:
    """The same numbers, or an error where a mark can be read in two ways."""
    separator, mark, groups = dialect
    groups = {".": ",", ",": "."}[mark] if groups == "other" else groups
    path = tmp_path_factory.getbasetemp() / "random.csv"
    path.write_text(write([(*row, "x") for row in rows], separator, mark, groups), encoding="utf-8")
    try:
        found = read(path)
    except rw.InputError as error:
        if "decimal point and" not in str(error):
            raise
        can_be_thousands = re.compile(r"-?[1-9]\d{0,2}[.,]\d{3}")  # 1.234 and 1,234
        assert separator != "," or mark == "," or groups == ","
        assert not any(re.search(r"[.,]\d{1,2}$", number(v, mark, groups)) for row in rows for v in row)
        assert any(can_be_thousands.fullmatch(number(v, mark, groups)) for row in rows for v in row)
        return
    assert [row[:2] for row in found] == rows


@pytest.mark.parametrize(
    ("cells", "expected"),
    [
        (["1'234.5", "12"], [1234.5, 12.0]),
        (["1\u2019234\u2019567", "-0,5"], [1234567.0, -0.5]),
        (["1 234,5", "2.345"], [1234.5, 2345.0]),
        (["1,234", "2.5"], [1234.0, 2.5]),
        (["1,234", "2,5"], [1.234, 2.5]),
        (["1,234", "0,500"], [1.234, 0.5]),
        (["1.234.567", "3,25"], [1234567.0, 3.25]),
        (["1,234,567", "3.25"], [1234567.0, 3.25]),
        (["1234,567", "8"], [1234.567, 8.0]),
        (["\u22122,5e3", "+.5e1".replace(".", ",")], [-2500.0, 5.0]),
        (["1.500e-3", "7"], [0.0015, 7.0]),
    ],
)
def test_numbers(cells: list[str], expected: list[float], tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("time;speed\n" + ";".join(cells) + "\n")
    found = table.read(path, table.TableLayout({"time": "s", "speed": "m/s"}, "time,speed\n0,1"))
    assert found.numbers("time", "speed")[0].tolist() == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time;speed\n1.234;5\n", "line 2, column time: '1.234' is 1.234 with a decimal point and 1234"),
        ("time;speed\n-2,345;5\n", "Write -2345 without a thousands separator, or -2,3450 for a decimal"),
        ("time;speed\n0;1,5\n3;2.5\n", "line 3, column speed: '2.5' and '1,5' have different decimal marks"),
        ("time;speed\n0;1\n\n3;12 m/s\n", "line 4, column speed: '12 m/s' is not a number"),
        ("time;speed\n0;1\n3;1_000\n", "line 3, column speed: '1_000' is not a number"),
        ("time;speed\n0;1\n3;1'23\n", "line 3, column speed"),
        ("time;speed\n0;1\n3;1.234.5\n", "line 3, column speed"),
        ("time;speed\n0;1\n3;\n", "line 3, column speed: the cell is blank"),
        ("time;speed\n0;1\n3;NaN\n", "line 3, column speed: 'NaN' is not a finite number"),
        ("time;speed\n0;-inf\n", "line 2, column speed"),
        ("time,speed\n0,1\n3,2,5\n", "line 3: 3 values in a table of 2 columns"),
        ("time,speed\n# a comment\n0,1\n3\n", "line 4: 1 values in a table of 2 columns"),
        ("time,speed,speed\n0,1,2\n", "line 1: two columns are named 'speed'"),
        ("time,speed,Speed\n0,1,2\n", "line 1: two columns are named 'Speed'"),
        ("time,speed,\n0,1,2\n", "line 1: column 3 has no name"),
        ("\n# written by hand\ntime,sped\n0,1\n", "line 3: no column speed. Is it the column 'sped'?"),
        ("0,1\n1,2\n", "Its first line holds numbers"),
        ("time,speed\n", "no rows"),
        ("# nothing\n\n", "has no rows"),
        ("", "is empty"),
        (" \n\n", "is empty"),
        ('time,speed\n0,"1\n2,3\n', "line 3"),
        ("time [h],speed [furlong]\n0,1\n", "column speed [furlong]: The unit 'furlong' is unknown"),
        ("time [h],speed [N]\n0,1\n", "measure different quantities"),
        ("time,speed\n0,1\n#REF!,2\n9,3\n", "line 3, column time: '#REF!' is not a number"),
        ("time;speed\n0;1\n#NV;2\n9;3\n", "line 3, column time: '#NV' is not a number"),
        ("time;speed\n3;1\n2;1\n", "line 3: time does not increase: 2 s after 3 s"),
    ],
)
def test_errors_name_the_place_and_show_an_example(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "plan.csv"
    path.write_text(text)
    with pytest.raises(rw.InputError) as error:
        rw.Schedule.from_csv(path)
    assert words in str(error.value)
    assert str(path) in error.value.cause
    assert "An example: time,speed / 0,0.5 / 10,1" in error.value.remedy


def test_files_without_a_table(tmp_path: Path) -> None:
    for name, data, words in (
        ("old.xls", b"\xd0\xcf\x11\xe0" + bytes(100), "before 2007"),
        ("packed.csv", b"\x1f\x8b\x08" + bytes(100), "compressed"),
        ("broken.xlsx", b"PK\x03\x04" + bytes(100), "cannot be read as an Excel file"),
        ("picture.csv", b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "not a text file"),
        ("zeros.csv", bytes(1000), "not a text file"),
        ("half.csv", codecs.BOM_UTF16_LE + b"a\0b", "not a text file"),
    ):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(rw.InputError, match=words):
            rw.Schedule.from_csv(tmp_path / name)
    for path in (tmp_path, tmp_path / "none.csv", "a\0b.csv", tmp_path / ("n" * 300)):
        with pytest.raises(rw.InputError, match=r"folder|no file|cannot be read|NUL"):
            rw.Profile.from_csv(path)
    for wrong in (None, 3, b"plan.csv", {"time": [0]}, [0, 1]):
        with pytest.raises(rw.InputError, match="DataFrame"):
            rw.Profile.from_csv(wrong)  # type: ignore[arg-type]


def test_an_unreadable_file_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "plan.csv"
    path.write_text("time,speed\n0,1\n")

    def refuse(self: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(rw.InputError, match=r"plan\.csv cannot be read: Permission denied"):
        rw.Schedule.from_csv(path)


def test_units_in_a_header_are_converted(tmp_path: Path) -> None:
    path = tmp_path / "ground.csv"
    path.write_text("Station (ft); Elevation [km]\n0;1,5\n100;1,6\n")
    ground = rw.Profile.from_csv(path)
    np.testing.assert_allclose(ground.station, [0.0, 30.48])
    np.testing.assert_allclose(ground.elevation, [1500.0, 1600.0])
    path.write_text("time;Temperature [degF];wind_from [rad]\n0;14;3,141592653589793\n")
    assert rw.Schedule.from_csv(path, "temperature").speeds == pytest.approx([-10.0])  # degrees C, as in an Environment
    assert rw.Schedule.from_csv(path, "wind_from").speeds == pytest.approx([180.0])
    path.write_text("time,unit.speed [rpm]\n0,60\n")
    assert rw.Schedule.from_csv(path, "unit.speed").speeds == pytest.approx([2.0 * np.pi])
    path.write_text("time [min],c1.speed [km/h]\n0,3.6\n2,7.2\n")
    assert rw.Schedule.from_csv(path, "c1.speed") == rw.Schedule([0.0, 120.0], [1.0, 2.0])


def excel(path: Path, sheets: dict[str, list[list[object]]]) -> Path:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def test_excel_files(tmp_path: Path) -> None:
    rows: list[list[object]] = [
        ["# surveyed in May"],
        [],
        ["Station", "Elevation", "Bemerkung"],
        [0, 846.4, "Weg"],
        [10.5, "840,1"],
    ]
    ground = rw.Profile.from_csv(excel(tmp_path / "one.xlsx", {"Tabelle1": rows}))
    assert ground.elevation.tolist() == [846.4, 840.1]
    many = {"Deckblatt": [["Titel"], ["Profil 3"]], "Profil": rows, "leer": []}
    assert rw.Profile.from_csv(excel(tmp_path / "many.xlsx", many)).station.tolist() == [0.0, 10.5]
    with pytest.raises(rw.InputError, match=r"several sheets.*'A', 'B'"):
        rw.Profile.from_csv(excel(tmp_path / "two.xlsx", {"A": rows, "B": rows}))
    bad: list[list[object]] = [["station", "elevation"], [0, 846.4], [10, True]]
    with pytest.raises(rw.InputError, match="sheet S, row 3, column elevation: True is not a number"):
        rw.Profile.from_csv(excel(tmp_path / "bad.xlsx", {"S": bad}))
    lost: list[list[object]] = [["station", "elevation"], [0, 846.4], ["#DIV/0!", 840], [10, 835]]
    with pytest.raises(rw.InputError, match="row 3, column station: '#DIV/0!' is not a number"):
        rw.Profile.from_csv(excel(tmp_path / "lost.xlsx", {"S": lost}))
    beyond: list[list[object]] = [["station", "elevation"], [0, 846.4], [10, 840, 1]]
    with pytest.raises(rw.InputError, match="row 1: column 3 has no name"):
        rw.Profile.from_csv(excel(tmp_path / "beyond.xlsx", {"S": beyond}))
    with pytest.raises(rw.InputError, match="is empty"):
        rw.Profile.from_csv(excel(tmp_path / "blank.xlsx", {"S": []}))


def test_excel_without_openpyxl_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = excel(tmp_path / "one.xlsx", {"S": [["station", "elevation"], [0, 1], [2, 3]]})
    monkeypatch.setitem(__import__("sys").modules, "openpyxl", None)
    with pytest.raises(rw.InputError, match=r"ropeway\[excel\]"):
        rw.Profile.from_csv(path)


def test_frames_go_through_the_same_checks() -> None:
    frame = pd.DataFrame({"Time": [0, 1.5], "speed": ["1,5", "2,5"], "remark": [None, "x"]})
    assert rw.Schedule.from_csv(frame).speeds == (1.5, 2.5)
    with pytest.raises(rw.InputError, match="the DataFrame, row 1, column speed: the cell is blank"):
        rw.Schedule.from_csv(pd.DataFrame({"time": [0, 1], "speed": [1.0, math.nan]}))
    with pytest.raises(rw.InputError, match="row 0, column speed: True is not a number"):
        rw.Schedule.from_csv(pd.DataFrame({"time": [0, 1], "speed": [True, False]}))
    with pytest.raises(rw.InputError, match="the DataFrame: two columns are named 'speed'"):
        rw.Schedule.from_csv(pd.DataFrame([[0, 1, 2]], columns=["time", "speed", "speed"]))


@pytest.mark.parametrize(
    ("label", "name"),
    [
        ("Stütze 7", "Stuetze_7"),
        ("Stu\u0308tze", "Stuetze"),
        ("Straße", "Strasse"),
        ("Ärger", "Aerger"),
        ("Søre Ås", "Soere_As"),
        ("Châtel-St-Denis", "Chatel_St_Denis"),
        ("Łódź", "Lodz"),
        ("3a", "n3a"),
        (" a_b ", "a_b"),
        ("NA", "NA"),
        ("опора 2", "______2"),
    ],
)
def test_identifiers(label: str, name: str) -> None:
    assert identifier(label) == name


@given(st.text(alphabet="aZ09 _-äÖßéøŁıя\u0301½٣", min_size=1))
def test_any_text_is_a_name(label: str) -> None:
    if label.strip():
        name = identifier(label)
        assert name.isidentifier()
        assert name.isascii()
        assert identifier(name) == name


@pytest.mark.slow
def test_large_tables(tmp_path: Path) -> None:
    """A million numbers: nothing in the reader grows faster than the table."""
    count = 500_000
    path = tmp_path / "large.csv"
    path.write_text("station;elevation\n" + "".join(f"{i},25;{i % 977},5\n" for i in range(count)))
    ground = rw.Profile.from_csv(path)
    assert ground.station[-1] == count - 1 + 0.25
