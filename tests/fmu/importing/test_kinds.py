"""Variables of all kinds: start values, outputs, connections, and inputs over time."""

from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.fmu import CoSimulation, FmuImportError, FmuVariableError, Slave, StepControl, component, load
from support.kinds import described

Kind = Literal["CoSimulation", "ModelExchange"]


def alone(path: Path, kind: Kind, /, step: float = 0.1, **start: Any) -> CoSimulation:
    together = CoSimulation(step)
    together.add("k", path, kind=kind, start=start)
    return together


def test_values_of_all_kinds_pass(kinds: Path, kind: Kind) -> None:
    given: dict[str, Any] = {"count": -(2**31), "brake": True, "text": "Füße", "gear": "high"}
    frame = alone(kinds, kind, **given).run(0.2)
    last = frame.iloc[-1]
    assert [last[f"k.{name}_out"] for name in given] == [-(2**31), True, "Füße", 2]
    kept = {name: frame[f"k.{name}_out"].dtype for name in given}
    assert kept == {"count": np.int64, "brake": np.bool_, "text": np.object_, "gear": np.int64}


WIDE = {"int8": -128, "uint8": 255, "int16": -(2**15), "uint16": 2**16 - 1, "uint32": 2**32 - 1}
WIDE |= {"int64": -(2**63), "uint64": 2**64 - 1}


def test_types_of_version_3(kinds3: Path, kind: Kind) -> None:
    given: dict[str, Any] = {**WIDE, "float32": 7.0, "binary": b"\x00\xff\x01"}
    frame = alone(kinds3, kind, **given).run(0.2)
    assert {name: frame[f"k.{name}_out"].iloc[-1] for name in given} == given
    assert frame["k.uint64_out"].dtype == np.uint64
    reasons = frame.attrs["left_out"]
    assert set(reasons) == {"k.tick", "k.ticked"}
    assert "clock" in reasons["k.ticked"]


def test_arrays_have_a_column_for_each_element(kinds3: Path, kind: Kind) -> None:
    frame = alone(kinds3, kind, v=[1.5, 2.0, -3.0], m=[[1.0, 2.0], [3.0, 4.0]], flags=(True, False)).run(0.1)
    last = frame.iloc[-1]
    assert [last[f"k.w[{i}]"] for i in (1, 2, 3)] == [3.0, 4.0, -6.0]
    assert last["k.trace"] == 5.0
    assert (last["k.flags_out[1]"], last["k.flags_out[2]"]) == (True, False)
    one = alone(kinds3, kind, **{"v[2]": 8.0, "m[2,2]": 6.0}).run(0.1).iloc[-1]  # the others keep their starts
    assert [one[f"k.w[{i}]"] for i in (1, 2, 3)] == [0.0, 16.0, 0.0]
    assert one["k.trace"] == 6.0


def test_sizes_follow_structural_parameters(kinds3: Path, kind: Kind) -> None:
    frame = alone(kinds3, kind, n=5, v=np.arange(5.0)).run(0.1)
    assert [c for c in frame if c.startswith("k.w")] == [f"k.w[{i}]" for i in range(1, 6)]
    assert frame["k.w[5]"].iloc[-1] == 8.0


@pytest.mark.parametrize(
    ("name", "value", "cause"),
    [
        ("int8", 128, r"an Int8: it cannot be 128\. Give a whole number from -128 to 127"),
        ("uint16", -1, "a UInt16: it cannot be -1"),
        ("count", 1.5, "an Int32: it cannot be 1.5"),
        ("count", True, "an Int32: it cannot be True"),
        ("brake", 2, "a Boolean: it cannot be 2. Give 0 or 1"),
        ("gear", "middle", r"Give one of 1 \(low\), 2 \(high\)"),
        ("text", 5, "a String: it cannot be 5. Give a text"),
        ("binary", "00", "Give bytes"),
        ("v", [1.0, 2.0], "is an array of 3; 2 values were given"),
        ("tick", 1, "Clocks tick by themselves"),
    ],
)
def test_values_that_do_not_fit(kinds3: Path, name: str, value: Any, cause: str) -> None:
    with pytest.raises(FmuVariableError, match=cause) as caught:
        alone(kinds3, "CoSimulation", **{name: value})
    assert caught.value.variable == name


