"""States of a compiled line as rows: loads in their spans, and outputs, in the compiled core (see `native/rows.c`)."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import lru_cache

import casadi as ca
import numpy as np

from ropeway.components.weather import Weather
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.rope_path import Run
from ropeway.systems.native.c_library import CallTables
from ropeway.systems.native.kernel_marks import kernel_mark
from ropeway.systems.native.section_library import Motion, OutputCalls, section_library
from ropeway.systems.solvers.array_outputs import FORCE, Form, Group, output_function, output_groups
from ropeway.systems.solvers.compiled_line import PointSolver, addresses_of, compiled_line
from ropeway.systems.solvers.compiled_nodes import Filled
from ropeway.systems.solvers.condensed_newton import Cases
from ropeway.systems.solvers.line_sections import shared_count
from ropeway.systems.solvers.points import Point
from ropeway.systems.solvers.state_rows import StateRows


def load_tables(model: Model, runs: Sequence[Run], p: np.ndarray) -> dict[str, np.ndarray]:
    """The lists of loads of some runs, and the rope at their supports at zero travel, as the core reads them."""
    loads = [run.loads for run in runs]
    return {
        "load_first": np.cumsum([0, *(len(own.place) for own in loads)], dtype=np.int64),
        "place": np.concatenate([own.place for own in loads]),
        "mass": np.concatenate([own.mass for own in loads]),
        "drag": np.concatenate([own.drag for own in loads]),
        "rope": np.concatenate([layout.start(p) for layout in model.layouts]),
    }


class SlotWriter:
    """Writes the loads of some runs into the slots of states. No load is pinned, and all have a slot."""

    def __init__(self, model: Model, runs: Sequence[Run], p: np.ndarray) -> None:
        line, empty = compiled_line(model), np.zeros(0)
        self._motion = Filled(Motion(), load_tables(model, runs, p))
        point = Point(empty, empty, empty, p, empty)
        self._solver = PointSolver(line, point, np.zeros(len(line.section_of), np.int64), empty, empty)
        self._tables, self._call = line.tables, line.core.rs_write_rows

    def write(self, d: np.ndarray, passed: np.ndarray) -> None:
        """Writes into the discrete variables `d` (states, nd), which may be a part of rows; `passed`: loads that have
        passed the supports of all runs, (states, supports)."""
        beyond, stride = np.ascontiguousarray(passed, dtype=np.int64), d.strides[0] // d.itemsize
        tables, where = ctypes.byref(self._tables), ctypes.byref(self._solver.point)
        self._call(tables, where, self._motion.address, d.ctypes.data, stride, beyond.ctypes.data, len(d))


def solve_rows(model: Model, rows: StateRows, which: np.ndarray) -> np.ndarray:
    """Solves the states `which` in place; returns those that are not solved, which are unchanged."""
    some = rows.some(which)
    used = np.hstack([beyond[:, :-1] - beyond[:, 1:] for beyond in some.passed]).astype(np.int64)
    good = compiled_line(model).solve_cases(Cases(*some.columns.vectors), np.ascontiguousarray(used))
    rows.z[which[good]] = some.z[good]
    return which[~good]


class CompiledOutputs:
    """The outputs of a model at `which` places, in compiled code."""

    def __init__(self, model: Model, which: np.ndarray) -> None:
        self._plan = plan = output_groups(model)
        self._core = section_library()
        place = np.full(len(model.y), -1)
        place[which] = np.arange(len(which))
        vectors = plan.none + 1
        self._none = vectors + 1  # what no rope gives, behind the time
        self._pull = np.full(plan.ends + 1, self._none)
        """Of each rope end the first place of what it gives."""
        row, size = np.zeros(len(which), dtype=np.int32), self._none + plan.force
        inputs, first, kernels = list[np.ndarray](), list[np.ndarray](), list[int]()
        for group in plan.groups:
            rows, count = place[group.outputs], group.own.shape[1]
            chosen = np.flatnonzero((rows >= 0).any(axis=1))
            results = len(chosen) + plan.force * len(group.ports) * group.ropes
            own = size + results * np.arange(count)
            size += results * count
            for k, some in enumerate(rows[chosen]):
                row[some[some >= 0]] = own[some >= 0] + k
            for k, port in enumerate(group.ports if group.ropes else ()):
                self._pull[port[1]] = own + len(chosen) + plan.force * k
            reads = np.vstack(
                [self._shared(group, vectors), group.own, *(self._port(port, group) for port in group.ports)]
            )
            inputs += list(reads.T)
            first.append(own)
            kernels += [_address(group.form, tuple(chosen.tolist()), group.ropes)] * count
        self._size = size + max((len(own) for own in inputs), default=0)
        self._called = Filled(
            CallTables(calls=len(kernels), values=size),
            {
                "result": np.concatenate([*first, [0]]).astype(np.int32),
                "inputs_end": np.cumsum([len(own) for own in inputs]).astype(np.int32),
                "input": np.concatenate([*inputs, [0]]).astype(np.int32),
                "kernels": np.array(kernels or [0], dtype=np.uint64),
            },
        )
        outputs = OutputCalls(calls=self._called.tables, vectors=vectors, outputs=len(which))
        self._calls = Filled(outputs, {"row": row})

    def _shared(self, group: Group, time: int) -> np.ndarray:
        """Places of the time, and of what all components read, for the components of a group."""
        return np.repeat(np.array([[time], *([i] for i in self._plan.shared)]), group.own.shape[1], axis=1)

    def _pulls(self, ends: np.ndarray) -> np.ndarray:
        """Places of what some rope ends give to their seats."""
        return np.asarray(self._pull[ends] + np.arange(self._plan.force)[:, None])

    def _port(self, port: tuple[np.ndarray, ...], group: Group) -> np.ndarray:
        """Places of what the components of a group read at a port."""
        return port[0] if group.ropes else np.vstack([self._pulls(port[0]), port[1]])

    def write(self, rows: StateRows, to: np.ndarray) -> None:
        """Writes the outputs of states into `to` (states, outputs), which may be a part of rows."""
        work = np.zeros(self._size)
        work[self._none + FORCE : self._none + self._plan.force] = 1.0
        time = np.ascontiguousarray(rows.time)
        read, written = (array.strides[0] // array.itemsize for array in (rows.values, to))
        call, first, room = self._core.rs_outputs, rows.values.ctypes.data, work.ctypes.data
        call(self._calls.address, first, read, time.ctypes.data, len(rows), room, to.ctypes.data, written)


@lru_cache(maxsize=256)
def _address(form: Form, outputs: tuple[int, ...], ropes: bool) -> int:
    """Where the kernel of some outputs of components of a form is."""
    kinds = tuple(v.kind for v in form.variables)
    mark = kernel_mark("outputs", form.key, form.weather, kinds, outputs, ropes)
    return addresses_of(mark, 1, lambda: [_kernel(form, outputs, ropes)])[0]


def _kernel(form: Form, outputs: tuple[int, ...], ropes: bool) -> ca.Function:
    function = output_function(form, outputs)
    time, _, own, *ports = (ca.SX.sym(function.name_in(i), function.size1_in(i)) for i in range(function.n_in()))
    shared = ca.SX.sym("shared", shared_count(weather=form.weather))
    read, given = list[ca.SX](), list[ca.SX]()
    for port in ports:
        if not ropes:
            read.append(port)
            given.append(port)
            continue
        place = ca.SX.sym("place", 7)  # position, travel, and what lies aside: x, z, rope
        x, y, z, travel, aside_x, aside_z, aside_rope = ca.vertsplit(place)
        read.append(place)
        given.append(ca.vertcat(x + aside_x, y, z + aside_z, travel + aside_rope))
    values = ca.vertsplit(shared)
    known = ca.vertcat(values[0], *(Weather.of(values[1:]) if form.weather else ()))
    result = function.call([time, known, own, *given])[0]
    return ca.Function("outputs", [ca.vertcat(time, shared, own, *read)], [ca.densify(result)])


@kept_with_model
def compiled_outputs(model: Model, which: bytes) -> CompiledOutputs:
    """The outputs of a model at `which` places."""
    return CompiledOutputs(model, np.frombuffer(which, dtype=int))
