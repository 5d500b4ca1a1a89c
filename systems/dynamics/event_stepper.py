"""A line on the move between two stops: drives, loads that cross supports, and the jumps of the line.

Two ways lead from stop to stop. While the drives move on their own (`drive_trajectories`), their travel is known for
the whole stretch, and each section of the line is solved only when one of its loads crosses a support. When a
limit binds or a load stands on a sheave, IDAS integrates the whole line from event to event.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ropeway.components.errors import EquilibriumError, SimulationError
from ropeway.systems.dynamics import load_crossings as loads
from ropeway.systems.dynamics.chattering import ChatterGuard, FinalError
from ropeway.systems.dynamics.line_stepper import LineMotion, LineStepper, Signal
from ropeway.systems.solvers.drive_trajectories import Window, drives_of
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.stability import has_free_nodes, require_stable, slack

_LEAST_STEP = 1e-5
"""Shortest stretch [s] that is tried when a longer one has failed."""

_LOOK = 1.0
"""Longest stretch [s] over which drives with limits move before these, and turns of the rope, are looked at."""

_SWING, _STRIDE = 0.05, 0.05
"""Part of their nominals by which states may move otherwise than rates tell in stretches longer than this [s]: else
the rope may have swung back and forth."""


class _UnforeseenError(Exception):
    """A load has crossed a support before the time that rates foretold."""


class EventStepper(LineStepper):
    """A line that moves. `record(exact)` is called on both sides of each event, exact when all sections are solved,
    and `note(crossing, what)` for each event."""

    def __init__(
        self,
        state: LineState,
        signals: Sequence[Signal],
        tolerance: float,
        record: Callable[[bool], None] = lambda exact: None,
        note: Callable[[loads.Crossing, str], None] = lambda crossing, what: None,
        rewind: Callable[[], Callable[[], None]] = lambda: lambda: None,
    ) -> None:
        """rewind() marks the records and events so far and returns a function that drops later ones. By default
        nothing is written down."""
        super().__init__(state, signals, tolerance)
        self.headway = ChatterGuard(sum(len(run.nodes) for run in state.runs))
        self.record = record
        self.note = note
        self.rewind = rewind
        self._motion_now: LineMotion | None = None

    def run_to(self, stop: float) -> None:
        """Moves on to `stop` [s], before which no input bends and nobody acts; solved there. Raises EquilibriumError,
        SimulationError."""
        saved, drop = self.state.copy(), self.rewind()
        begin = saved.point.t
        try:
            self._move_to(stop)
            self.state.require_rope("End the run before, or turn the drive")
            self._require_stable()
        except FinalError:
            raise
        except (EquilibriumError, SimulationError):
            # Either it has come to its end, or Newton's method to none or to a root that no rope can have: from nearer
            # by it finds the true one. Or a drive has turned where a crossing is sought: nearer by it has not yet.
            if stop - begin < _LEAST_STEP:
                raise
            self.headway.require(begin)
            self.state = saved
            drop()
            self.disturb()
            self.run_to((begin + stop) / 2.0)
            self.run_to(stop)

    def _require_stable(self) -> None:
        if not has_free_nodes(self.state.model) and slack(self.state):
            require_stable(self.state)

    def _move_to(self, stop: float) -> None:
        if self._motion_now is None or len(self.breaks):
            self._motion_now = self.solve(stop)
        motion = self._motion_now
        while self.time < stop - 1e-9:
            done = self._by_sections(motion, stop)
            motion = self._as_whole(motion, stop) if done is None else done
        self._motion_now = motion
        self.set_time(stop)

    @property
    def disturbed(self) -> bool:
        """Whether the line has not been solved since something else than time has changed it."""
        return self._motion_now is None

    def disturb(self) -> None:
        """Says that something else than time has changed how the line moves."""
        self._motion_now = None

    def _by_sections(self, motion: LineMotion, stop: float) -> LineMotion | None:
        """Towards the stop with drives that move on their own; None, and nothing done, where they do not."""
        drives = drives_of(self.state.model, self.tolerance)
        if self.state.standing() or not drives.decoupled(self.state.point):
            return None
        saved, drop, slope = self.state.copy(), self.rewind(), self.slope(stop)
        begin, end = self.time, min(stop, self.time + _LOOK) if drives.ties else stop
        window = drives.window(self.state.point, end - begin, motion.x, slope)
        if not drives.alone(window, self.state.point, slope):
            return None
        astray = bool(loads.overrun(self.state, set()))
        while end > begin:
            try:
                done = self._through(window, end, motion, stop, strict=not astray and end - begin > _LEAST_STEP)
                if done is not None:
                    return done
                end = begin
            except _UnforeseenError:  # from nearer by, rates foretell it
                end = (begin + end) / 2.0
            self.headway.require(begin)
            self.state = saved.copy()
            drop()
        return None

    def _through(
        self, window: Window, end: float, motion: LineMotion, stop: float, *, strict: bool
    ) -> LineMotion | None:
        """To the `end` of a window, crossing by crossing; None where a limit binds. Strict, raises _UnforeseenError."""
        drives = drives_of(self.state.model, self.tolerance)
        crossed = -np.inf
        while (coming := loads.next_crossing(self.state, motion.travel)) is not None:
            if coming.time > end - self.time:
                break
            motion = self._follow(window, self.time + coming.time, motion)
            touched = self._beside([coming])
            motion = self._solve_followed(motion, stop, touched)
            now = loads.gap_of(self.state, coming, motion.travel)
            if abs(now.gap) > loads.NEAR * self.state.span_scale[now.r]:
                if now.time > end - self.time:
                    continue
                # The section has been solved here: a short way on, and it is on its support.
                motion = self._follow(window, self.time + now.time, motion)
                if abs(now.time) > self.tiny:
                    motion = self._solve_followed(motion, stop, touched)
                    now = loads.gap_of(self.state, coming, motion.travel)
                    if abs(now.gap) > loads.NEAR * self.state.span_scale[now.r]:
                        continue
            if strict and self.time < crossed - _LEAST_STEP:
                raise _UnforeseenError
            # A crossing can bring a drive to a limit that it has left again before the stop.
            alone = drives.decoupled(self.state.point)
            motion, crossed = self._cross(now, motion, stop, exact=False), self.time
            if not alone or not drives.decoupled(self.state.point):
                return None
            if self.state.standing():
                return self.solve(stop)
        motion = self._follow(window, end, motion)
        motion = self._solve_followed(motion, stop)
        if strict and loads.overrun(self.state, set()):
            raise _UnforeseenError
        return motion if drives.decoupled(self.state.point) else None

    def _follow(self, window: Window, time: float, motion: LineMotion) -> LineMotion:
        """Takes the states from the drives, and the algebraic variables along a straight line."""
        self.state.point.x[:], x_rate = window.at(time)
        self.state.point.z[:] += (time - self.time) * motion.z
        self.set_time(time)
        return self._moving(x_rate, motion.z)

    def _as_whole(self, motion: LineMotion, stop: float) -> LineMotion:
        """To the next event or the stop, all equations at once."""
        coming = loads.next_crossing(self.state, motion.travel)
        h = min(stop - self.time, _LOOK, np.inf if coming is None else max(coming.time, 0.0))
        standing = bool(self.state.standing())
        h = min(h, 0.02) if standing else h
        before, begun, astray = self.state.copy(), motion, bool(loads.overrun(self.state, set()))
        while True:
            motion = self._advance(h, motion, stop) if h <= self.tiny else self._integrate(h, motion, stop)
            if standing and self._let_go(before, stop):
                return self.solve(stop)
            if h <= _STRIDE or not self._swung(before, begun, motion):
                coming = loads.next_crossing(self.state, motion.travel)
                if coming is not None and coming.time <= max(0.0, min(self.short, stop - self.time)):
                    first, motion = self._locate(before, coming, motion, stop)
                    return self._cross(first, motion, stop, exact=True)
                if astray or h <= _LEAST_STEP or not loads.overrun(self.state, set()):
                    return motion
            # A load has passed a support and is on its way back, or may have been there: it is seen from nearer by.
            self.headway.require(before.point.t)
            self.state, h, motion = before.copy(), h / 2.0, begun

    def _swung(self, before: LineState, begun: LineMotion, motion: LineMotion) -> bool:
        """Whether states have moved otherwise than their rates at both ends of a stretch tell."""
        moved = self.state.point.x - before.point.x
        told = (self.time - before.point.t) * (begun.x + motion.x) / 2.0
        return bool(np.any(np.abs(moved - told) > _SWING * self.state.model.x.nominals))

    def _locate(
        self, before: LineState, first: loads.Crossing, motion: LineMotion, stop: float
    ) -> tuple[loads.Crossing, LineMotion]:
        """Moves the state to where the first load stands on its support."""
        early, late = 0.0, np.inf
        for _ in range(30):
            if abs(first.gap) <= loads.NEAR * self.state.span_scale[first.r]:
                return first, motion
            passed = self.time - before.point.t
            early, late = (early, min(late, passed)) if first.gap < 0.0 else (max(early, passed), late)
            if abs(first.time) > self.short:  # far overrun: once more from before, up to there
                h = passed + first.time
                if not early < h < late and np.isfinite(late):  # it moves otherwise now than it did there
                    h = (early + late) / 2.0
                self.state = before.copy()
                motion = self._advance(h, self.solve(stop), stop)
            else:
                motion = self._advance(first.time, motion, stop)
            coming = loads.next_crossing(self.state, motion.travel)
            if coming is None:
                break
            first = coming
        raise SimulationError(
            f"Cannot locate the crossing of {self.state.runs[first.r].nodes[first.k].name!r}",
            "The rope hardly moves there; look at its speed",
            self.state.point.t,
        )

    def _cross(self, first: loads.Crossing, motion: LineMotion, stop: float, *, exact: bool) -> LineMotion:
        """Loads cross, and the line jumps; both sides are recorded."""
        crossings = self._carried(loads.due(self.state, first, motion.travel), motion, stop)
        if not crossings:
            return motion
        self.record(exact)
        self.headway.require(self.time, self.state.runs[first.r].nodes[first.k].name)
        before, events = loads.on_line(self.state), list[tuple[loads.Crossing, str]]()
        just: set[tuple[int, int]] = set()
        solved: set[int] = set()
        for _ in range(50):
            for crossing in crossings:
                just.add((crossing.r, crossing.k))
                # A load that has come over and is thrown back stays there.
                back = any(c.opposite(crossing) for c, _ in events)
                events.append((crossing, loads.apply(self.state, crossing, passing=False if back else None)))
                self.note(*events[-1])
            loads.require_order(self.state)
            touched = self._beside(crossings)
            solved.update(touched)
            motion = self._solve_parts(touched, motion, stop)
            if exact:  # the drives feel the jump
                motion = self._motion(motion.z)
            # Where a section is not solved it has not jumped: its loads are about where they seem to be.
            crossings = [c for c in loads.overrun(self.state, just) if not solved.isdisjoint(self._beside([c]))]
            crossings = self._carried(crossings, motion, stop)
            if not crossings:
                loads.require_all(self.state, before, events)
                self.record(exact)
                return motion
        place = self.state.runs[crossings[0].r].nodes[crossings[0].k].name
        raise SimulationError(
            f"Loads cross forwards and backwards without end at {place!r}",
            "Move supports or loads there",
            self.state.point.t,
        )

    def _carried(self, crossings: Sequence[loads.Crossing], motion: LineMotion, stop: float) -> list[loads.Crossing]:
        """The crossings without those of loads that their drum would draw back: these rest on it for now."""
        found = []
        for crossing in crossings:
            if loads.can_rest(self.state, crossing):
                saved, self.state = self.state, self.state.copy()
                try:
                    loads.apply(self.state, crossing)
                    self._solve_parts(self._beside([crossing]), motion, stop)
                    back = loads.drawn_back(self.state, crossing)
                finally:
                    self.state = saved
                if back > loads.NEAR * saved.span_scale[crossing.r]:
                    self.headway.require(self.time, saved.runs[crossing.r].nodes[crossing.k].name)
                    loads.rest(saved, crossing, back)
                    continue
            found.append(crossing)
        return found

    def _let_go(self, before: LineState, stop: float) -> bool:
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
            self._advance(h * was / (was - pull), self.solve(stop), stop)
            if max(p for _, p in loads.pulls(self.state)) <= enough:  # still on the sheave: the root is beyond
                before, self.state = self.state.copy(), end
        self.headway.require(self.time, self.state.runs[leaving.r].nodes[leaving.k].name)
        self.record(True)
        loads.let_go(self.state, leaving)
        self.note(leaving, "load released forward" if leaving.forward else "load released backward")
        self.solve(stop)
        self.record(True)
        return True
