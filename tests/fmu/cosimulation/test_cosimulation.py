"""Coupled slaves."""

from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.fmu import CoSimulation, FmuVariableError
from support.fmus import HYDRAULIC, corridor, one_span, open_line, short_line


def cascade(driven: Path, line: Path, step: float, **more: object) -> pd.DataFrame:
    """The speed of a sheave with a hydraulic drive is the command of another line's sheave."""
    together = CoSimulation(step, **more)  # type: ignore[arg-type]
    together.add("first", driven, start={"c1.speed": 1.02})
    together.add("second", line)
    together.connect("first.c1.rope_speed", "second.c1.speed")
    return together.run(4.0)


def lag(frame: pd.DataFrame) -> float:
    return float(np.abs(frame["first.c1.travel"] - frame["second.c1.travel"]).max())


@pytest.mark.parametrize("name", ["line2", "line3"])
def test_explicit_coupling_is_of_first_order(driven: Path, name: str, request: pytest.FixtureRequest) -> None:
    line = request.getfixturevalue(name)
    coarse, fine = (lag(cascade(driven, line, step)) for step in (0.1, 0.05))
    assert 1.7 < coarse / fine < 2.3


@pytest.mark.parametrize("master", ["Jacobi", "Gauss-Seidel"])
def test_iterated_coupling_is_of_second_order(driven: Path, line2: Path, master: str) -> None:
    coarse, fine = (lag(cascade(driven, line2, step, iterated=True, master=master)) for step in (0.1, 0.05))
    assert 3.0 < coarse / fine < 5.0
    assert fine < 0.1 * lag(cascade(driven, line2, 0.05))


def test_result_has_units(driven: Path, line2: Path) -> None:
    frame = cascade(driven, line2, 1.0)
    assert frame.index.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert frame.attrs["units"]["second.c1.tension_in"] == "N"


def test_result_has_counts_and_limits(line2: Path, line3: Path) -> None:
    """Booleans and integers, of both versions: as in one simulation. A rope is above its safe working load, or not."""
    rope = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=140e3)
    s = rw.System("tight")
    s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(100.0, 0.0)), tension=60e3)
    together = CoSimulation(5.0)
    for name, slave in (("two", line2), ("three", line3), ("tight", s)):
        together.add(name, slave)
    frame = together.run(60.0)
    assert frame["two.c1.loads_passed"].dtype == int
    assert frame["two.c1.loads_passed"].iloc[-1] > 0
    pd.testing.assert_series_equal(frame["two.c1.loads_passed"], frame["three.c1.loads_passed"], check_names=False)
    above = frame.filter(regex="SWL")
    assert set(above.dtypes.astype(str)) == {"bool"}
    assert above.filter(like="tight.").all(axis=None)
    assert not above.drop(columns=above.filter(like="tight.")).any(axis=None)


def test_a_system_is_exported_automatically() -> None:
    together = CoSimulation(1.0)
    together.add("span", one_span())
    rest = rw.equilibrium(one_span())
    assert together.run(1.0)["span.a_b.tension_a"].to_list() == pytest.approx([rest["a_b.tension_a"]] * 2, rel=1e-9)


def test_an_equilibrium_is_a_participant() -> None:
    rest = rw.equilibrium(one_span(), given={"a_b.tension_a": 40e3}, solve_for="turn.mass")
    together = CoSimulation(1.0)
    together.add("span", rest)
    assert together.run(1.0)["span.a_b.tension_a"].to_list() == pytest.approx([40e3] * 2, rel=1e-9)


