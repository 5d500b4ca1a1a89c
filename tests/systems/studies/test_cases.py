"""Cases of a sweep from a file."""

from pathlib import Path

import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.studies.cases import table_of


def test_a_file_holds_what_a_frame_does(tmp_path: Path) -> None:
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
