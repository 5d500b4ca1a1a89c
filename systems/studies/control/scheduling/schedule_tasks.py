"""Tasks of schedules: bounds on the outputs and speeds of a line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from ropeway.components.control_sheave import ControlSheave
from ropeway.components.errors import InputError
from ropeway.components.node import Node
from ropeway.components.schedule import Schedule
from ropeway.systems.studies.control.scheduling.limits import HYDRAULIC, ScheduleLimits
from ropeway.systems.studies.control.scheduling.line_runs import TENSIONS, Baseline, LineRuns
from ropeway.systems.studies.control.scheduling.plan_check import PEAK_GAP, SPARE, Simulated
from ropeway.systems.studies.control.scheduling.section_equations import Constraint, LineEquations, drive_parameters
from ropeway.systems.studies.control.scheduling.terms import Bounds, Task

_REACH = 0.15
"""Share of a line's highest speed by which a plan may leave the line's own, or m/s for a line that stands."""


@dataclass(frozen=True, eq=False)
class ScheduleTasks:
    """Makes the tasks of a line's schedules, within limits."""

    limits: ScheduleLimits
    runs: LineRuns
    baseline: Baseline

    def task(self, weights: Mapping[str, float], first: Simulated, *, held: bool) -> Task:
        """The task of the problems around the simulation `first` and later ones; held: speeds are not changed. Raises
        InputError."""
        equations = first.equations
        bounds = Bounds(self.baseline.tension, tuple(self._rows(equations, node) for node in equations.nodes))
        fixed = tuple(held or n.name == self.runs.lead or n.name not in self.runs.names for n in equations.nodes)
        return Task(
            grid=self.runs.grid,
            weights=weights,
            bounds=bounds,
            early=self._early(bounds, first),
            fixed=fixed,
            speed=tuple(self._speed_range(node.name) for node in equations.nodes),
            acceleration=self.limits.acceleration,
            target=self.baseline.target,
            deviation=1.0,
            settle=self.baseline.settle,
        )

    def allows(self, name: str, schedule: Schedule) -> bool:
        """Whether a sheave's schedule is within the limits of speed and acceleration."""
        speeds = np.array(schedule.speeds)
        low, high = self._speed_range(name)
        if speeds.min() < low or speeds.max() > high:
            return False
        steepest = np.abs(np.diff(speeds)).max() / self.runs.step
        return bool(steepest <= self.limits.acceleration) or name == self.runs.lead

    def _early(self, bounds: Bounds, first: Simulated) -> Bounds:
        """The bounds before `settle`. A limit that the line's start exceeds is wider, by as much as the start and the
        sheaves need until they are in balance; so is the default of the lowest tension. No tension is higher than the
        highest with sheaves in balance."""
        balanced = self.baseline.balanced.full_frame
        before = pd.concat([first.result.full_frame.iloc[:1], balanced[balanced.index < self.baseline.settle]])
        ends = before.filter(regex=TENSIONS)
        low, high = bounds.tension
        if self.limits.tension_low is None or ends.iloc[0].min() < low:
            low = min(low, float(ends.min(axis=None)) - PEAK_GAP)
        high = min(high, float(balanced.filter(regex=TENSIONS).max(axis=None)) + PEAK_GAP)
        if ends.iloc[0].max() > high:
            high = float(ends.max(axis=None)) + PEAK_GAP
        return Bounds((low, high), tuple(tuple(_wider(row, first, before) for row in rows) for rows in bounds.rows))

    def _rows(self, equations: LineEquations, node: Node) -> tuple[Constraint, ...]:
        if not isinstance(node, ControlSheave):
            return ()
        hydraulic = drive_parameters(equations.model, node, equations.parameters, tuple(HYDRAULIC.values()))
        rows = []
        for output, (low, high, limit) in self.limits.outputs(node.name, hydraulic).items():
            name = f"{node.name}.{output}"
            if name not in equations.model.y.index:
                raise InputError(f"{node.name!r} has no {output}: its drive is ideal", "Limit force and power instead")
            unit = equations.y_unit[equations.model.y.index[name]]
            rows.append(Constraint(name, low / unit, high / unit, limit))
        return tuple(rows)

    def _speed_range(self, name: str) -> tuple[float, float]:
        if self.limits.speed is not None:
            return self.limits.speed
        speeds = self.runs.own_speed(name).on(self.runs.grid.tolist()).speeds
        reach = _REACH * (max(map(abs, speeds)) or 1.0)
        return min(speeds) - reach, max(speeds) + reach


def _wider(row: Constraint, run: Simulated, before: pd.DataFrame) -> Constraint:
    """A row with bounds that the values of a time keep too, where the first of them does not keep its own."""
    unit = run.equations.y_unit[run.equations.model.y.index[row.output]]
    values, spare = before[row.output] / unit, SPARE * row.size
    if row.low <= values.iloc[0] <= row.high:
        return row
    return replace(row, low=min(row.low, values.min() - spare), high=max(row.high, values.max() + spare))
