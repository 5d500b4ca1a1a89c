"""An open FMU for Model Exchange whose equations and events CasADi and the simulation call.

Its discrete variables are known by a mode: the number of a saved state of the FMU. An event leads from one mode to
another. So the equations are a function of time, states, inputs and mode, also when a step is repeated.
"""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from threading import RLock
from typing import Any

import casadi as ca
import numpy as np

from ropeway.components.errors import SimulationError
from ropeway.components.external_events import ExternalEvents, ExternalPoint, Outcome
from ropeway.fmu.errors import FmuImportError, FmuRunError
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.instance import Instance
from ropeway.fmu.importing.model_exchange_integrator import Integrator, IntegratorState

_SHIFT = 1e-7
"""Step of finite differences, relative to a value or its nominal."""


class EventfulFmu:
    """An open FMU by its `states`, continuous `inputs` and `outputs` in its own units.

    Raises FmuImportError, FmuRunError.
    """

    def __init__(self, fmu: Fmu, name: str, values: Mapping[str, float]) -> None:
        self._instance = Instance(fmu, name, "ModelExchange")
        weakref.finalize(self, self._instance.close)
        self._integrator = Integrator(self._instance, 1e-8)
        self._lock = RLock()
        self._modes: list[IntegratorState] = []
        self._followers: dict[tuple[int, float, bytes, bytes], Outcome] = {}
        self.states = _state_names(fmu)
        self.inputs = [n for n in fmu.names("input") if fmu.entries[n].continuous]
        self.outputs = [n for n in fmu.outputs() if n not in self.states]
        self._instance.enter(0.0, values)
        self._instance.leave()
        self._integrator.begin()
        self._mode = 0
        self._save()
        if self.has_events and not self._instance.keeps_states:
            raise FmuImportError(
                f"{fmu.path.name} has events and cannot save its state, so a step cannot be repeated",
                "Couple it by CoSimulation; or give ignore_events=True if its equations do not change at events",
            )

    @property
    def has_events(self) -> bool:
        """Whether it has event indicators, or announces an event."""
        return self._integrator.sizes[1] > 0 or bool(np.isfinite(self._modes[0].next_event))

    def starts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Start values of states, inputs and outputs."""
        return (
            self._modes[0].states[: len(self.states)],
            self._instance.get(self.inputs),
            self._instance.get(self.outputs),
        )

    def _save(self) -> None:
        self._modes.append(self._integrator.save())

    def _go(self, point: ExternalPoint) -> None:
        """Sets the FMU to a point."""
        if point.mode != self._mode:
            self._integrator.restore(self._modes[point.mode])
            self._mode = point.mode
        self._integrator.place(point.time, point.states, dict(zip(self.inputs, point.inputs.tolist(), strict=True)))

    def evaluate(self, point: ExternalPoint) -> tuple[np.ndarray, np.ndarray]:
        """Rates of the states, and outputs. Raises FmuRunError."""
        with self._lock:
            self._go(point)
            return self._integrator.rates(), self._instance.get(self.outputs)

    def margin(self, point: ExternalPoint) -> float:
        """Least distance of an event indicator from its change of sign in this mode. Raises FmuRunError."""
        with self._lock:
            self._go(point)
            return self._integrator.margin()

    def next_time(self, mode: int) -> float:
        """Time of the next time event in a mode [s]."""
        return self._modes[mode].next_event

    def update(self, point: ExternalPoint) -> Outcome:
        """The event at a point; the same point leads to the same mode. Raises FmuRunError."""
        key = point.mode, point.time, point.states.tobytes(), point.inputs.tobytes()
        with self._lock:
            if key not in self._followers:
                self._go(point)
                self._integrator.event()
                ended = self._instance.ended
                if ended is None:
                    self._save()
                    self._mode = len(self._modes) - 1
                else:  # the FMU takes no more calls in this mode
                    self._instance.ended, self._mode = None, -1
                states = point.states if ended is not None else self._modes[-1].states[: len(self.states)]
                self._followers[key] = Outcome(point.mode if ended is not None else self._mode, states.copy(), ended)
            return self._followers[key]


def _state_names(fmu: Fmu) -> list[str]:
    """Names of the continuous states, those of an array by its elements."""
    names = (unknown.variable.derivative.name for unknown in fmu.description.derivatives)
    return [element for name in names for element in fmu.arrays.get(name, (name,))]


class FmuEvents(ExternalEvents):
    """The events of an FMU, in SI units by factors and offsets of the variables."""

    mode = "fmu_mode"

    def __init__(self, opened: EventfulFmu, scales: Mapping[str, tuple[float, float]]) -> None:
        self._opened = opened
        self.states, self.inputs = opened.states, opened.inputs
        self._x, self._u = (np.array([scales[n] for n in names]).reshape(-1, 2) for names in (self.states, self.inputs))

    def _raw(self, point: ExternalPoint) -> ExternalPoint:
        states, inputs = (
            (values - scale[:, 1]) / scale[:, 0] for values, scale in ((point.states, self._x), (point.inputs, self._u))
        )
        return point._replace(states=states, inputs=inputs)

    def margin(self, point: ExternalPoint) -> float:
        return self._opened.margin(self._raw(point))

    def next_time(self, mode: int) -> float:
        return self._opened.next_time(mode)

    def update(self, point: ExternalPoint) -> Outcome:
        try:
            found = self._opened.update(self._raw(point))
        except FmuRunError as error:
            raise SimulationError(error.cause, error.remedy, point.time) from error
        return found._replace(states=self._x[:, 0] * found.states + self._x[:, 1])


class _Called(ca.Callback):  # type: ignore[misc]  # CasADi has no types
    """(t, x, u, p, mode) -> (ode, y), in the units of the FMU; it has no parameters p."""

    def __init__(self, name: str, opened: EventfulFmu, nominals: Sequence[np.ndarray]) -> None:
        ca.Callback.__init__(self)
        self.opened, self.nominals = opened, nominals
        self._sizes = (1, len(opened.states), len(opened.inputs), 0, 1), (len(opened.states), len(opened.outputs))
        self._derived: list[Any] = []  # CasADi does not keep the objects that it is given
        self.construct(name, {})

    def get_n_in(self) -> int:
        return 5

    def get_n_out(self) -> int:
        return 2

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self._sizes[0][i], 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self._sizes[1][i], 1)

    def values(self, arguments: Sequence[ca.DM]) -> list[np.ndarray]:
        """Rates and outputs."""
        t, x, u, _, mode = (np.asarray(a.full(), dtype=float).ravel() for a in arguments[:5])
        return list(self.opened.evaluate(ExternalPoint(float(t[0]), x, u, int(mode[0]))))

    def eval(self, arguments: Sequence[ca.DM]) -> list[np.ndarray]:
        return self.values(arguments)

    def has_jacobian(self) -> bool:
        return True

    def get_jacobian(self, name: str, inames: Sequence[str], onames: Sequence[str], opts: Any) -> ca.Function:
        made = _Jacobian(name, self, self._sizes)
        self._derived.append(made)
        return made


class _Jacobian(ca.Callback):  # type: ignore[misc]
    """Derivatives of the rates and outputs by states and inputs, by central differences."""

    def __init__(self, name: str, of: _Called, sizes: tuple[tuple[int, ...], tuple[int, ...]]) -> None:
        ca.Callback.__init__(self)
        self._of, self._sizes = of, sizes
        self.construct(name, {})

    def get_n_in(self) -> int:
        return 7

    def get_n_out(self) -> int:
        return 10

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense((*self._sizes[0], *self._sizes[1])[i], 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        rows, columns = self._sizes[1][i // 5], self._sizes[0][i % 5]
        return ca.Sparsity.dense(rows, columns) if i % 5 in (1, 2) else ca.Sparsity(rows, columns)

    def eval(self, arguments: Sequence[ca.DM]) -> list[ca.DM]:
        blocks = {i: ca.DM(self.get_sparsity_out(i)) for i in range(10)}
        for which in (1, 2):
            nominals, columns = self._of.nominals[which - 1], []
            for j, nominal in enumerate(nominals):
                value = float(arguments[which][j])
                h = _SHIFT * max(abs(value), nominal)
                sides = []
                for side in (value + h, value - h):
                    shifted = list(arguments)
                    shifted[which] = ca.DM(arguments[which])
                    shifted[which][j] = side
                    sides.append(np.concatenate(self._of.values(shifted)))
                columns.append((sides[0] - sides[1]) / (2.0 * h))
            if columns:
                whole, n = np.column_stack(columns), self._sizes[1][0]
                blocks[which], blocks[5 + which] = ca.DM(whole[:n]), ca.DM(whole[n:])
        return [blocks[i] for i in range(10)]


def called(name: str, opened: EventfulFmu, nominals: Sequence[np.ndarray]) -> ca.Function:
    """The equations as a function for CasADi; `nominals`: of the states, and of the inputs."""
    return _Called(name, opened, nominals)
