"""Loads of a line with inertia near supports: within the zone of a support a load moves with the rope, tied to the
support; it crosses the support tied, and is free again beyond the zone.

    tie     a free load comes within the zone of a support
    cross   a tied load is past its support: it changes spans
    leave   a tied load is beyond 1.1 times the zone: it takes place and velocity of its station on the rope

Each event restarts the integration of the whole line. Therefore loads tie up to a zone earlier and leave up to a zone
later where they can do so together with another event.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ropeway.systems.dynamics.inertia.inertial_state import join, output_rates, slot_motions, slot_outputs, tieable
from ropeway.systems.dynamics.load_crossings import Crossing, passing_event
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import take_more

TIE, CROSS, LEAVE = "tie", "cross", "leave"
PAST = 1.5e-3
"""How far past its support a load crosses [m]."""
NEAR = 5e-4
"""How far before a threshold an event is due [m]."""
BEYOND = 1.1
"""A load leaves at this multiple of the zone, so that it does not come back at once."""
EARLY = 1.0
"""How much earlier an event can be, together with another one, as a share of the zone."""


class ZoneEvent(NamedTuple):
    """What a load does at support k of run r: `load` is its number, `gap` [m] the rope's travel until then at the
    latest, `speed` [m/s] that at which it closes; it is possible `early` [m] before."""

    what: str
    r: int
    k: int
    load: int
    gap: float
    speed: float
    early: float
    forward: bool


@dataclass(frozen=True)
class _Standing:
    """The loads of a run that are on its line, and those that wait at its ends: index, place on the rope [m], span
    (-1 or the number of spans where they wait), and the support that each is tied to, or -1."""

    index: np.ndarray
    place: np.ndarray
    span: np.ndarray
    tied: np.ndarray


class Threshold(NamedTuple):
    """Where the loads of run r come to one kind of event as the rope runs over their supports k: forwards, with side
    1, or backwards, -1. `gap` [m] is the travel until then at the latest, negative where it is overdue; it is possible
    `early` [m] before; `on`: whether it applies. Arrays over the loads."""

    what: str
    r: int
    k: np.ndarray
    side: float
    gap: np.ndarray
    early: np.ndarray
    on: np.ndarray
    load: np.ndarray
    forward: bool


def thresholds(state: LineState) -> list[Threshold]:
    """All events that loads can come to."""
    found: list[Threshold] = []
    zone = state.model.inertia.zone if state.model.inertia is not None else 0.0
    for r in range(len(state.runs)):
        ties = tieable(state.model, r)
        if not ties.any() or not len(state.runs[r].loads.place):
            continue
        take_more(state, r)
        loads, rope, last = _standing(state, r), state.rope(r), len(ties) - 1
        # Loads that leave one end of a short span late must not be beyond the other end by then.
        room = np.clip((np.abs(np.diff(rope)) - 2.0 * BEYOND * zone) / 2.0, 0.0, EARLY * zone)
        early = room[np.clip(loads.span, 0, last - 1)]
        number = loads.index + state.runs[r].loads.first
        inside = (loads.span >= 0) & (loads.span < last)
        free = (loads.tied < 0) & inside
        for end, side in ((0, 1.0), (1, -1.0)):  # free loads towards the ends a and b of their spans
            k = np.where(free, loads.span + end, 0)
            gap = side * (loads.place - rope[k]) - zone
            found.append(Threshold(TIE, r, k, -side, gap, early, free & ties[k], number, end == 1))
        k, tied = np.maximum(loads.tied, 0), loads.tied >= 0
        past, before, behind = loads.place - rope[k], tied & (loads.span < k), tied & (loads.span >= k)
        reach, at_once = BEYOND * zone + early, np.zeros(len(number))
        found += [
            Threshold(CROSS, r, k, 1.0, PAST - past, at_once, before, number, True),
            Threshold(CROSS, r, k, -1.0, past + PAST, at_once, behind, number, False),
            Threshold(LEAVE, r, k, -1.0, reach + past, early, before & inside, number, False),
            Threshold(LEAVE, r, k, 1.0, reach - past, early, behind & inside, number, True),
        ]
    return found


def approached(found: Sequence[Threshold], rates: Sequence[np.ndarray], within: float = np.inf) -> list[ZoneEvent]:
    """The events towards which loads move, at `rates` of travel of each run [m/s], up to where they are possible
    `within` [m]."""
    events = list[ZoneEvent]()
    for t in found:
        speed = t.side * rates[t.r][t.k]
        for i in np.flatnonzero(t.on & (speed > 1e-9) & (t.gap <= within + t.early)):
            numbers = float(t.gap[i]), float(speed[i]), float(t.early[i])
            events.append(ZoneEvent(t.what, t.r, int(t.k[i]), int(t.load[i]), *numbers, t.forward))
    return events


def coming(state: LineState, rates: Sequence[np.ndarray]) -> list[ZoneEvent]:
    """All events towards which loads move, at `rates` of travel of each run [m/s]; a negative gap is overdue."""
    return approached(thresholds(state), rates)


def _standing(state: LineState, r: int) -> _Standing:
    run, beyond, motion = state.runs[r], state.passed[r], slot_motions(state.model)[r]
    on = np.arange(int(beyond[-1]), int(beyond[0]))
    # Span k has the loads from beyond[k + 1] to beyond[k] - 1.
    span = np.searchsorted(-beyond, -on, side="left") - 1
    slot = beyond[span] - 1 - on
    tied = np.where(
        state.point.d[motion.tied[0, span] + slot] > 0.0,
        span,
        np.where(state.point.d[motion.tied[1, span] + slot] > 0.0, span + 1, -1),
    )
    if not run.closed:  # the next load of a feed waits at the first support, the last one off the line at the last
        last = len(beyond) - 1
        if beyond[0] < len(run.loads.place):
            on, span, tied = np.append(on, beyond[0]), np.append(span, -1), np.append(tied, 0)
        if beyond[-1] > 0:
            on, span, tied = np.append(on, beyond[-1] - 1), np.append(span, last), np.append(tied, last)
    return _Standing(on, run.loads.place[on], span, tied)


def due(events: Sequence[ZoneEvent]) -> list[ZoneEvent]:
    """The events that are due, and all that are possible with them, one for each load."""
    if not any(e.gap <= NEAR for e in events):
        return []
    found = {(e.r, e.load): e for e in reversed(events) if e.gap <= NEAR + e.early}
    return list(found.values())


def apply(
    state: LineState, events: Sequence[ZoneEvent], rates: tuple[np.ndarray, np.ndarray]
) -> list[tuple[Crossing, str]]:
    """Applies events in place, with the rates of states and algebraic variables before them; the line is not solved.
    Returns the crossings with what they are called."""
    leaving = [e for e in events if e.what == LEAVE]
    if leaving:
        moved = output_rates(state, *rates)
        seen = state.outputs()
        for event in leaving:
            _leave(state, event, seen, moved)
        for r, k in {(e.r, _slot(state, e.r, e.load)[0]) for e in leaving}:
            join(state, r, k)
    for event in events:
        if event.what == TIE:
            k, j = _slot(state, event.r, event.load)
            motion, point = slot_motions(state.model)[event.r], state.point
            end = 0 if event.k == k else 1
            point.d[motion.tied[end, k] + j], point.d[motion.joined[k] + j] = 1.0, 0.0
            _balance(state, event.r, k, j)
    return [_cross(state, event) for event in events if event.what == CROSS]


def _slot(state: LineState, r: int, load: int) -> tuple[int, int]:
    """Span and slot of a load by its number."""
    beyond, i = state.passed[r], load - state.runs[r].loads.first
    k = int(np.searchsorted(-beyond, -i, side="left")) - 1
    return k, int(beyond[k]) - 1 - i


def _balance(state: LineState, r: int, k: int, j: int) -> None:
    """Starts the tension behind a slot that hangs in balance."""
    layout, motion, point = state.model.layouts[r], slot_motions(state.model)[r], state.point
    d, slots, p = point.d, layout.slots, point.p
    before = point.z[layout.force[k] + np.arange(3)] if j == 0 else point.z[motion.pull[:, k] + j - 1]
    travel = layout.travel.read(point.x, point.z)[k]
    at = [d[slots.at[k] + i] + d[slots.ride[k] + i] * travel for i in (j - 1, j) if i >= 0]
    length = at[-1] - (at[0] if len(at) > 1 else 0.0)
    weight = (p[layout.mass_per_length[k]] * length + d[slots.mass[k] + j]) * p[0]
    point.z[motion.pull[:, k] + j] = before + np.array([0.0, 0.0, weight])


def _leave(state: LineState, event: ZoneEvent, seen: np.ndarray, moved: np.ndarray) -> None:
    """Frees a load: it takes the place and the velocity of its station."""
    k, j = _slot(state, event.r, event.load)
    motion, point = slot_motions(state.model)[event.r], state.point
    station = slot_outputs(state.model, event.r)[:, k] + j
    damping = state.model.inertia.damping if state.model.inertia is not None else 0.0
    point.x[motion.velocity[:, k] + j] = moved[station]
    # The rope sees the place a little ahead: there the tension does not jump.
    point.x[motion.place[:, k] + j] = seen[station] - damping * moved[station]
    point.d[motion.tied[:, k] + j] = 0.0


class _Moving(NamedTuple):
    """What a slot with a load has in a span."""

    place: np.ndarray
    velocity: np.ndarray
    pull: np.ndarray
    acceleration: np.ndarray
    tied: np.ndarray
    joined: float
    lost: float


def _taken(state: LineState, r: int, k: int) -> dict[int, _Moving]:
    """What the slots of span k have, by the index of their loads."""
    motion, point, beyond = slot_motions(state.model)[r], state.point, state.passed[r]
    return {
        int(beyond[k]) - 1 - j: _Moving(
            point.x[motion.place[:, k] + j],
            point.x[motion.velocity[:, k] + j],
            point.z[motion.pull[:, k] + j],
            point.z[motion.acceleration[:, k] + j],
            point.d[motion.tied[:, k] + j],
            float(point.d[motion.joined[k] + j]),
            float(point.d[motion.lost[k] + j]),
        )
        for j in range(int(beyond[k] - beyond[k + 1]))
    }


def _put(state: LineState, r: int, k: int, known: dict[int, _Moving]) -> None:
    """Writes what the slots of span k have, now that its loads have changed; empty ones are tied to its end b."""
    motion, point, layout = slot_motions(state.model)[r], state.point, state.model.layouts[r]
    beyond, count = state.passed[r], int(layout.slots.count[k])
    behind = point.z[layout.force[k] + np.arange(3)]
    for j in range(count):
        load = int(beyond[k]) - 1 - j
        own = known.get(load) if load >= beyond[k + 1] else None
        point.d[motion.joined[k] + j] = 0.0 if own is None else own.joined
        point.d[motion.lost[k] + j] = 0.0 if own is None else own.lost
        if own is None:
            point.d[motion.tied[:, k] + j] = (0.0, 1.0)
            point.z[motion.pull[:, k] + j] = behind
            continue
        point.x[motion.place[:, k] + j], point.x[motion.velocity[:, k] + j] = own.place, own.velocity
        point.z[motion.pull[:, k] + j], point.z[motion.acceleration[:, k] + j] = own.pull, own.acceleration
        point.d[motion.tied[:, k] + j] = own.tied
        behind = own.pull


def _cross(state: LineState, event: ZoneEvent) -> tuple[Crossing, str]:
    """Moves a tied load past its support to the other span, where it is tied to the same support."""
    r, run, last = event.r, state.runs[event.r], len(state.passed[event.r]) - 1
    crossing = Crossing(0.0, 0.0, r, event.k, event.load, event.forward)
    ends = [0, last] if run.closed and event.k in (0, last) else [event.k]
    spans = sorted({k for end in ends for k in (end - 1, end) if 0 <= k < last})
    known = {k: _taken(state, r, k) for k in spans}
    lost = {i: own.lost for slots in known.values() for i, own in slots.items()}
    weight = np.array([0.0, 0.0, run.loads.mass[event.load - run.loads.first] * state.point.p[0]])
    layout = state.model.layouts[r]
    for end in ends:
        i = int(state.passed[r][end]) - (0 if event.forward else 1)
        state.passed[r][end] += 1 if event.forward else -1
        into = end if event.forward else end - 1
        if not 0 <= into < last:
            continue
        force = state.point.z[layout.force[into] + np.arange(3)]
        if event.forward:  # the first piece, before the load, is pulled less steeply down
            pull = force.copy()
            state.point.z[layout.force[into] + np.arange(3)] = force - weight
        else:
            ahead = known[into].get(i + 1)
            pull = (force if ahead is None else ahead.pull) + weight
        none = np.zeros(3)
        tied = np.array([1.0, 0.0] if event.forward else [0.0, 1.0])
        gone = lost.get(event.load - run.loads.first, 0.0)
        known[into][i] = _Moving(none, none.copy(), pull, none.copy(), tied, 0.0, gone)
    if not event.forward:
        _lighten(state, r, [end for end in ends if end < last], known)
    state.write_slots()
    for k in spans:
        _put(state, r, k, known[k])
    return crossing, passing_event(state, crossing)


def _lighten(state: LineState, r: int, ends: Sequence[int], known: dict[int, dict[int, _Moving]]) -> None:
    """Where the first load of a span has left it through end a, the tension at that end is that behind the load."""
    layout = state.model.layouts[r]
    for k in ends:
        gone = known[k].get(int(state.passed[r][k]))
        if gone is not None:
            state.point.z[layout.force[k] + np.arange(3)] = gone.pull


def lose(state: LineState, name: str) -> bool:
    """Takes a load off the rope where it hangs. False where no such load is on the line."""
    for r, run in enumerate(state.runs):
        beyond = state.passed[r]
        for i in range(int(beyond[-1]), int(beyond[0])):
            if run.loads.names[i] == name:
                k, j = _slot(state, r, i + run.loads.first)
                state.point.d[slot_motions(state.model)[r].lost[k] + j] = 1.0
                return True
    return False
