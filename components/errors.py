"""What can go wrong, as types. Each error carries its cause and the remedy, in the user's terms."""


class RopewayError(Exception):
    """Any error of this library: `cause` says what is wrong, `remedy` what to do about it."""

    def __init__(self, cause: str, remedy: str = "") -> None:
        self.cause = cause
        self.remedy = remedy
        super().__init__(f"{cause}. {remedy}".strip() if remedy else cause)


class RopewayWarning(UserWarning):
    """A result that is right, and that a user should not build on: it says why."""


class InputError(RopewayError, ValueError):
    """A value that no component or system can have. Raised before anything is built."""


class UnbalancedSystemError(InputError):
    """Equations and unknowns of a system do not match: a port left open, or too much said."""


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


class SimulationError(RopewayError):
    """A simulation stopped before its end. `result` holds everything up to `time` [s], None where there was no run."""

    def __init__(self, cause: str, remedy: str = "", time: float | None = None, result: object = None) -> None:
        self.time = time
        self.result = result
        super().__init__(cause, remedy)

    def __str__(self) -> str:
        return super().__str__() if self.time is None else f"At t = {self.time:.6g} s: {super().__str__()}"


class ScheduleError(RopewayError):
    """No schedule was found, or none that its simulation bears out. `plan` is the last one, if any."""

    def __init__(self, cause: str, remedy: str = "", plan: object = None) -> None:
        self.plan = plan
        super().__init__(cause, remedy)


class InfeasibleScheduleError(ScheduleError):
    """Limits that no schedule keeps together. `relaxation`: the smallest change of each limit that would do, by
    name, in its unit; `colliding`: a table of the limits that then bind, with component and time [s]."""

    def __init__(self, cause: str, remedy: str, relaxation: object, colliding: object) -> None:
        self.relaxation = relaxation
        self.colliding = colliding
        super().__init__(cause, remedy)
