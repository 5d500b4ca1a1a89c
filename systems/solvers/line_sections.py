"""A line as chains of spans: what couples two spans is the rope that runs over the support between them.

Each span's forces follow from the travels at its two ends. Eliminated span by span, they leave one unknown a support,
the travel of an idler, and a tridiagonal system for each section between two driven supports. A model fits that has
no other unknowns: supports that stand, spans, idlers, drums that keep a tension.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ropeway.components.compliance import solved
from ropeway.components.component import Component, Seat
from ropeway.components.node import Node
from ropeway.components.span import Span
from ropeway.components.variable import Kind, Site
from ropeway.components.weather import SHARED, Weather
from ropeway.systems.modelling.component_functions import component_function, force_function
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.model_tables import shared_places
from ropeway.systems.modelling.rope_path import drive_speeds
from ropeway.systems.solvers.points import VECTORS

SPAN_RESULTS = 24
"""Results of a span's kernel: closure (3,); force at end b (3,); then, for the closure, the travel at end a and that at
end b, the move of the tension vector (3, 3) and of the force at end b (3, 3)."""
SUPPORT_RESULTS = 9
"""Results of a support's kernel: balance; its derivatives by travel, by the forces of the rope coming in (3,) and going
out (3,), and by the driven speed."""


@dataclass(frozen=True)
class SpanForm:
    """Spans of one form, `key`: `first` stands for all; `parameters`: number of its parameters.

    Kernels are functions of one vector (what all share, force (3,), parameters, then of the used slots mass, at, ride
    and in weather drag area, place and travel at end a (4,), at end b (4,)) -> `SPAN_RESULTS`. All share gravity, and
    in weather the values of `weather.SHARED`.
    """

    key: Hashable
    first: Span = field(compare=False)
    parameters: int
    weather: bool = False

    def kernel(self, slots: int) -> ca.Function:
        """The kernel for so many used slots."""
        return _span_kernel(self, slots)


@dataclass(frozen=True)
class SupportForm:
    """Supports of one form, `key`, whose travel is an unknown. `parameters`, `discrete`: how many variables they have.

    `kernel`: a function of one vector (what all share, parameters, discrete variables, travel, forces of the rope
    coming in (3,) and going out (3,), driven speed) -> `SUPPORT_RESULTS`.
    """

    key: Hashable
    parameters: int
    discrete: int
    kernel: ca.Function = field(compare=False)


@dataclass(frozen=True, eq=False)
class LineSections:
    """Places in the vectors of a model. Spans and supports are numbered through, run after run.

    Of spans (spans,): `form`, first place of `parameters`, of the tension vector `force`, of the residuals `closure`,
    of slots `mass`, `at`, `ride`, `drag` (-1 without weather), `empty`, its `length_start`, and the support `start`;
    the next one is where it ends. `shared`: places in (parameters, inputs) of what all kernels read.

    Of supports (supports,): `point` (supports, 3) in the parameters, `state` and `travel` of its rope in the states and
    algebraic variables, -1 where it is not there; of a free one its `balance` in the residuals, `support_form`, first
    places of its parameters and discrete variables, and `speed`: that of the nearest drive in (states, inputs), -1 for
    none.
    """

    model: Model
    forms: tuple[SpanForm, ...]
    support_forms: tuple[SupportForm, ...]
    form: np.ndarray
    parameters: np.ndarray
    force: np.ndarray
    closure: np.ndarray
    mass: np.ndarray
    at: np.ndarray
    ride: np.ndarray
    drag: np.ndarray
    empty: np.ndarray
    length_start: np.ndarray
    start: np.ndarray
    point: np.ndarray
    state: np.ndarray
    travel: np.ndarray
    balance: np.ndarray
    support_form: np.ndarray
    support_parameters: np.ndarray
    support_discrete: np.ndarray
    speed: np.ndarray
    shared: np.ndarray

    def used(self, passed: Sequence[np.ndarray]) -> np.ndarray:
        """Loads in each span, (spans,), from those passed at the supports of each run."""
        return np.concatenate([beyond[:-1] - beyond[1:] for beyond in passed]).astype(int)


_OF_SPANS = ("form", "parameters", "force", "closure", "mass", "at", "ride", "empty", "drag", "length_start", "start")
_OF_SUPPORTS = ("state", "travel", "balance", "support_form", "support_parameters", "support_discrete", "speed")
"""Fields of `LineSections`, in the order in which they are found."""


class UnfitError(Exception):
    """A model or a component does not fit the compiled core; the text says why."""


@kept_with_model
def line_sections(model: Model) -> LineSections | str:
    """The sections of a model; a text that says why where it does not fit."""
    try:
        return _Finder(model).sections()
    except UnfitError as reason:
        return str(reason)


class _Finder:
    """Looks through a model."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.first: dict[tuple[str, Kind], int] = {}
        for kind in VECTORS:
            for i, name in enumerate(model.tables[kind].names):
                self.first.setdefault((name.rpartition(".")[0], kind), i)
        self.forms: dict[Any, tuple[int, SpanForm]] = {}
        self.support_forms: dict[Any, tuple[int, SupportForm]] = {}
        self.speeds = drive_speeds(model.runs)

    def sections(self) -> LineSections:
        """The places. Raises UnfitError."""
        m = self.model
        if m.external:
            raise UnfitError("it has a component in compiled code")
        if m.inertia is not None:
            raise UnfitError("its ropes have inertia")
        spans: list[tuple[int, ...]] = []
        supports: list[tuple[int, ...]] = []
        points: list[list[int]] = []
        for run in m.runs:
            for k, node in enumerate(run.nodes):
                axes = [m.p.index.get(f"{node.name}.{axis}", -1) for axis in "xyz"]
                if min(axes) < 0 or any(seat.offset is not None for seat in node.seats):
                    raise UnfitError(f"ropes hold {node.name!r}, or leave it beside its place")
                points.append(axes)
                arrives = run.seats[k] if k else None
                leaves = run.seats[0] if k == 0 else node.through(run.seats[k]) if k < len(run.spans) else None
                supports.append(self._support(node, arrives, leaves))
                if k < len(run.spans):
                    spans.append((*self._span(run.spans[k]), len(supports) - 1))
        unknowns = 3 * len(spans) + sum(row[1] >= 0 for row in supports)
        if not spans or unknowns != len(m.z):
            raise UnfitError("it has unknowns besides tensions and the travel of idlers")
        by_span, by_support = np.array(spans, dtype=int).T, np.array(supports, dtype=int).T
        places = {name: row.copy() for name, row in zip(_OF_SPANS, by_span, strict=True)}
        places |= {name: row.copy() for name, row in zip(_OF_SUPPORTS, by_support, strict=True)}
        forms = tuple(form for _, form in self.forms.values())
        support_forms = tuple(form for _, form in self.support_forms.values())
        shared = [i if kind is Kind.PARAMETER else len(m.p) + i for kind, i in shared_places(m.tables)]
        places |= {"point": np.array(points, dtype=int), "shared": np.array(shared, dtype=int)}
        found = LineSections(m, forms, support_forms, **places)
        _require_chain(found)
        return found

    def _span(self, span: Span) -> tuple[int, ...]:
        m = self.model
        site = Site(1.0, 1.0, weather=m.weather)
        count = sum(v.kind is Kind.PARAMETER for v in span.variables(site))
        if span.form(site) not in self.forms:
            made = SpanForm(span.form(site), span, count, m.weather)
            made.kernel(0)  # raises where it does not fit
            self.forms[span.form(site)] = (len(self.forms), made)
        number = self.forms[span.form(site)][0]
        slots = [m.d.index.get(f"{span.name}.slot_{what}[1]", 0) for what in ("mass", "at", "ride", "empty")]
        slots.append(m.d.index.get(f"{span.name}.slot_drag[1]", -1))
        slots.append(m.p.index[f"{span.name}.length_start"])
        force, closure = m.z.index[f"{span.name}.force_x"], m.r.index[f"{span.name}.closure_x"]
        return (number, self.first[span.name, Kind.PARAMETER], force, closure, *slots)

    def _support(self, node: Node, arrives: Seat | None, leaves: Seat | None) -> tuple[int, ...]:
        """Places of its state, travel and balance, its form, its parameters, discrete variables and driven speed."""
        m, seat = self.model, arrives or leaves
        travel = None if seat is None or seat.travel is None else f"{node.name}.{seat.travel}"
        state = m.x.index.get(travel, -1) if travel else -1
        free = m.z.index.get(travel, -1) if travel else -1
        if free < 0:
            return (state, -1, -1, -1, 0, 0, -1)
        balance = node.balance_at(seat) if seat else None
        if balance is None:
            raise UnfitError(f"the rope over {node.name!r} has no balance of its own")
        ports = [port.name for port in node.ports]
        ends = tuple(-1 if s is None else ports.index(s.name) for s in (arrives, leaves))
        site = Site(1.0, 1.0, weather=m.weather)
        variables = node.variables(site)
        key = (node.form(site), tuple(v.kind for v in variables), ends)
        if key not in self.support_forms:
            self.support_forms[key] = (len(self.support_forms), _support_form(_Node(key, node, m.weather), ends))
        row = m.r.index[f"{node.name}.{balance}"]
        speed = self._speed(node, leaves or arrives)
        discrete = self.first.get((node.name, Kind.DISCRETE), 0)
        number = self.support_forms[key][0]
        return (-1, free, row, number, self.first[node.name, Kind.PARAMETER], discrete, speed)

    def _speed(self, node: Node, seat: Seat | None) -> int:
        m, driver = self.model, None if seat is None else self.speeds.get((node.name, seat.name))
        if driver is None:
            return -1
        name = ".".join(driver)
        if name in m.z.index:
            raise UnfitError(f"{name!r} is an unknown")
        return m.x.index[name] if name in m.x.index else len(m.x) + m.u.index[name]


