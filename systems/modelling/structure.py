"""What models of equal structure share: their equations, and the functions that solvers derive from these alone.

The equations are functions of the positions of variables, not of names or values. A line with other supports, lengths
or loads, or the next trial of a search, has the same structure: nothing is built again.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import casadi as ca

from ropeway.components.node import Node
from ropeway.components.variable import Site, Variable
from ropeway.systems.modelling.component_functions import ComponentFunctions
from ropeway.systems.modelling.rope_path import Run, drive_speeds
from ropeway.systems.modelling.system import System

MOST = 20_000
"""Variables of all structures that a thread keeps: the least recently used are dropped."""


@dataclass(frozen=True, eq=False)
class Closures:
    """Equations whose derivatives have a closed form: (t, x, z, u, p, d) -> (ode, alg, quantities, derivatives), and
    their `rows` in alg. Each three rows depend on eleven of the quantities: the tension vector of a span, and position
    and travel at each of its ends; (3, 11) derivatives follow each other."""

    function: ca.Function
    rows: tuple[int, ...]

    @cached_property
    def expanded(self) -> ca.Function:
        """The function as one scalar graph."""
        return self.function.expand()

    def __reduce__(self) -> tuple[Any, ...]:
        return Closures, (self.function, self.rows)


@dataclass(frozen=True, eq=False)
class Nested:
    """Equations with inertia, in which `parts`, the results of each span, depend on few `quantities`: `outer`
    (t, x, z, u, p, d, parts) -> (ode, alg, quantities), and `inner` (t, x, z, u, p, d) -> (parts, and their derivatives
    by the quantities). Spans of one kind share these derivatives, which are therefore built fast."""

    outer: ca.Function
    inner: ca.Function


@dataclass(frozen=True, eq=False)
class Structure:
    """Equations of a model, (t, x, z, u, p, d) -> (ode, alg) and -> y, and what is `derived` from them alone;
    `closures`: those of them with derivatives in closed form; `nested`: how those with inertia depend on their spans;
    `compiled`: whether solvers use compiled code."""

    dae: ca.Function
    outputs: ca.Function
    closures: Closures | None = None
    nested: Nested | None = None
    compiled: bool = False
    derived: dict[Hashable, Any] = field(default_factory=dict)

    def __reduce__(self) -> tuple[Any, ...]:
        return Structure, (self.dae, self.outputs, self.closures, self.nested, self.compiled)

    def in_code(self, *, compiled: bool) -> Structure:
        """The same equations, for solvers that use compiled code or not."""
        if compiled == self.compiled:
            return self
        other = Structure(self.dae, self.outputs, self.closures, self.nested, compiled, {"other": self})
        found: Structure = self.derived.setdefault("other", other)
        return found


class KnownStructures(threading.local):
    """The structures and component functions that a thread has built. CasADi counts references to the parts of its
    graphs without a lock: each thread has its own."""

    def __init__(self) -> None:
        self.functions = ComponentFunctions()
        self._known: OrderedDict[Hashable, tuple[int, Structure]] = OrderedDict()

    def get(self, key: Hashable, size: int, build: Callable[[], Structure]) -> Structure:
        """The structure of a key with `size` variables, built where it is not known."""
        if key in self._known:
            self._known.move_to_end(key)
            return self._known[key][1]
        structure = build()
        if size <= MOST:
            self._known[key] = (size, structure)
            while sum(one for one, _ in self._known.values()) > MOST:
                self._known.popitem(last=False)
        return structure


KNOWN = KnownStructures()


def key_of(
    system: System,
    runs: Sequence[Run],
    sites: Mapping[str, Site],
    variables: Mapping[str, Sequence[Variable]],
    positions: Hashable,
) -> Hashable | None:
    """All that the equations of a system depend on, with the numbers of components instead of their names; None where
    external code is part of them.

    `variables` of "" are those that all components share. `positions`: those of variables in the vectors, as solvers
    read them.
    """
    if any(c.external for c in system.components.values()):
        return None
    number = {name: i for i, name in enumerate(system.components)}
    shared = tuple((v.name, v.kind, v.size) for v in variables[""])
    forms = tuple(
        (
            c.form(sites[name]),
            sites[name].weather,
            c.inertial,
            tuple((v.name, v.kind, v.size) for v in variables[name]),
            tuple((type(port), port.name) for port in c.ports),
            tuple((s.name, s.travel, s.offset, s.speed, s.acceleration, s.rates) for s in c.seats)
            if isinstance(c, Node)
            else (),
            (c.sums, c.shares),
        )
        for name, c in system.components.items()
    )
    joined = tuple((number[a], p, number[b], q) for (a, p), (b, q) in system.connections.items())
    fed = tuple((number[a], number[b]) for a, b in system.supplies.items())
    linked = tuple((number[a], p, number[b], q) for (a, p), (b, q) in system.links.items())
    driven = tuple((number[a], p, number[b], q) for (a, p), (b, q) in drive_speeds(runs).items())
    return (shared, forms, joined, fed, linked, driven, positions)
