"""A line in time: IDAS between events, loads that cross supports, and what is written down."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError, RopewayError, SimulationError, UnknownNameError
from ropeway.components.node import Node
from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.event_stepper import EventStepper
from ropeway.systems.dynamics.line_stepper import Signal, breaks_of
from ropeway.systems.dynamics.result import Result
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model, component_of, nearest
from ropeway.systems.modelling.intervention import Intervention
from ropeway.systems.modelling.sampled_control import Clock
from ropeway.systems.modelling.system import System
from ropeway.systems.progress_bar import bar
from ropeway.systems.results.run_data import Event
from ropeway.systems.solvers.newton import Buffered, dense
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.statics.line_state import LineState, Record
from ropeway.systems.statics.pending_events import Pending
from ropeway.systems.statics.warm_start import carried_over, declared_alike


@checked
@interruptible
def simulate(
    system: System | Model,
    until: float,
    *,
    every: float = 1.0,
    inputs: Mapping[str, Signal] | None = None,
    start: Equilibrium | None = None,
    tolerance: float = 1e-6,
    interventions: Sequence[Intervention] = (),
    stop_at: str | Sequence[str] = (),
    progress: bool | None = None,
) -> Result:
    """Simulate a system from its equilibrium.

    until: end [s]; every: interval of the result's frame [s]; inputs: constant or Schedule for each input
    left open, or in place of a component's own (`{"c1.speed": 1.02}`); start: where to start from, of the same
    declarations but for responses and speeds: an equilibrium, or `result.at(t)`, from which clocks, delayed
    responses, brakes and an emergency stop go on, times again from 0 on (a speed given in inputs ends the stop of its
    drive); interventions: brakes, failures, an emergency stop;
    tolerance: of IDAS, absolute on scaled variables; stop_at: names of events at which to stop; progress: show
    a bar (by default only on a terminal).

    Raises InputError before the run; SimulationError, with the result so far, when it cannot go on.
    """
    check.positive(until, "simulate", "until", "s")
    check.positive(every, "simulate", "every", "s")
    check.positive(tolerance, "simulate", "tolerance")
    check.count(until / every, "simulate", "records")
    model = system if isinstance(system, Model) else assemble(system)
    signals = _signals(model, inputs or {}, until)
    known = {*model.limits.events, "load held"}
    stops = (stop_at,) if isinstance(stop_at, str) else tuple(stop_at)
    if unknown := [event for event in stops if event not in known]:
        raise InputError(f"A run cannot stop at {unknown[0]!r}", f"Events are {', '.join(sorted(known))}")
    _check_interventions(model, interventions)
    if start is None:
        rest = equilibrium(model)
    else:
        rest = start if declared_alike(start, model.system) else carried_over(start, model)
    stopping = {name: s for name, s in (rest.pending.stopping or {}).items() if name not in (inputs or {})}
    signals = tuple(stopping.get(name, signal) for name, signal in zip(model.u.names, signals, strict=True))
    pending = replace(rest.pending, stopping=stopping or None)
    run = _Simulation(replace(rest, pending=pending), signals, interventions, tolerance, stops)
    with bar("simulate", until, progress) as advance, keeping(run.result_so_far):
        try:
            run.go(until, every, advance)
        except SimulationError as error:
            error.result = run.result()
            raise
        except RopewayError as error:
            raise SimulationError(error.cause, error.remedy, run.state.point.t, run.result()) from error
    result = run.result()
    result.require_certified()
    return result


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


def _is_speed(system: System, component: str, quantity: str) -> bool:
    """Whether an input is the commanded speed of a drive."""
    return quantity == "speed" and isinstance(system.components[component], Node)


def _check_interventions(model: Model, interventions: Sequence[Intervention]) -> None:
    driven = [target for target in model.system.links if _is_speed(model.system, *target)]
    for intervention in interventions:
        if intervention.action == "emergency stop" and driven:
            raise InputError(
                f"An emergency stop cannot ramp down {'.'.join(driven[0])!r}, which another component drives",
                "Brake that sheave",
            )
        if intervention.component is not None and intervention.entry[0] not in model.d.index:
            known = [
                component_of(n)
                for n in model.d.names
                if n.rpartition(".")[2] == intervention.entry[0].rpartition(".")[2]
            ]
            raise UnknownNameError(
                f"{intervention.action!r} does not apply to {intervention.component!r}",
                f"It applies to {', '.join(known) or 'nothing in this system'}",
            )


class _Simulation:
    """One run. `state` moves on in place; records and events are appended."""

    def __init__(
        self,
        start: Equilibrium,
        signals: Sequence[Signal],
        interventions: Sequence[Intervention],
        tolerance: float,
        stop_at: tuple[str, ...],
    ) -> None:
        state = LineState(start.model, start.point.copy(), start.runs, start.passed)
        state.unpin()
        self.line = EventStepper(
            state, signals, tolerance, lambda exact: self.record(exact=exact), self.note, self.mark
        )
        self.stop_at = stop_at
        self.records: list[Record] = []
        self.on_grid: list[bool] = []
        self.exact: list[bool] = []
        self.events: list[Event] = []
        self.interventions = sorted(interventions, key=lambda i: i.time)
        self.first_tick = [start.pending.next_tick(clock) for clock in start.model.clocks]
        self.ticks = [0] * len(start.model.clocks)
        self.pending = self.ticking(start.pending)
        self.drop = self.mark()

    @property
    def state(self) -> LineState:
        """Where the line is."""
        return self.line.state

    def mark(self) -> Callable[[], None]:
        """Marks what is written down; the function it returns drops all that came later."""
        records, events = len(self.records), len(self.events)

        def drop() -> None:
            for written in (self.records, self.on_grid, self.exact):
                del written[records:]
            del self.events[events:]

        return drop

    def result(self) -> Result:
        """Everything so far."""
        state = self.state
        return Result(
            state.model,
            tuple(state.runs),
            state.point.p,
            tuple(self.records),
            np.array(self.on_grid, dtype=bool),
            np.array(self.exact, dtype=bool),
            tuple(self.events),
            self.line.tolerance,
        )

    def result_so_far(self) -> Result | None:
        """Everything up to the last whole interval: what was written down beyond it may have been a trial."""
        self.drop()
        return self.result() if self.records else None

    def go(self, until: float, every: float, advance: Callable[[float], None]) -> None:
        """Runs to the end."""
        self.line.set_time(0.0)
        self.line.solve(until)
        self.record(on_grid=True)
        count, grid = 1, min(every, until)
        while True:
            self.drop = self.mark()
            t = self.line.time
            bend = min(self.line.breaks[self.line.breaks > t + 1e-12 * max(1.0, t)], default=np.inf)
            stop = min(grid, self.next_act(), bend)
            self.line.run_to(stop)
            if stop == bend:  # inputs are linear between records
                self.record()
            ticked = self.act()
            if ticked and stop < grid:
                self.record()
            if stop >= grid:
                self.record(on_grid=True)
                advance(grid)
                if grid >= until:
                    return
                count, grid = count + 1, min((count + 1) * every, until)
            if self.stop_at and self.stopped():
                return

    def ticking(self, pending: Pending) -> Pending:
        """What is pending, with the time of the next tick of each clock, by its period and phase [s]; none after an
        emergency stop."""
        clocks = zip(self.state.model.clocks, self.first_tick, self.ticks, strict=True)
        responding = pending.stopping is None
        ticks = {(c.period, c.phase): first + n * c.period for c, first, n in clocks if responding}
        return replace(pending, ticks=ticks)

    def next_act(self) -> float:
        """Time of the next tick of a clock or intervention [s]."""
        return min([np.inf, *self.pending.ticks.values(), *(i.time for i in self.interventions[:1])])

    def act(self) -> bool:
        """What clocks and interventions do at the present time; whether clocks have ticked that nothing is written
        down of."""
        point, t = self.state.point, self.state.point.t
        d, changes, notes = point.d.copy(), dict[int, float](), list[Event]()
        due = [
            c for c in self.state.model.clocks if abs(self.pending.ticks.get((c.period, c.phase), np.inf) - t) <= 1e-9
        ]
        for clock in due:
            new = update_of(self.state.model, clock)(*replace(point, d=d).arguments)[0]
            for entry, name in clock.corrections.items():
                value = float(new[int(np.flatnonzero(clock.entries == entry)[0])])
                if value != d[entry]:
                    changes[entry] = value
                    notes.append(Event(t, name, "response", value))
            quiet = np.array([entry not in clock.corrections for entry in clock.entries])
            d[clock.entries[quiet]] = new[quiet]
        pending = self.pending
        while self.interventions and self.interventions[0].time <= t + 1e-9:
            intervention = self.interventions.pop(0)
            notes.append(Event(t, intervention.component or self.state.model.name, intervention.action, np.nan))
            if intervention.action == "emergency stop":
                ended, stopping = self.emergency_stop(intervention.deceleration)
                changes.update(ended)
                pending = replace(pending, stopping=stopping)
            else:
                name, value = intervention.entry
                changes[self.state.model.d.index[name]] = value
        if notes:
            self.record()
        for entry, value in changes.items():
            d[entry] = value
        point.d[:] = d
        for clock in due:
            self.ticks[self.state.model.clocks.index(clock)] += 1
        self.pending = self.ticking(pending)
        self.events += notes
        if not notes:
            return bool(due)
        self.line.set_time(t)
        self.line.disturb()
        self.record()
        return False

    def emergency_stop(self, deceleration: float) -> tuple[dict[int, float], dict[str, Schedule]]:
        """Takes all drives down to rest; returns the corrections that this ends, and the signals of inputs."""
        model, t = self.state.model, self.state.point.t
        signals, ended, stopping = list(self.line.signals), dict[int, float](), dict[str, Schedule]()
        for i, (name, speed) in enumerate(zip(model.u.names, self.state.point.u, strict=True)):
            if not _is_speed(model.system, *name.rpartition(".")[::2]):
                continue
            entry = model.d.index.get(f"{component_of(name)}.correction")
            if entry is not None:
                speed, ended[entry] = speed + self.state.point.d[entry], 0.0
            down = t + max(abs(speed) / deceleration, 1e-6)
            signals[i] = stopping[name] = Schedule((t, down), (speed, 0.0))
        self.line.signals = tuple(signals)
        self.line.breaks = breaks_of(signals)
        return ended, stopping

    def note(self, crossing: loads.Crossing, what: str) -> None:
        """Writes an event down; its value is the load's number on the rope."""
        run = self.state.runs[crossing.r]
        load = crossing.load - run.loads.first
        if run.loads.mass[load] == 0.0:  # a missing load
            return
        name = run.loads.names[load]
        self.events.append(
            Event(
                self.state.point.t,
                run.nodes[crossing.k].name,
                what,
                int(name[1:]) if run.closed else crossing.load + 1,
                name,
            )
        )

    def record(self, *, on_grid: bool = False, exact: bool = True) -> None:
        """Writes the state down; exact when all its sections are solved."""
        self.records.append(self.state.snapshot(self.pending))
        self.on_grid.append(on_grid)
        self.exact.append(exact and not self.line.disturbed)

    def stopped(self) -> bool:
        """Whether an event has come at which the run stops."""
        limits = self.state.model.limits
        broken = np.flatnonzero(limits.broken(self.state.outputs()))
        now = {limits.events[i] for i in broken} | ({"load held"} if self.state.held else set())
        if now.isdisjoint(self.stop_at):
            return False
        self.record()
        return True


@lru_cache(maxsize=64)
def update_of(model: Model, clock: Clock) -> Buffered:
    """The update of a clock, on arrays."""
    return dense(model, clock.update)
