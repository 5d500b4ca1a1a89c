"""Files are written whole or not at all."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import ropeway as rw
from ropeway.components.whole_files import whole

RUN_OUT_OF_ROOM = """
import resource, signal, sys
import pandas as pd
import ropeway as rw
from ropeway.components.whole_files import whole

def limit(size):
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))

def square(x):
    return {"value": x * x, "words": "a long text " * 20}

folder = sys.argv[1]
s = rw.System("one span")
rope = rw.Rope(mass_per_length=2.1, axial_stiffness=21e6, breaking_load=300e3)
s.string(rope, rw.Anchor("a", at=(0, 0)), rw.Anchor("b", at=(90, 7)), tension=30e3)
result = rw.simulate(s, 200.0)
schedule = rw.Schedule(range(3000), range(3000))
result.frame, rw.sweep(square, {"x": range(3)}, workers=1, path=f"{folder}/before.parquet")
limit(8000)
calls = {
    "result.csv": result.to_csv,
    "result.parquet": result.to_parquet,
    "schedule.csv": schedule.to_csv,
    "line.fmu": lambda path: rw.fmu.export(s, path, platforms=()),
    "sweep.parquet": lambda path: rw.sweep(square, {"x": range(400)}, workers=1, path=path),
}
for name, call in calls.items():
    try:
        call(f"{folder}/{name}")
        print(name, "written")
    except rw.WriteError as error:
        print(name, type(error).__name__, error.remedy)
"""


def test_a_complete_file_replaces_the_old_one(tmp_path: Path) -> None:
    target = tmp_path / "table.csv"
    target.write_text("old")
    target.chmod(0o600)
    with whole(target) as file:
        assert file.parent == tmp_path
        assert file.suffix == ".csv"
        file.write_text("new")
        assert target.read_text() == "old"
    assert target.read_text() == "new"
    assert target.stat().st_mode & 0o777 == 0o600
    assert os.listdir(tmp_path) == ["table.csv"]


def test_after_an_error_the_old_file_stays_and_nothing_else(tmp_path: Path) -> None:
    target = tmp_path / "table.csv"
    target.write_text("old")
    for error in (ValueError("unfit"), KeyboardInterrupt()):
        with pytest.raises(type(error)), whole(target) as file:  # noqa: PT012
            file.write_text("hal")
            raise error
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["table.csv"]


def test_write_errors_are_typed(tmp_path: Path) -> None:
    schedule = rw.Schedule([0.0, 1.0], [1.0, 2.0])
    for path in (tmp_path / "no folder" / "s.csv", tmp_path):
        with pytest.raises(rw.WriteError, match="cannot be written"):
            schedule.to_csv(path)
    with pytest.raises(OSError, match="cannot be written"):
        schedule.to_csv(tmp_path)


def test_a_link_stays_a_link_and_a_pipe_a_pipe(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    real, link = tmp_path / "real" / "s.csv", tmp_path / "s.csv"
    link.symlink_to(real)
    schedule = rw.Schedule([0.0, 1.0], [1.0, 2.0])
    for _ in range(2):
        assert schedule.to_csv(link) == link
        assert link.is_symlink()
        assert rw.Schedule.from_csv(real) == schedule
    reading, writing = os.pipe()
    schedule.to_csv(f"/dev/fd/{writing}")
    os.close(writing)
    with os.fdopen(reading) as file:
        assert file.readline() == "time,speed\n"


def test_a_full_disk_leaves_no_part_of_a_file(tmp_path: Path) -> None:
    script = tmp_path / "run_out_of_room.py"
    script.write_text(RUN_OUT_OF_ROOM)
    folder = tmp_path / "out"
    folder.mkdir()
    done = subprocess.run([sys.executable, script, folder], capture_output=True, text=True, check=True)
    remedy = "WriteError Choose a folder with write permission and free space"
    names = ("result.csv", "result.parquet", "schedule.csv", "line.fmu", "sweep.parquet")
    assert done.stdout.splitlines() == [f"{name} {remedy}" for name in names]
    # The journal keeps what has been found: the sweep goes on from there.
    assert sorted(os.listdir(folder)) == ["before.parquet", "sweep.parquet.journal"]
