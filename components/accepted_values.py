"""Checks of arguments: each returns the value as the library uses it, or raises `RefusedError`.

NumPy numbers become Python numbers, so that a float32 does not reduce the precision of a product; a pandas Series
becomes an array.
"""

from __future__ import annotations

import inspect
import math
import numbers
from collections.abc import Callable, Collection, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from reprlib import Repr
from typing import Any

import numpy as np

from ropeway.components.errors import RopewayError

Check = Callable[[Any], Any]

FINITE = "a finite number, not NaN or inf"

LONGEST_NAME = 255
"""Longest file name of common file systems [bytes]."""

_TEXTS = (str, bytes, bytearray, memoryview)
_REPR = Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 60


class RefusedError(RopewayError):
    """An invalid value; `expected` describes valid ones, `place` is its position in the argument."""

    def __init__(self, value: object, expected: str) -> None:
        self.value, self.expected, self.place = value, expected, ""
        super().__init__(expected)

    def at(self, place: str) -> RefusedError:
        """The same error, located in its container."""
        self.place = f"[{place}]{self.place}"
        return self


def short(value: object) -> str:
    """A value in a message: its repr if short, else its class."""
    try:
        text = _REPR.repr(value)
    except Exception:  # noqa: BLE001 the repr of a user's object may raise anything
        text = "<"
    if isinstance(value, type):
        return f"the class {value.__name__}"
    return f"{article(type(value).__name__)}" if text.startswith("<") or "\n" in text else text


def article(word: str) -> str:
    """A word with a or an."""
    return f"{'an' if word[0].lower() in 'aeiou' else 'a'} {word}"


def is_real(value: object) -> bool:
    """Whether a value is a real number; a Boolean is not."""
    if isinstance(value, np.ndarray):
        return value.ndim == 0 and value.dtype.kind in "iuf"
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def real(value: Any) -> Any:
    """A finite number."""
    kind = type(value)
    try:
        if kind is not float and kind is not int:
            if not is_real(value):
                raise RefusedError(value, "a number")
            value = float(value)
        finite = math.isfinite(value)
    except OverflowError:
        finite = False
    if not finite:
        raise RefusedError(value, FINITE)
    return value


def _are_finite(values: Collection[Any]) -> bool:
    """Whether all are floats with a finite sum, then all are finite; faster than `real` for many values."""
    return set(map(type, values)) == {float} and math.isfinite(sum(values))


def unbounded(value: Any) -> Any:
    """A number, which may be infinite."""
    return float(value) if is_real(value) and value in (math.inf, -math.inf) else real(value)


def undefined(value: Any) -> Any:
    """A number, which may be NaN."""
    return float(value) if is_real(value) and value != value else real(value)


def whole(value: Any) -> Any:
    """An integer."""
    if is_real(value) and isinstance(value, numbers.Integral):
        return int(value)
    raise RefusedError(value, "a whole number")


def truth(value: Any) -> Any:
    """True or False."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise RefusedError(value, "True or False")


def path(value: Any) -> Any:
    """Path of a file or folder."""
    if not isinstance(value, (str, Path)):
        raise RefusedError(value, "the path of a file")
    if "\0" in str(value) or any(len(part.encode(errors="replace")) > LONGEST_NAME for part in Path(value).parts):
        raise RefusedError(value, f"a path without NUL and with names of at most {LONGEST_NAME} bytes")
    return value


def array(value: Any) -> Any:
    """A number unchanged; arrays, Series and nested sequences as an array of numbers."""
    if isinstance(value, (list, tuple)):
        each(value, array)
    elif not (isinstance(value, np.ndarray) and value.ndim) and not hasattr(value, "to_numpy"):
        return real(value)
    try:
        found = np.asarray(value)
    except ValueError:
        raise RefusedError(value, "rows of one length") from None
    if found.dtype.kind not in "iuf" or not found.size:
        raise RefusedError(value, "a number, or an array of numbers")
    return _finite(found)


def _finite(found: np.ndarray) -> np.ndarray:
    """An array of floats; the first that is not finite is refused."""
    bad = ~np.isfinite(found)
    if bad.any():
        place = np.argwhere(bad)[0]
        raise RefusedError(float(found[tuple(place)]), FINITE).at(", ".join(map(str, place)))
    return found.astype(float, copy=False)


def any_array(value: Any) -> Any:
    """An array of finite numbers, or of Booleans, of its own type."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        if value.dtype.kind == "f":
            _finite(value)
        return value
    raise RefusedError(value, "an array of numbers")


def each(values: Sequence[Any], check: Check) -> list[Any]:
    """All elements checked."""
    try:
        return [check(value) for value in values]
    except RefusedError:
        return _placed(values, check)


def _placed(values: Sequence[Any], check: Check) -> list[Any]:
    """The same, with the position of the refused element."""
    found = []
    for i, value in enumerate(values):
        try:
            found.append(check(value))
        except RefusedError as refusal:
            raise refusal.at(str(i)) from None
    return found


