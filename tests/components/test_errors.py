"""Every error of the package copies, pickles and comes back from a process pool with all that it carries."""

import copy
import importlib
import pickle
import pkgutil
from concurrent.futures import ProcessPoolExecutor
from inspect import Parameter, signature
from multiprocessing import get_context
from typing import Any

import pytest

import ropeway
from ropeway.components.errors import Interrupted, OutOfReachError, RopewayError, SimulationError, UnknownNameError


def every_error() -> list[type[BaseException]]:
    """All exception classes of all modules of the package, but its tests and scripts."""
    found: dict[str, type[BaseException]] = {}
    for module in pkgutil.walk_packages(ropeway.__path__, "ropeway."):
        if module.name.startswith(("ropeway.tests", "ropeway.examples", "ropeway.benchmarks", "ropeway.docs")):
            continue
        if module.name == "ropeway.__main__":
            continue
        for name, value in vars(importlib.import_module(module.name)).items():
            if isinstance(value, type) and issubclass(value, BaseException) and value.__module__ == module.name:
                found[f"{value.__module__}.{name}"] = value
    return [found[name] for name in sorted(found)]


def made(kind: type[BaseException]) -> BaseException:
    """An error with another value for each of its arguments."""
    if not issubclass(kind, (RopewayError, Interrupted)):
        return kind()
    values: dict[str, Any] = {"cause": "A rope of 31 m is short", "remedy": "Give 33 m", "time": 7.25, "fatal": True}
    named = {
        name: values.get(name, f"the {name}")
        for name, p in signature(kind).parameters.items()
        if p.kind is not Parameter.VAR_POSITIONAL
    }
    return kind(**named)


def same(error: BaseException, other: BaseException) -> bool:
    return type(error) is type(other) and str(error) == str(other) and vars(error) == vars(other)


@pytest.mark.parametrize("kind", every_error(), ids=lambda kind: kind.__name__)
def test_an_error_copies_and_pickles_with_its_attributes(kind: type[BaseException]) -> None:
    error = made(kind)
    error.add_note("seen at the tailspar")
    for other in (copy.copy(error), copy.deepcopy(error), pickle.loads(pickle.dumps(error))):
        assert same(error, other)
        assert other.args == error.args


def test_the_walk_finds_errors_of_all_floors() -> None:
    names = {kind.__name__ for kind in every_error()}
    assert {"Interrupted", "OutOfReachError", "InfeasibleScheduleError", "FmuRunError", "WriteError"} <= names


def test_an_error_of_a_users_own_class_pickles() -> None:
    error = _BrokenSpliceError(12.5)
    other = pickle.loads(pickle.dumps(error))
    assert same(error, other)
    assert other.station == 12.5


def test_unpicklable_attributes_are_dropped_with_a_note() -> None:
    error = SimulationError("It stopped", "Look", 3.0, lambda: None)
    other = pickle.loads(pickle.dumps(error))
    assert other.result is None
    assert "result was dropped" in other.__notes__[0]
    assert str(other) == str(error)
    assert other.time == 3.0
    assert copy.copy(error).result is error.result


def test_an_interrupt_is_a_keyboard_interrupt_and_no_error() -> None:
    assert issubclass(Interrupted, KeyboardInterrupt)
    assert not issubclass(Interrupted, Exception)


def test_errors_come_back_from_a_process_pool() -> None:
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        beyond = pool.submit(_fail, "beyond").exception(timeout=60)
        unknown = pool.submit(_fail, "unknown").exception(timeout=60)
    assert isinstance(beyond, OutOfReachError)
    assert (beyond.limit, beyond.component) == ("haulback tension", "carriage")
    assert isinstance(unknown, UnknownNameError)
    assert str(unknown) == "No 'l9'. Ask for another"


class _BrokenSpliceError(RopewayError):
    def __init__(self, station: float) -> None:
        self.station = station
        super().__init__(f"A splice has broken at {station:g} m", "Splice it anew")


def _fail(how: str) -> None:
    if how == "beyond":
        raise OutOfReachError("Too heavy", "Load less", "carriage", "haulback tension")
    raise UnknownNameError("No 'l9'", "Ask for another")
