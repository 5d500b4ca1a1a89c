"""A line between two stops: integrated by sections where that is possible, else as a whole."""

from __future__ import annotations

from collections.abc import Sequence

from ropeway.components.errors import EquilibriumError, SimulationError
from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.agenda import Agenda, Progress
from ropeway.systems.dynamics.chattering import ChatterGuard, FinalError
from ropeway.systems.dynamics.compiled_sections import CompiledSections
from ropeway.systems.dynamics.compiled_stepper import CompiledStepper
from ropeway.systems.dynamics.line_integrator import LineIntegrator
from ropeway.systems.dynamics.line_stepper import LEAST_STEP, LineMotion, LineStepper, Signal
from ropeway.systems.dynamics.load_events import LoadEvents
from ropeway.systems.dynamics.recorder import Recorder
from ropeway.systems.dynamics.section_integrator import SectionIntegrator
from ropeway.systems.solvers.prescribed_states import commanded_of
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.stability import has_free_nodes, require_stable, slack


class EventStepper:
    """A line that moves: `line` has its state and signals; `recorder` gets both sides of each event."""

    def __init__(
        self,
        state: LineState,
        signals: Sequence[Signal],
        tolerance: float,
        recorder: Recorder | None = None,
        *,
        compiled: bool = False,
    ) -> None:
        """compiled: sections are solved in the compiled core, which must fit the model (`require_compiled`)."""
        self.line = (CompiledStepper if compiled else LineStepper)(state, signals, tolerance)
        self.recorder = Recorder() if recorder is None else recorder
        self.guard = ChatterGuard(sum(len(run.nodes) for run in state.runs))
        self._events = events = LoadEvents(self.line, self.guard, self.recorder)
        by_sections = CompiledSections if compiled else SectionIntegrator
        self._by_sections = by_sections(self.line, events, self.guard, self.recorder)
        self._as_whole = LineIntegrator(self.line, events, self.guard)
        self._motion: LineMotion | None = None

    @property
    def state(self) -> LineState:
        """The state of the line."""
        return self.line.state

    @property
    def disturbed(self) -> bool:
        """Whether the line has not been solved since something else than time has changed it."""
        return self._motion is None

    @property
    def integrates(self) -> bool:
        """Whether states are integrated: not all of them are known functions of time."""
        return len(commanded_of(self.state.model).rows) < len(self.state.model.x)

    def disturb(self) -> None:
        """Declares that something else than time has changed the line: it is solved before the next step."""
        self._motion = None

    def settle(self, stop: float) -> None:
        """Solves the line where a run starts. Loads that this moves past an idler cross it: friction acts there as soon
        as the rope runs. Inputs do not bend before `stop` [s]. Raises EquilibriumError, SimulationError."""
        motion = self.line.solve(stop)
        ends = {(r, k) for r, run in enumerate(self.state.runs) for k in (0, len(run.nodes) - 1)}
        for crossing in loads.overrun(self.state, ends)[:1]:
            self._events.cross(crossing, motion, stop, exact=True, balanced=False)

    def run_agenda(self, agenda: Agenda) -> Progress:
        """Advances through the stops of an agenda, with an entry at each, as far as the compiled core can do it
        alone."""
        if not isinstance(self._by_sections, CompiledSections):
            return Progress(0, tuple(agenda.ticks))
        begin = self.line.time
        progress, motion = self._by_sections.along(agenda)
        if self.line.time > begin:
            self._motion = motion
        return progress

    def run_to(self, stop: float) -> None:
        """Advances to `stop` [s], before which no input bends and nothing acts on the line; solved there. Raises
        EquilibriumError, SimulationError."""
        saved, checkpoint = self.state.copy(), self.recorder.checkpoint()
        begin = saved.point.t
        try:
            self._move_to(stop)
            self.state.require_rope("End the run before, or turn the drive")
            if not has_free_nodes(self.state.model) and slack(self.state):
                require_stable(self.state)
        except FinalError:
            raise
        except (EquilibriumError, SimulationError):
            # The run ended, Newton's method failed or found a non-physical root, or a drive turned while a crossing
            # was located: retry with half the step.
            if stop - begin < LEAST_STEP:
                raise
            self.guard.require(begin)
            self.line.state = saved
            self.recorder.rewind(checkpoint)
            self.disturb()
            self.run_to((begin + stop) / 2.0)
            self.run_to(stop)

    def _move_to(self, stop: float) -> None:
        line = self.line
        if self._motion is None or len(line.breaks):
            self._motion = line.solve(stop)
        motion = self._motion
        while line.time < stop - 1e-9:
            done = self._by_sections.advance(motion, stop)
            motion = self._as_whole.advance(motion, stop) if done is None else done
        self._motion = motion
        line.set_time(stop)
