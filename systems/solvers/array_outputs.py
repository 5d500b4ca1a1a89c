"""Outputs of a model at many points at once, in NumPy: each kind of component is evaluated for all its components and
points together."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import casadi as ca
import numpy as np

from ropeway.components.component import Component, RopeEnd, Seat
from ropeway.components.node import Node
from ropeway.components.variable import Kind, Site, Variable
from ropeway.components.weather import Weather
from ropeway.systems.modelling.component_functions import component_function
from ropeway.systems.modelling.dae_model import Model, kept_with_model, shared_places
from ropeway.systems.modelling.rope_path import drive_speeds
from ropeway.systems.solvers.array_function import ArrayFunction
from ropeway.systems.solvers.newton import outputs_of
from ropeway.systems.solvers.points import VECTORS, Point, Vectors

_BATCH = 12_000
"""Entries of one array, about: they stay in the processor's cache."""
_FEW = 8
"""Points that are not worth an evaluation of their own kind."""
_FORCE = 4
"""Entries of a force at a port: three components and the energy carried; in weather the expansion of the rope too."""


@dataclass(frozen=True)
class _Form:
    """Components of one form: `first` stands for all, with these variables."""

    key: Hashable
    first: Component = field(compare=False)
    variables: tuple[Variable, ...] = field(compare=False)
    weather: bool = False


@dataclass(frozen=True, eq=False)
class _Group:
    """Components of one form. `own`: for each kind of vector the places of their variables (variables, components);
    `outputs` (outputs, components); `ports`: for each port either places of position, travel and what lies aside
    (7, components), or the numbers of a rope end (components,) and the place of the rope's speed (components,)."""

    function: ArrayFunction
    ropes: bool
    own: tuple[np.ndarray, ...]
    outputs: np.ndarray
    ports: tuple[tuple[np.ndarray, ...], ...]