def test_a_limit_switch_stops_a_drive(kinds2: Path, kinds3: Path, kind: Kind) -> None:
    """The switch of one FMU is the brake of the other; each text, number and gear is handed on."""
    together = CoSimulation(0.1)
    together.add("one", kinds2, kind=kind, start={"level": 0.55, "u": 1.0, "text": "x", "gear": 2, "count": 3})
    together.add("two", kinds3, kind=kind, start={"u": 2.0})
    together.connect("one.limit", "two.brake")
    for name in ("text", "gear", "count"):
        together.connect(f"one.{name}_out", f"two.{name}")
    together.connect("one.count_out", "two.int64")
    together.connect("one.count_out", "two.d")
    together.connect("one.limit", "two.uint8")
    frame = together.run(1.0)
    assert frame["two.x"].to_numpy() == pytest.approx(np.minimum(2.0 * frame.index, 1.2))
    last = frame.iloc[-1]
    assert [last[f"two.{n}_out"] for n in ("text", "gear", "count", "int64", "d", "uint8")] == ["x", 2, 3, 3, 3.0, 1]
    assert frame["two.brake_out"].equals(frame["one.limit"].rename("two.brake_out"))


@pytest.mark.parametrize("method", ["Richardson", "coupling error"])
def test_a_step_control_meets_a_switch(kinds2: Path, kinds3: Path, kind: Kind, method: Any) -> None:
    """x rises by 1 m/s up to the level; the other one, of 2 m/s, is braked then."""
    together = CoSimulation(0.1, iterated=True, control=StepControl(method, least=1e-5))
    together.add("one", kinds2, kind=kind, start={"level": 0.55, "u": 1.0})
    together.add("two", kinds3, kind=kind, start={"u": 2.0})
    together.connect("one.limit", "two.brake")
    frame = together.run(3.0)
    assert frame["two.x"].iloc[-1] == pytest.approx(1.1, abs=2e-4)
    assert len(frame) < 80


def test_connections_that_do_not_fit(kinds2: Path, kinds3: Path) -> None:
    together = CoSimulation(0.1)
    for name, path in (("a", kinds2), ("b", kinds3)):
        together.add(name, path)
    for source, target in (
        ("a.x", "b.brake"),
        ("a.x", "b.count"),
        ("a.text_out", "b.count"),
        ("a.count_out", "b.gear"),
    ):
        with pytest.raises(FmuVariableError, match="they cannot be connected"):
            together.connect(source, target)
    with pytest.raises(
        FmuVariableError, match=r"'v' of kinds3\.fmu is an array of 3\. Name one of its elements, v\[1\]"
    ):
        together.connect("a.x", "b.v")
    with pytest.raises(
        FmuVariableError, match=r"'tick' of kinds3\.fmu is a Clock .* not an output that can be connected"
    ):
        together.connect("b.tick", "a.brake")


def test_a_switch_that_keeps_changing(kinds: Path) -> None:
    """Its own limit is its level: never settled."""
    together = CoSimulation(0.1)
    together.add("k", kinds, start={"level": 0.5})
    together.connect("k.limit", "k.d")
    assert together.run(0.3)["k.d_out"].tolist() == [0.0] * 4


RAMP = rw.Schedule((0.0, 0.33, 1.0, 2.0), (0.0, 1.0, 1.0, -0.5))


def exact(times: np.ndarray, ramp: rw.Schedule = RAMP, gain: float = 0.0) -> np.ndarray:
    """The integral of a ramp and of gain times a d that goes from 0 to 2 at 0.45 s, until the brake holds at 1.25 s."""
    fine = np.unique(np.concatenate([np.linspace(0.0, 2.0, 200001), ramp.times, [0.45, 1.25]]))
    d = np.where(fine[:-1] >= 0.45, 2.0, 0.0)
    middle = 0.5 * (fine[1:] + fine[:-1])
    rate = np.where(fine[:-1] >= 1.25, 0.0, np.interp(middle, ramp.times, ramp.speeds) + gain * d)
    whole = np.concatenate([[0.0], np.cumsum(rate * np.diff(fine))])
    return np.interp(times, fine, whole)


