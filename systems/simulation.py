"""A line in time: IDAS between events, loads that cross supports, and what is written down."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from ropeway.components import check
from ropeway.components.errors import InputError, RopewayError, SimulationError, UnknownNameError
from ropeway.components.schedule import Schedule
from ropeway.systems import crossing as loads
from ropeway.systems.assembly import assemble
from ropeway.systems.blocks import blocks_of
from ropeway.systems.equilibrium import Equilibrium, equilibrium
from ropeway.systems.idas import Idas
from ropeway.systems.model import Model, nearest
from ropeway.systems.newton import Buffered, expanded, newton_of
from ropeway.systems.progress import bar
from ropeway.systems.result import Event, Result
from ropeway.systems.state import LineState, Record
from ropeway.systems.system import System

Signal = float | Schedule


def simulate(
    system: System | Model,
    until: float,
    *,
    every: float = 1.0,
    inputs: Mapping[str, Signal] | None = None,
    start: Equilibrium | None = None,
    tolerance: float = 1e-6,
    stop_at: Sequence[str] = (),
    progress: bool | None = None,
) -> Result:
    """Simulate a system from its equilibrium.

    until: end [s]; every: interval of the result's frame [s]; inputs: constant or Schedule for each input
    left open, or in place of a component's own (`{"c1.speed": 1.02}`); start: an equilibrium to start from;
    tolerance: of IDAS, absolute on scaled variables; stop_at: names of events at which to stop;
    progress: show a bar (by default only on a terminal).

    Raises InputError before the run; SimulationError, with the result so far, when it cannot go on.
    """
    check.positive(until, "simulate", "until", "s")
    check.positive(every, "simulate", "every", "s")
    check.positive(tolerance, "simulate", "tolerance")
    model = system if isinstance(system, Model) else assemble(system)
    signals = _signals(model, inputs or {}, until)
    known = {*model.limits.events, "load held"}
    if unknown := [event for event in stop_at if event not in known]:
        raise InputError(f"A run cannot stop at {unknown[0]!r}", f"Events are {', '.join(sorted(known))}")
    rest = equilibrium(model) if start is None else start
    run = _Simulation(rest, signals, tolerance, tuple(stop_at))
    with bar("simulate", until, progress) as advance:
        try:
            run.go(until, every, advance)
        except SimulationError as error:
            error.result = run.result()
            raise
        except RopewayError as error:
            t = run.state.point.t
            raise SimulationError(f"At t = {t:.6f} s: {error.cause}", error.remedy, t, run.result()) from error
    return run.result()


def _signals(model: Model, inputs: Mapping[str, Signal], until: float) -> tuple[Signal, ...]:
    """What drives each input of the model."""
    for name in inputs:
        if name not in model.u.index:
            raise UnknownNameError(f"{name!r} is not an input of {model.name!r}", nearest(name, model.u.names))
    signals: list[Signal] = []
    for name, own in zip(model.u.names, model.signals, strict=True):
        signal = inputs.get(name, own)
        if signal is None:
            raise InputError(f"Input {name!r} is open", f"Give it: simulate(..., inputs={{{name!r}: 1.0}})")
        if isinstance(signal, Schedule):
            if signal.times[-1] < until:
                raise InputError(
                    f"The schedule of {name!r} ends at {signal.times[-1]:g} s, the run at {until:g} s",
                    "Make the schedule longer or the run shorter",
                )
        else:
            check.number(signal, f"Input {name!r}", "value")
        signals.append(signal)
    return tuple(signals)


class _Motion(NamedTuple):
    """Rates at a point [per s]: of the states, of the algebraic variables, and of each run's travels."""

    x: np.ndarray
    z: np.ndarray
    travel: list[np.ndarray]


