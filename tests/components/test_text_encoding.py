"""Encodings of text files: names as they were written, or an error; a warning where nobody can know."""

import warnings
from pathlib import Path

import pytest

import ropeway as rw
from ropeway.components.text_encoding import decoded

PATH = Path("supports.csv")


def table(*names: str) -> str:
    return "name,x,y,z,kind\n" + "".join(f"{name},{10 * i},0,0,idler\n" for i, name in enumerate(names))


@pytest.mark.parametrize(
    "names",
    [
        ("Stütze 1", "Höhe über Straße", "Ärmel"),
        ("Vallée", "Châtel", "façade", "l\u2019été"),
        ("Peña", "Río Ñuble"),
        ("Nº 4", "§ 3", "12 m³", "5°", "±1", "„Alm“", "«ici»", "Ost\u2013West", "10 µm", "½"),
    ],
)
def test_western_names_are_read(names: tuple[str, ...]) -> None:
    text = table(*names)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if "Peña" in names else "error", rw.RopewayWarning)
        assert decoded(PATH, text.encode("cp1252")) == text


@pytest.mark.parametrize(
    ("names", "encoding"),
    [
        (("Stožár", "Příčka", "Údolní stanice"), "cp1250"),
        (("Věra", "Důl"), "cp1250"),
        (("Słup 2", "Górna"), "cp1250"),
        (("Piątka",), "cp1250"),
        (("Łódź",), "cp1250"),
        (("Poznań",), "cp1250"),
        (("Šoštanj",), "cp1250"),
        (("Słupek żelazny", "Dół"), "iso8859-2"),
        (("Опора", "Станция"), "cp1251"),
        (("Опора",), "koi8-r"),
        (("Στήριξη",), "cp1253"),
        (("Y\u0131ld\u0131z Da\u011f\u0131", "I\u011fd\u0131r"), "cp1254"),
        (("支柱一", "谷側"), "shift-jis"),
        (("支柱", "山側停留場"), "euc-jp"),
        (("ｼﾞｭｳ", "ﾀﾆ"), "shift-jis"),
        (("支柱", "下站"), "gb2312"),
        (("Höhe", "Stätte"), "cp850"),
        (("Höhe", "Stütze"), "mac-roman"),
    ],
)
def test_other_code_pages_are_refused(names: tuple[str, ...], encoding: str) -> None:
    for line_end in ("\n", "\r\n"):
        data = table(*names).replace("\n", line_end).encode(encoding)
        with pytest.raises(rw.InputError, match=r"supports\.csv has an unknown encoding.*Save the table as CSV UTF-8"):
            decoded(PATH, data)


@pytest.mark.parametrize(
    ("name", "encoding", "read_as"),
    [("Rivière", "cp1252", "Rivière"), ("Sørli", "cp1252", "Sørli"), ("Kočka", "cp1250", "Koèka")],
)
def test_ambiguous_code_pages_warn(name: str, encoding: str, read_as: str) -> None:
    with pytest.warns(rw.RopewayWarning, match=f"names such as '{read_as}'.*save it as CSV UTF-8"):
        assert read_as in decoded(PATH, table("a", name).encode(encoding))


def test_a_table_asks_for_its_encoding(tmp_path: Path) -> None:
    path = tmp_path / "line.csv"
    path.write_bytes(table("Věž 1", "Věž 2").encode("cp1250"))
    with pytest.raises(rw.InputError, match=r"line\.csv has an unknown encoding.*'Vìž'.*UTF-8"):
        rw.monocable(rw.Rope(mass_per_length=2.0, axial_stiffness=2e7, breaking_load=3e5), path, tension=3e4)
