"""What is recorded, at which rates slaves run, and what changes in a run."""

import time
import tracemalloc
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.fmu import CoSimulation, FmuRunError, FmuVariableError, StepControl
from ropeway.fmu.cosimulation.coupling import Coupling
from ropeway.fmu.cosimulation.recording import Recorder
from support.hostiles import hostile_fmu
from support.kinds import described
from support.masses import exact_pair, pair


def alone(path: Path, step: float = 0.1, **start: Any) -> CoSimulation:
    together = CoSimulation(step)
    together.add("k", path, start=start)
    return together


def test_chosen_outputs_at_chosen_times(kinds3: Path) -> None:
    every = alone(kinds3, u=1.0).run(1.0)
    few = alone(kinds3, u=1.0).run(1.0, outputs=["k.text_out", "k.x", "k.u", "k.limit"], every=0.3)
    assert few.index.tolist() == pytest.approx([0.0, 0.3, 0.6, 0.9, 1.0])
    assert list(few) == ["k.text_out", "k.x", "k.u", "k.limit"]
    assert few["k.x"].tolist() == every["k.x"].iloc[[0, 3, 6, 9, 10]].tolist()
    assert few["k.u"].tolist() == [1.0] * 5
    assert few.dtypes.astype(str).tolist() == ["object", "float64", "float64", "bool"]
    assert few.attrs["units"].keys() == set(few)
    coarse = alone(kinds3, 0.4, u=1.0).run(1.2, every=0.1)
    assert coarse.index.tolist() == pytest.approx([0.0, 0.4, 0.8, 1.2])


@pytest.mark.parametrize(
    ("outputs", "error", "cause"),
    [
        (["l.x"], rw.InputError, "no slave is named 'l'"),
        (["k.y"], FmuVariableError, "has no variable 'y'"),
        (["k.ticked"], FmuVariableError, "only at the ticks of a clock"),
        (["k.x", "k.x"], rw.InputError, "named twice"),
        ([], rw.InputError, "outputs is empty"),
    ],
)
def test_outputs_that_cannot_be_recorded(kinds3: Path, outputs: Any, error: Any, cause: str) -> None:
    with pytest.raises(error, match=cause):
        alone(kinds3).run(1.0, outputs=outputs)


@pytest.mark.parametrize("expected", [8001, 0])
def test_rows_need_no_more_memory_than_the_frame(expected: int) -> None:
    """Slaves that cost nothing: only the rows are measured."""
    row = np.arange(200.0)
    entries = {f"y{i}": SimpleNamespace(kind="Real", dtype="float64", causality="output") for i in range(200)}
    variables = pd.DataFrame({"unit": "m"}, index=list(entries))
    fmu = SimpleNamespace(entries=entries, variables=variables, outputs=lambda *kinds: [] if kinds else list(entries))
    coupling = cast(
        Coupling, SimpleNamespace(slaves={"k": SimpleNamespace(fmu=fmu, get=lambda names: row)}, ended=None)
    )
    tracemalloc.start()
    record = Recorder(coupling, expected=expected)
    for i in range(8001):
        record.add(0.1 * i)
    for entry in fmu.entries.values():
        entry.clocked = False
    frame = record.frame()
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1.2 * frame.memory_usage().sum()
    assert frame["k.y199"].iloc[-1] == 199.0


def test_a_run_at_the_pace_of_the_clock(kinds2: Path) -> None:
    begin = time.monotonic()
    frame = alone(kinds2, u=1.0).run(2.0, pace=10.0)
    assert time.monotonic() - begin >= 0.2
    assert frame.attrs["late"] >= 0.0
    assert frame["k.x"].iloc[-1] == pytest.approx(2.0)


def test_a_scenario_takes_precedence(kinds2: Path, kinds3: Path, tmp_path: Path) -> None:
    """A connected input, a switch, a parameter and an input without a connection."""
    together = CoSimulation(0.1)
    together.add("a", kinds2, start={"u": 1.0})
    together.add("b", kinds3, start={"gain": 1.0, "d": 1.0})
    together.connect("a.d_out", "b.u")
    together.connect("a.brake_out", "b.brake")
    text = "time,variable,value\n0.25,b.u,2\n0.5,b.u,\n0.5,b.gain,3\n0.7,b.brake,true\n0.9,b.brake,\n0.3,a.u,0.0\n"
    (tmp_path / "changes.csv").write_text(text)
    rows = [
        (0.25, "b.u", 2.0),
        (0.5, "b.u", None),
        (0.5, "b.gain", 3.0),
        (0.7, "b.brake", True),
        (0.9, "b.brake", None),
    ]
    table = pd.DataFrame([*rows, (0.3, "a.u", 0.0)], columns=["time", "variable", "value"])
    for scenario in (table, tmp_path / "changes.csv"):
        last = together.run(1.0, scenario=scenario).iloc[-1]
        assert last["a.x"] == pytest.approx(0.3)
        assert last["b.x"] == pytest.approx(0.25 * 1.0 + 0.25 * 3.0 + 0.2 * 3.0 + 0.1 * 3.0)
    assert together.run(1.0)["b.x"].iloc[-1] == pytest.approx(1.0)


def test_a_scenario_with_iterated_steps(mass: Path) -> None:
    """The force on the second mass is given from the start on, so that it moves as if it were alone."""
    scenario = pd.DataFrame({"time": [0.0], "variable": ["two.force"], "value": [1.0]})
    frame = pair(mass, 0.05, iterated=True).run(2.0, scenario=scenario)
    mass_, spring, damper = 2.0, 2.0, 0.5
    decay, turn = damper / (2 * mass_), np.sqrt(spring / mass_ - (damper / (2 * mass_)) ** 2)
    t = frame.index.to_numpy()
    exact = (1.0 - np.exp(-decay * t) * (np.cos(turn * t) + decay / turn * np.sin(turn * t))) / spring
    assert frame["two.x"].to_numpy() == pytest.approx(exact, abs=1e-5)


