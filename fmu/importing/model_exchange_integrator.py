"""Integration of an FMU for Model Exchange, with its events."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import DOP853, OdeSolver, Radau

from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.importing.instance import Instance

_ENDLESS = 1000
"""Largest number of events at one time."""
_STIFF_STEPS, _NOT_STIFF_STEPS, _STABILITY = 15, 6, 6.1
"""Steps at the limit of stability after which a problem counts as stiff, steps inside it that reset this count, and the
limit: step size times the largest eigenvalue (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations)."""
_SHORTER = 0.01
"""Next step after an implicit step that ends just before an event, as a share of it."""


@dataclass(frozen=True, slots=True)
class IntegratorState:
    """State of an integration, to be restored."""

    time: float
    states: np.ndarray
    positive: np.ndarray
    next_event: float
    events: int
    step: float | None
    kept: Any | None


@dataclass(frozen=True, slots=True)
class _Ramp:
    """Inputs that are linear in time from `begin` on, for `size` seconds."""

    begin: float
    size: float
    start: Mapping[str, float]
    end: Mapping[str, float]

    def at(self, time: float) -> dict[str, float]:
        """Values at a time [s]."""
        share = (time - self.begin) / self.size
        return {name: v + share * (self.end[name] - v) for name, v in self.start.items()}

    def continues(self, later: _Ramp) -> bool:
        """Whether the inputs are constant, and the same in the next step."""
        return self.start == self.end == later.start == later.end


class _Stiffness:
    """Counts steps of DOP853 that its stability limits; `found`: the problem is stiff."""

    def __init__(self) -> None:
        self.found = False
        self._at_limit = self._inside = 0

    def finds(self, solver: DOP853, before: np.ndarray) -> bool:
        """Whether the problem is stiff, after a step from the states `before`."""
        stage = before + (solver.t - solver.t_old) * solver.K[:11].T @ solver.A[11, :11]
        distance = float(np.linalg.norm((solver.y - stage) / solver.atol))
        slope = float(np.linalg.norm((solver.K[12] - solver.K[11]) / solver.atol))
        if (solver.t - solver.t_old) * slope > _STABILITY * distance > 0.0:
            self._at_limit, self._inside = self._at_limit + 1, 0
        else:
            self._inside += 1
            self._at_limit = 0 if self._inside >= _NOT_STIFF_STEPS else self._at_limit
        self.found = self._at_limit >= _STIFF_STEPS
        return self.found


class Integrator:
    """Advances an instance by a Runge-Kutta method, `tolerance` relative to states or their nominals.

    The method is DOP853 until its steps are limited by stability, then the implicit method Radau IIA of order 5. State
    events, where an event indicator changes its sign, are located by bisection; time events are met exactly. At each
    event the discrete states are updated until they converge. Two events of one indicator within one step of the
    integrator are not detected. Inputs are linear in time.
    """

    def __init__(self, instance: Instance, tolerance: float) -> None:
        self._instance, self._tolerance = instance, tolerance
        self._size(0, 0)
        self._positive = self._indicators > 0.0
        self._next_event = np.inf
        self._events = 0
        self._step: float | None = None
        self._continuous = False
        self._stiffness = _Stiffness()
        self._implicit: Radau | None = None
        self._inputs = _Ramp(0.0, 1.0, {}, {})

    def _size(self, states: int, indicators: int) -> None:
        self._n = states
        self._indicators = np.zeros(indicators)
        self._values = np.zeros(max(states, 1))  # a constant one if there is none, so that time advances
        self._nominals = np.ones(len(self._values))

    def begin(self) -> None:
        """First update of the discrete states, after the initialisation. Raises FmuRunError."""
        self._size(*self._instance.sizes())
        self._update()

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of continuous states and event indicators."""
        return self._n, len(self._indicators)

    def place(self, time: float, states: np.ndarray, inputs: Mapping[str, float]) -> None:
        """Sets the instance to a trial time, states and continuous inputs. Raises FmuRunError."""
        self._put(time, states if self._n else np.ones(1))
        self._instance.set(inputs)

    def rates(self) -> np.ndarray:
        """Rates of the states at the trial point, shape (states,). Raises FmuRunError."""
        self._vector("its rates", "getDerivatives", self._values[: self._n])
        return self._values[: self._n].copy()

    def margin(self) -> float:
        """Least distance of an event indicator from its change of sign since the last event, not positive beyond it.

        Raises FmuRunError.
        """
        values = self._vector("its event indicators", "getEventIndicators", self._indicators)
        beyond = (values > 0.0) != self._positive
        return float(np.min(np.where(beyond, -np.abs(values), np.maximum(np.abs(values), 1e-300)), initial=np.inf))

    def event(self) -> None:
        """An event at the trial point, which ends a step. Raises FmuRunError."""
        self._instance.call("the end of a step", "completedIntegratorStep", False)
        self._event({})

    def set(self, values: Mapping[str, object]) -> None:
        """Sets variables; discrete ones at an event, as FMI requires. Raises FmuRunError, FmuVariableError."""
        entries = self._instance.fmu.entries
        now = {n: v for n, v in values.items() if not self._continuous or (n in entries and entries[n].continuous)}
        self._instance.set(now)
        if len(now) < len(values):
            self._event({n: v for n, v in values.items() if n not in now})

    def _event(self, values: Mapping[str, object]) -> None:
        """An event at which values change. Raises FmuRunError, FmuVariableError."""
        self._events += 1
        self._instance.call("an event", "enterEventMode")
        self._continuous = False
        self._instance.set(values)
        self._update()

    def _vector(self, what: str, method: str, values: np.ndarray) -> np.ndarray:
        if len(values):
            self._instance.call(what, method, np.ctypeslib.as_ctypes(values), len(values))
        return values.copy()

    def _states(self) -> np.ndarray:
        self._vector("its states", "getContinuousStates", self._values[: self._n])
        return self._values.copy()

    def _signs(self) -> np.ndarray:
        return self._vector("its event indicators", "getEventIndicators", self._indicators) > 0.0

    def _put(self, time: float, states: np.ndarray) -> None:
        self._instance.call("the time", "setTime", time)
        self._values[:] = states
        self._vector("its states", "setContinuousStates", self._values[: self._n])

    def _update(self) -> None:
        """The event iteration, from event mode to continuous time."""
        for _ in range(_ENDLESS):
            again, end, _, _, defined, time = self._instance.call("an event", "newDiscreteStates")
            if end:
                self._instance.end()
                return
            if not again:
                break
        else:
            raise self._instance.error("has too many events at one time", "Check its inputs at that time")
        self._instance.call("continuous time", "enterContinuousTimeMode")
        self._continuous = True
        self._vector("nominals", "getNominalsOfContinuousStates", self._nominals[: self._n])
        self._next_event = time if defined else np.inf
        self._positive = self._signs()

    def advance(self, size: float, start: Mapping[str, float], end: Mapping[str, float]) -> None:
        """Advances by `size` seconds, or until the FMU ends the run.

        Continuous inputs go from `start` to `end`. Raises FmuRunError.
        """
        stop = self._instance.time + size
        inputs = _Ramp(self._instance.time, size, start, end)
        if not self._inputs.continues(inputs):
            self._implicit = None
        self._inputs = inputs
        states, count, last = self._states(), 0, -np.inf
        self._try(self._instance.time, states)
        due = bool(np.any(self._signs() != self._positive))  # the inputs jumped
        while True:
            time = self._instance.time
            if due or time >= self._next_event:
                count = count + 1 if time == last else 1
                last = time
                if count > _ENDLESS:
                    raise self._instance.error("has too many events at one time", "Check its inputs at that time")
                self._event({})
                if self._instance.ended is not None:
                    return
                states = self._states()
            if time >= stop:
                return
            states, due = self._until(min(stop, self._next_event), states)
            if self._instance.ended is not None:
                return

    def _try(self, time: float, states: np.ndarray) -> None:
        """Sets the instance to a time, states, and the inputs at that time."""
        self._put(time, states)
        self._instance.set(self._inputs.at(time))

    def _rates(self, time: float, states: np.ndarray) -> np.ndarray:
        try:
            self._try(time, states)
            self._vector("its rates", "getDerivatives", self._values[: self._n])
        except FmuRunError as error:
            if error.fatal:
                raise
            return np.full(len(states), np.nan)  # the integrator tries a smaller step
        return self._values.copy() if self._n else np.zeros(1)

    def _solver(self, time: float, states: np.ndarray, goal: float) -> OdeSolver:
        """An integrator from a time to another; the implicit one continues with its matrices. Raises FmuRunError."""
        old = self._implicit
        if old is not None and old.t == time and np.array_equal(old.y, states):
            old.t_bound, old.status = goal, "running"
            return old
        if not np.all(np.isfinite(self._rates(time, states))):
            raise self._instance.error("has rates that are not finite", "Check its inputs at that time")
        allowed = {"rtol": self._tolerance, "atol": self._tolerance * self._nominals}
        first = None if self._step is None else min(self._step, goal - time)
        method = Radau if self._stiffness.found else DOP853
        solver = method(self._rates, time, states, goal, first_step=first, **allowed)
        self._implicit = solver if isinstance(solver, Radau) else None
        return solver

    def _until(self, goal: float, states: np.ndarray) -> tuple[np.ndarray, bool]:
        """Integrates to a time or to the first event before it; returns the states, and whether there is an event."""
        instance = self._instance
        solver = self._solver(instance.time, states, goal)
        while solver.status == "running":
            before = states
            message = solver.step()
            if solver.status == "failed":
                raise instance.error(f"cannot be integrated ({message})", "Check its inputs at that time")
            time, states = solver.t, solver.y
            self._try(time, states)
            event = bool(np.any(self._signs() != self._positive))
            if event:
                time, states, event = self._locate(solver, before)
            instance.time = time
            wanted, end = instance.call("the end of a step", "completedIntegratorStep", False)
            if end:
                raise instance.error("requested the end of the run", "End the run earlier")
            if event or wanted:
                self._implicit = None
                return states, True
            if time < solver.t:  # the step was too long for its event
                self._implicit = None
                solver = self._solver(time, states, goal)
            elif solver.status == "running":
                self._step = solver.h_abs
                if isinstance(solver, DOP853) and self._stiffness.finds(solver, before):
                    solver = self._solver(time, states, goal)
        return states, False

    def _locate(self, solver: OdeSolver, before: np.ndarray) -> tuple[float, np.ndarray, bool]:
        """Time and states just after the first sign change in the last step, or not long before it, and which of both;
        the instance is set there."""
        time, states = self._bisected(solver)
        if isinstance(solver, DOP853):
            return time, states, True
        # Between the ends of a step the implicit method is of lower order: the step is repeated up to the event.
        allowed = {"rtol": self._tolerance, "atol": self._tolerance * self._nominals}
        start = solver.t_old
        solver = Radau(self._rates, start, before, time, first_step=time - start, **allowed)
        while solver.status == "running":
            solver.step()
        if solver.status == "failed":
            raise self._instance.error("cannot be integrated to an event", "Check its inputs at that time")
        self._try(solver.t, solver.y)
        if np.any(self._signs() != self._positive):
            return *self._bisected(solver), True
        self._step = _SHORTER * (time - start)
        return solver.t, solver.y, False

    def _bisected(self, solver: OdeSolver) -> tuple[float, np.ndarray]:
        """Time and states just after the first sign change in the last step of a solver, by its interpolation."""
        between = solver.dense_output()
        before, after = solver.t_old, solver.t
        while before < (middle := 0.5 * (before + after)) < after:
            self._try(middle, between(middle))
            if np.any(self._signs() != self._positive):
                after = middle
            else:
                before = middle
        states = solver.y if after == solver.t else between(after)
        self._try(after, states)
        return after, states

    def save(self) -> IntegratorState:
        """Present state; free it with `forget`. Raises FmuRunError."""
        kept = self._instance.save() if self._instance.keeps_states else None
        return IntegratorState(
            self._instance.time,
            self._states(),
            self._positive.copy(),
            self._next_event,
            self._events,
            self._step,
            kept,
        )

    def restore(self, saved: IntegratorState) -> None:
        """Restores a state. Raises FmuRunError if the FMU cannot save its state and had an event since."""
        if saved.kept is not None:
            self._instance.restore(saved.kept)
        elif saved.events != self._events:
            raise self._instance.error(
                f"cannot restore t = {saved.time:.9g} s, as it cannot save its state and had an event since,",
                "Couple it with iterated=False and without step control",
            )
        self._instance.time, self._instance.ended = saved.time, None
        self._continuous = True
        self._positive, self._next_event = saved.positive.copy(), saved.next_event
        self._events, self._step = saved.events, saved.step
        self._implicit = None
        self._put(saved.time, saved.states)

    def forget(self, saved: IntegratorState) -> None:
        """Frees a saved state."""
        if saved.kept is not None:
            self._instance.forget(saved.kept)
