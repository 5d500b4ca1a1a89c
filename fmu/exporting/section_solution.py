"""A line in an FMU that is solved by its sections: kernels of its spans and supports, its drives, and their tables."""

from __future__ import annotations

from functools import cached_property

import casadi as ca
import numpy as np
from scipy.sparse import csc_matrix

from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.native.c_tables import Tables
from ropeway.systems.native.kernel_source import hidden_kernel
from ropeway.systems.native.section_library import LINE_INTEGERS, LINE_KERNELS, LINE_NUMBERS
from ropeway.systems.solvers.compiled_line import line_tables, slots_of_kernel
from ropeway.systems.solvers.kernels.compiled_network import elimination_order
from ropeway.systems.solvers.line_sections import LineSections


class SectionSolution:
    """The sections of a line, `coupled`: whether the rates of its states depend on the states."""

    def __init__(self, model: Model, sections: LineSections, *, coupled: bool) -> None:
        self.model, self.sections, self.coupled = model, sections, coupled
        self.sizes, self.numbers = line_tables(model, sections)

    @cached_property
    def coupling(self) -> ca.Sparsity:
        """Pattern of the derivatives of the rates by (x, z)."""
        return ca.horzcat(*(self.model.dae.jac_sparsity(0, argument) for argument in (1, 2)))

    @cached_property
    def kernels(self) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]:
        """Name in C and file of the kernels of spans, for each form and number of used slots, and of supports."""
        spans = []
        for form in self.sections.forms:
            own = {slots: hidden_kernel(form.kernel(slots)) for slots in self._slots}
            spans += [own[slots_of_kernel(used)] for used in range(self.sizes["slots"] + 1)]
        return spans, [hidden_kernel(support.kernel) for support in self.sections.support_forms]

    @property
    def _slots(self) -> list[int]:
        return sorted({slots_of_kernel(used) for used in range(self.sizes["slots"] + 1)})

    @property
    def sources(self) -> dict[str, str]:
        """A file in C for each kernel."""
        return {f"{name}.c": text for own in self.kernels for name, text in own}

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
            own = self.coupling
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


def fill_line(tables: Tables, solution: SectionSolution | None, model: Model) -> None:
    """Writes the tables of a line by sections, or empty ones."""
    nx, nz = len(model.x), len(model.z)
    coupling = pattern = None
    of_states: list[list[int]] = [[] for _ in range(nx)]
    if solution is not None:
        coupling = solution.coupling if solution.coupled else None
        pattern = solution.pattern
        for s, states in enumerate(solution._states_of_sections):
            for state in states:
                of_states[state].append(s)
    tables.size("sections", int(solution is not None))
    tables.size("nsec", 0 if solution is None else solution.sizes["sections"])
    tables.size("ncp", 0 if coupling is None else coupling.nnz())
    tables.size("dnnz", 0 if pattern is None else pattern.nnz())
    tables.integers("coupling_colind", np.zeros(nx + nz + 1) if coupling is None else coupling.colind())
    tables.integers("coupling_row", [] if coupling is None else coupling.row())
    write_pattern(tables, "drives", ca.Sparsity(0, 0) if pattern is None else pattern)
    tables.integers("state_section_first", np.concatenate([[0], np.cumsum([len(s) for s in of_states])]))
    tables.integers("state_section", [s for sections in of_states for s in sections])
    _line(tables, solution)


def write_pattern(tables: Tables, name: str, pattern: ca.Sparsity) -> None:
    """Writes a square sparse matrix, with an order of its elimination."""
    colind, row = pattern.colind(), pattern.row()
    order, diagonal = elimination_order(csc_matrix((np.ones(len(row)), row, colind), shape=pattern.shape))
    tables.pattern(name, colind, row, order.tolist(), diagonal.tolist())


def _line(tables: Tables, solution: SectionSolution | None) -> None:
    """rs_line."""
    if solution is None:
        tables.structure("rs_line", "line", {"spans": "0"})
        return
    fields = {name: str(size) for name, size in solution.sizes.items()}
    for name in LINE_INTEGERS:
        tables.integers(f"line_{name}", solution.numbers[name])
        fields[name] = f"rw_line_{name}"
    fields |= {name: f"rw_{name}" for name in LINE_NUMBERS}
    for name, kernels in zip(LINE_KERNELS, solution.kernels, strict=True):
        tables.kernels(f"line_{name}", [own for own, _ in kernels])
        fields[name] = f"rw_line_{name}"
    tables.structure("rs_line", "line", fields)
