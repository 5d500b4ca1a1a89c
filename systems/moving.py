"""A line on the move between two stops: drives, loads that cross supports, and the jumps of the line.

Two ways lead from stop to stop. While the drives move on their own (`decoupled`), their travel is known for
the whole stretch, and each section of the line is solved only when one of its loads crosses a support. When a
limit binds or a load stands on a sheave, IDAS integrates the whole line from event to event.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ropeway.components.errors import EquilibriumError, SimulationError
from ropeway.components.schedule import Schedule
from ropeway.systems import crossing as loads
from ropeway.systems.blocks import blocks_of
from ropeway.systems.decoupled import Window, drives_of
from ropeway.systems.idas import Idas
from ropeway.systems.model import Model
from ropeway.systems.newton import Buffered, dense, newton_of
from ropeway.systems.stability import has_free_nodes, require_followed, require_stable, slack
from ropeway.systems.state import LineState

Signal = float | Schedule

_LEAST_STEP = 1e-5
"""Shortest stretch [s] that is tried when a longer one has failed."""

_LOOK = 1.0
"""Longest stretch [s] over which drives with limits move before these, and turns of the rope, are looked at."""

_SWING, _STRIDE = 0.05, 0.05
"""Part of their nominals by which states may move otherwise than rates tell in stretches longer than this [s]: else
the rope may have swung to and fro."""


def breaks_of(signals: Sequence[Signal]) -> np.ndarray:
    """Times at which an input bends [s]."""
    return np.unique(np.concatenate([[], *(s.breaks() for s in signals if isinstance(s, Schedule))]))


class _UnforeseenError(Exception):
    """A load has crossed a support before the time that rates foretold."""


class Motion(NamedTuple):
    """Rates at a point [per s]: of the states, of the algebraic variables, and of each run's travels."""

    x: np.ndarray
    z: np.ndarray
    travel: list[np.ndarray]


