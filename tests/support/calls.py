"""A valid call of every public callable, for campaigns that make one argument at a time invalid."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from functools import cache
from typing import Any

import ropeway as rw
from ropeway.components.component import Component
from ropeway.components.node import Node
from ropeway.components.response import Response
from support.call_arguments import functions, instances
from support.call_methods import Call, methods


@cache
def calls() -> Mapping[str, Callable[[], Call]]:
    """A valid call by name; each is created anew, as a call may change its arguments."""
    table = dict(methods())
    for name, make in instances().items():
        table[name] = lambda make=make: Call(type(make()), _fields(make()))
    for name, arguments in functions().items():
        table[name] = lambda name=name, arguments=arguments: Call(public(name), arguments())
    return table


def public(name: str) -> Any:
    """A public name's object."""
    return getattr(rw.fmu, name[4:]) if name.startswith("fmu.") else getattr(rw, name)


def _fields(thing: Any) -> dict[str, Any]:
    return {f.name: getattr(thing, f.name) for f in fields(thing) if f.init}


EXTENSION = {
    "Component", "Drive", "DriveMotion", "Energies", "Equations", "Kind", "Limit", "MovingMass", "Node", "RopeEnd",
    "Seat", "Site", "Variable",
}  # fmt: skip
"""Parts of components, created a thousand times in an assembly, which checks them as a whole."""


def public_names() -> list[str]:
    """All names of the root and of `rw.fmu` that can be called, without errors and parts of components."""
    left_out = {*EXTENSION, "fmu", "units"}
    names = [n for n in (*rw.__all__, *(f"fmu.{name}" for name in rw.fmu.__all__)) if n not in left_out]
    return [n for n in names if not (isinstance(public(n), type) and issubclass(public(n), BaseException))]


PROTOCOL = {name for base in (Component, Node, Response) for name in vars(base)} - {"output", "input"}
"""Methods of components that the library calls with its own objects."""
INSIDE = {
    "wheel_equations", "wheel_outputs", "line_outputs", "total", "placed", "require_above", "own_variables", "demand",
    "motion", "block_out", "driver", "outputs", "clearance", "travels", "forget", "restore",
    "precedence_of", "energies", "closure_moves", "force_moves",
}  # fmt: skip
"""Methods with intermediate objects of the library as arguments."""


def public_methods() -> Iterator[str]:
    """All methods of public classes that take arguments from a user."""
    for name in public_names():
        kind = public(name)
        if not isinstance(kind, type):
            continue
        for method, raw in vars(kind).items():
            function = getattr(raw, "__func__", raw)
            hidden = method.startswith("_") and method != "__getitem__"
            if hidden or method in PROTOCOL | INSIDE or not inspect.isfunction(function):
                continue
            if len(inspect.signature(function).parameters) > (not isinstance(raw, staticmethod)):
                yield f"{name}.{method}"
