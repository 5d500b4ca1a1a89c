"""A line with inertia between two stops: IDAS from event to event, where loads come near supports and cross them."""

from __future__ import annotations

from collections.abc import Sequence

from ropeway.systems.dynamics.inertia import support_zones as zones
from ropeway.systems.dynamics.inertia.inertial_line import InertialLine
from ropeway.systems.dynamics.inertia.inertial_state import regrown
from ropeway.systems.dynamics.inertia.peaks import Peaks
from ropeway.systems.dynamics.inertia.zone_bounds import Bounds
from ropeway.systems.dynamics.line_stepper import LineMotion, Signal
from ropeway.systems.dynamics.recorder import Recorder
from ropeway.systems.statics.line_records import recorded
from ropeway.systems.statics.line_state import LineState


class InertialStepper:
    """A line with inertia that moves: `line` has its state and signals; `recorder` gets both sides of each event."""

    disturbed = False
    """It is solved again at once after each change."""
    integrates = False
    """It stops at each record."""
    line_kind: type[InertialLine] = InertialLine

    def __init__(
        self, state: LineState, signals: Sequence[Signal], tolerance: float, recorder: Recorder | None = None
    ) -> None:
        self.line = self.line_kind(state, signals, tolerance)
        self.recorder = Recorder() if recorder is None else recorder
        self._peaks = Peaks(state)

    @property
    def state(self) -> LineState:
        """The state of the line."""
        return self.line.state

    def disturb(self) -> None:
        """Declares that something else than time has changed the line: it is solved again."""
        self.line.solve(self.line.time)
        self._peaks.written(self.state)

    def run_along(self, stops: Sequence[float]) -> int:
        """Advances through some stops with an entry at each; returns how many they are. Inputs do not bend before the
        last one. Raises EquilibriumError, SimulationError."""
        if stops:
            begin = self._begin(stops[-1])
            for stop in stops:
                begin = self._advance_to(stop, stops[-1], *begin)
                self._record(on_grid=True)
        return len(stops)

    def settle(self, stop: float) -> None:
        """Solves the line where a run starts; inputs do not bend before `stop` [s]. Raises EquilibriumError."""
        self.line.solve(stop)

    def run_to(self, stop: float) -> None:
        """Advances to `stop` [s], before which no input bends and nothing acts on the line; solved there. Raises
        EquilibriumError, SimulationError."""
        self._advance_to(stop, stop, *self._begin(stop))

    def _begin(self, quiet: float) -> tuple[LineMotion, Bounds]:
        """The rates at the present time, and what loads come to."""
        self.line.set_time(self.line.time)
        return self.line.solve(quiet), Bounds(self.state)

    def _advance_to(self, stop: float, quiet: float, motion: LineMotion, bounds: Bounds) -> tuple[LineMotion, Bounds]:
        """As `run_to`, from known rates and bounds, where nothing acts on the line before `quiet` [s]; returns those at
        the stop."""
        line = self.line
        while line.time < stop - 1e-9:
            if due := bounds.due(self.state, motion.travel):
                motion = self._act(due, motion, stop)
                bounds = Bounds(self.state)
            else:
                motion = line.move(stop, quiet, motion, bounds)
                self._keep_peaks()
        self.state.require_rope("End the run before, or turn the drive")
        return motion, bounds

    def _act(self, due: Sequence[zones.ZoneEvent], motion: LineMotion, stop: float) -> LineMotion:
        """Applies events that are due, and solves the line. Raises EquilibriumError, SimulationError."""
        line, names = self.line, self.state.runs[due[0].r].nodes
        line.guard.require(line.time, names[due[0].k].name)
        self._record()
        if any(event.what == zones.LEAVE for event in due):
            motion = line.solve_rates(stop)
        model = self.state.model
        crossed = zones.apply(self.state, due, (motion.x, motion.z))
        if self.state.model is not model:  # a span holds more loads than before
            self.recorder.rewrite(lambda record: regrown(record, model, self.state.model))
        for crossing, what in crossed:
            self.recorder.note(self.state, crossing, what)
        motion = line.solve(stop)
        self._record()
        return motion

    def _record(self, *, on_grid: bool = False) -> None:
        """Writes the state down."""
        self.recorder.record(self.state, on_grid=on_grid)
        self._peaks.written(self.state)

    def _keep_peaks(self) -> None:
        """Keeps the states at which quantities were highest as the line has moved last."""
        path = self.line.path
        if not (found := self._peaks.along(self.state.model, path)):
            return
        here = recorded(self.state, self.recorder.pending)
        for number, t in found.items():
            x, z = path.at(t)
            self.recorder.keep(number, here._replace(time=t, x=x, z=z, u=self.line.inputs_at(t)))
