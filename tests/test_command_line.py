"""The command line as a user meets it."""

import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def ropeway(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "ropeway", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, check=False)


def test_demo(tmp_path: Path) -> None:
    done = ropeway("demo", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "24 spans" in done.stdout
    assert "crossing forward" in done.stdout
    assert str(tmp_path / "ropeway-demo") in done.stdout.replace("\n", "")
    for name in ("tensions.csv", "events.csv", "tensions.png", "line.png"):
        assert (tmp_path / "ropeway-demo" / name).stat().st_size > 1000
    table = pd.read_csv(tmp_path / "ropeway-demo" / "tensions.csv", index_col=0)
    assert len(table) == 601
    assert "c1.tension_in [N]" in table


def test_simulate(tmp_path: Path) -> None:
    line = str(EXAMPLES / "line.csv")
    done = ropeway("simulate", line, "--rope", "compacted skyline 22", "--until", "20", "--out", "o", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "o" / "line.png").exists()


def test_ropes(tmp_path: Path) -> None:
    done = ropeway("ropes", cwd=tmp_path)
    assert done.returncode == 0
    assert "6x19 EEIP 25" in done.stdout
    assert "mass [kg/m]" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("simulate", "no.csv"), "There is no file no.csv"),
        (("simulate", str(EXAMPLES / "line.csv"), "--rope", "string"), "No rope 'string'"),
        (("simulate", str(EXAMPLES / "line.csv"), "--tension", "100"), "Raise the tension"),
    ],
)
def test_errors_are_one_line(arguments: tuple[str, ...], message: str, tmp_path: Path) -> None:
    done = ropeway(*arguments, cwd=tmp_path)
    assert done.returncode == 1
    assert len(done.stderr.strip().splitlines()) == 1
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_help_and_wrong_usage(tmp_path: Path) -> None:
    done = ropeway("simulate", "--help", cwd=tmp_path)
    assert done.returncode == 0
    assert "name,x,y,z,kind" in done.stdout.replace("\n", "")
    assert "[m/s]" in done.stdout
    assert ropeway("simulate", "--no-such-option", cwd=tmp_path).returncode == 2


def test_payload(tmp_path: Path) -> None:
    corridor = str(EXAMPLES / "corridor.csv")
    done = ropeway(
        "payload", corridor, "--support", "260:9", "--tail", "480", "--spacing", "60", "--out", "p", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert "kg, limited at 105 m by skyline tension." in done.stdout
    near = ropeway("payload", corridor, "--tail", "480", "--load-depth", "40", "--spacing", "60", cwd=tmp_path)
    assert "Largest payload 0 kg" in near.stdout
    assert "by clearance." in near.stdout
    assert (tmp_path / "p" / "payload.png").stat().st_size > 5000
    wrong = ropeway("payload", corridor, "--support", "260", cwd=tmp_path)
    assert wrong.returncode == 1
    assert "STATION:HEIGHT" in wrong.stderr


def test_optimise(tmp_path: Path) -> None:
    line = str(EXAMPLES / "line.csv")
    done = ropeway("optimise", line, "--until", "12", "--intervals", "6", "--settle", "4", "--out", "o", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "From 4 s on" in done.stdout
    assert "optimised" in done.stdout
    assert "masses +10 %" in done.stdout
    table = pd.read_csv(tmp_path / "o" / "schedule.csv", index_col=0)
    assert list(table.columns) == [f"c{k}.speed" for k in range(1, 5)]
    assert (tmp_path / "o" / "schedule.png").stat().st_size > 5000
    wrong = ropeway("optimise", line, "--minimise", "comfort", cwd=tmp_path)
    assert wrong.returncode == 1
    assert "peak tension" in wrong.stderr
