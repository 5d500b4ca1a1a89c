"""Ctrl-C ends long calls at the next safe point, with partial results, and never inside CasADi."""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.systems.dynamics.recorder import Recorder
from ropeway.systems.interrupts import interruptible, keeping, stop_if_interrupted, users_code
from ropeway.systems.native import compiler
from ropeway.systems.solvers.condensed_newton import CondensedNewton
from ropeway.systems.solvers.model_functions import Buffered
from ropeway.systems.studies.control.scheduling import nonlinear_program
from ropeway.systems.studies.skyline.station_solver import Stations
from support.fmus import corridor
from support.schedule_lines import line

Patch = pytest.MonkeyPatch


@pytest.fixture(autouse=True)
def handler() -> Iterator[None]:
    """Each test restores the handler."""
    before = signal.getsignal(signal.SIGINT)
    yield
    assert signal.getsignal(signal.SIGINT) is before


def ctrl_c_at(monkeypatch: Patch, owner: type, method: str, number: int) -> None:
    """A Ctrl-C just before the `number`-th call of a method, from any caller."""
    calls = 0
    original: Callable[..., Any] = getattr(owner, method)

    def counted(self: Any, *args: Any, **named: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls == number:
            signal.raise_signal(signal.SIGINT)
        return original(self, *args, **named)

    monkeypatch.setattr(owner, method, counted)


def later(seconds: float) -> threading.Timer:
    """A Ctrl-C from outside."""
    timer = threading.Timer(seconds, lambda: signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT))
    timer.start()
    return timer


@pytest.mark.parametrize("number", [3, 8, 15])
def test_a_simulation_keeps_its_records(number: int, monkeypatch: Patch) -> None:
    model = rw.assemble(line(6, 3))
    start = rw.equilibrium(model)
    whole = rw.simulate(model, 12.0, every=0.5, start=start)
    ctrl_c_at(monkeypatch, Recorder, "record", number)
    with pytest.raises(rw.Interrupted) as caught:
        rw.simulate(model, 12.0, every=0.5, start=start)
    part = caught.value.result
    assert isinstance(part, rw.Result)
    assert 0 < len(part.frame) < len(whole.frame)
    pd.testing.assert_frame_equal(part.full_frame, whole.full_frame.iloc[: len(part.records)])
    pd.testing.assert_frame_equal(rw.simulate(model, 12.0, every=0.5, start=start).frame, whole.frame)


def test_a_signal_inside_idas_is_not_dropped() -> None:
    model = rw.assemble(line(6, 3))
    rw.simulate(model, 5.0)
    for seconds in (0.11, 0.17, 0.23):
        timer = later(seconds)
        with pytest.raises(rw.Interrupted) as caught:
            rw.simulate(model, 1e6, every=50.0)
        timer.join()
        assert isinstance(caught.value.result, rw.Result)


def test_before_the_first_record_there_is_no_result(monkeypatch: Patch) -> None:
    ctrl_c_at(monkeypatch, Buffered, "__call__", 2)
    with pytest.raises(rw.Interrupted) as caught:
        rw.simulate(line(6, 3), 12.0)
    assert caught.value.result is None


def test_load_paths_and_payloads_keep_their_rows(monkeypatch: Patch) -> None:
    rig, stations = corridor(haulback=None, haulback_tension=None), np.linspace(20.0, 130.0, 8)
    whole = rw.load_path(rig, 900.0, stations)
    ctrl_c_at(monkeypatch, Stations, "solve", 5)
    with pytest.raises(rw.Interrupted) as caught:
        rw.load_path(rig, 900.0, stations)
    pd.testing.assert_frame_equal(caught.value.result, whole.iloc[:4])
    assert caught.value.result.attrs["units"]["carriage_x"] == "m"
    monkeypatch.undo()
    whole = rw.payload(rig, stations=stations[:3]).frame
    ctrl_c_at(monkeypatch, Stations, "solve", 15)
    with pytest.raises(rw.Interrupted) as caught:
        rw.payload(rig, stations=stations[:3])
    rows = caught.value.result
    assert 0 < len(rows) < 3
    pd.testing.assert_frame_equal(rows, whole.iloc[: len(rows)])


