"""What all skyline rigs share: their parts, and the System they make with the carriage in one of the spans."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from enum import Enum
from typing import Any

import numpy as np

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.carriage import Carriage
from ropeway.components.carriage_on_shoe import CarriageOnShoe
from ropeway.components.component import Node, Seat
from ropeway.components.drum import Drum
from ropeway.components.errors import EquilibriumError, InputError, SlackRopeError
from ropeway.components.guyed_spar import GuyedSpar
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.log import Log
from ropeway.components.map_frame import MapFrame
from ropeway.components.rope import Rope
from ropeway.components.sheave import Sheave
from ropeway.components.spar import Block, HeadSpar, TailSpar
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.empty_rope import lengths_for_tension, lengths_for_total
from ropeway.systems.modelling.system import System
from ropeway.systems.rigs import carriage_guess
from ropeway.systems.rigs.guylines import string_guylines


class RigKind(Enum):
    """How the skyline is held at the yarder."""

    STANDING = "standing"
    LIVE = "live"
    GRAVITY = "gravity"
    RUNNING = "running"


@checked
@dataclass(frozen=True)
class Turn:
    """What hangs under the carriage: a `log` on a `dropline` of unstretched `length` [m]. The payload is the
    log's mass. Raises InputError."""

    log: Log
    dropline: Rope
    length: float

    def __post_init__(self) -> None:
        check.positive(self.length, f"Dropline of {self.log.name!r}", "length", "m")

    def under(self, x: float, y: float, z: float, mass: float, ground: Profile | None) -> Log:
        """The log about where it hangs under a carriage at (x, y, z), with the ground under its rear."""
        lag = 0.2 * self.length * (-self.log.moving or 1.0)
        log = replace(self.log, at=(x + lag, y, z - 0.98 * self.length), mass=max(mass, LEAST))
        for _ in range(3):
            log = on_ground(log, ground, log.rear_start()[0])
        return log


STEEPEST = 0.98
"""Sine of the steepest slope of a shoe that a carriage can stand on."""


LEAST = 1.0
"""A log's least mass [kg]: a payload of nothing is one of this."""


GROUND = ("ground_x", "ground_z", "slope", "slope_after", "rounding")
"""What a log knows of the ground, as `Profile.vertex_at` gives it."""