def test_inputs_over_time(kinds: Path, kind: Kind) -> None:
    frame = alone(kinds, kind).run(
        2.0,
        inputs={
            "k.u": RAMP,
            "k.d": pd.Series([0.0, 2.0], [0.0, 0.45]),
            "k.gain": pd.Series([0.5, 0.5], [0.0, 0.7]),
            "k.brake": pd.Series([False, True], [0.0, 1.25]),
            "k.text": "held",
        },
    )
    assert len(frame) == 21
    assert frame["k.x"].to_numpy() == pytest.approx(exact(frame.index.to_numpy(), gain=0.5), abs=1e-7)
    assert frame["k.brake_out"].tolist() == (frame.index > 1.25).tolist()
    assert set(frame["k.text_out"]) == {"held"}


def test_tunable_parameters_change_at_events(kinds: Path, kind: Kind) -> None:
    given = {"k.gain": pd.Series([1.0, 3.0], [0.0, 0.5]), "k.d": 2.0}
    assert alone(kinds, kind).run(1.0, inputs=given)["k.x"].iloc[-1] == pytest.approx(2.0 * 0.5 + 6.0 * 0.5)
    with Slave(load(kinds), kind=kind) as slave:
        slave.enter(0.0, {})
        slave.leave()
        slave.set({"gain": 2.0, "d": 1.0})
        slave.step(0.5, {"u": 1.0}, {"u": 1.0})
        assert slave.get(["x"])[0] == pytest.approx(1.5)
        with pytest.raises(FmuVariableError, match=r"'level' of .* is fixed: it cannot change during a run"):
            slave.set({"level": 3.0})


def test_a_table_of_inputs(kinds: Path, tmp_path: Path) -> None:
    rows = pd.DataFrame({"time": [0.0, 0.45, 0.45, 2.0], "k.u": [0.0, 0.9, 0.3, 0.3], "k.brake": [0, 0, 0, 1]})
    rows.to_csv(tmp_path / "inputs.csv", index=False)
    for inputs in (rows, rows.set_index("time"), tmp_path / "inputs.csv"):
        frame = alone(kinds, "CoSimulation").run(2.0, inputs=inputs)
        assert frame["k.x"].iloc[-1] == pytest.approx(0.5 * 0.45 * 0.9 + 0.3 * 1.55)  # a jump at 0.45 s


def test_a_table_of_inputs_in_other_notations(kinds2: Path, tmp_path: Path) -> None:
    """Decimal commas, capitals, texts; a column of another name is an error with its line."""
    text = "Time [min];k.u;k.brake;k.text;k.count\n0;1,5;false;left;-3\n0,01;1,5;true;right;7\n0,02;1,5;true;right;7\n"
    (tmp_path / "inputs.csv").write_text(text)
    frame = alone(kinds2, "CoSimulation").run(1.2, inputs=tmp_path / "inputs.csv")
    last = frame.iloc[-1]
    assert last["k.x"] == pytest.approx(0.9)
    assert [last[f"k.{n}_out"] for n in ("brake", "text", "count")] == [True, "right", 7]
    (tmp_path / "inputs.csv").write_text("t,k.u\n0,1\n")
    with pytest.raises(rw.InputError, match=r"inputs\.csv, line 1.*no column time"):
        alone(kinds2, "CoSimulation").run(1.0, inputs=str(tmp_path / "inputs.csv"))


def test_a_table_with_elements_of_an_array(kinds3: Path, tmp_path: Path) -> None:
    (tmp_path / "inputs.csv").write_text("time,k.v[1],k.v[3]\n0,1,2\n1,3,2\n")
    last = alone(kinds3, "CoSimulation", v=[0.0, 5.0, 0.0]).run(1.0, inputs=tmp_path / "inputs.csv").iloc[-1]
    assert [last[f"k.w[{i}]"] for i in (1, 2, 3)] == [6.0, 10.0, 4.0]


