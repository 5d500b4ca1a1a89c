"""Algebraic loops of Booleans, enumerations and integers; values that are mapped one by one."""

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import ropeway as rw
from ropeway.fmu import CoSimulation, FmuRunError, FmuVariableError
from support.fmus import rewritten

NOT = {True: False, False: True}


def looped(path: Path, variable: str, start: object, there: Any = None, back: Any = None) -> CoSimulation:
    """Two slaves whose outputs are their inputs at once, each driven by the other."""
    together = CoSimulation(0.1)
    together.add("a", path, start={variable: start})
    together.add("b", path)
    together.connect(f"a.{variable}_out", f"b.{variable}", mapping=there)
    together.connect(f"b.{variable}_out", f"a.{variable}", mapping=back)
    return together


@pytest.mark.parametrize(
    ("variable", "start", "there", "cause"),
    [
        ("brake", True, None, "is singular at t = 0 s: many values satisfy it"),
        (
            "brake",
            True,
            NOT,
            r"No values satisfy the algebraic loop a\.brake_out -> b\.brake, b\.brake_out -> a\.brake",
        ),
        ("gear", "low", None, "many values satisfy it"),
        ("count", 3, None, "many values satisfy it"),
        ("count", 3, {0: 3, 3: 4, 4: 3}, r"count: values keep changing at t = 0 s"),
    ],
)
def test_loops_without_one_solution(kinds2: Path, variable: str, start: object, there: Any, cause: str) -> None:
    with pytest.raises(FmuRunError, match=cause) as error:
        looped(kinds2, variable, start, there).run(0.3)
    assert error.value.remedy.startswith(("Open the loop", "The connections form a loop"))


def test_one_slave_that_drives_itself(kinds3: Path) -> None:
    together = CoSimulation(0.1)
    together.add("a", kinds3, start={"brake": True})
    together.connect("a.brake_out", "a.brake", mapping=NOT)
    with pytest.raises(FmuRunError, match="No values satisfy"):
        together.run(0.3)


def test_a_loop_with_one_solution(kinds2: Path, tmp_path: Path) -> None:
    """Iteration goes from the first to the second gear and back for ever; only the third confirms itself."""
    item = '<Item name="high" value="2"/>'
    path = rewritten(
        kinds2, tmp_path / "three.fmu", lambda text: text.replace(item, f'{item}<Item name="top" value="3"/>')
    )
    turn = {"low": "high", "high": "low", "top": "top"}
    frame = looped(path, "gear", "low", turn).run(0.3)
    assert frame[["a.gear_out", "b.gear_out"]].to_numpy().tolist() == [[3, 3]] * 4


def test_a_scenario_opens_a_loop(kinds2: Path) -> None:
    scenario = pd.DataFrame({"time": [0.0, 0.2], "variable": "b.brake", "value": [True, False]})
    frame = looped(kinds2, "brake", False).run(0.3, scenario=scenario)
    assert frame["a.brake_out"].tolist() == [True, True, False, False]


def test_values_are_mapped(kinds2: Path, kinds3: Path) -> None:
    together = CoSimulation(0.1)
    together.add("a", kinds2, start={"brake": True, "gear": "high", "count": 2})
    together.add("b", kinds3)
    together.connect("a.brake_out", "b.brake", mapping=NOT)
    together.connect("a.gear_out", "b.int16", mapping={"low": 10, "high": 20})
    together.connect("a.count_out", "b.gear", mapping={2: "high"})
    together.connect("a.brake_out", "b.uint8", mapping={True: 7, False: 8})
    table = pd.DataFrame({"time": [0.0, 0.1, 0.2], "a.gear": [2, 1, 2], "a.brake": [True, True, False]})
    frame = together.run(0.3, inputs=table)
    assert frame["b.brake_out"].tolist() == [False, False, True, True]
    assert frame["b.int16_out"].tolist() == [20, 10, 20, 20]
    assert frame["b.gear_out"].tolist() == [2] * 4
    assert frame["b.uint8_out"].tolist() == [7, 7, 8, 8]
    table["a.count"] = [2, 2, 3]
    with pytest.raises(
        FmuRunError, match=r"a\.count_out is 3 at t = 0\.2 s, which its mapping to b\.gear lacks"
    ) as error:
        together.run(0.3, inputs=table)
    assert error.value.result is not None
    assert len(error.value.result) == 2


@pytest.mark.parametrize(
    ("source", "target", "how", "error", "cause"),
    [
        ("x", "u", {"mapping": {1: 2}}, FmuVariableError, r"'a\.x' is of type Real: its values cannot be mapped"),
        ("text_out", "text", {"mapping": {"a": "b"}}, FmuVariableError, "of type String"),
        ("brake_out", "brake", {"mapping": {}}, rw.InputError, "is empty"),
        ("brake_out", "brake", {"mapping": {True: 2}}, FmuVariableError, "is a Boolean: it cannot be 2"),
        ("gear_out", "gear", {"mapping": {"first": "low"}}, FmuVariableError, "it cannot be 'first'"),
        ("gear_out", "gear", {"mapping": {"low": "low", 1: "high"}}, rw.InputError, "two values for 1"),
        ("brake_out", "brake", {"mapping": NOT, "factor": 2.0}, rw.InputError, "a factor and a mapping"),
    ],
)
def test_wrong_mappings(kinds2: Path, source: str, target: str, how: Any, error: Any, cause: str) -> None:
    together = CoSimulation(0.1)
    for name in "ab":
        together.add(name, kinds2)
    with pytest.raises(error, match=cause):
        together.connect(f"a.{source}", f"b.{target}", **how)
