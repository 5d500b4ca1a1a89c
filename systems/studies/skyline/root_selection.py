"""Selection of the physical equilibrium of a rig at a station, from a cold start.

The station is given, and the rope's length is fixed (or a drum's tension, or the carriage's height). The physical state
is the stable and taut one that continues the empty carriage's state as the payload grows from zero. If all
through-running ropes are taut, this state is unique (`RigCheck`) and any initial guess serves. Otherwise continuation
in the payload selects it. A log hangs free if possible; otherwise it drags as if the ground had risen to it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntEnum

import numpy as np

from ropeway.components.errors import EquilibriumError, OutOfReachError
from ropeway.systems.solvers.points import Point
from ropeway.systems.studies.skyline.carriage_model import SpanModel, StationCase
from ropeway.systems.studies.skyline.starting_points import from_geometry

BESIDE = 1.0
"""Distance of the neighbouring stations [m] from which a failed state is continued."""

SHORTEST = 1.0 / 128.0
"""Smallest step of a continuation, relative to the path; it ends there, as at a fold."""

LEAST_STEP = 1e-3
"""Smallest fraction of a Newton step for a nearby root."""

FARTHEST = 2.0
"""Largest move of a carriage or log in one continuation step [m]; a longer one may be a jump to another state."""

DEEP = 1e3
"""Depth of a ground that a log cannot reach [m]."""


class Effort(IntEnum):
    """Initial guesses to try. NEAR: solved points and a given start. QUICK: also geometry. FULL: also all
    continuations."""

    NEAR = 0
    QUICK = 1
    FULL = 2


Continuation = Callable[[SpanModel, StationCase], tuple[Point, bool]]
"""A method that returns a point and whether it is unique."""


def physical_state(
    at: SpanModel,
    case: StationCase,
    near: Sequence[Point] = (),
    *,
    start: Point | None = None,
    effort: Effort = Effort.FULL,
    failure: EquilibriumError | None = None,
) -> Point:
    """The physical equilibrium of a case. `near` are solved points, which accelerate the search; `start` is an initial
    guess for this case; `failure` is the error of an earlier attempt, which excludes geometry. Raises
    EquilibriumError."""
    for known in near:
        try:
            point, unique = solved_in_place(at, known.copy(), case, shortest=LEAST_STEP)
        except EquilibriumError:
            continue
        if unique:
            return point
    failures: list[EquilibriumError] = [] if failure is None else [failure]
    direct: Point | None = None
    starts: list[Point | None] = [] if start is None else [start]
    if failure is None and effort > Effort.NEAR:
        starts.append(None)
    for first in starts:
        try:
            found, unique = solved_in_place(at, first, case) if first is not None else _from_geometry(at, case)
        except EquilibriumError as error:
            failures.append(error)
            continue
        if unique:
            return found
        direct = found if direct is None else direct
    if direct is not None and at.log is not None:
        return direct
    # If several states are possible, continuation in the payload selects one; the other methods only find a state.
    continuations: tuple[Continuation, ...] = (
        (_from_empty,) if direct is not None else (_from_heavier, _from_beside, _from_middle)
    )
    if direct is None and case.payload > 0.0:
        continuations = (_from_empty, *continuations)
    for continuation in () if effort < Effort.FULL and direct is None else continuations:
        try:
            return continuation(at, case)[0]
        except EquilibriumError as error:
            failures.append(error)
    if direct is not None:
        return direct
    raise _error_to_report(at, case, failures, failure)


def solved_in_place(
    at: SpanModel, point: Point, case: StationCase, *, lower: float = 0.0, iterations: int = 25, shortest: float = 1e-7
) -> tuple[Point, bool]:
    """Solves a point in place and checks it. Returns the point and whether it is unique. `lower` shifts the ground
    under a log down [m]; `shortest` is the smallest fraction of a Newton step. Raises EquilibriumError."""
    at.load(point, case.payload)
    target = [] if at.rig.ideal else [case.station]
    if at.rig.ideal:
        kind, k = at.axes[0]
        point.vector(kind)[k] = case.station
    if at.by_height:
        target.append(case.height or 0.0)
    at.ground_under(point, lower)
    for _ in range(12):
        at.newton.solve(point, target=np.array(target, dtype=float), iterations=iterations, shortest=shortest)
        if not at.ground_under(point, lower):
            return point, at.check.require(point)
    raise EquilibriumError("The log's rear does not settle on one segment of ground", "Choose a station nearby", at.log)


def _from_geometry(at: SpanModel, case: StationCase) -> tuple[Point, bool]:
    start = from_geometry(at, *case)
    if at.log is None or at.check.log is None:
        return solved_in_place(at, start, case, iterations=80)
    hanging, _ = solved_in_place(at, start, case, lower=DEEP, iterations=80)
    under = at.check.log.gap(hanging)
    if under >= 0.0:
        return solved_in_place(at, hanging, case)
    dragging = hanging.copy()
    at.check.log.lay_down(dragging, case.payload * at.rig.gravity)
    return solved_in_place(at, dragging, case, iterations=80)


def _from_empty(at: SpanModel, case: StationCase) -> tuple[Point, bool]:
    """Continuation from the empty carriage at this station."""
    empty, unique = _from_geometry(at, case._replace(payload=0.0))
    if case.payload == 0.0:
        return empty, unique
    return follow(at, empty, lambda share: case._replace(payload=share * case.payload))


def _from_heavier(at: SpanModel, case: StationCase) -> tuple[Point, bool]:
    """Continuation from a heavier carriage, which tensions the ropes, down to the payload."""
    extra = 4.0 * (case.payload + at.rig.carriage.mass) + 1000.0
    heavy, _ = _from_geometry(at, case._replace(payload=case.payload + extra))
    return follow(at, heavy, lambda share: case._replace(payload=case.payload + (1.0 - share) ** 3 * extra))


def _from_beside(at: SpanModel, case: StationCase) -> tuple[Point, bool]:
    """Continuation from the stations on both sides."""
    low, high = at.reach
    last: EquilibriumError | None = None
    for station in (case.station - BESIDE, case.station + BESIDE):
        if not low < station < high:
            continue
        beside, unique = case._replace(station=station), False
        for start in (_from_geometry, _from_empty, _from_heavier):
            if unique:  # no other state to start from
                break
            try:
                point, unique = start(at, beside)
                return follow(at, point, _towards(at, station, case))
            except EquilibriumError as error:
                last = error
    raise last or EquilibriumError("The span has no neighbouring station", "Choose another station")


def _from_middle(at: SpanModel, case: StationCase) -> tuple[Point, bool]:
    """Continuation from mid-span. Close to a saddle geometry is a poor guess: its error exceeds the rope between
    carriage and saddle."""
    if at.on is not None:
        raise EquilibriumError("A shoe has no mid-span", "Choose another station")
    middle = 0.5 * sum(at.reach)
    start, _ = _from_geometry(at, case._replace(station=middle))
    return follow(at, start, _towards(at, middle, case))


def _towards(at: SpanModel, start: float, case: StationCase) -> Callable[[float], StationCase]:
    """A path from a station to that of the case, in equal ratios of the distance from the nearest end of the span."""
    end = min(at.reach, key=lambda x: abs(x - case.station))
    first, last = start - end, case.station - end

    def case_at(share: float) -> StationCase:
        offset = first * (last / first) ** share if first * last > 0.0 else first + share * (last - first)
        return case._replace(station=end + offset)

    return case_at


def follow(
    at: SpanModel,
    point: Point,
    case_at: Callable[[float], StationCase],
    lower: Callable[[float], float] = lambda _: 0.0,
) -> tuple[Point, bool]:
    """Continuation from a solution of `case_at(0)` to one of `case_at(1)`. Steps that fail or move too far are halved.
    Returns the point and whether it is unique. Raises EquilibriumError where the path ends, as at a fold."""
    done, step, unique = 0.0, 0.25, False
    before: tuple[float, Point] | None = None
    while done < 1.0:
        share = min(done + step, 1.0)
        trial = point.copy() if before is None else _extrapolated(before[1], point, (share - done) / (done - before[0]))
        try:
            trial, unique = solved_in_place(at, trial, case_at(share), lower=lower(share), shortest=LEAST_STEP)
            if step > SHORTEST and _moved(at, point, trial) > FARTHEST:
                raise EquilibriumError("The carriage moves too far in one step", "Reduce the step")
        except EquilibriumError:
            step *= 0.5
            if step < SHORTEST:
                raise
            continue
        before, point, done, step = (done, point), trial, share, 2.0 * step
    return point, unique


def _extrapolated(before: Point, last: Point, share: float) -> Point:
    """Linear extrapolation through two points."""
    point = last.copy()
    point.z[:] += share * (last.z - before.z)
    point.x[:] += share * (last.x - before.x)
    return point


def _moved(at: SpanModel, before: Point, after: Point) -> float:
    """Displacement of the carriage and its log across the path [m]."""
    return max(abs(at.read(after, slot) - at.read(before, slot)) for slot in at.places)


def _error_to_report(
    at: SpanModel, case: StationCase, failures: Sequence[EquilibriumError], before: EquilibriumError | None
) -> EquilibriumError:
    """The error to report: a named limit, otherwise the error of the direct start."""
    for error in failures:
        if isinstance(error, OutOfReachError):
            return error
    if before is not None:
        return before
    first = failures[0] if failures else EquilibriumError("No nearby state converged", "Search with full effort")
    return EquilibriumError(
        f"No equilibrium of {at.model.name!r} with the carriage at station {case.station:g} m and "
        f"{case.payload:g} kg: {first.cause}",
        "Check the skyline's length, the payload, mainline and haulback",
        first.component,
    )
