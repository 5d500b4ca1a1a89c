"""Wrong arguments for every public callable: a typed error, or a result without NaN; never a foreign traceback.

A valid call of each public function, class and method is spoilt in one place: an argument, an element of it, or its
name. What no call may take is known from the argument's valid value: a bool where there is a number, NaN, bytes, a
class, a complex number and so on.
"""

from __future__ import annotations

import datetime
import inspect
import math
import resource
import signal
import traceback
import types
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import is_dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, NamedTuple, Union, get_args, get_origin

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

import ropeway as rw
from ropeway.components.argument_checks import hints_of
from support import calls
from support.call_objects import CARRIAGE, HEAD, ROPE, TAIL

if TYPE_CHECKING:
    from conftest import Campaign

LIMIT = 20.0
"""Seconds that a call may take: the valid ones take less than ten."""
MEMORY = 8 * 2**30

NEVER: tuple[Any, ...] = (
    object(), b"x", bytearray(b"12"), 1 + 2j, datetime.datetime(2025, 3, 1), datetime.timedelta(seconds=3), rw.Rope,
    int, {1.0}, {"a"}, lambda: 3.0, rw.Elastic, pd.Timestamp("2025-03-01"), NotImplemented, ..., Decimal("NaN"), range,
    np.array([1 + 1j]), np.datetime64("2025-03-01"), memoryview(b"12"), iter([1.0]),
)  # fmt: skip
"""Values that no argument takes, but for an iterator where any iterable is allowed."""
NO_NUMBER: tuple[Any, ...] = (
    True, False, np.True_, math.nan, np.nan, -math.nan, "", "x", "1.5", [], ["a"], [True], [math.nan], {"a": "x"},
    np.array([True]), np.array([np.nan]), np.array(None), pd.NA, pd.NaT, pd.DataFrame(), [[1.0], [2.0, 3.0]],
    pd.Series(["a"]), [None], rw.Load("other", 3.0), Path("x"), np.array([1.0, "x"], dtype=object),
)  # fmt: skip
"""Values that no argument takes whose valid value is a number."""
ODD: tuple[Any, ...] = (
    None, -1, 0, 1, -0.0, 2, 3.5, 1e308, -1e308, 1e-300, 1e-12, 1e9, 1e30, math.inf, -math.inf, 10**400, 10**12, 2**63,
    np.array(["a", "b"]),
    "", "x", "a", "ä ö", "\0", "x" * 5000, [], [1], [1.0, 2.0], [[1.0]], ["a"], [1e308, 1e308], [0.0] * 3, [2.0, 1.0],
    (), (1.0,), (0.0, 0.0, 0.0), (1.0, 2.0, 3.0, 4.0), {}, {"a": 1.0}, {"c": 1.0}, {"x": "y"}, {1: 2}, set(),
    np.float32(1.5), np.float64(3.0), np.int64(2), np.array(2.0), np.array([]), np.array([1.0, 2.0]), np.zeros((2, 2)),
    np.ones((2, 2, 2)), np.array([1, 2]), np.arange(3000.0), list(range(3000)), [1.0] * 3000, pd.DataFrame(),
    pd.Series([1.0, 2.0]), pd.DataFrame({"name": ["a"]}), pd.DataFrame({"station": [1.0], "elevation": [2.0]}),
    Decimal("1.5"), Fraction(1, 3), Path("x"), Path("/"), Path("/nowhere/x"), "/", rw.Load("other", 3.0),
    rw.Anchor("other", at=(1.0, 2.0)), rw.Sheave("a", at=(0.0, 0.0)), rw.Drum("a", at=(0.0, 0.0)), rw.Elastic(),
    rw.ThresholdResponse(low=1.0, high=2.0, increment=0.1), rw.Schedule([0.0, 1.0], [1.0, -1.0]), rw.System("other"),
    rw.Schedule([0.0], [1e300]), rw.Profile([0.0, 1.0], [0.0, 1e9]), ROPE, HEAD, TAIL, CARRIAGE,
)  # fmt: skip
"""Values that some argument takes."""

