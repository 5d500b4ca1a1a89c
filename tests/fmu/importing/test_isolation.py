"""FMUs that crash, hang or leave things behind, and the session that goes on."""

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import ropeway as rw
from ropeway.fmu import CoSimulation, FmuImportError, FmuRunError, Slave, load
from ropeway.fmu.cosimulation.recording import Recorder
from support.hostiles import DEEDS, hostile_fmu, library
from support.masses import pair


def children() -> set[str]:
    return {pid for task in Path("/proc/self/task").iterdir() for pid in (task / "children").read_text().split()}


@pytest.fixture(autouse=True)
def nothing_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """No process, folder, open library or changed working folder."""
    here, running, own = os.getcwd(), children(), tmp_path / "temporary"
    own.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(own))
    yield
    assert os.getcwd() == here
    assert children() <= running
    assert [p for p in own.iterdir() if any(p.iterdir())] == []
    assert str(own) not in Path("/proc/self/maps").read_text()


def runs(path: Path, until: float = 1.0, **how: Any) -> pd.DataFrame:
    together = CoSimulation(0.1)
    together.add("bad", path, **how)
    together.add("good", path, start={"u1": 2.0})
    together.connect("good.y1", "bad.u3")
    return together.run(until)


WORDS = {
    "segfault": r"ended its process by signal 11 \(Segmentation fault\) in the call 'step' at t = 0\.3 s",
    "exit": r"ended its process by exit\(3\)",
    "abort": r"ended its process by signal 6 \(Aborted\)",
    "bus": r"ended its process by signal 7 \(Bus error\)",
    "hang": r"did not answer the call 'step' within 1 s",
    "fatal": r"rejected a step of 0\.1 s at t = 0\.3 s",
}


@pytest.mark.parametrize("deed", WORDS)
def test_a_fault_keeps_session_and_rows(hostile: Path, deed: str) -> None:
    timeout = 1.0 if deed == "hang" else None
    with pytest.raises(FmuRunError, match=rf"'bad' \(hostile\.fmu\) {WORDS[deed]}") as caught:
        runs(hostile, isolated=True, timeout=timeout, start={"deed": DEEDS.index(deed), "when": 0.35})
    assert caught.value.fatal
    rows = caught.value.result
    assert rows is not None
    assert rows.index.tolist() == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert rows["bad.y3"].tolist() == [2.0] * 4
    assert rows["good.y1"].tolist() == [2.0] * 4
    assert runs(hostile)["good.t"].iloc[-1] == pytest.approx(1.0)


@pytest.mark.slow
@pytest.mark.parametrize("deed", ["overflow", "trash"])
def test_other_faults(hostile: Path, deed: str) -> None:
    with pytest.raises(FmuRunError, match="ended its process by signal 11"):
        runs(hostile, isolated=True, start={"deed": DEEDS.index(deed), "when": 0.35})


@pytest.mark.parametrize(
    ("deed", "cause"),
    [("segfault", r"ended its process by signal 11"), ("hang", r"did not answer the call 'open' within 1 s")],
)
def test_a_fault_at_instantiation(hostile: Path, deed: str, cause: str) -> None:
    with pytest.raises(
        FmuImportError, match=rf"hostile\.fmu cannot be instantiated: '{deed}' \(hostile\.fmu\) {cause}"
    ):
        Slave(load(hostile, isolated=True, timeout=1.0), deed)


