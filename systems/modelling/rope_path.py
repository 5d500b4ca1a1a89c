"""A rope over its supports, and the loads in each span.

Loads keep their order along the rope, so the discrete state of a run is one integer per support: the number of loads
that have passed it. Span k holds the loads from passed[k + 1] to passed[k] - 1; the last of them is the nearest to its
end a. A crossing changes the integer by one, so no load can be lost or counted twice.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ropeway.components.annotation_checks import Numbers
from ropeway.components.component import Seat
from ropeway.components.errors import InputError, UnbalancedSystemError
from ropeway.components.node import Node
from ropeway.components.rope import Rope
from ropeway.components.span import Span
from ropeway.systems.modelling.declarations import Feed
from ropeway.systems.modelling.system import System


@dataclass(frozen=True)
class Loads:
    """Loads of a run, foremost first.

    Names, masses [kg], drag areas [m2] and positions on the rope [m, unstretched, from the first support at zero
    travel]. `pinned`: index of the span in which a load is fixed at a distance `at` from end a; -1 for a load fixed to
    the rope. `first`: number of the foremost load, negative if an endless rope has run backwards. Drag areas are zero
    if they are left out.
    """

    names: tuple[str, ...] = ()
    mass: np.ndarray = field(default_factory=lambda: np.zeros(0))
    place: np.ndarray = field(default_factory=lambda: np.zeros(0))
    pinned: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))
    at: np.ndarray = field(default_factory=lambda: np.zeros(0))
    first: int = 0
    drag: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if len(self.drag) != len(self.mass):
            object.__setattr__(self, "drag", np.zeros(len(self.mass)))

    @property
    def pins(self) -> bool:
        """Whether a load is fixed at a distance in its span."""
        return len(self.pinned) > 0 and bool(np.maximum.reduce(self.pinned) >= 0)

    def sorted(self, material: np.ndarray) -> Loads:
        """The loads in order, with positions of pinned loads from the rope coordinates at the supports.

        `material` (supports,): the rope coordinate at each support.
        """
        span = np.maximum(self.pinned, 0)
        inside = np.minimum(material[span] + self.at, np.maximum(material[span], material[span + 1]))
        place = np.where(self.pinned >= 0, inside, self.place)
        order = np.argsort(-place, kind="stable")
        return Loads(
            tuple(self.names[i] for i in order),
            self.mass[order],
            place[order],
            self.pinned[order],
            self.at[order],
            self.first,
            self.drag[order],
        )


@dataclass(frozen=True)
class Run:
    """A rope through consecutive spans; `nodes` has one more element than `spans`.

    `seats` has the seat where the rope arrives at each node, and where it leaves the first one.
    """

    nodes: tuple[Node, ...]
    seats: tuple[Seat, ...]
    spans: tuple[Span, ...]
    loads: Loads
    feed: Feed | None = None

    def carrying(self, *, mass: np.ndarray | None = None, place: np.ndarray | None = None) -> Run:
        """The run with other masses or places of its loads."""
        own = self.loads
        mass, place = own.mass if mass is None else mass, own.place if place is None else place
        loads = Loads(own.names, mass, place, own.pinned, own.at, own.first, own.drag)
        return Run(self.nodes, self.seats, self.spans, loads, self.feed)

    @property
    def name(self) -> str:
        """Names of the first and the last support."""
        return f"{self.nodes[0].name} ... {self.nodes[-1].name}"

    @property
    def rope(self) -> Rope:
        """The rope of the first span."""
        return self.spans[0].rope

    @property
    def points(self) -> np.ndarray:
        """Positions of the supports, shape (n + 1, 3) [m]."""
        return np.array([node.at for node in self.nodes])

    def leaving(self, k: int) -> Seat:
        """The seat from which span k leaves its node."""
        return self.seats[0] if k == 0 else self.nodes[k].through(self.seats[k]) or self.seats[k]

    def start(self, k: int, read: Callable[[str], Numbers]) -> np.ndarray:
        """Start of span k, (x, y, z) [m]. `read` returns the value of a variable."""
        return _place(self.leaving(k), read)

    def end(self, k: int, read: Callable[[str], Numbers]) -> np.ndarray:
        """End of span k, as `start`. On a shoe it differs from the start of the next span."""
        return _place(self.seats[k + 1], read)

    @property
    def closed(self) -> bool:
        """Whether the rope is endless: it ends at its first node, a driven wheel."""
        return self.nodes[0] is self.nodes[-1]

    @property
    def around(self) -> int:
        """Number of circulating loads on an endless rope, otherwise 0."""
        return 0 if self.feed is None else self.feed.around or 0

    @property
    def moves(self) -> bool:
        """Whether a drive, or a drum with constant tension, can move the rope."""
        return any(n.drive_speed is not None or n.set_tension is not None for n in self.nodes)


def _place(seat: Seat, read: Callable[[str], Numbers]) -> np.ndarray:
    """Position of the rope at a seat, (x, y, z) [m]."""
    name = seat.owner.name
    place = np.array([read(f"{name}.{axis}") for axis in "xyz"])
    if seat.offset is not None:
        place[0] += read(f"{name}.{seat.offset}_x")
        place[2] += read(f"{name}.{seat.offset}_z")
    return place


def passed(place: np.ndarray, material: np.ndarray) -> np.ndarray:
    """Number of loads that have passed each support, of the shape of `material` (..., supports).

    A load has passed if its position `place` (descending) exceeds the rope coordinate at the support. A load on a
    support has not passed it.
    """
    count = np.searchsorted(-place, -material, side="left")
    return np.asarray(np.minimum.accumulate(count, axis=-1))


def find_runs(system: System) -> tuple[Run, ...]:
    """The ropes of a system, each followed from its first to its last support.

    Raises UnbalancedSystemError for a rope joined against its direction, or held by no support.
    """
    nodes = {name: c for name, c in system.components.items() if isinstance(c, Node)}
    spans = {name: c for name, c in system.components.items() if isinstance(c, Span)}
    by_seat = {seat: end for end, seat in system.connections.items()}
    follows: dict[str, str] = {}
    for name in spans:
        owner, seat_name = system.connections[name, "b"]
        onward = nodes[owner].through(_seat(nodes[owner], seat_name))
        if onward is not None and (owner, onward.name) in by_seat:
            other, end = by_seat[owner, onward.name]
            if end != "a":
                raise UnbalancedSystemError(
                    f"Spans {name!r} and {other!r} both arrive at {owner!r}",
                    "A rope runs from end a to end b: swap the ends of one span",
                )
            follows[name] = other
    starts = [name for name in spans if name not in follows.values()]
    starts += _cuts(spans, follows, starts, system)
    runs = []
    for start in starts:
        chain = [start]
        while chain[-1] in follows and follows[chain[-1]] != start:
            chain.append(follows[chain[-1]])
        on = tuple(spans[name] for name in chain)
        places = (system.connections[start, "a"], *(system.connections[s.name, "b"] for s in on))
        seats = tuple(_seat(nodes[owner], seat) for owner, seat in places)
        runs.append(_run(system, tuple(nodes[owner] for owner, _ in places), seats, on))
    return tuple(runs)


def _cuts(spans: Iterable[str], follows: Mapping[str, str], starts: Sequence[str], system: System) -> list[str]:
    """The span of each endless rope that starts at its first driven wheel. Raises UnbalancedSystemError."""
    open_ended = set(starts)
    for start in starts:
        while start in follows:
            start = follows[start]
            open_ended.add(start)
    cuts, remaining = [], [name for name in spans if name not in open_ended]
    while remaining:
        loop = [remaining[0]]
        while follows[loop[-1]] != loop[0]:
            loop.append(follows[loop[-1]])
        for name in loop:
            node = system.components[system.connections[name, "a"][0]]
            if isinstance(node, Node) and node.drive_speed is not None:
                cuts.append(name)
                break
        else:
            raise UnbalancedSystemError(
                f"No drive moves the endless rope {loop[0]} ... {loop[-1]}", "Make one of its sheaves a ControlSheave"
            )
        remaining = [name for name in remaining if name not in loop]
    return cuts


def _seat(node: Node, name: str) -> Seat:
    return next(s for s in node.seats if s.name == name)


def _run(system: System, nodes: tuple[Node, ...], seats: tuple[Seat, ...], spans: tuple[Span, ...]) -> Run:
    if any(span.rope != spans[0].rope for span in spans):
        raise InputError(
            f"Rope {spans[0].name} ... {spans[-1].name} contains different ropes", "Use one rope in all spans"
        )
    if all(s.travel is not None for s in seats) and all(n.drive_speed is None for n in nodes):
        raise UnbalancedSystemError(
            f"Nothing holds the rope {spans[0].name} ... {spans[-1].name}: it can run freely",
            "Give one of its supports a speed, or anchor an end",
        )
    start = np.concatenate([[0.0], np.cumsum([s.length for s in spans])])
    index = {span.name: k for k, span in enumerate(spans)}
    feed = next((f for f in system.feeds if f.spans[0].name in index), None)
    if feed is not None:
        if set(feed.spans) != set(spans):
            raise InputError("feed covers only a part of a rope", "Give all its spans, from the first to the last")
        if nodes[0] is nodes[-1]:
            feed = _around(feed, float(start[-1]))
        loads = fed(feed, start[-1])
    else:
        hung = [h for h in system.hung if h.spans[0].name in index]
        if hung and nodes[0] is nodes[-1]:
            raise InputError(f"Load {hung[0].load.name!r} hangs on an endless rope", "Use feed for an endless rope")
        names = tuple(h.load.name for h in hung)
        first = np.array([index[h.spans[0].name] for h in hung], dtype=int)
        single = np.array([len(h.spans) == 1 for h in hung], dtype=bool)
        at = np.array([h.at for h in hung])
        loads = Loads(
            names,
            np.array([h.load.mass for h in hung]),
            start[first] + at if hung else np.zeros(0),
            np.where(single, first, -1) if hung else first,
            at,
            drag=np.array([h.load.drag_area for h in hung]),
        ).sorted(start)
    return Run(nodes, seats, spans, loads, feed)


def _around(feed: Feed, length: float) -> Feed:
    """Feed of an endless rope, with as many evenly spaced loads as fit."""
    count = max(1, round(length / feed.spacing))
    masses = tuple(feed.masses[i % len(feed.masses)] for i in range(count))
    return replace(feed, spacing=length / count, masses=masses, around=count)


def fed(feed: Feed, length: float) -> Loads:
    """Loads of a feed on `length` metres of rope. The last one is half a spacing behind the first support.

    The next few loads wait behind it. An endless rope has its circulating loads only.
    """
    on_line = max(int(np.floor(length / feed.spacing + 0.5)), 0)
    foremost = np.array([(on_line - 0.5) * feed.spacing])
    mass, drag = np.array([feed.masses[0]]), np.array([feed.drag_area if feed.masses[0] else 0.0])
    first = Loads((f"{feed.prefix}l1",), mass, foremost, np.array([-1]), np.zeros(1), drag=drag)
    return extended(first, feed, on_line + 7 if feed.around is None else feed.around - 1)


def extended(loads: Loads, feed: Feed, more: int) -> Loads:
    """The loads with `more` behind the last one."""
    number = len(loads.place) + np.arange(more)
    masses = np.array(feed.masses)[number % len(feed.masses)]
    return Loads(
        loads.names + tuple(f"{feed.prefix}l{i + 1}" for i in number),
        np.concatenate([loads.mass, masses]),
        np.concatenate([loads.place, loads.place[-1] - feed.spacing * np.arange(1, more + 1)]),
        np.concatenate([loads.pinned, np.full(more, -1)]),
        np.concatenate([loads.at, np.zeros(more)]),
        loads.first,
        np.concatenate([loads.drag, np.where(masses > 0.0, feed.drag_area, 0.0)]),  # missing loads bear no wind
    )


def rounds(loads: Loads, begin: int, around: int, length: float, ahead: int, behind: int) -> Loads:
    """The `around` loads of an endless rope, repeated for `ahead` revolutions before and `behind` revolutions after.

    The list begins with load `begin`. Repeated loads are one rope `length` [m] apart.
    """
    revolution, load = np.divmod(np.arange(-ahead * around, (behind + 1) * around), around)
    load += begin
    return Loads(
        tuple(loads.names[i] for i in load),
        loads.mass[load],
        loads.place[load] - revolution * length,
        loads.pinned[load],
        loads.at[load],
        loads.first + begin - ahead * around,
        loads.drag[load],
    )


def loads_passed(run: Run, rope: np.ndarray) -> np.ndarray:
    """`passed` for `rope` (..., supports) at each support.

    Loads hung by the user stay on the line; pinned loads stay in their spans.
    """
    count = passed(run.loads.place, rope)
    if run.loads.pins:
        pinned = np.flatnonzero(run.loads.pinned >= 0)
        span = run.loads.pinned[pinned]
        least, most = np.zeros(rope.shape[-1], dtype=int), np.full(rope.shape[-1], len(run.loads.place))
        np.maximum.at(least, span, pinned + 1)
        np.minimum.at(most, span + 1, pinned)
        count = np.clip(count, np.maximum.accumulate(least[::-1])[::-1], np.minimum.accumulate(most))
    if run.feed is None:
        count[..., 0], count[..., -1] = len(run.loads.place), 0
    return count


def slot_counts(run: Run, counts: Sequence[int] | np.ndarray) -> tuple[int, ...]:
    """Slots of each span: for its present loads (`counts`), and on a moving line for all loads that fit in its
    length."""
    place = run.loads.place
    gaps = np.diff(-place)
    gap = run.feed.spacing if run.feed is not None else (gaps[gaps > 0.0].min() if np.any(gaps > 0.0) else np.inf)
    spare = 1 if len(run.spans) > 1 and len(place) else 0
    room = [int(np.ceil(s.length * 1.02 / gap)) + 1 if run.moves and len(place) else 0 for s in run.spans]
    return tuple(
        rounded_up(min(max(int(c) + spare, r), max(len(place), int(c))) if run.feed is None else max(int(c) + spare, r))
        for c, r in zip(counts, room, strict=True)
    )


def rounded_up(slots: int) -> int:
    """A number of slots rounded up to three binary digits from 32 on.

    Spans with many loads can then share functions.
    """
    step = 1 << max(0, slots.bit_length() - 3) if slots > 32 else 1
    return -(-slots // step) * step


def drive_speeds(runs: Sequence[Run]) -> dict[tuple[str, str], tuple[str, str]]:
    """Component and variable with the speed of the nearest drive for each seat of a rope."""
    found = {}
    for run in runs:
        driven = [k for k, node in enumerate(run.nodes) if node.drive_speed is not None]
        for k, (node, seat) in enumerate(zip(run.nodes, run.seats, strict=True)):
            if driven:
                after = bisect_left(driven, k)
                beside = driven[max(after - 1, 0) : after + 1]
                nearest = run.nodes[min(beside, key=lambda j: abs(j - k))]
                for touched in (seat, node.through(seat)):
                    if touched is not None:
                        found[node.name, touched.name] = (nearest.name, nearest.drive_speed or "")
    return found
