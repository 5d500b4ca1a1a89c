"""The user's code that calls this package, for messages."""

from __future__ import annotations

import inspect
from functools import cache
from pathlib import Path

_COMMAND_LINE = ("typer", "click")
_PACKAGE = str(Path(__file__).parents[2])


def caller() -> str:
    """File and line of the first frame outside this package; "" on the command line."""
    frame = inspect.currentframe()
    while frame is not None and _inside(frame.f_code.co_filename):
        frame = frame.f_back
    if frame is None or str(frame.f_globals.get("__name__", "")).split(".")[0] in _COMMAND_LINE:
        return ""
    return f"{frame.f_code.co_filename}:{frame.f_lineno}"


@cache
def _inside(path: str) -> bool:
    """Whether a file belongs to this package: a line of it is not the user's."""
    users = tuple(f"{_PACKAGE}/{d}/" for d in ("tests", "examples", "benchmarks"))
    return path.startswith(_PACKAGE) and not path.startswith(users)
