"""Argument checks of public functions, methods and classes, from their annotations.

Public callables are decorated with `@checked`. Annotations are resolved at the first call. Signatures, help and types
are unchanged.
"""

from __future__ import annotations

import inspect
import sys
import typing
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import cache, wraps
from types import FunctionType, SimpleNamespace
from typing import Any, NamedTuple, TypeVar

from ropeway.components.accepted_values import Check, RefusedError, short
from ropeway.components.annotation_checks import check_of
from ropeway.components.errors import InputError

_Target = TypeVar("_Target", bound=Callable[..., Any])


def checked(target: _Target) -> _Target:
    """Check the arguments of a function, or of a class's constructor and its own public methods.

    A wrong type, or an unknown, missing or superfluous argument is an InputError.
    """
    if not isinstance(target, type):
        return typing.cast(_Target, _checked_call(target, target.__qualname__, lambda: hints_of(target)))
    kind: Any = target
    if isinstance(vars(kind).get("__init__"), FunctionType):
        constructor = kind.__init__
        kind.__init__ = _checked_call(constructor, kind.__name__, lambda: hints_of(constructor, kind))
    for name, member in list(vars(kind).items()):
        function = member.__func__ if isinstance(member, (classmethod, staticmethod)) else member
        if (not name.startswith("_") or name == "__getitem__") and isinstance(function, FunctionType):
            checked_call = checked(function)
            setattr(kind, name, type(member)(checked_call) if function is not member else checked_call)
    return target


class _Signature(NamedTuple):
    """Arguments of a callable: their checks by name, None if everything is allowed."""

    owner: str
    positional: tuple[str, ...]
    required: tuple[str, ...]
    checks: Mapping[str, Check | None]
    rest: str
    open: bool
    """Whether no argument has a check, as in the equations of a component, which the solvers call."""

    def admit(self, args: tuple[Any, ...], kwargs: dict[str, Any]) -> tuple[Any, ...]:
        """Checked positional arguments; keyword arguments are replaced in place. Raises InputError."""
        checks, positional, given = self.checks, self.positional, len(args)
        if self.open and given == len(positional) and not kwargs:
            return args
        if given > len(positional) and not self.rest:
            bound = positional[:1] in (("self",), ("cls",))
            raise InputError(
                f"{self.owner} has {given - bound} positional arguments",
                f"It takes at most {len(positional) - bound}",
            )
        found = list(args)
        for i, value in enumerate(args):
            name = positional[i] if i < len(positional) else self.rest
            check = checks[name]
            if check is not None:
                try:
                    found[i] = check(value)
                except RefusedError as refusal:
                    raise self.refused(name, refusal, args, kwargs) from None
        for name, value in kwargs.items():
            check = checks.get(name, _unknown)
            if check is _unknown or name == self.rest:
                raise self.unknown(name)
            if name in positional[:given]:
                raise InputError(f"{self.owner} has two values for {name}", "Give one")
            if check is not None:
                try:
                    kwargs[name] = check(value)
                except RefusedError as refusal:
                    raise self.refused(name, refusal, args, kwargs) from None
        if missing := [n for n in self.required if n not in kwargs and n not in positional[:given]]:
            raise InputError(f"{self.owner} has no {', no '.join(missing)}", f"Give {' and '.join(missing)}")
        return tuple(found)

    def refused(self, name: str, refusal: RefusedError, args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> InputError:
        """The error for an argument; a component is identified by its own name as well."""
        owner = self.owner
        if self.checks.get("name") is not None and name != "name":
            known = dict(zip(self.positional, args, strict=False)) | dict(kwargs)
            owner += f" {known['name']!r}" if isinstance(known.get("name"), str) else ""
        return InputError(f"{owner}: {name}{refusal.place} is {short(refusal.value)}", f"Give {refusal.expected}")

    def unknown(self, name: str) -> InputError:
        """The error for an unknown keyword."""
        names = [n for n in self.checks if n not in (self.rest, "self", "cls")]
        near = get_close_matches(name, names, 1)
        remedy = f"Did you mean {near[0]}?" if near else f"It has {', '.join(names) or 'no arguments'}"
        return InputError(f"{self.owner} has no argument {name!r}", remedy)


def _unknown(value: Any) -> Any:
    """Placeholder for the check of an unknown argument."""
    return value


def _checked_call(function: Any, owner: str, hints: Callable[[], Mapping[str, Any]]) -> Any:
    signature = cache(lambda: _signature(function, owner, hints()))

    @wraps(function)
    def checked_call(*args: Any, **kwargs: Any) -> Any:
        args = signature().admit(args, kwargs)
        try:
            return function(*args, **kwargs)
        except (ArithmeticError, MemoryError) as error:
            raise InputError(
                f"{owner}: the values lead to numbers outside the floating-point range ({type(error).__name__})",
                "Check their units; one value is far too large or too small",
            ) from error

    return checked_call


def _signature(function: Any, owner: str, hints: Mapping[str, Any]) -> _Signature:
    positional: list[str] = []
    required: list[str] = []
    checks: dict[str, Check | None] = {}
    rest = ""
    for name, parameter in inspect.signature(function).parameters.items():
        hint = hints.get(name, Any)
        checks[name] = check_of(hint)
        if parameter.kind is parameter.VAR_POSITIONAL:
            rest = name
            continue
        if parameter.kind is not parameter.KEYWORD_ONLY:
            positional.append(name)
        if parameter.default is parameter.empty:
            required.append(name)
    everything = not rest and len(checks) == len(positional) and not any(checks.values())
    return _Signature(owner, tuple(positional), tuple(required), checks, rest, everything)


def hints_of(function: Any, kind: type | None = None) -> dict[str, Any]:
    """Annotations of the arguments.

    Those of a constructor that belong to a field are resolved in the module of the class that declares the field.
    """
    hints: dict[str, Any] = {}
    for name, hint in function.__annotations__.items():
        if name == "return":
            continue
        bases = () if kind is None else kind.__mro__
        home = next((b for b in bases if vars(b).get("__annotations__", {}).get(name) == hint), function)
        names = vars(sys.modules[home.__module__])
        hints |= typing.get_type_hints(SimpleNamespace(__annotations__={name: hint}), names, include_extras=True)
    return hints
