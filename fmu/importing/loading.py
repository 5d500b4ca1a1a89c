"""Loading the binary of an FMU into this process, and closing it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Lock
from typing import Any

from fmpy import fmi2 as binding2, fmi3 as binding3

from ropeway.fmu.errors import FmuImportError
from ropeway.fmu.importing.interface import FmuInterface

_CLASSES = {
    ("CoSimulation", False): binding2.FMU2Slave,
    ("ModelExchange", False): binding2.FMU2Model,
    ("CoSimulation", True): binding3.FMU3Slave,
    ("ModelExchange", True): binding3.FMU3Model,
}
_LOADING = Lock()
_SINGLE: set[Path] = set()
"""Open FMUs that allow one instance in a process."""


def loaded(kind: str, three: bool, **arguments: Any) -> Any:
    """FMPy's object of an FMU. If the library lacks functions, it is closed."""
    made = _CLASSES[kind, three].__new__(_CLASSES[kind, three])
    try:
        made.__init__(**arguments)
    except BaseException:
        close_library(made)
        raise
    return made


def close_library(made: Any) -> None:
    """Closes the library of FMPy's object, if it is open."""
    if getattr(made, "dll", None) is not None:
        made.freeLibrary()
        made.dll = None


def reserve(fmu: FmuInterface, section: Any) -> None:
    """Counts an instance. Raises FmuImportError if the FMU allows one in a process, and has it."""
    if not section.canBeInstantiatedOnlyOncePerProcess:
        return
    with _LOADING:
        if fmu.path in _SINGLE:
            raise FmuImportError(
                f"{fmu.path.name} allows one instance in a process, and has it",
                "Run each in a process of its own: isolated=True",
            )
        _SINGLE.add(fmu.path)


def release(fmu: FmuInterface) -> None:
    """The FMU has no instance any more."""
    _SINGLE.discard(fmu.path)


@contextmanager
def restored_working_folder() -> Iterator[None]:
    """Around the loading of a library: FMPy enters its folder, and stays there on failure.

    Threads share one working folder, hence the lock.
    """
    with _LOADING:
        folder = os.getcwd()
        try:
            yield
        finally:
            os.chdir(folder)


class KeptWorkingFolder:
    """Around a call of an FMU, which may change the working folder; nothing is done while a thread loads a library."""

    __slots__ = ("_before",)
    _before: str | None

    def __enter__(self) -> None:
        self._before = None
        with suppress(OSError):  # the folder may have been removed
            self._before = None if _LOADING.locked() else os.getcwd()

    def __exit__(self, *_: object) -> None:
        with suppress(OSError):
            if self._before is not None and not _LOADING.locked() and os.getcwd() != self._before:
                os.chdir(self._before)