MAY_BE_NAN = {
    "sensitivities",
    "fmu.Fmu",
    "fmu.load",
    "fmu.Fmu.shaped",
    "fmu.Fmu.values",
    "fmu.CoSimulation.add",
    "fmu.component",
    "Equilibrium",
    "places",
    "Result",
    "fmu.FmuComponent",
    "Profile.elevations",
    "twelve_cases",
    "optimise_supports",
    "SchedulePlan.robustness",
    "method_errors",
    "load_path",
    "SupportPlan",
    "sweep",
    "solve_span",
    "compare_payload_methods",
    "payload",
    "load_cases",
    "LoadCases",
    "support_table",
    "optimise_schedule",
    "SchedulePlan",
    "receding_horizon",
    "ropes",
    "StudyInputs",
    "carriages",
    "yarders",
}
"""Callables whose tables have NaN where there is no number, as they say, and what only keeps what it is given."""

ANYTHING = {"fmu.Fmu.description", "fmu.Fmu.values.given", "fmu.Slave.enter.values", "fmu.Slave.set.values"} | {
    "SupportPlan.station",
    "StudyInputs.arguments",
    "Monitor.update.row",
}
"""Arguments that may be anything, or NaN; those of a study are checked when it runs."""
MUCH = {"until", "generations", "population", "horizon"}
"""Arguments whose large values ask for long work, and get it."""


class Spoilt(NamedTuple):
    """A call with one wrong thing; `never`: it must be refused."""

    name: str
    arguments: Mapping[str, Any]
    what: str
    never: bool


class HangError(BaseException):
    """A call that takes too long. No Exception, so that nothing on its way takes it for one of its own."""


def is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def takes_iterators(function: Any, argument: str, *, element: bool) -> bool:
    """Whether the annotation of an argument, or of its elements, allows any iterable: not a sequence only."""
    owner = (function.__init__, function) if isinstance(function, type) else (function,)
    hint = hints_of(*owner).get(argument, Any)
    options = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    if element:
        options = tuple(get_args(option)[-1] for option in options if get_args(option))
    return any(get_origin(option) in (Iterable, Iterator) for option in options)


def spoil(rng: np.random.Generator, name: str, call: calls.Call) -> Spoilt:
    """One argument replaced, an element of it replaced, or an argument's name changed or left out."""
    arguments, spoilt = call.arguments, dict(call.arguments)
    if not arguments or rng.random() < 0.03:
        spoilt["tensoin"] = 3.0
        return Spoilt(name, spoilt, "tensoin", True)
    key = str(rng.choice(list(arguments)))
    value = arguments[key]
    element = type(value) in (list, tuple, dict) and len(value) > 0 and rng.random() < 0.4
    inner: Any = value
    if element:
        places = list(value) if isinstance(value, dict) else range(len(value))
        place = places[int(rng.integers(len(places)))]
        inner = value[place]
    pick = rng.random()
    zoo = NEVER if pick < 0.25 else NO_NUMBER if pick < 0.5 else ODD
    wrong = zoo[int(rng.integers(len(zoo)))]
    wrong = iter([1.0]) if isinstance(wrong, Iterator) else wrong  # one that nothing has read
    never = zoo is NEVER and not callable(inner) and f"{name}.{key}" not in ANYTHING
    if is_number(inner):
        never = (never or zoo is NO_NUMBER) and f"{name}.{key}" not in ANYTHING
    if isinstance(wrong, Iterator):
        never = never and not takes_iterators(call.function, key, element=element)
    if key in MUCH and is_number(wrong) and wrong > 100.0:
        wrong = 0
    if not element:
        spoilt[key] = wrong
    elif isinstance(value, dict):
        spoilt[key] = {**value, str(place): wrong}
    else:
        spoilt[key] = type(value)([*value[:place], wrong, *value[place + 1 :]])
    return Spoilt(name, spoilt, f"{key}={repr(spoilt[key])[:80]}", never)


