"""Every public name has a docstring in numpydoc's sections, as its signature has it, and an example that runs."""

from __future__ import annotations

import doctest
import inspect
import re
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from numpydoc.docscrape import NumpyDocString
from numpydoc.validate import validate

import ropeway as rw
from support.calls import INSIDE, PROTOCOL, public

CHECKS = {
    "GL06": "unknown section",
    "GL07": "order of sections",
    "GL08": "no docstring",
    "SS03": "summary without a period",
    "SS06": "summary of several lines",
    "PR01": "undocumented parameter",
    "PR02": "unknown parameter",
    "PR03": "order of parameters",
    "PR04": "parameter without a type",
    "PR07": "parameter without a description",
    "RT01": "no Returns",
}
DEFINES_THE_PROTOCOL = ("Component", "Node", "Drive")


def names() -> list[str]:
    """All public functions, classes, methods and properties, but those that only implement a protocol."""
    found = []
    for name in (*rw.__all__, *(f"fmu.{n}" for n in rw.fmu.__all__)):
        if isinstance(public(name), ModuleType):
            continue
        found.append(name)
        kind = public(name)
        if not isinstance(kind, type) or issubclass(kind, Enum):
            continue
        implemented = frozenset() if name in DEFINES_THE_PROTOCOL else PROTOCOL | INSIDE
        found += [f"{name}.{m}" for m, raw in vars(kind).items() if m not in implemented and _is_public(m, raw)]
    return found


def _is_public(name: str, raw: Any) -> bool:
    function = getattr(raw, "__func__", raw)
    return not name.startswith("_") and (inspect.isfunction(function) or isinstance(raw, property))


def faults(name: str) -> list[str]:
    """What is wrong with a docstring. Classes that users do not create have attributes instead of parameters."""
    top = public(name) if "." not in name.removeprefix("fmu.") else None
    found = {code for code, _ in validate(f"ropeway.{name}")["errors"]} & set(CHECKS)
    if isinstance(top, type) and (issubclass(top, (BaseException, Enum)) or _attributes(top) == _fields(top)):
        found -= {"PR01"}
    faulty = [CHECKS[code] for code in sorted(found)]
    if top is not None and not isinstance(top, type):
        text = inspect.getdoc(top) or ""
        sections = ["Raises", "Examples"] if inspect.signature(top).parameters else ["Examples"]
        faulty += [f"no {section}" for section in sections if f"\n{section}\n---" not in text]
    return faulty


def _fields(kind: type) -> list[str]:
    return list(inspect.signature(kind).parameters)


def _attributes(kind: type) -> list[str]:
    """Names in the section of attributes, in order."""
    section = NumpyDocString(inspect.getdoc(kind) or "")["Attributes"]
    return [name for entry in section for name in entry.name.split(", ")]


@pytest.mark.parametrize("name", names())
def test_a_docstring_has_its_sections(name: str) -> None:
    assert faults(name) == []


ROOT = Path(__file__).resolve().parents[1]
LONG = ("RecedingHorizon", "SchedulePlan", "TunedResponse", "optimise_schedule", "receding_horizon", "tune_response")
"""Names whose examples run in the slow tests."""


@pytest.fixture(scope="module")
def ready(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Any]]:
    """What the script of docs/api.md defines, in a folder with its files."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("examples"))
        Path("examples").symlink_to(ROOT / "examples")
        defined: dict[str, Any] = {}
        exec(re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "api.md").read_text(), re.DOTALL)[0], defined)
        yield defined


def examples() -> list[Any]:
    """All public names, and their methods with an example."""
    found = [name for name in names() if "." not in name.removeprefix("fmu.") or ">>>" in _text(name)]
    return [pytest.param(name, marks=[pytest.mark.slow] if name in LONG else []) for name in found]


def _text(name: str) -> str:
    owner, _, member = name.removeprefix("fmu.").partition(".")
    found = public(f"fmu.{owner}" if name.startswith("fmu.") else owner)
    if member:
        found = inspect.getattr_static(found, member)
    return inspect.getdoc(getattr(found, "__func__", found)) or ""


@pytest.mark.parametrize("name", examples())
def test_the_example_of_a_name_runs(name: str, ready: dict[str, Any]) -> None:
    """Errors that a short script cannot provoke have none."""
    test = doctest.DocTestParser().get_doctest(_text(name), dict(ready), name, None, 0)
    top = public(name) if "." not in name.removeprefix("fmu.") else None
    assert test.examples or (isinstance(top, type) and issubclass(top, (BaseException, Warning)))
    assert not any("SKIP" in example.source for example in test.examples)
    failures: list[str] = []
    doctest.DocTestRunner(verbose=False, optionflags=doctest.NORMALIZE_WHITESPACE).run(test, out=failures.append)
    assert "".join(failures) == ""