def test_an_inhaul_keeps_the_rows_of_its_current_section(monkeypatch: Patch) -> None:
    whole = rw.inhaul(corridor(), payload=1000.0, start=140.0, end=20.0)
    ctrl_c_at(monkeypatch, Recorder, "record", 15)
    with pytest.raises(rw.Interrupted) as caught:
        rw.inhaul(corridor(), payload=1000.0, start=140.0, end=20.0)
    rows = caught.value.result.frame
    assert 5 < len(rows) < len(whole.frame)
    pd.testing.assert_frame_equal(rows, whole.frame.iloc[: len(rows)])


def test_ipopt_stops_between_iterations(monkeypatch: Patch) -> None:
    evaluations: list[int] = []
    original = nonlinear_program._Stop.eval

    def counted(self: Any, arguments: Any) -> Any:
        evaluations.append(1)
        if len(evaluations) == 4:
            signal.raise_signal(signal.SIGINT)
        return original(self, arguments)

    monkeypatch.setattr(nonlinear_program._Stop, "eval", counted)
    with pytest.raises(rw.Interrupted) as caught:
        rw.optimise_schedule(line(6, 2), 12.0, intervals=6)
    assert caught.value.result is None
    assert len(evaluations) == 4


def test_a_sweep_keeps_its_rows_and_stops_a_function_at_once() -> None:
    def study(x: float) -> float:
        if x == 3.0:
            signal.raise_signal(signal.SIGINT)
            pytest.fail("the function continued")
        return 2.0 * x

    with pytest.raises(rw.Interrupted) as caught:
        rw.sweep(study, {"x": [0.0, 1.0, 2.0, 3.0, 4.0]}, workers=1)
    table = caught.value.result
    assert table["value"].tolist() == [0.0, 2.0, 4.0]
    assert table["error"].tolist() == [""] * 3


def test_a_sweep_continues_after_an_interrupt(tmp_path: Path, monkeypatch: Patch) -> None:
    path, masses = tmp_path / "m.parquet", {"l1.mass": np.linspace(100.0, 200.0, 6)}
    whole = rw.sweep(line(6, 3), masses, outputs="c1.tension_in", workers=1)
    ctrl_c_at(monkeypatch, CondensedNewton, "solve", 3)
    with pytest.raises(rw.Interrupted) as caught:
        rw.sweep(line(6, 3), masses, outputs="c1.tension_in", workers=1, path=path)
    monkeypatch.undo()
    assert 0 < len(caught.value.result) < 6
    assert not path.exists()
    pd.testing.assert_frame_equal(rw.sweep(line(6, 3), masses, outputs="c1.tension_in", workers=1, path=path), whole)


