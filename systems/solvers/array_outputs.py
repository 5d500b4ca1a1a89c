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
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.model_tables import shared_places
from ropeway.systems.modelling.rope_path import drive_speeds
from ropeway.systems.solvers.array_function import ArrayFunction
from ropeway.systems.solvers.newton import outputs_of
from ropeway.systems.solvers.points import VECTORS, Vectors
from ropeway.systems.solvers.state_rows import StateRows

_BATCH = 12_000
"""Entries of one array, about: they stay in the processor's cache."""
_FEW = 8
"""Points that are not worth an evaluation of their own kind."""
FORCE = 4
"""Entries of a force at a port: three components and the energy carried; in weather the expansion of the rope too."""


@dataclass(frozen=True)
class Form:
    """Components of one form: `first` stands for all, with these variables."""

    key: Hashable
    first: Component = field(compare=False)
    variables: tuple[Variable, ...] = field(compare=False)
    weather: bool = False


@dataclass(frozen=True, eq=False)
class Group:
    """Components of one form. `own`: places of their variables among all (variables, components); `outputs` (outputs,
    components); `ports`: for each port either places of position, travel and what lies aside (7, components), or the
    numbers of a rope end (components,) and the place of the rope's speed (components,)."""

    form: Form
    ropes: bool
    own: np.ndarray
    outputs: np.ndarray
    ports: tuple[tuple[np.ndarray, ...], ...]


class OutputGroups:
    """How the outputs of a model are evaluated: groups of components in their order; `shared`: places of what all
    components read. Rope ends are numbered; the number `ends` is that of none. The place `none` behind all variables
    is zero."""

    def __init__(self, model: Model) -> None:
        places = _Places(model)
        by_form: dict[Form, list[Component]] = defaultdict(list)
        for c in model.system.components.values():
            site = Site(1.0, 1.0, places.slots.get(c.name, 0), weather=model.weather)
            by_form[Form(c.form(site), c, c.variables(site), model.weather)].append(c)
        groups = [places.group(form, components) for form, components in by_form.items()]
        self.groups = sorted(groups, key=lambda group: not group.ropes)  # ropes pull at the seats
        self.ends, self.force, self.none = places.ends, FORCE + model.weather, places.none
        self.shared = [places.first[kind] + i for kind, i in shared_places(model.tables)]


