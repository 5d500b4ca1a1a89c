"""The core for systems with inertia as Python calls it: its structures, as in inertial.h, and its functions."""

from __future__ import annotations

import ctypes

from ropeway.systems.native.c_library import core_library

FILES = ("inertial.h", "inertial_system.c", "inertial_steps.c")
BLOCKS = 8
"""Blocks of the matrix of a piece."""

SIZES = ("nx", "nz", "nu", "np", "ns", "pieces", "components", "unknowns", "band")
INTEGERS = (
    *("form_nx", "form_nz", "form_nu", "form_np", "form_nd", "form_ports", "form_given", "block", "order_at"),
    *("rows", "columns", "at", "order_r", "order_z"),
    *("form", "x", "z", "r", "u", "p", "d", "port_at", "input", "result", "blocks", "dense", "unknown"),
    *("port_source", "port_aside", "port_piece", "port_row"),
    *("active_at", "active_unknown", "shared"),
)
NUMBERS = ("x_nominal", "z_nominal", "r_scale")
KERNELS = ("value", "matrix")


class SystemTables(ctypes.Structure):
    """ri_line."""

    _fields_ = (
        *((name, ctypes.c_int) for name in SIZES),
        *((name, ctypes.c_void_p) for name in (*INTEGERS, *NUMBERS, *KERNELS)),
    )


class SystemPoint(ctypes.Structure):
    """ri_point."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("x", "z", "u", "p", "d", "x_rate", "z_rate", "u_rate")),
        *((name, ctypes.c_void_p) for name in ("y", "value", "kernel", "dense", "pivot", "band", "room")),
        ("step", ctypes.c_double),
        ("worst", ctypes.c_int),
    )


class SystemRun(ctypes.Structure):
    """ri_run."""

    _fields_ = (
        *((name, ctypes.c_double) for name in ("time", "stop", "h", "tolerance", "shortest")),
        *((name, ctypes.c_int) for name in ("watches", "steps", "rejected", "hit", "room")),
        *((name, ctypes.c_void_p) for name in ("watched", "low", "high", "trace")),
    )


FAILURES = {
    1: "The equations are singular",
    2: "Newton's method makes no progress",
    3: "Newton's method has not converged",
    4: "The steps become too short",
}


def inertial_library() -> ctypes.CDLL:
    """The compiled core. Raises CompilerError, WriteError."""
    pointer, code = ctypes.c_void_p, ctypes.c_int
    return core_library(FILES, {"ri_solve": (code, pointer, pointer), "ri_move": (code, pointer, pointer, pointer)})
