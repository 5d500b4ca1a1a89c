"""`ropeway fmu` as a user meets it."""

import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

from ropeway.__main__ import app
from support.fmus import first_supports


def ropeway(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "ropeway", "fmu", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, check=False)


def test_export_info_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first_supports().to_csv(tmp_path / "short.csv", index=False)
    done = ropeway("export", "short.csv", "-o", "line.fmu", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    monkeypatch.chdir(tmp_path)
    told = CliRunner().invoke(app, ["fmu", "info", "line.fmu"])
    assert "FMI 2.0, ModelExchange, CoSimulation" in told.stdout
    assert "c1.speed = 1.0 [m/s]" in told.stdout
    run = ["run", "line.fmu", "--until", "5", "--step", "0.5", "--start", "c1.speed=1.01"]
    told = CliRunner().invoke(app, ["fmu", *run])
    assert told.exit_code == 0, told.stderr
    table = pd.read_csv(tmp_path / "result.csv", index_col=0)
    assert table["c1.travel [m]"].iloc[-1] == 5.05
    assert len(table) == 11


def test_errors_on_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for arguments, words in (
        (("info", "none.fmu"), "none.fmu"),
        (("run", "none.fmu", "--until", "1"), "none.fmu"),
        (("run", "x", "--until", "1", "--start", "a"), "There is no file x"),
        (("run", "x", "--until", "1", "-o", "none/x.csv"), "There is no folder"),
    ):
        done = CliRunner().invoke(app, ["fmu", *arguments])
        assert done.exit_code == 1
        assert len(done.stderr.splitlines()) == 1
        assert done.stderr.startswith("ropeway: ")
        assert words in done.stderr


def test_start_values_of_all_kinds(tmp_path: Path, kinds3: Path) -> None:
    given = ["text=left 1", "gear=high", "count=-4", "brake=true", "binary=00ff", "v[2]=1.5", "n=2"]
    start = [part for value in given for part in ("--start", value)]
    done = ropeway("run", str(kinds3), "--until", "0.2", *start, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    last = pd.read_csv(tmp_path / "result.csv", index_col=0).iloc[-1]
    last.index = [name.partition(" ")[0] for name in last.index]
    assert [last[f"{n}_out"] for n in ("text", "gear", "count", "brake")] == ["left 1", 2, -4, True]
    assert last["w[2]"] == 3.0
    done = ropeway("run", str(kinds3), "--until", "0.2", "--start", "brake=perhaps", cwd=tmp_path)
    assert "a Boolean: it cannot be 'perhaps'" in done.stderr


def test_an_isolated_run_with_changes(tmp_path: Path, hostile: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "changes.csv").write_text("time,variable,value\n0.5,fmu.u1,3\n")
    run = ["fmu", "run", str(hostile), "--until", "2", "--isolated", "--every", "0.5", "--scenario", "changes.csv"]
    done = CliRunner().invoke(app, [*run, "--start", "deed=3", "--start", "when=1.25"])
    assert done.exit_code == 1
    assert "ended its process by signal 6 (Aborted)" in done.stderr
    table = pd.read_csv(tmp_path / "result.csv", index_col=0)
    assert table.index.tolist() == [0.0, 0.5, 1.0]
    assert table[next(c for c in table if c.partition(" ")[0] == "y1")].tolist() == [0.0, 3.0, 3.0]