def test_ctrl_c_ends_a_call_that_hangs(hostile: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    add = Recorder.add

    def recorded(self: Recorder, time: float) -> None:
        add(self, time)
        if time == pytest.approx(0.3):
            clock.start()

    monkeypatch.setattr(Recorder, "add", recorded)
    with pytest.raises(rw.Interrupted) as caught:
        runs(hostile, isolated=True, timeout=600.0, start={"deed": DEEDS.index("hang"), "when": 0.35})
    clock.join()
    assert isinstance(caught.value.result, pd.DataFrame)
    assert len(caught.value.result) == 4


def test_a_killed_process_and_one_that_is_forgotten(hostile: Path) -> None:
    fmu, before = load(hostile, isolated=True), children()
    slave = Slave(fmu, "slave")
    slave.enter(0.0, {"u1": 1.0})
    slave.leave()
    slave.step(0.5, {"u1": 1.0}, {"u1": 1.0})
    assert slave.get(["y1", "t"]).tolist() == [1.0, 0.5]
    assert slave.get(["t"]).tolist() == [0.5]
    slave.step(0.5, {"u1": 1.0}, {"u1": 3.0})
    assert slave.get(["y1", "t"]).tolist() == [3.0, 1.0]  # answered with the step
    slave.set({"u1": 7.0})
    assert slave.get(["y1", "t"]).tolist() == [7.0, 1.0]
    (pid,) = children() - before
    os.kill(int(pid), signal.SIGKILL)
    with pytest.raises(FmuRunError, match=r"by signal 9 \(Killed\) in the call 'get' at t = 1 s"):
        slave.get(["y2"])
    with pytest.raises(FmuRunError, match="has no process any more"):
        slave.get(["y2"])
    slave.close()
    forgotten = Slave(fmu)
    assert children() - before
    del forgotten


def test_messages_do_not_pile_up(hostile: Path) -> None:
    with Slave(load(hostile, isolated=True)) as slave:  # it keeps them on both sides
        slave.enter(0.0, {"deed": DEEDS.index("noise")})
        slave.leave()
        for _ in range(2100):
            slave.step(0.1, {}, {})
        assert 1000 <= len(slave.log) <= 2000


def test_isolated_slaves_give_the_same_rows(mass: Path) -> None:
    frames = []
    for isolated in (False, True):
        together = pair(load(mass, isolated=isolated), 0.1, master="Gauss-Seidel", iterated=True)
        frames.append(together.run(1.0))
    pd.testing.assert_frame_equal(*frames, check_exact=True)


def test_all_types_pass(kinds3: Path) -> None:
    frames = []
    for isolated in (False, True):
        together = CoSimulation(0.1)
        start = {"text": "Füße", "binary": b"\x00\xff", "uint64": 2**64 - 1, "brake": True, "gear": "high", "n": 2}
        together.add("k", kinds3, isolated=isolated, start={**start, "v": [1.0, 2.0], "stop_at": 0.25})
        frames.append(together.run(0.5))
    pd.testing.assert_frame_equal(*frames, check_exact=True)
    assert frames[0].attrs == frames[1].attrs
    assert "ends the run at t = 0.25 s" in frames[1].attrs["ended"]


def test_errors_pass(kinds2: Path) -> None:
    with Slave(load(kinds2, isolated=True)) as slave:
        slave.enter(0.0, {"error_at": 0.05})
        slave.leave()
        with pytest.raises(FmuRunError, match="it has failed") as failed:
            slave.step(0.1, {}, {})
        assert not failed.value.fatal
        with pytest.raises(rw.fmu.FmuVariableError, match="has no variable 'y'") as unknown:
            slave.get(["y"])
        assert unknown.value.variable == "y"


def test_the_process_ends_with_its_session(hostile: Path) -> None:
    script = (
        "import sys, ropeway as rw; s = rw.fmu.Slave(rw.fmu.load(sys.argv[1], isolated=True));"
        "s.enter(0.0, {'deed': 4, 'when': -1.0}); s.leave(); print(s._slave._process.pid, flush=True);"
        "s.step(1.0, {}, {})"
    )
    command = [sys.executable, "-c", script, str(hostile)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, env={**os.environ, "TMPDIR": tempfile.gettempdir()}
    ) as session:
        assert session.stdout is not None
        pid = int(session.stdout.readline())
        session.kill()
    until = time.monotonic() + 10.0
    while Path(f"/proc/{pid}").exists() and time.monotonic() < until:
        time.sleep(0.05)
    assert not Path(f"/proc/{pid}").exists()


def test_the_working_folder_is_kept(tmp_path: Path, hostile: Path) -> None:
    here = os.getcwd()
    mover = hostile_fmu(tmp_path / "mover.fmu", library(tmp_path / "mover.so", "-DMOVES_AT_LOAD"))
    fmu = load(os.path.relpath(mover))
    assert fmu.path.is_absolute()
    with Slave(fmu, "move"):
        assert os.getcwd() == here
    with Slave(load(hostile)) as slave:
        slave.enter(0.0, {"deed": DEEDS.index("move"), "when": -1.0})
        slave.leave()
        slave.step(0.1, {}, {})
        assert os.getcwd() == here


def test_libraries_are_closed_on_failure(tmp_path: Path, hostile: Path) -> None:
    with pytest.raises(FmuImportError, match=r"hostile\.fmu cannot be instantiated"):
        Slave(load(hostile), "refused")
    lacking = hostile_fmu(tmp_path / "lacking.fmu", library(tmp_path / "lacking.so", "-DLACKS_A_FUNCTION"))
    with pytest.raises(FmuImportError, match=r"lacking\.fmu cannot be instantiated: .*fmi2CancelStep"):
        Slave(load(lacking))
    with Slave(load(hostile)) as slave:
        slave.enter(0.0, {"deed": DEEDS.index("fatal"), "when": -1.0})
        slave.leave()
        with pytest.raises(FmuRunError):
            slave.step(0.1, {}, {})


def test_one_instance_in_a_process(tmp_path: Path, hostile_binary: Path) -> None:
    once = hostile_fmu(tmp_path / "once.fmu", hostile_binary, canBeInstantiatedOnlyOncePerProcess="true")
    fmu = load(once)
    with Slave(fmu):
        with pytest.raises(FmuImportError, match=r"once\.fmu allows one instance in a process.*isolated=True"):
            Slave(fmu)
        with Slave(load(once, isolated=True)):
            pass
    with Slave(fmu):
        pass


def test_a_changed_file_is_noticed(tmp_path: Path, hostile_binary: Path) -> None:
    path = hostile_fmu(tmp_path / "changed.fmu", hostile_binary)
    fmu = load(path)
    path.touch()
    with Slave(fmu):
        pass
    hostile_fmu(path, hostile_binary, [("extra", b"1")])
    with pytest.raises(FmuImportError, match=r"changed\.fmu has changed since it was loaded. Load it again"):
        Slave(fmu)
    path.unlink()
    with pytest.raises(FmuImportError, match=r"changed\.fmu cannot be unpacked"):
        Slave(fmu)


def test_components_are_not_isolated(hostile: Path) -> None:
    with pytest.raises(FmuImportError, match="a component runs in the process of the session"):
        rw.fmu.component("part", load(hostile, isolated=True))
    with pytest.raises(rw.InputError, match="timeout"):
        load(hostile, timeout=0.0)
