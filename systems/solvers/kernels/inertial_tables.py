"""The tables of a model with inertia for the compiled core (see `systems/native/inertial.h`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ropeway.components.component import Component, Seat
from ropeway.components.node import Node
from ropeway.components.variable import Kind
from ropeway.systems.modelling.component_functions import port_size, rope_size
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.model_tables import shared_places
from ropeway.systems.modelling.rope_path import drive_speeds
from ropeway.systems.native.inertial_library import BLOCKS, SIZES
from ropeway.systems.solvers.kernels.component_kernels import (
    Block,
    ComponentKernels,
    component_kernels,
    is_piece,
)
from ropeway.systems.solvers.line_sections import UnfitError

_RATES = tuple(f"{what}_{axis}" for what in ("velocity", "acceleration") for axis in "xyz")
_KINDS = (Kind.STATE, Kind.ALGEBRAIC, Kind.INPUT, Kind.PARAMETER)
"""The vectors that ports read, one after the other."""


@dataclass(frozen=True, eq=False)
class _Part:
    """A component: its kernels, the first places of its variables, and what its ports read."""

    component: Component
    kernels: ComponentKernels
    first: dict[Kind, int]


class _Finder:
    """Looks through a model for what the tables say of it."""

    def __init__(self, model: Model) -> None:
        self.model, self.system = model, model.system
        if model.external or self.system.links or self.system.supplies:
            raise UnfitError("its components share a power unit, drive each other, or have compiled code of their own")
        slots = {
            span.name: int(n)
            for run, layout in zip(model.runs, model.layouts, strict=True)
            for span, n in zip(run.spans, layout.slots.count, strict=True)
        }
        sizes = [len(model.tables[kind]) for kind in _KINDS]
        self.begins = dict(zip(_KINDS, np.cumsum([0, *sizes[:-1]]).tolist(), strict=True))
        self.zero = sum(sizes)
        parts = self._parts(slots)
        self.pieces = [part for part in parts if is_piece(part.component)]
        self.nodes = [p for p in parts if not is_piece(p.component) and p.kernels.sizes.nx + p.kernels.sizes.nz]
        self.parts = [*self.pieces, *self.nodes]
        self.seats = {
            (n.name, s.name): s for n in self.system.components.values() if isinstance(n, Node) for s in n.seats
        }
        self.by_name = {part.component.name: part for part in self.nodes}
        self.speeds = drive_speeds(model.runs)
        self.unknown, self.band = self._unknowns()

    def _parts(self, slots: dict[str, int]) -> list[_Part]:
        """All components in the order of the vectors."""
        model, found = self.model, list[_Part]()
        at = {kind: model.tables[kind].shared for kind in (*_KINDS, Kind.DISCRETE, Kind.RESIDUAL)}
        for component in self.system.components.values():
            kernels = component_kernels(component, slots.get(component.name, 0), weather=model.weather)
            found.append(_Part(component, kernels, dict(at)))
            s = kernels.sizes
            for kind, count in zip((*_KINDS, Kind.DISCRETE), (s.nx, s.nz, s.nu, s.np, s.nd), strict=True):
                at[kind] += count
            at[Kind.RESIDUAL] += s.nz
        if any(at[kind] != len(model.tables[kind]) for kind in at):
            raise UnfitError("it has variables of no component")
        return found

    def place(self, component: str, name: str | None) -> int:
        """Where a variable stands in (x, z, u, p, 0)."""
        for kind in _KINDS if name is not None else ():
            index = self.model.tables[kind].index.get(f"{component}.{name}")
            if index is not None:
                return self.begins[kind] + index
        return self.zero

    def seat(self, piece: Component, end: str) -> tuple[str, Seat]:
        """The node and the seat where a piece ends."""
        key = self.system.connections[piece.name, end]
        return key[0], self.seats[key]

    def sources(self, piece: Component) -> list[int]:
        """What the ports of a piece read."""
        found = list[int]()
        for port in piece.ports:
            node, seat = self.seat(piece, port.name)
            if seat.offset is not None:
                raise UnfitError(f"a rope leaves {node!r} beside its place")
            names = [*"xyz", seat.travel]
            if piece.inertial:
                names += [*(f"{seat.rates}{rate}" for rate in _RATES), seat.speed, seat.acceleration]
            found += [self.place(node, name) for name in names]
        return found

    def _unknowns(self) -> tuple[dict[str, int], int]:
        """The first unknown of each node, in an order that keeps what ropes join near to each other, and the number of
        diagonals of their matrix on each side."""
        number = {part.component.name: i for i, part in enumerate(self.nodes)}
        joined = [
            [
                number[name]
                for name in {self.seat(p.component, port.name)[0] for port in p.component.ports}
                if name in number
            ]
            for p in self.pieces
        ]
        pairs = np.array([(a, b) for ends in joined for a in ends for b in ends] or [(0, 0)])
        count = max(len(self.nodes), 1)
        graph = csr_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
        order = reverse_cuthill_mckee(graph, symmetric_mode=True)
        first, at, sizes = dict[str, int](), 0, [p.kernels.sizes.nx + p.kernels.sizes.nz for p in self.nodes]
        for i in order[: len(self.nodes)].tolist():
            first[self.nodes[i].component.name] = at
            at += sizes[i]
        begins = [first[part.component.name] for part in self.nodes]
        reach = [abs(begins[a] - begins[b]) + max(sizes[a], sizes[b]) for a, b in pairs.tolist()] if begins else [0]
        return first, max(reach)

    def unknown_of(self, place: int, node: str) -> int:
        """The unknown of a node that stands at a place, or -1."""
        part = self.by_name.get(node)
        if part is None:
            return -1
        s = part.kernels.sizes
        x, z = place - part.first[Kind.STATE], place - len(self.model.x) - part.first[Kind.ALGEBRAIC]
        if 0 <= x < s.nx:
            return self.unknown[node] + x
        return self.unknown[node] + s.nx + z if 0 <= z < s.nz else -1

    def active(self, piece: _Part) -> list[tuple[int, int]]:
        """Entries of the ports of a piece that are unknowns of nodes, and these unknowns."""
        blocks, sources = piece.kernels.blocks, self.sources(piece.component)
        needed = {*blocks[_PORTS].columns, *blocks[_FORCES_PORTS].columns}
        each = len(sources) // len(piece.component.ports)
        nodes = [self.seat(piece.component, port.name)[0] for port in piece.component.ports]
        found = [(k, self.unknown_of(sources[k], nodes[k // each])) for k in sorted(needed)]
        return [(k, unknown) for k, unknown in found if unknown >= 0]

    @cached_property
    def ends(self) -> dict[tuple[str, str], tuple[int, int]]:
        """The piece that ends at each seat, and which of its ends that is."""
        return {
            self.system.connections[p.component.name, port.name]: (i, e)
            for i, p in enumerate(self.pieces)
            for e, port in enumerate(p.component.ports)
        }

    def forces(self, node: _Part) -> list[tuple[int, int, int]]:
        """What the ports of a node read: each entry a place, a piece or -1, and the result of the piece."""
        found, weather, component = list[tuple[int, int, int]](), self.model.weather, node.component
        size = rope_size(weather=weather)
        for port in component.ports:
            piece, end = self.ends.get((component.name, port.name), (-1, 0))
            given, first = 0, 0
            if piece >= 0:
                s = self.pieces[piece].kernels.sizes
                given = s.given // len(self.pieces[piece].component.ports)
                first = s.nx + s.nz + end * given
            driver = self.speeds.get((component.name, port.name))
            speed = self.zero if driver is None else self.place(*driver)
            if len(found) + size in node.kernels.far and speed < self.begins[Kind.INPUT]:
                raise UnfitError(f"{component.name!r} reads the speed of another drive")
            for k in range(port_size(rope=False, weather=weather, inertial=component.inertial)):
                row = k - (k > size)  # the speed stands between force and inertia
                if k == size:
                    found.append((speed, -1, 0))
                elif row < given:
                    found.append((self.zero, piece, first + row))
                else:  # an open seat: without force, and its rope as it was strung
                    found.append((self.zero + int(row == 4 and weather), -1, 0))
        return found


class _Form:
    """A kind of component as the core has it: its kernels, and those of their results that are needed. Of a piece the
    columns of ports are numbered through those that are `active`; rows of forces are those that nodes have `used`."""

    def __init__(
        self, kernels: ComponentKernels, active: Sequence[int] = (), used: frozenset[int] = frozenset()
    ) -> None:
        self.kernels, places = kernels, {port: i for i, port in enumerate(active)}
        self.blocks, self.at, begin = list[Block](), list[list[int]](), 0
        piece = bool(kernels.order_r)
        for k, block in enumerate(kernels.blocks):
            entries = [(r, c, begin + i) for i, (r, c) in enumerate(zip(*block, strict=True))]
            begin += len(entries)
            if piece and k in (_FORCES, _FORCES_STATES, _FORCES_PORTS):
                entries = [e for e in entries if e[0] in used]
            if piece and k in (_PORTS, _FORCES_PORTS):
                entries = [(r, places[c], at) for r, c, at in entries if c in places]
            self.blocks.append(Block(tuple(e[0] for e in entries), tuple(e[1] for e in entries)))
            self.at.append([e[2] for e in entries])
        empty = BLOCKS - len(self.blocks)
        self.blocks += [Block((), ())] * empty
        self.at += [[]] * empty

    @property
    def begins(self) -> list[int]:
        """Where its blocks begin, and where the last one ends."""
        return [0, *np.cumsum([len(own) for own in self.at]).tolist()]


_PORTS, _FORCES, _FORCES_STATES, _FORCES_PORTS = 1, 3, 4, 5
"""Blocks, in the order of inertial.h."""


class Tables(NamedTuple):
    """Sizes, integers and scales, by their names in inertial.h; the kernels of its forms; the room that a point
    needs."""

    sizes: dict[str, int]
    integers: dict[str, np.ndarray]
    numbers: dict[str, np.ndarray]
    kernels: list[ComponentKernels]
    room: dict[str, int]


def tables_of(model: Model) -> Tables:
    """The tables of a model. Raises UnfitError."""
    found = _Finder(model)
    parts, pieces = found.parts, found.pieces
    shared = [found.begins[kind] + i for kind, i in shared_places(model.tables)]
    ports = [[(k, -1, 0) for k in found.sources(p.component)] for p in pieces] + [found.forces(p) for p in found.nodes]
    actives = [found.active(p) for p in pieces]
    forms, of = _forms(found, ports, actives)
    sizes = [p.kernels.sizes for p in parts]
    # Of a piece the inputs of its factors are kept too.
    inputs = [2 * (s.nx + s.nz + s.ports + s.nu + len(shared) + s.np + s.nd) + 1 for s in sizes]
    entries = [sum(len(b.rows) for b in p.kernels.blocks) for p in parts]
    kernel = np.cumsum([0, *np.column_stack([inputs, [s.nx + s.nz + s.given for s in sizes], entries]).ravel()])
    dense = [s.nz * (2 * s.nz + 2 * len(a) + 1) + s.given * len(a) for s, a in zip(sizes, actives, strict=False)]
    flat = [entry for own in ports for entry in own]
    unknowns = sum(s.nx + s.nz for s in sizes[len(pieces) :])
    integers: dict[str, Any] = {
        **_of_forms(forms),
        "form": of,
        **{
            letter: [p.first[kind] for p in parts]
            for letter, kind in zip("xzupdr", (*_KINDS, Kind.DISCRETE, Kind.RESIDUAL), strict=True)
        },
        "port_at": np.cumsum([0, *(len(own) for own in ports)]),
        "input": kernel[:-1:3],
        "result": kernel[1::3],
        "blocks": kernel[2::3],
        "dense": np.cumsum([0, *dense])[:-1],
        "unknown": [0] * len(pieces) + [found.unknown[p.component.name] for p in found.nodes],
        "port_source": [e[0] for e in flat],
        "port_piece": [e[1] for e in flat],
        "port_row": [e[2] for e in flat],
        "active_at": np.cumsum([0, *(len(a) for a in actives)]),
        "active_unknown": [k for own in actives for _, k in own],
        "shared": shared,
    }
    n = len(model.x) + len(model.z)
    room = {
        "y": found.zero + 2,
        "value": n,
        "kernel": int(kernel[-1]),
        "dense": sum(dense),
        "pivot": sum(s.nz * (2 * s.nz + 1) + 2 for s in sizes[: len(pieces)]) + unknowns,
        "band": unknowns * (4 * found.band + 1),
        "room": 2 * len(model.z) + unknowns + 11 * n,
    }
    counts = (*(len(t) for t in (model.x, model.z, model.u, model.p)), len(shared), len(pieces), len(parts), unknowns)
    return Tables(
        dict(zip(SIZES, (*counts, found.band), strict=True)),
        {name: np.ascontiguousarray(values, dtype=np.int32) for name, values in integers.items()},
        {"x_nominal": model.x.nominals, "z_nominal": model.z.nominals, "r_scale": 1.0 / model.r.nominals},
        [form.kernels for form in forms],
        room,
    )


def _forms(
    found: _Finder, ports: list[list[tuple[int, int, int]]], actives: list[list[tuple[int, int]]]
) -> tuple[list[_Form], list[int]]:
    """The forms of all components, and which one each of them has."""
    used: list[set[int]] = [set() for _ in found.pieces]
    for node, own in zip(found.nodes, ports[len(found.pieces) :], strict=True):
        for column in node.kernels.far:
            _, piece, result = own[column]
            if piece >= 0:
                s = found.pieces[piece].kernels.sizes
                used[piece].add(result - s.nx - s.nz)
    keys = [
        (id(p.kernels), tuple(k for k, _ in a), frozenset(u))
        for p, a, u in zip(found.pieces, actives, used, strict=True)
    ]
    keys += [(id(p.kernels), (), frozenset()) for p in found.nodes]
    forms: dict[Any, _Form] = {}
    for part, key in zip(found.parts, keys, strict=True):
        if key not in forms:
            forms[key] = _Form(part.kernels, key[1], key[2])
    number = {key: i for i, key in enumerate(forms)}
    return list(forms.values()), [number[key] for key in keys]


def _of_forms(forms: Sequence[_Form]) -> dict[str, Any]:
    """What the tables say of forms."""
    begins = np.cumsum([0, *(form.begins[-1] for form in forms)]).tolist()
    sizes = ("nx", "nz", "nu", "np", "nd", "ports", "given")
    return {
        **{f"form_{name}": [getattr(form.kernels.sizes, name) for form in forms] for name in sizes},
        "block": [at + own for form, at in zip(forms, begins, strict=False) for own in form.begins],
        "order_at": np.cumsum([0, *(len(form.kernels.order_r) for form in forms)]),
        "rows": [i for form in forms for block in form.blocks for i in block.rows],
        "columns": [i for form in forms for block in form.blocks for i in block.columns],
        "at": [i for form in forms for own in form.at for i in own],
        "order_r": [i for form in forms for i in form.kernels.order_r],
        "order_z": [i for form in forms for i in form.kernels.order_z],
    }
