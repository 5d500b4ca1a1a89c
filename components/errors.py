"""Error types. Each has a cause and a remedy in the user's terms."""

from __future__ import annotations

import copy
import pickle
from typing import Any


class _Portable(BaseException):
    """An exception that can be pickled and copied with all its attributes, whatever the arguments of its `__init__`.

    Python would call the class with `args`, which holds the message only. A process pool that receives an error that it
    cannot rebuild never returns.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        kept = {name: value for name, value in self.__dict__.items() if _pickles(value)}
        lost = [name for name in self.__dict__ if name not in kept]
        if lost:
            notes = [f"{name} was dropped: it cannot be sent to another process" for name in lost]
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
    """Whether a value can be pickled and unpickled. User code runs here, so any exception counts as no."""
    try:
        pickle.loads(pickle.dumps(value))
    except Exception:  # noqa: BLE001
        return False
    return True


class Interrupted(_Portable, KeyboardInterrupt):
    """The user interrupted a call (Ctrl-C).

    A `KeyboardInterrupt`, so `except Exception` and `except RopewayError` do not catch it.

    Attributes
    ----------
    result : object
        Results of the call up to the interrupt; None if there are none.
    """

    def __init__(self, message: str = "Interrupted", result: object = None) -> None:
        self.result = result
        super().__init__(message)


class RopewayError(_Portable, Exception):
    """Base class of all errors of this library.

    Attributes
    ----------
    cause : str
        What is wrong.
    remedy : str
        How to correct it.
    """

    def __init__(self, cause: str, remedy: str = "") -> None:
        self.cause = cause
        self.remedy = remedy
        super().__init__(f"{cause}. {remedy}".strip() if remedy else cause)


class RopewayWarning(UserWarning):
    """The result is correct, but it is not safe to build or needs the user's attention."""


class InputError(RopewayError, ValueError):
    """Invalid input. Raised before anything is solved.

    Examples
    --------
    >>> rw.Sheave("s1", at=(100.0, 5.0), friction=-0.02)
    Traceback (most recent call last):
        ...
    ropeway.components.errors.InputError: Sheave 's1': friction is -0.02. Give a number of zero or more
    """


class CompilerError(RopewayError):
    """The C compiler is missing, or it failed; the cause contains its messages."""


class UnbalancedSystemError(InputError):
    """Numbers of equations and unknowns differ: an open port, or an over-determined system.

    Examples
    --------
    >>> rw.equilibrium(line, given={"c1.tension_in": 50e3})
    Traceback (most recent call last):
        ...
    ropeway.components.errors.UnbalancedSystemError: given has 1 values, solve_for 0 names. Name one quantity
    in solve_for for each value in given
    """


class WriteError(RopewayError, OSError):
    """A file could not be written (full disk, no permission). An earlier version of the file is unchanged.

    Examples
    --------
    >>> rw.Schedule([0.0, 10.0], [0.5, 1.0]).to_csv("no folder/start.csv")
    Traceback (most recent call last):
        ...
    ropeway.components.errors.WriteError: no folder/start.csv cannot be written: No such file or
    directory. Choose a folder with write permission and free space
    """


class UnknownNameError(InputError, KeyError):
    """A name that the system does not have.

    Examples
    --------
    >>> rw.equilibrium(line)["c1.tension_inn"]
    Traceback (most recent call last):
        ...
    ropeway.components.errors.UnknownNameError: 'c1.tension_inn' is not in system 'mono-cable line'. Did
    you mean c1.tension_in, c1.tension_out, c1.differential_tension, c1.bearing_load, c1.support_force,
    c1.wrap, c1.drive_force, c1.power, c1.grip_margin, c1.travel, c1.speed, c1.x?
    """

    def __str__(self) -> str:  # KeyError shows the repr of its arguments
        return Exception.__str__(self)


class SlackRopeError(RopewayError):
    """The rope is too long, or its tension too low, to hang between its supports.

    Examples
    --------
    >>> s = rw.System("slack")
    >>> s.string(rope, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(100.0, 0.0)), tension=1.0)
    Traceback (most recent call last):
        ...
    ropeway.components.errors.SlackRopeError: 1 N at 'a_b' is too low for the weight of the rope in that
    span. Raise the tension or add a support
    """


class EquilibriumError(RopewayError):
    """No valid equilibrium was found.

    Attributes
    ----------
    component : str or None
        The component with the largest residual.
    """

    def __init__(self, cause: str, remedy: str = "", component: str | None = None) -> None:
        self.component = component
        super().__init__(cause, remedy)


class OutOfReachError(EquilibriumError):
    """The carriage cannot reach a station.

    Attributes
    ----------
    limit : str
        The condition that limits its path, in two words.
    """

    def __init__(self, cause: str, remedy: str, component: str, limit: str) -> None:
        self.limit = limit
        super().__init__(cause, remedy, component)


class CompiledError(InputError):
    """The compiled core does not support this system or question."""


class SimulationError(RopewayError):
    """A simulation failed before its end time.

    Attributes
    ----------
    time : float or None
        Time of the failure [s].
    result : Result or None
        The results up to that time.
    """

    def __init__(self, cause: str, remedy: str = "", time: float | None = None, result: object = None) -> None:
        self.time = time
        self.result = result
        super().__init__(cause, remedy)

    def __str__(self) -> str:
        return super().__str__() if self.time is None else f"At t = {self.time:.6g} s: {super().__str__()}"


class DesignPointError(RopewayError):
    """The search for the most probable failure did not converge, or the study fails on its way.

    Examples
    --------
    >>> from scipy.stats import norm
    >>> rw.reliability(lambda load: 5.0, rw.Uncertain({"load": norm(10.0, 2.0)}), above=6.0)
    Traceback (most recent call last):
        ...
    ropeway.components.errors.DesignPointError: The result does not change with the inputs at 0 standard
    deviations from their medians. Name inputs that it depends on; where it is flat, or never passes the limit,
    sweep cases and use rw.exceedance
    """


class FitError(RopewayError):
    """A fit to measured values did not converge."""


class WorkerError(RopewayError):
    """Worker processes of a study were lost.

    Attributes
    ----------
    result : DataFrame or None
        The completed cases.
    """

    def __init__(self, cause: str, remedy: str = "", result: object = None) -> None:
        self.result = result
        super().__init__(cause, remedy)


class ScheduleError(RopewayError):
    """No schedule was found, or its simulation does not confirm it.

    Attributes
    ----------
    plan : SchedulePlan or None
        The last plan.
    """

    def __init__(self, cause: str, remedy: str = "", plan: object = None) -> None:
        self.plan = plan
        super().__init__(cause, remedy)


class InfeasibleScheduleError(ScheduleError):
    """No schedule satisfies all limits.

    Attributes
    ----------
    relaxation : dict of str to float
        The smallest relaxation of each limit that makes the problem feasible, in the unit of the limit.
    colliding : DataFrame
        The limits that are then active, with component and time [s].
    """

    def __init__(self, cause: str, remedy: str, relaxation: object, colliding: object) -> None:
        self.relaxation = relaxation
        self.colliding = colliding
        super().__init__(cause, remedy)