def _elements(value: Any, expected: str) -> Sequence[Any]:
    """The elements of a list, tuple, array or Series."""
    if isinstance(value, (list, tuple)):
        return value
    if hasattr(value, "to_numpy") and not isinstance(value, type):
        value = value.to_numpy()
    if isinstance(value, np.ndarray) and value.ndim:
        return list(value)
    if isinstance(value, Sequence) and not isinstance(value, _TEXTS):
        return value
    raise RefusedError(value, expected)


def sequence_of(check: Check | None, expected: str) -> Check:
    """A sequence with checked elements; the same object if nothing changes."""

    def sequence(value: Any) -> Any:
        if isinstance(value, np.ndarray) and check is real and value.ndim == 1 and value.dtype.kind in "iuf":
            return _finite(value)
        values = _elements(value, expected)
        found = values if check is None else each(values, check)
        same = values is value and all(one is other for one, other in zip(found, values, strict=True))
        return value if same else found

    return sequence


def rows_of(check: Check) -> Check:
    """A sequence of sequences of one length."""

    def rows(value: Any) -> Any:
        found = check(value)
        if len({len(row) for row in found}) > 1:
            raise RefusedError(value, "rows of one length")
        return found

    return rows


def tuple_of(check: Check | None, expected: str) -> Check:
    """A sequence as a tuple, with checked elements."""

    def alike(value: Any) -> tuple[Any, ...]:
        values = _elements(value, expected)
        return tuple(values) if check is None else tuple(each(values, check))

    return alike


def tuple_like(checks: Sequence[Check | None], expected: str) -> Check:
    """A sequence as a tuple, with one check for each element."""

    def like(value: Any) -> Any:
        values = _elements(value, expected)
        if len(values) != len(checks):
            raise RefusedError(value, expected)
        pairs = list(zip(checks, values, strict=True))
        return tuple(each(pairs, lambda pair: pair[1] if pair[0] is None else pair[0](pair[1])))

    return like


def mapping_of(keys: Check | None, values: Check | None, expected: str, *, text: bool = False) -> Check:
    """A mapping or Series with checked keys and values; `text`: whether the keys are names."""

    def mapping(value: Any) -> Any:
        if hasattr(value, "to_dict") and getattr(value, "ndim", 0) == 1:  # a Series
            value = value.to_dict()
        if not isinstance(value, Mapping):
            raise RefusedError(value, expected)
        found, sound = {}, values is real and _are_finite(value.values())
        if sound and text and set(map(type, value)) == {str}:
            return value
        for key, element in value.items():
            try:
                key = key if keys is None else keys(key)
            except RefusedError as refusal:
                raise RefusedError(key, f"{refusal.expected} as each key") from None
            try:
                found[key] = element if values is None or sound else values(element)
            except RefusedError as refusal:
                raise refusal.at(repr(key)) from None
        return value if all(found[key] is value[key] for key in found) else found

    return mapping


def instance_of(kinds: tuple[type, ...], expected: str) -> Check:
    """An object of one of these classes."""

    def instance(value: Any) -> Any:
        if isinstance(value, kinds):
            return value
        raise RefusedError(value, expected)

    return instance


def with_members(members: Sequence[str], expected: str) -> Check:
    """An instance that has all these attributes."""

    def having(value: Any) -> Any:
        if not isinstance(value, type) and all(hasattr(value, name) for name in members):
            return value
        raise RefusedError(value, expected)

    return having


def iterable(value: Any) -> Any:
    """An iterable other than text, in an order that does not change from run to run."""
    if hasattr(value, "__iter__") and not isinstance(value, (type, set, frozenset, *_TEXTS)):
        return value
    raise RefusedError(value, "several values in their order")


def function_of(count: int | None) -> Check:
    """A function that accepts this number of arguments, not a class; None: any callable."""

    def function(value: Any) -> Any:
        if not callable(value) or (count is not None and isinstance(value, type)):
            raise RefusedError(value, "a function")
        try:
            if count is not None:
                inspect.signature(value).bind(*range(count))
        except TypeError:
            raise RefusedError(value, f"a function of {count} arguments") from None
        except ValueError:
            pass  # compiled functions may have no signature
        return value

    return function


def one_of(words: tuple[Any, ...]) -> Check:
    """One of these words; the error suggests the closest."""
    expected = f"one of {', '.join(map(repr, words))}"

    def word(value: Any) -> Any:
        if isinstance(value, str) and value in words:
            return value
        near = get_close_matches(value, words, 1) if isinstance(value, str) else ()
        raise RefusedError(value, f"{expected}; did you mean {near[0]!r}?" if near else expected)

    return word


def any_of(plain: tuple[type, ...], expected: Sequence[str], checks: Sequence[Check]) -> Check:
    """An object of one of the `plain` classes, named in `expected`, or a value that one of the checks accepts."""

    def alternative(value: Any) -> Any:
        if isinstance(value, plain):
            return value
        refusals = []
        for check in checks:
            try:
                return check(value)
            except RefusedError as refusal:
                refusals.append(refusal)
        for failure in refusals:  # an error within the right container is more specific than the list of kinds
            if failure.place or failure.expected == FINITE:
                raise failure
        raise RefusedError(value, " or ".join(dict.fromkeys((*(r.expected for r in refusals), *expected))))

    return alternative
