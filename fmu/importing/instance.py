"""An open instance of an FMU: calls for FMI 2.0 and 3.0, and their errors."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from ctypes import byref
from threading import Lock
from typing import Any

import fmpy
import numpy as np
from fmpy import fmi2 as binding2, fmi3 as binding3
from fmpy.fmi1 import FMICallException

from ropeway.fmu.errors import FmuImportError, FmuRunError, FmuVariableError
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.variable_access import Access, Group
from ropeway.fmu.importing.variable_types import Value
from ropeway.systems.interrupts import stop_if_interrupted

_CLASSES = {
    ("CoSimulation", False): binding2.FMU2Slave,
    ("ModelExchange", False): binding2.FMU2Model,
    ("CoSimulation", True): binding3.FMU3Slave,
    ("ModelExchange", True): binding3.FMU3Model,
}
_IN_3 = {
    "getFMUstate": "getFMUState",
    "setFMUstate": "setFMUState",
    "freeFMUstate": "freeFMUState",
    "getDerivatives": "getContinuousStateDerivatives",
    "newDiscreteStates": "updateDiscreteStates",
}
"""Methods with another name in FMI 3.0."""
_DISCARD, _ERROR, _FATAL = 2, 3, 4
_LAST_SUCCESSFUL_TIME, _TERMINATED = 2, 3
"""Status kinds of FMI 2.0."""


_LOADING = Lock()


def require_kind(fmu: Fmu, kind: str) -> None:
    """Raises FmuImportError unless an FMU supports a kind ("ModelExchange", "CoSimulation") on this platform."""
    if fmu.kinds == ("ScheduledExecution",):
        raise FmuImportError(
            f"{fmu.path.name} supports ScheduledExecution only, which requires a scheduler for its clocks",
            "Export it for CoSimulation or ModelExchange",
        )
    if kind not in fmu.kinds:
        raise FmuImportError(
            f"{fmu.path.name} does not support {kind}", f"It supports {', '.join(fmu.kinds) or 'nothing'}"
        )
    if fmpy.platform not in fmu.platforms:
        raise FmuImportError(
            f"{fmu.path.name} has no binary for {fmpy.platform} (it has {', '.join(fmu.platforms) or 'none'})",
            "Export it for this platform",
        )


class Instance:
    """An open instance.

    `time`: its last communication point or event [s]; `ended`: why the FMU ended the run, or None; `log`: its messages.
    Raises FmuImportError.
    """

    def __init__(self, fmu: Fmu, name: str, kind: str) -> None:
        require_kind(fmu, kind)
        self.fmu, self.name = fmu, name
        self.log: list[str] = []
        self.time = 0.0
        self.ended: str | None = None
        description = fmu.description
        section = description.modelExchange if kind == "ModelExchange" else description.coSimulation
        self.keeps_states = bool(section.canGetAndSetFMUstate)
        self.interpolates = bool(getattr(section, "canInterpolateInputs", False))
        self.differentiates = bool(section.providesDirectionalDerivative)
        self.varies_steps = bool(getattr(section, "canHandleVariableCommunicationStepSize", True))
        self._three = fmu.fmi != "2.0"
        self._worst = 0
        self._open = self._running = False
        self._stop: float | None = None
        self._folder = tempfile.mkdtemp(prefix="ropeway-")
        try:
            fmpy.extract(str(fmu.path), unzipdir=self._folder)
            with _restored_working_folder():
                self._fmu: Any = _CLASSES[kind, self._three](
                    guid=description.guid or description.instantiationToken,
                    unzipDirectory=self._folder,
                    modelIdentifier=section.modelIdentifier,
                    instanceName=name,
                )
                self._instantiate()
        except Exception as error:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise FmuImportError(f"{fmu.path.name} cannot be instantiated: {error}{self._log_tail()}") from error
        self._access = Access(fmu, self._fmu, self._three)
        self._open = True

    def _instantiate(self) -> None:
        if self._three:
            self._fmu.instantiate(logMessage=lambda _, status, category, text: self._note(status, text))
            return
        self._callbacks = binding2.fmi2CallbackFunctions()
        self._callbacks.logger = binding2.fmi2CallbackLoggerTYPE(
            lambda _, name, status, category, text: self._note(status, text)
        )
        self._callbacks.allocateMemory = binding2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        self._callbacks.freeMemory = binding2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self._fmu.instantiate(callbacks=self._callbacks)

    def _note(self, status: int, text: bytes) -> None:
        if status > 0:
            self.log.append(text.decode(errors="replace"))

    def _log_tail(self) -> str:
        return f". Its log: {' | '.join(self.log[-3:])}" if self.log else ""

    def error(self, what: str, remedy: str, *, fatal: bool = False) -> FmuRunError:
        """An error with the instance's name, its time and its log."""
        cause = f"{self.name!r} ({self.fmu.path.name}) {what} at t = {self.time:.9g} s{self._log_tail()}"
        return FmuRunError(cause, remedy, time=self.time, fatal=fatal)

    def end(self) -> None:
        """Records that the FMU ended the run at `time`."""
        self.ended = f"{self.name!r} ({self.fmu.path.name}) ends the run at t = {self.time:.9g} s{self._log_tail()}"

    def call(self, what: str, method: str, *arguments: Any, **named: Any) -> Any:
        """Calls a function, by FMPy's name for FMI 2.0. Raises FmuRunError, Interrupted."""
        stop_if_interrupted()
        try:
            return getattr(self._fmu, _IN_3.get(method, method) if self._three else method)(*arguments, **named)
        except FMICallException as error:
            raise self._refused(what, error) from error

    def _refused(
        self, what: str, refusal: FMICallException, remedy: str = "Check its inputs at that time"
    ) -> FmuRunError:
        self._worst = max(self._worst, int(refusal.status))
        return self.error(f"rejected {what}", remedy, fatal=refusal.status == _FATAL)

    def enter(self, start: float, values: Mapping[str, object], stop: float | None = None) -> None:
        """Sets start values and begins the initialisation. Raises FmuRunError, FmuVariableError."""
        self.time, self._stop = start, stop
        taken = self.fmu.values(values)
        if self._three:
            if self.fmu.structure:
                self.call("other sizes", "enterConfigurationMode")
                self.set(self.fmu.structure)
                self.call("other sizes", "exitConfigurationMode")
            self.set(taken)
            self.call("the initialisation", "enterInitializationMode", startTime=start, stopTime=stop)
        else:
            self.call("the start time", "setupExperiment", startTime=start, stopTime=stop)
            self.set(taken)
            self.call("the initialisation", "enterInitializationMode")

    def leave(self) -> None:
        """Ends the initialisation. Raises FmuRunError."""
        self.call("the initialisation", "exitInitializationMode")
        self._running = True

    def set(self, values: Mapping[str, object]) -> None:
        """Sets variables. Raises FmuRunError, FmuVariableError."""
        for group in self._access.groups(tuple(values)):
            if self._running and group.fixed:
                raise FmuVariableError(
                    f"{group.fixed!r} of {self.fmu.path.name} is fixed: it cannot change during a run",
                    "Set it as a start value",
                    group.fixed,
                )
            try:
                self._access.write(group, values)
            except FMICallException as error:
                raise self._refused(f"values for {group.label}", error) from error

    def read(self, names: Sequence[str]) -> list[Value]:
        """Values of variables. Raises FmuRunError, FmuVariableError."""
        found: list[Value] = [0.0] * len(names)
        for group in self._access.groups(tuple(names)):
            for place, value in zip(group.places, self._shown(group), strict=True):
                found[place] = value
        return found

    def get(self, names: Sequence[str]) -> np.ndarray:
        """Values of numbers, of Booleans 0 and 1. Raises FmuRunError, FmuVariableError."""
        values = np.zeros(len(names))
        for group in self._access.groups(tuple(names)):
            values[group.places] = self._shown(group)
        return values

    def _shown(self, group: Group) -> list[Any]:
        try:
            return self._access.read(group)
        except FMICallException as error:
            raise self._refused(f"the values of {group.label}", error) from error

    def set_rates(self, rates: Mapping[str, float]) -> None:
        """Sets rates of inputs in the next step (FMI 2.0). Raises FmuRunError."""
        where = self._access.references(rates)
        self.call("rates of inputs", "setRealInputDerivatives", where, [1] * len(where), list(rates.values()))

    def derivative(self, outputs: Sequence[str], name: str) -> np.ndarray:
        """Derivatives of scalar variables by an input. Raises FmuRunError."""
        arguments = self._access.references(outputs), self._access.references([name]), [1.0]
        return np.array(self.call("directional derivatives", "getDirectionalDerivative", *arguments), dtype=float)

    def do_step(self, size: float) -> None:
        """A step of Co-Simulation, shorter where the FMU ends the run. Raises FmuRunError, Interrupted."""
        goal = self.time + size
        if self._stop is not None and abs(goal - self._stop) <= 1e-9 * size:
            goal = self._stop  # rounding must not take a sum of steps beyond the stop time
        while goal - self.time > 1e-9 * size:
            stop_if_interrupted()
            reached, ends = self._step_in_3(goal) if self._three else self._step_in_2(goal)
            if reached <= self.time and not ends:
                raise self.error("returned from a step without advancing", "Check its inputs at that time")
            self.time = goal if goal - reached <= 1e-9 * size else reached
            if ends:
                self.end()
                return
        self.time = goal

    def _no_step(self, size: float, refusal: FMICallException) -> FmuRunError:
        """An error for a failed step; a smaller step can help only if the FMU discarded it."""
        if refusal.status == _DISCARD and self.varies_steps:
            return self._refused(f"a step of {size:g} s", refusal, "Use a smaller step")
        return self._refused(f"a step of {size:g} s", refusal)

    def _step_in_2(self, goal: float) -> tuple[float, bool]:
        """One call; returns the time reached, and whether the FMU ended the run."""
        size = goal - self.time
        try:
            self._fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=size)
        except FMICallException as error:
            if error.status != _DISCARD or not self._status(self._fmu.getBooleanStatus, _TERMINATED):
                raise self._no_step(size, error) from error
            return min(max(self._status(self._fmu.getRealStatus, _LAST_SUCCESSFUL_TIME), self.time), goal), True
        return goal, False

    def _status(self, ask: Callable[[int], float], kind: int) -> float:
        try:
            return float(ask(kind))
        except FMICallException:  # few FMUs implement it
            return 0.0

    def _step_in_3(self, goal: float) -> tuple[float, bool]:
        """One call; returns the time reached, and whether the FMU ended the run."""
        size, fmu = goal - self.time, self._fmu
        event, end, early = binding3.fmi3Boolean(), binding3.fmi3Boolean(), binding3.fmi3Boolean()
        reached = binding3.fmi3Float64(self.time)
        returned = byref(event), byref(end), byref(early), byref(reached)
        try:
            fmu.fmi3DoStep(fmu.component, self.time, size, binding3.fmi3True, *returned)
        except FMICallException as error:
            if error.status != _DISCARD or not end.value:
                raise self._no_step(size, error) from error
        short = early.value or end.value
        return min(max(float(reached.value), self.time), goal) if short else goal, bool(end.value)

    def sizes(self) -> tuple[int, int]:
        """Numbers of continuous states and event indicators (Model Exchange). Raises FmuRunError."""
        if not self._three:
            described = self.fmu.description
            return int(described.numberOfContinuousStates), int(described.numberOfEventIndicators)
        names = "getNumberOfContinuousStates", "getNumberOfEventIndicators"
        states, indicators = (int(self.call("the number of its states", name)) for name in names)
        return states, indicators

    def save(self) -> Any:
        """A copy of the FMU's state; free it with `forget`. Raises FmuRunError."""
        return self.call("saving its state", "getFMUstate")

    def restore(self, state: Any) -> None:
        """Restores a state, at `time`. Raises FmuRunError."""
        self.call("restoring its state", "setFMUstate", state)

    def forget(self, state: Any) -> None:
        """Frees a saved state."""
        self.call("freeing a state", "freeFMUstate", state)

    def close(self) -> None:
        """Terminates and frees the instance; after a fatal error no call is allowed."""
        if not self._open:
            return
        self._open = False
        if self._running and self._worst < _ERROR:
            try:
                self._fmu.terminate()
            except FMICallException:
                self.log.append("Termination failed")
        if self._worst < _FATAL:
            self._fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)


@contextmanager
def _restored_working_folder() -> Iterator[None]:
    """Restores the working folder: FMPy enters the folder of a library to load it, and stays there on failure.

    Threads share one working folder, hence the lock.
    """
    with _LOADING:
        folder = os.getcwd()
        try:
            yield
        finally:
            os.chdir(folder)