class ArrayOutputs:
    """The outputs of a model for points as columns."""

    def __init__(self, model: Model) -> None:
        self._size = len(model.y)
        self._most = max(len(model.system.components), 1)
        places = _Places(model)
        by_form: dict[_Form, list[Component]] = defaultdict(list)
        for c in model.system.components.values():
            site = Site(1.0, 1.0, places.slots.get(c.name, 0), weather=model.weather)
            by_form[_Form(c.form(site), c, c.variables(site), model.weather)].append(c)
        groups = [places.group(form, components) for form, components in by_form.items()]
        self._groups = sorted(groups, key=lambda group: not group.ropes)  # ropes pull at the seats
        self._ends, self._force = places.ends, _FORCE + model.weather
        self._shared = [(list(VECTORS).index(kind), i) for kind, i in shared_places(model.tables)]

    def __call__(self, points: Vectors, time: np.ndarray | float = 0.0) -> np.ndarray:
        """Outputs (ny, points)."""
        count = points.z.shape[1]
        y, size = np.empty((self._size, count)), max(1, _BATCH // self._most)
        times = np.broadcast_to(np.asarray(time, dtype=float), (count,))
        with np.errstate(all="ignore"):
            for i in range(0, count, size):
                columns = slice(i, i + size)
                self._evaluate([v[:, columns] for v in points.vectors], times[columns], y[:, columns])
        return y

    def _evaluate(self, vectors: Sequence[np.ndarray], time: np.ndarray, y: np.ndarray) -> None:
        count = len(time)
        every = np.vstack([*vectors, np.zeros((1, count))])
        pulls = np.zeros((self._ends + 1, self._force, count))
        pulls[self._ends, _FORCE:] = 1.0
        gravity, *weather = (vectors[kind][i] for kind, i in self._shared)
        shared = [gravity, *(Weather.of(weather) if weather else ())]
        for group in self._groups:
            own = [[vector[row] for row in rows] for vector, rows in zip(vectors, group.own, strict=True)]
            ports = []
            for port in group.ports:
                if group.ropes:
                    x, y_, z, travel, aside_x, aside_z, aside_rope = (every[row] for row in port[0])
                    ports.append([x + aside_x, y_, z + aside_z, travel + aside_rope])
                else:
                    ports.append([*(pulls[port[0], i] for i in range(self._force)), every[port[1]]])
            found = group.function([time], shared, *own, *ports)
            for row, value in zip(group.outputs, found, strict=False):
                y[row] = value
            if group.ropes:
                rest = found[len(group.outputs) :]
                for k, port in enumerate(group.ports):
                    for i in range(self._force):
                        pulls[port[1], i] = rest[self._force * k + i]


class _Places:
    """Where components of a model find what they read. Rope ends are numbered; the number behind them is no rope."""

    def __init__(self, model: Model) -> None:
        self.model = model
        names = [name for kind in VECTORS for name in model.tables[kind].names]
        self.index = {name: i for i, name in enumerate(names)}
        self.none = len(names)
        self.slots = {
            span.name: int(n)
            for run, layout in zip(model.runs, model.layouts, strict=True)
            for span, n in zip(run.spans, layout.slots.count, strict=True)
        }
        connections = model.system.connections
        self.number = {end: i for i, end in enumerate(connections)}
        self.on = {seat: i for i, seat in enumerate(connections.values())}
        self.ends = len(connections)
        self.seats = {
            (n.name, s.name): s for n in model.system.components.values() if isinstance(n, Node) for s in n.seats
        }
        self.speeds = drive_speeds(model.runs)

    def group(self, form: _Form, components: Sequence[Component]) -> _Group:
        """Components of a form."""
        ropes = any(isinstance(port, RopeEnd) for port in form.first.ports)
        own = tuple(self._own(form, components, kind) for kind in VECTORS)
        outputs = self._own(form, components, Kind.OUTPUT)
        ports = tuple(
            tuple(
                np.array(cells, dtype=int).T
                for cells in zip(*(self._port(c, k, ropes) for c in components), strict=True)
            )
            for k in range(len(form.first.ports))
        )
        return _Group(_function(form), ropes, own, outputs, ports)

    def _own(self, form: _Form, components: Sequence[Component], kind: Kind) -> np.ndarray:
        """Places of the variables of a kind, (variables, components)."""
        table, rows = self.model.tables[kind].index, []
        for v in form.variables:
            if v.kind is not kind:
                continue
            indexed = isinstance(v.value, tuple) or v.size != 1 or v.hidden
            for i in range(v.size):
                end = f"{v.name}[{i + 1}]" if indexed else v.name
                rows.append([table[f"{c.name}.{end}"] for c in components])
        return np.array(rows, dtype=int).reshape(-1, len(components))

    def _port(self, c: Component, k: int, ropes: bool) -> tuple[list[int] | int, int]:
        """Of a rope end the places of `_position`, and its number; of a seat the rope end there and its speed."""
        name = c.ports[k].name
        if ropes:
            return self._position(self.seats[self.model.system.connections[c.name, name]]), self.number[c.name, name]
        driver = self.speeds.get((c.name, name))
        speed = self.none if driver is None else self.index[".".join(driver)]
        return self.on.get((c.name, name), self.ends), speed

    def _position(self, seat: Seat) -> list[int]:
        """Places of x, y, z, travel, and of what lies aside: x, z, rope."""
        node, aside = seat.owner.name, seat.offset
        travel = self.none if seat.travel is None else self.index[f"{node}.{seat.travel}"]
        more = [self.none] * 3 if aside is None else [self.index[f"{node}.{aside}_{n}"] for n in ("x", "z", "rope")]
        return [*(self.index[f"{node}.{axis}"] for axis in "xyz"), travel, *more]


@lru_cache(maxsize=128)
def _function(form: _Form) -> ArrayFunction:
    """Outputs, and forces of rope ends, of a component's function."""
    f = component_function(form.first, form.variables, weather=form.weather)
    arguments = [ca.SX.sym(f"a{i}", f.size1_in(i)) for i in range(f.n_in())]
    signals = 7
    results = f.call([ca.SX.ones(a.numel()) if i == signals else a for i, a in enumerate(arguments)])
    result = ca.vertcat(*ca.cse([ca.densify(r) for r in results[2:]]))
    inputs = [a for i, a in enumerate(arguments) if i != signals]
    return ArrayFunction(ca.Function("outputs", inputs, [result]))


@kept_with_model
def array_outputs(model: Model) -> ArrayOutputs | None:
    """The outputs of a model at many points; None where components read each other's outputs, or call compiled code."""
    system = model.system
    if (
        model.external
        or model.inertia is not None
        or system.supplies
        or system.links
        or any(c.sums for c in system.components.values())
    ):
        return None
    return ArrayOutputs(model)


def outputs_of_columns(model: Model, columns: Vectors, time: np.ndarray | float = 0.0) -> np.ndarray:
    """Outputs at points that are columns, (ny, points)."""
    together, count = array_outputs(model), columns.z.shape[1]
    if together is not None and count >= _FEW:
        return together(columns, time)
    times = np.broadcast_to(np.asarray(time, dtype=float), (count,))
    rows = [np.ascontiguousarray(vector.T) for vector in columns.vectors]
    found = [outputs_of(model)(times[i : i + 1].copy(), *(row[i] for row in rows))[0].copy() for i in range(count)]
    return np.array(found).reshape(count, len(model.y)).T


def outputs_at(model: Model, points: Sequence[Point]) -> np.ndarray:
    """Outputs at many points, (points, ny)."""
    columns = Vectors(*(np.array(rows).T for rows in zip(*(point.vectors for point in points), strict=True)))
    return outputs_of_columns(model, columns, np.array([point.t for point in points])).T
