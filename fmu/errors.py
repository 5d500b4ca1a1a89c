"""Error types of FMUs: each names the file, and the variable if any."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ropeway.components.errors import RopewayError

if TYPE_CHECKING:
    import pandas as pd


class FmuError(RopewayError):
    """Base class of the errors of FMUs.

    Attributes
    ----------
    variable : str or None
        The variable concerned.
    """

    def __init__(self, cause: str, remedy: str = "", variable: str | None = None) -> None:
        self.variable = variable
        super().__init__(cause, remedy)


class FmuExportError(FmuError):
    """An FMU could not be exported, for example because the C compiler is missing or failed."""


class FmuImportError(FmuError):
    """A file is not an FMU that can be used here: no zip archive, an unknown FMI version, no binary."""


class FmuVariableError(FmuError, KeyError):
    """An unknown variable, or one that does not fit in causality, type or unit."""

    def __str__(self) -> str:  # KeyError shows the repr of its arguments
        return Exception.__str__(self)


class FmuRunError(FmuError):
    """An FMU rejected a call during a run; the cause ends with its log messages.

    Attributes
    ----------
    time : float
        Time of the call [s].
    fatal : bool
        Whether the instance is no longer usable.
    result : DataFrame or None
        The rows of a co-simulation up to that time.
    """

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