def on_ground(log: Log, ground: Profile | None, x: float) -> Log:
    """A log with the ground under a point x; far below where there is none."""
    if ground is None:
        return log
    *vertex, room = ground.vertex_at(x)
    known: dict[str, Any] = dict(zip(GROUND, (*vertex, min(log.rounding, room)), strict=True))
    return replace(log, **known)


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class SkylineRig:
    """A skyline with its carriage. `system(span, station)` joins its public parts.

    `length` [m]: unstretched, from the headspar to where the skyline is tied; None for a running skyline.
    The functions standing_skyline, live_skyline, gravity_skyline and running_skyline make one.
    """

    kind: RigKind
    terrain: Profile | None
    headspar: HeadSpar
    supports: tuple[IntermediateSupport, ...]
    tailspar: TailSpar | GuyedSpar
    skyline: Rope
    length: float | None
    tension: float | None
    mainline: Rope | None
    haulback: Rope | None
    haulback_tension: float | None
    haulback_block: Block | None
    carriage: Carriage
    turn: Turn | None
    name: str
    gravity: float

    def __repr__(self) -> str:
        places = ", ".join(f"{node.name} at {node.at[0]:g} m" for node in self.stands)
        return f"<SkylineRig {self.name!r}: {places}>"

    @property
    def map_frame(self) -> MapFrame | None:
        """Where it lies on a map: that of its terrain."""
        return None if self.terrain is None else self.terrain.map_frame

    @property
    def stands(self) -> tuple[Node, ...]:
        """What bounds the spans: headspar, intermediate supports, tailspar."""
        return (self.headspar, *self.supports, self.tailspar)

    @property
    def tail(self) -> tuple[Node | Seat, ...]:
        """The tailspar, with its block and tailhold where the skyline runs on."""
        hold = self.tailspar.tailhold
        return (self.tailspar,) if hold is None else (self._tail_block("skyline"), hold)

    def _tail_block(self, rope: str) -> Node | Seat:
        """The block at the tailspar's top that a rope runs through."""
        if isinstance(self.tailspar, GuyedSpar):
            return self.tailspar.block(rope)
        return Block(self.tailspar.name, at=self.tailspar.at, capacity=self.tailspar.capacity)

    def _from_yarder(self, rope: str, drum: str, tension: float | None = None) -> list[Any]:
        """Where a rope comes from: a drum at the headspar's top, or at a guyed one's foot and a block at its top."""
        if isinstance(self.headspar, GuyedSpar):
            return [Drum(drum, at=self.headspar.foot, tension=tension), self.headspar.block(rope)]
        return [Drum(drum, at=self.headspar.at, tension=tension)]

    @property
    def skyline_drum(self) -> str:
        """Name of the drum that sets the skyline's length, or a running one's tension."""
        if self.kind is RigKind.RUNNING:
            return "haulback"
        return "skyline" if isinstance(self.headspar, GuyedSpar) else self.headspar.name

    @property
    def ends(self) -> tuple[Node, ...]:
        """Headspar, supports, and tailspar with its tailhold: what the skyline runs over."""
        hold = self.tailspar.tailhold
        return (*self.stands, *(() if hold is None else (hold,)))

    @property
    def points(self) -> np.ndarray:
        """Points that the skyline runs over, shape (n, 3) [m]."""
        return np.array([node.at for node in self.ends])

    @property
    def spans(self) -> int:
        """Spans that the carriage can run on."""
        return len(self.supports) + 1

    def span_of(self, station: float) -> int:
        """The span of a station, counted from 0; at a support that before it. Raises InputError."""
        x = [node.at[0] for node in self.stands]
        if not x[0] < station < x[-1]:
            raise InputError(
                f"Station {station:g} m is outside the skyline",
                f"It runs from {x[0]:g} m to {x[-1]:g} m, ends excluded",
            )
        return int(np.searchsorted(x, station, side="left")) - 1

    def chord(self, span: int, station: float) -> float:
        """Height z of the chord of a span at a station [m]."""
        check.index(span, self.spans, self.name, "span")
        a, b = self.stands[span].at, self.stands[span + 1].at
        return a[2] + (b[2] - a[2]) * (station - a[0]) / (b[0] - a[0])

    @property
    def ideal(self) -> bool:
        """Whether an ideal force holds the carriage."""
        return self.mainline is None and not self.carriage.clamped

    def start(self, span: int, station: float, payload: float, height: float | None = None) -> carriage_guess.Start:
        """Where the carriage is about: the ellipse of its span [or at a given `height` z]."""
        check.index(span, self.spans, self.name, "span")
        if not self.stands[0].at[0] <= station <= self.stands[-1].at[0]:
            raise InputError(f"Station {station:g} m is outside the skyline", "Choose one between its spars")
        load = (self.carriage.mass + payload) * self.gravity
        weight, strain = self.skyline.mass_per_length * self.gravity, self.skyline.strain
        ends = self.points[span : span + 2]
        if self.kind is RigKind.RUNNING:
            return carriage_guess.running(ends, station, weight, load, self.tension or 0.0, height)
        if height is not None:
            return carriage_guess.at_height(ends, station, weight, load, height)
        return carriage_guess.ellipse(self.points, span, station, weight, strain, self.length or 0.0, load)

    def shoe_near(self, station: float) -> int | None:
        """The support, counted from 0, with a shoe near a station; None where there is none."""
        for k, support in enumerate(self.supports):
            if abs(station - support.at[0]) < 2.0 * support.radius:
                return k
        return None

    def system(
        self,
        span: int = 0,
        station: float | None = None,
        payload: float | None = None,
        *,
        on: int | None = None,
        rollers: int | None = None,
    ) -> System:
        """The system with the carriage in a span, about at a station [m] (by default mid-span); or, `on` a
        support (counted from 0) that has a radius, on its shoe. rollers: how many supports the mainline runs
        over, by default all that it has passed.

        It is solved like any other: `equilibrium(rig.system(0, 120.0))`. With an ideal holding force the
        station is exact (`carriage.x` is a parameter); otherwise give `carriage.x` and solve for the travel
        of the mainline's drum (of the clamp, where there is one). Raises InputError, SlackRopeError.
        """
        mass = self.carriage.payload if payload is None else payload
        carriage, start = self._carriage(span, station, mass) if on is None else self._on_shoe(on, station, mass)
        span = span if on is None else on
        system = System(self.name, gravity=self.gravity, terrain=self.terrain)
        for spar in (self.headspar, self.tailspar):
            if isinstance(spar, GuyedSpar):
                string_guylines(system, spar)
        if self.kind is RigKind.RUNNING:
            self._running(system, carriage)
        else:
            self._skyline(system, carriage, span, on)
        if self.pulled:
            self._mainline(system, carriage, span if rollers is None else rollers, start.pull)
        if self.haulback is not None and not carriage.clamped and self.kind is not RigKind.RUNNING:
            if self.haulback_block is None:
                way: list[Any] = [Drum("haulback", at=self.tailspar.at, tension=self.haulback_tension)]
            else:
                way = [*self._from_yarder("haulback", "haulback", self.haulback_tension), self.haulback_block]
            _string(system, self.haulback, [*way, carriage.haulback], self.haulback_tension or 0.0)
        if self.turn is not None:
            x, y, z = carriage.at
            log = self.turn.under(x, y, z, mass, self.terrain)
            system.string(self.turn.dropline, carriage.dropline, log, length=self.turn.length)
        return system

    def _carriage(self, span: int, station: float | None, mass: float) -> tuple[Carriage, carriage_guess.Start]:
        """The carriage about at a station of a span."""
        if not 0 <= span < self.spans:
            raise InputError(f"Span {span} of {self.spans}", f"Choose from 0 to {self.spans - 1}")
        here, there = self.stands[span].at, self.stands[span + 1].at
        x = (here[0] + there[0]) / 2.0 if station is None else station
        if not here[0] < x < there[0]:
            ends = f"{self.stands[span].name} and {self.stands[span + 1].name}"
            raise InputError(
                f"Station {x:g} m is not between {ends}", f"They stand at {here[0]:g} m and {there[0]:g} m"
            )
        start = self.start(span, x, mass)
        share = (x - here[0]) / (there[0] - here[0])
        place = (x, here[1] + share * (there[1] - here[1]), start.z)
        return replace(self.carriage, at=place, payload=mass if self.turn is None else 0.0), start

    def _on_shoe(self, on: int, station: float | None, mass: float) -> tuple[Carriage, carriage_guess.Start]:
        """The carriage on a support's shoe."""
        if not 0 <= on < len(self.supports) or self.supports[on].radius <= 0.0:
            raise InputError(f"{self.name} has no shoe {on}", "Give the support a radius")
        support = self.supports[on]
        start = self.on_shoe_start(on, support.at[0] if station is None else station, mass)
        place = (support.at[0] if station is None else station, support.at[1], start.z)
        mine = {f.name: getattr(self.carriage, f.name) for f in fields(self.carriage)}
        mine.update(at=place, payload=mass if self.turn is None else 0.0)
        return CarriageOnShoe(**mine, support=support, mainline_on_roller=self.pulled), start

    def on_shoe_start(self, on: int, station: float, payload: float) -> carriage_guess.Start:
        """Where the carriage is on a support's shoe, the skyline's tension about, and the pull along the shoe."""
        check.index(on, len(self.supports), self.name, "on")
        support = self.supports[on]
        x = station - support.centre[0]
        if abs(x) > STEEPEST * support.radius:
            raise EquilibriumError(f"Station {station:g} m is off the shoe of {support.name!r}", "Take one on it")
        rise = (support.radius**2 - x * x) ** 0.5
        tension = self.start(on, support.at[0] - support.radius, payload).tension
        pull = (self.carriage.mass + payload) * self.gravity * x / support.radius
        return carriage_guess.Start(support.centre[1] + rise, tension, pull)

    @property
    def pulled(self) -> bool:
        """Whether a real mainline pulls the carriage."""
        return self.mainline is not None and not self.carriage.clamped

    def _skyline(self, system: System, carriage: Carriage, span: int, on: int | None) -> None:
        head = [self.headspar] if self.kind is RigKind.STANDING else self._from_yarder("skyline", self.skyline_drum)
        over: list[Any] = [*head, *self.supports, *self.tail]
        first = len(head) + span
        over[first : first + (on is not None)] = [carriage]
        length = self.length or 0.0
        if len(head) > 1:  # from the drum up to the block, with the bare rope's stretch
            strain = self.skyline.strain.at(self._bare_tension)
            length += float(np.linalg.norm(np.subtract(_node(head[1]).at, head[0].at))) / (1.0 + strain)
        if any(s.friction > 0.0 for s in self.supports):
            # Friction in the saddles counts from where the bare rope lay on them: by the rope beyond each.
            strung = np.cumsum(self._shared([_node(o).at for o in over], length)[::-1])[::-1]
            bare = np.cumsum(self._shared(self.points, self.length or 0.0)[::-1])[::-1]
            for k, support in enumerate(self.supports):
                if k != on:
                    place = over.index(support)
                    over[place] = replace(support, rest=float(bare[k + 1] - strung[place]))
        system.string(self.skyline, *over, length=length)

    @property
    def _bare_tension(self) -> float:
        """Tension of the bare skyline at the headspar [N], all spars upright; its least one for a slack rope."""
        if self.tension is not None:
            return self.tension
        points, rope = [tuple(p) for p in self.points], self.skyline
        weight, names = rope.mass_per_length * self.gravity, [f"skyline {k + 1}" for k in range(len(points) - 1)]
        low, high = 0.0, rope.breaking_load
        for _ in range(50):
            middle = 0.5 * (low + high)
            try:
                long = lengths_for_tension(points, weight, rope.strain, middle, names).sum() > (self.length or 0.0)
            except SlackRopeError:
                long = True
            low, high = (middle, high) if long else (low, middle)
        return high

    def _shared(self, points: Sequence[Sequence[float]] | np.ndarray, length: float) -> np.ndarray:
        """How a length of the skyline [m] is shared out at rest over `points` without a load."""
        names = [f"skyline {k + 1}" for k in range(len(points) - 1)]
        weight = self.skyline.mass_per_length * self.gravity
        return lengths_for_total([tuple(p) for p in points], weight, self.skyline.strain, length, names)

    def _running(self, system: System, carriage: Carriage) -> None:
        over = [*self._from_yarder("haulback", "haulback", self.tension), carriage, self._tail_block("haulback")]
        _string(system, self.skyline, [*over, carriage.haulback], self.tension or 0.0)

    def _mainline(self, system: System, carriage: Carriage, count: int, pull: float) -> None:
        rope = self.mainline
        if rope is None:
            return
        rollers = [_roller(support) for support in self.supports[:count]]
        over = [*self._from_yarder("mainline", "mainline"), *rollers, carriage.mainline]
        # Beside the skyline and the guylines of a guyed spar its spans need names of their own.
        _string(system, rope, over, pull, "line" if isinstance(self.headspar, GuyedSpar) else None)


def _node(one: Node | Seat) -> Node:
    """A node, or that of a seat."""
    node = one.owner if isinstance(one, Seat) else one
    if not isinstance(node, Node):
        raise InputError(f"{node.name!r} is no support", "Give a node or a seat of one")
    return node


def _string(system: System, rope: Rope, over: Sequence[Any], tension: float, name: str | None = None) -> None:
    """Runs a rope with about a tension [N], and not less than its own weight needs."""
    points = np.array([_node(o).at for o in over])
    lengths = carriage_guess.rope_lengths(points, rope.mass_per_length * system.gravity, rope.strain, tension)
    system.string(rope, *over, length=float(lengths.sum()), name=name)


def _roller(support: IntermediateSupport) -> Node:
    """What the mainline runs over at a support: a sheave, or an arc like that of its shoe."""
    name = f"{support.name}_mainline"
    if support.radius == 0.0:
        return Sheave(name, at=support.at)
    return IntermediateSupport(name, at=support.at, radius=support.radius, slope=support.slope)