def _require_chain(found: LineSections) -> None:
    """Raises UnfitError where a residual reads other unknowns than its spans and supports have."""
    m = found.model
    pattern = m.dae.jac_sparsity(1, 2)
    allowed = np.zeros(pattern.shape, dtype=bool)
    unknowns = [np.arange(force, force + 3) for force in found.force]
    for k, own in enumerate(unknowns):
        ends = found.travel[[found.start[k], found.start[k] + 1]]
        for row in range(found.closure[k], found.closure[k] + 3):
            allowed[row, own] = True
            allowed[row, ends[ends >= 0]] = True
        for support in (found.start[k], found.start[k] + 1):
            if found.balance[support] >= 0:
                allowed[found.balance[support], own] = True
                allowed[found.balance[support], ends[ends >= 0]] = True
    if not allowed[np.array(pattern.row(), dtype=int), np.array(pattern.get_col(), dtype=int)].all():
        raise UnfitError("an equation couples spans that are not beside each other")


def _symbols(count: int) -> tuple[ca.SX, list[ca.SX]]:
    vector = ca.SX.sym("v", count)
    return vector, ca.vertsplit(vector) if count else []


def shared_count(*, weather: bool) -> int:
    """Number of quantities that all components share."""
    return 1 + (len(SHARED) if weather else 0)


