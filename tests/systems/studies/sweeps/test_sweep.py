"""A sweep gives the same rows for all kinds of workers, keeps failures, and can be resumed."""

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import psutil
import pytest
from dask.distributed import Client, LocalCluster

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
HEIGHTS = (0.0, 5.0, 2.0, 8.0, 4.0, 12.0)
MASSES = (400.0, 250.0, 300.0, 150.0, 500.0)


def line(heights: tuple[float, ...] = HEIGHTS, masses: tuple[float, ...] = MASSES, length: float = 502.0) -> rw.System:
    """Five spans over idlers, a load in each."""
    last = len(heights) - 1
    nodes = [(rw.Sheave if 0 < k < last else rw.Anchor)(f"s{k}", at=(100.0 * k, z)) for k, z in enumerate(heights)]
    system = rw.System("five spans")
    spans = system.string(ROPE, *nodes, length=length)
    for k, mass in enumerate(masses):
        system.hang(rw.Load(f"l{k}", mass=mass), spans, at=100.0 * k + 47.0)
    return system


def cases(samples: int) -> pd.DataFrame:
    bounds = {f"l{k}.mass": (100.0, 500.0) for k in range(5)}
    bounds |= {f"s{k}.z": (HEIGHTS[k] - 2.0, HEIGHTS[k] + 2.0) for k in range(1, 5)}
    return rw.latin_hypercube(bounds, samples)


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    return rw.sweep(line(), cases(60), workers=1)


def area(width: float, height: float = 1.0) -> dict[str, float]:
    if height < 0.0:
        raise ValueError(f"height is {height}")
    return {"area": width * height, "circumference": 2.0 * (width + height)}


def test_all_combinations_in_order_with_failures_as_rows() -> None:
    found = rw.sweep(area, {"width": [1, 2], "height": (3.0, -1.0)}, workers=1)
    assert list(found.columns) == ["width", "height", "area", "circumference", "error", "message"]
    assert found["width"].tolist() == [1, 1, 2, 2]
    assert found["area"].fillna(-1.0).tolist() == [3.0, -1.0, 6.0, -1.0]
    assert found["error"].tolist() == ["", "ValueError", "", "ValueError"]
    assert found["message"].tolist() == ["", "height is -1.0", "", "height is -1.0"]


def test_number_or_series_of_a_function() -> None:
    assert rw.sweep(lambda x: np.float64(x) ** 2, {"x": range(4)}, workers=1)["value"].tolist() == [0, 1, 4, 9]
    series = rw.sweep(lambda x: pd.Series({"half": x / 2, "name": f"case {x}"}), {"x": [1, 2]}, workers=1)
    assert series["half"].tolist() == [0.5, 1.0]
    assert series["name"].tolist() == ["case 1", "case 2"]


@pytest.mark.parametrize("found", [pd.DataFrame(), {"x": 1.0}, {"error": 1.0}, {"a": [1.0]}, [1.0]])
def test_an_invalid_return_value_is_a_failure(found: Any) -> None:
    row = rw.sweep(lambda x: found, {"x": [1.0]}, workers=1).iloc[0]
    assert row["error"] == "InputError"


def test_rows_are_the_equilibria_of_lines_declared_with_the_values(table: pd.DataFrame) -> None:
    assert table["error"].eq("").all()
    for row in (0, 17, 59):
        case = cases(60).iloc[row]
        heights = (HEIGHTS[0], *(case[f"s{k}.z"] for k in range(1, 5)), HEIGHTS[5])
        declared = rw.equilibrium(line(heights, tuple(case[f"l{k}.mass"] for k in range(5))))
        names = [n for n in table.columns if n.endswith((".tension_a", ".tension_b", ".length", ".vertical_a"))]
        expected = [declared[n] for n in names]
        np.testing.assert_allclose(table.loc[row, names].to_numpy(float), expected, rtol=1e-9)


def skyline() -> rw.System:
    """A carriage on a skyline over a rough saddle."""
    rig = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
        supports=[rw.IntermediateSupport("jack", at=(120.0, -12.0), friction=0.1)],
        tailspar=rw.TailSpar("tail", at=(300.0, -50.0)),
        skyline=ROPE,
        length=305.0,
        carriage=rw.Carriage("carriage", mass=450.0),
    )
    return rig.system(0, 50.0)


