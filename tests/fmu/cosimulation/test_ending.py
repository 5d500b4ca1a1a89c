"""Runs that an FMU ends, discards or fails in, and what is left of them."""

import os
import signal
import zipfile
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.fmu import CoSimulation, FmuImportError, FmuRunError, Slave, StepControl, load
from ropeway.fmu.cosimulation.recording import Recorder
from support.kinds import described
from support.masses import mass_fmu

Kind = Literal["CoSimulation", "ModelExchange"]


def run(path: Path, kind: Kind, until: float = 1.0, more: dict[str, Any] | None = None, **start: Any) -> Any:
    together = CoSimulation(0.1, **(more or {}))
    together.add("k", path, kind=kind, start={"u": 1.0, **start})
    return together.run(until)


@pytest.mark.parametrize("more", [{}, {"iterated": True}, {"control": StepControl("Richardson")}])
def test_an_fmu_that_ends_the_run_ends_it(kinds: Path, kind: Kind, more: dict[str, Any]) -> None:
    frame = run(kinds, kind, more=more, stop_at=0.437)
    assert frame.index[-1] == pytest.approx(0.437, abs=1e-9)
    assert frame["k.x"].iloc[-1] == pytest.approx(0.437, abs=1e-7)
    assert frame.attrs["ended"].startswith(f"'k' ({kinds.name}) ends the run at t = 0.437 s")
    assert run(kinds, kind).attrs["ended"] is None


def test_all_stop_where_one_ends(kinds2: Path, kinds3: Path) -> None:
    for first, iterated, last in (("a", False, 0.25), ("b", False, 0.2), ("b", True, 0.25)):
        together = CoSimulation(0.1, iterated=iterated)
        for name in sorted("ab", key=lambda n: n != first):  # one that has gone further already is left out
            path, start = (kinds2, {"stop_at": 0.25}) if name == "a" else (kinds3, {})
            together.add(name, path, start={"u": 1.0, **start})
        together.connect("a.x", "b.d")
        frame = together.run(1.0)
        assert frame.index[-1] == pytest.approx(last)
        assert frame[["a.x", "b.x"]].iloc[-1].to_list() == pytest.approx([last, last])
        assert "'a' (kinds2.fmu) ends the run at t = 0.25 s" in frame.attrs["ended"]


def test_an_end_at_once(kinds: Path) -> None:
    frame = run(kinds, "ModelExchange", stop_at=0.0)
    assert frame.index.tolist() == [0.0]
    assert "ends the run at t = 0 s" in frame.attrs["ended"]


def test_discarded_and_failed_steps_keep_the_rows(kinds: Path, kind: Kind) -> None:
    with pytest.raises(FmuRunError, match="it has failed") as failed:
        run(kinds, kind, error_at=0.55)
    rows = failed.value.result
    assert rows is not None
    assert rows.index.tolist() == pytest.approx(np.arange(6) * 0.1)
    assert rows["k.x"].to_numpy() == pytest.approx(rows.index)
    assert "smaller" not in failed.value.remedy
    assert rows.attrs["units"].keys() == set(rows.columns)


def test_a_smaller_step_is_advised_where_it_can_help(tmp_path: Path, kinds: Path) -> None:
    with pytest.raises(FmuRunError, match=r"rejected a step of 0\.1 s at t = 0\.3 s.*no step from there") as varied:
        run(kinds, "CoSimulation", discard_at=0.35)
    assert varied.value.remedy == "Use a smaller step"
    assert varied.value.result is not None
    assert len(varied.value.result) == 4
    fmi: Literal["2.0", "3.0"] = "2.0" if "2" in kinds.name else "3.0"
    path = described(tmp_path / "stiff.fmu", fmi, kinds.with_suffix(".so"), varies_steps=False)
    with pytest.raises(FmuRunError) as fixed:
        run(path, "CoSimulation", discard_at=0.35)
    assert "smaller" not in fixed.value.remedy


def test_a_start_that_fails_has_no_rows(mass: Path) -> None:
    together = CoSimulation(0.1)
    together.add("spring", mass, start={"stiffness": -1.0, "x": 1.0})
    together.add("mass", mass)
    together.connect("spring.f", "mass.force")
    together.connect("mass.a", "spring.x_in")
    with pytest.raises(FmuRunError) as caught:
        together.run(0.1)
    assert caught.value.result is None


def test_instances_are_terminated(kinds: Path, kind: Kind) -> None:
    with Slave(load(kinds), kind=kind) as slave:
        slave.enter(0.0, {})
        slave.leave()
        slave.step(0.1, {}, {})
    assert slave.log == ["terminated"]
    with Slave(load(kinds), kind=kind) as unused:
        pass
    assert unused.log == []


def test_a_failed_termination_is_logged(mass: Path) -> None:
    with Slave(load(mass)) as slave:
        slave.enter(0.0, {})
        slave.leave()
    assert slave.log == ["Termination failed"]


def test_a_binary_that_does_not_load(tmp_path: Path, mass: Path) -> None:
    path, here = tmp_path / "text.fmu", os.getcwd()
    with zipfile.ZipFile(mass) as source, zipfile.ZipFile(path, "w") as target:
        for name in source.namelist():
            target.writestr(name, "no library" if name.endswith(".so") else source.read(name))
    with pytest.raises(FmuImportError, match=r"text\.fmu cannot be instantiated: Failed to load shared library"):
        Slave(load(path))
    assert os.getcwd() == here
    good = mass_fmu(tmp_path / "mass.fmu")
    with Slave(load(os.path.relpath(good))) as slave:
        slave.enter(0.0, {})


def test_ctrl_c_keeps_the_rows(mass: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add = Recorder.add

    def interrupted(self: Recorder, time: float) -> None:
        add(self, time)
        if len(self.times) == 8:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Recorder, "add", interrupted)
    together = CoSimulation(0.1)
    together.add("k", mass)
    with pytest.raises(rw.Interrupted) as caught:
        together.run(10.0)
    assert isinstance(caught.value.result, pd.DataFrame)
    assert caught.value.result.index.tolist() == pytest.approx(np.arange(8) * 0.1)
