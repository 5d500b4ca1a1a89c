"""Records of long lines hold only what has changed, and give the states that whole records give."""

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.dynamics import recorder
from ropeway.systems.statics.line_records import PartRecord, Record
from support import schedule_lines


@pytest.fixture(scope="module")
def model() -> rw.Model:
    return rw.assemble(schedule_lines.line(9, 4))


def run(model: rw.Model) -> rw.Result:
    return rw.simulate(model, until=40.0, every=10.0, progress=False)


def test_parts_of_records_give_the_states_of_whole_ones(model: rw.Model, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = run(model)
    monkeypatch.setattr(recorder, "_LARGE", 1)
    monkeypatch.setattr(recorder, "_PARTS", 3)
    parts = run(model)
    kinds = [type(record) for record in parts.records]
    assert PartRecord in kinds[1:4]
    assert all(kind is Record for kind, exact in zip(kinds, parts.exact, strict=True) if exact)
    assert len(parts.records) == len(whole.records) > 10
    for one, other in zip(parts.records, whole.records, strict=True):
        assert (one.time, one.pending) == (other.time, other.pending)
        for name in ("x", "u", "kept"):
            assert np.array_equal(getattr(one, name), getattr(other, name))
        assert all(np.array_equal(p, q) for p, q in zip(one.passed, other.passed, strict=True))
    np.testing.assert_allclose(parts.outputs, whole.outputs, rtol=1e-9, atol=1e-6)
    assert parts.events.drop(columns="value").equals(whole.events.drop(columns="value"))
    middle = parts.records[5].time
    assert parts.at(middle)["l3.z"] == pytest.approx(whole.at(middle)["l3.z"], abs=1e-9)


def test_records_of_a_compiled_run_keep_no_block_of_rows(model: rw.Model, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder, "_LARGE", 1)
    records = list(rw.simulate(model, until=20.0, every=10.0, compiled=True, progress=False).records)
    assert {type(record) for record in records} == {Record, PartRecord}
    whole = [record for record in records if isinstance(record, Record)]
    assert all(row.base is None for record in records for row in (record.x, record.u))
    assert all(row.base is None for record in whole for row in (record.z, *record.passed))


def loop() -> rw.System:
    """An endless rope that turns twice, with loads on both sides of its first support."""
    rows = [("d", 0, 0, 0, "control"), ("o", 68, 0, 4, "idler"), ("r", 141, 1.5, 5, "return"), ("b", 72, 3, 4, "idler")]
    table = pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])
    rope = rw.Rope(mass_per_length=2.9, axial_stiffness=28e6, breaking_load=480e3)
    turning = rw.Schedule((0.0, 20.0, 22.0, 55.0, 57.0, 70.0), (1.9, 1.9, -1.9, -1.9, 1.6, 1.6))
    masses = (210.0, 150.0, 0.0, 330.0, 90.0)
    return rw.endless(rope, table, speed=turning, tension=52e3, load_mass=masses, load_spacing=28.0)


@pytest.mark.parametrize("endless", [False, True])
def test_the_compiled_core_writes_down_what_crossings_change(
    model: rw.Model, endless: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    line, until = (rw.assemble(loop()), 70.0) if endless else (model, 40.0)
    whole = rw.simulate(line, until, every=10.0, compiled=True, progress=False)
    monkeypatch.setattr(recorder, "_LARGE", 1)
    monkeypatch.setattr(recorder, "_PARTS", 5)
    parts = rw.simulate(line, until, every=10.0, compiled=True, progress=False)
    kinds = [type(record) for record in parts.records]
    assert kinds.count(PartRecord) > kinds.count(Record) - 8
    assert len(parts.records) == len(whole.records) > 20
    solved = 0
    for one, other in zip(parts.records, whole.records, strict=True):
        for name in ("time", "x", "u", "kept", "pending"):
            assert np.array_equal(getattr(one, name), getattr(other, name))
        assert all(np.array_equal(p, q) for p, q in zip(one.passed, other.passed, strict=True))
        if isinstance(one, PartRecord):
            assert np.array_equal(one.values, other.z[one.columns])
            solved += len(one.columns) < len(other.z)
    assert endless or solved > 10
    pd.testing.assert_frame_equal(parts.events, whole.events)
    np.testing.assert_allclose(parts.outputs, whole.outputs, rtol=1e-9, atol=1e-6)


def test_events_are_found_in_parts(model: rw.Model, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, parts = run(model), run(model)
    monkeypatch.setattr("ropeway.systems.results.run_data._KEPT", 0)
    monkeypatch.setattr("ropeway.systems.results.run_data._BATCH", 7)
    found, known = ([event._replace(value=0.0) for event in run.limits_reached] for run in (parts, whole))
    assert found == known
    assert "_solved" not in parts.__dict__
