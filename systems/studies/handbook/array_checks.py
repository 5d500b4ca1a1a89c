"""Checks of numbers and arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ropeway.components.errors import InputError
from ropeway.systems.studies.handbook.array_roots import Array


def require(value: ArrayLike, what: str, test: Any, words: str) -> None:
    """Raises InputError unless all values are finite and pass `test`."""
    array = np.asarray(value, dtype=float)
    bad = ~(np.isfinite(array) & test(array))
    if bad.any():
        raise InputError(f"{what} is {float(array[bad].flat[0])!r}", f"It must be {words}")


def require_broadcast(*values: ArrayLike) -> None:
    """Raises InputError unless arrays broadcast."""
    try:
        np.broadcast_shapes(*(np.shape(v) for v in values))
    except ValueError:
        shapes = " and ".join(dict.fromkeys(str(np.shape(v)) for v in values if np.ndim(v)))
        raise InputError(f"Arrays of shapes {shapes} do not broadcast", "Give arrays of one length") from None


def finite(value: ArrayLike, what: str) -> Array:
    """A result as an array. Raises InputError for a value that is not finite."""
    array = np.asarray(value, dtype=float)
    if not np.isfinite(array).all():
        raise InputError(f"The {what} is not finite", "Check the units: a value is far too large or too small")
    return array