class ArrayOutputs:
    """The outputs of a model at many points, or some of them: those at `which` places."""

    def __init__(self, model: Model, which: np.ndarray) -> None:
        self._plan, self._weather = output_groups(model), model.weather
        self._size = len(which) + 1  # the last one takes what is not among them
        self._most = max(len(model.system.components), 1)
        place = np.full(len(model.y), -1)
        place[which] = np.arange(len(which))
        self._calls = []
        for group in self._plan.groups:
            rows = place[group.outputs]
            chosen = tuple(np.flatnonzero((rows >= 0).any(axis=1)).tolist())
            self._calls.append((group, _function(group.form, chosen), rows[list(chosen)]))

    def __call__(self, points: np.ndarray, time: np.ndarray) -> np.ndarray:
        """Outputs (outputs, points) of points as columns, all vectors and a zero behind them (all + 1, points)."""
        count = points.shape[1]
        y, size = np.empty((self._size, count)), max(1, _BATCH // self._most)
        with np.errstate(all="ignore"):
            for i in range(0, count, size):
                columns = slice(i, i + size)
                self._evaluate(np.ascontiguousarray(points[:, columns]), time[columns], y[:, columns])
        return y[:-1]

    def _evaluate(self, every: np.ndarray, time: np.ndarray, y: np.ndarray) -> None:
        plan = self._plan
        pulls = np.zeros((plan.ends + 1, plan.force, len(time)))
        pulls[plan.ends, FORCE:] = 1.0
        gravity, *weather = (every[i] for i in plan.shared)
        shared = [gravity, *(Weather.of(weather) if self._weather else ())]
        for group, function, rows in self._calls:
            ports = []
            for port in group.ports:
                if group.ropes:
                    x, y_, z, travel, aside_x, aside_z, aside_rope = every[port[0]]
                    ports.append([x + aside_x, y_, z + aside_z, travel + aside_rope])
                else:
                    ports.append([*(pulls[port[0], i] for i in range(plan.force)), every[port[1]]])
            found = function([time], shared, every[group.own], *ports)
            for row, value in zip(rows, found, strict=False):
                y[row] = value
            if group.ropes:
                rest = found[len(rows) :]
                for k, port in enumerate(group.ports):
                    for i in range(plan.force):
                        pulls[port[1], i] = rest[plan.force * k + i]


class _Places:
    """Where components of a model find what they read. Rope ends are numbered; the number behind them is no rope."""

    def __init__(self, model: Model) -> None:
        self.model = model
        names = [name for kind in VECTORS for name in model.tables[kind].names]
        sizes = np.cumsum([0, *(len(model.tables[kind]) for kind in VECTORS)]).tolist()
        self.first = dict(zip(VECTORS, sizes, strict=False))
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

    def group(self, form: Form, components: Sequence[Component]) -> Group:
        """Components of a form."""
        ropes = any(isinstance(port, RopeEnd) for port in form.first.ports)
        own = np.vstack([self.first[kind] + self._own(form, components, kind) for kind in VECTORS])
        outputs = self._own(form, components, Kind.OUTPUT)
        ports = tuple(
            tuple(
                np.array(cells, dtype=int).T
                for cells in zip(*(self._port(c, k, ropes) for c in components), strict=True)
            )
            for k in range(len(form.first.ports))
        )
        return Group(form, ropes, own, outputs, ports)

    def _own(self, form: Form, components: Sequence[Component], kind: Kind) -> np.ndarray:
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


def output_function(form: Form, outputs: tuple[int, ...]) -> ca.Function:
    """Some outputs of a component, and the forces of its rope ends; a function of time, what all read, the component's
    variables and its ports."""
    f = component_function(form.first, form.variables, weather=form.weather)
    arguments = [ca.SX.sym(f"a{i}", f.size1_in(i)) for i in range(f.n_in())]
    signals, own = 7, slice(2, 2 + len(VECTORS))
    results = f.call([ca.SX.ones(a.numel()) if i == signals else a for i, a in enumerate(arguments)])
    chosen = ca.vertcat(ca.SX(0, 1), *(results[2][i] for i in outputs))
    result = ca.vertcat(*ca.cse([ca.densify(r) for r in (chosen, *results[3:])]))
    inputs = [*arguments[:2], ca.vertcat(*arguments[own]), *arguments[signals + 1 :]]
    return ca.Function("outputs", inputs, [result])


@lru_cache(maxsize=128)
def _function(form: Form, outputs: tuple[int, ...]) -> ArrayFunction:
    return ArrayFunction(output_function(form, outputs))


@kept_with_model
def output_groups(model: Model) -> OutputGroups:
    """How the outputs of a model are evaluated."""
    return OutputGroups(model)


@kept_with_model
def has_groups(model: Model) -> bool:
    """Whether the outputs of a model are evaluated in groups: no components read each other's outputs, or call compiled
    code."""
    system = model.system
    return not (
        model.external
        or model.inertia is not None
        or system.supplies
        or system.links
        or any(c.sums for c in system.components.values())
    )


@kept_with_model
def _array_outputs(model: Model, which: bytes) -> ArrayOutputs:
    return ArrayOutputs(model, np.frombuffer(which, dtype=int))


def outputs_of_rows(model: Model, rows: StateRows, which: np.ndarray, few: int = _FEW) -> np.ndarray:
    """The outputs at `which` places of states (states, outputs); those of fewer than `few` states one by one, which may
    change their last bits."""
    if has_groups(model) and len(rows) >= few:
        return _array_outputs(model, which.tobytes())(rows.values.T, rows.time).T
    alone = StateRows(model, np.ascontiguousarray(rows.values), rows.time)
    found = [outputs_of(model)(*point.arguments)[0][which] for point in alone]
    return np.array(found).reshape(len(rows), len(which))


def outputs_of_columns(model: Model, columns: Vectors, time: np.ndarray | float = 0.0) -> np.ndarray:
    """All outputs at points that are columns, (ny, points)."""
    values = np.vstack([*columns.vectors, np.zeros((1, columns.z.shape[1]))]).T
    times = np.broadcast_to(np.asarray(time, dtype=float), (len(values),))
    return outputs_of_rows(model, StateRows(model, values, times), np.arange(len(model.y))).T
