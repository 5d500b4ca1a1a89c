"""The door of the library: arguments are checked by their annotations."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol

import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.components.annotation_checks import Numbers, Unbounded
from ropeway.components.argument_checks import checked
from ropeway.components.check import Range


class Floats(Protocol):
    """What can float."""

    def draught(self) -> float:
        """Depth under water [m]."""
        ...


class Raft:
    def draught(self) -> float:
        return 0.4


@checked
def boat(
    beam: float,
    rig: Literal["sloop", "ketch"] = "sloop",
    *logs: rw.Load,
    frames: Sequence[float] | np.ndarray | None = None,
    place: tuple[float, float] = (0.0, 0.0),
    crew: Mapping[str, int] | None = None,
    hull: Floats | None = None,
    draught: Annotated[float, Range(0.1, 3.0)] = 1.0,
    stiffness: Unbounded = math.inf,
    depths: Numbers = 1.0,
    path: str | Path = "boat",
    turn: Callable[[float], float] | None = None,
    afloat: bool = True,
    decks: int = 1,
) -> dict[str, Any]:
    """A boat."""
    return dict(locals())


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"beam": True}, "boat: beam is True. Give a number"),
        ({"beam": math.nan}, "boat: beam is nan. Give a finite number, not NaN or inf"),
        ({"beam": 10**400}, "Give a finite number, not NaN or inf"),
        ({"beam": b"3"}, "boat: beam is b'3'. Give a number"),
        ({"beam": 3 + 0j}, "boat: beam is (3+0j). Give a number"),
        ({"beam": 3.0, "rig": "skech"}, "Give one of 'sloop', 'ketch'; did you mean 'ketch'?"),
        ({"beam": 3.0, "frames": "12"}, "boat: frames is '12'. Give a sequence of numbers or None"),
        ({"beam": 3.0, "frames": [1.0, "x"]}, "boat: frames[1] is 'x'. Give a number"),
        ({"beam": 3.0, "frames": np.ones((2, 2))}, "boat: frames[0] is array([1., 1.]). Give a number"),
        ({"beam": 3.0, "frames": np.array([1.0, math.nan])}, "boat: frames[1] is nan."),
        ({"beam": 3.0, "place": (1.0, 2.0, 3.0)}, "boat: place is (1.0, 2.0, 3.0). Give 2 values"),
        ({"beam": 3.0, "crew": {"mate": 1.5}}, "boat: crew['mate'] is 1.5. Give a whole number"),
        ({"beam": 3.0, "crew": {7: 1}}, "Give text as each key"),
        ({"beam": 3.0, "hull": Raft}, "boat: hull is the class Raft. Give a Floats, which has draught or None"),
        ({"beam": 3.0, "draught": 0.05}, "boat: draught is 0.05. Give a number of 0.1 or more, at most 3"),
        ({"beam": 3.0, "depths": [[1.0], [2.0, 3.0]]}, "Give rows of one length"),
        ({"beam": 3.0, "depths": [1.0, True]}, "boat: depths[1] is True. Give a number"),
        ({"beam": 3.0, "path": "a\0b"}, "Give a path without NUL"),
        ({"beam": 3.0, "turn": 3}, "boat: turn is 3. Give a function or None"),
        ({"beam": 3.0, "afloat": 1}, "boat: afloat is 1. Give True or False"),
        ({"beam": 3.0, "decks": 2.0}, "boat: decks is 2.0. Give a whole number"),
        ({"beam": 3.0, "fames": []}, "boat has no argument 'fames'. Did you mean frames?"),
        ({}, "boat has no beam. Give beam"),
    ],
)
def test_rejected_input(given: dict[str, Any], message: str) -> None:
    with pytest.raises(rw.InputError) as caught:
        boat(**given)
    assert message in str(caught.value)


def test_positional_arguments_are_counted_and_named() -> None:
    with pytest.raises(rw.InputError, match=r"boat: logs is 7\. Give a Load"):
        boat(3.0, "sloop", rw.Load("a", 3.0), 7)  # type: ignore[arg-type]
    with pytest.raises(rw.InputError, match="boat has two values for beam"):
        boat(3.0, beam=2.0)  # type: ignore[misc]
    with pytest.raises(rw.InputError, match=r"Anchor has 3 positional arguments\. It takes at most 2"):
        rw.Anchor("a", (0.0, 0.0), 1.0)  # type: ignore[call-arg]


def test_numbers_of_numpy_and_pandas_become_those_of_python() -> None:
    found = boat(
        np.float32(0.1), frames=pd.Series([1, 2], index=[5, 6]), place=np.array([1, 2]), decks=np.int64(2),
        afloat=np.True_, depths=[[1, 2], [3, 4]], crew={"mate": np.int8(3)}, hull=Raft(), stiffness=-math.inf,
    )  # type: ignore[arg-type]  # fmt: skip
    assert type(found["beam"]) is float
    np.testing.assert_array_equal(found["frames"], [1.0, 2.0])
    assert found["place"] == (1, 2)
    assert (found["decks"], found["afloat"], found["crew"]) == (2, True, {"mate": 3})
    assert found["depths"].dtype == float
    assert found["stiffness"] == -math.inf


def test_signature_and_help_are_those_of_the_function() -> None:
    assert boat.__doc__ == "A boat."
    assert list(inspect.signature(boat).parameters)[:3] == ["beam", "rig", "logs"]
    assert list(inspect.signature(rw.Load).parameters) == ["name", "mass", "drag_area"]


def test_overflow_is_a_typed_error() -> None:
    @checked
    def power(base: float) -> float:
        return float(base) ** 400

    assert power(1.5) > 1.0
    with pytest.raises(rw.InputError, match=r"power: the values lead to numbers outside .*OverflowError"):
        power(1e9)


@pytest.mark.parametrize(
    "call",
    [
        lambda line: rw.exact_load(line, 30.0, 2e5, "rollin"),  # type: ignore[arg-type]
        lambda line: rw.exact_load(line, -31.0, 2e5, "clamped"),
        lambda line: rw.exact_load(line, [30.0, 30.0, 30.0], [2e5, 2e5], "clamped"),  # type: ignore[arg-type]
        lambda line: rw.stretched_position(
            rw.Rope.named("6x19 EEIP 19"), stations=9.0, horizontal=1e4, vertical=0.0, method="elastik"  # type: ignore[arg-type]
        ),
        lambda line: rw.unstretched_length(
            rw.Rope.named("6x19 EEIP 19"), length=90.0, horizontal=1e4, vertical=0.0, gravity=-1.62
        ),
    ],
)  # fmt: skip
def test_handbook_functions_refuse_what_has_no_result(call: Callable[[rw.LoadedSpan], object]) -> None:
    with pytest.raises(rw.InputError):
        call(rw.LoadedSpan(170.0, 18.0, 0.05, 0.45))


def test_too_little_tension_is_an_error_not_nan() -> None:
    with pytest.raises(rw.SlackRopeError, match="A tension of 900 is too low"):
        rw.exact_load(rw.LoadedSpan(170.0, 18.0), 30.0, np.array([2e5, 900.0]), "clamped")


def test_masses_that_are_bytes_are_refused() -> None:
    table = pd.DataFrame({"name": ["a", "b"], "x": [0.0, 80.0], "y": 0.0, "z": 0.0, "kind": ["drum", "drum"]})
    rope = rw.Rope.named("6x19 EEIP 25")
    with pytest.raises(rw.InputError, match=r"monocable: load_mass is b'z'\. Give a number"):
        rw.monocable(rope, table, tension=2e4, load_mass=b"z", load_spacing=20.0)