@pytest.mark.parametrize(
    ("system", "variants"),
    [
        (line(), cases(12)),
        (skyline(), rw.latin_hypercube({"carriage.mass": (100.0, 3000.0), "jack.z": (-14.0, -11.0)}, 12)),
    ],
    ids=["line", "skyline"],
)
def test_warm_and_cold_starts_agree(system: rw.System, variants: pd.DataFrame) -> None:
    model = rw.assemble(system)
    names = [n for n in model.y.names if ".slot_" not in n]
    warm = rw.sweep(model, variants, workers=1)
    assert warm["error"].eq("").all()
    for row, case in variants.iterrows():
        cold = rw.equilibrium(model, parameters=case.to_dict())
        np.testing.assert_allclose(warm.loc[row, names].to_numpy(float), [cold[n] for n in names], rtol=1e-9, atol=1e-6)


def test_lengths_count_from_the_declared_ones() -> None:
    longer = rw.sweep(line(), {"s0_s1.length": [101.0, 103.0]}, outputs=["s0_s1.tension_a"], workers=1)
    given = next(c.length for c in line().components.values() if isinstance(c, rw.Span))
    for length, tension in zip([101.0, 103.0], longer["s0_s1.tension_a"], strict=True):
        expected = rw.equilibrium(line(length=502.0 + length - given))["s0_s1.tension_a"]
        assert tension == pytest.approx(expected, rel=1e-9)


def test_a_slack_line_continues_a_taut_one() -> None:
    slack = line(length=540.0)
    found = rw.sweep(slack, {"l2.mass": [50.0, 300.0, 900.0]}, workers=1)
    for row in found.itertuples(index=False):
        cold = rw.equilibrium(slack, parameters={"l2.mass": row[0]})
        assert found.loc[found["l2.mass"] == row[0], "s2_s3.tension_a"].item() == pytest.approx(
            cold["s2_s3.tension_a"], rel=1e-12
        )


def test_an_impossible_line_is_a_row() -> None:
    found = rw.sweep(line(), {"l1.mass": [250.0, -1.0], "s1_s2.length": [101.0, 30.0]}, workers=1)
    assert found["error"].tolist() == ["", "EquilibriumError", "InputError", "InputError"]
    assert found["s0_s1.tension_a"].notna().tolist() == [True, False, False, False]
    assert found["message"].str.len().gt(10).tolist() == [False, True, True, True]


def test_outputs_by_name_with_units() -> None:
    found = rw.sweep(line(), {"l1.mass": [250.0]}, outputs=["l1.z", "s1.x", "s0_s1.tension_b"], workers=1)
    assert list(found.columns) == ["l1.mass", "l1.z", "s1.x", "s0_s1.tension_b", "error", "message"]
    assert found.attrs["units"] == {"l1.mass": "kg", "l1.z": "m", "s1.x": "m", "s0_s1.tension_b": "N"}


def test_two_processes_give_the_same_rows(table: pd.DataFrame) -> None:
    pd.testing.assert_frame_equal(rw.sweep(line(), cases(60), workers=2), table, check_exact=True)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_dask_cluster_gives_the_same_rows(table: pd.DataFrame, threads: int) -> None:
    settings = {"n_workers": 1, "threads_per_worker": threads, "processes": threads == 1, "dashboard_address": None}
    with LocalCluster(**settings) as cluster, Client(cluster) as client:
        pd.testing.assert_frame_equal(rw.sweep(line(), cases(60), workers=client), table, check_exact=True)


