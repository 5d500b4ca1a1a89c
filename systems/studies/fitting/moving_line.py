"""A line that follows measured inputs from row to row, with masses and parameters that are corrected on the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ropeway.components.check import POSITIVE
from ropeway.components.errors import EquilibriumError, InputError, SimulationError
from ropeway.components.schedule import Schedule
from ropeway.components.variable import Kind
from ropeway.systems.dynamics.event_stepper import EventStepper
from ropeway.systems.dynamics.line_stepper import Signal
from ropeway.systems.dynamics.recorder import Checkpoint
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import unpin

_LONGEST = 3600.0
"""Longest time between two rows [s]."""
_TOLERANCE = 1e-6
"""Tolerance of the integration of drives."""
_NEAREST = 1e-3
"""How near an estimate comes to a limit that it stays above, as a share of the distance of its expected value."""


class MovingLine:
    """A line from its equilibrium at time 0. `given`: inputs that rows give; the others are as declared."""

    def __init__(self, rest: Equilibrium, given: list[str]) -> None:
        self.model, self.given = rest.model, given
        state = LineState(rest.model, rest.point.copy(), rest.runs, rest.passed)
        unpin(state)
        self._signals = _declared(rest.model, given)
        self._values = {name: float(rest.point.u[rest.model.u.index[name]]) for name in given}
        self._stepper = EventStepper(state, self._signals, _TOLERANCE)
        self._stepper.line.set_time(0.0)

    @property
    def state(self) -> LineState:
        """The state of the line."""
        return self._stepper.state

    @property
    def time(self) -> float:
        """Time of the state [s]."""
        return self._stepper.line.time

    def advance(self, time: float, inputs: Mapping[str, float]) -> Equilibrium:
        """Advances to a time [s], to which inputs change linearly. Raises InputError, SimulationError."""
        line, now = self._stepper.line, self.time
        if time < now:
            raise InputError(f"A row at {time:g} s comes after {now:g} s", "Sort the rows")
        if time - now > _LONGEST:
            raise InputError(
                f"A row at {time:g} s comes {time - now:g} s after the last one",
                "Count the time from the start of the run [s]; begin a new monitor after a long stop",
            )
        values = {**self._values, **inputs}
        signals = list(self._signals)
        for name, value in values.items():
            k = self.model.u.index[name]
            if now == time or value == self._values[name]:
                signals[k] = value
            else:
                signals[k] = Schedule([now, time], [self._values[name], value])
        line.drive(signals)
        self._values = values
        if now == time:
            line.set_time(now)
            self._stepper.disturb()
        try:
            while self.time < time:
                bends = line.breaks[line.breaks > self.time + 1e-12]
                self._stepper.run_to(float(min([time, *bends])))
            if self._stepper.disturbed:
                line.solve(time)
        except EquilibriumError as error:
            raise SimulationError(error.cause, error.remedy, self.time) from error
        self._stepper.recorder.rewind(Checkpoint(0, 0))
        state = self.state
        return Equilibrium(state.model, state.point, tuple(state.runs), tuple(state.passed), state.held)

    def set(self, values: Mapping[str, float]) -> None:
        """Sets masses of loads and parameters from now on."""
        state, masses = self.state, {n.removesuffix(".mass"): v for n, v in values.items() if n.endswith(".mass")}
        for r, run in enumerate(state.runs):
            mass = run.loads.mass.copy()
            for i, name in enumerate(run.loads.names):
                if name in masses:
                    mass[i] = masses[name]
            state.runs[r] = replace(run, loads=replace(run.loads, mass=mass))
        for name, value in values.items():
            if (k := state.model.p.index.get(name)) is not None:
                state.point.p[k] = value
        state.write_slots()
        self._stepper.disturb()

    def on_line(self) -> list[str]:
        """Names of the loads on the line, foremost first; a missing load is none."""
        found = list[str]()
        for run, passed in zip(self.state.runs, self.state.passed, strict=True):
            found += [run.loads.names[i] for i in range(passed[-1], passed[0]) if run.loads.mass[i] > 0.0]
        return list(dict.fromkeys(found))

    def bounds_of(self, name: str, value: float) -> tuple[float, float]:
        """The least and the largest estimate of a parameter or the mass of a load with an expected value. Raises
        InputError where this one is outside its range."""
        table = self.state.model.tables[Kind.PARAMETER]
        allowed = table.ranges[table.index[name]] if name in table.index else POSITIVE
        if words := allowed.refuses(value):
            raise InputError(f"monitor: the expected value of {name} is {value:g}", f"Give {words}")
        low = allowed.least + _NEAREST * (value - allowed.least) if allowed.above else allowed.least
        return low, allowed.most


def _declared(model: Model, given: list[str]) -> list[Signal]:
    """Signals of the inputs as declared. Raises InputError for a sheave that responds, whose speed is not given."""
    for name in (name for clock in model.clocks for name in clock.corrections.values()):
        if f"{name}.speed" not in given:
            raise InputError(
                f"Control sheave {name!r} responds to tensions: its speed is not known",
                f"Map the column with its measured speed to '{name}.speed'",
            )
    found = list[Signal]()
    for name, signal in zip(model.u.names, model.signals, strict=True):
        if signal is None and name not in given:
            raise InputError(f"Input {name!r} is open", f"Map a column to '{name}'")
        found.append(0.0 if signal is None else signal)
    return found


def require_parameter(model: Model, name: str) -> float:
    """Declared value of a parameter. Raises InputError for a quantity that cannot be estimated while a line runs."""
    if name not in model.tables[Kind.PARAMETER].index:
        raise InputError(
            f"{name} cannot be estimated while the line runs",
            "Free masses of loads ('l7.mass', '*.mass') or parameters",
        )
    return float(model.p.values[model.p.index[name]])
