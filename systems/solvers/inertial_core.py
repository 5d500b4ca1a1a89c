"""A model with inertia in the compiled core: its tables, points and runs (see `systems/native/inertial.h`)."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ropeway.components.component import Component, Seat
from ropeway.components.errors import CompiledError
from ropeway.components.node import Node
from ropeway.components.variable import Kind
from ropeway.systems.modelling.component_functions import port_size, rope_size
from ropeway.systems.modelling.dae_model import Model, kept_with_model, shared_places
from ropeway.systems.modelling.rope_path import drive_speeds
from ropeway.systems.native.inertial_library import (
    BLOCKS,
    INTEGERS,
    KERNELS,
    NUMBERS,
    SIZES,
    SystemPoint,
    SystemRun,
    SystemTables,
    inertial_library,
)
from ropeway.systems.solvers.component_kernels import ComponentKernels, UnfitError, component_kernels, is_piece
from ropeway.systems.solvers.newton import Point

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
            raise UnfitError("components drive each other, or have compiled code of their own")
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
        self.seats = {(n.name, s.name): s for n in self.system.components.values() if isinstance(n, Node) for s in n.seats}
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
            [number[name] for name in {self.seat(p.component, port.name)[0] for port in p.component.ports} if name in number]
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
        needed = {*blocks[1].columns, *blocks[5].columns}
        each = len(sources) // len(piece.component.ports)
        nodes = [self.seat(piece.component, port.name)[0] for port in piece.component.ports]
        found = [(k, self.unknown_of(sources[k], nodes[k // each])) for k in sorted(needed)]
        return [(k, unknown) for k, unknown in found if unknown >= 0]

    def forces(self, node: _Part) -> list[tuple[int, int, int]]:
        """What the ports of a node read: each entry a place, or a piece and its result."""
        ends = {
            self.system.connections[p.component.name, port.name]: (i, e)
            for i, p in enumerate(self.pieces)
            for e, port in enumerate(p.component.ports)
        }
        found, weather, component = list[tuple[int, int, int]](), self.model.weather, node.component
        for port in component.ports:
            size = rope_size(weather=weather)
            count = port_size(rope=False, weather=weather, inertial=component.inertial)
            piece, end = ends.get((component.name, port.name), (-1, 0))
            given, first = 0, 0
            if piece >= 0:
                s = self.pieces[piece].kernels.sizes
                given = s.given // len(self.pieces[piece].component.ports)
                first = s.nx + s.nz + end * given
            driver = self.speeds.get((component.name, port.name))
            speed = self.zero if driver is None else self.place(*driver)
            for k in range(count):
                row = k - (k > size)  # the speed stands between force and inertia
                if k == size:
                    if len(found) in node.kernels.far and speed < self.begins[Kind.INPUT]:
                        raise UnfitError(f"{component.name!r} reads the speed of another drive")
                    found.append((speed, -1, 0))
                elif row < given:
                    found.append((self.zero, piece, first + row))
                else:
                    found.append((self.zero + (row == 4 and size == 5), -1, 0))
        return found


def _tables(found: _Finder) -> tuple[dict[str, int], dict[str, np.ndarray], dict[str, int]]:
    """Sizes, integers, and the room that a point needs."""
    model, parts, pieces = found.model, found.parts, found.pieces
    forms = list({id(p.kernels): p.kernels for p in parts}.values())
    number = {id(k): i for i, k in enumerate(forms)}
    shared = [found.begins[kind] + i for kind, i in shared_places(model.tables)]
    ports = [[(k, -1, 0) for k in found.sources(p.component)] for p in pieces] + [found.forces(p) for p in found.nodes]
    actives = [found.active(p) for p in pieces]
    sizes = [p.kernels.sizes for p in parts]
    # Of a piece the inputs of its factors are kept too.
    inputs = [2 * (s.nx + s.nz + s.ports + s.nu + len(shared) + s.np + s.nd) + 1 for s in sizes]
    entries = [sum(len(b.rows) for b in p.kernels.blocks) for p in parts]
    kernel = np.cumsum([0, *np.column_stack([inputs, [s.nx + s.nz + s.given for s in sizes], entries]).ravel()])
    dense = np.cumsum([0, *(s.nz * (2 * s.nz + len(a)) + s.given * len(a) for s, a in zip(sizes, actives, strict=False))])
    blocks = [[*k.blocks, *[((), ())] * (BLOCKS - len(k.blocks))] for k in forms]
    begins, at = list[int](), 0
    for own in blocks:
        lengths = np.cumsum([0, *(len(b[0]) for b in own)]) + at
        begins, at = [*begins, *lengths.tolist()], int(lengths[-1])
    flat = [entry for own in ports for entry in own]
    unknowns = sum(s.nx + s.nz for s in sizes[len(pieces) :])
    integers: dict[str, Any] = {
        **{f"form_{n}": [getattr(k.sizes, n) for k in forms] for n in ("nx", "nz", "nu", "np", "nd", "ports", "given")},
        "block": begins,
        "order_at": np.cumsum([0, *(len(k.order_r) for k in forms)]),
        "rows": [i for own in blocks for b in own for i in b[0]],
        "columns": [i for own in blocks for b in own for i in b[1]],
        "order_r": [i for k in forms for i in k.order_r],
        "order_z": [i for k in forms for i in k.order_z],
        "form": [number[id(p.kernels)] for p in parts],
        **{
            letter: [p.first[kind] for p in parts]
            for letter, kind in zip("xzupdr", (*_KINDS, Kind.DISCRETE, Kind.RESIDUAL), strict=True)
        },
        "port_at": np.cumsum([0, *(len(own) for own in ports)]),
        "input": kernel[:-1:3],
        "result": kernel[1::3],
        "blocks": kernel[2::3],
        "dense": dense[:-1],
        "unknown": [0] * len(pieces) + [found.unknown[p.component.name] for p in found.nodes],
        "port_source": [e[0] for e in flat],
        "port_piece": [e[1] for e in flat],
        "port_row": [e[2] for e in flat],
        "active_at": np.cumsum([0, *(len(a) for a in actives)]),
        "active_port": [k for own in actives for k, _ in own],
        "active_unknown": [k for own in actives for _, k in own],
        "shared": shared,
    }
    n = len(model.x) + len(model.z)
    room = {
        "y": found.zero + 2,
        "value": n,
        "kernel": int(kernel[-1]),
        "dense": int(dense[-1]),
        "pivot": sum(s.nz * (s.nz + 3) for s in sizes[: len(pieces)]) + unknowns,
        "band": unknowns * (3 * found.band + 1),
        "room": 2 * len(model.z) + unknowns + 11 * n,
    }
    counts = (*(len(t) for t in (model.x, model.z, model.u, model.p)), len(shared), len(pieces), len(parts), unknowns)
    named = dict(zip(SIZES, (*counts, found.band), strict=True))
    return named, {k: np.ascontiguousarray(v, dtype=np.int32) for k, v in integers.items()}, room


class InertialCore:
    """The compiled equations of a model. `tables` stays as it is: each thread has a point of its own."""

    def __init__(self, model: Model) -> None:
        found = _Finder(model)
        self.model, self.core, self.tables = model, inertial_library(), SystemTables()
        sizes, integers, self.room = _tables(found)
        forms = list({id(p.kernels): p.kernels for p in found.parts}.values())
        addresses = ([k.value for k in forms], [k.matrix for k in forms])
        nominals = (model.x.nominals, model.z.nominals, 1.0 / model.r.nominals)
        self._kept: list[np.ndarray] = []
        for name, size in sizes.items():
            setattr(self.tables, name, size)
        for name in INTEGERS:
            self._keep(name, integers[name])
        for name, values in zip(NUMBERS, nominals, strict=True):
            self._keep(name, np.ascontiguousarray(values, dtype=float))
        for name, own in zip(KERNELS, addresses, strict=True):
            self._keep(name, np.array(own, dtype=np.uint64))

    def _keep(self, name: str, values: np.ndarray) -> None:
        self._kept.append(values)
        setattr(self.tables, name, values.ctypes.data)


@kept_with_model
def inertial_core(model: Model) -> InertialCore:
    """The compiled core of a model with inertia. Raises CompiledError where it does not fit, CompilerError, WriteError."""
    try:
        return InertialCore(model)
    except UnfitError as reason:
        cause = f"The compiled core cannot simulate {model.name!r}: {reason}"
        raise CompiledError(cause, "Leave out compiled=True") from reason


class CorePoint:
    """A point of a model in the core, and its rates `x_rate` (nx,) and `z_rate` (nz,) [per s], which the core finds."""

    def __init__(self, core: InertialCore) -> None:
        self.core, model = core, core.model
        self.x_rate, self.z_rate, self.u_rate = (np.zeros(len(table)) for table in (model.x, model.z, model.u))
        self.point = SystemPoint(step=-1.0)
        room = {name: np.zeros(max(n, 1), np.int32 if name == "pivot" else float) for name, n in core.room.items()}
        rates = {"x_rate": self.x_rate, "z_rate": self.z_rate, "u_rate": self.u_rate}
        self._room = list(room.values())
        for name, array in {**rates, **room}.items():
            setattr(self.point, name, array.ctypes.data)

    def put(self, point: Point, u_rate: np.ndarray) -> None:
        """Sets the point, which the core changes in place, and the rates of its inputs."""
        self._vectors = point.vectors
        for name, array in zip("xzupd", self._vectors, strict=True):
            setattr(self.point, name, array.ctypes.data)
        self.u_rate[:] = u_rate

    def solve(self) -> int:
        """Solves the algebraic variables in place, with all rates; returns 0, or why it failed."""
        return int(self.core.core.ri_solve(ctypes.byref(self.core.tables), ctypes.byref(self.point)))

    def move(self, run: SystemRun) -> int:
        """Moves the point in place; returns 0, or why it failed."""
        address = (ctypes.byref(part) for part in (self.core.tables, self.point, run))
        return int(self.core.core.ri_move(*address))
