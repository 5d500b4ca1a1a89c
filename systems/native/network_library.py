"""The core of networks as Python calls it: its structures, as in network.h, and its functions."""

from __future__ import annotations

import ctypes

from ropeway.systems.native.c_library import CallTables, core_library

FILES = ("calls.h", "sparse_lu.h", "network.h", "calls.c", "network.c", "sparse_lu.c")

NETWORK_SIZES = ("sums", "drifts", "entries", "balances")
NETWORK_INTEGERS = (
    *("sum", "terms_end", "factor", "other"),
    *("unknown", "residual", "drift"),
    "entry",
    *("balance_residual", "balance_unknown", "balance_entry"),
)


class MatrixPattern(ctypes.Structure):
    """rn_pattern."""

    _fields_ = (
        *((name, ctypes.c_int) for name in ("n", "inner")),
        *((name, ctypes.c_void_p) for name in ("column_end", "row", "order", "diagonal")),
    )


class NetworkTables(ctypes.Structure):
    """rn_network."""

    _fields_ = (
        ("calls", CallTables),
        ("pattern", MatrixPattern),
        *((name, ctypes.c_int) for name in NETWORK_SIZES),
        *((name, ctypes.c_void_p) for name in (*NETWORK_INTEGERS, "sign")),
    )


class NetworkProblem(ctypes.Structure):
    """rn_problem."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("values", "scale", "weight", "target", "anchor")),
        *((name, ctypes.c_double) for name in ("damping", "shortest")),
        *((name, ctypes.c_int) for name in ("iterations", "rates")),
    )


FAILURES = {
    1: "The equations are singular",
    2: "Newton's method makes no progress",
    3: "Newton's method has not converged in {iterations} iterations",
    4: "The memory is too small",
}


def network_library() -> ctypes.CDLL:
    """The compiled core. Raises CompilerError, WriteError."""
    pointer = ctypes.c_void_p
    functions = {
        "rn_evaluate": (None, *(pointer,) * 2),
        "rn_matrix": (None, *(pointer,) * 4),
        "rn_pivots": (ctypes.c_int, *(pointer,) * 4),
        "rn_solve": (ctypes.c_int, *(pointer,) * 5),
    }
    return core_library(FILES, functions)
