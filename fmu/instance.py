"""An open instance of an FMU: its calls, alike for FMI 2.0 and 3.0, and what it says about them."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave

from ropeway.fmu.errors import FmuImportError, FmuRunError, FmuVariableError
from ropeway.fmu.imported import Fmu
from ropeway.systems.interrupts import stop_if_interrupted

_CLASSES = {
    ("CoSimulation", False): FMU2Slave,
    ("ModelExchange", False): FMU2Model,
    ("CoSimulation", True): FMU3Slave,
    ("ModelExchange", True): FMU3Model,
}
_IN_3 = {
    "setReal": "setFloat64",
    "setInteger": "setInt32",
    "getReal": "getFloat64",
    "getInteger": "getInt32",
    "getFMUstate": "getFMUState",
    "setFMUstate": "setFMUState",
    "freeFMUstate": "freeFMUState",
    "getDerivatives": "getContinuousStateDerivatives",
    "newDiscreteStates": "updateDiscreteStates",
}
"""Methods that FMI 3.0 has given another name."""
_FATAL = 4


def require_kind(fmu: Fmu, kind: str) -> None:
    """Raises FmuImportError unless an FMU is of a kind ("ModelExchange", "CoSimulation") and runs on this platform."""
    if kind not in fmu.kinds:
        raise FmuImportError(f"{fmu.path.name} is not for {kind}", f"It is for {', '.join(fmu.kinds)}")
    if fmpy.platform not in fmu.platforms:
        raise FmuImportError(
            f"{fmu.path.name} has no binary for {fmpy.platform} (it has {', '.join(fmu.platforms) or 'none'})",
            "Export it for this platform",
        )


class _Group(NamedTuple):
    """Variables of one kind, their places among those asked for, and their value references."""

    kind: str
    names: list[str]
    places: list[int]
    references: list[int]


class Instance:
    """An open instance. `time` is that of its last communication point or event [s]; `log` what it said. Raises
    FmuImportError."""

    def __init__(self, fmu: Fmu, name: str, kind: str) -> None:
        require_kind(fmu, kind)
        self.fmu, self.name = fmu, name
        self.log: list[str] = []
        self.time = 0.0
        description = fmu.description
        section = description.modelExchange if kind == "ModelExchange" else description.coSimulation
        self.keeps_states = bool(section.canGetAndSetFMUstate)
        self.interpolates = bool(getattr(section, "canInterpolateInputs", False))
        self.differentiates = bool(section.providesDirectionalDerivative)
        self._three = fmu.fmi != "2.0"
        self._references = {str(n): int(r) for n, r in fmu.variables["reference"].items()}
        self._kinds = {str(n): str(kind) for n, kind in fmu.variables["kind"].items()}
        self._groups: dict[tuple[str, ...], list[_Group]] = {}  # the same variables are asked for at every step
        self._open = False
        self._folder = tempfile.mkdtemp(prefix="ropeway-")
        try:
            fmpy.extract(str(fmu.path), unzipdir=self._folder)
            self._fmu: Any = _CLASSES[kind, self._three](
                guid=description.guid or description.instantiationToken,
                unzipDirectory=self._folder,
                modelIdentifier=section.modelIdentifier,
                instanceName=name,
            )
            self._instantiate()
        except Exception as error:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise FmuImportError(f"{fmu.path.name} cannot be instantiated: {error}{self._said()}") from error
        self._open = True

    def _instantiate(self) -> None:
        if self._three:
            self._fmu.instantiate(logMessage=lambda _, status, category, text: self._note(status, text))
            return
        from fmpy import calloc, free
        from fmpy import fmi2 as binding

        self._callbacks = binding.fmi2CallbackFunctions()
        self._callbacks.logger = binding.fmi2CallbackLoggerTYPE(
            lambda _, name, status, category, text: self._note(status, text)
        )
        self._callbacks.allocateMemory = binding.fmi2CallbackAllocateMemoryTYPE(calloc)
        self._callbacks.freeMemory = binding.fmi2CallbackFreeMemoryTYPE(free)
        self._fmu.instantiate(callbacks=self._callbacks)

    def _note(self, status: int, text: bytes) -> None:
        if status > 0:
            self.log.append(text.decode(errors="replace"))

    def _said(self) -> str:
        return f". It says: {' | '.join(self.log[-3:])}" if self.log else ""

    def error(self, what: str, remedy: str, *, fatal: bool = False) -> FmuRunError:
        """What went wrong, with the instance's name, its time and its own words."""
        cause = f"{self.name!r} ({self.fmu.path.name}) {what} at t = {self.time:.9g} s{self._said()}"
        return FmuRunError(cause, remedy, time=self.time, fatal=fatal)

    def call(self, what: str, method: str, *arguments: Any, **named: Any) -> Any:
        """A call, by FMPy's name of it for FMI 2.0. Raises FmuRunError, Interrupted."""
        stop_if_interrupted()
        try:
            return getattr(self._fmu, _IN_3.get(method, method) if self._three else method)(*arguments, **named)
        except FMICallException as error:
            raise self.error(
                f"refused {what}", "Look at its inputs there, or make the step smaller", fatal=error.status == _FATAL
            ) from error

    def enter(self, start: float, values: Mapping[str, float]) -> None:
        """Sets start values and begins the initialisation. Raises FmuRunError, FmuVariableError."""
        self.time = start
        self._where(values)
        if self._three:
            self.set(values)
            self.call("the initialisation", "enterInitializationMode", startTime=start)
        else:
            self.call("the start time", "setupExperiment", startTime=start)
            self.set(values)
            self.call("the initialisation", "enterInitializationMode")

    def leave(self) -> None:
        """Ends the initialisation. Raises FmuRunError."""
        self.call("the initialisation", "exitInitializationMode")

    def _where(self, names: Iterable[str]) -> list[int]:
        return [self._references[n] if n in self._references else int(self.fmu.variable(n)["reference"]) for n in names]

    def _by_kind(self, names: tuple[str, ...]) -> list[_Group]:
        if names not in self._groups:
            places: dict[str, list[int]] = {}
            for i, name in enumerate(names):
                places.setdefault(self._kinds.get(name, "Real"), []).append(i)
            owned = {kind: [names[i] for i in own] for kind, own in places.items()}
            self._groups[names] = [_Group(kind, own, places[kind], self._where(own)) for kind, own in owned.items()]
        return self._groups[names]

    def set(self, values: Mapping[str, float]) -> None:
        """Sets variables, Booleans by 0 and 1. Raises FmuRunError, FmuVariableError."""
        for group in self._by_kind(tuple(values)):
            own = {name: values[name] for name in group.names}
            numbers = list(own.values()) if group.kind == "Real" else self._whole(own, group.kind)
            self.call(f"values for {', '.join(own)}", f"set{group.kind}", group.references, numbers)

    def _whole(self, values: Mapping[str, float], kind: str) -> list[int]:
        for name, value in values.items():
            if kind not in ("Boolean", "Integer") or value not in ((0, 1) if kind == "Boolean" else (round(value),)):
                cause = f"{name!r} of {self.fmu.path.name} is a {kind}: it cannot be {value!r}"
                remedy = "Give 0 or 1" if kind == "Boolean" else "Give a whole number to an Integer, set nothing else"
                raise FmuVariableError(cause, remedy, name)
        return [int(value) for value in values.values()]

    def get(self, names: Sequence[str]) -> np.ndarray:
        """Values of variables, of Booleans 0 and 1. Raises FmuRunError, FmuVariableError."""
        values = np.zeros(len(names))
        for group in self._by_kind(tuple(names)):
            shown = self.call(f"to show {', '.join(group.names)}", f"get{group.kind}", group.references)
            values[group.places] = shown
        return values

    def set_rates(self, rates: Mapping[str, float]) -> None:
        """Sets rates of inputs in the next step (FMI 2.0). Raises FmuRunError."""
        where = self._where(rates)
        self.call("rates of inputs", "setRealInputDerivatives", where, [1] * len(where), list(rates.values()))

    def derivative(self, outputs: Sequence[str], name: str) -> np.ndarray:
        """Derivatives of variables by an input. Raises FmuRunError."""
        arguments = self._where(outputs), self._where([name]), [1.0]
        return np.array(self.call("directional derivatives", "getDirectionalDerivative", *arguments), dtype=float)

    def do_step(self, size: float) -> None:
        """A step of Co-Simulation. Raises FmuRunError."""
        done = self.call(
            f"a step of {size:g} s", "doStep", currentCommunicationPoint=self.time, communicationStepSize=size
        )
        self.time += size
        if done is not None and (done[1] or done[2]):  # FMI 3.0: wants to end, or has come to less than the end
            raise self.error("wants to end", "End the run before")

    def save(self) -> Any:
        """A copy of the FMU's state; free it with `forget`. Raises FmuRunError."""
        return self.call("to save its state", "getFMUstate")

    def restore(self, state: Any) -> None:
        """Back to a state, at `time`. Raises FmuRunError."""
        self.call("an earlier state", "setFMUstate", state)

    def forget(self, state: Any) -> None:
        """Frees a saved state."""
        self.call("to free a state", "freeFMUstate", state)

    def close(self) -> None:
        """Ends the instance."""
        if self._open:
            self._open = False
            self._fmu.freeInstance()
            shutil.rmtree(self._folder, ignore_errors=True)
