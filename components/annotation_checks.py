"""Checks of arguments, from the annotations of public signatures."""

from __future__ import annotations

import types
import typing
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from ropeway.components import accepted_values
from ropeway.components.accepted_values import Check, RefusedError
from ropeway.components.check import POSITIVE, Range

Array = NDArray[np.float64]

Numbers = float | Array
"""A number or an array of numbers."""

Positive = Annotated[float, POSITIVE]
PositiveNumbers = Annotated[Numbers, POSITIVE]
"""Numbers above zero."""

_INFINITE = "may be infinite"
Unbounded = Annotated[float, _INFINITE]
"""A number that may be infinite, such as the stiffness of an inextensible rope."""

_UNDEFINED = "may be NaN"
Undefined = Annotated[float, _UNDEFINED]
"""A number that may be NaN, for a missing value."""

_PLAIN: dict[Any, Check] = {
    float: accepted_values.real,
    int: accepted_values.whole,
    bool: accepted_values.truth,
    np.ndarray: accepted_values.any_array,
}
_NAMES: dict[Any, str] = {
    str: "text",
    type(None): "None",
}

_PLURAL: dict[Any, str] = {float: "numbers", int: "whole numbers", str: "texts"}


def check_of(hint: Any) -> Check | None:
    """The check of an annotation; None if it allows everything. Raises TypeError for an unknown annotation."""
    if hint is Any or hint is object:
        return None
    if hint in (Numbers, ArrayLike):
        return accepted_values.array
    if hint in _PLAIN:
        return _PLAIN[hint]
    if isinstance(hint, TypeVar):
        return check_of(hint.__bound__ or Any)
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _annotated(arguments[0], arguments[1])
    if origin in (Union, types.UnionType):
        return _union(arguments)
    if origin is Literal:
        return accepted_values.one_of(arguments)
    if origin is not None:
        return _container(origin, arguments)
    if _is_protocol(hint):
        members = sorted(_members(hint))
        return accepted_values.with_members(
            members, f"{accepted_values.article(hint.__name__)}, which has {', '.join(members)}"
        )
    if isinstance(hint, type):
        return _maker(hint) or accepted_values.instance_of((hint,), _name(hint))
    raise TypeError(f"No check for {hint!r}")


def _maker(hint: Any) -> Check | None:
    """The class method `_from_given` of a class that users give in other forms too: a rope by its name, a profile by
    the path of its table."""
    return getattr(hint, "_from_given", None) if isinstance(hint, type) else None


def _name(kind: Any) -> str:
    return _NAMES.get(kind) or accepted_values.article(getattr(kind, "__name__", str(kind)))


def _annotated(hint: Any, extra: Any) -> Check | None:
    """Check of `Unbounded`, or of an annotation with a `Range`."""
    if extra == _INFINITE:
        return accepted_values.unbounded
    if extra == _UNDEFINED:
        return accepted_values.undefined
    inner = check_of(hint)
    if inner is None or not isinstance(extra, Range):
        return inner

    def ranged(value: Any) -> Any:
        value = inner(value)
        for v in np.ravel(value):
            if extra.refuses(float(v)):
                raise RefusedError(float(v), extra.words)
        return value

    return ranged


def _union(options: tuple[Any, ...]) -> Check | None:
    """Check of a union. An array contains numbers: it is checked as a sequence where both are allowed."""
    checks = {option: check_of(option) for option in options}
    if None in checks.values():
        return None
    if np.ndarray in checks:
        del checks[np.ndarray]
        if not any(get_origin(option) is Sequence for option in options):
            checks[ArrayLike] = accepted_values.array
    if any(get_origin(option) is Mapping for option in options):  # which takes a Series too
        checks.pop(pd.Series, None)
    if Path in checks:
        del checks[Path]
        checks[str] = accepted_values.path
    makers = [check for option in checks if (check := _maker(option)) is not None]
    if makers:  # they take the other forms that the union names; None and other classes of the library are left
        left = tuple(o for o in checks if o is type(None) or (_is_own(o) and _maker(o) is None))
        return accepted_values.any_of(left, [_name(o) for o in left], makers)
    plain = [o for o in checks if isinstance(o, type) and o not in (*_PLAIN, str) and not _is_protocol(o)]
    others = [check for option, check in checks.items() if option not in plain and check is not None]
    return accepted_values.any_of(tuple(plain), [_name(o) for o in plain], others)


def _is_own(hint: Any) -> bool:
    return isinstance(hint, type) and hint.__module__.startswith("ropeway.")


def _is_protocol(hint: Any) -> bool:
    return bool(getattr(hint, "_is_protocol", False))


def _container(origin: Any, arguments: tuple[Any, ...]) -> Check:
    if origin is tuple and arguments[-1] is not Ellipsis:
        return accepted_values.tuple_like([check_of(a) for a in arguments], f"{len(arguments)} values")
    if origin is Callable:
        return accepted_values.function_of(len(arguments[0]) if isinstance(arguments[0], list) else None)
    if issubclass(origin, np.ndarray):
        return accepted_values.array
    checks = [check_of(a) for a in arguments if a is not Ellipsis]
    if issubclass(origin, Mapping):
        return accepted_values.mapping_of(
            checks[0], checks[1], "a mapping of names to values", text=arguments[0] is str
        )
    what = _PLURAL.get(arguments[0], "values")
    if origin is tuple:
        return accepted_values.tuple_of(checks[0], f"a sequence of {what}")
    if issubclass(origin, Sequence):
        found = accepted_values.sequence_of(checks[0], f"a sequence of {what}")
        return accepted_values.rows_of(found) if arguments[0] == Sequence[float] else found
    if origin in (Iterable, Collection):
        return accepted_values.iterable
    return accepted_values.instance_of((origin,), _name(origin))


def _members(protocol: Any) -> set[str]:
    """Attributes that a protocol requires."""
    bases = [b for b in protocol.__mro__ if _is_protocol(b) and b is not typing.Protocol]
    names = {name for b in bases for name in (*vars(b), *vars(b).get("__annotations__", {}))}
    return {name for name in names if not name.startswith("_")}
