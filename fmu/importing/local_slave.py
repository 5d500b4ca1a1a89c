"""An FMU in this process, advanced by its own solver (Co-Simulation) or by an integrator of this library."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.importing.instance import Instance
from ropeway.fmu.importing.interface import FmuInterface
from ropeway.fmu.importing.variable_types import Value


class LocalSlave:
    """An FMU in this process; `OpenFmu` describes its methods.

    `folder`: where it is unpacked, if it is. Raises FmuImportError.
    """

    def __init__(self, fmu: FmuInterface, name: str, kind: str, tolerance: float, folder: Path | None = None) -> None:
        self._instance = Instance(fmu, name, kind, folder)
        self._integrator = None
        if kind == "ModelExchange":
            from ropeway.fmu.importing.model_exchange_integrator import Integrator

            self._integrator = Integrator(self._instance, tolerance)
        self.can_restore = self._integrator is not None or self._instance.keeps_states
        self.can_interpolate = self._integrator is not None or bool(self._instance.interpolated)
        self.varies_steps = self._integrator is not None or self._instance.varies_steps
        self._continuous = frozenset(n for n, entry in fmu.entries.items() if entry.continuous)

    @property
    def time(self) -> float:
        return self._instance.time

    @property
    def ended(self) -> str | None:
        return self._instance.ended

    @property
    def log(self) -> list[str]:
        return self._instance.log

    @property
    def noted(self) -> int:
        return self._instance.noted

    def enter(self, start: float, values: Mapping[str, object], stop: float | None = None) -> None:
        self._instance.enter(start, values, stop)

    def leave(self) -> None:
        self._instance.leave()
        if self._integrator is not None:
            self._integrator.begin()

    def set(self, values: Mapping[str, object]) -> None:
        if self.ended is not None:
            return
        if self._integrator is not None:
            self._integrator.set(values)
        else:
            self._instance.set(values)

    def read(self, names: Sequence[str]) -> list[Value]:
        return self._instance.read(names)

    def get(self, names: Sequence[str]) -> np.ndarray:
        return self._instance.get(names)

    def derivatives(self, outputs: Sequence[str], inputs: Mapping[str, float]) -> np.ndarray:
        if self._instance.differentiates:
            try:
                return np.column_stack([self._instance.derivative(outputs, name) for name in inputs])
            except FmuRunError as error:  # some FMUs declare derivatives that they do not provide
                if error.fatal:
                    raise
        before, columns = self.get(outputs), []
        for name, value in inputs.items():
            shift = 1e-6 * (1.0 + abs(value))
            self.set({name: value + shift})
            columns.append((self.get(outputs) - before) / shift)
            self.set({name: value})
        return np.column_stack(columns)

    def step(self, size: float, start: Mapping[str, float], end: Mapping[str, float]) -> None:
        if not start.keys() <= self._continuous:
            self.set({n: v for n, v in start.items() if n not in self._continuous})
            start = {n: v for n, v in start.items() if n in self._continuous}
        if self.ended is not None:
            return
        if self._integrator is not None:
            self._integrator.advance(size, start, end)
            return
        if start != end or self._instance.ramped:
            changes = {n: (end[n] - v) / size for n, v in start.items()}
            ramps = {n: v for n, v in start.items() if n in self._instance.interpolated}
            self.set({n: (v + end[n]) / 2.0 for n, v in start.items() if n not in ramps})
            if ramps:
                self._instance.ramp(ramps, changes)
            self._instance.do_step(size)
            self.set({n: end[n] for n in start})
        else:
            self.set(start)
            self._instance.do_step(size)

    def save(self) -> Any:
        return self._integrator.save() if self._integrator is not None else (self.time, self._instance.save())

    def restore(self, state: Any) -> None:
        if self._integrator is not None:
            self._integrator.restore(state)
        else:
            self._instance.time, kept = state
            self._instance.ended = None
            self._instance.restore(kept)

    def forget(self, state: Any) -> None:
        if self._integrator is not None:
            self._integrator.forget(state)
        else:
            self._instance.forget(state[1])

    def close(self) -> None:
        self._instance.close()
