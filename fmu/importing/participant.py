"""An FMU that a master moves on: one for Co-Simulation by its own solver, one for Model Exchange by an integrator
here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.fmu.errors import FmuRunError, FmuVariableError
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.instance import Instance
from ropeway.fmu.importing.model_exchange_integrator import Integrator
from ropeway.fmu.importing.variable_types import Value


class OpenFmu:
    """An open FMU. Close it, or use it with `with`. kind: "CoSimulation" or "ModelExchange"; tolerance: of the
    integrator of the latter. `can_restore`: it can go back in time; `can_interpolate`: its inputs may change linearly
    within a step. Raises FmuImportError."""

    def __init__(self, fmu: Fmu, name: str = "slave", kind: str = "CoSimulation", tolerance: float = 1e-8) -> None:
        self.fmu, self.name, self.kind = fmu, name, kind
        self._instance = Instance(fmu, name, kind)
        self._integrator = Integrator(self._instance, tolerance) if kind == "ModelExchange" else None
        self.can_restore = self._integrator is not None or self._instance.keeps_states
        self.can_interpolate = self._integrator is not None or self._instance.interpolates

        self._continuous = frozenset(n for n, entry in fmu.entries.items() if entry.continuous)

    @property
    def time(self) -> float:
        """Where it is [s]."""
        return self._instance.time

    @property
    def ended(self) -> str | None:
        """Why the FMU has ended the run itself; None while it has not."""
        return self._instance.ended

    @property
    def varies_steps(self) -> bool:
        """Whether its steps may have different lengths."""
        return self._integrator is not None or self._instance.varies_steps

    @property
    def log(self) -> list[str]:
        """Its warnings and errors so far."""
        return self._instance.log

    def enter(self, start: float, values: Mapping[str, object], stop: float | None = None) -> None:
        """Sets start values and begins the initialisation at a time [s]; stop: when the run is to end. Raises
        FmuRunError, FmuVariableError."""
        self._instance.enter(start, values, stop)

    def leave(self) -> None:
        """Ends the initialisation. Raises FmuRunError."""
        self._instance.leave()
        if self._integrator is not None:
            self._integrator.begin()

    def set(self, values: Mapping[str, object]) -> None:
        """Sets variables; in Model Exchange what is not continuous makes an event. An FMU that has ended the run keeps
        what it has. Raises FmuRunError, FmuVariableError."""
        if self.ended is not None:
            return
        if self._integrator is not None:
            self._integrator.set(values)
        else:
            self._instance.set(values)

    def read(self, names: Sequence[str]) -> list[Value]:
        """Values of variables of any kind. Raises FmuRunError, FmuVariableError."""
        return self._instance.read(names)

    def get(self, names: Sequence[str]) -> np.ndarray:
        """Values of numbers, of Booleans 0 and 1. Raises FmuRunError, FmuVariableError."""
        return self._instance.get(names)

    def derivatives(self, outputs: Sequence[str], inputs: Mapping[str, float]) -> np.ndarray:
        """Derivatives of outputs (rows) by inputs (columns) around these values of the inputs: the FMU's own
        directional derivatives where it gives them, else differences. Raises FmuRunError."""
        if not inputs:
            return np.empty((len(outputs), 0))
        if self._instance.differentiates:
            try:
                return np.column_stack([self._instance.derivative(outputs, name) for name in inputs])
            except FmuRunError as error:  # some FMUs promise more than they keep
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
        """Moves on by `size` seconds with inputs that go from `start` to `end`: linearly where the FMU can, else held
        at their mean; discrete ones keep their start. Where the FMU ends the run it stops earlier, and says so in
        `ended`. Raises FmuRunError."""
        if not start.keys() <= self._continuous:
            self.set({n: v for n, v in start.items() if n not in self._continuous})
            start = {n: v for n, v in start.items() if n in self._continuous}
        if self.ended is not None:
            return
        if self._integrator is not None:
            self._integrator.advance(size, start, end)
            return
        changes = {n: (end[n] - v) / size for n, v in start.items()}
        if self.can_interpolate and any(changes.values()):
            self.set(start)
            self._instance.set_rates(changes)
        else:
            self.set({n: (v + end[n]) / 2.0 for n, v in start.items()})
        self._instance.do_step(size)
        self.set({n: end[n] for n in start})

    def save(self) -> Any:
        """The state, for `restore`; free it with `forget`. Raises InputError, FmuRunError."""
        if not self.can_restore:
            raise InputError(f"{self.name!r} cannot go back in time", "Couple it without iteration")
        return self._integrator.save() if self._integrator is not None else (self.time, self._instance.save())

    def restore(self, state: Any) -> None:
        """Back to a saved state. Raises FmuRunError."""
        if self._integrator is not None:
            self._integrator.restore(state)
        else:
            self._instance.time, kept = state
            self._instance.ended = None
            self._instance.restore(kept)

    def forget(self, state: Any) -> None:
        """Frees a saved state."""
        if self._integrator is not None:
            self._integrator.forget(state)
        else:
            self._instance.forget(state[1])

    def close(self) -> None:
        """Ends the instance."""
        self._instance.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@checked
class Slave(OpenFmu):
    """An open FMU whose calls check their arguments; a co-simulation spares that, at every step."""

    __init__ = OpenFmu.__init__
    enter, set, read, get = OpenFmu.enter, OpenFmu.set, OpenFmu.read, OpenFmu.get
    derivatives, step = OpenFmu.derivatives, OpenFmu.step


def require_causality(fmu: Fmu, name: str, causality: str) -> None:
    """Raises FmuVariableError unless a variable is a real one of this causality."""
    require_connectable(fmu, name, causality, ("Real",))


def require_connectable(
    fmu: Fmu,
    name: str,
    causality: str,
    kinds: Sequence[str] = ("Real", "Boolean", "Integer", "Enumeration", "String", "Binary"),
) -> None:
    """Raises FmuVariableError unless a variable is of this causality, of one of these kinds and of no clock."""
    entry = fmu.entry(name)
    if entry.causality != causality or entry.kind not in kinds or entry.clocked:
        what = f"{'clocked ' if entry.clocked else ''}{entry.kind}"
        choice = [n for n in fmu.names(causality, *kinds) if not fmu.entries[n].clocked]
        wanted = f"a Real {causality}" if len(kinds) == 1 else f"an {causality} that can be connected"
        raise FmuVariableError(
            f"{name!r} of {fmu.path.name} is a {what} of causality {entry.causality!r}, not {wanted}",
            f"Choose from {', '.join(choice[:12]) or 'nothing: it has none'}",
            name,
        )