def test_the_compiler_is_killed(tmp_path: Path, monkeypatch: Patch) -> None:
    script, begun = tmp_path / "cc", tmp_path / "begun"
    script.write_text(f"#!/bin/sh\nsleep 600 &\necho $! > {begun}.part\nmv {begun}.part {begun}\nwait\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))

    def when_begun() -> None:
        while not begun.exists():
            time.sleep(0.01)
        later(0.0)

    thread = threading.Thread(target=when_begun)
    thread.start()
    with pytest.raises(rw.Interrupted):
        interruptible(compiler.compile_library)(tmp_path, ["a.c"], compiler.host(), tmp_path / "a.so")
    thread.join()
    for _ in range(1000):
        try:
            os.kill(int(begun.read_text()), 0)
        except ProcessLookupError:
            return
        time.sleep(0.01)
    pytest.fail("a process of the compiler continues")


@interruptible
def long_call(steps: int, done: list[int], interrupt_at: int) -> str:
    with keeping(lambda: tuple(done)):
        for k in range(steps):
            if k == interrupt_at:
                signal.raise_signal(signal.SIGINT)
            done.append(k)
            stop_if_interrupted()
    return "all"


def test_a_call_stops_at_the_next_point() -> None:
    with pytest.raises(rw.Interrupted) as caught:
        long_call(9, [], 4)
    assert caught.value.result == (0, 1, 2, 3, 4)


def test_a_signal_in_the_last_step_keeps_the_whole_result() -> None:
    @interruptible
    def last_step() -> str:
        signal.raise_signal(signal.SIGINT)
        return "all"

    with pytest.raises(rw.Interrupted) as caught:
        last_step()
    assert caught.value.result == "all"


def test_an_error_after_a_signal_is_its_context() -> None:
    @interruptible
    def failing() -> None:
        signal.raise_signal(signal.SIGINT)
        raise rw.EquilibriumError("No balance")

    with pytest.raises(rw.Interrupted) as caught:
        failing()
    assert isinstance(caught.value.__context__, rw.EquilibriumError)


def test_a_second_signal_does_not_wait() -> None:
    @interruptible
    def ignoring() -> None:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        pytest.fail("it continued")

    with pytest.raises(rw.Interrupted):
        ignoring()


def test_a_signal_acts_at_once_in_a_users_function_but_not_in_a_call_from_it() -> None:
    done: list[int] = []

    @interruptible
    def outer() -> None:
        with users_code():
            long_call(5, done, 2)

    with pytest.raises(rw.Interrupted):
        outer()
    assert done == [0, 1, 2]


def test_a_users_handler_is_called_between_steps() -> None:
    seen: list[int] = []

    def own(number: int, frame: object) -> None:
        seen.append(number)

    def refusing(number: int, frame: object) -> None:
        raise TimeoutError("the user's own")

    before = signal.signal(signal.SIGINT, own)
    try:
        done: list[int] = []
        assert long_call(6, done, 3) == "all"
        assert (seen, len(done)) == ([signal.SIGINT], 6)
        signal.signal(signal.SIGINT, refusing)
        done.clear()
        with pytest.raises(TimeoutError, match="the user's own"):
            long_call(6, done, 3)
        assert done == [0, 1, 2, 3]
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        assert long_call(6, [], 3) == "all"
    finally:
        signal.signal(signal.SIGINT, before)


def test_another_thread_installs_no_handler() -> None:
    found: list[object] = []

    def work() -> None:
        before = signal.getsignal(signal.SIGINT)
        watched = interruptible(lambda: signal.getsignal(signal.SIGINT))
        found.append(watched() is before)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [True]


@pytest.mark.slow
def test_worker_processes_end() -> None:
    import multiprocessing

    timer = later(6.0)
    with pytest.raises(rw.Interrupted) as caught:
        rw.sweep(line(6, 3), {"l1.mass": np.linspace(100.0, 200.0, 1_000_000)}, outputs="c1.tension_in", workers=2)
    timer.join()
    assert len(caught.value.result) < 1_000_000
    assert not multiprocessing.active_children()


@pytest.mark.slow
def test_every_long_call_stops(monkeypatch: Patch, tmp_path: Path) -> None:
    monkeypatch.setenv("ROPEWAY_CACHE", str(tmp_path))  # an export that compiles nothing is too short
    response = rw.ThresholdResponse(low=30e3, high=60e3, increment=0.01)
    tuned = {"over": {"increment": (0.002, 0.05)}, "minimise": "peak tension", "until": 600.0, "workers": 1}
    long_line = line(12, 3)
    result = rw.simulate(long_line, 600.0)
    calls: dict[str, tuple[Callable[[], Any], type]] = {
        "optimise": (lambda: rw.optimise_schedule(long_line, 60.0, intervals=60), rw.SchedulePlan),
        "again": (lambda: rw.receding_horizon(long_line, 200.0, horizon=20.0, every=4.0), pd.DataFrame),
        "tune": (lambda: rw.tune_response(long_line, response, **tuned), pd.DataFrame),
        "derive": (lambda: rw.sensitivities(result, of="c1.tension_in", to=["l3.mass", "c1.speed"]), pd.DataFrame),
        "export": (lambda: rw.fmu.export(long_line, tmp_path / "never.fmu"), Path),
    }
    for name, (call, kind) in calls.items():
        timer = later(1.0)
        with pytest.raises(rw.Interrupted) as caught:
            call()
        timer.join()
        assert caught.value.result is None or isinstance(caught.value.result, kind), name
    assert not (tmp_path / "never.fmu").exists()
