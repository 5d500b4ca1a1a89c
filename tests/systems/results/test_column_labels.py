"""Units and descriptions follow a frame through pandas without copies."""

import copy
import json
import pickle
from pathlib import Path

import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.results.column_labels import Labels
from support.schedule_lines import line


def test_pandas_does_not_copy_them() -> None:
    labels = Labels({"c1.speed": "m/s", "a_b.tension_a": "N"})
    frame = pd.DataFrame({"c1.speed": [1.0, 2.0], "a_b.tension_a": [3e4, 4e4]})
    frame.attrs["units"] = labels
    for derived in (frame["c1.speed"], frame * 2.0, frame.iloc[1:], frame.copy(), frame.filter(regex="tension")):
        assert derived.attrs["units"] is labels


def test_labels_are_an_immutable_dictionary() -> None:
    labels = Labels({"c1.speed": "m/s"})
    assert labels == {"c1.speed": "m/s"}
    assert json.loads(json.dumps(labels)) == labels
    assert copy.deepcopy(labels) is labels
    restored = pickle.loads(pickle.dumps(labels))
    assert (type(restored), restored) == (Labels, labels)
    for change in (
        lambda: labels.update({"c1.speed": "km/h"}),
        lambda: labels.__setitem__("c1.speed", "km/h"),
        lambda: labels.pop("c1.speed"),
        labels.clear,
    ):
        with pytest.raises(rw.InputError, match="cannot change"):
            change()
    assert labels["c1.speed"] == "m/s"


def test_results_keep_their_units_in_files(tmp_path: Path) -> None:
    result = rw.simulate(line(4, 2), 2.0)
    read = pd.read_parquet(result.to_parquet(tmp_path / "run.parquet"))
    assert read.attrs["units"] == result.frame.attrs["units"]
    assert read.attrs["units"]["c1.tension_in"] == "N"


def test_a_summary_builds_each_record_once(monkeypatch: pytest.MonkeyPatch) -> None:
    result = rw.simulate(line(12, 3), 3.0)
    made: list[int] = []
    original = rw.Result.record
    monkeypatch.setattr(rw.Result, "record", lambda self, i: made.append(i) or original(self, i))
    spans = result.summary().spans
    assert len(made) == len(set(made)) <= len(result.records)
    assert len(spans) == 12
    monkeypatch.undo()
    for name, row in spans.iterrows():
        slackest = int(result.full_frame[f"{name}.horizontal"].to_numpy().argmin())
        curve = result.record(slackest).profile(str(name), 401)
        ends = curve.iloc[[0, -1]]
        along = ((curve["x"] - ends["x"].iloc[0]) ** 2 + (curve["y"] - ends["y"].iloc[0]) ** 2) ** 0.5
        rise = ends["z"].iloc[1] - ends["z"].iloc[0]
        sag = (ends["z"].iloc[0] + rise * along / along.iloc[-1] - curve["z"]).max()
        assert row["largest_sag"] == pytest.approx(sag, rel=1e-4)
        assert row["sag_at"] == result.times[slackest]
        highest = result.full_frame[[f"{name}.tension_a", f"{name}.tension_b"]].to_numpy().max()
        assert row["highest_tension"] == highest
