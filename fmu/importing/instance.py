"""An open instance of an FMU: calls for FMI 2.0 and 3.0, and their errors."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Callable, Mapping, Sequence
from ctypes import byref
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy import fmi2 as binding2, fmi3 as binding3
from fmpy.fmi1 import FMICallException

from ropeway.fmu.errors import FmuError, FmuImportError, FmuRunError, FmuVariableError
from ropeway.fmu.importing.input_ramps import InputRamp
from ropeway.fmu.importing.interface import FmuInterface
from ropeway.fmu.importing.loading import (
    KeptWorkingFolder,
    close_library,
    loaded,
    release,
    reserve,
    restored_working_folder,
)
from ropeway.fmu.importing.variable_access import Access, Group
from ropeway.fmu.importing.variable_types import Value
from ropeway.systems.interrupts import stop_if_interrupted

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
KEPT = 1000
"""Messages that are kept at least."""


def require_kind(fmu: FmuInterface, kind: str) -> None:
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

    `time`: its last communication point or event [s]; `ended`: why the FMU ended the run, or None; `log`: its last
    messages, of `noted` ones in all; `interpolated`: inputs that may be linear within a step; `ramped`: they are.
    `folder`: where it is unpacked; by default it is unpacked into a folder of its own, which `close` removes. Raises
    FmuImportError.
    """

    def __init__(self, fmu: FmuInterface, name: str, kind: str, folder: Path | None = None) -> None:
        require_kind(fmu, kind)
        self.fmu, self.name = fmu, name
        self.log: list[str] = []
        self.noted = 0
        self.time = 0.0
        self.ended: str | None = None
        description = fmu.description
        section = description.modelExchange if kind == "ModelExchange" else description.coSimulation
        self.keeps_states = bool(section.canGetAndSetFMUstate)
        self._three = fmu.fmi != "2.0"
        self._ramp, self.ramped = InputRamp(), False
        self.interpolated = _interpolated(fmu, section) if kind == "CoSimulation" else frozenset()
        self.differentiates = bool(section.providesDirectionalDerivative)
        self.varies_steps = bool(getattr(section, "canHandleVariableCommunicationStepSize", True))
        self._worst = 0
        self._open = self._running = False
        self._stop: float | None = None
        self._fmu: Any = None
        reserve(fmu, section)
        own = tempfile.mkdtemp(prefix="ropeway-") if folder is None else None
        self._cleared = weakref.finalize(self, _clear, fmu, own)
        try:
            if own is not None:
                fmu.unpack(own)
            with restored_working_folder():
                self._fmu = loaded(
                    kind,
                    self._three,
                    guid=description.guid or description.instantiationToken,
                    unzipDirectory=str(own or folder),
                    modelIdentifier=section.modelIdentifier,
                    instanceName=name,
                )
                self._instantiate()
        except FmuError:
            self._cleared()
            raise
        except Exception as error:
            close_library(self._fmu)
            self._cleared()
            tool = "It needs the tool that exported it" if section.needsExecutionTool else ""
            raise FmuImportError(f"{fmu.path.name} cannot be instantiated: {error}{self._log_tail()}", tool) from error
        self._access = Access(fmu, self._fmu, self._three)
        self._open = True

    def _instantiate(self) -> None:
        if self._three:
            log: dict[str, Any] = {"logMessage": lambda _, status, category, text: self._note(status, text)}
            if self.interpolated:
                inputs = [self.fmu.entries[name].reference for name in self.interpolated]
                log |= {"intermediateUpdate": self._ramp.update, "requiredIntermediateVariables": inputs}
            self._fmu.instantiate(**log)
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
            self.noted += 1
            self.log.append(text.decode(errors="replace"))
            if len(self.log) > 2 * KEPT:
                del self.log[:KEPT]

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
        with KeptWorkingFolder():
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
        with KeptWorkingFolder():
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
            for place, value in zip(group.places, self._shown(group, self._access.read), strict=True):
                found[place] = value
        return found

    def get(self, names: Sequence[str]) -> np.ndarray:
        """Values of numbers, of Booleans 0 and 1. Raises FmuRunError, FmuVariableError."""
        groups = self._access.groups(tuple(names))
        if len(groups) == 1:
            return np.array(self._shown(groups[0], self._access.numbers), dtype=float)
        values = np.zeros(len(names))
        for group in groups:
            values[group.places] = self._shown(group, self._access.numbers)
        return values

    def _shown(self, group: Group, read: Callable[[Group], Any]) -> Any:
        try:
            return read(group)
        except FMICallException as error:
            raise self._refused(f"the values of {group.label}", error) from error

    def ramp(self, start: Mapping[str, float], rates: Mapping[str, float]) -> None:
        """Values of inputs now, and their rates in the next step. Raises FmuRunError."""
        self.set(start)
        self.ramped = any(rates[name] for name in start)
        where = self._access.references(start)
        if self._three:
            lines = zip(start.values(), (rates[n] for n in start), strict=True)
            self._ramp.begin(self._fmu, self.time, dict(zip(where, lines, strict=True)))
        else:
            slopes = [rates[n] for n in start]
            self.call("rates of inputs", "setRealInputDerivatives", where, [1] * len(where), slopes)

    def derivative(self, outputs: Sequence[str], name: str) -> np.ndarray:
        """Derivatives of scalar variables by an input. Raises FmuRunError."""
        arguments = self._access.references(outputs), self._access.references([name]), [1.0]
        return np.array(self.call("directional derivatives", "getDirectionalDerivative", *arguments), dtype=float)

    def do_step(self, size: float) -> None:
        """A step of Co-Simulation, shorter where the FMU ends the run. Raises FmuRunError, Interrupted."""
        goal = self.time + size
        if self._stop is not None and abs(goal - self._stop) <= 1e-9 * size:
            goal = self._stop  # rounding must not take a sum of steps beyond the stop time
        try:
            self._step_to(goal, size)
        finally:
            refusal = self._ramp.end()
        if refusal is not None:
            raise self._refused("values for its inputs within a step", refusal)

    def _step_to(self, goal: float, size: float) -> None:
        while goal - self.time > 1e-9 * size:
            stop_if_interrupted()
            with KeptWorkingFolder():
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
        """Terminates and frees the instance, and closes its library; after a fatal error no call is allowed."""
        if not self._open:
            return
        self._open = False
        with KeptWorkingFolder():
            if self._running and self._worst < _ERROR:
                try:
                    self._fmu.terminate()
                except FMICallException:
                    self.log.append("Termination failed")
            if self._worst < _FATAL:
                self._fmu.freeInstance()
            else:
                close_library(self._fmu)
        self._cleared()


def _interpolated(fmu: FmuInterface, section: Any) -> frozenset[str]:
    """Inputs that may be linear within a step of Co-Simulation: scalars of double precision."""
    three = fmu.fmi != "2.0"
    if not getattr(section, "providesIntermediateUpdate" if three else "canInterpolateInputs"):
        return frozenset()
    known = {v.valueReference for v in fmu.description.modelVariables if v.intermediateUpdate or not three}
    inputs = {n: e for n, e in fmu.entries.items() if e.causality == "input" and e.continuous}
    return frozenset(
        n for n, e in inputs.items() if e.size == 1 and e.type in ("Real", "Float64") and e.reference in known
    )


def _clear(fmu: FmuInterface, folder: str | None) -> None:
    release(fmu)
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)
