"""The core by sections as Python calls it: its structures, as in sections.h and moving.h, and its functions."""

from __future__ import annotations

import ctypes
from typing import Any

from ropeway.systems.native.c_library import CallTables, core_library

FILES = (
    *("calls.h", "sections.h", "clocks.h", "drives.h", "moving.h"),
    *("calls.c", "sections.c", "crossings.c", "moving.c", "drives.c", "windows.c", "clocks.c", "running.c", "rows.c"),
)

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


def _fields(*groups: tuple[Any, str]) -> tuple[tuple[str, Any], ...]:
    """Fields of a structure, from types with the names of their fields."""
    return tuple((name, kind) for kind, names in groups for name in names.split())


class CrossingEvent(ctypes.Structure):
    """rs_event."""

    _fields_ = _fields((ctypes.c_int, "run support load forward record"))


class ResponseEvent(ctypes.Structure):
    """rs_response."""

    _fields_ = _fields((ctypes.c_int, "member record"), (ctypes.c_double, "value"))


class Motion(ctypes.Structure):
    """rs_motion."""

    _fields_ = _fields(
        (ctypes.c_double, "time begin h"),
        (ctypes.c_void_p, "stop"),
        (ctypes.c_int, "stops grids reached strict single failure"),
        (ctypes.c_void_p, "window window_rates nodes weights"),
        (ctypes.c_double, "crossed short_step least_step longest_step"),
        (ctypes.c_void_p, "load_first place mass drag rope scale passed pull wind sign"),
        (ctypes.c_int, "records wholes sections numbers behind"),
        (ctypes.c_int, "most most_wholes most_numbers chain events responses epoch"),
        (ctypes.c_void_p, "record_grid record_epoch record_sections part_section"),
        (ctypes.c_void_p, "record_time record_x record_u whole_z part_z whole_passed event response"),
        (CrossingEvent, "coming"),
        (ctypes.c_void_p, "kept"),
        (ctypes.c_int, "keeps epochs"),
        (ctypes.c_void_p, "epoch_kept epoch_ticks due room"),
        (ctypes.c_double, "stopped"),
        (ctypes.c_int, "curved"),
        (ctypes.c_void_p, "touched old_rate curve"),
    )


class Agenda(ctypes.Structure):
    """rs_agenda."""

    _fields_ = _fields(
        (ctypes.c_int, "bends bent"),
        (ctypes.c_void_p, "bend value slope"),
        (ctypes.c_int, "discrete"),
        (ctypes.c_void_p, "saved"),
    )


class DriveTables(ctypes.Structure):
    """rs_drives."""

    _fields_ = _fields(
        (ctypes.c_int, "drives most"),
        (ctypes.c_void_p, "form x u p d port_first port_span port_end states inputs parameters discrete ports tied"),
        (ctypes.c_void_p, "kernels nominal nodes weights derivative window rates limited"),
        (ctypes.c_double, "last"),
        (ctypes.c_void_p, "work"),
    )


class ClockTables(ctypes.Structure):
    """rs_clocks."""

    _fields_ = _fields(
        (ctypes.c_int, "clocks most"),
        (ctypes.c_void_p, "period begin ticks first effect form x u p d port_first port_span port_end"),
        (ctypes.c_void_p, "states inputs parameters discrete ports values correction waiting place_first place"),
        (ctypes.c_void_p, "rival_first rival by_need kernels results changed work"),
    )


class OutputCalls(ctypes.Structure):
    """rs_output_calls."""

    _fields_ = (
        ("calls", CallTables),
        ("vectors", ctypes.c_int),
        ("outputs", ctypes.c_int),
        ("row", ctypes.c_void_p),
    )


MOST = 64
"""RS_MOST."""
REACHED, CROSSING, UNFORESEEN, LOADS, FULL, FAILED, SLACK, PASSED, COUPLED, ASTRAY = range(10)
"""Why `rs_move` and `rs_run` return."""

FAILURES = {
    1: "The equations are singular",
    2: "Newton's method makes no progress",
    3: "Newton's method has not converged",
    4: "The rope has moved away from its balance",
}


def section_library() -> ctypes.CDLL:
    """The compiled core. Raises CompilerError, WriteError."""
    pointer = ctypes.c_void_p
    functions = {
        "rs_work_size": (pointer,),
        "rs_solve": (pointer, pointer, ctypes.c_int, ctypes.c_int),
        "rs_solve_all": (pointer, pointer, ctypes.c_int),
        "rs_solve_many": (pointer, pointer, ctypes.c_int, pointer, pointer),
        "rs_move": (pointer, pointer, pointer, ctypes.c_double, pointer),
        "rs_run": (pointer,) * 6,
        "rs_write_rows": (*(pointer,) * 4, ctypes.c_longlong, pointer, ctypes.c_int),
        "rs_outputs": (pointer, pointer, ctypes.c_longlong, pointer, ctypes.c_int, pointer, pointer, ctypes.c_longlong),
        "rs_window": (*(pointer,) * 4, ctypes.c_double),
        "rs_coupled": (*(pointer,) * 5, ctypes.c_int),
        "rs_rates": (pointer,) * 4,
        "rs_drives_size": (pointer, pointer),
        "rs_saved_size": (pointer, ctypes.c_int),
    }
    return core_library(FILES, {name: (ctypes.c_int, *arguments) for name, arguments in functions.items()})
