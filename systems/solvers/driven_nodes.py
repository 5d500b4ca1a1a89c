"""The nodes of a line that have states or responses, as kernels of their own equations for the compiled core.

Each kernel is a function of one vector: time, what all kernels read, the node's states, inputs, parameters and discrete
variables, and the force of the rope at each of its ports (3,).
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import casadi as ca

from ropeway.components.node import Node
from ropeway.components.response import Response, response_of
from ropeway.components.variable import Kind, Site, Variable
from ropeway.components.weather import Weather
from ropeway.systems.modelling.component_functions import component_function, rope_size
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.sampled_control import rule_of
from ropeway.systems.solvers.line_sections import UnfitError, shared_count

OWN = (Kind.STATE, Kind.INPUT, Kind.PARAMETER, Kind.DISCRETE)
"""Kinds of a node's variables that its kernels read, in their order."""


@dataclass(frozen=True)
class NodeForm:
    """Nodes of one form, `key`: `node` stands for all. `sizes`: numbers of its variables of each kind in `OWN`."""

    key: Hashable
    node: Node = field(compare=False)
    weather: bool

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Its variables."""
        return self.node.variables(Site(1.0, 1.0, weather=self.weather))

    @property
    def sizes(self) -> tuple[int, ...]:
        """Numbers of its variables of each kind in `OWN`."""
        return tuple(sum(v.size for v in self.variables if v.kind is kind) for kind in OWN)


class NodePlaces:
    """Where the variables of a model's nodes stand, and the spans that pull at their ports."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.first: dict[tuple[str, Kind], int] = {}
        for kind in OWN:
            for i, name in enumerate(model.tables[kind].names):
                self.first.setdefault((name.rpartition(".")[0], kind), i)
        self.spans: dict[tuple[str, str], tuple[int, int]] = {}
        number = 0
        for run in model.runs:
            for span in run.spans:
                for end, port in enumerate(span.ports):
                    self.spans[model.system.connections[span.name, port.name]] = number, end
                number += 1

    def form(self, node: Node) -> NodeForm:
        """The form of a node."""
        site = Site(1.0, 1.0, weather=self.model.weather)
        return NodeForm((node.form(site), tuple(v.kind for v in node.variables(site))), node, self.model.weather)

    def responding(self, node: Node) -> NodeForm:
        """The form of a node with its response, whose rule has constants that are no variables. Raises UnfitError."""
        form, response = self.form(node), response_of(node)
        try:
            hash(response)
        except TypeError as error:
            raise UnfitError(f"the response of {node.name!r} cannot be told from others") from error
        return replace(form, key=(form.key, type(response), response))

    def places(self, node: Node) -> list[int]:
        """First places of its variables of each kind in `OWN`."""
        return [self.first.get((node.name, kind), 0) for kind in OWN]

    def ports(self, node: Node) -> list[tuple[int, int]]:
        """The span at each of its ports, -1 for none, and which end of it."""
        return [self.spans.get((node.name, port.name), (-1, 0)) for port in node.ports]


@kept_with_model
def node_places(model: Model) -> NodePlaces:
    """Those of a model, made once."""
    return NodePlaces(model)


@dataclass(frozen=True)
class _Called:
    """A node's function called on symbols: `vector` of all that a kernel reads, of it `time`, own variables by kind and
    `forces`, `other` what ropes give to a port besides forces; `rates` of its states, and `outputs` by name."""

    vector: ca.SX
    time: ca.SX
    own: dict[Kind, ca.SX]
    forces: ca.SX
    other: ca.SX
    rates: ca.SX
    outputs: dict[str, ca.SX]

    def require_forces(self, what: ca.SX, form: NodeForm) -> None:
        """Raises UnfitError unless ropes change something by their forces only."""
        if ca.jacobian(what, self.other).nnz():
            raise UnfitError(f"{form.node.name!r} feels more of a rope than its force")


def _called(form: NodeForm) -> _Called:
    variables, ports = form.variables, form.node.ports
    function = component_function(form.node, variables, weather=form.weather)
    shared = ca.SX.sym("shared", shared_count(weather=form.weather))
    time, own = ca.SX.sym("t"), {kind: ca.SX.sym(kind.value, n) for kind, n in zip(OWN, form.sizes, strict=True)}
    forces, rest = ca.SX.sym("forces", 3 * len(ports)), rope_size(weather=form.weather) - 2
    other = ca.SX.sym("other", rest * len(ports))
    if any(v.kind in (Kind.ALGEBRAIC, Kind.RESIDUAL) for v in variables) or form.node.sums:
        raise UnfitError(f"{form.node.name!r} has unknowns, or sums signals")
    alone = ca.SX.ones(function.size1_in(7))  # shares of a source
    given = {**own, Kind.ALGEBRAIC: ca.SX(0, 1)}
    vectors = [given[kind] for kind in (Kind.STATE, Kind.ALGEBRAIC, Kind.INPUT, Kind.PARAMETER, Kind.DISCRETE)]
    seen = [ca.vertcat(forces[3 * i : 3 * i + 3], other[rest * i : rest * (i + 1)]) for i in range(len(ports))]
    values = ca.vertsplit(shared)
    known = ca.vertcat(values[0], *(Weather.of(values[1:]) if form.weather else ()))
    results = function.call([time, known, *vectors, alone, *seen])
    names = [v.name for v in variables if v.kind is Kind.OUTPUT for _ in range(v.size)]
    vector = ca.vertcat(time, shared, *own.values(), forces)
    outputs = dict(zip(names, ca.vertsplit(results[2]), strict=True))
    return _Called(vector, time, own, forces, other, results[0], outputs)


def _kernel(name: str, called: _Called, results: Sequence[ca.SX]) -> ca.Function:
    return ca.Function(name, [called.vector], [ca.densify(ca.vertcat(*ca.cse([ca.vec(r) for r in results])))])


@lru_cache(maxsize=64)
def drive_kernel(form: NodeForm) -> tuple[ca.Function, bool]:
    """Rates of a node's states, their derivatives by the states (by rows), inputs, time and forces; and whether forces
    can change them. Raises UnfitError."""
    called = _called(form)
    called.require_forces(called.rates, form)
    by_force = ca.jacobian(called.rates, called.forces)
    by = [ca.jacobian(called.rates, s).T for s in (called.own[Kind.STATE], called.own[Kind.INPUT], called.time)]
    return _kernel("drive", called, [called.rates, *map(ca.densify, (*by, by_force.T))]), by_force.nnz() > 0


@dataclass(frozen=True)
class Rule:
    """The decisions of a response: `kernel` gives whether it wants to act, its need, then the values of some discrete
    variables, `names` with their sizes, if granted and if refused."""

    kernel: ca.Function
    names: tuple[tuple[str, int], ...]


@lru_cache(maxsize=64)
def response_kernel(form: NodeForm) -> Rule:
    """The rule of a node's response. Raises UnfitError."""
    response, called = response_of(form.node), _called(form)
    if not isinstance(response, Response):
        raise UnfitError(f"{form.node.name!r} has no response")
    function, variables = rule_of(response)
    known = {"time": called.time, **called.outputs}
    for kind in (Kind.PARAMETER, Kind.DISCRETE):
        first = 0
        for v in form.variables:
            if v.kind is kind:
                known[v.name] = called.own[kind][first : first + v.size]
                first += v.size
    results = function.call([known[name] for name, _ in variables.inputs])
    called.require_forces(ca.vertcat(*map(ca.densify, results)), form)
    return Rule(_kernel("response", called, results), variables.outputs)
