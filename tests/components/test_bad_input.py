"""What a wrong value gets: a typed error that names the component, the value and the remedy."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

import ropeway as rw

ROPE = {"mass_per_length": 3.48, "axial_stiffness": 34.8e6, "breaking_load": 576.6e3}


def rope(**changes: object) -> rw.Rope:
    return rw.Rope(**{**ROPE, **changes})  # type: ignore[arg-type]


def told(error: rw.RopewayError, *words: str) -> None:
    """The message has a cause and a remedy, and names what it is about."""
    assert error.cause
    assert error.remedy
    assert error.cause in str(error)
    assert error.remedy in str(error)
    for word in words:
        assert word in str(error)


NUMBERS = {
    "mass_per_length": ("Rope 'main'", lambda v: rope(mass_per_length=v, name="main")),
    "axial_stiffness": ("Rope 'main'", lambda v: rope(axial_stiffness=v, name="main")),
    "breaking_load": ("Rope 'main'", lambda v: rope(breaking_load=v, name="main")),
    "diameter": ("Rope 'main'", lambda v: rope(diameter=v, name="main")),
    "safety_factor": ("Rope 'main'", lambda v: rope(safety_factor=v, name="main")),
    "length": ("Span 'a_b'", lambda v: rw.Span("a_b", rope=rope(), length=v)),
    "mass": ("Load 'turn'", lambda v: rw.Load("turn", mass=v)),
    "tension": ("Drum 'yarder'", lambda v: rw.Drum("yarder", at=(0, 0), tension=v)),
    "gravity": ("System 'line'", lambda v: rw.System("line", gravity=v)),
}


@pytest.mark.parametrize("value", [0.0, -2.5, math.nan, -math.inf])
@pytest.mark.parametrize("field", NUMBERS)
def test_values_that_must_be_positive(field: str, value: float) -> None:
    owner, make = NUMBERS[field]
    with pytest.raises(rw.InputError) as info:
        make(value)
    told(info.value, owner, field, repr(value))


@pytest.mark.parametrize("field", [f for f in NUMBERS if f != "axial_stiffness"])
def test_infinite_values(field: str) -> None:
    owner, make = NUMBERS[field]
    with pytest.raises(rw.InputError) as info:
        make(math.inf)
    told(info.value, owner, field, "inf")


def test_a_rope_may_be_inextensible() -> None:
    assert rope(axial_stiffness=math.inf).strain.none


@pytest.mark.parametrize("value", ["3.48", None, (3.0,)])
def test_values_that_are_no_numbers(value: object) -> None:
    with pytest.raises(rw.InputError) as info:
        rope(mass_per_length=value)
    told(info.value, "mass_per_length", repr(value))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: rw.ConstructionStretch(-0.1), ("ConstructionStretch", "coefficient", "-0.1")),
        (lambda: rw.Sheave("s1", at=(0, 0), friction=-0.01), ("Sheave 's1'", "friction", "-0.01")),
        (lambda: rw.ControlSheave("c1", at=(0, 0), speed=math.nan), ("ControlSheave 'c1'", "speed", "nan")),
        (lambda: rw.Drum("d", at=(0, 0), speed=1.0, tension=1e4), ("Drum 'd'", "speed", "tension")),
        (lambda: rw.Anchor("a", at=(0.0, math.nan)), ("Anchor 'a'", "nan")),
        (lambda: rw.Anchor("a", at=(0.0, 1.0, 2.0, 3.0)), ("Anchor 'a'", "4 coordinates")),
        (lambda: rw.Sheave("s1", at=(0.0,)), ("Sheave 's1'", "1 coordinates")),
        (lambda: rw.Schedule([], []), ("Schedule", "0 times")),
        (lambda: rw.Schedule([0.0, 1.0], [1.0]), ("Schedule", "2 times", "1 speeds")),
        (lambda: rw.Schedule([0.0, 5.0, 5.0], [1.0, 1.0, 2.0]), ("Schedule", "5.0")),
        (lambda: rw.Schedule([0.0, 1.0], [1.0, math.nan]), ("Schedule", "NaN")),
        (lambda: rw.Rope.from_construction("6x19 IWRC", 19.0), ("6x19 IWRC", "19.0 m", "mm")),
        (lambda: rw.Rope.from_construction("6x19 IWRC", -0.019), ("6x19 IWRC", "diameter", "-0.019")),
        (lambda: rw.Rope.from_construction("6x19 IWRC", 0.019, 0.0), ("6x19 IWRC", "grade", "0.0")),
    ],
)
def test_other_values(make: Callable[[], object], words: tuple[str, ...]) -> None:
    with pytest.raises(rw.InputError) as info:
        make()
    told(info.value, *words)


@pytest.mark.parametrize("name", ["", "1a", "a b", "a.b", "a-b", "Süd/1"])
@pytest.mark.parametrize(
    "make",
    [
        lambda name: rw.Anchor(name, at=(0, 0)),
        lambda name: rw.Sheave(name, at=(0, 0)),
        lambda name: rw.ControlSheave(name, at=(0, 0)),
        lambda name: rw.Drum(name, at=(0, 0)),
        lambda name: rw.Span(name, rope=rope(), length=10.0),
        lambda name: rw.Load(name, mass=1.0),
    ],
)
def test_names_are_identifiers(make: Callable[[str], object], name: str) -> None:
    with pytest.raises(rw.InputError) as info:
        make(name)
    told(info.value, repr(name))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: rw.Rope.from_construction("7x7", 0.02), ("'7x7'", "6x19 IWRC")),
        (lambda: rw.Rope.named("no such"), ("'no such'", "compacted skyline 20", "rw.ropes()")),
    ],
)
def test_unknown_names_list_the_known(make: Callable[[], object], words: tuple[str, ...]) -> None:
    with pytest.raises(rw.UnknownNameError) as info:
        make()
    told(info.value, *words)


def test_errors_are_the_builtin_kinds_too() -> None:
    assert issubclass(rw.InputError, ValueError)
    assert issubclass(rw.UnknownNameError, KeyError)
    assert issubclass(rw.UnbalancedSystemError, rw.InputError)
    for kind in (rw.InputError, rw.EquilibriumError, rw.SlackRopeError, rw.SimulationError):
        assert issubclass(kind, rw.RopewayError)
