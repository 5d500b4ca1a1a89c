"""Equilibria of a rig at successive stations: one assembled model per span, with warm starts."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple, cast

import numpy as np

from ropeway.components.errors import EquilibriumError, OutOfReachError
from ropeway.systems.rigs.rope_paths import roller_name
from ropeway.systems.rigs.skyline_rig import STEEPEST, SkylineRig
from ropeway.systems.solvers.points import Point
from ropeway.systems.studies.skyline.carriage_model import Place, Solved, StationCase, span_model
from ropeway.systems.studies.skyline.root_selection import Effort, physical_state
from ropeway.systems.studies.skyline.starting_points import off_shoe, on_mainline

SIDE = 0.02
"""Distance of a carriage from a point saddle [m], on the side of its station."""


NO_EQUILIBRIUM = "no equilibrium"
"""Limit of a payload for which no other limit is known."""


NEAR = 1e-4
"""Length of rope between carriage and shoe [m] below which the carriage is solved on the shoe, with a second-order
error."""


class Stations:
    """Equilibria of a rig over stations. Each is the physical one (`root_selection`), independent of earlier solutions;
    these only accelerate the search.

    The carriage's clamp holds it on the skyline where the mainline would have to push, because the carriage is beyond
    its rest point, or to pull less than its own weight does. The clamped state is solved with an ideal holding force
    along the bisector. `like`: a rig whose models serve for this one, with its supports moved (`SpanModel.moved`).
    """

    def __init__(
        self, rig: SkylineRig, *, by_height: bool = False, like: SkylineRig | None = None, compiled: bool = False
    ) -> None:
        self.rig, self.by_height, self.like, self.compiled = rig, by_height, like, compiled
        self._last: dict[tuple[Place, bool], list[_Known]] = {}
        self._was_clamped: dict[Place, bool] = {}

    def solve(
        self, station: float, payload: float, height: float | None = None, *, effort: Effort = Effort.FULL
    ) -> Solved:
        """The equilibrium at a station. An `effort` below FULL omits the continuation from other states after a
        failure. Raises InputError outside the skyline, EquilibriumError if no equilibrium exists."""
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
        case = StationCase(x, payload, height)
        if height is not None:
            self._require_below_chord(span, x, height)
        try:
            return self._held(Place(span), case, shoe, effort=effort)
        except OutOfReachError:
            raise
        except EquilibriumError:
            if on is None or effort < Effort.FULL:
                raise
            self._walk(Place(span), on, case)
            return self._held(Place(span), case, None)

    def _walk(self, place: Place, on: int, case: StationCase) -> None:
        """Continuation from the edge of a shoe to a station; each solution is the initial guess of the next."""
        inside, outside, shoe = self.rig.supports[on].at[0], case.station, None
        for _ in range(10):
            middle = 0.5 * (inside + outside)
            found = self._on_shoe(on, middle, case.payload)
            if found is not None and found.off_shoe < NEAR:
                inside = middle
            else:
                outside, shoe = middle, found or shoe
        for share in (0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85):
            self._held(place, case._replace(station=outside + share * (case.station - outside)), shoe)
            shoe = None

    def _laid(self, shoe: Solved, span: int, x: float, payload: float) -> Solved | None:
        """The carriage before a shoe with the mainline, which sags, already on the shoe's roller; None if it does not
        touch the roller."""
        if shoe.held_by != "mainline":
            return None
        try:
            place = Place(span, rollers=span + 1)
            laid = self._solve(place, StationCase(x, payload), effort=Effort.QUICK, start=shoe)
        except EquilibriumError:
            return None
        roller = roller_name(self.rig.supports[span])
        return laid if laid[f"{roller}.a_rope"] > laid[f"{roller}.b_rope"] else None

    def _on_shoe(self, on: int, station: float, payload: float) -> Solved | None:
        """The carriage held on a shoe, in contact or not; None if that is impossible."""
        support = self.rig.supports[on]
        if abs(station - support.centre[0]) > STEEPEST * support.radius:
            return None
        try:
            return self._held(Place(on, on), StationCase(station, payload), None)
        except EquilibriumError:
            return None

    def _held(self, place: Place, case: StationCase, shoe: Solved | None, *, effort: Effort = Effort.FULL) -> Solved:
        """The carriage held by its mainline, its clamp or an ideal force. `shoe` is its state on a nearby shoe.

        The mainline holds it where that pulls; the clamp where the mainline would have to push, or to pull less than
        its own weight does."""
        rig = self.rig
        if effort is Effort.NEAR and not any((place, clamp) in self._last for clamp in (False, True)):
            effort = Effort.QUICK
        if rig.ideal or rig.carriage.clamped:
            return self._solve(place, case, start=shoe, effort=effort)
        if not rig.kind.keeps_length and case.height is None:
            self._require_lift(case.station, case.payload)
        name, own = rig.carriage.name, self.own_pull(place.span, case.station)
        # The clamp is tried first if it held the last state: this is faster and gives the same result.
        held = self._clamped(place, case, shoe, effort=effort) if self._was_clamped.get(place) else None
        pulled, failure, tried = None, None, held
        if held is None or held[f"{name}.holding"] > 0.0:
            try:
                pulled = self._solve(place, case, effort=min(effort, Effort.QUICK), start=held or shoe)
            except EquilibriumError as error:
                failure = error
        if held is None and (pulled is None or pulled[f"{name}.mainline_pull"] < own):
            held = self._clamped(place, case, shoe, effort=effort)
        holds = np.inf if held is None else held[f"{name}.holding"]
        if failure is not None and holds > 0.0:
            full = effort if holds > own else min(effort, Effort.QUICK)
            try:
                if held is tried and full < Effort.FULL:
                    raise failure
                pulled = self._solve(place, case, effort=full, start=None if held is tried else held, failure=failure)
            except EquilibriumError:
                if held is None or holds > own:
                    raise
        self._was_clamped[place] = pulled is None or holds <= 0.0
        if pulled is not None and holds > 0.0:
            return pulled
        if not rig.kind.has_clamp:
            raise OutOfReachError(
                f"At station {case.station:g} m the carriage of {rig.name!r} is beyond its rest point with "
                f"{case.payload:g} kg: the mainline would have to push",
                "Raise the haulback's tension, or choose a station nearer to the headspar",
                rig.carriage.name,
                "rest point",
            )
        return cast(Solved, held)

    def _clamped(
        self, place: Place, case: StationCase, shoe: Solved | None, *, effort: Effort = Effort.FULL
    ) -> Solved | None:
        """The carriage held by its clamp; None where there is no equilibrium."""
        try:
            return self._solve(place, case, clamp=True, effort=effort, start=shoe)
        except EquilibriumError:
            return None

    def _require_below_chord(self, span: int, x: float, height: float) -> None:
        """Raises OutOfReachError for a height z of the carriage [m] at or above the chord."""
        chord = self.rig.chord(span, x)
        if height >= chord:
            raise OutOfReachError(
                f"At station {x:g} m the carriage of {self.rig.name!r} would have to be at {height:g} m, but the chord "
                f"of its span is at {chord:g} m",
                "Reduce the height, or raise the spars",
                self.rig.carriage.name,
                "clearance",
            )

    def _require_lift(self, x: float, payload: float) -> None:
        """Raises EquilibriumError where a running skyline's haulback cannot support the load at any depth. For
        straight, almost vertical ropes, T + M = 2 T (L - x) / x towards the headspar and 2 T towards the tail. The load
        includes half the weight of the four ropes, at least that of their horizontal lengths."""
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

    def own_pull(self, span: int, x: float) -> float:
        """Upper bound of the mainline tension from its own weight [N]; below it the mainline cannot stay taut."""
        rope = self.rig.mainline
        if rope is None:
            return 0.0
        stands = [node.at for node in self.rig.stands[: span + 1]]
        ends = [*stands, (x, stands[-1][1], self.rig.stands[span + 1].at[2])]
        longest = max(sum(abs(p - q) for p, q in zip(a, b, strict=True)) for a, b in pairwise(ends))
        return longest * rope.mass_per_length * self.rig.gravity

    def beside(self, span: int, station: float) -> float:
        """The station, moved by `SIDE` off a support."""
        low, high = self.rig.stands[span].at[0], self.rig.stands[span + 1].at[0]
        side = min(SIDE, (high - low) / 4.0)
        return min(max(station, low + side), high - side)

    def _solve(
        self,
        place: Place,
        case: StationCase,
        *,
        clamp: bool = False,
        effort: Effort = Effort.FULL,
        start: Solved | None = None,
        failure: EquilibriumError | None = None,
    ) -> Solved:
        """The solution of a case at a place. `start` is a solution of another model, on a nearby shoe or clamped at the
        same place; `failure` is the error of an attempt from nearby points and geometry."""
        at = span_model(self.rig, place, self.by_height, clamp, like=self.like, compiled=self.compiled)
        known = self._last.get((place, clamp), [])
        first = None
        if start is not None and start.at.place == place:
            first = on_mainline(at, start)
        elif start is not None and start.at.rig is at.rig:
            first = off_shoe(at, start)
        near = [] if failure is not None else _extrapolated(known, case)
        point = physical_state(at, case, near, start=first, effort=effort, failure=failure)
        self._last[place, clamp] = [*known[-1:], _Known(case, point)]
        held_by = "clamp" if clamp or at.rig.carriage.clamped else "holding" if at.rig.ideal else "mainline"
        return Solved(at, point, at.outputs(point), held_by, case)


class _Known(NamedTuple):
    """A solved point and its case."""

    case: StationCase
    point: Point


def _extrapolated(known: list[_Known], case: StationCase) -> list[Point]:
    """Initial guess: the last solved point, or an extrapolation of the last two over the one quantity of the case in
    which they differ."""
    if not known:
        return []
    last, first = known[-1], known[0]
    cases = [(q.station, q.payload, q.height or 0.0) for q in (first.case, last.case, case)]
    moves = [(then - now, now - before) for before, now, then in zip(*cases, strict=True) if not before == now == then]
    if len(moves) != 1 or moves[0][1] == 0.0:
        return [last.point]
    share = moves[0][0] / moves[0][1]
    if not -1.0 <= share <= 2.0 or share == 0.0:
        return [last.point]
    point = last.point.copy()
    point.z[:] += share * (last.point.z - first.point.z)
    point.x[:] += share * (last.point.x - first.point.x)
    return [point]