def undefined(value: Any, depth: int = 0) -> bool:
    """Whether a result holds NaN."""
    if isinstance(value, (float, np.floating)):
        return bool(np.isnan(value))
    if isinstance(value, rw.Result):
        return undefined(value.frame)
    if isinstance(value, np.ndarray):
        return value.dtype.kind == "f" and bool(np.isnan(value).any())
    if isinstance(value, (pd.DataFrame, pd.Series)):
        return undefined(pd.DataFrame(value).select_dtypes("number").to_numpy(dtype=float))
    if depth > 2:
        return False
    if isinstance(value, Mapping):
        return any(undefined(v, depth + 1) for v in value.values())
    if isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        return any(undefined(v, depth + 1) for v in value[:100])
    if is_dataclass(value):
        return any(undefined(getattr(value, f), depth + 1) for f in value.__dataclass_fields__ if not f.startswith("_"))
    return False


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raises HangError in a call that takes longer."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise HangError

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def verdict(make: Any, spoilt: Spoilt) -> str:
    """What is wrong with what a spoilt call does, empty when nothing is."""
    try:
        with limited(LIMIT), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = make().function(**spoilt.arguments)
    except rw.RopewayError:
        return ""
    except HangError:
        return "hang"
    except Exception as error:  # noqa: BLE001 what this campaign looks for
        last = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__} {str(error)[:90]!r} {Path(last.filename).name}:{last.lineno}"
    finally:
        plt.close("all")
    if spoilt.never:
        return "accepted"
    return "NaN" if spoilt.name not in MAY_BE_NAN and undefined(result) else ""


def spoilt_calls(seed: int, count: int, names: Sequence[str]) -> Counter[str]:
    """What goes wrong in `count` spoilt calls."""
    rng = np.random.default_rng(seed)
    found: Counter[str] = Counter()
    for _ in range(count):
        name = names[int(rng.integers(len(names)))]
        spoilt = spoil(rng, name, calls.calls()[name]())
        if wrong := verdict(calls.calls()[name], spoilt):
            found[f"{name}({spoilt.what}): {wrong}"] += 1
    return found


@pytest.fixture
def small_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder of its own for what calls write, and a limit to what they may ask of the memory."""
    monkeypatch.chdir(tmp_path)
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)


def test_every_public_callable_has_a_valid_call() -> None:
    """A new public name needs one, or no campaign tries it."""
    assert [n for n in [*calls.public_names(), *calls.public_methods()] if n not in calls.calls()] == []


@pytest.mark.slow
def test_every_argument_has_a_valid_value() -> None:
    missing = []
    for name, make in calls.calls().items():
        if name in SLOW or name.startswith("fmu."):
            continue  # their objects take seconds to make
        function, given = make()
        parameters = inspect.signature(function).parameters.values()
        named = [p.name for p in parameters if p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]
        missing += [f"{name}: {argument}" for argument in named if argument not in given]
    assert missing == []


SLOW = {
    "receding_horizon", "tune_response", "set_up", "SchedulePlan", "SchedulePlan.at", "SchedulePlan.robustness",
    "optimise_schedule", "Result.report", "Result.animate", "Fit.report", "LoadCases.report",
    "SchedulePlan.report", "PayloadStudy.report", "Inhaul.report",
    "load_path_report", "Result.plot", "Result.plot_line", "fmu.export", "inhaul",
    "tension_history", "payload", "optimise_supports", "load_path", "balanced",
}  # fmt: skip


def test_an_iterator_is_wrong_where_a_sequence_is_asked_for() -> None:
    assert takes_iterators(rw.sweep, "parameters", element=True)
    assert not takes_iterators(rw.sweep, "parameters", element=False)
    assert takes_iterators(rw.Monitor.follow, "rows", element=False)
    assert not takes_iterators(rw.sweep, "outputs", element=False)
    assert not takes_iterators(rw.Schedule, "times", element=False)


@pytest.mark.usefixtures("small_memory")
def test_a_sample_of_wrong_arguments_is_refused() -> None:
    quick = [name for name in calls.calls() if name not in SLOW and not name.startswith("fmu.")]
    assert spoilt_calls(5, 400, quick) == {}


@pytest.mark.slow
@pytest.mark.usefixtures("small_memory")
def test_valid_calls_are_valid() -> None:
    wrong = {n: v for n, make in calls.calls().items() if (v := verdict(make, Spoilt(n, make().arguments, "", False)))}
    assert wrong == {}


@pytest.mark.slow
@pytest.mark.usefixtures("small_memory")
def test_wrong_arguments_are_refused(campaign: Campaign) -> None:
    assert spoilt_calls(campaign.seed, campaign.size(3000), list(calls.calls())) == {}