class Moving:
    """A line that moves. `state` and `motion` go on in place; `record(exact)` is called on both sides of each
    event, exact when all sections are solved, and `note(crossing, what)` for each event."""

    short = 5e-3
    """Stretches up to this [s] are one trapezoidal step: they bring a load onto its support."""
    tiny = 1e-4
    """Stretches up to this [s] are a straight line: the second order is below rounding."""

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
        self.state = state
        self.signals = tuple(signals)
        self.breaks = breaks_of(signals)
        self.tolerance = tolerance
        self.record = record
        self.note = note
        self.rewind = rewind
        self._motion_now: Motion | None = None

    @property
    def time(self) -> float:
        """Time of the state [s]."""
        return self.state.point.t

    def run_to(self, stop: float) -> None:
        """Moves on to `stop` [s], before which no input bends and nobody acts; solved there. Raises EquilibriumError,
        SimulationError."""
        saved, drop = self.state.copy(), self.rewind()
        begin = saved.point.t
        try:
            self._move_to(stop)
            self.state.require_rope("End the run before, or turn the drive")
            self._require_stable()
        except (EquilibriumError, SimulationError):
            # Either it has come to its end, or Newton's method to none or to a root that no rope can have: from nearer
            # by it finds the true one. Or a drive has turned where a crossing is sought: nearer by it has not yet.
            if stop - begin < _LEAST_STEP:
                raise
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

    def disturb(self) -> None:
        """Says that something else than time has changed how the line moves."""
        self._motion_now = None

    def _by_sections(self, motion: Motion, stop: float) -> Motion | None:
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
            self.state = saved.copy()
            drop()
        return None

    def _through(self, window: Window, end: float, motion: Motion, stop: float, *, strict: bool) -> Motion | None:
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

    def _follow(self, window: Window, time: float, motion: Motion) -> Motion:
        """Takes the states from the drives, and the algebraic variables along a straight line."""
        self.state.point.x[:], x_rate = window.at(time)
        self.state.point.z[:] += (time - self.time) * motion.z
        self.set_time(time)
        return self._moving(x_rate, motion.z)

    def _as_whole(self, motion: Motion, stop: float) -> Motion:
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
            self.state, h, motion = before.copy(), h / 2.0, begun

    def _swung(self, before: LineState, begun: Motion, motion: Motion) -> bool:
        """Whether states have moved otherwise than their rates at both ends of a stretch tell."""
        moved = self.state.point.x - before.point.x
        told = (self.time - before.point.t) * (begun.x + motion.x) / 2.0
        return bool(np.any(np.abs(moved - told) > _SWING * self.state.model.x.nominals))

    def set_time(self, t: float) -> None:
        """Sets the clock, and the inputs to their values then."""
        self.state.point = replace(self.state.point, t=t)
        self.state.point.u[:] = self.inputs_at(t)

    def inputs_at(self, t: float) -> np.ndarray:
        """Values of all inputs, shape (nu,)."""
        if not len(self.breaks):  # all of them constant
            return np.array(self.signals, dtype=float)
        return np.array([s.at(t) if isinstance(s, Schedule) else s for s in self.signals], dtype=float)

    def slope(self, stop: float) -> np.ndarray:
        """Rates of the inputs from now to `stop`, no later than their next break, shape (nu,)."""
        t = self.state.point.t
        if not len(self.breaks) or stop - t < 1e-9:
            return np.zeros(len(self.signals))
        return (self.inputs_at(stop) - self.state.point.u) / (stop - t)

    def solve(self, stop: float) -> Motion:
        """Solves the algebraic variables; returns how everything moves from here."""
        state = self.state
        z = newton_of(state.model).solve(state.point, slope=self.slope(stop))
        return self._motion(np.zeros(0) if z is None else z)

    def _beside(self, crossings: Sequence[loads.Crossing]) -> list[int]:
        """The sections on both sides of crossings."""
        parts, touched = blocks_of(self.state.model), set[int]()
        for c in crossings:
            force = self.state.model.layouts[c.r].force
            touched.update(int(parts.of[z]) for z in force[max(c.k - 1, 0) : c.k + 1])
            if c.k == 0 and self.state.runs[c.r].closed:
                touched.add(int(parts.of[force[-1]]))
        return sorted(touched)

    def _solve_parts(self, touched: Sequence[int], motion: Motion, stop: float) -> Motion:
        """Solves some sections only; the others keep their rates."""
        z = motion.z.copy()
        blocks_of(self.state.model).solve(self.state.point, touched, motion.x, self.slope(stop), z)
        return self._moving(motion.x, z)

    def _solve_followed(self, motion: Motion, stop: float, touched: Sequence[int] | None = None) -> Motion:
        """Solves some sections, or all, where their rates have led them. Raises EquilibriumError."""
        led = self.state.point.z.copy()
        motion = self.solve(stop) if touched is None else self._solve_parts(touched, motion, stop)
        require_followed(self.state, led)
        return motion

    def _motion(self, z: np.ndarray) -> Motion:
        """All rates, from those of the algebraic variables."""
        return self._moving(rates_of(self.state.model)(*self.state.point.arguments)[0].copy(), z)

    def _moving(self, x: np.ndarray, z: np.ndarray) -> Motion:
        return Motion(x, z, [layout.travel.read(x, z) for layout in self.state.model.layouts])

    def _advance(self, h: float, motion: Motion, stop: float) -> Motion:
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
        return self._integrate(h, motion, stop)

    def _integrate(self, h: float, motion: Motion, stop: float) -> Motion:
        """Moves the state on by `h` seconds with IDAS."""
        point, integrator = self.state.point, idas_of(self.state.model, self.tolerance)
        led = point.z + h * motion.z
        point.x[:], point.z[:] = integrator.advance(point, h, motion.x, motion.z, self.slope(stop))
        self.set_time(point.t + h)
        motion = self.solve(stop)
        require_followed(self.state, led)
        return motion

    def _locate(
        self, before: LineState, first: loads.Crossing, motion: Motion, stop: float
    ) -> tuple[loads.Crossing, Motion]:
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

    def _cross(self, first: loads.Crossing, motion: Motion, stop: float, *, exact: bool) -> Motion:
        """Loads cross, and the line jumps; both sides are recorded."""
        self.record(exact)
        before, events = loads.on_line(self.state), list[tuple[loads.Crossing, str]]()
        crossings = loads.due(self.state, first, motion.travel)
        just: set[tuple[int, int]] = set()
        solved: set[int] = set()
        for _ in range(50):
            for crossing in crossings:
                just.add((crossing.r, crossing.k))
                events.append((crossing, loads.apply(self.state, crossing)))
                self.note(*events[-1])
            touched = self._beside(crossings)
            solved.update(touched)
            motion = self._solve_parts(touched, motion, stop)
            if exact:  # the drives feel the jump
                motion = self._motion(motion.z)
            # Where a section is not solved it has not jumped: its loads are about where they seem to be.
            crossings = [c for c in loads.overrun(self.state, just) if not solved.isdisjoint(self._beside([c]))]
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
        self.record(True)
        loads.let_go(self.state, leaving)
        self.note(leaving, "load released forward" if leaving.forward else "load released backward")
        self.solve(stop)
        self.record(True)
        return True


@lru_cache(maxsize=16)
def idas_of(model: Model, tolerance: float) -> Idas:
    """The integrator of a model: made once, as its functions take a while to build."""
    return Idas(model, tolerance)


@lru_cache(maxsize=16)
def rates_of(model: Model) -> Buffered:
    """Rates of the states as a function of a point."""
    return dense(model, model.dae)
