"""A simulation: a line from stop to stop, what its clocks and interventions do there, and what it records."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.environment import Environment
from ropeway.components.errors import InputError, RopewayError, SimulationError
from ropeway.components.inertia import Inertia
from ropeway.components.schedule import Schedule
from ropeway.systems.dynamics.agenda import TOGETHER, Agenda, grid_times
from ropeway.systems.dynamics.external_parts import ExternalParts
from ropeway.systems.dynamics.inertia.inertial_stepper import InertialStepper
from ropeway.systems.dynamics.inertia.support_zones import lose
from ropeway.systems.dynamics.line_stepper import LONGEST_STEP, Signal
from ropeway.systems.dynamics.recorder import Recorder
from ropeway.systems.dynamics.result import Result
from ropeway.systems.dynamics.run_inputs import (
    check_interventions,
    in_core,
    is_speed,
    require_no_events,
    signals_of,
    start_of,
    started,
)
from ropeway.systems.dynamics.steppers import stepper_of
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.modelling.assembly import in_weather
from ropeway.systems.modelling.dae_model import Model, component_of, in_code, kept_with_model
from ropeway.systems.modelling.intervention import EMERGENCY_STOP, LOAD_LOST, STOP, Intervention
from ropeway.systems.modelling.sampled_control import Clock
from ropeway.systems.modelling.system import System
from ropeway.systems.progress_bar import bar
from ropeway.systems.results.run_data import Event
from ropeway.systems.solvers.model_functions import Buffered, dense
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import unpin
from ropeway.systems.statics.pending_events import Pending


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
    compiled: bool = False,
    environment: Environment | None = None,
    inertia: Inertia | None = None,
) -> Result:
    """Simulate a system in time.

    Parameters
    ----------
    system : System or Model
        Its declarations, or `assemble` of them.
    until : float
        End of the run [s].
    every : float, default 1.0
        Interval of the result's frame [s]. With inertia the peaks of tensions between its rows are recorded, too: see
        `full_frame`, `summary` and `dynamic_factor`.
    inputs : mapping of str to float or Schedule, optional
        A signal for each input without one of its own, or in place of a component's own (`{"c1.speed": 1.02}`).
    start : Equilibrium, optional
        Where the run starts: an equilibrium of the same declarations (responses and speeds may differ), or
        `result.at(t)`, from which clocks, delayed responses, brakes and an emergency stop continue; times count from 0
        again. A speed in `inputs` ends the emergency stop of its drive. By default the system's equilibrium.
    tolerance : float, default 1e-6
        Of IDAS, or of a compiled step with inertia, absolute on scaled variables.
    interventions : sequence of Intervention, optional
        Brakes, losses of pressure, an emergency stop.
    stop_at : str or sequence of str, optional
        Names of events at which the run stops: those of limits, and "load held".
    progress : bool, optional
        Whether to show a progress bar; by default on a terminal only.
    compiled : bool, default False
        Whether to solve the line in compiled code, which needs a C compiler at first use: the same result, faster. On
        standing supports drives and responses run there too, but IDAS integrates a line while a load stands on a
        support, and drives that share a power unit. With `inertia` all systems and drives run in compiled code.
    environment : Environment, optional
        Weather, instead of that of the system; its temperature, wind pressure and direction may be schedules.
    inertia : Inertia, optional
        The inertia of ropes, loads and wheels, of which the line is in equilibrium otherwise at every time. The run
        starts in equilibrium, with the line at its speed.

    Returns
    -------
    Result

    Raises
    ------
    InputError, UnknownNameError
        Before the run.
    CompiledError, CompilerError, WriteError
        Of `compiled`: the core cannot simulate this system, has no compiler, or its cache cannot be written.
    EquilibriumError
        Where the system has no equilibrium to start from.
    SimulationError
        Where the run cannot continue, with the result so far.

    Examples
    --------
    >>> result = rw.simulate(line, 30.0)
    >>> print(f"{result.frame['c1.tension_in'].max() / 1e3:.1f} kN")
    46.8 kN
    >>> result.events["event"].unique().tolist()
    ['crossing forward', 'load put on', 'load taken off']
    """
    check.positive(until, "simulate", "until", "s")
    check.positive(every, "simulate", "every", "s")
    check.positive(tolerance, "simulate", "tolerance")
    check.count(until / every, "simulate", "records")
    model = in_weather(system, environment, inputs or ())
    if model.inertia is not None:
        raise InputError(f"{model.name!r} is a model with inertia", "Give the system and inertia=")
    signals = signals_of(model, inputs or {}, until)
    known = {*model.limits.events, "load held"}
    stops = (stop_at,) if isinstance(stop_at, str) else tuple(stop_at)
    if unknown := [event for event in stops if event not in known]:
        raise InputError(f"A run cannot stop at {unknown[0]!r}", f"Events are {', '.join(sorted(known))}")
    check_interventions(model, interventions, inertia)
    if inertia is not None:
        require_no_events(model.system)
    moved_in_core = compiled and in_core(model, signals, inertia)
    at_once = compiled and inertia is None
    rest = equilibrium(model, compiled=at_once) if start is None else start_of(start, model, inertia)
    stopping = {name: s for name, s in (rest.pending.stopping or {}).items() if name not in (inputs or {})}
    signals = tuple(stopping.get(name, signal) for name, signal in zip(model.u.names, signals, strict=True))
    pending = replace(rest.pending, stopping=stopping or None, emergency=rest.pending.emergency and bool(stopping))
    settings = _Settings(model.u.names, signals, interventions, tolerance, stops, moved_in_core, inertia)
    solved_on = in_code(rest.model, compiled=model.compiled or (compiled and not moved_in_core))
    run = _Simulation(replace(rest, model=solved_on, pending=pending), settings, compiled=model.compiled)
    with bar("simulate", until, progress) as advance, keeping(run.result_so_far):
        try:
            run.go(until, every, advance)
        except SimulationError as error:
            error.result = run.result()
            raise
        except RopewayError as error:
            raise SimulationError(error.cause, error.remedy, run.line.time, run.result()) from error
    result = run.result()
    result.require_certified()
    return result


@dataclass(frozen=True)
class _Settings:
    """What a run is asked for: a signal for each of the inputs, interventions, tolerance, events at which it stops."""

    inputs: Sequence[str]
    signals: Sequence[Signal]
    interventions: Sequence[Intervention]
    tolerance: float
    stop_at: tuple[str, ...]
    compiled: bool
    inertia: Inertia | None


class _Simulation:
    """One run: a line, and the clocks and interventions that act on it."""

    def __init__(self, start: Equilibrium, settings: _Settings, *, compiled: bool) -> None:
        self._compiled = compiled and settings.inertia is None
        state = LineState(start.model, start.point.copy(), start.runs, start.passed)
        unpin(state)
        signals = settings.signals
        if settings.inertia is not None:
            known = dict(zip(settings.inputs, signals, strict=True))
            if state.model.inertia is None:
                state = started(state, signals, settings.inertia)
            # Rates of inputs follow from these: their own signals are not read.
            signals = tuple(known.get(name, 0.0) for name in state.model.u.names)
        self.recorder = Recorder(model=state.model)
        self.stepper = stepper_of(state, signals, settings.tolerance, self.recorder, compiled=settings.compiled)
        self.line = self.stepper.line
        self.external = ExternalParts(state.model.system, self.stepper, self.recorder)
        self.stop_at, self.settings = settings.stop_at, settings
        self.interventions = sorted(settings.interventions, key=lambda i: i.time)
        self.first_tick = [start.pending.next_tick(clock) for clock in start.model.clocks]
        self.ticks = [0] * len(start.model.clocks)
        self.recorder.pending = self.ticking(start.pending)
        self.last_stop = self.recorder.checkpoint()

    @property
    def state(self) -> LineState:
        """The state of the line."""
        return self.line.state

    def result(self) -> Result:
        """All entries so far."""
        state, recorder = self.state, self.recorder
        return Result(
            in_code(state.model, compiled=self._compiled),
            tuple(state.runs),
            state.point.p,
            recorder.records,
            recorder.on_grid,
            recorder.exact,
            tuple(recorder.events),
            self.line.tolerance,
            self.settings.compiled and self.settings.inertia is None,
        )

    def result_so_far(self) -> Result | None:
        """All entries up to the last stop: later ones may belong to a step that is tried."""
        self.recorder.rewind(self.last_stop)
        return self.result() if self.recorder.entries else None

    def go(self, until: float, every: float, advance: Callable[[float], None]) -> None:
        """Runs to the end, with an entry `every` so many seconds [s]."""
        self.line.set_time(0.0)
        self.stepper.settle(until)
        self.record(on_grid=True)
        count, grid = 1, min(every, until)
        while True:
            self.last_stop = self.recorder.checkpoint()
            t = self.line.time
            bend = min(self.line.breaks[self.line.breaks > t + 1e-12 * max(1.0, t)], default=np.inf)
            quiet = min(self.next_act(), bend)
            if (done := self.run_ahead(count, every, until, quiet)) is not None:
                count, grid = count + done, min((count + done) * every, until)
                advance(self.line.time)
                if self.line.time >= until:
                    return
                continue
            stop = min(self.next_stop(grid, until), quiet)
            due = grid_times(count, every, until, stop)
            self.recorder.expect(due)
            self.external.run_to(stop)
            count, grid = count + len(due), min((count + len(due)) * every, until)
            if self.external.ended:
                self.record(on_grid=True)
                return
            if stop == bend:  # inputs are linear between records
                self.record()
            ticked = self.act()
            if ticked and stop < grid:
                self.record()
            if stop >= grid:
                self.record(on_grid=True)
                if grid >= until:
                    return
                count, grid = count + 1, min((count + 1) * every, until)
            advance(stop)
            if self.stop_at and self.stopped():
                return

    def next_stop(self, grid: float, until: float) -> float:
        """The next stop [s], where `grid` is the next record. A line that is integrated has stops of its own, at whole
        seconds: a result does not depend on the interval of its records. `stop_at` and parts with events of their own
        act at records."""
        if self.stop_at or self.external.present or not self.stepper.integrates:
            return grid
        own = min(float(np.floor(self.line.time + 1e-9)) + LONGEST_STEP, until)
        return grid if abs(own - grid) <= 1e-9 else own

    def run_ahead(self, count: int, every: float, until: float, quiet: float) -> int | None:
        """Runs through as many stops as the line can do alone; `count` is the number of the next one on the grid, and
        nothing acts on the line before `quiet` [s]. Returns how many of the grid, None where the line has not moved."""
        if self.stop_at:
            return None
        together = (count + TOGETHER) * every
        if isinstance(self.stepper, InertialStepper):
            return self.stepper.run_along(grid_times(count, every, until, min(quiet, together))) or None
        pending, begin = self.recorder.pending, self.line.time
        if not self.settings.compiled or (pending.stopping and not pending.emergency):
            return None  # the response of a drive that stops alone does not tick on
        last = self.interventions[0].time if self.interventions else np.inf
        ticking = not pending.emergency
        grid = grid_times(count, every, until, min(last, together))
        agenda = Agenda(
            grid,
            last if last < until and (count + len(grid)) * every >= last - 1e-9 else np.inf,
            self.first_tick if ticking else (),
            self.ticks if ticking else (),
            lambda ticks: self.ticking(pending, ticks),
        )
        progress = self.stepper.run_agenda(agenda)
        if ticking:
            self.ticks = list(progress.ticks)
        return progress.grid if self.line.time > begin else None

    def ticking(self, pending: Pending, ticks: Sequence[int] | None = None) -> Pending:
        """What is pending, with the time of each clock's next tick [s], by default after those so far; clocks do not
        tick after an emergency stop."""
        clocks = zip(self.state.model.clocks, self.first_tick, ticks or self.ticks, strict=True)
        coming = {(c.period, c.phase): first + n * c.period for c, first, n in clocks if not pending.emergency}
        return replace(pending, ticks=coming)

    def next_act(self) -> float:
        """Time of the next tick of a clock or intervention [s]."""
        return min([np.inf, *self.recorder.pending.ticks.values(), *(i.time for i in self.interventions[:1])])

    def act(self) -> bool:
        """Applies the clocks and interventions of the present time. Returns whether clocks have ticked without a change
        of the line's motion, which leaves no entry."""
        point, pending = self.state.point, self.recorder.pending
        due = [
            c for c in self.state.model.clocks if abs(pending.ticks.get((c.period, c.phase), np.inf) - point.t) <= 1e-9
        ]
        (d, changes, events), lost = self.sampled(due), list[str]()
        while self.interventions and self.interventions[0].time <= point.t + 1e-9:
            intervention = self.interventions.pop(0)
            events.append(Event(point.t, intervention.component or self.state.model.name, intervention.action, np.nan))
            if intervention.action in (STOP, EMERGENCY_STOP):
                ended, stopping = self.stop(intervention)
                changes.update(ended)
                emergency = pending.emergency or intervention.action == EMERGENCY_STOP
                pending = replace(pending, stopping={**(pending.stopping or {}), **stopping}, emergency=emergency)
            elif intervention.action == LOAD_LOST:
                lost.append(str(intervention.component))
            else:
                name, value = intervention.entry
                changes[self.state.model.d.index[name]] = value
        if events:
            self.record()
        for entry, value in changes.items():
            d[entry] = value
        point.d[:] = d
        for name in lost:
            lose(self.state, name)
        for clock in due:
            self.ticks[self.state.model.clocks.index(clock)] += 1
        self.recorder.pending = self.ticking(pending)
        self.recorder.events += events
        if not events:
            return bool(due)
        self.line.set_time(point.t)
        self.stepper.disturb()
        self.record()
        return False

    def sampled(self, due: Sequence[Clock]) -> tuple[np.ndarray, dict[int, float], list[Event]]:
        """The discrete variables after the ticks of some clocks, without the corrections of speed that change: these by
        their entry, and as events."""
        point = self.state.point
        d, changes, events = point.d.copy(), dict[int, float](), list[Event]()
        stopped = {component_of(name) for name in self.recorder.pending.stopping or {}}
        for clock in due:
            new = update_of(self.state.model, clock)(*replace(point, d=d).arguments)[0]
            for entry, name in clock.corrections.items():
                value = float(new[int(np.flatnonzero(clock.entries == entry)[0])])
                if value != d[entry] and name not in stopped:
                    changes[entry] = value
                    events.append(Event(point.t, name, "response", value))
            others = np.array([entry not in clock.corrections for entry in clock.entries])
            d[clock.entries[others]] = new[others]
        return d, changes, events

    def stop(self, stop: Intervention) -> tuple[dict[int, float], dict[str, Schedule]]:
        """Ramps one drive or all of them down to rest; returns the corrections that this ends, and the signals of
        inputs."""
        model, t = self.state.model, self.line.time
        signals, ended, stopping = list(self.line.signals), dict[int, float](), dict[str, Schedule]()
        for i, (name, speed) in enumerate(zip(model.u.names, self.state.point.u, strict=True)):
            owner, _, quantity = name.rpartition(".")
            if not is_speed(model.system, owner, quantity) or stop.component not in (None, owner):
                continue
            entry = model.d.index.get(f"{owner}.correction")
            if entry is not None:
                speed, ended[entry] = speed + self.state.point.d[entry], 0.0
            down = t + max(abs(speed) / stop.deceleration, 1e-6)
            signals[i] = stopping[name] = Schedule((t, down), (speed, 0.0))
        self.line.drive(signals)
        return ended, stopping

    def record(self, *, on_grid: bool = False) -> None:
        """Writes the state down."""
        self.recorder.record(self.state, on_grid=on_grid, exact=not self.stepper.disturbed)

    def stopped(self) -> bool:
        """Whether an event at which the run stops has occurred; then the state is written down."""
        limits = self.state.model.limits
        broken = np.flatnonzero(limits.broken(self.state.outputs()))
        now = {limits.events[i] for i in broken} | ({"load held"} if self.state.held else set())
        if now.isdisjoint(self.stop_at):
            return False
        self.record()
        return True


@kept_with_model
def update_of(model: Model, clock: Clock) -> Buffered:
    """The update of a clock, on arrays."""
    return dense(model, clock.update)
