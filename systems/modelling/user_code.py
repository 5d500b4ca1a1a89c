"""The user's code that calls this package, for messages."""

from __future__ import annotations

import inspect
from pathlib import Path

_COMMAND_LINE = ("typer", "click")
_PACKAGE = str(Path(__file__).parents[2])


def caller() -> str:
    """File and line of the first frame outside this package; "" on the command line."""
    frame = inspect.currentframe()
    while frame is not None:
        if str(frame.f_globals.get("__name__", "")).split(".")[0] in _COMMAND_LINE:
            return ""
        path = frame.f_code.co_filename
        inside = path.startswith(_PACKAGE) and not path.startswith(
            tuple(f"{_PACKAGE}/{d}/" for d in ("tests", "examples", "benchmarks"))
        )
        if not inside:
            return f"{path}:{frame.f_lineno}"
        frame = frame.f_back
    return ""
