"""A rig with its carriage at one station after another: one assembled model for each span, warm starts."""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np

from ropeway.components.errors import EquilibriumError, OutOfReachError
from ropeway.systems.rigs.skyline_rig import STEEPEST, SkylineRig
from ropeway.systems.solvers.newton import Point
from ropeway.systems.studies.skyline.carriage_model import Place, Question, Solved, span_model
from ropeway.systems.studies.skyline.root_selection import Effort, meant
from ropeway.systems.studies.skyline.starting_points import off_shoe, on_mainline

SIDE = 0.02
"""A carriage at a point saddle hangs this far beside it [m], on the side it was asked for."""


NO_EQUILIBRIUM = "no equilibrium"
"""What limits a payload where no other limit is known."""


NEAR = 1e-4
"""A carriage with less rope than this between it and a shoe [m] is solved on it: an error of the second order."""


class Stations:
    """A rig's equilibria over stations: each that which is meant there (`root_selection`), whatever was solved
    before. The last ones are starts that make it faster.

    Where the mainline would have to push, because the carriage stands beyond its rest point, or to pull less
    than its own weight does, the carriage's clamp holds it on the skyline: solved with the ideal holding force
    along the bisector.
    """

    def __init__(self, rig: SkylineRig, *, by_height: bool = False) -> None:
        self.rig, self.by_height = rig, by_height
        self._last: dict[tuple[Place, bool], list[_Known]] = {}
        self._was_clamped: dict[Place, bool] = {}

    def solve(
        self, station: float, payload: float, height: float | None = None, *, effort: Effort = Effort.FULL
    ) -> Solved:
        """effort: below FULL a refusal is believed without a look from beside. Raises InputError outside the skyline,
        EquilibriumError where there is no equilibrium."""
        span, on = self.rig.span_of(station), None
        rig = self.rig
        if height is None:
            on = rig.shoe_near(station)
        shoe = None if on is None else self._on_shoe(on, station, payload)
        if shoe is not None and shoe.off_shoe < NEAR:
            return shoe
        x = self.beside(span, station) if shoe is None else station
        laid = None if shoe is None or span != on else self._laid(shoe, span, x, payload)
        if laid is not None:
            return laid
        asked = Question(x, payload, height)
        if height is not None:
            self._require_below_chord(span, x, height)
        try:
            return self._held(Place(span), asked, shoe, effort=effort)
        except OutOfReachError:
            raise
        except EquilibriumError:
            if on is None or effort < Effort.FULL:
                raise
            self._walk(Place(span), on, asked)
            return self._held(Place(span), asked, None)

    def _walk(self, place: Place, on: int, asked: Question) -> None:
        """From where the carriage leaves a shoe out to a station, step by step; each starts from the one before."""
        inside, outside, shoe = self.rig.supports[on].at[0], asked.station, None
        for _ in range(10):
            middle = 0.5 * (inside + outside)
            found = self._on_shoe(on, middle, asked.payload)
            if found is not None and found.off_shoe < NEAR:
                inside = middle
            else:
                outside, shoe = middle, found or shoe
        for share in (0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85):
            self._held(place, asked._replace(station=outside + share * (asked.station - outside)), shoe)
            shoe = None

    def _laid(self, shoe: Solved, span: int, x: float, payload: float) -> Solved | None:
        """Before the carriage comes to a shoe, a mainline with much sag can lie on the shoe's roller already; None
        where it does not."""
        if shoe.held_by != "mainline":
            return None
        try:
            place = Place(span, rollers=span + 1)
            laid = self._solve(place, Question(x, payload), effort=Effort.QUICK, start=shoe)
        except EquilibriumError:
            return None
        roller = f"{self.rig.supports[span].name}_mainline"
        return laid if laid[f"{roller}.a_rope"] > laid[f"{roller}.b_rope"] else None

    def _on_shoe(self, on: int, station: float, payload: float) -> Solved | None:
        """The carriage held on a shoe, whether it presses on it or not; None where that cannot be."""
        support = self.rig.supports[on]
        if abs(station - support.centre[0]) > STEEPEST * support.radius:
            return None
        try:
            return self._held(Place(on, on), Question(station, payload), None)
        except EquilibriumError:
            return None

    def _held(self, place: Place, asked: Question, shoe: Solved | None, *, effort: Effort = Effort.FULL) -> Solved:
        """The carriage held by its mainline, its clamp or an ideal force. shoe: the same on a shoe nearby.

        By its mainline wherever that pulls; by its clamp where it would have to push, or to pull less than its own
        weight does."""
        rig = self.rig
        if effort is Effort.NEAR and not any((place, clamp) in self._last for clamp in (False, True)):
            effort = Effort.QUICK
        if rig.ideal or rig.carriage.clamped:
            return self._solve(place, asked, start=shoe, effort=effort)
        if not rig.kind.keeps_length and asked.height is None:
            self._require_lift(asked.station, asked.payload)
        name, own = rig.carriage.name, self._own_pull(place.span, asked.station)
        # Started with the clamp where the last one was held by it: that is faster, the answer is the same.
        held = self._clamped(place, asked, shoe, effort=effort) if self._was_clamped.get(place) else None
        pulled, refused, tried = None, None, held
        if held is None or held[f"{name}.holding"] > 0.0:
            try:
                pulled = self._solve(place, asked, effort=min(effort, Effort.QUICK), start=held or shoe)
            except EquilibriumError as error:
                refused = error
        if held is None and (pulled is None or pulled[f"{name}.mainline_pull"] < own):
            held = self._clamped(place, asked, shoe, effort=effort)
        holds = np.inf if held is None else held[f"{name}.holding"]
        if refused is not None and holds > 0.0:
            full = effort if holds > own else min(effort, Effort.QUICK)
            try:
                if held is tried and full < Effort.FULL:
                    raise refused
                pulled = self._solve(place, asked, effort=full, start=None if held is tried else held, refused=refused)
            except EquilibriumError:
                if held is None or holds > own:
                    raise
        self._was_clamped[place] = pulled is None or holds <= 0.0
        if pulled is not None and holds > 0.0:
            return pulled
        if not rig.kind.has_clamp:
            raise OutOfReachError(
                f"At station {asked.station:g} m the carriage of {rig.name!r} is beyond its rest point with "
                f"{asked.payload:g} kg: the mainline would have to push",
                "Raise the haulback's tension, or stay nearer to the headspar",
                rig.carriage.name,
                "rest point",
            )
        return cast(Solved, held)

    def _clamped(
        self, place: Place, asked: Question, shoe: Solved | None, *, effort: Effort = Effort.FULL
    ) -> Solved | None:
        """The carriage held by its clamp; None where there is no equilibrium."""
        try:
            return self._solve(place, asked, clamp=True, effort=effort, start=shoe)
        except EquilibriumError:
            return None

    def _require_below_chord(self, span: int, x: float, height: float) -> None:
        """Raises OutOfReachError for a height z of the carriage [m] that no tension gives."""
        chord = self.rig.chord(span, x)
        if height >= chord:
            raise OutOfReachError(
                f"At station {x:g} m the carriage of {self.rig.name!r} would have to be at {height:g} m, and the chord "
                f"of its span is at {chord:g} m",
                "Ask for less height, or raise the spars",
                self.rig.carriage.name,
                "clearance",
            )

    def _require_lift(self, x: float, payload: float) -> None:
        """Raises EquilibriumError where a running skyline's haulback cannot carry the load however deep it hangs:
        with straight ropes all but plumb, T + M = 2 T (L - x) / x towards the headspar and 2 T towards the tail.
        Half of the four ropes' weight counts, at least that of their horizontal lengths."""
        head, tail = self.rig.points[0], self.rig.points[1]
        most = 2.0 * (self.rig.tension or 0.0) * (tail[0] - head[0]) / (x - head[0])
        ropes = 0.99 * self.rig.skyline.mass_per_length * (tail[0] - head[0])
        load = (payload + self.rig.carriage.mass + ropes) * self.rig.gravity
        if load >= most:
            raise OutOfReachError(
                f"A haulback tension of {self.rig.tension:g} N carries less than {most:.6g} N at station {x:g} m, "
                f"load and ropes of {self.rig.name!r} weigh {load:.6g} N",
                "Raise the haulback's tension",
                self.rig.carriage.name,
                "haulback tension",
            )

    def _own_pull(self, span: int, x: float) -> float:
        """What the mainline pulls by its own weight, at most [N]: below it, it cannot be kept taut."""
        rope = self.rig.mainline
        if rope is None:
            return 0.0
        stands = [node.at for node in self.rig.stands[: span + 1]]
        ends = np.array([*stands, (x, stands[-1][1], self.rig.stands[span + 1].at[2])])
        return float(np.abs(np.diff(ends, axis=0)).sum(axis=1).max() * rope.mass_per_length * self.rig.gravity)

    def beside(self, span: int, station: float) -> float:
        """The station, or a little beside a support that stands there."""
        low, high = self.rig.stands[span].at[0], self.rig.stands[span + 1].at[0]
        side = min(SIDE, (high - low) / 4.0)
        return min(max(station, low + side), high - side)

    def _solve(
        self,
        place: Place,
        asked: Question,
        *,
        clamp: bool = False,
        effort: Effort = Effort.FULL,
        start: Solved | None = None,
        refused: EquilibriumError | None = None,
    ) -> Solved:
        """start: a solution of another model: on the shoe nearby, or held by the clamp at the same place; refused: the
        refusal of a try from near and from geometry."""
        at = span_model(self.rig, place, self.by_height, clamp)
        known = self._last.get((place, clamp), [])
        first = None
        if start is not None and start.at.place == place:
            first = on_mainline(at, start)
        elif start is not None and start.at.rig is at.rig:
            first = off_shoe(at, start)
        near = [] if refused is not None else _ahead(known, asked)
        point = meant(at, asked, near, start=first, effort=effort, refused=refused)
        self._last[place, clamp] = [*known[-1:], _Known(asked, point)]
        held_by = "clamp" if clamp or at.rig.carriage.clamped else "holding" if at.rig.ideal else "mainline"
        return Solved(at, point, at.outputs(point), held_by, asked)


class _Known(NamedTuple):
    """A solved point and its question."""

    asked: Question
    point: Point


def _ahead(known: list[_Known], asked: Question) -> list[Point]:
    """Where to start from: the last solved point, or on the line through the last two of one payload, at one station
    by their heights."""
    if not known:
        return []
    last, first = known[-1], known[0]
    if len(known) == 1 or not last.asked.payload == first.asked.payload == asked.payload:
        return [last.point]
    before, now, then = ((q.station, q.height or 0.0) for q in (first.asked, last.asked, asked))
    axis = int(before[0] == now[0] == then[0])
    if before[axis] == now[axis]:
        return [last.point]
    share = (then[axis] - now[axis]) / (now[axis] - before[axis])
    if not 0.0 < share <= 2.0:
        return [last.point]
    point = last.point.copy()
    point.z[:] += share * (last.point.z - first.point.z)
    point.x[:] += share * (last.point.x - first.point.x)
    return [point]
