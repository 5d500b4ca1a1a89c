"""A line in the compiled core: its tables, and its sections solved there (see `systems/native/sections.h`)."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ropeway.components.errors import CompiledError, EquilibriumError
from ropeway.systems.modelling.dae_model import Model, component_of, kept_with_model
from ropeway.systems.native.binary_cache import library, named_library
from ropeway.systems.native.c_library import address
from ropeway.systems.native.kernel_marks import kernel_mark
from ropeway.systems.native.kernel_source import kernel_source
from ropeway.systems.native.section_library import (
    FAILURES,
    LINE_INTEGERS,
    LINE_KERNELS,
    LINE_NUMBERS,
    LINE_SIZES,
    LinePoint,
    LineTables,
    section_library,
)
from ropeway.systems.solvers.condensed_newton import Cases
from ropeway.systems.solvers.line_sections import LineSections, SpanForm, SupportForm, line_sections
from ropeway.systems.solvers.points import Point


class CompiledLine:
    """The sections of a model, compiled. `tables` stays as it is: threads share it, each with a point of its own."""

    def __init__(self, model: Model, sections: LineSections) -> None:
        self.model, self.sections = model, sections
        self._kept: list[Any] = []  # arrays that the tables point to
        self.core = section_library()
        sizes, numbers = line_tables(model, sections)
        slots = sizes["slots"]
        self.tables = LineTables()
        for name, size in sizes.items():
            setattr(self.tables, name, size)
        for name in LINE_INTEGERS:
            self._keep(name, np.ascontiguousarray(numbers[name], dtype=np.int32))
        for name, nominals in zip(LINE_NUMBERS, (model.z.nominals, model.r.nominals), strict=True):
            self._keep(name, np.ascontiguousarray(nominals))
        kernels = (
            [_span_addresses(form, slots) for form in sections.forms],
            [_support_address(form) for form in sections.support_forms],
        )
        for name, addresses in zip(LINE_KERNELS, kernels, strict=True):
            self._keep(name, np.array(addresses or [0], dtype=np.uint64))
        self.work_size = int(self.core.rs_work_size(ctypes.byref(self.tables)))
        self.section_of, self.around = numbers["section_of"], numbers["around"]
        self._ends = [numbers[name].tolist() for name in ("first", "last", "first_span")]
        self._columns: dict[tuple[int, ...], np.ndarray] = {}

    def _keep(self, name: str, values: np.ndarray) -> None:
        self._kept.append(values)
        setattr(self.tables, name, values.ctypes.data)

    def columns(self, sections: tuple[int, ...]) -> np.ndarray:
        """The algebraic variables of some sections, in the order of `record_beside` in the core."""
        if sections not in self._columns:
            found = list[int]()
            for first, last, span in ((own[s] for own in self._ends) for s in sections):
                for k in range(first, last + 1):
                    force, travel = self.sections.force[span + k - first] if k < last else 0, self.sections.travel[k]
                    found += [*range(force, force + 3)] if k < last else []
                    found += [travel] if travel >= 0 else []
            self._columns[sections] = np.array(found, dtype=int)
        return self._columns[sections]

    def used(self, passed: Sequence[np.ndarray]) -> np.ndarray:
        """Loads in each span, from those passed at the supports of each run."""
        return np.concatenate([beyond[:-1] - beyond[1:] for beyond in passed]).astype(np.int64)

    def solve(self, solver: PointSolver, sections: Sequence[int] | None = None) -> None:
        """Solves some sections, or all, with their rates. Raises EquilibriumError."""
        tables, point = ctypes.byref(self.tables), ctypes.byref(solver.point)
        failed = 0
        if sections is None:
            failed = self.core.rs_solve_all(tables, point, 1)
        else:
            for section in sections:
                failed = failed or self.core.rs_solve(tables, point, section, 1)
        if failed:
            raise self.failure(failed, solver.point.worst)

    def solve_point(self, point: Point, passed: Sequence[np.ndarray]) -> None:
        """Solves a point in place. Raises EquilibriumError; the point is unchanged then."""
        start = point.z.copy()
        try:
            self.solve(PointSolver(self, point, self.used(passed), np.zeros(len(point.x)), np.zeros(len(point.u))))
        except EquilibriumError:
            point.z[:] = start
            raise

    def failure(self, code: int, worst: int) -> EquilibriumError:
        """The error of a solve that has failed."""
        name = self.model.r.names[worst]
        return EquilibriumError(
            f"{FAILURES[code]} (worst: {name})",
            "Check lengths, tensions and loads there, or start from a nearby equilibrium with start=",
            component_of(name),
        )

    def solve_cases(self, cases: Cases, used: np.ndarray) -> np.ndarray:
        """Solves many cases in place, `used` loads in each span (spans,), or in each case (cases, spans); returns which
        have converged."""
        count = cases.z.shape[1]
        good = np.zeros(count, dtype=np.uint8)
        if count == 0:
            return good.astype(bool)
        rows = [vector.T if _rows_follow(vector.T) else np.ascontiguousarray(vector.T) for vector in cases.vectors]
        before = cases.z.copy()
        x, z, u, p, d = (row[0] for row in rows)
        first = Point(x, z, u, p, d)
        solver = PointSolver(self, first, used, np.zeros(len(x)), np.zeros(len(u)))
        moves = [row.strides[0] // row.itemsize for row in (*rows, *([used] if used.ndim == 2 else []))]
        strides = np.array([*moves, 0][:6], dtype=np.int64)
        self.core.rs_solve_many(
            ctypes.byref(self.tables), ctypes.byref(solver.point), count, strides.ctypes.data, good.ctypes.data
        )
        found = good.astype(bool)
        if not _rows_follow(cases.z.T):
            cases.z[:] = rows[1].T
        cases.z[:, ~found] = before[:, ~found]
        return found


def _rows_follow(rows: np.ndarray) -> bool:
    """Whether each row is in one piece, as the compiled core reads it, at equal distances."""
    return rows.strides[1] == rows.itemsize


class CompiledCases:
    """The solver of many cases of a line with `used` loads in each span, as `CondensedNewton`."""

    def __init__(self, line: CompiledLine, used: np.ndarray) -> None:
        self.line, self.sections, self.used = line, line.sections, used.astype(np.int64)

    def solve(self, cases: Cases) -> np.ndarray:
        """Solves for `cases.z` in place; returns which cases have converged, (cases,): the others are unchanged."""
        return self.line.solve_cases(cases, self.used)


class PointSolver:
    """A point of a compiled line with its rates, and room to work: of one thread. `z_rate` (nz,) is found."""

    def __init__(
        self, line: CompiledLine, point: Point, used: np.ndarray, x_rate: np.ndarray, u_rate: np.ndarray
    ) -> None:
        self.used, self.x_rate, self.u_rate = used, np.array(x_rate), np.array(u_rate)
        self.z_rate, self._work = np.zeros(len(line.model.z)), np.zeros(line.work_size)
        self._vectors = point.vectors
        read = (*self._vectors, used, self.x_rate, self.u_rate, self.z_rate, self._work)
        self.point = LinePoint(*(vector.ctypes.data for vector in read))


@kept_with_model
def compiled_line(model: Model) -> CompiledLine:
    """The compiled core of a model. Raises CompiledError where it does not fit, CompilerError, WriteError."""
    sections = line_sections(model)
    if isinstance(sections, str):
        raise CompiledError(f"The compiled core cannot solve {model.name!r}: {sections}", "Leave out compiled=True")
    return CompiledLine(model, sections)


def line_tables(model: Model, sections: LineSections) -> tuple[dict[str, int], dict[str, np.ndarray]]:
    """The sizes of a line and its tables of integers, as rs_line has them."""
    counts = np.concatenate([layout.slots.count for layout in model.layouts])
    numbers = {**_by_span(sections, counts), **_by_support(model, sections), **_by_section(sections)}
    vectors = (len(table) for table in (model.x, model.z, model.u, model.p))
    spans, supports = len(sections.form), len(sections.travel)
    own = (spans, supports, len(numbers["first"]), int(counts.max(initial=0)))
    sizes = (*own, *vectors, len(sections.shared), len(model.runs))
    return dict(zip(LINE_SIZES, sizes, strict=True)), numbers


def slots_of_kernel(used: int) -> int:
    """Slots of the kernel for so many loads in a span: above 8 those of multiples of 8 serve, with empty slots."""
    return used if used <= 8 else (used + 7) // 8 * 8


def _by_span(sections: LineSections, counts: np.ndarray) -> dict[str, np.ndarray]:
    names = ("form", "parameters", "force", "closure", "mass", "at", "ride", "drag", "empty", "length_start", "start")
    return {
        **{name: getattr(sections, name) for name in names},
        "count": counts,
        "shared": sections.shared,
        "on_idlers": np.concatenate(
            [
                np.full(len(run.spans), any(node.balance is not None for node in run.nodes))
                for run in sections.model.runs
            ]
        ),
        "form_parameters": np.array([form.parameters for form in sections.forms]),
    }


def _by_support(model: Model, sections: LineSections) -> dict[str, np.ndarray]:
    sizes = [len(run.nodes) for run in model.runs]
    first = np.concatenate([[0], np.cumsum(sizes)])
    free_end = np.zeros(int(first[-1]), dtype=int)
    for k in (*first[:-1], *(first[1:] - 1)):
        free_end[k] = sections.travel[k] >= 0
    names = ("state", "travel", "balance", "support_form", "support_parameters", "support_discrete", "speed")
    return {
        **{name: getattr(sections, name) for name in names},
        "point": sections.point.ravel(),
        "support_form_parameters": np.array([form.parameters for form in sections.support_forms] or [0]),
        "support_form_discrete": np.array([form.discrete for form in sections.support_forms] or [0]),
        "run_of": np.repeat(np.arange(len(sizes)), sizes),
        "held": np.concatenate([layout.held for layout in model.layouts]),
        "free_end": free_end,
        "run_first": first,
        "around": np.array([run.around > 0 for run in model.runs]),
        "fed": np.array([run.feed is not None and not run.around for run in model.runs]),
    }


def _by_section(sections: LineSections) -> dict[str, np.ndarray]:
    """A section ends at each support whose travel is no unknown, and at the end of its run."""
    first, last, first_span, section_of = list[int](), list[int](), list[int](), list[int]()
    for i, k in enumerate(sections.start.tolist()):
        goes_on = i > 0 and sections.start[i - 1] == k - 1 and sections.travel[k] >= 0
        if goes_on:
            last[-1] = k + 1
        else:
            first.append(k)
            last.append(k + 1)
            first_span.append(i)
        section_of.append(len(first) - 1)
    return {
        "first": np.array(first),
        "last": np.array(last),
        "first_span": np.array(first_span),
        "section_of": np.array(section_of),
    }


def _span_addresses(form: SpanForm, most: int) -> list[int]:
    """Where the kernels for 0 to `most` used slots are (see `slots_of_kernel`)."""
    found = list[int]()
    for first in (0, 3, 6):
        if first <= most:
            found += _compiled(form, (first, first + 1, first + 2))
    for slots in range(16, most + 8, 8):
        found += _compiled(form, (slots,)) * 8
    return found[: most + 1]


@lru_cache(maxsize=64)
def _compiled(form: SpanForm, slots: tuple[int, ...]) -> list[int]:
    mark = kernel_mark("span", form.key, form.weather, slots)
    return addresses_of(mark, len(slots), lambda: [form.kernel(n) for n in slots])


@lru_cache(maxsize=64)
def _support_address(form: SupportForm) -> int:
    return addresses_of(kernel_mark("support", form.key), 1, lambda: [form.kernel])[0]


def addresses_of(mark: str | None, count: int, kernels: Callable[[], Sequence[ca.Function]]) -> list[int]:
    """Where so many kernels are, compiled to one library; they are made only where `mark` does not find them in the
    cache."""
    names = [f"kernel_{i}" for i in range(count)]

    def files() -> dict[str, str]:
        return {f"{name}.c": kernel_source(kernel, name) for name, kernel in zip(names, kernels(), strict=True)}

    found = library(files()) if mark is None else named_library(mark, files)
    return [address(found, name) for name in names]