class _Simulation:
    """One run. `state` moves on in place; records and events are appended."""

    short = 5e-3
    """Stretches up to this [s] are one trapezoidal step: they bring a load onto its support."""
    tiny = 1e-4
    """Stretches up to this [s] are a straight line: the second order is below rounding."""

    def __init__(
        self, start: Equilibrium, signals: Sequence[Signal], tolerance: float, stop_at: tuple[str, ...]
    ) -> None:
        self.state = LineState(start.model, start.point.copy(), start.runs, start.passed)
        self.state.unpin()
        self.signals = signals
        self.tolerance = tolerance
        self.stop_at = stop_at
        self.records: list[Record] = []
        self.on_grid: list[bool] = []
        self.events: list[Event] = []
        self.breaks = np.unique(np.concatenate([[], *(s.breaks() for s in signals if isinstance(s, Schedule))]))

    def result(self) -> Result:
        """Everything so far."""
        state = self.state
        return Result(
            state.model,
            tuple(state.runs),
            state.point.p,
            tuple(self.records),
            np.array(self.on_grid, dtype=bool),
            tuple(self.events),
        )

    def go(self, until: float, every: float, advance: Callable[[float], None]) -> None:
        """Runs to the end."""
        self.set_time(0.0)
        motion = self.solve(until)
        self.record(on_grid=True)
        count, grid = 1, min(every, until)
        while True:
            t = self.state.point.t
            stop = min([grid, *self.breaks[self.breaks > t + 1e-9][:1]])
            coming = loads.next_crossing(self.state, motion.travel)
            h = stop - t if coming is None else min(stop - t, max(coming.time, 0.0))
            on_sheave = bool(self.state.held)
            before = self.state.copy()
            motion = self.advance(min(h, 0.02) if on_sheave else h, motion, stop)
            if on_sheave and self.let_go(before, stop):
                motion = self.solve(stop)
            t = self.state.point.t
            coming = loads.next_crossing(self.state, motion.travel)
            if coming is not None and coming.time <= max(0.0, min(self.short, stop - t)):
                first, motion = self.locate(before, coming, motion, stop)
                motion = self.cross(first, motion, stop)
            elif t >= grid - 1e-9 * every:
                self.set_time(grid)
                self.record(on_grid=True)
                advance(grid)
                if grid >= until:
                    return
                count, grid = count + 1, min((count + 1) * every, until)
                motion = self.solve(grid)
            if self.stop_at and self.stopped():
                return

    def set_time(self, t: float) -> None:
        """Sets the clock, and the inputs to their values then."""
        self.state.point = replace(self.state.point, t=t)
        self.state.point.u[:] = self.inputs_at(t)

    def inputs_at(self, t: float) -> np.ndarray:
        """Values of all inputs, shape (nu,)."""
        return np.array([s.at(t) if isinstance(s, Schedule) else s for s in self.signals], dtype=float)

    def slope(self, stop: float) -> np.ndarray:
        """Rates of the inputs from now to `stop`, no later than their next break, shape (nu,)."""
        t = self.state.point.t
        if not len(self.breaks) or stop - t < 1e-9:
            return np.zeros(len(self.signals))
        return (self.inputs_at(stop) - self.state.point.u) / (stop - t)

    def solve(self, stop: float) -> _Motion:
        """Solves the algebraic variables; returns how everything moves from here."""
        state = self.state
        return self.motion(newton_of(state.model).solve(state.point, slope=self.slope(stop)))

    def solve_beside(self, crossings: Sequence[loads.Crossing], motion: _Motion, stop: float) -> _Motion:
        """Solves only the sections on both sides of the crossings anew."""
        state, parts = self.state, blocks_of(self.state.model)
        touched: set[int] = set()
        for c in crossings:
            layout = state.model.layouts[c.r]
            beside = layout.force[max(c.k - 1, 0) : c.k + 1]
            touched.update(int(parts.of[z]) for z in beside)
        z = motion.z.copy()
        parts.solve(state.point, sorted(touched), self.slope(stop), z)
        return self.motion(z)

    def motion(self, z: np.ndarray) -> _Motion:
        """All rates, from those of the algebraic variables."""
        state = self.state
        x = rates_of(state.model)(*state.point.arguments)[0].copy()
        return _Motion(x, z, [layout.travel.read(x, z) for layout in state.model.layouts])

    def advance(self, h: float, motion: _Motion, stop: float) -> _Motion:
        """Moves the state on by `h` seconds, a little backwards too."""
        point, t = self.state.point, self.state.point.t
        if h == 0.0:
            return motion
        if abs(h) <= self.tiny:
            point.x[:] += h * motion.x
            point.z[:] += h * motion.z
            self.set_time(t + h)
            return motion
        if abs(h) <= self.short:
            x = point.x.copy()
            point.x[:] = x + h * motion.x
            point.z[:] += h * motion.z
            self.set_time(t + h)
            end = self.solve(stop)
            if np.array_equal(end.x, motion.x):
                return end
            self.state.point.x[:] = x + h / 2.0 * (motion.x + end.x)
            return self.solve(stop)
        integrator = idas_of(self.state.model, self.tolerance)
        point.x[:], point.z[:] = integrator.advance(point, h, motion.x, motion.z, self.slope(stop))
        self.set_time(t + h)
        return self.solve(stop)

    def locate(
        self, before: LineState, first: loads.Crossing, motion: _Motion, stop: float
    ) -> tuple[loads.Crossing, _Motion]:
        """Moves the state to where the first load stands on its support."""
        for _ in range(20):
            if abs(first.gap) <= loads.NEAR * self.state.span_scale[first.r]:
                return first, motion
            if abs(first.time) > self.short:  # far overrun: once more from before, up to there
                h = self.state.point.t + first.time - before.point.t
                self.state = before.copy()
                motion = self.advance(h, self.solve(stop), stop)
            else:
                motion = self.advance(first.time, motion, stop)
            coming = loads.next_crossing(self.state, motion.travel)
            if coming is None:
                break
            first = coming
        raise SimulationError(
            f"Cannot locate the crossing of {self.state.runs[first.r].nodes[first.k].name!r}",
            "The rope hardly moves there; look at its speed",
            self.state.point.t,
        )

    def cross(self, first: loads.Crossing, motion: _Motion, stop: float) -> _Motion:
        """Loads cross, and the line jumps; both sides are recorded."""
        self.record(on_grid=False)
        crossings = loads.due(self.state, first, motion.travel)
        just: set[tuple[int, int]] = set()
        for _ in range(50):
            for crossing in crossings:
                just.add((crossing.r, crossing.k))
                self.note(crossing, loads.apply(self.state, crossing))
            motion = self.solve_beside(crossings, motion, stop)
            crossings = loads.overrun(self.state, just)
            if not crossings:
                self.record(on_grid=False)
                return motion
        raise SimulationError(
            f"Loads are thrown to and fro at {self.state.runs[crossings[0].r].nodes[crossings[0].k].name!r}",
            "Move supports or loads there",
            self.state.point.t,
        )

    def let_go(self, before: LineState, stop: float) -> bool:
        """Releases a load that stands on a sheave when a side has gained the upper hand."""
        enough = 1e-7 * float(self.state.model.z.nominals.max())
        for _ in range(30):
            found = loads.pulls(self.state)
            i = int(np.argmax([pull for _, pull in found]))
            leaving, pull = found[i]
            if pull <= enough:
                return False
            was, h = loads.pulls(before)[i][1], self.state.point.t - before.point.t
            if pull <= 10.0 * enough or h < 1e-9:
                break
            if was >= -10.0 * enough:
                self.state = before
                break
            self.state, end = before.copy(), self.state
            self.advance(h * was / (was - pull), self.solve(stop), stop)
            if max(p for _, p in loads.pulls(self.state)) <= enough:  # still on the sheave: the root is beyond
                before, self.state = self.state.copy(), end
        self.record(on_grid=False)
        loads.let_go(self.state, leaving)
        self.note(leaving, "load released forward" if leaving.forward else "load released backward")
        self.solve(stop)
        self.record(on_grid=False)
        return True

    def note(self, crossing: loads.Crossing, what: str) -> None:
        """Writes an event down; its value is the load's number on the rope."""
        run = self.state.runs[crossing.r]
        name = run.loads.names[crossing.load]
        self.events.append(Event(self.state.point.t, run.nodes[crossing.k].name, what, crossing.load + 1, name))

    def record(self, *, on_grid: bool) -> None:
        """Writes the state down."""
        self.records.append(self.state.snapshot())
        self.on_grid.append(on_grid)

    def stopped(self) -> bool:
        """Whether an event has come at which the run stops."""
        limits = self.state.model.limits
        broken = np.flatnonzero(limits.broken(self.state.outputs()))
        now = {limits.events[i] for i in broken} | ({"load held"} if self.state.held else set())
        if now.isdisjoint(self.stop_at):
            return False
        self.record(on_grid=False)
        return True


@lru_cache(maxsize=16)
def idas_of(model: Model, tolerance: float) -> Idas:
    """The integrator of a model: made once, as its functions take a while to build."""
    return Idas(model, tolerance)


@lru_cache(maxsize=16)
def rates_of(model: Model) -> Buffered:
    """Rates of the states as a function of a point."""
    arguments = model.dae.sx_in()
    return Buffered(ca.Function("rates", arguments, [ca.densify(expanded(model)(*arguments)[0])]))
