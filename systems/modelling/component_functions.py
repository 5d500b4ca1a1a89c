"""CasADi functions of each kind of component in its variables and ports, built once per kind."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from ropeway.components.argument_checks import checked
from ropeway.components.catenary import norm
from ropeway.components.component import Component, RopeEnd
from ropeway.components.errors import InputError
from ropeway.components.span import Span
from ropeway.components.variable import Equations, Kind, Site, Variable
from ropeway.components.weather import Weather
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling import component_rules

SYMBOLS = (Kind.STATE, Kind.ALGEBRAIC, Kind.INPUT, Kind.PARAMETER, Kind.DISCRETE)
"""Kinds of variables in equations, in the order of the model's arguments."""


MOST = 2_000
"""Functions that are kept: a class that shares none has one for each of its constants."""


def rope_size(*, weather: bool) -> int:
    """Number of entries of what a rope gives to a seat: the force, the energy carried; with weather its expansion."""
    return 5 if weather else 4


INERTIA = 5
"""Number of entries that a rope with inertia gives to a seat besides."""


def port_size(*, rope: bool, weather: bool, inertial: bool) -> int:
    """Number of entries of a port: of a rope's end its position and travel, of a seat `rope_size` and the rope's
    speed; inertial: and what these need for inertia."""
    if rope:
        return 12 if inertial else 4
    return rope_size(weather=weather) + 1 + (INERTIA if inertial else 0)


class ComponentFunctions:
    """Component functions of all assemblies of a thread; one for each kind of component."""

    def __init__(self) -> None:
        self._functions: dict[Any, ca.Function] = {}
        self._declared: set[Hashable] = set()

    def variables_of(self, component: Component, site: Site) -> tuple[Variable, ...]:
        """A component's variables. Raises InputError for a broken rule; each form is checked once."""
        variables, form = component.variables(site), component.form(site)
        if form not in self._declared:
            if len(self._declared) > MOST:
                self._declared.clear()
            component_rules.require_declared(component, variables)
            self._declared.add(form)
        return variables

    def demand(
        self, component: Component, sums: tuple[str, ...], site: Site, variables: tuple[Variable, ...]
    ) -> ca.Function:
        """Demand of a component on its source, with an entry for each name in `sums` and the same inputs as its
        equations. Raises InputError unless it has exactly these names."""
        key = ("demand", sums, *_form(component, site, variables))
        if key not in self._functions:
            v, inputs = _symbols(component, variables, weather=site.weather)
            demands = component.demand(v)
            if set(demands) != set(sums):
                named, supplied = ", ".join(demands) or "nothing", ", ".join(sums)
                cause = f"{component.name!r} demands {named}, its source supplies {supplied}"
                raise InputError(cause, "Return exactly the source's names from `demand`")
            self._functions[key] = ca.Function("demand", inputs, [ca.vertcat(*(demands[name] for name in sums))])
        return self._functions[key]

    def get(self, component: Component, site: Site, variables: tuple[Variable, ...]) -> ca.Function:
        """A component's equations."""
        return self._known(
            _form(component, site, variables),
            lambda: component_function(component, variables, weather=site.weather),
        )

    def closure(self, span: Span, site: Site, variables: tuple[Variable, ...]) -> ca.Function:
        """The closure of a span with its derivatives in closed form."""
        key = ("closure", *_form(span, site, variables))
        return self._known(key, lambda: closure_function(span, variables, weather=site.weather))

    def moves(self, component: Component, site: Site, variables: tuple[Variable, ...]) -> ca.Function:
        """Derivatives of a component's rates, residuals and forces by its states, algebraic variables and ports, of the
        same inputs as its equations."""
        key = ("moves", *_form(component, site, variables))
        return self._known(key, lambda: _moves_function(self.get(component, site, variables)))

    def _known(self, key: tuple[Hashable, ...], make: Callable[[], ca.Function]) -> ca.Function:
        stop_if_interrupted()
        if key not in self._functions:
            if len(self._functions) > MOST:
                self._functions.clear()
            self._functions[key] = make()
        return self._functions[key]


@checked
def check_component(component: Component) -> None:
    """Check a user-defined component, as scikit-learn's `check_estimator` checks an estimator.

    The assembly of a system makes the same checks.

    Parameters
    ----------
    component : Component
        Any component, added to a system or not.

    Raises
    ------
    InputError
        A fault and its remedy: a reserved, repeated or invalid name, or an unknown unit, of a variable; a missing or
        superfluous residual, rate, output or rope force; an unknown variable in a limit, travel or balance; unequal
        numbers of residuals and algebraic variables; a Python `if`, `max` or `math` function on a symbol; results that
        are not numbers.

    Examples
    --------
    >>> rw.check_component(rw.Anchor("a", at=(0.0, 0.0)))
    """
    for weather in (False, True):
        variables = component.variables(Site(1e4, 100.0, weather=weather))
        component_rules.require_declared(component, variables)
        component_function(component, variables, weather=weather)


def _form(component: Component, site: Site, variables: tuple[Variable, ...]) -> tuple[Hashable, ...]:
    """Key of a component's form. Components of one form share their functions; driven and open inputs differ in
    kind."""
    return (component.form(site), site.weather, component.inertial, tuple(v.kind for v in variables))