def _shared(v: list[ca.SX], *, weather: bool) -> tuple[ca.SX, list[ca.SX]]:
    """What all components share, as their functions take it, and the other entries."""
    count = shared_count(weather=weather)
    return ca.vertcat(v[0], *(Weather.of(v[1:count]) if weather else ())), v[count:]


def _called(component: Component, function: ca.Function, shared: Any, given: dict[Kind, Any], ports: list[Any]) -> Any:
    """Results of a component's function; of what is not given it has none."""
    empty = ca.SX(0, 1)
    vectors = [given.get(kind, empty) for kind in VECTORS]
    if any(function.size1_in(2 + i) != vector.numel() for i, vector in enumerate(vectors)) or function.size1_in(7):
        raise UnfitError(f"{component.name!r} has variables of its own besides its travel")
    return function.call([ca.SX(0.0), shared, *vectors, empty, *ports])


@lru_cache(maxsize=64)
def _span_kernel(form: SpanForm, slots: int) -> ca.Function:
    variables = form.first.variables(Site(1.0, 1.0, slots, weather=form.weather))
    function = component_function(form.first, variables, weather=form.weather)
    slotted = (4 if form.weather else 3) * slots
    vector, v = _symbols(shared_count(weather=form.weather) + 3 + form.parameters + slotted + 8)
    shared, rest = _shared(v, weather=form.weather)
    force, rest = ca.vertcat(*rest[:3]), rest[3:]
    own, rest = ca.vertcat(*rest[: form.parameters]), rest[form.parameters :]
    discrete, rest = ca.vertcat(ca.SX(0, 1), *rest[:slotted], ca.SX.zeros(slots)), rest[slotted:]
    ends = [ca.vertcat(*rest[:4]), ca.vertcat(*rest[4:])]
    given = {Kind.ALGEBRAIC: force, Kind.PARAMETER: own, Kind.DISCRETE: discrete}
    results = _called(form.first, function, shared, given, ends)
    closure, going, coming = results[1], results[3][:3], results[4][:3]
    unknowns = ca.vertcat(force, rest[3], rest[7])
    if not ca.is_equal(ca.simplify(going), force, 2):
        raise UnfitError(f"the force of {form.first.name!r} at its start is not its tension vector")
    if type(form.first) is Span:
        moves = force_function(form.first, variables, weather=form.weather)
        found = ca.horzsplit(_called(form.first, moves, shared, given, ends)[1])
    else:
        matrix = ca.vertsplit(ca.jacobian(closure, unknowns))
        sides = [-closure, *(ca.vertcat(*(-row[i] for row in matrix)) for i in (3, 4))]
        found = [ca.vertcat(*move) for move in solved(matrix, sides)]
    pull = ca.jacobian(coming, unknowns)
    coming_moves = [ca.mtimes(pull[:, :3], move) for move in found]
    coming_moves[1] += pull[:, 3]
    coming_moves[2] += pull[:, 4]
    result = ca.vertcat(*ca.cse([closure, coming, *found, *coming_moves]))
    return ca.Function(f"span_{slots}", [vector], [ca.densify(result)])


