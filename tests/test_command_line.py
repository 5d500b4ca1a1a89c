"""The command line as a user meets it."""

import os
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import typer
from typer.testing import CliRunner

import ropeway as rw
from ropeway.__main__ import app
from ropeway.cli_options import errors_on_one_line
from ropeway.components.errors import RopewayWarning
from ropeway.examples.corridor_map import make_raster

Command = Callable[..., Any]
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


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Command:
    """Runs the command line in this process, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(app, list(arguments))


def test_simulate(tmp_path: Path, command: Command) -> None:
    line = str(EXAMPLES / "line.csv")
    done = command("simulate", line, "--rope", "compacted skyline 22", "--until", "20", "--out", "o")
    assert done.exit_code == 0, done.stderr
    assert (tmp_path / "o" / "line.png").exists()


def test_simulate_compiled(tmp_path: Path, command: Command) -> None:
    line = str(EXAMPLES / "line.csv")
    done = command("simulate", line, "--until", "5", "--out", "o", "--compiled")
    assert done.exit_code == 0, done.stderr
    assert "libraries" in command("cache", "info").stdout
    assert "removed" in command("cache", "clear").stdout
    assert command("cache", "info").stdout.startswith("0 libraries")


@pytest.mark.parametrize("name", ["payload", "optimise"])
def test_compiled_studies_need_a_compiler(name: str, command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    file, more = ("corridor.csv", "--spacing") if name == "payload" else ("line.csv", "--until")
    done = command(name, str(EXAMPLES / file), more, "120", "--compiled")
    assert done.exit_code == 1
    assert "compiler cannot be started" in done.stderr


def test_ropes(command: Command) -> None:
    done = command("ropes")
    assert done.exit_code == 0
    assert "6x19 EEIP 25" in done.stdout
    assert "mass [kg/m]" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("simulate", "no.csv"), "There is no file no.csv"),
        (("simulate", str(EXAMPLES / "line.csv"), "--rope", "string"), "No rope 'string'"),
        (("simulate", str(EXAMPLES / "line.csv"), "--tension", "100"), "Raise the tension"),
        (("simulate", str(EXAMPLES / "line.csv"), "--report", "run.doc"), "run.doc is no report"),
        (("optimise", str(EXAMPLES / "line.csv"), "--report", "none/plan.html"), "there is no folder none"),
        (("payload", str(EXAMPLES / "corridor.csv"), "--gis", "map.shp"), "'map.shp' ends in '.shp'"),
        (("payload", str(EXAMPLES / "corridor.csv"), "--spacing", "1e-9"), "would make 5.3e+11 stations"),
    ],
)
def test_errors_are_one_line(arguments: tuple[str, ...], message: str, command: Command) -> None:
    done = command(*arguments)
    assert done.exit_code == 1
    assert len(done.stderr.strip().splitlines()) == 1
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_help_and_wrong_usage(command: Command) -> None:
    done = command("simulate", "--help")
    assert done.exit_code == 0
    assert "name,x,y,z,kind" in done.stdout.replace("\n", "")
    assert "[m/s]" in done.stdout
    assert command("simulate", "--no-such-option").exit_code == 2


def test_payload(tmp_path: Path, command: Command) -> None:
    corridor = str(EXAMPLES / "corridor.csv")
    done = command("payload", corridor, "--support", "260:9", "--tail", "480", "--spacing", "60", "--out", "p")
    assert done.exit_code == 0, done.stderr
    assert "kg, limited at 105 m by skyline tension." in done.stdout
    near = command("payload", corridor, "--tail", "480", "--load-depth", "40", "--spacing", "60")
    assert "Largest payload 0 kg" in near.stdout
    assert "by clearance." in near.stdout
    assert (tmp_path / "p" / "payload.png").stat().st_size > 5000
    wrong = command("payload", corridor, "--support", "260")
    assert wrong.exit_code == 1
    assert "STATION:HEIGHT" in wrong.stderr


def test_a_corridor_of_a_raster_to_report_and_map(tmp_path: Path, command: Command) -> None:
    import geopandas

    make_raster(tmp_path / "dem.tif")
    line = ("--start", "2600120,1200560", "--end", "2600450,1200130", "--head", "8", "--tail", "525")
    files = ("--report", "c.html", "--gis", "c.gpkg", "--gis", "c.dxf")
    done = command("payload", "dem.tif", *line, *files, "--support", "265:11", "--spacing", "80")
    assert done.exit_code == 0, done.stderr
    for name in ("c.html", "c.dxf"):
        assert (tmp_path / name).stat().st_size > 50_000
    spars = geopandas.read_file(tmp_path / "c.gpkg", layer="supports").set_index("name").geometry
    # 8 m and 525 m along the line from its start: the azimuth is that of both map points.
    east, north = (330.0, -430.0)
    for name, station in (("head", 8.0), ("tail", 525.0)):
        share = station / float(np.hypot(east, north))
        assert (spars[name].x, spars[name].y) == pytest.approx(
            (2600120 + share * east, 1200560 + share * north), abs=1e-3
        )
    half = command("payload", "dem.tif", "--start", "2600120,1200560")
    assert half.exit_code == 1
    assert "both --start and --end" in half.stderr
    assert "EASTING,NORTHING" in command("payload", "dem.tif", "--start", "1", "--end", "1,2").stderr


def test_optimise(tmp_path: Path, command: Command) -> None:
    line = str(EXAMPLES / "line.csv")
    done = command("optimise", line, "--until", "12", "--intervals", "6", "--settle", "4", "--out", "o")
    assert done.exit_code == 0, done.stderr
    words = " ".join(done.stdout.split())
    assert "tensions from 4 s on, energy from 0 to 12 s" in words
    assert "constant speed" in words
    assert "optimised" in done.stdout
    assert "masses +10 %" in done.stdout
    table = pd.read_csv(tmp_path / "o" / "schedule.csv", index_col=0)
    assert list(table.columns) == [f"c{k}.speed [m/s]" for k in range(1, 5)]
    assert (tmp_path / "o" / "schedule.png").stat().st_size > 5000
    wrong = command("optimise", line, "--minimise", "comfort")
    assert wrong.exit_code == 1
    assert "peak tension" in wrong.stderr


LINE = """name,x,y,z,kind
lower,0,0,0,drum
t1,85,0,6,idler
pull,170,0,9,control
t2,255,0,13,idler
upper,340,0,18,drum
"""


@pytest.fixture
def line(tmp_path: Path) -> str:
    path = tmp_path / "way.csv"
    path.write_text(LINE)
    return str(path)


def test_files_are_written_before_a_closed_pipe_ends_the_command(line: str, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "ropeway", "simulate", line, "--until", "6", "--out", "o"]
    read, write = os.pipe()
    os.close(read)  # as `| head` does when it has enough
    with open(write, "wb") as closed:
        run = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, cwd=tmp_path, check=False)
    errors = run.stderr.decode()
    assert "Traceback" not in errors
    assert "Broken pipe" not in errors
    assert len(pd.read_csv(tmp_path / "o" / "tensions.csv")) == 7
    assert (tmp_path / "o" / "line.png").stat().st_size > 5000


def test_an_interrupt_keeps_the_results(line: str, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "ropeway", "simulate", line, "--until", "200000", "--out", "o"]
    run = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=tmp_path)
    for _ in range(600):
        if (tmp_path / "o").is_dir():
            break
        time.sleep(0.05)
    time.sleep(3.0)
    run.send_signal(signal.SIGINT)
    _, errors = run.communicate(timeout=60)
    assert run.returncode == 130
    assert "Traceback" not in errors.decode()
    assert errors.decode().rstrip().endswith("ropeway: interrupted")
    table = pd.read_csv(tmp_path / "o" / "tensions.csv", index_col=0)
    assert 1 < len(table) < 200000
    assert f"the first {table.index[-1]:g}" in errors.decode()


def test_a_tension_above_a_limit_is_a_warning(line: str, command: Command) -> None:
    for tension, load in (("620e3", "breaking load"), ("240e3", "safe working load")):
        done = command("simulate", line, "--tension", tension, "--until", "2", "--out", "o")
        assert done.exit_code == 0
        assert len(done.stderr.splitlines()) == 1
        assert done.stderr.startswith("ropeway: warning: ")
        assert load in done.stderr
    calm = command("simulate", line, "--until", "2", "--out", "o")
    assert calm.stderr == ""


def test_folders_and_files_are_distinguished(line: str, command: Command) -> None:
    Path("maps").mkdir()
    for arguments, words in (
        (("simulate", "maps"), "maps"),
        (("payload", "maps"), "maps"),
        (("simulate", line, "--until", "2", "--out", line), "it is a file"),
        (("fmu", "run", "x.fmu", "--until", "1", "-o", "maps"), "maps is a folder"),
    ):
        done = command(*arguments)
        assert done.exit_code == 1
        assert words in done.stderr
        assert "Errno" not in done.stderr
        assert len(done.stderr.splitlines()) == 1


def test_a_duplicate_name_shows_no_internal_code(tmp_path: Path, command: Command) -> None:
    (tmp_path / "twice.csv").write_text(LINE.replace("t2", "t1"))
    done = command("simulate", "twice.csv")
    assert done.exit_code == 1
    assert "'t1'" in done.stderr
    assert "typer" not in done.stderr
    assert ".py" not in done.stderr


def test_warnings_and_interrupts_are_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    with errors_on_one_line():
        warnings.warn("The rope is above its\nbreaking load", RopewayWarning, stacklevel=1)
        warnings.warn("Something of a library below", UserWarning, stacklevel=1)
    assert capsys.readouterr().err == "ropeway: warning: The rope is above its breaking load\n"
    with pytest.raises(typer.Exit) as ended, errors_on_one_line():
        raise KeyboardInterrupt
    assert ended.value.exit_code == 130
    assert capsys.readouterr().err == "ropeway: interrupted\n"


def test_printed_limits_are_on_the_safe_side(tmp_path: Path, command: Command) -> None:
    """The payload printed is not above that of the table, the highest tension not below it."""
    corridor = str(EXAMPLES / "corridor.csv")
    done = command("payload", corridor, "--tail", "260", "--tail-height", "9", "--spacing", "65")
    table = pd.read_csv(tmp_path / "ropeway-payload" / "payload.csv")
    least = table["payload [kg]"].min()
    (printed,) = [int(line.split()[2]) for line in done.stdout.splitlines() if line.startswith("Largest payload")]
    assert printed <= least < printed + 1


def test_loads_that_are_too_heavy_are_named(line: str, command: Command) -> None:
    done = command("simulate", line, "--load-mass", "30000", "--load-spacing", "60")
    assert done.exit_code == 1
    assert "too heavy" in done.stderr
    assert "Newton" not in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("kind", ["standing", "live", "gravity", "running"])
def test_a_new_project_is_edited_and_studied(kind: str, tmp_path: Path, command: Command) -> None:
    assert command("new", "slope.json", "--kind", kind).exit_code == 0
    text = (tmp_path / "slope.json").read_text()
    assert "// The carriage: mass [kg]" in text
    (tmp_path / "slope.json").write_text(text.replace('"mass": 450', '"mass": 300'))
    done = command("payload", "slope.json", "--spacing", "160", "--clearance", "0", "--out", "p")
    assert done.exit_code == 0, done.stderr
    assert "Largest payload" in done.stdout
    assert rw.load("slope.json").carriage.mass == 300.0
    again = command("new", "slope.json")
    assert "exists" in again.stderr
    assert "Choose standing, live" in command("new", "b.json", "--kind", "flying").stderr


def test_a_new_line_is_simulated_with_a_report(tmp_path: Path, command: Command) -> None:
    command("new", "line.json", "--kind", "monocable")
    done = command("simulate", "line.json", "--until", "3", "--report", "line.html", "--out", "o")
    assert done.exit_code == 0, done.stderr
    assert (tmp_path / "line.html").stat().st_size > 1e6
    ignored = command("simulate", "line.json", "--load-mass", "500", "--safety-factor", "5")
    assert "leave out --load-mass, --safety-factor" in ignored.stderr
    assert "leave out --tension" in command("payload", "line.json", "--tension", "8e4").stderr
    wrong = command("payload", "line.json")
    assert "The project holds a System" in wrong.stderr
    (tmp_path / "line.json").write_text((tmp_path / "line.json").read_text().replace('"tension": 45', '"tensoin": 45'))
    assert (
        "line.json, line 9, tensoin: there is no such field. Is tension meant?"
        in command("simulate", "line.json").stderr
    )


def test_variants_are_compared(tmp_path: Path, command: Command) -> None:
    command("new", "a.json")
    (tmp_path / "b.json").write_text(
        (tmp_path / "a.json").read_text().replace('"tension": 70.0e3', '"tension": 90.0e3')
    )
    done = command("compare", "a.json", "b.json", "--out", "c")
    assert done.exit_code == 0, done.stderr
    table = pd.read_csv(tmp_path / "c" / "comparison.csv", index_col=0)
    assert list(table.index) == ["a", "b"]
    assert table.loc["b", "payload [kg]"] > table.loc["a", "payload [kg]"]
    assert (tmp_path / "c" / "comparison.png").stat().st_size > 5000
    assert "Give two or more" in command("compare", "a.json").stderr


def test_version_and_ropes_of_ones_own(tmp_path: Path, command: Command) -> None:
    assert command("--version").stdout.strip() == f"ropeway {rw.__version__}"
    (tmp_path / "ours.csv").write_text("name,diameter [mm],mass_per_length,breaking_load [kN]\nours,22,2.4,425\n")
    assert "ours" in command("ropes", "--catalogue", "ours.csv", "--search", "our").stdout
    corridor = str(EXAMPLES / "corridor.csv")
    options = ("--skyline", "ours", "--catalogue", "ours.csv", "--tail", "480", "--spacing", "160", "--kind", "live")
    done = command("payload", corridor, *options)
    assert done.exit_code == 0, done.stderr
    assert "Give --mainline" in command("payload", corridor, "--kind", "running").stderr


SHORT = "name,x,y,z,kind\na,0,0,0,drum\ns1,100,0,11,idler\nc1,205,0,20,control\nb,300,0,27,drum\n"


def test_load_cases_of_a_line_and_of_a_project(tmp_path: Path, command: Command) -> None:
    (tmp_path / "line.csv").write_text(SHORT)
    rows = ["name,temperature,ice_thickness [mm],loading", "calm,,,", "cold,-25,,", "iced,-5,10,full"]
    (tmp_path / "cases.csv").write_text("\n".join(rows))
    given = ("line.csv", "cases.csv", "--loading", "empty", "--loading", "full")
    done = command("cases", *given, "--rollers", "s1:8", "--out", "o")
    assert done.exit_code == 0, done.stderr
    assert "5 load cases" in done.stdout
    frame = pd.read_csv(tmp_path / "o" / "cases.csv")
    assert frame["case"].tolist() == ["calm, empty", "calm, full", "cold, empty", "cold, full", "iced"]
    table = pd.read_csv(tmp_path / "o" / "supports.csv")
    s1 = table[(table["support"] == "s1") & (table["case"] == "iced")].iloc[0]
    assert s1["roller_force [N]"] == pytest.approx(s1["bearing_load [N]"] / 8.0, rel=0.02)
    assert (tmp_path / "o" / "cases.png").stat().st_size > 20_000
    assert len(pd.read_csv(tmp_path / "o" / "governing.csv")) > 15
    assert "not NAME:NUMBER" in command("cases", *given, "--rollers", "s1").stderr
    assert "no loading 'half'" in command("cases", *given, "--loading", "half").stderr
    assert command("new", "rig.json").exit_code == 0
    (tmp_path / "cold.csv").write_text("name,temperature\ncold,-20\n")
    done = command("cases", "rig.json", "cold.csv", "--loading", "empty", "--out", "r")
    assert done.exit_code == 0, done.stderr


def test_weather_of_runs_and_payloads(tmp_path: Path, command: Command) -> None:
    (tmp_path / "line.csv").write_text(SHORT)
    iced_up = ("--temperature", "-5", "--ice", "0.02", "--wind-pressure", "90")
    for out, weather in {"calm": (), "iced": iced_up}.items():
        assert command("simulate", "line.csv", "--until", "2", *weather, "--out", out).exit_code == 0
    calm, iced = (pd.read_csv(tmp_path / out / "tensions.csv") for out in ("calm", "iced"))
    assert iced["c1.tension_in [N]"].iloc[0] > 1.005 * calm["c1.tension_in [N]"].iloc[0]  # more weight to the drum
    corridor = (str(EXAMPLES / "corridor.csv"), "--tail", "480", "--support", "260:9", "--spacing", "160")
    payloads = []
    for thickness in ("0", "0.015"):
        done = command("payload", *corridor, "--ice", thickness, "--out", "p")
        assert done.exit_code == 0, done.stderr
        payloads.append(pd.read_csv(tmp_path / "p" / "payload.csv")["payload [kg]"].min())
    assert payloads[1] < 0.95 * payloads[0]
