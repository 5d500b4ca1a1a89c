"""A run of a system as the source of a fit: a simulation from rest whose inputs are given over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ropeway.components.errors import InputError
from ropeway.components.schedule import Schedule
from ropeway.components.variable import Kind
from ropeway.systems.dynamics.simulation import simulate
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.statics.line_state import find
from ropeway.systems.studies.fitting.line_source import LineSource, measurable, pretensions
from ropeway.systems.studies.fitting.rope_points import RETURN_TIME, return_time, rope_points
from ropeway.systems.studies.fitting.sources import Source, States
from ropeway.systems.studies.sensitivity.forward_sensitivity import ForwardSensitivity
from ropeway.systems.studies.sensitivity.linearisation import LinearState
from ropeway.systems.studies.sensitivity.perturbations import Varied
from ropeway.systems.studies.sensitivity.reading import Reading

_NEAR = 1e-6
"""Distance of a time from the regular grid, relative to its interval."""
_TOLERANCE = 1e-8
"""Tolerance of the simulations."""
_MOST = 100_000
"""Largest number of times of a grid."""


class RunSource(Source):
    """A system in time, by the names of its quantities at rest."""

    def __init__(self, line: LineSource) -> None:
        self.line, self.name = line, line.name

    def role(self, name: str) -> str:
        return self.line.role(name)

    def unit(self, name: str) -> str:
        return self.line.unit(name)

    def declared(self, name: str) -> float:
        if name in self.line.model.u.index and isinstance(
            self.line.model.signals[self.line.model.u.index[name]], Schedule
        ):
            raise InputError(f"{name} follows a schedule and cannot be free", "Declare it as a number")
        return self.line.declared(name)

    def states(self, free: Sequence[str], given: Sequence[str], values: np.ndarray, time: np.ndarray | None) -> States:
        if time is None:
            raise InputError("The series has no times", "Map a column to 'time'")
        for name in given:
            if name not in self.line.model.u.index:
                raise InputError(f"{name} cannot be given over time", "Only inputs, such as speeds, vary in a run")
        return RunStates(self.line, free, dict(zip(given, values.T, strict=True)), time)


class RunStates(States):
    """The line at each time of a series."""

    def __init__(
        self, source: LineSource, free: Sequence[str], inputs: Mapping[str, np.ndarray], time: np.ndarray
    ) -> None:
        self.source, self.free, self.time = source, list(free), time
        self.every, self.places = _grid(time)
        self.inputs: dict[str, Any] = {name: _signal(time, values) for name, values in inputs.items()}
        self._lines: list[Equilibrium] = []

    def predict(self, values: Mapping[str, float]) -> list[LinearState]:
        model, rest = self.source.model, self.source.rest
        own = self.source.spread(values)
        start = equilibrium(model, start=rest, parameters=own)
        inputs = {name: value for name, value in own.items() if name in model.u.index}
        until = float(self.time[-1])
        result = simulate(
            model, until, every=self.every, inputs={**self.inputs, **inputs}, start=start, tolerance=_TOLERANCE,
            progress=False,
        )  # fmt: skip
        forward = ForwardSensitivity(result, Varied.of(result.record(0), self.free, pretensions(values)))
        on_grid, lines = list[LinearState](), list[Equilibrium]()
        for i in range(len(result.records)):
            now = forward.step(i)
            if result.on_grid[i]:
                on_grid.append(forward.state(now))
                lines.append(now[0])
        self._lines = [lines[k] for k in self.places]
        return [on_grid[k] for k in self.places]

    def reading(self, state: int, name: str) -> Reading:
        line, (owner, _, quantity) = self._lines[state], name.rpartition(".")
        if quantity == RETURN_TIME:
            return return_time(line.model, line.runs, owner)
        kind, _ = find(line.model, line.runs, line.passed, name)
        if kind is Kind.PARAMETER:
            raise InputError(f"{name} is not measured over time", "Give it in free")
        return Reading((name,))

    def points(self, state: int, span: str, at: np.ndarray) -> Reading:
        line = self._lines[state]
        return rope_points(line.model, line.runs, span, at)

    def candidates(self, state: int) -> Sequence[str]:
        return measurable(self._lines[state])

    def label(self, state: int) -> str:
        return f"time {self.time[state]:g} s"


def _grid(time: np.ndarray) -> tuple[float, np.ndarray]:
    """The interval of a regular grid from 0 [s], and the place of each time on it. Raises InputError."""
    if len(time) == 0 or np.any(np.diff(time) <= 0.0) or time[0] < 0.0 or time[-1] <= 0.0:
        raise InputError(
            "The times do not increase from 0", "Sort the rows, and count the times from the start at rest"
        )
    steps = np.diff(time, prepend=0.0)
    every = float(steps[steps > 0.0].min())
    places = np.round(time / every)
    if np.any(np.abs(time / every - places) > _NEAR * np.maximum(places, 1.0)) or places[-1] > _MOST:
        raise InputError(
            f"The times are not multiples of {every:g} s", "Give rows at a regular interval; rows may be missing"
        )
    return every, places.astype(int)


def _signal(time: np.ndarray, values: np.ndarray) -> float | Schedule:
    """An input that is given at times, linear between them."""
    if np.all(values == values[0]):
        return float(values[0])
    first = [] if time[0] == 0.0 else [0.0]
    return Schedule([*first, *time.tolist()], [*([values[0]] if first else []), *values.tolist()])
