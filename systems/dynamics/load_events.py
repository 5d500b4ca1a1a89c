"""Loads that pass a support or are released from it: the line jumps, and both sides of the jump are recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ropeway.components.errors import SimulationError
from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.chattering import ChatterGuard
from ropeway.systems.dynamics.line_stepper import LineMotion, LineStepper
from ropeway.systems.dynamics.recorder import Recorder
from ropeway.systems.statics.line_state import LineState

_MOST_ROUNDS = 50
"""How often crossings at one time may cause further ones."""
_RELEASE_TRIALS = 30


class LoadEvents:
    """The events of a line's loads. `guard` counts them, `recorder` writes them down."""

    def __init__(self, line: LineStepper, guard: ChatterGuard, recorder: Recorder) -> None:
        self.line = line
        self.guard = guard
        self.recorder = recorder

    def cross(
        self, first: loads.Crossing, motion: LineMotion, stop: float, *, exact: bool, balanced: bool = True
    ) -> LineMotion:
        """Moves the loads that stand on their supports to the next spans, and those that the jump of the line then
        takes past theirs. exact: all sections are solved; balanced: until now all loads are in their spans, which is
        recorded. Returns the rates after the jump. Raises EquilibriumError, SimulationError."""
        line = self.line
        crossings = self._passing(loads.due(line.state, first, motion.travel), motion, stop)
        if not crossings:
            return motion
        if balanced:
            self.recorder.record(line.state, exact=exact)
        self.guard.require(line.time, line.state.runs[first.r].nodes[first.k].name)
        before, events = loads.on_line(line.state), list[tuple[loads.Crossing, str]]()
        passed: set[tuple[int, int]] = set()
        solved: set[int] = set()
        for _ in range(_MOST_ROUNDS):
            for crossing in crossings:
                passed.add((crossing.r, crossing.k))
                # A load that has crossed and comes back at once stays on the support.
                back = any(c.opposite(crossing) for c, _ in events)
                events.append((crossing, loads.apply(line.state, crossing, passing=False if back else None)))
                self.recorder.note(line.state, *events[-1])
            loads.require_order(line.state)
            touched = line.sections_beside(crossings)
            solved.update(touched)
            motion = line.solve_sections(touched, motion, stop)
            if exact:  # the drives feel the jump
                motion = line.motion(motion.z)
            # A section that is not solved has not jumped: its loads have not passed a support.
            crossings = [
                c for c in loads.overrun(line.state, passed) if not solved.isdisjoint(line.sections_beside([c]))
            ]
            crossings = self._passing(crossings, motion, stop)
            if not crossings:
                loads.require_all(line.state, before, events)
                self.recorder.record(line.state, exact=exact)
                return motion
        place = line.state.runs[crossings[0].r].nodes[crossings[0].k].name
        raise SimulationError(
            f"Loads cross forwards and backwards without end at {place!r}",
            "Move supports or loads there",
            line.time,
        )

    def release(self, before: LineState, stop: float) -> bool:
        """Releases a load that stands on a sheave when the pull of one side prevails, at the time between the state
        `before` and now at which it does. False where no load is released. Raises EquilibriumError,
        SimulationError."""
        line = self.line
        enough = 1e-7 * float(line.state.model.z.nominals.max())
        for _ in range(_RELEASE_TRIALS):
            found = loads.pulls(line.state)
            i = int(np.argmax([pull for _, pull in found]))
            leaving, pull = found[i]
            if pull <= enough:
                return False
            earlier, h = loads.pulls(before)[i][1], line.time - before.point.t
            if pull <= 10.0 * enough or h < 1e-9:
                break
            if earlier >= -10.0 * enough:
                line.state = before
                break
            line.state, end = before.copy(), line.state
            line.advance(h * earlier / (earlier - pull), line.solve(stop), stop)
            if max(p for _, p in loads.pulls(line.state)) <= enough:  # still on the sheave: the root is later
                before, line.state = line.state.copy(), end
        self.guard.require(line.time, line.state.runs[leaving.r].nodes[leaving.k].name)
        self.recorder.record(line.state)
        loads.let_go(line.state, leaving)
        self.recorder.note(
            line.state, leaving, "load released forward" if leaving.forward else "load released backward"
        )
        line.solve(stop)
        self.recorder.record(line.state)
        return True

    def _passing(self, crossings: Sequence[loads.Crossing], motion: LineMotion, stop: float) -> list[loads.Crossing]:
        """The crossings without those of loads that their drum would draw back: these stay on the drum for now."""
        line, found = self.line, []
        for crossing in crossings:
            if loads.can_rest(line.state, crossing):
                saved, line.state = line.state, line.state.copy()
                try:
                    loads.apply(line.state, crossing)
                    line.solve_sections(line.sections_beside([crossing]), motion, stop)
                    back = loads.drawn_back(line.state, crossing)
                finally:
                    line.state = saved
                if back > loads.NEAR * saved.span_scale[crossing.r]:
                    self.guard.require(line.time, saved.runs[crossing.r].nodes[crossing.k].name)
                    loads.rest(saved, crossing, back)
                    continue
            found.append(crossing)
        return found
