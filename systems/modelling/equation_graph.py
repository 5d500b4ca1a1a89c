"""The graph of all component calls: rope pieces first, then the nodes with the forces on them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import casadi as ca
import numpy as np

from ropeway.components.component import Component, RopeEnd, Seat
from ropeway.components.errors import UnbalancedSystemError
from ropeway.components.node import Node
from ropeway.components.span import Span
from ropeway.components.variable import Kind, Site, Variable
from ropeway.components.weather import Weather
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.component_functions import INERTIA, SYMBOLS, ComponentFunctions, rope_size
from ropeway.systems.modelling.connections.signals import differences
from ropeway.systems.modelling.model_tables import VariableTable, shared_places
from ropeway.systems.modelling.rope_path import Run, drive_speeds
from ropeway.systems.modelling.structure import Closures, Nested, Structure
from ropeway.systems.modelling.system import System

_RATES, _RESIDUALS, _OUTPUTS, _FORCES = 0, 1, 2, 3
"""Positions in the results of a component's function. The forces of its rope ends follow from the last one on."""


class _Parts(NamedTuple):
    """Results of a span with inertia but its outputs, their symbols in the equations, the quantities on which they
    depend, and their derivatives by these."""

    results: ca.MX
    symbols: ca.MX
    quantities: ca.MX
    derivatives: ca.MX