@dataclass(frozen=True)
class _Node:
    """A node that stands for all of a form."""

    key: Hashable
    node: Node = field(compare=False)
    weather: bool


@lru_cache(maxsize=64)
def _support_form(form: _Node, ends: tuple[int, ...]) -> SupportForm:
    node = form.node
    variables = node.variables(Site(1.0, 1.0, weather=form.weather))
    function = component_function(node, variables, weather=form.weather)
    sizes = {kind: sum(v.size for v in variables if v.kind is kind) for kind in (*VECTORS, Kind.RESIDUAL)}
    if sizes[Kind.ALGEBRAIC] != 1 or sizes[Kind.RESIDUAL] != 1 or sizes[Kind.STATE] or sizes[Kind.INPUT]:
        raise UnfitError(f"{node.name!r} has unknowns or states of its own besides its travel")
    parameters, discrete = sizes[Kind.PARAMETER], sizes[Kind.DISCRETE]
    vector, v = _symbols(shared_count(weather=form.weather) + parameters + discrete + 8)
    shared, rest = _shared(v, weather=form.weather)
    own, rest = ca.vertcat(ca.SX(0, 1), *rest[:parameters]), rest[parameters:]
    switches, rest = ca.vertcat(ca.SX(0, 1), *rest[:discrete]), rest[discrete:]
    travel, speed = rest[0], rest[7]
    carried, expansion = ca.SX.sym("carried", 2), ([1.0] if form.weather else [])
    ports = [ca.vertcat(0.0, 0.0, 0.0, 0.0, *expansion, speed) for _ in node.ports]
    for side, port in enumerate(ends):
        if port >= 0:
            ports[port] = ca.vertcat(*rest[1 + 3 * side : 4 + 3 * side], carried[side], *expansion, speed)
    given = {Kind.ALGEBRAIC: travel, Kind.PARAMETER: own, Kind.DISCRETE: switches}
    residual = _called(node, function, shared, given, ports)[1]
    if ca.jacobian(residual, carried).nnz():
        raise UnfitError(f"the balance of {node.name!r} reads the energy that its rope carries")
    result = ca.vertcat(*ca.cse([residual, ca.jacobian(residual, ca.vertcat(*rest)).T]))
    return SupportForm(form.key, parameters, discrete, ca.Function("support", [vector], [ca.densify(result)]))
