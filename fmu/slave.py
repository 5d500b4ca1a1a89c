"""An instance of an FMU that a master moves on: a Co-Simulation FMU by its own solver, or a Model Exchange FMU by an
integrator here, which can always go back in time."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Mapping, Sequence
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Slave
from scipy.integrate import solve_ivp

from ropeway.components.errors import InputError
from ropeway.fmu.errors import FmuImportError, FmuRunError, FmuVariableError
from ropeway.fmu.imported import Fmu


class Slave:
    """An open instance. Close it, or use it with `with`. kind: "CoSimulation" or "ModelExchange" (FMI 2.0, without
    events in the time between two steps). Raises FmuImportError."""

    def __init__(self, fmu: Fmu, name: str = "slave", kind: str = "CoSimulation", tolerance: float = 1e-8) -> None:
        if kind not in fmu.kinds:
            raise FmuImportError(f"{fmu.path.name} is not for {kind}", f"It is for {', '.join(fmu.kinds)}")
        if kind == "ModelExchange" and fmu.fmi != "2.0":
            raise FmuImportError(
                f"{fmu.path.name} is of FMI version {fmu.fmi}", "Use its Co-Simulation, or export it as FMI 2.0"
            )
        require_platform(fmu)
        self.fmu, self.name, self.kind = fmu, name, kind
        self.log: list[str] = []
        self.time = 0.0
        self._tolerance = tolerance
        self._open = False
        self._folder = tempfile.mkdtemp(prefix="ropeway-")
        section = fmu.description.modelExchange if kind == "ModelExchange" else fmu.description.coSimulation
        self.can_restore = bool(kind == "ModelExchange" or getattr(section, "canGetAndSetFMUstate", False))
        self.can_interpolate = bool(kind == "ModelExchange" or getattr(section, "canInterpolateInputs", False))
        self._references = {str(n): int(r) for n, r in fmu.variables["reference"].items()}
        try:
            fmpy.extract(str(fmu.path), unzipdir=self._folder)
            made = FMU3Slave if fmu.fmi != "2.0" else FMU2Model if kind == "ModelExchange" else FMU2Slave
            self._fmu: Any = made(
                guid=fmu.description.guid or fmu.description.instantiationToken,
                unzipDirectory=self._folder,
                modelIdentifier=section.modelIdentifier,
                instanceName=name,
            )
            self._instantiate()
        except Exception as error:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise FmuImportError(f"{fmu.path.name} cannot be instantiated: {error}{self._said()}") from error
        self._open = True

    @property
    def _three(self) -> bool:
        return self.fmu.fmi != "2.0"

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

    def call(self, what: str, method: str, *arguments: Any, **named: Any) -> Any:
        """A call of the FMU. Raises FmuRunError with its own words."""
        try:
            return getattr(self._fmu, method)(*arguments, **named)
        except FMICallException as error:
            raise FmuRunError(
                f"{self.name!r} ({self.fmu.path.name}) refused {what} at t = {self.time:.9g} s{self._said()}",
                "Look at its inputs there, or make the step smaller",
                time=self.time,
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
        if self.kind == "ModelExchange":
            self.call("the first event", "newDiscreteStates")
            self.call("continuous time", "enterContinuousTimeMode")

    def _where(self, names: Mapping[str, float] | Sequence[str]) -> list[int]:
        return [self._references[n] if n in self._references else int(self.fmu.variable(n)["reference"]) for n in names]

    def set(self, values: Mapping[str, float]) -> None:
        """Sets real variables. Raises FmuRunError, FmuVariableError."""
        if values:
            method = "setFloat64" if self._three else "setReal"
            self.call(f"values for {', '.join(values)}", method, self._where(values), list(values.values()))

    def get(self, names: Sequence[str]) -> np.ndarray:
        """Values of real variables. Raises FmuRunError, FmuVariableError."""
        if not names:
            return np.zeros(0)
        method = "getFloat64" if self._three else "getReal"
        return np.array(self.call(f"to show {', '.join(names)}", method, self._where(names)), dtype=float)

    def step(self, size: float, start: Mapping[str, float], end: Mapping[str, float]) -> None:
        """Moves on by `size` seconds with inputs that go from `start` to `end`: linearly where the FMU can, else held
        at their mean. Raises FmuRunError."""
        if self.kind == "ModelExchange":
            self._integrate(size, start, end)
            return
        changes = {n: (end[n] - v) / size for n, v in start.items()}
        if self.can_interpolate and any(changes.values()):
            self.set(start)
            where = self._where(changes)
            self.call("rates of inputs", "setRealInputDerivatives", where, [1] * len(where), list(changes.values()))
        else:
            self.set({n: (v + end[n]) / 2.0 for n, v in start.items()})
        self.call(f"a step of {size:g} s", "doStep", currentCommunicationPoint=self.time, communicationStepSize=size)
        self.time += size
        self.set(end)

    def _integrate(self, size: float, start: Mapping[str, float], end: Mapping[str, float]) -> None:
        n = self.fmu.description.numberOfContinuousStates
        begin, values = self.time, np.zeros(max(n, 1))
        pointer = np.ctypeslib.as_ctypes(values)

        def put(t: float, x: np.ndarray) -> None:
            share = (t - begin) / size
            self.call("the time", "setTime", t)
            if n:
                values[:n] = x
                self.call("its states", "setContinuousStates", pointer, n)
            self.set({name: v + share * (end[name] - v) for name, v in start.items()})

        def rates(t: float, x: np.ndarray) -> np.ndarray:
            put(t, x)
            self.call("its rates", "getDerivatives", pointer, n)
            return values[:n].copy()

        if n:
            self.call("its states", "getContinuousStates", pointer, n)
            run = solve_ivp(
                rates, (begin, begin + size), values[:n].copy(), "DOP853", rtol=self._tolerance, atol=self._tolerance
            )
            if not run.success:
                raise FmuRunError(f"{self.name!r} cannot be integrated: {run.message}", "Make the step smaller")
        put(begin + size, run.y[:, -1] if n else np.zeros(0))
        self.time = begin + size
        event, stop = self.call("the end of a step", "completedIntegratorStep")
        if event or stop:
            raise FmuRunError(f"{self.name!r} has an event at t = {self.time:.9g} s", "Use its Co-Simulation")

    def save(self) -> Any:
        """The state, for `restore`; free it with `forget`."""
        if not self.can_restore:
            raise InputError(f"{self.name!r} cannot go back in time", "Couple it without iteration")
        if self.kind == "CoSimulation":
            return self.time, self.call("to save its state", "getFMUState" if self._three else "getFMUstate")
        n = self.fmu.description.numberOfContinuousStates
        values = np.zeros(max(n, 1))
        if n:
            self.call("its states", "getContinuousStates", np.ctypeslib.as_ctypes(values), n)
        return self.time, values

    def restore(self, state: Any) -> None:
        """Back to a saved state."""
        self.time, kept = state
        if self.kind == "CoSimulation":
            self.call("an earlier state", "setFMUState" if self._three else "setFMUstate", kept)
            return
        self.call("the time", "setTime", self.time)
        n = self.fmu.description.numberOfContinuousStates
        if n:
            self.call("its states", "setContinuousStates", np.ctypeslib.as_ctypes(kept), n)

    def forget(self, state: Any) -> None:
        """Frees a saved state."""
        if self.kind == "CoSimulation":
            self.call("to free a state", "freeFMUState" if self._three else "freeFMUstate", state[1])

    def close(self) -> None:
        """Ends the instance."""
        if self._open:
            self._open = False
            self._fmu.freeInstance()
            shutil.rmtree(self._folder, ignore_errors=True)

    def __enter__(self) -> Slave:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def require_platform(fmu: Fmu) -> None:
    """Raises FmuImportError unless an FMU has a binary for this platform."""
    if fmpy.platform not in fmu.platforms:
        raise FmuImportError(
            f"{fmu.path.name} has no binary for {fmpy.platform} (it has {', '.join(fmu.platforms) or 'none'})",
            "Export it for this platform",
        )


def require_causality(fmu: Fmu, name: str, causality: str) -> None:
    """Raises FmuVariableError unless a variable is a real one of this causality."""
    row = fmu.variable(name)
    if row["causality"] != causality or row["kind"] != "Real":
        raise FmuVariableError(
            f"{name!r} of {fmu.path.name} is a {row['kind']} of causality {row['causality']!r}, not a Real {causality}",
            f"Choose from {', '.join(fmu.names(causality)[:12]) or 'nothing: it has none'}",
            name,
        )