class EquationGraph:
    """The components of a system joined at their ports, as functions of the vectors of the model."""

    def __init__(
        self,
        system: System,
        runs: Sequence[Run],
        sites: Mapping[str, Site],
        variables: Mapping[str, tuple[Variable, ...]],
        tables: Mapping[Kind, VariableTable],
        functions: ComponentFunctions,
    ) -> None:
        self.system, self.sites, self.variables, self.tables = system, sites, variables, tables
        self.component_functions = functions
        self.time = ca.MX.sym("t")
        self.vectors = {kind: ca.MX.sym(kind.value, len(tables[kind])) for kind in SYMBOLS}
        self.parts = {kind: _split(kind, self.vectors[kind], variables, tables[kind]) for kind in SYMBOLS}
        self.weather = system.environment is not None
        self.shared = self._shared()
        self.speed_of = drive_speeds(runs)
        self.seats = {(n.name, s.name): s for n in system.components.values() if isinstance(n, Node) for s in n.seats}
        self.results: dict[str, Sequence[ca.MX]] = {}
        self.force_on: dict[tuple[str, str], ca.MX] = {}
        self.external: dict[ca.MX, ca.MX] = {}
        self.parts_of: dict[str, _Parts] = {}

    def structure(self) -> Structure:
        """The equations. Raises InputError."""
        self._call_ropes()
        shares = self._call_sources()
        for c in self.system.components.values():
            if c.name not in self.results:
                own = shares.get(c.name, ca.MX(ca.DM.ones(len(c.shares), 1)))
                self.results[c.name] = self._call(c, own, self._forces(c))
        ode, y = (ca.vertcat(ca.MX(0, 1), *(self.results[n][i] for n in self.variables)) for i in (_RATES, _OUTPUTS))
        alg = self._residuals(y, {name: results[_RESIDUALS] for name, results in self.results.items()})
        arguments = [self.time, *(self.vectors[kind] for kind in SYMBOLS)]
        nested = self._nested(arguments, ode, alg)
        if self.parts_of:
            symbols, results = ([own[i] for own in self.parts_of.values()] for i in (1, 0))
            ode, alg, y = ca.substitute([ode, alg, y], symbols, results)
        if self.external:  # the remaining equations as one scalar graph
            scalar_graph = ca.Function("rest", [*arguments, *self.external], [ode, alg, y]).expand()
            ode, alg, y = scalar_graph(*arguments, *self.external.values())
        names = ["t", "x", "z", "u", "p", "d"]
        stop_if_interrupted()
        dae = ca.Function("dae", arguments, [ode, alg], names, ["ode", "alg"])
        stop_if_interrupted()
        return Structure(dae, ca.Function("outputs", arguments, [y], names, ["y"]), self._closures(ode, y), nested)

    def _nested(self, arguments: Sequence[ca.MX], ode: ca.MX, alg: ca.MX) -> Nested | None:
        """The equations on the symbols of the spans' results."""
        if self.external or not self.parts_of:
            return None
        results, symbols, quantities, derivatives = zip(*self.parts_of.values(), strict=True)
        seen = ca.vertcat(*symbols)
        known = ca.MX.sym("parts", seen.numel())
        ends = np.cumsum([0, *(own.numel() for own in symbols)]).tolist()
        found = ca.substitute([ode, alg], list(symbols), ca.vertsplit(known, ends))
        outer = ca.Function("outer", [*arguments, known], [*found, ca.vertcat(*quantities)])
        inner = ca.Function("inner", arguments, [ca.vertcat(*results), ca.diagcat(*derivatives)])
        return Nested(outer, inner)

    def _closures(self, ode: ca.MX, outputs: ca.MX) -> Closures | None:
        """The closures of spans in calm, with their derivatives."""
        spans = [c for c in self.system.components.values() if type(c) is Span]
        if self.weather or self.external or not spans:
            return None
        residuals = {name: results[_RESIDUALS] for name, results in self.results.items()}
        quantities, derivatives, one = list[ca.MX](), list[ca.MX](), ca.MX.eye(3)
        for span in spans:
            ends = self._ends(span)
            f = self.component_functions.closure(span, self.sites[span.name], self.variables[span.name])
            residuals[span.name], by = f.call(self._inputs(span, ca.MX(0, 1), ends))
            quantities += [self.parts[Kind.ALGEBRAIC][span.name], *ends]
            derivatives += [by[:, :3], one, by[:, 3], -one, by[:, 4]]
        alg = self._residuals(outputs, residuals)
        arguments = [self.time, *(self.vectors[kind] for kind in SYMBOLS)]
        results = [ode, alg, ca.vertcat(*quantities), ca.horzcat(*derivatives)]
        first = [self.tables[Kind.RESIDUAL].index[f"{span.name}.closure_x"] for span in spans]
        return Closures(ca.Function("closures", arguments, results), tuple(k + i for k in first for i in range(3)))

    def _call_ropes(self) -> None:
        """Calls components with rope ends, which give the forces on the seats."""
        for c in self.system.components.values():
            if not any(isinstance(port, RopeEnd) for port in c.ports):
                continue
            self.results[c.name] = self._call(c, ca.MX(0, 1), self._ends(c))
            if c.inertial and not c.external:
                self._take_apart(c)
            seats = [self.system.connections[c.name, port.name] for port in c.ports]
            self.force_on.update(zip(seats, self.results[c.name][_FORCES:], strict=True))

    def _take_apart(self, component: Component) -> None:
        """Puts symbols in place of the results of a rope with inertia, but its outputs."""
        name, ends = component.name, self._ends(component)
        rates, residuals, outputs, *forces = self.results[name]
        moves = self.component_functions.moves(component, self.sites[name], self.variables[name])
        own = [rates, residuals, *forces]
        symbols = ca.MX.sym(name, sum(part.numel() for part in own))
        split = ca.vertsplit(symbols, np.cumsum([0, *(part.numel() for part in own)]).tolist())
        quantities = ca.vertcat(*(self.parts[kind][name] for kind in (Kind.STATE, Kind.ALGEBRAIC)), *ends)
        derivatives = moves.call(self._inputs(component, ca.MX(0, 1), ends))[0]
        self.parts_of[name] = _Parts(ca.vertcat(*own), symbols, quantities, derivatives)
        self.results[name] = [split[0], split[1], outputs, *split[2:]]

    def _ends(self, component: Component) -> list[ca.MX]:
        """Position and travel of the rope at the seats of a component's rope ends."""
        seats = [self.system.connections[component.name, port.name] for port in component.ports]
        return [self._position(self.seats[seat], inertial=component.inertial) for seat in seats]

    def _call_sources(self) -> dict[str, ca.MX]:
        """Calls sources with the sums of all demands. Returns the shares of each component that a source feeds."""
        fed: dict[str, list[Component]] = defaultdict(list)
        for name, feeding in self.system.supplies.items():
            fed[feeding].append(self.system.components[name])
        shares: dict[str, ca.MX] = {}
        for source in (c for c in self.system.components.values() if c.sums):
            demands = ca.MX(len(source.sums), 1)
            for c in fed[source.name]:
                demand = self.component_functions.demand(c, source.sums, self.sites[c.name], self.variables[c.name])
                demands = demands + demand(*self._inputs(c, ca.MX(len(c.shares), 1), self._forces(c)))
            self.results[source.name] = self._call(source, demands, self._forces(source))
            names = [v.name for v in self.variables[source.name] if v.kind is Kind.OUTPUT]
            values = dict(zip(names, ca.vertsplit(self.results[source.name][_OUTPUTS]), strict=True))
            shares.update({c.name: ca.vertcat(*(values[name] for name in c.shares)) for c in fed[source.name]})
        return shares

    def _residuals(self, outputs: ca.MX, own: Mapping[str, ca.MX]) -> ca.MX:
        """Residuals of all components, which are their `own`, and of the inputs that others drive."""

        def quantity(component: str, name: str) -> ca.MX:
            index = self.tables[Kind.OUTPUT].index.get(f"{component}.{name}")
            return self._variable(component, name) if index is None else outputs[index]

        parts = [
            part
            for c, owned in self.variables.items()
            for part in (own[c], *differences(self.system, c, owned, quantity))
        ]
        return ca.vertcat(ca.MX(0, 1), *parts)

    def _call(self, component: Component, signals: ca.MX, ports: Sequence[ca.MX]) -> Sequence[ca.MX]:
        f = self.component_functions.get(component, self.sites[component.name], self.variables[component.name])
        # `call` returns a list also for a function with one output.
        out: Sequence[ca.MX] = f.call(self._inputs(component, signals, ports))
        if not component.external:
            return out
        stand_ins = [ca.MX.sym(f"{component.name}_{i}", result.shape) for i, result in enumerate(out)]
        self.external.update(zip(stand_ins, out, strict=True))
        return stand_ins

    def _inputs(self, component: Component, signals: ca.MX, ports: Sequence[ca.MX]) -> list[ca.MX]:
        own = (self.parts[kind][component.name] for kind in SYMBOLS)
        return [self.time, self.shared, *own, signals, *ports]

    def _shared(self) -> ca.MX:
        """Gravity, and the weather."""
        gravity, *weather = (self.vectors[kind][i] for kind, i in shared_places(self.tables))
        return ca.vertcat(gravity, *Weather.of(weather)) if weather else gravity

    def _position(self, seat: Seat, *, inertial: bool) -> ca.MX:
        """Position and travel of the rope at a seat; inertial: and their rates."""
        place = self._place(seat)
        return ca.vertcat(place, self._rates(seat)) if inertial else place

    def _rates(self, seat: Seat) -> ca.MX:
        """Velocity and acceleration of the rope's end at a seat, speed and acceleration of the rope's travel there;
        zero where the node has no such variable."""
        node = seat.owner.name
        names = [f"{seat.rates}{what}_{axis}" for what in ("velocity", "acceleration") for axis in "xyz"]
        return ca.vertcat(*(self._rate(node, name) for name in (*names, seat.speed, seat.acceleration)))

    def _rate(self, node: str, name: str | None) -> ca.MX:
        known = name is not None and any(f"{node}.{name}" in self.tables[kind].index for kind in SYMBOLS)
        return self._variable(node, name) if known and name is not None else ca.MX(0.0)

    def _place(self, seat: Seat) -> ca.MX:
        """Position and travel of the rope at a seat."""
        node = seat.owner.name
        travel = ca.MX(0.0) if seat.travel is None else self._variable(node, seat.travel)
        position = ca.vertcat(*(self._variable(node, axis) for axis in "xyz"), travel)
        if seat.offset is None:
            return position
        aside = [self._variable(node, f"{seat.offset}_{name}") for name in ("x", "z", "rope")]
        return position + ca.vertcat(aside[0], 0.0, aside[1], aside[2])

    def _forces(self, component: Component) -> list[ca.MX]:
        """Force and speed of the rope at each seat; zero at a seat left open."""
        found = []
        for port in component.ports:
            driver = self.speed_of.get((component.name, port.name))
            speed = ca.MX(0.0) if driver is None else self._variable(*driver)
            size = rope_size(weather=self.weather)
            none = ca.vertcat(ca.MX.zeros(4), 1.0) if self.weather else ca.MX.zeros(4)
            force = self.force_on.get((component.name, port.name), none)
            inertia = ca.MX.zeros(INERTIA) if force.numel() == size else force[size:]
            found.append(ca.vertcat(force[:size], speed, *((inertia,) if component.inertial else ())))
        return found

    def _variable(self, component: str, name: str) -> ca.MX:
        for kind in (Kind.STATE, Kind.ALGEBRAIC, Kind.INPUT, Kind.PARAMETER):
            index = self.tables[kind].index.get(f"{component}.{name}")
            if index is not None:
                return self.vectors[kind][index]
        raise UnbalancedSystemError(f"{component!r} has no variable {name!r}")


def _split(
    kind: Kind, vector: ca.MX, variables: Mapping[str, tuple[Variable, ...]], table: VariableTable
) -> dict[str, ca.MX]:
    """The part of a vector that belongs to each component, behind what all have in common."""
    offsets = [0, *([table.shared] if table.shared else [])]
    for owned in variables.values():
        offsets.append(offsets[-1] + sum(v.size for v in owned if v.kind is kind))
    pieces = ca.vertsplit(vector, offsets)
    return dict(zip(variables, pieces[-len(variables) :], strict=True))
