"""What can go wrong with an FMU, as types: each names the file, and the variable where there is one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ropeway.components.errors import RopewayError

if TYPE_CHECKING:
    import pandas as pd


class FmuError(RopewayError):
    """Any error of an FMU. `variable` is the one concerned, if any."""

    def __init__(self, cause: str, remedy: str = "", variable: str | None = None) -> None:
        self.variable = variable
        super().__init__(cause, remedy)


class FmuExportError(FmuError):
    """An FMU could not be made: no compiler, or one that failed (its messages are in the cause)."""


class FmuImportError(FmuError):
    """A file is not an FMU that can be used here: not a zip, an unknown FMI version, no binary."""


class FmuVariableError(FmuError, KeyError):
    """A variable that the FMU does not have, or that cannot be used like that: causality, type or unit."""

    def __str__(self) -> str:  # KeyError would show the repr of its arguments
        return Exception.__str__(self)


class FmuRunError(FmuError):
    """An FMU refused a call while it ran; the cause ends with what it logged. `time` [s] is when; `fatal`: it can
    never be used again; `result`: the rows of a co-simulation so far, None where there are none."""

    def __init__(
        self,
        cause: str,
        remedy: str = "",
        variable: str | None = None,
        *,
        time: float = 0.0,
        fatal: bool = False,
        result: pd.DataFrame | None = None,
    ) -> None:
        self.time, self.fatal, self.result = time, fatal, result
        super().__init__(cause, remedy, variable)
