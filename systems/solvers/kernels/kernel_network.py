"""Tables of a network of kernels (see native/network.h): how the calls of a model are joined, and where the entries of
the Jacobian come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.solvers.kernels.call_graph import CallGraph, call_graph
from ropeway.systems.solvers.kernels.kernel_parts import PARTS, Kernel, Part
from ropeway.systems.solvers.points import Slot

Terms = list[tuple[int, int]]


@dataclass(eq=False)
class Network:
    """Calls and sums over one array of values: the vectors t, x, z, u, p, d, what is freed, results and derivatives of
    calls, sums, and the number one. `kernels`, `results`, `inputs` of each call; in a network that is `swept`, of each
    of its derivatives the result and the place of the input, `entries`, and, where wanted, the kernel of its changes,
    `tangents`; `sums`: place and factors of each,
    those of rates last; places of the `unknowns` and of the residuals, `rows`; `matrix`: of each residual unknown and
    place of its entries; `drifts`: place of the rate of each residual, -1 for none, empty without rates."""

    size: int
    one: int = -1
    kernels: list[Kernel] = field(default_factory=list)
    results: list[int] = field(default_factory=list)
    inputs: list[list[int]] = field(default_factory=list)
    entries: list[list[tuple[int, int]]] = field(default_factory=list)
    tangents: list[Kernel] = field(default_factory=list)
    sums: list[tuple[int, Terms]] = field(default_factory=list)
    unknowns: list[int] = field(default_factory=list)
    rows: list[int] = field(default_factory=list)
    matrix: list[dict[int, int]] = field(default_factory=list)
    drifts: list[int] = field(default_factory=list)
    drift_sums: int = 0


@dataclass(frozen=True, eq=False)
class _Needed:
    """A call of which some results are needed: what it reads and makes, as symbols."""

    part: Part
    read: list[Any]
    made: list[Any]


def newton_network(model: Model, freed: tuple[Slot, ...], given: tuple[Slot, ...], *, rates: bool = False) -> Network:
    """The network of the residuals of a model for what is freed and given; with the rates of its unknowns or without.
    Raises Interrupted."""
    graph = call_graph(model, freed, outputs=any(kind is Kind.OUTPUT for kind, _ in given))
    rows = [*graph.alg, *(_chosen(graph, slot) for slot in given)]
    builder = _Builder(graph)
    unknowns = [*graph.vectors[2], *graph.vectors[6]]
    return builder.solved(rows, unknowns, rates=graph.ode if rates else None)


def block_network(model: Model, rows: Sequence[int], columns: Sequence[int]) -> Network:
    """The network of some residuals of a model for some of its algebraic variables, with the rates of these: rates of
    the states and of the inputs are given. Raises Interrupted."""
    graph = call_graph(model, (), outputs=False)
    return _Builder(graph).solved([graph.alg[i] for i in rows], [graph.vectors[2][i] for i in columns], rates=())


def network_of_outputs(model: Model) -> Network:
    """The network of the outputs of a model. Raises Interrupted."""
    graph = call_graph(model, (), outputs=True)
    return _values(graph, graph.y)


def network_of_residuals(model: Model) -> Network:
    """The network of the residuals of a model, without derivatives. Raises Interrupted."""
    graph = call_graph(model, (), outputs=False)
    return _values(graph, graph.alg)


def swept_network(
    graph: CallGraph, rows: Sequence[Any], moving: Sequence[int] = (), *, tangents: bool = False
) -> Network:
    """The network of some entries of results of a graph. Its kernels have their derivatives by what depends on the
    vectors that are `moving`, so that changes of these can be followed call by call; tangents: there are kernels for
    changes of all that is read. Raises Interrupted."""
    builder = _Builder(graph, swept=True, tangents=tangents)
    for symbol in (symbol for vector in moving for symbol in graph.vectors[vector]):
        builder.unknown(symbol, 0)
    builder.call(rows)
    builder.net.rows = [builder.place(row) for row in rows]
    return builder.net


def _values(graph: CallGraph, rows: Sequence[Any]) -> Network:
    builder = _Builder(graph)
    builder.call(rows)
    builder.net.rows = [builder.place(row) for row in rows]
    return builder.net


def _chosen(graph: CallGraph, slot: Slot) -> Any:
    kind, k = slot
    return graph.y[k] if kind is Kind.OUTPUT else graph.full[kind][k]


class _Builder:
    """Adds calls to a network. `_slots`: of each place the places of its derivatives by the unknowns; of a network that
    is swept, of each place that moves."""

    def __init__(self, graph: CallGraph, *, swept: bool = False, tangents: bool = False) -> None:
        self.graph, self.swept, self.tangents = graph, swept, tangents
        symbols = [symbol for vector in graph.vectors for symbol in vector]
        self._place = {symbol.element_hash(): i for i, symbol in enumerate(symbols)}
        self._slots: dict[int, dict[int, int]] = {}
        self.net = Network(len(symbols))
        self.net.one = self.room(1)

    def room(self, count: int) -> int:
        """The first of some new places."""
        self.net.size += count
        return self.net.size - count

    def unknown(self, symbol: Any, number: int) -> None:
        """Counts a symbol among the unknowns."""
        self._slots[self.place(symbol)] = {number: self.net.one}

    def place(self, entry: Any) -> int:
        """The place of a symbol, or of an expression that has been evaluated."""
        return self._place[entry.element_hash()]

    def slots(self, entry: Any) -> dict[int, int]:
        """Places of the derivatives of a symbol or an expression by the unknowns."""
        return self._slots.get(self.place(entry), {})

    def sum_of(self, terms: Terms) -> int:
        """The place of a sum of products."""
        place = self.room(1)
        self.net.sums.append((place, terms))
        return place

    def solved(self, rows: Sequence[Any], unknowns: Sequence[Any], *, rates: Sequence[Any] | None) -> Network:
        """The network of residuals with their derivatives. With `rates` of the states, or where these are given, also
        with what moves the residuals: rates that are given stand behind the number one, those of the states first."""
        net, (time, x, _, u, *_) = self.net, self.graph.vectors
        moving, speeds = list[Any](), list[int]()
        if rates is not None:
            given = self.room((0 if rates else len(x)) + len(u))
            moving = [time[0], *x, *u]
        for i, symbol in enumerate((*unknowns, *moving)):
            self.unknown(symbol, i)
        self.call([*rows, *(rates or ())])
        if rates is not None:
            speeds = [net.one, *map(self.place, rates), *range(given, given + len(x) * (not rates) + len(u))]
        net.unknowns, net.rows = [self.place(symbol) for symbol in unknowns], [self.place(row) for row in rows]
        net.matrix = [{i: s for i, s in self.slots(row).items() if i < len(rows)} for row in rows]
        before = len(net.sums)
        for row in rows if rates is not None else ():
            terms = [(s, speeds[i - len(rows)]) for i, s in self.slots(row).items() if i >= len(rows)]
            net.drifts.append(self.sum_of(terms) if terms else -1)
        net.drift_sums = len(net.sums) - before
        return net

    def call(self, wanted: Sequence[Any]) -> None:
        """Adds the calls on which some entries depend, then what is wanted besides their results."""
        expressions = [entry for entry in wanted if not entry.is_symbolic()]
        plain = [PARTS.find(None, [[entry]], [(0, 0)]) for entry in expressions]
        reads = {entry.element_hash() for entry in wanted if entry.is_symbolic()}
        reads |= {symbol.element_hash() for part, read in plain for symbol in (read[i] for i in part.used)}
        needed = list[_Needed]()
        for call in reversed(self.graph.calls):
            made = {(i, j): s for i, vector in enumerate(call.results) for j, s in enumerate(vector)}
            places = [place for place, symbol in made.items() if symbol.element_hash() in reads]
            if places:
                part, read = PARTS.find(call.function, call.inputs, places)
                needed.append(_Needed(part, read, [made[place] for place in places]))
                reads |= {read[i].element_hash() for i in part.used}
        for one in reversed(needed):
            self._add(one)
        for entry, (part, read) in zip(expressions, plain, strict=True):
            if entry.element_hash() not in self._place:
                self._add(_Needed(part, read, [entry]))

    def _add(self, one: _Needed) -> None:
        inputs = [self._place.get(symbol.element_hash(), -1) for symbol in one.read]
        active = tuple(i for i in one.part.used if inputs[i] in self._slots)
        kernel = one.part.kernel(active)
        first = self.room(len(one.made) + len(kernel.entries))
        self.net.kernels.append(kernel)
        self.net.results.append(first)
        self.net.inputs.append([inputs[i] for i in one.part.used])
        if self.tangents:
            self.net.tangents.append(one.part.tangent)
        if self.swept:
            self.net.entries.append([(first + row, inputs[i]) for row, i in kernel.entries])
            self._slots |= {first + row: {} for row, _ in kernel.entries}
        else:
            self._differentiate(first, len(one.made), kernel.entries, inputs)
        for k, symbol in enumerate(one.made):
            self._place[symbol.element_hash()] = first + k

    def _differentiate(self, first: int, count: int, entries: Sequence[tuple[int, int]], inputs: Sequence[int]) -> None:
        """Derivatives of the results of a call by the unknowns: those of its kernel times those of what it reads."""
        terms: list[dict[int, Terms]] = [{} for _ in range(count)]
        for k, (row, i) in enumerate(entries):
            for unknown, slot in self._slots[inputs[i]].items():
                terms[row].setdefault(unknown, []).append((first + count + k, slot))
        for row, found in enumerate(terms):
            if found:
                self._slots[first + row] = {
                    unknown: pairs[0][0] if len(pairs) == 1 and pairs[0][1] == self.net.one else self.sum_of(pairs)
                    for unknown, pairs in found.items()
                }
