"""A schedule as an optimisation: speeds linear between grid times, travels their exact quadratics, and the line's
own equations at grid times and on both sides of each crossing, whose time is free."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import casadi as ca
import numpy as np

from ropeway.components.control_sheave import ControlSheave
from ropeway.systems.dynamics.result import Result
from ropeway.systems.solvers.points import Point
from ropeway.systems.studies.control.scheduling.nonlinear_program import Linear, Solution, Term, Uses, solve
from ropeway.systems.studies.control.scheduling.sample_times import SampleTime, shares
from ropeway.systems.studies.control.scheduling.section_equations import FORCE, LineEquations, SectionTerm
from ropeway.systems.studies.control.scheduling.terms import MOTION, SMOOTH, Parts, Task, bounds_of, motion
from ropeway.systems.studies.control.scheduling.variable_index import Label, Numbers, Sample

STEADINESS = 0.02
"""Weight of the squared changes of speed [s2/m2] in an objective of about one: it selects one of several schedules that
are equally good."""


class ScheduleProblem:
    """The problem around a run of the line with a schedule of `speeds` (driven, grid) [m/s]."""

    def __init__(
        self,
        equations: LineEquations,
        parts: Parts,
        task: Task,
        result: Result,
        moments: list[SampleTime],
        speeds: np.ndarray,
    ) -> None:
        self.equations, self.task, self.result, self.moments = equations, task, result, moments
        self.parts = parts
        self.sections = equations.sections()
        self.step = float(task.grid[1] - task.grid[0])
        self.numbers = Numbers()
        self.points: dict[int, Point] = {}
        self.uses: list[Uses] = []
        self.labels: list[Label] = []
        self.rows: tuple[list[list[int]], list[list[float]], list[float], list[float]] = ([], [], [], [])
        self._drives(speeds)
        self._moments(speeds)
        self.slack = {
            limit: self.numbers.add(0.0, 0.0)[0]
            for limit in (
                ("tension_low", "tension_high", *sorted({r.limit for rows in task.bounds.rows for r in rows}), *MOTION)
                if task.relaxed
                else ()
            )
        }
        self._limits_of_motion()
        self.peak = self.numbers.add(0.0)[0] if "peak tension" in task.weights else -1
        self._samples()
        self._sections()
        self._sheaves()
        self._objective()

    def point(self, record: int) -> Point:
        """The solved point of a record."""
        if record not in self.points:
            self.points[record] = self.result.record(record).point
        return self.points[record]

    # motion of the driven supports

    def _drives(self, speeds: np.ndarray) -> None:
        """Speeds and travels at grid times; travels differ from the speeds' integrals as far as they do in the run,
        where a drive follows with a lag."""
        task, h = self.task, self.step
        count = len(task.grid)
        self.v = np.empty(speeds.shape, dtype=int)
        self.q = np.empty(speeds.shape, dtype=int)
        at_grid = {m.grid: self.point(m.after) for m in self.moments if m.grid >= 0}
        places = self.equations.layout.travel.state[self.equations.driven]
        travel = np.array([[at_grid[j].x[k] for j in range(count)] for k in places])
        integral = np.concatenate(
            [np.zeros((len(speeds), 1)), np.cumsum(h * (speeds[:, 1:] + speeds[:, :-1]) / 2.0, axis=1)], axis=1
        )
        self.lag = travel - integral
        for i, fixed in enumerate(task.fixed):
            held = np.zeros(count, dtype=bool)
            held[0] = True
            held |= fixed
            self.v[i] = self.numbers.add(
                speeds[i], np.where(held, speeds[i], -np.inf), np.where(held, speeds[i], np.inf)
            )
            free = np.full(count, np.inf)
            free[0] = 0.0
            self.q[i] = self.numbers.add(travel[i], travel[i] - free, travel[i] + free)
            for j in range(count - 1):
                change = self.lag[i, j + 1] - self.lag[i, j]
                columns = [self.q[i, j + 1], self.q[i, j], self.v[i, j], self.v[i, j + 1]]
                self._row(columns, [1.0, -1.0, -h / 2.0, -h / 2.0], change, change)

    def _row(self, columns: list[int], factors: list[float], low: float, high: float) -> None:
        rows = self.rows
        rows[0].append(columns)
        rows[1].append(factors)
        rows[2].append(low)
        rows[3].append(high)

    def _limits_of_motion(self) -> None:
        """Rows on speed and acceleration."""
        task, h = self.task, self.step
        self.motion_rows: list[tuple[int, str, int, int]] = []
        for i, fixed in enumerate(task.fixed):
            if fixed:
                continue
            low, high = task.speed[i]
            for j in range(1, len(task.grid)):
                self._bounded([self.v[i, j]], [1.0], low, high, "speed", i, j)
                most = task.acceleration * h
                self._bounded([self.v[i, j], self.v[i, j - 1]], [1.0, -1.0], -most, most, "acceleration", i, j)

    def _bounded(
        self, columns: list[int], factors: list[float], low: float, high: float, limit: str, i: int, j: int
    ) -> None:
        if not self.task.relaxed:
            self.motion_rows.append((len(self.rows[0]), limit, i, j))
            self._row(columns, factors, low, high)
            return
        unit = self.step if limit == "acceleration" else 1.0
        for sign, bounds in ((1.0, (low, np.inf)), (-1.0, (-np.inf, high))):
            self.motion_rows.append((len(self.rows[0]), limit, i, j))
            self._row([*columns, self.slack[limit]], [*factors, sign * unit], *bounds)

    # moments and samples

    def _moments(self, speeds: np.ndarray) -> None:
        """Free times of crossings, and travels and speeds of the driven supports there."""
        grid, h = self.task.grid, self.step
        last = len(grid) - 1
        self.tau = np.full(len(self.moments), -1)
        self.q_at: dict[tuple[int, int], int] = {}
        self.v_at: dict[tuple[int, int], int] = {}
        columns, parameters = [], []
        places = self.equations.layout.travel.state[self.equations.driven]
        for m, moment in enumerate(self.moments):
            if moment.grid >= 0:
                continue
            j = int(np.clip(np.floor(moment.time / h), 0, last - 1))
            slackness = h if moment.crossings else 0.0
            low, high = max(moment.time - slackness, min(0.0, moment.time)), moment.time + slackness
            self.tau[m] = self.numbers.add(moment.time, low, high)[0]
            for i in self.near(moment):
                point, share = self.point(moment.before), moment.time / h - j
                speed = speeds[i, j] + share * (speeds[i, j + 1] - speeds[i, j])
                q = self.numbers.add(point.x[places[i]])[0]
                if moment.crossings and moment.crossings[0].support == self.equations.driven[i]:
                    self.numbers.low[q] = self.numbers.high[q] = moment.crossings[0].travel
                self.q_at[m, i], self.v_at[m, i] = q, self.numbers.add(speed)[0]
                around = [self.v[i, k] for k in np.clip([j - 1, j, j + 1, j + 2], 0, last)]
                columns.append([q, self.v_at[m, i], self.tau[m], self.q[i, j], *around])
                slope = (self.lag[i, j + 1] - self.lag[i, j]) / h
                here = point.x[places[i]] - self._integral(speeds, i, j, share)
                parameters.append([grid[j], self.lag[i, j], here - slope * h * share, slope])
        self.uses.append(
            Uses(
                motion(h),
                np.array(columns, dtype=int).reshape(-1, 8).T,
                np.array(parameters).reshape(-1, 4).T,
                np.zeros((2, len(columns))),
                np.zeros((2, len(columns))),
            )
        )
        self.labels.append(Label((), ()))
        for section in self.sections:
            own = [m for m, moment in enumerate(self.moments) if moment.touches(section)]
            for a, b in pairwise(own):
                # A little overlap is allowed: the next simulation then has them in the other order.
                self._row([self.tau[b], self.tau[a]], [1.0, -1.0], -h / 4.0, np.inf)

    def _integral(self, speeds: np.ndarray, i: int, j: int, share: float) -> float:
        """Travel by the schedule from the start to a share of interval j."""
        v, h = speeds[i], self.step
        whole = h * np.sum(v[1 : j + 1] + v[:j]) / 2.0
        return float(whole + h * share * (v[j] + share * (v[j + 1] - v[j]) / 2.0))

    def near(self, moment: SampleTime) -> list[int]:
        """Driven supports of the sections that have a sample at a moment."""
        found = set()
        for s in self._sampled(moment):
            found |= {i for i, k in enumerate(self.equations.driven) if k in self.sections[s]}
        return sorted(found)

    def _sampled(self, moment: SampleTime) -> list[int]:
        """Sections with a sample: those that are touched, and their neighbours; all of them at other moments."""
        if not moment.crossings:
            return list(range(len(self.sections)))
        own = [s for s, section in enumerate(self.sections) if moment.touches(section)]
        return sorted({t for s in own for t in (s - 1, s, s + 1) if 0 <= t < len(self.sections)})

    def _samples(self) -> None:
        """Algebraic variables of each section at its moments, before and after its own crossings."""
        self.samples: list[list[Sample]] = [[] for _ in self.sections]
        self.sides: list[dict[int, tuple[int, int]]] = [{} for _ in self.sections]
        for m, moment in enumerate(self.moments):
            for s in self._sampled(moment):
                columns = self.equations.columns(self.sections[s])
                records = [moment.before]
                if moment.touches(self.sections[s]):
                    records.append(moment.after)
                first = len(self.samples[s])
                for record in records:
                    z = self.point(record).z[columns] / self.equations.z_unit[columns]
                    self.samples[s].append(Sample(m, record, self.numbers.add(z)))
                self.sides[s][m] = (first, len(self.samples[s]) - 1)
                crossing = moment.crossings[0] if moment.touches(self.sections[s]) else None
                if crossing is not None and self.sections[s][0] <= crossing.support <= self.sections[s][1]:
                    place = self.equations.layout.travel.algebraic[crossing.support]
                    if place >= 0:
                        number = self.samples[s][first].numbers[int(np.searchsorted(columns, place))]
                        self.numbers.low[number] = self.numbers.high[number] = crossing.travel

    def _counts(self, moment: SampleTime) -> bool:
        return moment.time >= self.task.settle - 1e-9

    def driven_number(self, m: int, kind: str, i: int) -> int:
        moment = self.moments[m]
        if moment.grid >= 0:
            return int((self.q if kind == "q" else self.v)[i, moment.grid])
        return (self.q_at if kind == "q" else self.v_at)[m, i]

    def _sections(self) -> None:
        for s, section in enumerate(self.sections):
            for counts in (False, True):
                part = self.parts.section(s, counts)
                chosen = [x for x in self.samples[s] if self._counts(self.moments[x.moment]) == counts]
                columns = {int(c): n for n, c in enumerate(self.equations.columns(section))}
                self._use(part, [(x.moment, x.record, {c: x.numbers[n] for c, n in columns.items()}) for x in chosen])

    def _sheaves(self) -> None:
        """Limits and costs of the control sheaves, on both sides of the crossings in the sections beside them."""
        task = self.task
        sheaves = [i for i, node in enumerate(self.equations.nodes) if isinstance(node, ControlSheave)]
        # The root of the mean square, by its value and slope at the present deviation.
        square = task.weights.get("tension deviation", 0.0) * FORCE**2 / (2.0 * task.deviation)
        square /= len(sheaves)
        energy = task.weights.get("energy", 0.0) * FORCE
        for i in sheaves:
            every = self._places(i)
            count = np.array([self._counts(self.moments[m]) for m, _, _ in every])
            times = np.array([self.moments[m].time for m, _, _ in every])
            span = float(np.ptp(times[count])) or 1.0  # from the first moment after settling
            costs = np.array([square / span * shares(times, count), energy * shares(times, np.full(len(times), True))])
            for counts in (False, True):
                chosen = np.flatnonzero(count == counts)
                places = [every[k] for k in chosen]
                self._use(self.parts.sheave(i, counts), places, costs[:, chosen])
                for row in task.at(counts=counts).rows[i]:
                    if row.limit not in SMOOTH:
                        unit = self.equations.y_unit[self.equations.model.y.index[row.output]]
                        values = self.result.full_frame[row.output].to_numpy() / unit
                        near = [x for x in places if row.near(values[x[1]])]
                        self._use(self.parts.bent(i, row, counts), near)

    def _places(self, i: int) -> list[tuple[int, int, dict[int, int]]]:
        """Samples (moment, record, numbers of the algebraic variables) of both sections beside a driven support."""
        k = self.equations.driven[i]
        left, right = (next(s for s, ends in enumerate(self.sections) if ends[e] == k) for e in (1, 0))
        places = []
        for m, moment in enumerate(self.moments):
            if m not in self.sides[left] or m not in self.sides[right]:
                continue
            last = max(b - a for a, b in (self.sides[left][m], self.sides[right][m]))
            for after in range(last + 1):
                numbers: dict[int, int] = {}
                for s in (left, right):
                    sample = self.samples[s][min(self.sides[s][m][0] + after, self.sides[s][m][1])]
                    columns = self.equations.columns(self.sections[s])
                    numbers.update(zip(columns.tolist(), sample.numbers.tolist(), strict=True))
                places.append((m, moment.after if after else moment.before, numbers))
        return places

    def _use(
        self, part: SectionTerm, places: Sequence[tuple[int, int, Mapping[int, int]]], weights: np.ndarray | None = None
    ) -> None:
        """A part at samples (moment, record, numbers of the algebraic variables)."""
        n = len(places)
        variables = np.empty((len(part.variables), n), dtype=int)
        parameters = np.zeros((len(part.discrete) + len(part.states) + len(part.inputs) + 2, n))
        driving = self.numbers.add(np.zeros(n), 0.0) if ("driving", 0) in part.variables else np.zeros(0, dtype=int)
        for c, (m, record, numbers) in enumerate(places):
            point = self.point(record)
            x, u = self.equations.excess(point, self.speeds_at(m))
            parameters[:, c] = np.concatenate(
                [
                    point.d[part.discrete],
                    x[part.states],
                    u[part.inputs],
                    np.zeros(2) if weights is None else weights[:, c],
                ]
            )
            for r, (kind, place) in enumerate(part.variables):
                if kind == "z":
                    variables[r, c] = numbers[place]
                elif kind in ("q", "v"):
                    variables[r, c] = self.driven_number(m, kind, place)
                elif kind == "peak":
                    variables[r, c] = self.peak
                elif kind == "driving":
                    variables[r, c] = driving[c]
                else:
                    variables[r, c] = self.slack[kind.removeprefix("slack ")]
        low, high = bounds_of(part)
        self.uses.append(Uses(part.term, variables, parameters, np.tile(low, (n, 1)).T, np.tile(high, (n, 1)).T))
        self.labels.append(Label(tuple(m for m, _, _ in places), part.rows))
        values = self._values(part.term, variables, parameters) if n else np.zeros((len(low), 0))
        for r, row in enumerate(part.rows, part.residuals):
            if row.peak and n:
                self.numbers.start[self.peak] = max(self.numbers.start[self.peak], float(values[r].max()))
        if len(driving):
            for c in range(n):
                self.numbers.start[driving[c]] = max(0.0, -float(values[-1, c]))

    def _values(self, term: Term, variables: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        start = np.array(self.numbers.start)
        if self.peak >= 0:  # so that its rows are the tensions themselves
            start[self.peak] = 0.0
        return np.array(term.value.map(variables.shape[1])(start[variables], parameters)[1])

    def speeds_at(self, m: int) -> np.ndarray:
        """Speeds of the driven supports at a moment, by the initial guess; zero for those without a sample."""
        found = np.zeros(len(self.equations.driven))
        for i in range(len(found)):
            try:
                found[i] = self.numbers.start[self.driven_number(m, "v", i)]
            except KeyError:
                continue
        return found

    # objective

    def _objective(self) -> None:
        """Costs that are not of the line's parts: highest tension, steadiness, relaxations."""
        if self.task.relaxed:
            self._cost(list(self.slack.values()), [1.0 / self.size(limit) for limit in self.slack])
        elif self.peak >= 0:
            self._cost([self.peak], [self.task.weights["peak tension"] * FORCE])
        w = ca.SX.sym("w", 2)
        free = [i for i, fixed in enumerate(self.task.fixed) if not fixed]
        pairs = [[self.v[i, j], self.v[i, j + 1]] for i in free for j in range(len(self.task.grid) - 1)]
        if pairs:
            term = Term(w, ca.SX(0, 1), ca.SX(0, 1), STEADINESS * (w[1] - w[0]) ** 2)
            self._plain(term, np.array(pairs).T)

    def size(self, limit: str) -> float:
        """The size of a limit, in the problem's units: relaxations count relative to it."""
        task = self.task
        if limit.startswith("tension"):
            return (task.bounds.tension[limit == "tension_high"] or task.bounds.tension[1]) / FORCE
        if limit == "acceleration":
            return task.acceleration
        if limit == "speed":
            return max(abs(bound) for bounds in task.speed for bound in bounds)
        return max((r.size for rows in task.bounds.rows for r in rows if r.limit == limit), default=1.0)

    def unit(self, limit: str) -> float:
        """The problem's unit of a limit, in its own."""
        if limit in MOTION:
            return 1.0
        if limit.startswith("tension"):
            return FORCE
        outputs = [r.output for rows in self.task.bounds.rows for r in rows if r.limit == limit]
        return float(self.equations.y_unit[self.equations.model.y.index[outputs[0]]])

    def _cost(self, numbers: list[int], factors: list[float]) -> None:
        w, p = ca.SX.sym("w"), ca.SX.sym("p")
        self._plain(Term(w, p, ca.SX(0, 1), p * w), np.array([numbers]), np.array([factors]))

    def _plain(self, term: Term, variables: np.ndarray, parameters: np.ndarray | None = None) -> None:
        n = variables.shape[1]
        given = np.zeros((0, n)) if parameters is None else parameters
        self.uses.append(Uses(term, variables, given, np.zeros((0, n)), np.zeros((0, n))))
        self.labels.append(Label((), ()))

    def solve(self, iterations: int, tolerance: float) -> Solution:
        """Solves the problem. Raises Interrupted."""
        numbers = self.numbers
        return solve(
            np.array(numbers.start),
            np.array(numbers.low),
            np.array(numbers.high),
            self.uses,
            Linear(*self.rows),
            iterations=iterations,
            tolerance=tolerance,
        )
