"""What a user declares: components, how they are joined, and the loads on their ropes."""

from __future__ import annotations

import inspect
import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TypeVar, overload

from ropeway.components import check, units
from ropeway.components.argument_checks import checked
from ropeway.components.component import (
    Component,
    Kind,
    Node,
    Outlet,
    Port,
    RopeEnd,
    Seat,
    SignalInput,
    SignalOutput,
    Site,
    Supply,
)
from ropeway.components.errors import InputError, UnbalancedSystemError
from ropeway.components.load import Load
from ropeway.components.response import check_precedence
from ropeway.components.rope import Rope, hanging_limit
from ropeway.components.span import Span
from ropeway.systems.modelling.declarations import Declarations, Feed, Hung
from ropeway.systems.modelling.empty_rope import lengths_for_tension, lengths_for_total
from ropeway.systems.modelling.subsystem import Subsystem, include

GRAVITY = 9.80665
"""Standard gravity [m/s2]."""

MOST_LOADS = 10_000
"""More loads than this on one rope are a mistake of units."""

_Added = TypeVar("_Added", bound=Component)
_COMMAND_LINE = ("typer", "click")
_PACKAGE = str(Path(__file__).parents[2])


@checked
class System(Declarations):
    """Components and their connections. Declarations only: nothing is solved here."""

    def __init__(self, name: str = "system", *, gravity: float = GRAVITY, precedence: str = "all at once") -> None:
        """gravity [m/s2]; precedence: who acts first when several control sheaves respond, one of
        `ropeway.components.response.PRECEDENCES`. Raises InputError."""
        check_precedence(precedence)
        check.positive(gravity, f"System {name!r}", "gravity", "m/s2")
        super().__init__(name, gravity, precedence)

    def __repr__(self) -> str:
        spans = sum(isinstance(c, Span) for c in self.components.values())
        feeds = f", {len(self.feeds)} feeds" if self.feeds else ""
        return (
            f"<System {self.name!r}: {len(self.components) - spans} components, {spans} spans, {len(self.hung)} loads"
            f"{feeds}>"
        )

    @property
    def precedence(self) -> str:
        """Who acts first when several control sheaves respond."""
        return self.precedences[""]

    @precedence.setter
    def precedence(self, value: str) -> None:
        check_precedence(value)
        self.precedences = dict.fromkeys(self.precedences, value)

    def precedence_of(self, component: str) -> tuple[str, str]:
        """The subsystem that a component belongs to, "" for none, and who acts first among its control sheaves."""
        own = max((g for g in self.precedences if not g or component.startswith(f"{g}.")), key=len)
        return own, self.precedences[own]

    @overload
    def add(self, component: _Added) -> _Added: ...

    @overload
    def add(self, component: System, name: str) -> Subsystem: ...

    def add(self, component: _Added | System, name: str | None = None) -> _Added | Subsystem:
        """Add a component, or a system as a part of this one.

        Parameters
        ----------
        component
            A component, or a system: its components become `name.component`, its loads `name.load`; ports that it
            leaves open are connected here. Its sheaves keep a precedence of their own.
        name
            Of the subsystem.

        Returns
        -------
        Component or Subsystem
            The component itself; of a system its components under their new names, by their own:
            `line = outer.add(inner, name="a")`, `line["c1"].supply`.

        Raises
        ------
        InputError
            The name is taken, or the system has another gravity.
        """
        if isinstance(component, System):
            return self._include(component, name)
        if name is not None:
            raise InputError(f"{component.name!r} has a name", "Give name= with a system")
        known = self.components.get(component.name)
        if known is component:
            return component
        if known is not None or component.name in self._load_names():
            first = self.origin(component.name, "; the first was added at {}")
            raise InputError(
                f"Two components are named {component.name!r}{first}", "Give each component a name of its own"
            )
        self.components[component.name] = component
        self.origins[component.name] = caller()
        return component

    def _include(self, inner: System, name: str | None) -> Subsystem:
        if name is None:
            raise InputError(f"System {inner.name!r} needs a name as a part of {self.name!r}", "Give name=")
        check.name(name, "Subsystem")
        if inner is self:
            raise InputError(f"System {self.name!r} cannot be a part of itself", "Add another one")
        if inner.gravity != self.gravity:
            raise InputError(f"{inner.name!r} has another gravity than {self.name!r}", "Give both the same")
        taken = [n for n in (*self.components, *self._load_names()) if n == name or n.startswith(f"{name}.")]
        if taken:
            raise InputError(f"The name {name!r} is taken by {taken[0]!r}", "Give each part a name of its own")
        return include(self, inner, name, caller())

    def connect(self, one: Port, other: Port) -> None:
        """Join a rope end to a seat: one position, one rope travel, forces that sum to zero. Or the supply of a
        control sheave's hydraulic drive to the outlet of a power unit, which takes any number of them. Or an
        `output` of a component to the `input` of another, in place of what that has of its own.

        Raises InputError when a port is joined already, or the ports do not fit.
        """
        if isinstance(one, (SignalInput, SignalOutput)) or isinstance(other, (SignalInput, SignalOutput)):
            self._connect_signal(one, other)
            return
        if isinstance(one, (Supply, Outlet)) or isinstance(other, (Supply, Outlet)):
            self._connect_supply(one, other)
            return
        end, seat = (one, other) if isinstance(one, RopeEnd) else (other, one)
        if not isinstance(end, RopeEnd) or not isinstance(seat, Seat):
            raise InputError(f"{one} and {other} cannot be joined", "Join a rope end to a seat of a support")
        for port in (end, seat):
            self._require_part(port.owner)
        seat = self._open(seat)
        ends = self.connections
        if (end.owner.name, end.name) in ends or (seat.owner.name, seat.name) in self.seated:
            taken = end if (end.owner.name, end.name) in ends else seat
            raise InputError(f"Port {taken} is joined twice", "Each port takes one connection")
        self.connections[end.owner.name, end.name] = (seat.owner.name, seat.name)
        self.seated.add((seat.owner.name, seat.name))

    def _open(self, seat: Seat) -> Seat:
        """The seat, or another open one where all are alike. Raises InputError where none is open."""
        node = seat.owner
        if not (isinstance(node, Node) and node.interchangeable):
            return seat
        found = next((s for s in node.seats if (node.name, s.name) not in self.seated), None)
        if found is None:
            raise InputError(f"All {len(node.seats)} ends of {node.described} are taken", "Give it more with ends=")
        return found

    def _connect_signal(self, one: Port, other: Port) -> None:
        source, target = (one, other) if isinstance(one, SignalOutput) else (other, one)
        if not isinstance(source, SignalOutput) or not isinstance(target, SignalInput):
            raise InputError(f"{one} and {other} cannot be joined", "Join an output to an input")
        for port in (source, target):
            self._require_part(port.owner)
        unit, wanted = (port.owner.unit_of(port.name) for port in (source, target))
        if unit and wanted and not units.same(unit, wanted):
            raise InputError(f"{source} is in {unit}, {target} in {wanted}", "Connect variables of one unit")
        if (target.owner.name, target.name) in self.links:
            raise InputError(f"Port {target} is joined twice", "One output drives an input")
        self.links[target.owner.name, target.name] = (source.owner.name, source.name)

    def _connect_supply(self, one: Port, other: Port) -> None:
        supply, outlet = (one, other) if isinstance(one, Supply) else (other, one)
        if not isinstance(supply, Supply) or not isinstance(outlet, Outlet):
            raise InputError(f"{one} and {other} cannot be joined", "Join the supply of a drive to a unit's outlet")
        for port in (supply, outlet):
            self._require_part(port.owner)
        if not supply.owner.shares:
            raise InputError(f"{supply.owner.name!r} has no hydraulic drive", "Only hydraulic drives take a power unit")
        outputs = [v.name for v in outlet.owner.variables(Site(1.0, 1.0)) if v.kind is Kind.OUTPUT]
        missing = [name for name in supply.owner.shares if not outlet.owner.sums or name not in outputs]
        if missing:
            raise InputError(f"{outlet.owner.name!r} gives no {', '.join(missing)}", "Connect it to a power unit")
        if supply.owner.name in self.supplies:
            raise InputError(f"Port {supply} is joined twice", "A drive has one power unit")
        self.supplies[supply.owner.name] = outlet.owner.name

    def string(
        self,
        rope: Rope,
        *over: Node | Seat,
        length: float | None = None,
        tension: float | None = None,
        name: str | None = None,
    ) -> tuple[Span, ...]:
        """Run one rope over supports, from the first to the last; returns its spans, named `from_to`, or
        `name_from_to` where two ropes run between the same two. A seat stands for its node where that has
        several to choose from.

        length: total unstretched length of the rope [m]; or tension: of the empty rope at rest at the first
        support [N] (taut). The empty rope at rest has equal tension on both sides of each support; this sets
        how its length is shared out, also where a drive then holds it. Raises InputError, SlackRopeError.
        """
        if len(over) < 2:
            raise InputError(f"A rope needs two supports, not {len(over)}", "Name its ends and what it runs over")
        arriving = [seat if isinstance(seat, Seat) else seat.arriving for seat in over]
        nodes = [_node_of(seat) for seat in arriving]
        if (length is None) == (tension is None):
            raise InputError("string needs either length or tension", "Give one of them")
        for node, seat in zip(nodes[1:-1], arriving[1:-1], strict=True):
            if node.through(seat) is None:
                raise InputError(
                    f"{node.described} is an end support, not an intermediate one",
                    "A rope can end there, not run over it",
                )
        for before, after in pairwise(nodes):
            if before.at == after.at:
                raise InputError(f"{before.described} and {after.described} stand at one place", "Move one of them")
        points = [node.at for node in nodes]
        prefix = "" if name is None else f"{name}_"
        names = [f"{prefix}{a.name}_{b.name}" for a, b in pairwise(nodes)]
        weight = rope.mass_per_length * self.gravity
        if length is not None:
            check.positive(length, f"Rope {names[0]} ...", "length", "m")
            lengths = lengths_for_total(points, weight, rope.strain, length, names)
        else:
            check.positive(tension or 0.0, f"Rope {names[0]} ...", "tension", "N")
            lengths = lengths_for_tension(points, weight, rope.strain, tension or 0.0, names)
        spans = tuple(Span(name, rope=rope, length=float(d)) for name, d in zip(names, lengths, strict=True))
        self._check_strength(spans, nodes)
        trial = self.copy()  # nothing half-built when one of the parts is refused
        for component in (*nodes, *spans):
            trial.add(component)
        leaving = [nodes[0].leaving if isinstance(over[0], Node) else over[0]]
        leaving += [node.through(seat) or seat for node, seat in zip(nodes[1:-1], arriving[1:-1], strict=True)]
        for span, a, b in zip(spans, leaving, arriving[1:], strict=True):
            trial.connect(span.a, a)
            trial.connect(span.b, b)
        self.components, self.connections, self.origins = trial.components, trial.connections, trial.origins
        self.seated = trial.seated
        return spans

    def hang(self, load: Load, spans: Span | Sequence[Span], at: float) -> Load:
        """Clamp a load to a rope; at: unstretched distance [m] from end a of a span, or along several
        consecutive spans from the first one's end a (equilibrium finds the span). Raises InputError."""
        on = (spans,) if isinstance(spans, Span) else tuple(spans)
        self._check_spans(on, f"Load {load.name!r}")
        for one, other in pairwise(on):
            here, there = self.connections.get((one.name, "b")), self.connections.get((other.name, "a"))
            if here is None or there is None or here[0] != there[0]:
                cause = f"Load {load.name!r}: {one.name!r} and {other.name!r} do not follow each other"
                raise InputError(cause, "Join them first, and name them in order")
        if any(f.spans[0] in on or on[0] in f.spans for f in self.feeds):
            raise InputError(
                f"Load {load.name!r} hangs on a rope that is fed", "Use feed or hang on one rope, not both"
            )
        check.number(at, f"Load {load.name!r}", "at", "m")
        length = math.fsum(s.length for s in on)
        if not 0.0 <= at <= length:
            raise InputError(
                f"Load {load.name!r} hangs at {at} m, outside {on[0].name}"
                + (f" ... {on[-1].name}" if len(on) > 1 else "")
                + f", whose unstretched length is {length:.6g} m",
                f"Choose at between 0 and {length:.6g} m",
            )
        if load.name in self._load_names() or load.name in self.components:
            raise InputError(f"The name {load.name!r} is taken", "Give each load a name of its own")
        self.hung.append(Hung(load, on, float(at)))
        return load

    def feed(self, spans: Sequence[Span], *, spacing: float, masses: float | Sequence[float]) -> None:
        """Fill a rope with loads every `spacing` metres of rope, from its first support on, and go on feeding
        them there when it moves; masses [kg]: a number, or a sequence used in order and repeated.

        Raises InputError.
        """
        on = tuple(spans)
        self._check_spans(on, "feed")
        check.positive(spacing, "feed", "spacing", "m")
        check.count(math.fsum(span.length for span in on) / spacing, "feed", "loads", MOST_LOADS)
        values = tuple(masses) if isinstance(masses, Sequence) else (masses,)
        if not values:
            raise InputError("feed has no masses", "Give one number or a sequence of numbers")
        for value in values:
            check.not_negative(value, "feed", "mass", "kg")
        if not any(values):
            raise InputError("feed has no load with a mass", "A mass of 0 is a missing load; give some that are not")
        if any(h.spans[0] in on for h in self.hung) or any(f.spans[0] in on for f in self.feeds):
            raise InputError("This rope carries loads already", "Use feed or hang on one rope, not both")
        self.feeds.append(Feed(on, float(spacing), tuple(float(v) for v in values)))

    def origin(self, name: str, text: str = "{}") -> str:
        """File and line of the user's code that added a component, in a text; empty where there is no such code."""
        origin = self.origins.get(name)
        return text.format(origin) if origin else ""

    def copy(self) -> System:
        """The same declarations, so that later ones do not change a model made before."""
        other = System(self.name, gravity=self.gravity)
        other.precedences = dict(self.precedences)
        other.components, other.connections = dict(self.components), dict(self.connections)
        other.supplies, other.links = dict(self.supplies), dict(self.links)
        other.hung, other.feeds, other.origins = list(self.hung), list(self.feeds), dict(self.origins)
        other.seated = set(self.seated)
        return other

    def _require_part(self, component: Component) -> None:
        """Raises InputError for a component that has not been added."""
        if self.components.get(component.name) is not component:
            raise InputError(f"{component.name!r} is not part of system {self.name!r}", "Add it first")

    def _load_names(self) -> set[str]:
        return {h.load.name for h in self.hung}

    def _check_spans(self, spans: tuple[Span, ...], owner: str) -> None:
        if not spans:
            raise InputError(f"{owner} has no span", "Name the spans that it hangs on")
        for span in spans:
            if self.components.get(span.name) is not span:
                raise InputError(f"Span {span.name!r} is not part of system {self.name!r}", "Add it first")

    def _check_strength(self, spans: Sequence[Span], nodes: Sequence[Node]) -> None:
        for span, a, b in zip(spans, nodes[:-1], nodes[1:], strict=True):
            height = abs(a.at[2] - b.at[2])
            if max(height, span.length / 2.0) > hanging_limit(span.rope, self.gravity):
                need = max(height, span.length / 2.0) * span.rope.mass_per_length * self.gravity
                raise InputError(
                    f"Span {span.name!r}: the rope's own weight gives at least {need:.6g} N, above its minimum "
                    f"breaking load {span.rope.breaking_load:.6g} N",
                    "Choose a stronger rope or a shorter span",
                )

    def require_complete(self) -> None:
        """Raises UnbalancedSystemError that names each port left open, by the user's file and line."""
        if not self.components:
            raise UnbalancedSystemError(f"System {self.name!r} is empty", "Add components, or string a rope")
        joined = {*self.connections, *self.connections.values()}
        lone = [
            f"{port}{self.origin(c.name, ' (added at {})')}"
            for c in self.components.values()
            for port in c.ports
            if (c.name, port.name) not in joined and not (isinstance(port, Seat) and port.optional)
        ]
        if lone:
            raise UnbalancedSystemError(f"Ports left open: {', '.join(lone)}", "Connect each port once")


def _node_of(seat: Seat) -> Node:
    """The node of a seat. Raises InputError where it has no place yet."""
    node = seat.owner
    if not isinstance(node, Node) or not node.at:
        raise InputError(f"{node.name!r} has no place", "Give at=, or stand it on a terrain")
    return node


def caller() -> str:
    """File and line of the first frame outside this package; none on the command line, where no user's code is."""
    frame = inspect.currentframe()
    while frame is not None:
        if str(frame.f_globals.get("__name__", "")).split(".")[0] in _COMMAND_LINE:
            return ""
        path = frame.f_code.co_filename
        inside = path.startswith(_PACKAGE) and not path.startswith(
            tuple(f"{_PACKAGE}/{d}/" for d in ("tests", "examples", "benchmarks"))
        )
        if not inside:
            return f"{path}:{frame.f_lineno}"
        frame = frame.f_back
    return ""
