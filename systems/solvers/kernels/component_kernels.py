"""Equations of components with inertia as kernels in C, one for each form of component.

A piece of rope has unknowns that depend, for given unknowns of the nodes at its ends, on nothing else: its kernel gives
all that is needed to eliminate them. Of a step c the change of its states follows from that of its algebraic variables,
dx = S dz + T r with T = c (1 + c f_x), exact where the rates of its states depend on other states in one generation, as
places do on velocities.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ropeway.components.component import Component, RopeEnd
from ropeway.components.variable import Kind, Site, Variable
from ropeway.components.weather import SHARED, Weather
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.structure import KNOWN
from ropeway.systems.native.binary_cache import library
from ropeway.systems.native.c_library import address
from ropeway.systems.native.kernel_source import kernel_source
from ropeway.systems.solvers.line_sections import UnfitError


class Block(NamedTuple):
    """Rows and columns of the entries of a matrix."""

    rows: tuple[int, ...]
    columns: tuple[int, ...]


@dataclass(frozen=True)
class Sizes:
    """Numbers of states, algebraic variables, inputs, parameters and discrete variables of a component, of all entries
    of its ports, and of those that a piece gives to its nodes."""

    nx: int
    nz: int
    nu: int
    np: int
    nd: int
    ports: int
    given: int


@dataclass(frozen=True, eq=False)
class ComponentKernels:
    """Two functions of one vector (states, algebraic variables, ports, inputs, what all share, parameters, discrete
    variables; of a piece's matrix the step), the blocks of the matrix, and the orders of residuals and algebraic
    variables in it. `far`: entries of ports that its equations need."""

    sizes: Sizes
    value: ca.Function
    matrix: ca.Function
    blocks: tuple[Block, ...]
    order_r: tuple[int, ...]
    order_z: tuple[int, ...]
    far: frozenset[int]

    @cached_property
    def addresses(self) -> dict[str, int]:
        """Where both are, compiled, by their names in inertial.h. Raises CompilerError, WriteError."""
        kernels = {"value": self.value, "matrix": self.matrix}
        compiled = library({f"{name}.c": _source(k, name) for name, k in kernels.items()})
        return {name: address(compiled, name) for name in kernels}

    @cached_property
    def sources(self) -> dict[str, tuple[str, str]]:
        """Both in C for another library, by their names in inertial.h: a name that the content determines, and the
        text."""
        found = {}
        for name, kernel in (("value", self.value), ("matrix", self.matrix)):
            text = _source(kernel, "rw_kernel", exported=False)
            own = f"rw_kernel_{sha256(text.encode()).hexdigest()[:16]}"
            found[name] = own, text.replace("rw_kernel(", f"{own}(")
        return found


class _Symbols(NamedTuple):
    """A component on symbols: its vectors, ports, and what follows from them."""

    x: Any
    z: Any
    ports: Any
    known: Any
    rates: Any
    residuals: Any
    given: Any


_KERNELS: dict[Hashable, ComponentKernels] = {}


def component_kernels(component: Component, slots: int, *, weather: bool) -> ComponentKernels:
    """The kernels of a component with so many load slots. Raises UnfitError."""
    site = Site(1.0, 1.0, slots, weather=weather)
    key = component.form(site)
    if key not in _KERNELS:
        _KERNELS[key] = _made(component, site)
    return _KERNELS[key]


def is_piece(component: Component) -> bool:
    """Whether a component is a piece of rope, whose unknowns are eliminated."""
    return any(isinstance(port, RopeEnd) for port in component.ports)


def _made(component: Component, site: Site) -> ComponentKernels:
    variables = KNOWN.functions.variables_of(component, site)
    function = KNOWN.functions.get(component, site, variables)
    stop_if_interrupted()
    s = _symbols(component, function, weather=site.weather)
    nx, nz, nu, parameters, nd = (int(function.numel_in(i)) for i in range(2, 7))
    sizes = Sizes(nx, nz, nu, parameters, nd, s.ports.numel(), s.given.numel())
    step = ca.SX.sym("c")
    if is_piece(component):
        matrices, inputs = _piece(component, s, step), [s.x, s.z, s.ports, s.known, step]
        order_r, order_z = _by_slot(variables, Kind.RESIDUAL), _by_slot(variables, Kind.ALGEBRAIC)
    else:
        own, inputs = ca.vertcat(s.rates, s.residuals), [s.x, s.z, s.ports, s.known]
        matrices = [ca.jacobian(own, ca.vertcat(s.x, s.z)), ca.jacobian(own, s.ports)]
        order_r, order_z = (), ()
    blocks, entries = list[Block](), list[Any]()
    for k, matrix in enumerate(matrices):
        found = ca.sparsify(matrix)
        rows, columns = found.sparsity().row(), found.sparsity().get_col()
        if order_r and k in _ROWS_ARE_RESIDUALS:
            rows = np.argsort(order_r)[rows].tolist()
        if order_z and k in _COLUMNS_ARE_UNKNOWNS:
            columns = np.argsort(order_z)[columns].tolist()
        blocks.append(Block(tuple(rows), tuple(columns)))
        entries.append(found.nz[:])
    value = _kernel("value", [s.x, s.z, s.ports, s.known], [s.rates, s.residuals, s.given])
    matrix = _kernel("matrix", inputs, entries)
    return ComponentKernels(sizes, value, matrix, tuple(blocks), order_r, order_z, frozenset(blocks[1].columns))


_ROWS_ARE_RESIDUALS = (0, 1, 2)
_COLUMNS_ARE_UNKNOWNS = (0, 3, 6)
"""Among the blocks of a piece, in the order of inertial.h."""


def _symbols(component: Component, function: ca.Function, *, weather: bool) -> _Symbols:
    """Raises UnfitError."""
    time, _, x, z, u, p, d, signals, *ports = function.sx_in()
    shared = ca.SX.sym("shared", 1 + (len(SHARED) if weather else 0))
    values = ca.vertcat(shared[0], *(Weather.of(ca.vertsplit(shared)[1:]) if weather else ()))
    ones = ca.SX.ones(signals.numel())  # without a source of power each drive has its whole share
    rates, residuals, _, *forces = function.call([time, values, x, z, u, p, d, ones, *ports])
    given = ca.vertcat(ca.SX(0, 1), *forces)
    if ca.depends_on(ca.vertcat(rates, residuals, given), time):
        raise UnfitError(f"{component.name!r} depends on time")
    known = ca.vertcat(u, shared, p, d)
    return _Symbols(x, z, ca.vertcat(ca.SX(0, 1), *ports), known, rates, residuals, given)


def _piece(component: Component, s: _Symbols, c: Any) -> list[Any]:
    """The matrices of a piece for a step c, in the order of inertial.h. Raises UnfitError."""
    f_x, f_z = ca.jacobian(s.rates, s.x), ca.jacobian(s.rates, s.z)
    g_x, g_z = ca.jacobian(s.residuals, s.x), ca.jacobian(s.residuals, s.z)
    h_x, h_z = ca.jacobian(s.given, s.x), ca.jacobian(s.given, s.z)
    if ca.jacobian(s.rates, s.ports).nnz() or ca.mtimes(f_x, f_x).nnz():
        raise UnfitError(f"the states of {component.name!r} depend on each other")
    by_rates = c * (ca.SX.eye(s.x.numel()) + c * f_x)
    by_unknowns = ca.mtimes(by_rates, f_z)
    return [
        -(ca.mtimes(g_x, by_unknowns) + g_z),
        ca.jacobian(s.residuals, s.ports),
        ca.mtimes(g_x, by_rates),
        h_z + ca.mtimes(h_x, by_unknowns),
        ca.mtimes(h_x, by_rates),
        ca.jacobian(s.given, s.ports),
        by_unknowns,
        by_rates,
    ]


def _by_slot(variables: Sequence[Variable], kind: Kind) -> tuple[int, ...]:
    """The order of unknowns or residuals along the rope: tensions at end a, slot after slot, closure at end b."""
    rank = list[tuple[int, int]]()
    for v in variables:
        if v.kind is kind:
            alone = 0 if kind is Kind.ALGEBRAIC else 10**6
            rank += [
                (j + 1, len(rank) + j) if isinstance(v.value, tuple) else (alone, len(rank)) for j in range(v.size)
            ]
    return tuple(sorted(range(len(rank)), key=lambda i: rank[i]))


def _kernel(name: str, inputs: Sequence[Any], outputs: Sequence[Any]) -> ca.Function:
    """A function of one vector with one vector of results."""
    result = ca.cse(ca.densify(ca.vertcat(ca.SX(0, 1), *outputs)))
    return ca.Function(name, [ca.vertcat(*inputs)], [result])


_LONG = ((40_000, "O0"), (10_000, "O1"))
"""Lines of a kernel above which GCC takes minutes, and what it compiles such a kernel with."""


def _source(kernel: ca.Function, name: str, *, exported: bool = True) -> str:
    """A kernel in C, of a name."""
    text = kernel_source(kernel, name, exported=exported)
    level = next((level for lines, level in _LONG if text.count("\n") > lines), None)
    pragma = f'#if defined(__GNUC__) && !defined(__clang__)\n#pragma GCC optimize ("{level}")\n#endif\n'
    return text if level is None else pragma + text