def test_a_file_holds_the_same_table(table: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "sweep.parquet"
    written = rw.sweep(line(), cases(60), workers=1, path=path)
    pd.testing.assert_frame_equal(written, table, check_exact=True)
    assert written.attrs["units"] == table.attrs["units"]
    pd.testing.assert_frame_equal(pd.read_parquet(path), written, check_exact=True)
    assert [p.name for p in tmp_path.iterdir()] == ["sweep.parquet"]
    before = path.stat().st_mtime_ns
    pd.testing.assert_frame_equal(rw.sweep(line(), cases(60), workers=1, path=path), written, check_exact=True)
    assert path.stat().st_mtime_ns == before


SCRIPT = """
import os, sys, time
import ropeway as rw

def study(x, y):
    time.sleep(float(os.environ["PAUSE"]))
    with open(os.environ["CALLS"], "a") as file:
        file.write(f"{x} {y}\\n")
    if y == 4:
        raise ValueError("four")
    return {"sum": x + 0.1 * y, "name": f"{x}-{y}"}

if __name__ == "__main__":
    rw.sweep(study, {"x": range(8), "y": range(5)}, workers=int(sys.argv[2]), path=sys.argv[1])
"""


def run(folder: Path, environment: Mapping[str, str], workers: int) -> subprocess.Popen[bytes]:
    (folder / "script.py").write_text(SCRIPT)
    everything = {**os.environ, **environment}
    command = [sys.executable, str(folder / "script.py"), str(folder / "sweep.parquet"), str(workers)]
    return subprocess.Popen(command, env=everything, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def test_a_killed_sweep_resumes_and_completes_its_table(tmp_path: Path) -> None:
    journal, calls = tmp_path / "sweep.parquet.journal", tmp_path / "calls"
    process = run(tmp_path, {"PAUSE": "0.1", "CALLS": os.devnull}, workers=2)
    while not journal.exists() or journal.read_bytes().count(b"\n") < 8:
        assert process.poll() is None
        time.sleep(0.02)
    helpers = psutil.Process(process.pid).children(recursive=True)
    process.kill()
    process.wait()
    assert psutil.wait_procs(helpers, timeout=20.0)[1] == []
    written = journal.read_bytes().count(b"\n") - 1
    assert written < 40
    assert run(tmp_path, {"PAUSE": "0", "CALLS": str(calls)}, workers=1).wait() == 0
    assert len(calls.read_text().splitlines()) == 40 - written

    found = pd.read_parquet(tmp_path / "sweep.parquet")
    grid = [(x, y) for x in range(8) for y in range(5)]
    assert found[["x", "y"]].to_numpy().tolist() == [list(case) for case in grid]
    assert found["sum"].fillna(-1.0).tolist() == [-1.0 if y == 4 else x + 0.1 * y for x, y in grid]
    assert found["name"].fillna("").tolist() == ["" if y == 4 else f"{x}-{y}" for x, y in grid]
    assert found["error"].tolist() == ["ValueError" if y == 4 else "" for _, y in grid]
    assert not journal.exists()


def test_an_incomplete_row_is_repeated(tmp_path: Path) -> None:
    path, journal = tmp_path / "sweep.parquet", tmp_path / "sweep.parquet.journal"
    done: list[float] = []

    def third(x: float) -> float:
        if len(done) == 3:
            raise KeyboardInterrupt
        done.append(x)
        return x / 3.0

    with pytest.raises(KeyboardInterrupt):
        rw.sweep(third, {"x": range(5)}, workers=1, path=path)
    text = journal.read_bytes()
    for cut, again in ((len(text) - 4, [2, 3, 4]), (10, [0, 1, 2])):
        journal.write_bytes(text[:cut])
        done.clear()
        with contextlib.suppress(KeyboardInterrupt):
            rw.sweep(third, {"x": range(5)}, workers=1, path=path)
        assert done == again
        path.unlink(missing_ok=True)
    done.clear()
    assert rw.sweep(third, {"x": range(5)}, workers=1, path=path)["value"].tolist() == [x / 3.0 for x in range(5)]


def test_files_of_another_sweep_are_not_changed(tmp_path: Path) -> None:
    path = tmp_path / "sweep.parquet"
    rw.sweep(area, {"width": [1.0]}, workers=1, path=path)
    for study, parameters in ((area, {"width": [2.0]}), (line(), {"l1.mass": [2.0]})):
        with pytest.raises(rw.InputError, match="another table"):
            rw.sweep(study, parameters, workers=1, path=path)
    path.rename(tmp_path / "kept")
    (tmp_path / "sweep.parquet.journal").write_text('"of another"\n')
    with pytest.raises(rw.InputError, match="another sweep"):
        rw.sweep(area, {"width": [1.0]}, workers=1, path=path)
    lines = (line(), line(masses=(1.0,)))
    kept = [rw.sweep(s, {"s1.z": [5.0]}, workers=1, path=tmp_path / f"{i}.parquet") for i, s in enumerate(lines)]
    assert kept[0]["s0_s1.tension_a"].item() > kept[1]["s0_s1.tension_a"].item()
    with pytest.raises(rw.InputError, match="another table"):
        rw.sweep(lines[0], {"s1.z": [5.0]}, workers=1, path=tmp_path / "1.parquet")


def number_or_text(width: float) -> float | str:
    return width if width < 2.0 else "wide"


def test_a_column_of_numbers_and_text_has_no_file(tmp_path: Path) -> None:
    with pytest.raises(rw.InputError, match="value is a number in some cases and text in others"):
        rw.sweep(number_or_text, {"width": [1.0, 3.0]}, workers=1, path=tmp_path / "a.parquet")


def test_a_mass_below_zero_is_a_failure() -> None:
    table = rw.sweep(line(), {"l1.mass": [100.0, -5.0]}, outputs="s0_s1.tension_a", workers=1)
    assert list(table["error"]) == ["", "InputError"]


def test_a_process_that_dies_is_an_error() -> None:
    with pytest.raises(rw.RopewayError, match="worker process has died"):
        rw.sweep(os._exit, {"status": [3]}, workers=2)


def test_wrong_input_is_reported_before_the_first_case() -> None:
    for names in ("l9.mass", "s1.zz", "s0_s1.tension_a"):
        with pytest.raises(rw.InputError, match=names):
            rw.sweep(line(), {names: [1.0]})
    with pytest.raises(rw.UnknownNameError, match="tension_c"):
        rw.sweep(line(), {"l1.mass": [1.0]}, outputs=["s0_s1.tension_c"])
    with pytest.raises(rw.InputError, match="not a number in every case"):
        rw.sweep(line(), {"l1.mass": [1.0, "2"]})
    with pytest.raises(rw.InputError, match="not a number in every case"):
        rw.sweep(line(), {"l1.mass": [True, False]})
    with pytest.raises(rw.InputError, match="not from a function"):
        rw.sweep(area, {"width": [1.0]}, outputs=["area"])
    with pytest.raises(rw.InputError, match="does not take these parameters"):
        rw.sweep(area, {"length": [1.0]})
    with pytest.raises(rw.InputError, match=r"study is 1\.0\. Give a function or a System or a Model"):
        rw.sweep(1.0, {"length": [1.0]})  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="Give several values"):
        rw.sweep(area, {"width": 1.0})
    with pytest.raises(rw.InputError, match="several values in their order"):
        rw.sweep(area, {"width": {1.0, 2.0}})  # it would give its rows in another order each time
    with pytest.raises(rw.InputError, match=r"parameters is \[1\.0\]\. Give a mapping"):
        rw.sweep(area, [1.0])  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="named 'error'"):
        rw.sweep(lambda error: error, {"error": [1.0]}, workers=1)
    with pytest.raises(rw.InputError, match="cannot tell"):
        rw.sweep(lambda width: width, {"width": [1.0]}, workers=1, path="never.parquet")
    for place, words in ((".", "end it in .parquet"), ("a.csv", "as Parquet"), ("no/such/a.parquet", "be written")):
        with pytest.raises(rw.InputError, match=words):
            rw.sweep(area, {"width": [1.0]}, workers=1, path=place)
    with pytest.raises(rw.InputError, match="no cases"):
        rw.sweep(area, {"width": []})
    for workers in (0, "2"):
        with pytest.raises(rw.InputError, match=f"workers is {workers!r}"):
            rw.sweep(area, {"width": [1.0]}, workers=workers)  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="cannot be sent to a worker process"):
        rw.sweep(lambda width: width, {"width": [1.0]}, workers=2)
    with pytest.raises(rw.InputError, match="numbers and text"):
        rw.sweep(area, {"width": [ROPE]}, workers=1, path="never.parquet")