def test_steps_of_one_length_only(tmp_path: Path, kinds2: Path) -> None:
    """What changes between two communication points is given at the later one."""
    path = described(tmp_path / "stiff.fmu", "2.0", kinds2.with_suffix(".so"), varies_steps=False)
    frame = alone(path, "CoSimulation", gain=1.0).run(1.0, inputs={"k.d": pd.Series([0.0, 1.0], [0.0, 0.45])})
    assert frame["k.x"].iloc[-1] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("inputs", "cause"),
    [
        ({"k.d": RAMP}, "cannot follow a piecewise linear schedule"),
        ({"k.u": rw.Schedule((0.0, 0.5), (0.0, 1.0))}, r"ends at 0\.5 s, before 1 s"),
        ({"k.u": pd.Series([0.0, 1.0], [0.0, 0.5])}, r"values of 'k\.u' end at 0\.5 s"),
        ({"k.u": pd.Series([0.0, 1.0], [1.0, 0.5])}, "do not increase"),
        ({"k.u": pd.Series([0.0, 1.0], ["a", "b"])}, "has no times"),
        ({"k.level": 1.0}, "it cannot change during a run"),
        ({"k.brake": 0.5}, "a Boolean: it cannot be 0.5"),
        ({"k.d": 1.0, "l.u": 1.0}, "no slave is named 'l'"),
        ({"k.uu": 1.0}, "has no variable 'uu'"),
        ({"k.count": 1}, "is already driven"),
        ("no_such_file.csv", "There is no file"),
        (3.0, "inputs is 3.0"),
    ],
)
def test_bad_inputs(kinds2: Path, inputs: Any, cause: str) -> None:
    together = alone(kinds2, "CoSimulation")
    together.connect("k.count_out", "k.count")
    with pytest.raises((rw.InputError, FmuVariableError), match=cause):
        together.run(1.0, inputs=inputs)


def test_a_run_has_its_start_and_stop_time(kinds: Path, kind: Kind) -> None:
    frame = alone(kinds, kind, 0.3, u=1.0).run(11.0, start_time=10.0)
    assert frame.index.tolist() == pytest.approx([10.0, 10.3, 10.6, 10.9, 11.0])
    assert set(frame["k.start_told"]) == {10.0}
    assert set(frame["k.stop_told"]) == {11.0}
    assert frame["k.x"].iloc[-1] == pytest.approx(1.0)
    later = alone(kinds, kind, 0.25).run(11.0, start_time=10.0, inputs={"k.u": rw.Schedule((10.5, 11.0), (0.0, 1.0))})
    assert later["k.x"].iloc[-1] == pytest.approx(0.25)
    with pytest.raises(rw.InputError, match="must be above the start time, 10 s"):
        alone(kinds, kind).run(10.0, start_time=10.0)


def test_many_steps_do_not_pass_the_stop_time(kinds: Path) -> None:
    assert len(alone(kinds, "CoSimulation", 0.001).run(0.7)) == 701


def test_components_take_descriptions_without_dependencies(kinds: Path) -> None:
    """Tunable parameters and discrete inputs keep their starts, as they may change at events only."""
    s = rw.System("alone")
    s.add(component("k", kinds, parameters={"gain": 2.0}, ignore_events=True))
    frame = rw.simulate(s, 1.0, inputs={"k.u": rw.Schedule((0.0, 1.0), (0.0, 3.0))}).frame
    assert frame["k.x"].iloc[-1] == pytest.approx(1.5, rel=1e-6)
    assert "k.text_out" not in frame


def test_a_component_of_all_kinds_with_its_events(kinds: Path) -> None:
    """As without events, and the FMU ends the run."""
    s = rw.System("alone")
    s.add(component("k", kinds, parameters={"gain": 2.0, "stop_at": 0.75}))
    result = rw.simulate(s, 1.0, every=0.5, inputs={"k.u": rw.Schedule((0.0, 1.0), (0.0, 3.0))})
    assert result.frame.index[-1] == pytest.approx(0.75, abs=1e-6)
    assert result.frame["k.x"].iloc[-1] == pytest.approx(1.5 * 0.75**2, rel=1e-5)


def test_an_fmu_for_schedulers_only(tmp_path: Path, kinds3: Path) -> None:
    path = described(tmp_path / "clocks.fmu", "3.0", kinds3.with_suffix(".so"), kinds=["ScheduledExecution"])
    assert load(path).kinds == ("ScheduledExecution",)
    with pytest.raises(FmuImportError, match="supports ScheduledExecution only, which requires a scheduler"):
        CoSimulation(0.1).add("clocks", path)
