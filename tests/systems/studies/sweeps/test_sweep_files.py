"""Files of a sweep: one sweep at a time, errors for damaged files, and rows kept after lost workers."""

import subprocess
import sys
import threading
from pathlib import Path

import pandas as pd
import pytest

import ropeway as rw


def area(width: float) -> float:
    return width * width


def test_two_sweeps_on_one_path(tmp_path: Path) -> None:
    path, begun, go_on = tmp_path / "a.parquet", threading.Event(), threading.Event()

    def slow(width: float) -> float:
        begun.set()
        assert go_on.wait(60.0)
        return area(width)

    found: list[pd.DataFrame] = []
    first = threading.Thread(
        target=lambda: found.append(rw.sweep(slow, {"width": [1.0, 2.0]}, workers=1, path=path)), daemon=True
    )
    first.start()
    assert begun.wait(60.0)
    with pytest.raises(rw.InputError, match=r"Another sweep writes to .*a\.parquet\. Wait until it ends"):
        rw.sweep(slow, {"width": [1.0, 2.0]}, workers=1, path=path)
    go_on.set()
    first.join()
    assert found[0]["value"].tolist() == [1.0, 4.0]
    assert [file.name for file in tmp_path.iterdir()] == ["a.parquet"]


def test_a_rejected_sweep_leaves_no_journal(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    path.write_bytes(b"no table")
    with pytest.raises(rw.InputError, match="is damaged, or no Parquet file"):
        rw.sweep(area, {"width": [1.0]}, workers=1, path=path)
    whole = tmp_path / "b.parquet"
    rw.sweep(area, {"width": [1.0, 2.0]}, workers=1, path=whole)
    path.write_bytes(whole.read_bytes()[:-40])
    with pytest.raises(rw.InputError, match="Give another path, or remove the file"):
        rw.sweep(area, {"width": [1.0, 2.0]}, workers=1, path=path)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.parquet", "b.parquet"]


@pytest.mark.parametrize("damage", ["[[0, {", "7", '[[0, {"value": 1.0}], "x"]', '[["0", {}]]', "\x00\xff", '{"a": 1}'])
def test_the_error_names_a_damaged_line_of_a_journal(damage: str, tmp_path: Path) -> None:
    path, journal = tmp_path / "a.parquet", tmp_path / "a.parquet.journal"

    def stopping(width: float) -> float:
        if width == 3.0:
            raise KeyboardInterrupt
        return area(width)

    parameters = {"width": [1.0, 2.0, 3.0, 4.0]}
    with pytest.raises(rw.Interrupted) as caught:
        rw.sweep(stopping, parameters, workers=1, path=path)
    assert caught.value.result["value"].tolist() == [1.0, 4.0]
    lines = journal.read_text().splitlines()
    journal.write_text("\n".join([lines[0], damage, lines[2]]) + "\n", encoding="latin-1")
    with pytest.raises(rw.InputError, match=r"Line 2 of .*a\.parquet\.journal is damaged\. Remove that line"):
        rw.sweep(stopping, parameters, workers=1, path=path)
    journal.write_text("\n".join([lines[0], lines[2]]) + "\n")
    with pytest.raises(rw.Interrupted) as caught:
        rw.sweep(stopping, parameters, workers=1, path=path)
    assert caught.value.result["value"].tolist() == [1.0, 4.0]


NOTEBOOK = """
import ropeway as rw

def area(width):
    return width * width

try:
    rw.sweep(area, {"width": [1.0, 2.0]}, workers=2)
except rw.InputError as error:
    print(error)
print(rw.sweep(area, {"width": [1.0, 2.0]}, workers=1)["value"].tolist())
"""


def test_one_worker_is_the_remedy_in_a_notebook() -> None:
    done = subprocess.run([sys.executable], input=NOTEBOOK, capture_output=True, text=True, check=True)
    message, values = done.stdout.splitlines()
    assert "defined in a notebook or at a prompt. Use workers=1" in message
    assert values == "[1.0, 4.0]"


@pytest.mark.slow
def test_rows_are_kept_after_a_lost_worker() -> None:
    with pytest.raises(rw.WorkerError, match="worker process has died") as caught:
        rw.sweep(_dying, {"width": [float(k) for k in range(40)]}, workers=2)
    rows = caught.value.result
    assert rows["value"].tolist() == [area(w) for w in rows["width"]]
    assert len(rows) < 40


@pytest.mark.slow
def test_rows_are_kept_after_a_lost_dask_worker() -> None:
    import dask
    import distributed

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(1, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
        pytest.raises(rw.WorkerError, match=r"A worker was lost: .*Killed") as caught,
    ):
        rw.sweep(_dying, {"width": [float(k) for k in range(40)]}, workers=client)
    assert caught.value.result["value"].tolist() == [area(w) for w in caught.value.result["width"]]


def _dying(width: float) -> float:
    if width == 30.0:
        import os

        os._exit(9)
    return area(width)
