"""The solution of a schedule problem: speeds, the state of the line, active limits, relaxations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from ropeway.systems.solvers.newton import outputs_of
from ropeway.systems.studies.control.scheduling.nonlinear_program import Solution
from ropeway.systems.studies.control.scheduling.problem import ScheduleProblem
from ropeway.systems.studies.control.scheduling.section_equations import DRIVING, side

_REACHED, _MULTIPLIER = 1e-3, 1e-7
"""A limit counts as reached when its row is as near to it [the problem's units], with a multiplier as large."""


@dataclass(frozen=True)
class Active:
    """An active limit: its name, component, time [s], bound and size, and the change of the objective per unit."""

    limit: str
    component: str
    time: float
    bound: float
    size: float
    multiplier: float


@dataclass(frozen=True)
class Planned:
    """A solved problem: speeds (driven, grid) [m/s], times of the moments [s], the state of the line as a frame,
    active limits, relaxations by limit, and the result of IPOPT."""

    speeds: np.ndarray
    times: np.ndarray
    frame: pd.DataFrame
    active: list[Active]
    relaxation: dict[str, float]
    solution: Solution


def planned(problem: ScheduleProblem, iterations: int, tolerance: float) -> Planned:
    """Solves a problem."""
    solution = problem.solve(iterations, tolerance)
    w = solution.variables
    times = np.array([w[problem.tau[m]] if at.grid < 0 else at.time for m, at in enumerate(problem.moments)])
    return Planned(
        w[problem.v],
        times,
        planned_frame(problem, w, times),
        active_limits(problem, solution, times),
        {limit: float(w[k]) for limit, k in problem.slack.items()},
        solution,
    )


def planned_frame(problem: ScheduleProblem, w: np.ndarray, times: np.ndarray) -> pd.DataFrame:
    """The state of the line at the moments, on both sides, as `Result.full_frame` has it; NaN where a section has
    no sample."""
    equations, known = problem.equations, problem.result.full_frame
    model, rows, index = equations.model, [], []
    travels, count = equations.layout.travel.state[equations.driven], len(equations.driven)
    for m in np.argsort(times, kind="stable"):
        moment = problem.moments[m]
        for record in dict.fromkeys((moment.before, moment.after)):
            old = problem.point(record)
            x, z, u = (np.full(len(table), np.nan) for table in (model.x, model.z, model.u))
            speed = np.full(count, np.nan)
            for i in range(count) if moment.grid >= 0 else problem.near(moment):
                x[travels[i]] = w[problem.driven_number(m, "q", i)]
                speed[i] = w[problem.driven_number(m, "v", i)]
            more_x, more_u = equations.excess(old, problem.speeds_at(m))
            of_x, of_u = equations.owners
            for k, (i, travel) in enumerate(of_x):
                x[k] = x[k] if travel else speed[i] + more_x[k]
            for k, i in enumerate(of_u):
                u[k] = speed[i] + more_u[k]
            for s, sides in enumerate(problem.sides):
                if m in sides:
                    sample = problem.samples[s][sides[m][0] if record == moment.before else sides[m][1]]
                    columns = equations.columns(problem.sections[s])
                    z[columns] = w[sample.numbers] * equations.z_unit[columns]
            y = outputs_of(model)(np.array([times[m]]), x, z, u, old.p, old.d)[0]
            rows.append(np.concatenate([y, z, x, u]))
            index.append(times[m])
    names = (*model.y.names, *model.z.names, *model.x.names, *model.u.names)
    frame = pd.DataFrame(rows, pd.Index(index, name="time"), names)[list(known.columns)]
    frame.attrs = dict(known.attrs)
    return frame


def active_limits(problem: ScheduleProblem, solution: Solution, times: np.ndarray) -> list[Active]:
    """Limits that are reached and have a multiplier."""
    equations, found, offset = problem.equations, [], 0
    reached = np.abs(solution.multipliers) > _MULTIPLIER
    for use, label in zip(problem.uses, problem.labels, strict=True):
        m = use.low.shape[0]
        for c, moment in enumerate(label.moments):
            for r, row in enumerate(label.rows, m - len(label.rows)):
                at = offset + c * m + r
                bound = row.high if solution.multipliers[at] > 0.0 else row.low
                if row.peak or row.limit == DRIVING or not reached[at]:
                    continue
                if not problem.task.relaxed and abs(solution.rows[at] - bound) > _REACHED:
                    continue
                unit = equations.y_unit[equations.model.y.index[row.output]]
                name = side(row.limit, high=solution.multipliers[at] > 0.0)
                cost = float(abs(solution.multipliers[at]) / unit)
                size = problem.size(name) * unit
                found.append(Active(name, row.output, float(times[moment]), float(bound * unit), float(size), cost))
        offset += m * use.n
    for k, limit, i, j in problem.motion_rows:
        at = offset + k
        if reached[at]:
            bound = (problem.rows[3] if solution.multipliers[at] > 0.0 else problem.rows[2])[k]
            unit = problem.step if limit == "acceleration" else 1.0
            name, when = equations.nodes[i].name, float(problem.task.grid[j])
            cost = float(abs(solution.multipliers[at]) * unit)
            found.append(Active(limit, name, when, float(bound / unit), problem.size(limit), cost))
    return found
