"""A slave: an FMU advanced by its own solver (Co-Simulation) or by an integrator of this library (Model Exchange)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.fmu.errors import FmuVariableError
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.isolated_slave import IsolatedSlave
from ropeway.fmu.importing.local_slave import LocalSlave
from ropeway.fmu.importing.variable_types import Value


class OpenFmu:
    """An open FMU; close it, or use it with `with`.

    `can_restore`: it can restore an earlier state; `can_interpolate`: its inputs may be linear within a step. Raises
    FmuImportError.
    """

    def __init__(self, fmu: Fmu, name: str = "slave", kind: str = "CoSimulation", tolerance: float = 1e-8) -> None:
        self.fmu, self.name, self.kind = fmu, name, kind
        kind_of_slave = IsolatedSlave if fmu.isolated else LocalSlave
        self._slave: IsolatedSlave | LocalSlave = kind_of_slave(fmu, name, kind, tolerance)
        self.can_restore, self.can_interpolate = self._slave.can_restore, self._slave.can_interpolate

    @property
    def time(self) -> float:
        """Its time [s]."""
        return self._slave.time

    @property
    def ended(self) -> str | None:
        """Why the FMU ended the run; None if it has not."""
        return self._slave.ended

    @property
    def varies_steps(self) -> bool:
        """Whether its steps may have different lengths."""
        return self._slave.varies_steps

    @property
    def log(self) -> list[str]:
        """Its warnings and errors."""
        return self._slave.log

    def enter(self, start: float, values: Mapping[str, object], stop: float | None = None) -> None:
        """Set start values and begin the initialisation.

        Parameters
        ----------
        start : float
            Start time [s].
        values : mapping of str
            Start values by name.
        stop : float, optional
            End time of the run [s].

        Raises
        ------
        FmuRunError
            The FMU rejected the call.
        FmuVariableError
            An unknown variable, or a value of the wrong type.
        """
        self._slave.enter(start, values, stop)

    def leave(self) -> None:
        """End the initialisation.

        Raises
        ------
        FmuRunError
            The FMU rejected the call.
        """
        self._slave.leave()

    def set(self, values: Mapping[str, object]) -> None:
        """Set variables; discrete ones cause an event in Model Exchange.

        An FMU that ended the run keeps its values.

        Parameters
        ----------
        values : mapping of str
            Values by name.

        Raises
        ------
        FmuRunError
            The FMU rejected the call.
        FmuVariableError
            An unknown variable, or a value of the wrong type.
        """
        self._slave.set(values)

    def read(self, names: Sequence[str]) -> list[Value]:
        """Read variables of any type.

        Parameters
        ----------
        names : sequence of str
            Names of variables.

        Returns
        -------
        list
            Their values.

        Raises
        ------
        FmuRunError
            The FMU rejected the call.
        FmuVariableError
            An unknown variable, or a value of the wrong type.
        """
        return self._slave.read(names)

    def get(self, names: Sequence[str]) -> np.ndarray:
        """Read numbers and Booleans.

        Parameters
        ----------
        names : sequence of str
            Names of variables.

        Returns
        -------
        ndarray
            Their values; Booleans as 0 and 1.

        Raises
        ------
        FmuRunError
            The FMU rejected the call.
        FmuVariableError
            An unknown variable, or a value of the wrong type.
        """
        return self._slave.get(names)

    def derivatives(self, outputs: Sequence[str], inputs: Mapping[str, float]) -> np.ndarray:
        """Derivatives of outputs by inputs.

        Directional derivatives of the FMU if it has them, otherwise finite differences.

        Parameters
        ----------
        outputs : sequence of str
            Names of outputs.
        inputs : mapping of str to float
            Values of the inputs around which to differentiate.

        Returns
        -------
        ndarray, shape (outputs, inputs)
            The derivatives.

        Raises
        ------
        FmuRunError
            The FMU rejected the call.
        """
        if not inputs:
            return np.empty((len(outputs), 0))
        return self._slave.derivatives(outputs, inputs)

    def step(self, size: float, start: Mapping[str, float], end: Mapping[str, float]) -> None:
        """Advance by a step; it ends early if the FMU ends the run, see `ended`.

        Inputs are linear from `start` to `end` if the FMU supports that, otherwise constant at their mean; discrete
        inputs keep their value at the start.

        Parameters
        ----------
        size : float
            Step [s].
        start, end : mapping of str to float
            Values of the inputs at the start and at the end of the step.

        Raises
        ------
        FmuRunError
            The FMU rejected the call.
        """
        self._slave.step(size, start, end)

    def save(self) -> Any:
        """Save the state; free it with `forget`.

        Returns
        -------
        object
            For `restore`.

        Raises
        ------
        InputError
            The FMU cannot save its state.
        FmuRunError
            The FMU rejected the call.
        """
        if not self.can_restore:
            raise InputError(f"{self.name!r} cannot restore its state", "Couple it without iteration")
        return self._slave.save()

    def restore(self, state: Any) -> None:
        """Restore a saved state. Raises FmuRunError."""
        self._slave.restore(state)

    def forget(self, state: Any) -> None:
        """Frees a saved state."""
        self._slave.forget(state)

    def close(self) -> None:
        """Close the instance."""
        self._slave.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@checked
class Slave(OpenFmu):
    """An open FMU; close it, or use it with `with`. Its calls check their arguments.

    `can_restore`: it can restore an earlier state; `can_interpolate`: its inputs may be linear within a step.

    Parameters
    ----------
    fmu : Fmu
        The FMU.
    name : str, default "slave"
        Name in messages.
    kind : {"CoSimulation", "ModelExchange"}, default "CoSimulation"
        How it is advanced.
    tolerance : float, default 1e-8
        Tolerance of the integrator in Model Exchange.

    Raises
    ------
    FmuImportError
        The FMU cannot be used on this platform, or in this way.

    Examples
    --------
    >>> slave = rw.fmu.Slave(rw.fmu.load("span.fmu"))
    >>> slave.name
    'slave'
    """

    __init__ = OpenFmu.__init__
    enter, set, read, get = OpenFmu.enter, OpenFmu.set, OpenFmu.read, OpenFmu.get
    derivatives, step = OpenFmu.derivatives, OpenFmu.step


def require_causality(fmu: Fmu, name: str, causality: str) -> None:
    """Raises FmuVariableError unless a variable is real and of this causality."""
    require_connectable(fmu, name, causality, ("Real",))


def require_connectable(
    fmu: Fmu,
    name: str,
    causality: str,
    kinds: Sequence[str] = ("Real", "Boolean", "Integer", "Enumeration", "String", "Binary"),
) -> None:
    """Raises FmuVariableError unless a variable has this causality, one of these kinds and no clock."""
    entry = fmu.entry(name)
    if entry.causality != causality or entry.kind not in kinds or entry.clocked:
        what = f"{'clocked ' if entry.clocked else ''}{entry.kind}"
        choice = [n for n in fmu.names(causality, *kinds) if not fmu.entries[n].clocked]
        wanted = f"a Real {causality}" if len(kinds) == 1 else f"an {causality} that can be connected"
        raise FmuVariableError(
            f"{name!r} of {fmu.path.name} is a {what} of causality {entry.causality!r}, not {wanted}",
            f"Choose from {', '.join(choice[:12]) or 'none'}",
            name,
        )
