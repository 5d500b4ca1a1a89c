"""Comparison of variants: the numbers equal those of the studies."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd
import pytest

import ropeway as rw
from support import call_objects as objects


def test_payload_studies_and_rigs() -> None:
    rig = objects.rig()
    one, other = rw.payload(rig, stations=[70.0, 150.0]), rw.payload(objects.shod_rig(), stations=[70.0, 150.0])
    found = rw.compare(one, other)
    assert list(found.frame.index) == ["rig 1", "rig 2"]
    assert found.frame["payload"].tolist() == [one.payload, other.payload]
    assert found.frame.loc["rig 1", "limited_by"] == one.limiting["limited_by"]
    assert found.frame.loc["rig 1", "skyline_length"] == rig.length
    assert found.frame.attrs["units"]["pretension"] == "N"
    lines = found.plot().axes[0].get_lines()
    assert lines[0].get_ydata() == pytest.approx(one.frame["payload"] / 1e3)
    assert found.plot()._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]


def test_runs() -> None:
    result = objects.run()
    found = rw.compare(result, result, names=["as it is", "again"])
    row = found.frame.loc["again"]
    assert row["highest_tension"] == result.frame.filter(regex=r"\.tension_[ab]$").max(axis=None)
    assert row["duration"] == 4.0
    assert isinstance(found.frame, pd.DataFrame)


def test_invalid_comparisons_are_rejected() -> None:
    study = rw.payload(objects.rig(), stations=[70.0])
    for call, message in (
        (lambda: rw.compare(study), "Give two or more"),
        (lambda: rw.compare(study, objects.run()), "different kinds"),
        (lambda: rw.compare(study, replace(study), names=["a", "a"]), "a name of its own"),
    ):
        with pytest.raises(rw.InputError, match=message):
            call()
