"""Which equilibrium of a rig is meant at a station, and how it is found there from cold.

At a station, with the rope's length fixed (or what the rig fixes instead: a drum's tension, the carriage's height), it
is the stable and taut state that the empty carriage's state becomes as the payload grows from zero. Where all ropes
that run through are taut there is one such state only (`RigCheck`), so that any start will do; elsewhere the state is
followed by the payload. A log hangs free where it can; where it cannot, it drags as if the ground had come up to it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntEnum

import numpy as np

from ropeway.components.errors import EquilibriumError, OutOfReachError
from ropeway.systems.solvers.newton import Point
from ropeway.systems.studies.skyline.carriage_model import Question, SpanModel
from ropeway.systems.studies.skyline.starting_points import from_geometry

BESIDE = 1.0
"""Before a refusal is believed, the stations so far to either side [m] are solved, and followed from there."""

SHORTEST = 1.0 / 128.0
"""Part of a path below which a step that fails ends it, as at a fold."""

LEAST_STEP = 1e-3
"""Part of a Newton step below which a root is not nearby."""

FARTHEST = 2.0
"""A carriage or log that moves farther than this in a step [m] may have changed to another state."""

DEEP = 1e3
"""A ground so far below a log [m] is out of its reach."""


class Effort(IntEnum):
    """Starts that are tried: NEAR, solved points and one that belongs to the question; QUICK, and directly from
    geometry; FULL, and all continuations of a state."""

    NEAR = 0
    QUICK = 1
    FULL = 2


Continuation = Callable[[SpanModel, Question], tuple[Point, bool]]
"""How a point is found, and whether it is the only one."""


def meant(
    at: SpanModel,
    asked: Question,
    near: Sequence[Point] = (),
    *,
    start: Point | None = None,
    effort: Effort = Effort.FULL,
    refused: EquilibriumError | None = None,
) -> Point:
    """The equilibrium that is meant. near: solved points to start from, which make it faster; start: one that belongs
    to this question; refused: the refusal of a try before, after which geometry is no start. Raises
    EquilibriumError."""
    for known in near:
        try:
            point, alone = settled(at, known.copy(), asked, shortest=LEAST_STEP)
        except EquilibriumError:
            continue
        if alone:
            return point
    refusals: list[EquilibriumError] = [] if refused is None else [refused]
    direct: Point | None = None
    starts: list[Point | None] = [] if start is None else [start]
    if refused is None and effort > Effort.NEAR:
        starts.append(None)
    for first in starts:
        try:
            found, alone = settled(at, first, asked) if first is not None else _from_geometry(at, asked)
        except EquilibriumError as error:
            refusals.append(error)
            continue
        if alone:
            return found
        direct = found if direct is None else direct
    if direct is not None and at.log is not None:
        return direct
    # Where more than one state is possible, that by payload is meant; the others only find a state.
    continuations: tuple[Continuation, ...] = (
        (_by_payload,) if direct is not None else (_lightened, _from_beside, _from_middle)
    )
    if direct is None and asked.payload > 0.0:
        continuations = (_by_payload, *continuations)
    for continuation in () if effort < Effort.FULL and direct is None else continuations:
        try:
            return continuation(at, asked)[0]
        except EquilibriumError as error:
            refusals.append(error)
    if direct is not None:
        return direct
    raise _refusal(at, asked, refusals, refused)


def settled(
    at: SpanModel, point: Point, asked: Question, *, lower: float = 0.0, iterations: int = 25, shortest: float = 1e-7
) -> tuple[Point, bool]:
    """A point solved in place and checked, and whether there can be no other. lower: the ground under a log is taken
    to be so much lower [m]; shortest: part of a Newton step. Raises EquilibriumError."""
    at.load(point, asked.payload)
    target = [] if at.rig.ideal else [asked.station]
    if at.rig.ideal:
        kind, k = at.axes[0]
        point.vector(kind)[k] = asked.station
    if at.by_height:
        target.append(asked.height or 0.0)
    at.ground_under(point, lower)
    for _ in range(12):
        at.newton.solve(point, target=np.array(target, dtype=float), iterations=iterations, shortest=shortest)
        if not at.ground_under(point, lower):
            return point, at.check.require(point)
    raise EquilibriumError("The rear of the log finds no rest on the ground", "Try a station beside this one", at.log)


def _from_geometry(at: SpanModel, asked: Question) -> tuple[Point, bool]:
    start = from_geometry(at, *asked)
    if at.log is None or at.check.log is None:
        return settled(at, start, asked, iterations=80)
    hanging, _ = settled(at, start, asked, lower=DEEP, iterations=80)
    under = at.check.log.gap(hanging)
    if under >= 0.0:
        return settled(at, hanging, asked)
    dragging = hanging.copy()
    at.check.log.lay_down(dragging, asked.payload * at.rig.gravity)
    return settled(at, dragging, asked, iterations=80)


def _by_payload(at: SpanModel, asked: Question) -> tuple[Point, bool]:
    """From the empty carriage at this station."""
    empty, alone = _from_geometry(at, asked._replace(payload=0.0))
    if asked.payload == 0.0:
        return empty, alone
    return follow(at, empty, lambda share: asked._replace(payload=share * asked.payload))


def _lightened(at: SpanModel, asked: Question) -> tuple[Point, bool]:
    """From a heavier carriage, whose ropes are taut, down to the payload."""
    extra = 4.0 * (asked.payload + at.rig.carriage.mass) + 1000.0
    heavy, _ = _from_geometry(at, asked._replace(payload=asked.payload + extra))
    return follow(at, heavy, lambda share: asked._replace(payload=asked.payload + (1.0 - share) ** 3 * extra))


def _from_beside(at: SpanModel, asked: Question) -> tuple[Point, bool]:
    """From the stations to either side."""
    low, high = at.reach
    last: EquilibriumError | None = None
    for station in (asked.station - BESIDE, asked.station + BESIDE):
        if not low < station < high:
            continue
        beside, alone = asked._replace(station=station), False
        for start in (_from_geometry, _by_payload, _lightened):
            if alone:  # there is no other state to start from
                break
            try:
                point, alone = start(at, beside)
                return follow(at, point, _towards(at, station, asked))
            except EquilibriumError as error:
                last = error
    raise last or EquilibriumError("No station is beside it", "Take another station")


def _from_middle(at: SpanModel, asked: Question) -> tuple[Point, bool]:
    """From the middle of the span. Beside a saddle geometry is a bad start: wrong by more than the rope left there."""
    if at.on is not None:
        raise EquilibriumError("A shoe has no middle of a span", "Take another station")
    middle = 0.5 * sum(at.reach)
    start, _ = _from_geometry(at, asked._replace(station=middle))
    return follow(at, start, _towards(at, middle, asked))


def _towards(at: SpanModel, start: float, asked: Question) -> Callable[[float], Question]:
    """From a station to that asked for, by equal ratios of the distance from the end of the span nearest to it."""
    end = min(at.reach, key=lambda x: abs(x - asked.station))
    first, last = start - end, asked.station - end

    def ask(share: float) -> Question:
        offset = first * (last / first) ** share if first * last > 0.0 else first + share * (last - first)
        return asked._replace(station=end + offset)

    return ask


def follow(
    at: SpanModel,
    point: Point,
    ask: Callable[[float], Question],
    lower: Callable[[float], float] = lambda _: 0.0,
) -> tuple[Point, bool]:
    """From a point that answers `ask(0)` to that of `ask(1)`, each step from the one before, halved where it fails or
    goes far; and whether there can be no other. Raises EquilibriumError where the path ends: at a fold."""
    done, step, alone = 0.0, 0.25, False
    before: tuple[float, Point] | None = None
    while done < 1.0:
        share = min(done + step, 1.0)
        trial = point.copy() if before is None else _ahead(before[1], point, (share - done) / (done - before[0]))
        try:
            trial, alone = settled(at, trial, ask(share), lower=lower(share), shortest=LEAST_STEP)
            if step > SHORTEST and _moved(at, point, trial) > FARTHEST:
                raise EquilibriumError("The carriage moves far in one step", "Take a shorter one")
        except EquilibriumError:
            step *= 0.5
            if step < SHORTEST:
                raise
            continue
        before, point, done, step = (done, point), trial, share, 2.0 * step
    return point, alone


def _ahead(before: Point, last: Point, share: float) -> Point:
    """On the line through two points."""
    point = last.copy()
    point.z[:] += share * (last.z - before.z)
    point.x[:] += share * (last.x - before.x)
    return point


def _moved(at: SpanModel, before: Point, after: Point) -> float:
    """How far the carriage, and its log, moved across its path [m]."""
    return max(abs(at.read(after, slot) - at.read(before, slot)) for slot in at.places)


def _refusal(
    at: SpanModel, asked: Question, refusals: Sequence[EquilibriumError], before: EquilibriumError | None
) -> EquilibriumError:
    """The refusal to report: a limit that has a name, else that of the direct start."""
    for error in refusals:
        if isinstance(error, OutOfReachError):
            return error
    if before is not None:
        return before
    first = refusals[0] if refusals else EquilibriumError("No state is nearby", "Try harder")
    return EquilibriumError(
        f"No equilibrium of {at.model.name!r} with the carriage at station {asked.station:g} m and "
        f"{asked.payload:g} kg: {first.cause}",
        "Check the skyline's length, the payload and the lines that hold the carriage",
        first.component,
    )
