"""What can go wrong, as types. Each error carries its cause and the remedy, in the user's terms."""

from __future__ import annotations

import copy
import pickle
from typing import Any


class _Portable(BaseException):
    """An exception that pickles and copies with all its attributes, whatever its `__init__` takes.

    Python would call the class with `args`, which are the message alone; a process pool waits for ever for an
    error that it cannot rebuild.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        kept = {name: value for name, value in self.__dict__.items() if _pickles(value)}
        lost = [name for name in self.__dict__ if name not in kept]
        if lost:
            notes = [f"{name} is not here: it cannot be sent to another process" for name in lost]
            kept = {**kept, **dict.fromkeys(lost), "__notes__": [*kept.get("__notes__", []), *notes]}
        return _rebuilt, (type(self), self.args, kept)

    def __copy__(self) -> _Portable:
        return _rebuilt(type(self), self.args, self.__dict__)

    def __deepcopy__(self, memo: dict[int, Any]) -> _Portable:
        return _rebuilt(type(self), self.args, copy.deepcopy(self.__dict__, memo))


def _rebuilt(kind: type[_Portable], arguments: tuple[Any, ...], attributes: dict[str, Any]) -> _Portable:
    error = kind.__new__(kind)
    error.args = arguments
    error.__dict__.update(attributes)
    return error


def _pickles(value: object) -> bool:
    """Whether a value can be pickled and read again. Its own code decides that, so any exception says no."""
    try:
        pickle.loads(pickle.dumps(value))
    except Exception:  # noqa: BLE001
        return False
    return True


class Interrupted(_Portable, KeyboardInterrupt):
    """The user has interrupted a call (Ctrl-C). `result`: what the call has found so far, None where that is nothing.

    It is a `KeyboardInterrupt`, so that `except Exception` and `except RopewayError` let it pass.
    """

    def __init__(self, message: str = "Interrupted", result: object = None) -> None:
        self.result = result
        super().__init__(message)


class RopewayError(_Portable, Exception):
    """Any error of this library: `cause` says what is wrong, `remedy` what to do about it."""

    def __init__(self, cause: str, remedy: str = "") -> None:
        self.cause = cause
        self.remedy = remedy
        super().__init__(f"{cause}. {remedy}".strip() if remedy else cause)


class RopewayWarning(UserWarning):
    """A result that is right, and that a user should not build on: it says why."""


class InputError(RopewayError, ValueError):
    """A value that no component or system can have. Raised before anything is built."""


class CompilerError(RopewayError):
    """There is no C compiler, or it failed: its messages are in the cause."""


class UnbalancedSystemError(InputError):
    """Equations and unknowns of a system do not match: a port left open, or an over-determined one."""


class WriteError(RopewayError, OSError):
    """A file could not be written: the disk is full, the folder is read-only. What was there before is unchanged."""


class UnknownNameError(InputError, KeyError):
    """A name that the system does not have."""

    def __str__(self) -> str:  # KeyError would show the repr of its arguments
        return Exception.__str__(self)


class SlackRopeError(RopewayError):
    """The rope is too long, or its tension too low, to hang between its supports as asked."""


class EquilibriumError(RopewayError):
    """No valid equilibrium was found. `component` names the one with the worst residual, if any."""

    def __init__(self, cause: str, remedy: str = "", component: str | None = None) -> None:
        self.component = component
        super().__init__(cause, remedy)


class OutOfReachError(EquilibriumError):
    """A place where the carriage cannot be: `limit` says in two words what keeps it from there."""

    def __init__(self, cause: str, remedy: str, component: str, limit: str) -> None:
        self.limit = limit
        super().__init__(cause, remedy, component)


class CompiledError(InputError):
    """The compiled core cannot do what is asked of it."""


class SimulationError(RopewayError):
    """A simulation stopped before its end. `result` holds everything up to `time` [s], None where there was no run."""

    def __init__(self, cause: str, remedy: str = "", time: float | None = None, result: object = None) -> None:
        self.time = time
        self.result = result
        super().__init__(cause, remedy)

    def __str__(self) -> str:
        return super().__str__() if self.time is None else f"At t = {self.time:.6g} s: {super().__str__()}"


class WorkerError(RopewayError):
    """Workers of a long study were lost. `result`: a table of the cases finished so far."""

    def __init__(self, cause: str, remedy: str = "", result: object = None) -> None:
        self.result = result
        super().__init__(cause, remedy)


class ScheduleError(RopewayError):
    """No schedule was found, or none that its simulation bears out. `plan` is the last one, if any."""

    def __init__(self, cause: str, remedy: str = "", plan: object = None) -> None:
        self.plan = plan
        super().__init__(cause, remedy)


class InfeasibleScheduleError(ScheduleError):
    """No schedule satisfies all limits. `relaxation`: the smallest change of each limit that would do, by
    name, in its unit; `colliding`: a table of the limits that then bind, with component and time [s]."""

    def __init__(self, cause: str, remedy: str, relaxation: object, colliding: object) -> None:
        self.relaxation = relaxation
        self.colliding = colliding
        super().__init__(cause, remedy)
