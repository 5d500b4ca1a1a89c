"""Components whose equations are code from outside, with events of their own: located within a step by bisection."""

from __future__ import annotations

import numpy as np

from ropeway.components.errors import SimulationError
from ropeway.components.external_events import ExternalPoint
from ropeway.systems.dynamics.event_stepper import EventStepper
from ropeway.systems.dynamics.inertia.inertial_stepper import InertialStepper
from ropeway.systems.dynamics.recorder import Checkpoint, Recorder
from ropeway.systems.modelling.system import System
from ropeway.systems.results.run_data import Event
from ropeway.systems.statics.line_state import LineState

_FIRST_STEP, _LONGEST_STEP, _GROWTH = 0.05, 1.0, 1.5
"""Time between two checks of the event indicators after an event, at most [s], and the factor by which it grows."""
_RESOLUTION = 1e-9
"""Resolution of the time of an event [s]."""
_TRIALS = 60
_MOST_EVENTS = 100
"""Largest number of events at one time."""


class ExternalParts:
    """The components of a system that have events of their own; `ended`: one of them has ended the run."""

    def __init__(self, system: System, stepper: EventStepper | InertialStepper, recorder: Recorder) -> None:
        self._stepper, self._recorder = stepper, recorder
        found = ((name, component.external_events) for name, component in system.components.items())
        self._parts = {name: events for name, events in found if events is not None}
        self.ended = False
        self._step = _FIRST_STEP
        if self._parts:  # a step of the line that is linear would lose the second order of other equations
            self._stepper.line.tiny = self._stepper.line.linear = _RESOLUTION

    @property
    def present(self) -> bool:
        """Whether there are any."""
        return bool(self._parts)

    def run_to(self, stop: float) -> None:
        """Advances to a time [s] through all events before it and at it, or until a component ends the run. Raises
        EquilibriumError, SimulationError."""
        if not self._parts:
            self._stepper.run_to(stop)
            return
        state = self._stepper.state
        while state.point.t < stop and not self.ended:
            goal = min(stop, state.point.t + self._step, max(self._next_time(), state.point.t))
            if goal > state.point.t:
                before, mark, margin = state.copy(), self._recorder.checkpoint(), self._margin()
                self._stepper.run_to(goal)
                self._step = min(_GROWTH * self._step, _LONGEST_STEP)
                if self._margin() <= 0.0 < margin:
                    self._locate(before, mark, margin)
                    self._step = _FIRST_STEP
            self._handle()
            state = self._stepper.state

    def _point(self, name: str, state: LineState) -> ExternalPoint:
        events, model, point = self._parts[name], state.model, state.point
        inputs = [
            point.u[model.u.index[full]] if (full := f"{name}.{n}") in model.u.index else point.z[model.z.index[full]]
            for n in events.inputs
        ]
        states = [point.x[model.x.index[f"{name}.{n}"]] for n in events.states]
        return ExternalPoint(point.t, np.array(states), np.array(inputs), self._mode(name, state))

    def _mode(self, name: str, state: LineState) -> int:
        return int(state.point.d[state.model.d.index[f"{name}.{self._parts[name].mode}"]])

    def _next_time(self) -> float:
        state = self._stepper.state
        return min(events.next_time(self._mode(name, state)) for name, events in self._parts.items())

    def _margin(self) -> float:
        """Least distance to a state event, not positive beyond it."""
        state = self._stepper.state
        return min(events.margin(self._point(name, state)) for name, events in self._parts.items())

    def _due(self) -> list[str]:
        """Components with an event now."""
        state = self._stepper.state
        return [
            name
            for name, events in self._parts.items()
            if events.next_time(self._mode(name, state)) <= state.point.t + _RESOLUTION
            or events.margin(self._point(name, state)) <= 0.0
        ]

    def _locate(self, before: LineState, mark: Checkpoint, margin: float) -> None:
        """Goes back from the present state to just after the first state event since `before`, by the Illinois method;
        `margin`: the distance before it."""
        stepper, early = self._stepper, before.point.t
        late, beyond, side = stepper.state.point.t, self._margin(), 0
        for trial in range(_TRIALS):  # every third is a bisection: the indicator may be zero at the start
            share = margin / (margin - beyond) if trial % 3 and np.isfinite(margin) else 0.5
            guess = early + share * (late - early) + 0.5 * _RESOLUTION
            if guess >= late - 0.5 * _RESOLUTION:
                break
            stepper.line.state = before.copy()
            self._recorder.rewind(mark)
            stepper.disturb()
            stepper.run_to(guess)
            found = self._margin()
            if found > 0.0:
                before, mark = stepper.state.copy(), self._recorder.checkpoint()
                early, margin, beyond, side = guess, found, beyond / 2.0 if side > 0 else beyond, 1
            else:
                late, beyond, margin, side = guess, found, margin / 2.0 if side < 0 else margin, -1
        if stepper.state.point.t != late:
            stepper.line.state = before
            self._recorder.rewind(mark)
            stepper.disturb()
            stepper.run_to(late)

    def _handle(self) -> None:
        """All events at the present time, with an entry before and after them."""
        for count in range(_MOST_EVENTS):
            due = self._due()
            if not due:
                return
            stepper, state = self._stepper, self._stepper.state
            if count == 0:
                self._recorder.record(state)
            for name in due:
                outcome = self._parts[name].update(self._point(name, state))
                state.point.d[state.model.d.index[f"{name}.{self._parts[name].mode}"]] = outcome.mode
                for n, value in zip(self._parts[name].states, outcome.states, strict=True):
                    state.point.x[state.model.x.index[f"{name}.{n}"]] = value
                what = "event" if outcome.ended is None else "end of the run"
                self._recorder.events.append(Event(state.point.t, name, what, np.nan))
                self.ended |= outcome.ended is not None
            stepper.disturb()
            stepper.line.solve(state.point.t + 1.0)
            self._recorder.record(state)
            if self.ended:
                return
        time = self._stepper.state.point.t
        raise SimulationError(
            f"{due[0]!r} has more than {_MOST_EVENTS} events at t = {time:.9g} s", "Check its inputs at that time", time
        )