@pytest.mark.parametrize(
    ("row", "cause"),
    [
        ((0.0, "k.level", 1.0), "it cannot change during a run"),
        ((0.0, "l.u", 1.0), "no slave is named 'l'"),
        ((0.0, "k.brake", 0.5), "it cannot be 0.5"),
        ((0.0, "k.u", None), r"no value for 'k\.u' at 0 s"),
        (("soon", "k.u", 1.0), "a time that is not a number"),
    ],
)
def test_bad_scenarios(kinds2: Path, row: Any, cause: str) -> None:
    table = pd.DataFrame([row], columns=["time", "variable", "value"])
    with pytest.raises((rw.InputError, FmuVariableError), match=cause):
        alone(kinds2).run(1.0, scenario=table)
    with pytest.raises(rw.InputError, match="no column value"):
        alone(kinds2).run(1.0, scenario=table[["time", "variable"]])


def test_rates_of_their_own(mass: Path) -> None:
    """The heavy mass takes steps of five; the error follows its step, and the light one keeps its own."""
    errors, frames = [], []
    for step in (0.01, 0.005):
        together = CoSimulation(step)
        source = pair(mass, step)
        for name, participant in source._participants.items():
            slow = 5.0 * step if name == "two" else None
            together.add(name, mass, start=dict(participant.start), step=slow)
        for source_, target in (("two.x", "one.x_in"), ("two.v", "one.v_in"), ("one.f", "two.force")):
            together.connect(source_, target)
        frame = together.run(2.02)
        errors.append(np.abs(frame[["one.x", "two.x"]] - exact_pair(frame.index)[:, [0, 2]]).to_numpy().max())
        frames.append(frame)
    held = frames[0]["two.x"].to_numpy()
    assert set(held[5:10]) == {held[5]}
    assert held[10] != held[5]
    assert frames[0].index[-1] == 2.02
    assert 1.7 < errors[0] / errors[1] < 2.3
    assert errors[0] < 0.05


def test_a_slow_slave_with_switches_and_signals(kinds2: Path, kinds3: Path) -> None:
    together = CoSimulation(0.1)
    together.add("a", kinds2, start={"u": 1.0, "level": 0.45})
    together.add("b", kinds3, step=0.3)
    together.connect("a.limit", "b.brake")
    frame = together.run(1.2, inputs={"b.u": rw.Schedule((0.0, 1.2), (0.0, 1.2))})
    assert frame["b.x"].iloc[[3, 6, 9]].to_list() == pytest.approx([0.045, 0.18, 0.18])
    assert frame["b.x"].iloc[4] == frame["b.x"].iloc[3]


def test_bad_rates(mass: Path) -> None:
    with pytest.raises(rw.InputError, match=r"'m' has steps of 0\.25 s, which is no multiple of 0\.1 s"):
        CoSimulation(0.1).add("m", mass, step=0.25)
    for more in ({"iterated": True}, {"control": StepControl("coupling error")}):
        with pytest.raises(rw.InputError, match="has a step of its own"):
            CoSimulation(0.1, **more).add("m", mass, step=0.2)  # type: ignore[arg-type]


def test_steps_of_one_length(tmp_path: Path, kinds2: Path) -> None:
    path = described(tmp_path / "stiff.fmu", "2.0", kinds2.with_suffix(".so"), varies_steps=False)
    assert len(alone(path).run(0.7)) == 8
    with pytest.raises(rw.InputError, match=r"'k' accepts steps of one length only, and 0\.75 s are no whole number"):
        alone(path).run(0.75)
    together = CoSimulation(0.1, control=StepControl("coupling error"))
    together.add("k", path)
    with pytest.raises(rw.InputError, match="Leave out the step control"):
        together.run(1.0)


def test_singular_loops_are_errors(hostile: Path, hostile_binary: Path, tmp_path: Path) -> None:
    """y = u and u = y: of one FMU, and around two of them; a loop that an input determines is none."""
    one = CoSimulation(0.1)
    one.add("a", hostile, start={"u1": 2.0})
    one.connect("a.y1", "a.u1")
    with pytest.raises(FmuRunError, match=r"algebraic loop a\.y1 -> a\.u1 is singular at t = 0 s"):
        one.run(1.0)
    two = CoSimulation(0.1)
    two.add("a", hostile, start={"u1": 2.0})
    two.add("b", hostile_fmu(tmp_path / "b.fmu", hostile_binary), start={"u7": 2.0})
    two.connect("a.y1", "b.u1")
    two.connect("b.y1", "a.u1")
    two.connect("b.y7", "a.u7")
    with pytest.raises(FmuRunError, match=r"a\.y1 -> b\.u1, b\.y1 -> a\.u1 is singular"):
        two.run(1.0)
    chain = CoSimulation(0.1)
    chain.add("a", hostile, start={"u2": 2.0})
    chain.connect("a.y1", "a.u3")
    chain.connect("a.y2", "a.u1")
    assert chain.run(0.2)["a.y3"].tolist() == pytest.approx([2.0] * 3)


def test_a_structure_keeps_isolation_and_rates(kinds2: Path, tmp_path: Path) -> None:
    together = CoSimulation(0.1)
    together.add("a", kinds2, isolated=True, timeout=7.0)
    together.add("b", kinds2, step=0.5)
    again = CoSimulation.from_ssp(together.to_ssp(tmp_path / "both.ssp"))
    kept = {name: (p.fmu.isolated, p.fmu.timeout, p.step) for name, p in again._participants.items()}
    assert kept == {"a": (True, 7.0, None), "b": (False, 60.0, 0.5)}
