"""A line in an FMU that is solved by its sections: kernels of its spans and supports, its drives, and their tables."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.equations import expanded, scalar
from ropeway.systems.native.c_tables import Tables
from ropeway.systems.native.kernel_source import kernel_source
from ropeway.systems.native.section_library import LINE_INTEGERS, LINE_NUMBERS
from ropeway.systems.solvers.compiled_line import line_tables, slots_of_kernel
from ropeway.systems.solvers.line_sections import LineSections


class SectionSolution:
    """The sections of a line, `coupled`: whether the rates of its states depend on the states.

    The rates, their derivatives and the outputs that have limits are functions of their own, of the quantities that
    they need alone.
    """

    def __init__(self, model: Model, sections: LineSections, *, coupled: bool) -> None:
        self.model, self.sections, self.coupled = model, sections, coupled
        self.sizes, self.numbers = line_tables(model, sections)
        dae = expanded(model)
        self._symbols: list[Any] = dae.sx_in()
        self._ode = dae(*self._symbols)[0]

    def _function(self, name: str, result: Any) -> ca.Function:
        return ca.Function(name, self._symbols, [ca.cse(result)])

    @cached_property
    def rates(self) -> ca.Function:
        """(t, x, z, u, p, d) -> ode."""
        return self._function("rw_ode", ca.densify(self._ode))

    @cached_property
    def limits(self) -> ca.Function:
        """(t, x, z, u, p, d) -> the output of each limit."""
        outputs = scalar(self.model, self.model.outputs)(*self._symbols)
        chosen = [outputs[int(i)] for i in self.model.limits.output]
        return self._function("rw_limit_outputs", ca.densify(ca.vertcat(*chosen)))

    @cached_property
    def coupling(self) -> ca.Function:
        """(t, x, z, u, p, d) -> derivatives of ode by (x, z), sparse."""
        unknowns = ca.vertcat(self._symbols[1], self._symbols[2])
        return self._function("rw_ode_derivatives", ca.jacobian(self._ode, unknowns))

    @property
    def functions(self) -> tuple[ca.Function, ...]:
        """Those that are compiled as the equations of the whole line are."""
        return (self.rates, self.limits, *((self.coupling,) if self.coupled else ()))

    @cached_property
    def kernels(self) -> dict[str, ca.Function]:
        """The kernels of spans and supports, by their names in C."""
        found = {}
        for i, form in enumerate(self.sections.forms):
            for used in range(self.sizes["slots"] + 1):
                slots = slots_of_kernel(used)
                found[f"rw_span_{i}_{slots}"] = form.kernel(slots)
        for i, support in enumerate(self.sections.support_forms):
            found[f"rw_support_{i}"] = support.kernel
        return found

    @property
    def sources(self) -> dict[str, str]:
        """A file in C for each kernel."""
        return {f"{name}.c": kernel_source(k, name, exported=False) for name, k in self.kernels.items()}

    @cached_property
    def _states_of_sections(self) -> list[list[int]]:
        """The states that each section depends on: travels at its ends, and speeds of drives beside its idlers."""
        n, found = self.numbers, []
        for first, last in zip(n["first"], n["last"], strict=True):
            supports = range(int(first), int(last) + 1)
            states = {int(n["state"][k]) for k in (first, last)}
            states |= {
                int(n["speed"][k]) for k in supports if n["travel"][k] >= 0 and n["speed"][k] < len(self.model.x)
            }
            found.append(sorted(states - {-1}))
        return found

    @cached_property
    def pattern(self) -> ca.Sparsity:
        """Pattern of the derivatives of ode by the states, alone and through the line, with the diagonal."""
        nx, n = len(self.model.x), self.numbers
        pairs = {(i, i) for i in range(nx)}
        if self.coupled:
            reads: dict[int, list[int]] = {}
            own = self.coupling.sparsity_out(0)
            for row, column in zip(own.row(), own.get_col(), strict=True):
                if column < nx:
                    pairs.add((row, column))
                else:
                    reads.setdefault(column - nx, []).append(row)
            for s, states in enumerate(self._states_of_sections):
                a, b, span = (int(n[name][s]) for name in ("first", "last", "first_span"))
                places = [int(n["force"][i]) + axis for i in range(span, span + b - a) for axis in range(3)]
                places += [int(n["travel"][k]) for k in range(a, b + 1) if n["travel"][k] >= 0]
                pairs |= {(row, j) for z in places for row in reads.get(z, ()) for j in states}
        rows, columns = zip(*sorted(pairs), strict=True) if pairs else ((), ())
        return ca.Sparsity.triplet(nx, nx, list(rows), list(columns))


def fill_line(tables: Tables, solution: SectionSolution | None, model: Model) -> tuple[int, int]:
    """Writes the tables of a line by sections, or empty ones; returns room for the factors of its drives."""
    nx, nz = len(model.x), len(model.z)
    coupling = pattern = None
    of_states: list[list[int]] = [[] for _ in range(nx)]
    if solution is not None:
        coupling = solution.coupling.sparsity_out(0) if solution.coupled else None
        pattern = solution.pattern
        for s, states in enumerate(solution._states_of_sections):
            for state in states:
                of_states[state].append(s)
    order, lower, upper = room_of(pattern)
    tables.size("sections", int(solution is not None))
    tables.size("nsec", 0 if solution is None else solution.sizes["sections"])
    tables.size("ncp", 0 if coupling is None else coupling.nnz())
    tables.size("dnnz", 0 if pattern is None else pattern.nnz())
    tables.integers("coupling_colind", np.zeros(nx + nz + 1) if coupling is None else coupling.colind())
    tables.integers("coupling_row", [] if coupling is None else coupling.row())
    tables.pattern("drives", ca.Sparsity(nx, nx) if pattern is None else pattern, order)
    tables.integers("state_section_first", np.concatenate([[0], np.cumsum([len(s) for s in of_states])]))
    tables.integers("state_section", [s for sections in of_states for s in sections])
    _functions(tables, solution)
    _line(tables, solution)
    return lower, upper


def room_of(pattern: ca.Sparsity | None) -> tuple[list[int], int, int]:
    """Column order for LU, and an upper bound of the entries of L and U for any pivots, from the patterns of a QR
    factorisation."""
    if pattern is None or pattern.shape[0] == 0:
        return [], 1, 1
    v, r, _, order = pattern.qr_sparse()
    return list(order), v.nnz() + r.shape[1], r.nnz() + r.shape[1]


def _functions(tables: Tables, solution: SectionSolution | None) -> None:
    tables.functions("rates_alone", [] if solution is None else [solution.rates.name()])
    tables.functions("limits_alone", [] if solution is None else [solution.limits.name()])
    tables.functions("coupling", [] if solution is None or not solution.coupled else [solution.coupling.name()])


def _line(tables: Tables, solution: SectionSolution | None) -> None:
    """rs_line."""
    if solution is None:
        tables.structure("rs_line", "line", {"spans": "0"})
        return
    sizes, sections = solution.sizes, solution.sections
    fields = {name: str(size) for name, size in sizes.items()}
    for name in LINE_INTEGERS:
        tables.integers(f"line_{name}", solution.numbers[name])
        fields[name] = f"rw_line_{name}"
    fields |= {name: f"rw_{name}" for name in LINE_NUMBERS}
    spans = [
        f"rw_span_{i}_{slots_of_kernel(used)}" for i in range(len(sections.forms)) for used in range(sizes["slots"] + 1)
    ]
    supports = [f"rw_support_{i}" for i in range(len(sections.support_forms))]
    for name, kernels in (("kernels", spans), ("support_kernels", supports)):
        tables.kernels(f"line_{name}", kernels)
        fields[name] = f"rw_line_{name}"
    tables.structure("rs_line", "line", fields)
