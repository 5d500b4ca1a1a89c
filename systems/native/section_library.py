"""The core by sections as Python calls it: its structures, as in sections.h and moving.h, and its functions."""

from __future__ import annotations

import ctypes
from functools import lru_cache
from pathlib import Path

from ropeway.systems.native.binary_cache import library

_FOLDER = Path(__file__).parent
FILES = ("sections.h", "sections.c", "moving.h", "moving.c")


LINE_SIZES = ("spans", "supports", "sections", "slots", "nx", "nz", "nu", "np", "ns", "runs")
LINE_INTEGERS = (
    *(
        "form",
        "parameters",
        "force",
        "closure",
        "mass",
        "at",
        "ride",
        "drag",
        "start",
        "empty",
        "count",
        "length_start",
        "on_idlers",
    ),
    "form_parameters",
    *("point", "state", "travel", "balance", "support_form", "support_parameters", "support_discrete", "speed"),
    *("support_form_parameters", "support_form_discrete"),
    *("first", "last", "first_span", "section_of"),
    *("run_of", "held", "free_end", "run_first", "around", "fed"),
    "shared",
)
LINE_NUMBERS = ("z_nominal", "r_nominal")
LINE_KERNELS = ("kernels", "support_kernels")


class LineTables(ctypes.Structure):
    """rs_line."""

    _fields_ = (
        *((name, ctypes.c_int) for name in LINE_SIZES),
        *((name, ctypes.c_void_p) for name in (*LINE_INTEGERS, *LINE_NUMBERS, *LINE_KERNELS)),
    )


class LinePoint(ctypes.Structure):
    """rs_point."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("x", "z", "u", "p", "d", "used", "x_rate", "u_rate", "z_rate", "work")),
        ("worst", ctypes.c_int),
    )


class CrossingEvent(ctypes.Structure):
    """rs_event."""

    _fields_ = tuple((name, ctypes.c_int) for name in ("run", "support", "load", "forward", "record"))


class Motion(ctypes.Structure):
    """rs_motion."""

    _fields_ = (
        *((name, ctypes.c_double) for name in ("time", "begin", "h")),
        ("stop", ctypes.c_void_p),
        *((name, ctypes.c_int) for name in ("stops", "reached", "grid")),
        *((name, ctypes.c_int) for name in ("strict", "single", "failure")),
        *((name, ctypes.c_void_p) for name in ("window", "window_rates")),
        *((name, ctypes.c_double) for name in ("crossed", "short_step", "least_step")),
        *((name, ctypes.c_void_p) for name in ("load_first", "place", "mass", "drag", "rope", "scale", "passed")),
        ("pull", ctypes.c_void_p),
        ("wind", ctypes.c_void_p),
        *((name, ctypes.c_int) for name in ("records", "most", "events")),
        *(
            (name, ctypes.c_void_p)
            for name in ("record_grid", "record_time", "record_x", "record_z", "record_passed", "event")
        ),
        ("coming", CrossingEvent),
        ("room", ctypes.c_void_p),
    )


REACHED, CROSSING, UNFORESEEN, LOADS, FULL, FAILED, SLACK, PASSED = range(8)
"""Why `rs_move` returns."""

FAILURES = {
    1: "The equations are singular",
    2: "Newton's method makes no progress",
    3: "Newton's method has not converged",
    4: "The rope has moved away from its balance",
}


@lru_cache(maxsize=1)
def _source() -> tuple[tuple[str, str], ...]:
    return tuple((name, (_FOLDER / name).read_text()) for name in FILES)


def section_library() -> ctypes.CDLL:
    """The compiled core. Raises CompilerError, WriteError."""
    found = library(dict(_source()))
    pointer = ctypes.c_void_p
    for name, types in {
        "rs_work_size": (pointer,),
        "rs_solve": (pointer, pointer, ctypes.c_int, ctypes.c_int),
        "rs_solve_all": (pointer, pointer, ctypes.c_int),
        "rs_solve_many": (pointer, pointer, ctypes.c_int, pointer, pointer),
        "rs_move": (pointer, pointer, pointer),
    }.items():
        function = getattr(found, name)
        function.argtypes, function.restype = list(types), ctypes.c_int
    return found
