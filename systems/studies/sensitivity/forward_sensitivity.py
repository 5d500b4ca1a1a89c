"""Derivatives along a simulation, from record to record.

Between events the derivatives of the states satisfy the linearised equations. At a crossing they change by the jump of
the rates times the derivative of its time: q_k = X_k - c has d(time) = -d(q_k - X_k + c) / (dq_k/dt). A sample of a
response is a function of the point like any other. The order of events is fixed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from ropeway.components.errors import SimulationError, UnknownNameError
from ropeway.systems.dynamics.line_stepper import rates_of
from ropeway.systems.dynamics.result import Result
from ropeway.systems.dynamics.simulation import update_of
from ropeway.systems.modelling.dae_model import component_of, in_code
from ropeway.systems.solvers.drive_trajectories import drives_of
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.points import Point, Slot
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import find
from ropeway.systems.studies.sensitivity.linearisation import (
    Directions,
    LinearState,
    tangent_of,
    update_jacobian_of,
)
from ropeway.systems.studies.sensitivity.perturbations import Varied

_ACCURACY = 1e-9
"""Relative accuracy of the integration."""


class ForwardSensitivity:
    """Derivatives along a simulation, from record to record, in compiled code or not."""

    def __init__(self, result: Result, varied: Varied, *, compiled: bool = False) -> None:
        self.result = result
        self.model = in_code(result.model, compiled=compiled)
        self.tangent = tangent_of(self.model)
        self.varied = varied
        self.x = varied.x
        """Directions of the states now, (nx, k)."""
        self.kept = np.zeros((len(self.model.kept), varied.p.shape[1]))
        """Directions of the discrete variables that do not follow from the loads."""
        self.travel = np.zeros((len(self.model.z), varied.p.shape[1]))
        """Directions of the travels at the start."""
        self.ticks = [0] * len(self.model.clocks)
        self.before: tuple[Equilibrium, Directions] | None = None

    def step(self, i: int) -> tuple[Equilibrium, Directions]:
        """Advances to a record; returns the line there with all its directions."""
        line = self.result.record(i)
        if self.before is None:
            self._hang(line)
        else:
            last, directions = self.before
            if line.point.t > last.point.t:
                self._move(last, line)
            else:
                self._jump(last, line, directions)
        self.before = line, self._directions(line, line.point, self.x)
        if i == 0:
            for layout in self.model.layouts:
                moving = layout.travel.algebraic[layout.travel.algebraic >= 0]
                self.travel[moving] = self.before[1].z[moving]
        return self.before

    def state(self, now: tuple[Equilibrium, Directions]) -> LinearState:
        """The line at a record, with its derivatives; travel counts from the start."""
        line, directions = now

        def slot(name: str) -> Slot:
            return find(line.model, line.runs, line.passed, name)

        outputs = self.tangent.outputs(line.point, directions)
        return LinearState(line.__getitem__, slot, outputs, directions, self.travel.copy())

    def read(self, now: tuple[Equilibrium, Directions], wanted: Sequence[str]) -> list[np.ndarray]:
        """Derivatives of the wanted values, one row each."""
        line, rows = now[0], list[np.ndarray]()
        state = self.state(now)
        for name in wanted:
            try:
                rows.append(state.rates(name))
            except UnknownNameError:
                if not any(component_of(name) in run.loads.names for run in line.runs):
                    raise
                rows.append(np.full(self.x.shape[1], np.nan))
        return rows

    def _hang(self, line: Equilibrium) -> None:
        """Loads that hang at a distance from a support are clamped to the rope that is there at rest."""
        declared = {
            n: int(k) for run in self.model.runs for n, k in zip(run.loads.names, run.loads.pinned, strict=True)
        }
        if all(k < 0 for k in declared.values()):
            return
        directions = self._directions(line, line.point, self.x, pinned=declared)
        for r, (run, layout) in enumerate(zip(line.runs, self.model.layouts, strict=True)):
            for j in range(self.x.shape[1]):
                travel = layout.travel.read(directions.x[:, j], directions.z[:, j])
                for i, name in enumerate(run.loads.names):
                    if (k := declared.get(name, -1)) >= 0:
                        self.varied.place[r][i, j] = self.varied.start[r][k, j] - travel[k]

    def _directions(
        self, line: Equilibrium, point: Point, x: np.ndarray, pinned: dict[str, int] | None = None
    ) -> Directions:
        """All directions at a solved point of the line, from those of its states."""
        runs = line.runs
        if pinned:
            runs = tuple(
                replace(run, loads=replace(run.loads, pinned=np.array([pinned.get(n, -1) for n in run.loads.names])))
                for run in runs
            )
        d = self.varied.discrete(self.model, runs, line.passed, point)
        d[self.model.kept] += self.kept
        return self.tangent.solve(point, x, self.varied.u, self.varied.p, d)

    def _move(self, a: Equilibrium, b: Equilibrium) -> None:
        """From one record to the next, between which only clocks tick."""
        point = a.point.copy()
        while point.t < b.point.t:
            ticks = [c.phase + n * c.period for c, n in zip(self.model.clocks, self.ticks, strict=True)]
            stop = min([b.point.t, *ticks])
            if stop > point.t:
                point = self._integrated(a, b, point, stop)
            for j in np.flatnonzero(np.abs(np.array(ticks) - stop) <= 1e-9):
                self._tick(int(j), a, point)

    def _tick(self, j: int, line: Equilibrium, point: Point) -> None:
        """Updates the discrete variables and their directions at the tick of a clock."""
        self.ticks[j] += 1
        clock = self.model.clocks[j]
        newton_of(self.model).solve(point)
        directions = self._directions(line, point, self.x)
        rows = np.searchsorted(self.model.kept, clock.entries)
        self.kept[rows] = update_jacobian_of(self.model, clock)(point) @ directions.stacked
        point.d[clock.entries] = update_of(self.model, clock)(*point.arguments)[0]

    def _integrated(self, a: Equilibrium, b: Equilibrium, point: Point, stop: float) -> Point:
        """Integrates the states and their directions to `stop`. Raises SimulationError."""
        m, k, nominal = self.model, self.x.shape[1], self.model.x.nominals
        n = len(nominal)
        slope = (b.point.u - a.point.u) / (b.point.t - a.point.t)
        drives = drives_of(m, _ACCURACY)
        alone = all(drives.decoupled(line.point) for line in (a, b))
        weights = 1.0 / self.varied.nominal
        moving = self._directions(a, point, self.x)

        def at(t: float, values: np.ndarray) -> Point:
            u = a.point.u + (t - a.point.t) * slope
            return replace(point, t=t, x=values[:n] * nominal, u=u)

        def directions(now: Point, values: np.ndarray) -> Directions:
            x = values[n:].reshape(n, k) * nominal[:, None] * weights
            if alone and drives.decoupled(now):  # a limit can become active between two records
                return replace(moving, x=x)
            newton_of(m).solve(now)
            return self._directions(a, now, x)

        def rates(t: float, values: np.ndarray) -> np.ndarray:
            now = at(t, values)
            moves = directions(now, values)
            x = rates_of(m)(*now.arguments)[0] / nominal
            return np.concatenate([x, (self.tangent.rates(now, moves) / nominal[:, None] / weights).ravel()])

        start = np.concatenate([point.x / nominal, (self.x / nominal[:, None] / weights).ravel()])
        solution = solve_ivp(rates, (point.t, stop), start, method="LSODA", rtol=_ACCURACY, atol=_ACCURACY)
        if not solution.success:
            raise SimulationError(
                f"The derivatives cannot be integrated: {solution.message}", "Shorten the run", point.t
            )
        end = solution.y[:, -1]
        self.x = end[n:].reshape(n, k) * nominal[:, None] * weights
        return at(stop, end)

    def _jump(self, a: Equilibrium, b: Equilibrium, directions: Directions) -> None:
        """At a crossing: adds the change of the rates of the states times the derivative of its time."""
        change = rates_of(self.model)(*a.point.arguments)[0].copy()
        change -= rates_of(self.model)(*b.point.arguments)[0]
        nearest, time = np.inf, np.zeros(self.x.shape[1])
        if np.any(np.abs(change) > 1e-12 * self.model.x.nominals):
            nearest, time = self._time_of_crossing(a, b, directions)
        if np.isfinite(nearest):
            self.x = self.x + np.outer(change, time)

    def _time_of_crossing(self, a: Equilibrium, b: Equilibrium, directions: Directions) -> tuple[float, np.ndarray]:
        """Distance of the load that crosses from its support [m], and the directions of the time (k,)."""
        m, point = self.model, a.point.copy()
        z = newton_of(m).solve(point, slope=np.zeros(len(m.u)))
        rates = m.travels(rates_of(m)(*point.arguments)[0], np.zeros(0) if z is None else z)
        travels = m.travels(point.x, point.z)
        best, time = np.inf, np.zeros(self.x.shape[1])
        for r, (run, layout) in enumerate(zip(a.runs, m.layouts, strict=True)):
            for k in np.flatnonzero(a.passed[r] != b.passed[r]):
                load = int(min(a.passed[r][k], b.passed[r][k]))
                gap = abs(layout.start(point.p)[k] - run.loads.place[load] - travels[r][k])
                if gap < best and rates[r][k] != 0.0:
                    travel = np.array(
                        [layout.travel.read(x, z)[k] for x, z in zip(directions.x.T, directions.z.T, strict=True)]
                    )
                    best = gap
                    time = -(travel - self.varied.start[r][k] + self.varied.place[r][load]) / rates[r][k]
        return best, time
