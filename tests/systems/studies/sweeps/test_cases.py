"""Cases of a sweep from a file."""

from pathlib import Path

import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.studies.sweeps.cases import table_of


def test_a_file_equals_a_frame(tmp_path: Path) -> None:
    path = tmp_path / "cases.csv"
    path.write_text("Pull;count;kind\n1'500,5;3;a\n2000;4;NA\n", encoding="utf-16")
    expected = pd.DataFrame({"Pull": [1500.5, 2000.0], "count": [3, 4], "kind": ["a", "NA"]})
    pd.testing.assert_frame_equal(table_of(path), expected.rename_axis("case"), check_dtype=False)
    assert table_of(str(path))["count"].dtype.kind == "i"


def test_a_sweep_takes_a_path(tmp_path: Path) -> None:
    path = tmp_path / "cases.csv"
    path.write_text("pull,count\n10.0,2\n20.5,3\n")

    def study(pull: float, count: int) -> float:
        return pull * count

    assert rw.sweep(study, path, workers=1)["value"].tolist() == [20.0, 61.5]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a,b\n1,2\n3\n", "line 3: 1 values in a table of 2 columns"),
        ("a,b\n1,2\nx,3\n", "line 3, column a: 'x' is not a number"),
        ("a,b\n1,x\n2,\n", "line 3, column b: the cell is blank"),
        ("a,a\n1,2\n", "two columns are named 'a'"),
    ],
)
def test_bad_cases(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "cases.csv"
    path.write_text(text)
    with pytest.raises(rw.InputError, match=words):
        table_of(path)


def drives() -> rw.System:
    line = rw.System("drives")
    rope = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450e3)
    ends = rw.Drum("d", at=(0.0, 0.0), speed=1.0), rw.Anchor("e", at=(90.0, 4.0))
    line.hang(rw.Load("l", mass=200.0), line.string(rope, *ends, length=90.4), at=30.0)
    return line


def test_units_in_the_names_of_a_lines_parameters(tmp_path: Path) -> None:
    """A file, a DataFrame and a mapping give the same as values in the line's own units."""
    path = tmp_path / "cases.csv"
    path.write_text("d.speed [km/h];l.mass (t);d_e.compliance [1/kN]\n1,8;0,25;4e-5\n3,6;0,3;5e-5\n")
    feet = {"d.speed [ft/min]": [0.5 / 0.00508, 1.0 / 0.00508], "l.mass [g]": [250e3, 300e3]}
    own = {"d.speed": [0.5, 1.0], "l.mass": [250.0, 300.0], "d_e.compliance": [4e-8, 5e-8]}

    def swept(cases: pd.DataFrame | Path) -> pd.DataFrame:
        return rw.sweep(drives(), cases, outputs=["d_e.tension_a"], workers=1)

    wanted = swept(pd.DataFrame(own))
    for given in (path, pd.DataFrame({**feet, "d_e.compliance": own["d_e.compliance"]})):
        found = swept(given)
        pd.testing.assert_frame_equal(found, wanted, rtol=1e-12)
        assert [found.attrs["units"][name] for name in own] == ["m/s", "kg", "1/N"]
    grid = rw.sweep(drives(), {"l.mass [lb]": [100.0, 200.0]}, outputs="d_e.tension_a", workers=1)
    assert grid["l.mass"].tolist() == pytest.approx([45.359237, 90.718474])


def test_units_in_the_names_of_a_functions_parameters_become_si() -> None:
    def study(**case: object) -> str:
        return repr(sorted(case.items()))

    cases = pd.DataFrame({"drive speed [km/h]": [36, 72], "v[2]": [1, 2], "kind (old)": ["a", "b"]})
    assert rw.sweep(study, cases, workers=1)["value"].tolist() == [
        "[('drive speed', 10.0), ('kind (old)', 'a'), ('v[2]', 1)]",
        "[('drive speed', 20.0), ('kind (old)', 'b'), ('v[2]', 2)]",
    ]


@pytest.mark.parametrize(
    ("column", "words"),
    [
        ("d.speed [kN]", "'d.speed \\[kN\\]': 'kN' and 'm/s' measure different quantities"),
        ("l.mass [stone]", "'stone' is unknown"),
        ("l.weight [N]", "l.weight"),
    ],
)
def test_units_that_do_not_match(column: str, words: str) -> None:
    with pytest.raises(rw.InputError, match=words):
        rw.sweep(drives(), {column: [1.0]}, workers=1)
    with pytest.raises(rw.InputError, match=r"Two parameters are named 'l\.mass'"):
        rw.sweep(drives(), {"l.mass": [1.0], "l.mass [t]": [1.0]}, workers=1)
