"""Measured tables: units, blanks, files."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from support.measured import line_case

FREE = ["l2.mass", "a.pretension"]


def fitted(table: pd.DataFrame | Path, columns: dict[str, str] | None) -> rw.Fit:
    return rw.fit(line_case().system, table, columns=columns, free=FREE, sigma={"l1.z": 0.01, "a.tension": 100.0})


def test_units_in_names_headers_and_keys_give_the_same_fit() -> None:
    exact = line_case().exact
    expected = fitted(exact, {"m1": "l1.mass", "head": "a.tension", "z": "l1.z"})
    kilo = pd.DataFrame({"load_t": exact["m1"] / 1e3, "head_kN": exact["head"] / 1e3, "z_mm": exact["z"] * 1e3})
    header = pd.DataFrame(
        {"m": exact["m1"], "head [kip]": exact["head"] / 4448.2216152605, "z (ft)": exact["z"] / 0.3048}
    )
    key = pd.DataFrame({"m": exact["m1"], "A": exact["head"] / 1e3, "z": exact["z"]})
    plain = exact.rename(columns={"m1": "l1.mass", "head": "a.tension", "z": "l1.z"}).drop(columns="low")
    for table, columns in (
        (kilo, {"load_t": "l1.mass", "head_kN": "a.tension", "z_mm": "l1.z"}),
        (header, {"m": "l1.mass", "head": "a.tension", "z": "l1.z"}),
        (key, {"m": "l1.mass", "A [kN]": "a.tension", "z": "l1.z"}),
        (plain.assign(remark=1.0), None),
    ):
        found = fitted(table, columns)
        np.testing.assert_allclose(found.values, expected.values, rtol=1e-9)
        np.testing.assert_allclose(found.standard_errors, expected.standard_errors, rtol=1e-6)


def test_a_unit_that_does_not_fit() -> None:
    exact = line_case().exact
    with pytest.raises(rw.InputError, match=r"head_kg.*different quantities"):
        fitted(exact.rename(columns={"head": "head_kg"}), {"m1": "l1.mass", "head_kg": "a.tension", "z": "l1.z"})
    with pytest.raises(rw.InputError, match="different quantities"):
        fitted(exact.rename(columns={"z": "z [s]"}), {"m1": "l1.mass", "head": "a.tension", "z": "l1.z"})
    # What ends like the quantity itself has no unit: "tension_in" is not in inches.
    s = line_case().system
    table = pd.DataFrame({"s1_tension_in": [rw.equilibrium(s)["s1.tension_in"]]})
    fit = rw.fit(s, table, columns={"s1_tension_in": "s1.tension_in"}, free="a.pretension", sigma=1.0)
    assert fit.values["a.pretension"] == pytest.approx(30e3, rel=1e-6)


def test_blanks_are_skipped_and_counted(tmp_path: Path) -> None:
    exact = line_case().exact
    table = exact.copy()
    table.loc[2, "z"] = np.nan
    table.loc[5, "head"] = np.nan
    table.loc[7, "m1"] = np.nan
    columns = {"m1": "l1.mass", "head": "a.tension", "z": "l1.z"}
    fit = fitted(table, columns)
    assert fit.notes == ("1 rows are left out, as a given value is blank", "2 blank cells are skipped")
    assert fit.values["l2.mass"] == pytest.approx(280.0, rel=1e-6)
    assert list(fit.residuals.index) == [0, 1, 2, 3, 4, 5, 6, 8, 9]
    assert np.isnan(fit.residuals.loc[2, "z"])
    text = table.to_csv(index=False, na_rep="NaN", sep=";", decimal=",")
    path = tmp_path / "log.csv"
    path.write_text(text)
    np.testing.assert_allclose(fitted(path, columns).values, fit.values, rtol=1e-9)


def test_a_row_without_the_load_that_it_measures() -> None:
    with pytest.raises(rw.UnknownNameError, match="l7"):
        fitted(line_case().exact, {"m1": "l1.mass", "head": "a.tension", "z": "l7.z"})
    with pytest.raises(rw.InputError, match="Two columns give"):
        fitted(line_case().exact.assign(m2=1.0), {"m1": "l1.mass", "m2": "l1.mass", "z": "l1.z"})


def test_standard_deviations_by_row() -> None:
    exact = line_case().exact[["m1", "head"]]
    columns, sigma = {"m1": "l1.mass", "head": "a.tension"}, np.full(len(exact), 100.0)
    sigma[3:] = 1e6
    by_row = rw.fit(line_case().system, exact, columns=columns, free="a.pretension", sigma={"head": sigma.tolist()})
    three = rw.fit(line_case().system, exact.iloc[:3], columns=columns, free="a.pretension", sigma=100.0)
    assert by_row.standard_errors.iloc[0] == pytest.approx(three.standard_errors.iloc[0], rel=1e-5)
    with pytest.raises(rw.InputError, match="one for each row"):
        rw.fit(line_case().system, exact, columns=columns, free="a.pretension", sigma={"head": [1.0, 2.0]})
