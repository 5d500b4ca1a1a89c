"""Equations of an FMU: the model and its derivatives as functions for C, and the dependencies of its variables.

Dependencies are those after elimination of the algebraic variables.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from operator import or_

import casadi as ca
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from ropeway.components.errors import InputError
from ropeway.components.inertia import Inertia
from ropeway.components.schedule import Schedule
from ropeway.fmu.exporting.carriage_corridor import Corridor
from ropeway.fmu.exporting.inertial_solution import InertialSolution
from ropeway.fmu.exporting.section_solution import SectionSolution, room_of
from ropeway.systems.dynamics.run_inputs import is_speed, require_no_events, started
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.intervention import INERTIAL, SWITCHED
from ropeway.systems.solvers.line_sections import UnfitError, line_sections
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.load_positions import loads_once, unpin
from ropeway.systems.statics.pending_events import Pending


@dataclass(frozen=True, eq=False)
class ModelEquations:
    """Equations of a line that starts from an equilibrium.

    `state`: where the FMU starts, with loads clamped to the rope; `corridor`: places of a skyline's carriage;
    `pending`: delayed actions of a run in progress.
    """

    state: LineState
    corridor: Corridor | None = None
    pending: Pending = field(default_factory=Pending)

    @classmethod
    def at(cls, rest: Equilibrium, inertia: Inertia | None = None) -> ModelEquations:
        """Equations that start from an equilibrium, or from a run in progress.

        Raises InputError during an emergency stop, and for an inertia that does not fit.
        """
        if rest.pending.stopping is not None:
            raise InputError(
                f"{rest.model.name!r} is in an emergency stop, which an FMU cannot continue",
                "Export the line at an earlier time, or its equilibrium there: equilibrium(line, start=...)",
            )
        state = LineState(rest.model, rest.point.copy(), rest.runs, rest.passed)
        unpin(state)
        if inertia is not None and rest.model.inertia not in (None, inertia):
            raise InputError(f"{rest.model.name!r} moves with {rest.model.inertia}", "Give the same inertia=, or none")
        if inertia is not None and rest.model.inertia is None:
            require_no_events(rest.model.system)
            signals = [float(u) if s is None else s for s, u in zip(rest.model.signals, state.point.u, strict=True)]
            state = started(state, signals, inertia)
        return cls(state, pending=rest.pending)

    @property
    def model(self) -> Model:
        """The flat model."""
        return self.state.model

    @cached_property
    def symbols(self) -> list[ca.MX]:
        """t, x, z, u, p, d."""
        symbols: list[ca.MX] = self.model.dae.mx_in()
        return symbols

    @cached_property
    def dae(self) -> ca.Function:
        """(t, x, z, u, p, d) -> (ode, alg), dense."""
        return ca.Function("rw_dae", self.symbols, [ca.densify(v) for v in self.model.dae(*self.symbols)])

    @cached_property
    def outputs(self) -> ca.Function:
        """(t, x, z, u, p, d) -> y, dense."""
        return ca.Function("rw_outputs", self.symbols, [ca.densify(self.model.outputs(*self.symbols))])

    @cached_property
    def jacobian(self) -> ca.Function | None:
        """(t, x, z, u, p, d) -> derivatives of (ode, alg) by (x, z); its pattern holds the diagonal of the states.

        None where they are found by tangents in the directions of `groups`.
        """
        if self.groups:
            return None
        x, z = self.symbols[1], self.symbols[2]
        if self.corridor is None:
            matrix = ca.jacobian(ca.vertcat(*self.model.dae(*self.symbols)), ca.vertcat(x, z))
        else:
            matrix = self.corridor.united.jacobian(*self.symbols)
        diagonal = _diagonal(matrix.shape[0], x.numel())
        return ca.Function("rw_jacobian", self.symbols, [ca.project(matrix, matrix.sparsity() + diagonal)])

    @property
    def by_pieces(self) -> bool:
        """Whether the compiled core solves the equations, by sections of a line or by its pieces of rope."""
        return self.by_sections is not None or isinstance(self.inertial, InertialSolution)

    @cached_property
    def groups(self) -> list[int]:
        """Of each of (x, z) its group: no equation depends on two of a group. Empty unless the compiled core solves the
        equations piece by piece, and needs these derivatives rarely."""
        if not self.by_pieces:
            return []
        colours = self.pattern.uni_coloring()
        found = np.zeros(colours.shape[0], dtype=int)
        found[np.array(colours.row(), dtype=int)] = colours.get_col()
        groups: list[int] = found.tolist()
        return groups

    @cached_property
    def tangent(self) -> ca.Function:
        """(t, x, z, u, p, d, and a change of each) -> changes of (ode, alg, y), dense."""
        seeds = [ca.MX.sym(f"d{name}", s.shape) for name, s in zip("txzupd", self.symbols, strict=True)]
        parts = [f.call(self.symbols, f.is_a("MXFunction"), False) for f in (self.model.dae, self.model.outputs)]
        # Equations and outputs share the functions of their components.
        whole = ca.Function("rw_all", self.symbols, ca.cse([result for part in parts for result in part]))
        results = [ca.MX(*whole.size_out(i)) for i in range(whole.n_out())]
        changes = whole.forward(1).call([*self.symbols, *results, *seeds])
        return ca.Function("rw_tangent", [*self.symbols, *seeds], [ca.densify(c) for c in changes])

    @property
    def functions(self) -> tuple[ca.Function, ...]:
        """All functions that the C core calls."""
        margins = () if self.corridor is None else (self.corridor.function,)
        line = () if self.by_sections is None else self.by_sections.functions
        jacobian = () if self.jacobian is None else (self.jacobian,)
        return (self.dae, self.outputs, *jacobian, self.tangent, *self.clocks, *margins, *line)

    @cached_property
    def by_sections(self) -> SectionSolution | None:
        """How a line is solved by its sections; None for other systems."""
        sections = line_sections(self.model) if self.corridor is None else ""
        return None if isinstance(sections, str) else SectionSolution(self.model, sections, coupled=self.coupled)

    @cached_property
    def inertial(self) -> InertialSolution | UnfitError | None:
        """How a system with inertia is solved, or why the compiled core does not have it; None without inertia."""
        if self.model.inertia is None:
            return None
        try:
            return InertialSolution(self.model)
        except UnfitError as reason:
            return reason

    @cached_property
    def clocks(self) -> tuple[ca.Function, ...]:
        """(t, x, z, u, p, d) -> new values of the entries of each clock, dense."""
        return tuple(
            ca.Function(f"rw_clock_{i}", self.symbols, [ca.densify(clock.update(*self.symbols))])
            for i, clock in enumerate(self.model.clocks)
        )

    @cached_property
    def pattern(self) -> ca.Sparsity:
        """Pattern of the Jacobian."""
        if not self.by_pieces and self.jacobian is not None:
            return self.jacobian.sparsity_out(0)
        dae = self.model.dae
        rows = [ca.horzcat(dae.jac_sparsity(i, 1), dae.jac_sparsity(i, 2)) for i in range(2)]
        pattern = ca.vertcat(*rows)
        return pattern + _diagonal(pattern.shape[0], len(self.model.x))

    @cached_property
    def factors(self) -> tuple[list[int], int, int]:
        """Column order for LU, and room for L and U (see `room_of`)."""
        return room_of(self.pattern)

    @cached_property
    def coupled(self) -> bool:
        """Whether the rates depend on states, or not linearly on inputs and time: they must then be integrated."""
        if len(self.model.x) == 0:
            return False
        if any(self.model.dae.jac_sparsity(0, argument).nnz() for argument in (1, 2)):
            return True
        symbols = self.model.dae.sx_in()
        ode = self.model.dae.expand()(*symbols)[0]
        return not ca.is_linear(ode, ca.vertcat(symbols[0], symbols[3]))

    @cached_property
    def schedules(self) -> dict[int, Schedule]:
        """Schedules among the signals, by input."""
        return {i: s for i, s in enumerate(self.model.signals) if isinstance(s, Schedule)}

    @cached_property
    def switches(self) -> dict[str, int]:
        """Discrete variables that can be set during a run, by name: brakes and losses of pressure; with inertia cut
        ropes and dropped payloads."""
        actions = SWITCHED if self.model.inertia is None else {**SWITCHED, **INERTIAL}
        own = {variable for variable, _ in actions.values()}
        return {name: i for i, name in enumerate(self.model.d.names) if name.rpartition(".")[2] in own}

    @cached_property
    def commanded(self) -> dict[int, int]:
        """Commanded speeds among the inputs, which an emergency stop ramps down, and the places of their corrections by
        responses among the discrete variables, -1 if there are none."""
        m = self.model
        ends = [name.rpartition(".") for name in m.u.names]
        driven = {i: owner for i, (owner, _, quantity) in enumerate(ends) if is_speed(m.system, owner, quantity)}
        return {i: m.d.index.get(f"{owner}.correction", -1) for i, owner in driven.items()}

    @cached_property
    def followed(self) -> dict[int, int]:
        """Inputs that are rates of other inputs, and these: an FMU computes them."""
        index = self.model.u.index
        return {index[rate]: index[of] for rate, of in self.model.rate_of.items() if rate in index and of in index}

    @property
    def borders(self) -> int:
        """Borders between places of a carriage."""
        return 0 if self.corridor is None else len(self.corridor.order) - 1

    @cached_property
    def mass_names(self) -> list[list[str]]:
        """For each run the names of its masses that can be set: of its loads, or of its feed."""
        names = []
        for run in self.state.runs:
            if run.feed is None:
                names.append([f"{name}.mass" for name in run.loads.names])
            else:
                first, n = run.nodes[0].name, len(run.feed.masses)
                names.append([f"{first}.load_mass[{i + 1}]" for i in range(n)] if n > 1 else [f"{first}.load_mass"])
        return names

    @cached_property
    def masses(self) -> np.ndarray:
        """Values of `mass_names` [kg]."""
        masses = [
            loads_once(self.state, r).mass
            if run.around
            else run.loads.mass
            if run.feed is None
            else np.array(run.feed.masses)
            for r, run in enumerate(self.state.runs)
        ]
        return np.concatenate([[], *masses])


class Dependencies:
    """Knowns that rates, algebraic variables and outputs depend on after elimination, as bit masks.

    Knowns are states, inputs, switches, parameters and masses, numbered in this order.
    """

    def __init__(self, equations: ModelEquations) -> None:
        m = equations.model
        self._m = m
        self.first_input = len(m.x)
        self.first_switch = self.first_input + len(m.u)
        self.first_parameter = self.first_switch + len(equations.switches)
        self.first_mass = self.first_parameter + len(m.p)
        self.count = self.first_mass + len(equations.masses)
        self._slots = self._slot_masks(equations)
        self.z = self._eliminated(self._direct(m.dae, 1))
        self.rates = self._through(m.dae, 0)
        self.outputs = self._through(m.outputs, 0)
        margins = [] if equations.corridor is None else self._through(equations.corridor.function, 0)
        self.margins = reduce(or_, margins, 0)

    def _slot_masks(self, equations: ModelEquations) -> list[int]:
        """Knowns that each discrete variable is computed from: parameters and masses, or a switch."""
        masks = [0] * len(self._m.d)
        for i, entry in enumerate(equations.switches.values()):
            masks[entry] = 1 << (self.first_switch + i)
        mass = self.first_mass
        for run, layout, names in zip(equations.state.runs, self._m.layouts, equations.mass_names, strict=True):
            every = sum(1 << (mass + i) for i in range(len(names)))
            mass += len(names)
            # On an endless rope the loads of a turn are one rope length behind those of the previous turn.
            before = sum(1 << (self.first_parameter + int(i)) for i in layout.length_start) if run.around else 0
            for k, n in enumerate(layout.slots.count):
                for j in range(int(n)):
                    masks[int(layout.slots.mass[k]) + j] |= every
                    masks[int(layout.slots.at[k]) + j] |= before
                before |= 1 << (self.first_parameter + int(layout.length_start[k]))
        return masks

    def _direct(self, f: ca.Function, result: int) -> list[int]:
        """Masks of the result of a function, without the algebraic variables."""
        masks = [0] * f.size1_out(result)
        for argument, first in ((1, 0), (3, self.first_input), (4, self.first_parameter)):
            for row, column in _entries(f.jac_sparsity(result, argument)):
                masks[row] |= 1 << (first + column)
        for row, column in _entries(f.jac_sparsity(result, 5)):
            masks[row] |= self._slots[column]
        return masks

    def _eliminated(self, residuals: list[int]) -> list[int]:
        """Masks of the algebraic variables; each is determined by its matched residual."""
        n = len(residuals)
        if n == 0:
            return []
        pattern = self._m.dae.jac_sparsity(1, 2)
        row, column = np.array(pattern.row()), np.array(pattern.get_col())
        determined = self._m.determined
        needs = csr_matrix((np.ones(len(row)), (determined[row], column)), shape=(n, n))
        count, block = connected_components(needs, connection="strong")
        masks = [0] * count
        for r, mask in enumerate(residuals):
            masks[block[determined[r]]] |= mask
        edges = {(int(block[determined[r]]), int(block[c])) for r, c in zip(row, column, strict=True)}
        changed = True
        while changed:
            changed = False
            for a, b in edges:
                if masks[b] & ~masks[a]:
                    masks[a] |= masks[b]
                    changed = True
        return [masks[b] for b in block]

    def _through(self, f: ca.Function, result: int) -> list[int]:
        masks = self._direct(f, result)
        for row, column in _entries(f.jac_sparsity(result, 2)):
            masks[row] |= self.z[column]
        return masks

    def bits(self, mask: int) -> list[int]:
        """The knowns of a mask, ascending."""
        return [i for i, c in enumerate(reversed(bin(mask)[2:])) if c == "1"]


def _entries(pattern: ca.Sparsity) -> Iterator[tuple[int, int]]:
    rows: Sequence[int] = pattern.row()
    columns: Sequence[int] = pattern.get_col()
    return zip(rows, columns, strict=True)


def _diagonal(size: int, count: int) -> ca.Sparsity:
    """The first entries of a diagonal."""
    return ca.Sparsity.triplet(size, size, list(range(count)), list(range(count)))