def test_latin_hypercube_has_one_sample_in_each_part() -> None:
    found = rw.latin_hypercube({"a": (0.0, 10.0), "b": (-1.0, 1.0)}, 50, seed=3)
    for name, (low, high) in {"a": (0.0, 10.0), "b": (-1.0, 1.0)}.items():
        part = np.floor((found[name] - low) / (high - low) * 50).astype(int)
        assert sorted(part) == list(range(50))
    pd.testing.assert_frame_equal(found, rw.latin_hypercube({"a": (0.0, 10.0), "b": (-1.0, 1.0)}, 50, seed=3))
    assert not found.equals(rw.latin_hypercube({"a": (0.0, 10.0), "b": (-1.0, 1.0)}, 50, seed=4))
    with pytest.raises(rw.InputError, match="low one first"):
        rw.latin_hypercube({"a": (1.0, 1.0)}, 3)
    with pytest.raises(rw.InputError, match="at least one sample"):
        rw.latin_hypercube({"a": (1.0, 2.0)}, 0)
    with pytest.raises(rw.InputError, match="finite"):
        rw.latin_hypercube({"a": (1.0, np.inf)}, 3)


def test_a_study_without_a_signature_is_refused() -> None:
    with pytest.raises(rw.InputError, match="does not take these parameters"):
        rw.sweep(range, {"x": [1.0]}, workers=1)
