"""Every public name has a docstring in numpydoc's sections, as its signature has it."""

from __future__ import annotations

import inspect
from enum import Enum
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