def component_function(component: Component, variables: tuple[Variable, ...], *, weather: bool = False) -> ca.Function:
    """(t, shared, x, z, u, p, d, signals, ports...) -> (ode, alg, y, forces of rope ends...).

    `shared`: gravity, with weather also the values of `Weather`; a rope end's force is followed by the energy that the
    rope carries, with weather also by its expansion.
    """
    v, inputs = _symbols(component, variables, weather=weather)
    eq = component_rules.evaluated(component, v)
    component_rules.require_complete(component, variables, eq)

    def stacked(kind: Kind, by_name: Any) -> Any:
        return ca.vertcat(ca.DM(0, 1), *(by_name[var.name] for var in variables if var.kind is kind))

    # The force on the node at the other side of the port is opposite.
    forces = [
        ca.vertcat(
            *(-f for f in eq.forces[port.name]),
            eq.carried[port.name],
            *((eq.expansion,) if weather else ()),
            *(_inertia_at(eq, port.name) if component.inertial else ()),
        )
        for port in component.ports
        if isinstance(port, RopeEnd)
    ]
    results = [
        stacked(Kind.STATE, eq.rates),
        stacked(Kind.RESIDUAL, eq.residuals),
        stacked(Kind.OUTPUT, eq.outputs),
        *forces,
    ]
    if component.inertial and not component.external:
        results = ca.cse(results)
    found = ca.Function(type(component).__name__, inputs, results)
    if not component.external:
        kinds = (Kind.STATE, Kind.RESIDUAL, Kind.OUTPUT)
        names = [[var.name for var in variables if var.kind is kind for _ in range(var.size)] for kind in kinds]
        component_rules.require_numbers(component, found, names)
    return found


def closure_function(span: Span, variables: tuple[Variable, ...], *, weather: bool) -> ca.Function:
    """A span's closure (3,), and its derivatives (3, 5) by its tension vector and the travels at its ends, of the same
    inputs as its `component_function`."""
    v, inputs = _symbols(span, variables, weather=weather)
    closure = ca.vertcat(*span.equations(v).residuals.values())
    columns = [ca.vertcat(*column) for column in span.closure_moves(v)]
    return ca.Function("closure", inputs, ca.cse([closure, ca.horzcat(*columns)]))


def _moves_function(equations: ca.Function) -> ca.Function:
    """The derivatives of a `component_function` that are of interest: see `ComponentFunctions.moves`."""
    inputs = equations.sx_in()
    rates, residuals, _, *forces = equations.call(inputs)
    _, _, x, z, _, _, _, _, *ports = inputs
    found = ca.jacobian(ca.vertcat(rates, residuals, *forces), ca.vertcat(x, z, *ports))
    return ca.Function("moves", inputs, [ca.cse(found)])


def force_function(span: Span, variables: tuple[Variable, ...], *, weather: bool) -> ca.Function:
    """A span's closure (3,), and `force_moves` (3, 3) by it and the travels at its ends, of the same inputs as its
    `component_function`."""
    v, inputs = _symbols(span, variables, weather=weather)
    closure = list(span.equations(v).residuals.values())
    moves = [ca.vertcat(*move) for move in span.force_moves(v, closure)]
    return ca.Function("forces", inputs, ca.cse([ca.vertcat(*closure), ca.horzcat(*moves)]))


def _inertia_at(eq: Equations, end: str) -> tuple[Any, ...]:
    """What an inertial node has at the seat of a rope end besides force and carried energy."""
    pull, inertia = eq.forces[end], eq.inertia[end]
    # The force on the rope at end a points against the direction of the rope, at end b along it.
    side = 1.0 if end == "a" else -1.0
    along = -side * sum(pull[i] * inertia[i] for i in range(3)) / norm(pull)
    return (*inertia, along, side)


def _symbols(
    component: Component, variables: tuple[Variable, ...], *, weather: bool
) -> tuple[SimpleNamespace, list[Any]]:
    """Symbols of a component's equations, as attributes and as inputs of its function."""
    sym = ca.MX.sym if component.external else ca.SX.sym
    time, shared = sym("t"), sym("shared", 1 + (len(Weather._fields) if weather else 0))
    gravity, *values = (shared[i] for i in range(shared.numel()))
    v = SimpleNamespace(time=time, gravity=gravity, weather=Weather(*values) if weather else None)
    vectors = []
    for kind in SYMBOLS:
        owned = [var for var in variables if var.kind is kind]
        offsets = np.cumsum([0, *(var.size for var in owned)])
        vector = sym(kind.value, int(offsets[-1]))
        for var, start in zip(owned, offsets[:-1].tolist(), strict=True):
            setattr(v, var.name, vector[start : start + var.size, 0])
        vectors.append(vector)
    ports = []
    for port in component.ports:
        rope, more = isinstance(port, RopeEnd), component.inertial
        symbol = sym(port.name, port_size(rope=rope, weather=weather, inertial=more))
        vector_3d = (symbol[0], symbol[1], symbol[2])
        if rope:
            seen = SimpleNamespace(position=vector_3d, travel=symbol[3])
            if more:
                seen.velocity, seen.acceleration = (symbol[4], symbol[5], symbol[6]), (symbol[7], symbol[8], symbol[9])
                seen.speed, seen.rope_acceleration = symbol[10], symbol[11]
        else:
            force, rest = rope_size(weather=weather), rope_size(weather=weather) + 1
            expansion = symbol[4] if weather else 1.0
            seen = SimpleNamespace(force=vector_3d, carried=symbol[3], expansion=expansion, speed=symbol[force])
            if more:
                seen.inertia = (symbol[rest], symbol[rest + 1], symbol[rest + 2])
                seen.along, seen.side = symbol[rest + 3], symbol[rest + 4]
        setattr(v, port.name, seen)
        ports.append(symbol)
    names = (*component.sums, *component.shares)
    signals = sym("signals", len(names))
    for i, name in enumerate(names):
        setattr(v, name, signals[i])
    return v, [time, shared, *vectors, signals, *ports]
