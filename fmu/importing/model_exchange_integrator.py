"""Integration of an FMU for Model Exchange, with its events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from ropeway.fmu.errors import FmuRunError
from ropeway.fmu.importing.instance import Instance

_ENDLESS = 1000
"""Largest number of events at one time."""


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


class Integrator:
    """Advances an instance by the Runge-Kutta method DOP853, `tolerance` relative to states or their nominals.

    State events, where an event indicator changes its sign, are located by bisection; time events are met exactly. At
    each event the discrete states are updated until they converge. Two events of one indicator within one step of the
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

    def _size(self, states: int, indicators: int) -> None:
        self._n = states
        self._indicators = np.zeros(indicators)
        self._values = np.zeros(max(states, 1))  # a constant one if there is none, so that time advances
        self._nominals = np.ones(len(self._values))

    def begin(self) -> None:
        """First update of the discrete states, after the initialisation. Raises FmuRunError."""
        self._size(*self._instance.sizes())
        self._update()

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
        begin = self._instance.time
        stop = begin + size

        def put(time: float, states: np.ndarray) -> None:
            self._put(time, states)
            share = (time - begin) / size
            self._instance.set({name: v + share * (end[name] - v) for name, v in start.items()})

        states, count, last = self._states(), 0, -np.inf
        put(begin, states)
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
            states, due = self._until(min(stop, self._next_event), states, put)
            if self._instance.ended is not None:
                return

    def _until(
        self, goal: float, states: np.ndarray, put: Callable[[float, np.ndarray], None]
    ) -> tuple[np.ndarray, bool]:
        """Integrates to a time or to the first event before it; returns the states, and whether there is an event."""
        instance = self._instance

        def rates(time: float, x: np.ndarray) -> np.ndarray:
            try:
                put(time, x)
                self._vector("its rates", "getDerivatives", self._values[: self._n])
            except FmuRunError as error:
                if error.fatal:
                    raise
                return np.full(len(x), np.nan)  # the integrator tries a smaller step
            return self._values.copy() if self._n else np.zeros(1)

        allowed = {"rtol": self._tolerance, "atol": self._tolerance * self._nominals}
        first = None if self._step is None else min(self._step, goal - instance.time)
        if not np.all(np.isfinite(rates(instance.time, states))):
            raise instance.error("has rates that are not finite", "Check its inputs at that time")
        solver = DOP853(rates, instance.time, states, goal, first_step=first, **allowed)
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise instance.error(f"cannot be integrated ({message})", "Check its inputs at that time")
            time, states = solver.t, solver.y
            put(time, states)
            event = bool(np.any(self._signs() != self._positive))
            if event:
                time, states = self._locate(solver, put)
            instance.time = time
            wanted, end = instance.call("the end of a step", "completedIntegratorStep", False)
            if end:
                raise instance.error("requested the end of the run", "End the run earlier")
            if event or wanted:
                return states, True
            if solver.status == "running":
                self._step = solver.h_abs
        return states, False

    def _locate(self, solver: DOP853, put: Callable[[float, np.ndarray], None]) -> tuple[float, np.ndarray]:
        """Time and states just after the first sign change in the last step; the instance is set there."""
        between = solver.dense_output()
        before, after = solver.t_old, solver.t
        while before < (middle := 0.5 * (before + after)) < after:
            put(middle, between(middle))
            if np.any(self._signs() != self._positive):
                after = middle
            else:
                before = middle
        states = solver.y if after == solver.t else between(after)
        put(after, states)
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
        self._put(saved.time, saved.states)

    def forget(self, saved: IntegratorState) -> None:
        """Frees a saved state."""
        if saved.kept is not None:
            self._instance.forget(saved.kept)
