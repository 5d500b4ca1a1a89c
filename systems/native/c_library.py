"""Libraries of the C core as Python calls them, where their functions are, and calls of kernels (calls.h)."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from ropeway.systems.native.binary_cache import library

_FOLDER = Path(__file__).parent

Prototype = tuple[Any, ...]
"""Types of the result and of the arguments of a function in C."""


def core_library(files: tuple[str, ...], functions: Mapping[str, Prototype]) -> ctypes.CDLL:
    """The library of files of this folder, with its functions. Raises CompilerError, WriteError."""
    found = library(dict(_source(files)))
    for name, (result, *arguments) in functions.items():
        function = getattr(found, name)
        function.argtypes, function.restype = arguments, result
    return found


def address(of: ctypes.CDLL, name: str) -> int:
    """Where a function of a library is."""
    return int(ctypes.cast(getattr(of, name), ctypes.c_void_p).value or 0)


@lru_cache(maxsize=8)
def _source(files: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    return tuple((name, (_FOLDER / name).read_text()) for name in files)


CALL_INTEGERS = ("result", "inputs_end", "input")


class CallTables(ctypes.Structure):
    """rn_calls."""

    _fields_ = (
        *((name, ctypes.c_int) for name in ("calls", "values")),
        *((name, ctypes.c_void_p) for name in (*CALL_INTEGERS, "kernels")),
    )
