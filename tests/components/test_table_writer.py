"""Tables for others: one header row with units, no noise, the same numbers in every format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest

import ropeway as rw
from support import call_objects as objects


def noisy() -> pd.DataFrame:
    frame = pd.DataFrame(
        {"a.force": [1.5e4, -1.75e-46, -0.0], "b": [1.0, np.nan, np.inf], "c": ["x", "y", "z"], "n": [1, 2, 3]},
        index=pd.Index([0.0, 0.5, 1.0], name="time"),
    )
    frame.attrs["units"] = {"a.force": "N", "b": "1", "c": ""}
    return frame


def test_csv_has_one_header_row_with_units_and_no_noise(tmp_path: Path) -> None:
    lines = rw.write_table(noisy(), tmp_path / "t.csv").read_text().splitlines()
    assert lines == ["time [s],a.force [N],b,c,n", "0.0,15000.0,1.0,x,1", "0.5,0.0,,y,2", "1.0,0.0,inf,z,3"]


def test_excel_and_parquet_hold_the_same(tmp_path: Path) -> None:
    sheet = openpyxl.load_workbook(rw.write_table(noisy(), tmp_path / "t.xlsx")).active
    rows = list(sheet.values)
    assert rows[0] == ("time [s]", "a.force [N]", "b", "c", "n")
    assert rows[1:] == [(0, 15000, 1, "x", 1), (0.5, 0, None, "y", 2), (1, 0, "inf", "z", 3)]
    assert sheet.freeze_panes == "A2"
    read = pd.read_parquet(rw.write_table(noisy(), tmp_path / "t.parquet"))
    pd.testing.assert_frame_equal(read, noisy())
    assert read.attrs["units"]["a.force"] == "N"


def test_texts_stay_texts_in_excel(tmp_path: Path) -> None:
    names = ["=1+1", "#N/A", "a\x01b", "-5", "1e5"]
    table = pd.DataFrame({"=name": names, "x": range(5)})
    sheet = openpyxl.load_workbook(rw.write_table(table, tmp_path / "t.xlsx")).active
    assert [cell.value for cell in sheet["A"]] == ["=name", "=1+1", "#N/A", "ab", "-5", "1e5"]
    assert {cell.data_type for cell in sheet["A"]} == {"s"}


def test_levels_become_one_row(tmp_path: Path) -> None:
    columns = pd.MultiIndex.from_product([["open loop", "trimmed"], ["highest", "energy"]])
    frame = pd.DataFrame(np.ones((2, 4)), index=pd.Index(["masses +10 %", "late"], name="case"), columns=columns)
    lines = rw.write_table(frame, tmp_path / "t.csv").read_text().splitlines()
    assert lines[0] == "case,open loop: highest,open loop: energy,trimmed: highest,trimmed: energy"
    assert lines[1].startswith("masses +10 %,1.0")


def test_results_and_studies_write_their_frames(tmp_path: Path) -> None:
    result, study = objects.run(), rw.payload(objects.rig(), stations=[70.0, 150.0])
    read = rw.Schedule.from_csv(result.to_csv(tmp_path / "run.csv"), column="c.speed")
    assert read.speeds == tuple(result.frame["c.speed"])
    header = pd.read_excel(study.to_excel(tmp_path / "study.xlsx")).columns
    assert list(header[:3]) == ["station [m]", "payload [kg]", "limited_by"]
    rest = pd.read_csv(objects.rest().to_csv(tmp_path / "rest.csv"), index_col=0)
    assert rest.loc["c.tension_in", "value"] == objects.rest()["c.tension_in"]
    assert len(rw.ropes()) == len(pd.read_csv(rw.write_table(rw.ropes(), tmp_path / "ropes.csv")))


def test_five_hundred_variants_go_to_excel(tmp_path: Path) -> None:
    cases = {"turn.mass": np.linspace(100.0, 900.0, 500)}
    table = rw.sweep(objects.one_span(), cases, outputs=["a_b.tension_a", "turn.z"], workers=1, progress=False)
    sheet = openpyxl.load_workbook(rw.write_table(table, tmp_path / "t.xlsx")).active
    rows = list(sheet.values)
    assert len(rows) == 501
    assert "a_b.tension_a [N]" in rows[0]
    place = rows[0].index("a_b.tension_a [N]")
    assert [row[place] for row in rows[1:]] == pytest.approx(table["a_b.tension_a"].tolist(), rel=1e-15)


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    wide = pd.DataFrame(np.zeros((1, 20_000)))
    for call, message in (
        (lambda: rw.write_table(noisy(), tmp_path / "t.ods"), "no known format"),
        (lambda: rw.write_table(wide, tmp_path / "t.xlsx"), "20000 columns do not fit on an Excel sheet"),
        (lambda: objects.run().to_excel(tmp_path / "t.csv"), r"does not end with .xlsx"),
    ):
        with pytest.raises(rw.InputError, match=message):
            call()
    with pytest.raises(rw.WriteError):
        rw.write_table(noisy(), tmp_path / "none" / "t.csv")
    assert list(tmp_path.iterdir()) == []