def test_open_inputs_need_a_value() -> None:
    """By a start value, or over time."""
    together = CoSimulation(0.1)
    together.add("line", open_line(), start={"c1.relief_pressure": 300e5})
    with pytest.raises(rw.InputError, match=r"Input 'c1\.pump_flow' of 'line' is open\. Connect it"):
        together.run(0.1)
    frame = together.run(0.1, inputs={"line.c1.pump_flow": 0.02})
    assert frame["line.c1.rope_speed"].iloc[-1] == pytest.approx(1.0)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_switches(tmp_path: Path, kinds2: Path, fmi: Literal["2.0", "3.0"]) -> None:
    path = rw.fmu.export(short_line(drive=HYDRAULIC), tmp_path / "line.fmu", fmi, inputs=["c1.speed", "c1.brake"])
    together = CoSimulation(0.5)
    together.add("line", path, start={"c1.brake": True, "c1.speed": 1.1})
    assert together.run(5.0)["line.c1.rope_speed"].iloc[-1] == pytest.approx(0.0, abs=1e-6)
    switched = CoSimulation(0.5)
    switched.add("carriage", kinds2, start={"level": 1.9, "u": 1.0})
    switched.add("line", path, start={"c1.speed": 1.1})
    switched.connect("carriage.limit", "line.c1.brake")
    frame = switched.run(5.0)
    assert frame["line.c1.rope_speed"].iloc[[3, -1]].to_list() == pytest.approx([1.1, 0.0], abs=1e-2)
    assert frame["line.c1.travel"].iloc[-1] == pytest.approx(2.0 * 1.1, abs=0.2)
    with pytest.raises(FmuVariableError, match=r"'c1\.brake' of line\.fmu is a Boolean.*Give 0 or 1"):
        CoSimulation(0.5).add("line", path, start={"c1.brake": 0.5})


def test_mismatched_connections(driven: Path, line2: Path) -> None:
    together = CoSimulation(0.1)
    together.add("a", driven)
    together.add("b", line2)
    with pytest.raises(FmuVariableError, match=r"is in N, 'c1\.speed' of line2\.fmu in m/s"):
        together.connect("a.c1.tension_in", "b.c1.speed")
    with pytest.raises(FmuVariableError, match="of causality 'output', not an input"):
        together.connect("a.c1.rope_speed", "b.c1.tension_in")
    with pytest.raises(FmuVariableError, match="has no variable 'nothing'"):
        together.connect("a.nothing", "b.c1.speed")
    with pytest.raises(rw.InputError, match="no slave is named 'c'"):
        together.connect("c.x", "b.c1.speed")
    together.connect("a.c1.rope_speed", "b.c1.speed")
    with pytest.raises(rw.InputError, match="is already driven"):
        together.connect("a.c1.command", "b.c1.speed")
    with pytest.raises(rw.InputError, match="participant is a SkylineRig"):
        together.add("rig", corridor())  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="Two slaves are named 'a'"):
        together.add("a", line2)
    with pytest.raises(FmuVariableError, match="has no variable 'speed'"):
        together.add("c", line2, start={"speed": 1.0})
    with pytest.raises(FmuVariableError, match=r"'c1\.tension_in' of line2\.fmu is calculated"):
        together.add("c", line2, start={"c1.tension_in": 1.0})
    with pytest.raises(rw.InputError, match=r"c1\.speed is 'fast'"):
        together.add("c", line2, start={"c1.speed": "fast"})
    with pytest.raises(rw.InputError, match="kind is 'cs'"):
        together.add("c", line2, kind="cs")  # type: ignore[arg-type]


def test_bad_masters() -> None:
    with pytest.raises(rw.InputError, match="step"):
        CoSimulation(0.0)
    with pytest.raises(rw.InputError, match="master is"):
        CoSimulation(1.0, master="Newton")  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="iterations is 0"):
        CoSimulation(1.0, iterations=0)
    with pytest.raises(rw.InputError, match=r"control is .Richardson.*Give a StepControl"):
        CoSimulation(1.0, control="Richardson")  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="no slave"):
        CoSimulation(1.0).run(1.0)


def test_the_last_step_ends_at_the_end_time(line2: Path) -> None:
    together = CoSimulation(0.1)
    together.add("a", line2)
    assert list(together.run(0.14).index) == [0.0, 0.1, 0.14]
