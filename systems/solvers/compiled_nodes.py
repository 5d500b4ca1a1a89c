"""Drives and responses of a line in the compiled core: their tables (see `systems/native/drives.h` and `clocks.h`).

The tables stay as they are, threads share them; what a run changes is in arrays of its own.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np

from ropeway.components.node import Node
from ropeway.components.variable import Kind
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.modelling.sampled_control import discrete_places
from ropeway.systems.native.kernel_marks import kernel_mark
from ropeway.systems.native.section_library import ClockTables, DriveTables
from ropeway.systems.solvers.compiled_line import addresses_of, compiled_line
from ropeway.systems.solvers.drive_trajectories import DERIVATIVE, NODES, WEIGHTS
from ropeway.systems.solvers.driven_nodes import NodeForm, NodePlaces, drive_kernel, node_places, response_kernel
from ropeway.systems.solvers.line_sections import UnfitError


class Filled:
    """A structure with the arrays that its pointers point to."""

    def __init__(self, tables: ctypes.Structure, arrays: Mapping[str, np.ndarray]) -> None:
        self.tables = tables
        self.arrays = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
        for name, array in self.arrays.items():
            setattr(tables, name, array.ctypes.data)

    @property
    def address(self) -> Any:
        """Where the structure is."""
        return ctypes.byref(self.tables)


class CompiledDrives:
    """The nodes of a model that have states. Raises UnfitError where they do not move by themselves."""

    def __init__(self, model: Model) -> None:
        self._model = model
        if model.system.supplies:
            raise UnfitError("drives share a source")
        places = node_places(model)
        nodes = [node for node in _nodes(model) if any(v.kind is Kind.STATE for v in places.form(node).variables)]
        tables = _NodeTables(places, nodes, [places.form(node) for node in nodes])
        if int((tables.sizes[0][tables.form]).sum()) != len(model.x):
            raise UnfitError("a component beside its ropes has states")
        kernels = [_drive_address(form) for form in tables.forms]
        self.most = max((form.sizes[0] for form in tables.forms), default=1)
        self._drives = len(nodes)
        self._arrays = {
            **tables.arrays,
            "tied": np.array([tied for _, tied in kernels], dtype=np.int32),
            "kernels": np.array([address for address, _ in kernels] or [0], dtype=np.uint64),
            "nominal": model.x.nominals,
            "nodes": NODES,
            "weights": WEIGHTS,
            "derivative": DERIVATIVE,
        }

    def filled(self) -> Filled:
        """The tables, with arrays for one run."""
        line = compiled_line(self._model)
        empty = np.zeros((len(NODES), len(self._model.x)))
        none = np.zeros(self._drives, dtype=np.int32)
        arrays = {**self._arrays, "window": empty, "rates": empty.copy(), "limited": none}
        found = Filled(DriveTables(drives=self._drives, most=self.most), arrays)
        size = line.core.rs_drives_size(ctypes.byref(line.tables), found.address)
        return Filled(found.tables, {**arrays, "work": np.zeros(int(size))})


class CompiledClocks:
    """The clocks of a model. Raises UnfitError where a response has no kernel. `names`: the node of each member."""

    def __init__(self, model: Model) -> None:
        components, index = model.system.components, model.d.index
        self.names = [name for clock in model.clocks for name in clock.members]
        found, own = node_places(model), [components[name] for name in self.names]
        nodes = [node for node in own if isinstance(node, Node)]
        tables = _NodeTables(found, nodes, [found.responding(node) for node in nodes])
        rules = [response_kernel(form) for form in tables.forms]
        places = [
            [
                place
                for variable, size in rules[form].names
                for place in discrete_places(f"{name}.{variable}", size, index)
            ]
            for name, form in zip(self.names, tables.form.tolist(), strict=True)
        ]
        waiting = [
            index.get(f"{name}.response_waiting[1]", index.get(f"{name}.response_waiting", 0)) for name in self.names
        ]
        first = np.cumsum([0, *(len(clock.members) for clock in model.clocks)])
        rivals = [
            [(start + j, by_need) for j, by_need in own]
            for clock, start in zip(model.clocks, first.tolist(), strict=False)
            for own in (clock.rivals or ((),) * len(clock.members))
        ]
        flat = [rival for own in rivals for rival in own]
        values = [sum(size for _, size in rule.names) for rule in rules]
        most = 2 + 2 * max(values, default=0)
        inputs = (
            1
            + len(compiled_line(model).sections.shared)
            + max((sum(form.sizes) + 3 * len(form.node.ports) for form in tables.forms), default=0)
        )
        self._sizes = len(model.clocks), most, len(self.names), inputs
        self._arrays = {
            **tables.arrays,
            "period": np.array([clock.period for clock in model.clocks]),
            "first": first.astype(np.int32),
            "effect": np.array([not clock.rivals for clock in model.clocks], dtype=np.int32),
            "values": np.array(values, dtype=np.int32),
            "correction": np.array([index[f"{name}.correction"] for name in self.names], dtype=np.int32),
            "waiting": np.array(waiting, dtype=np.int32),
            "place_first": np.cumsum([0, *map(len, places)]).astype(np.int32),
            "place": np.array([place for own in places for place in own], dtype=np.int32),
            "rival_first": np.cumsum([0, *map(len, rivals)]).astype(np.int32),
            "rival": np.array([j for j, _ in flat], dtype=np.int32),
            "by_need": np.array([by_need for _, by_need in flat], dtype=np.int32),
            "kernels": np.array([_response_address(form) for form in tables.forms] or [0], dtype=np.uint64),
        }

    def filled(self, begin: np.ndarray, ticks: np.ndarray) -> Filled:
        """The tables, with arrays for one run: `begin` (clocks,) [s] the first tick of each clock, `ticks` how often it
        has ticked."""
        clocks, most, members, inputs = self._sizes
        work = {"results": np.zeros((members, most)), "changed": np.zeros(members), "work": np.zeros(inputs)}
        arrays = {**self._arrays, "begin": begin, "ticks": ticks.astype(np.int64), **work}
        return Filled(ClockTables(clocks=clocks, most=most), arrays)


def no_clocks() -> Filled:
    """Tables without a clock."""
    return Filled(ClockTables(clocks=0, most=2), {})


_Made = TypeVar("_Made")


@kept_with_model
def compiled_drives(model: Model) -> CompiledDrives | None:
    """The drives of a model in the core; None where they do not fit."""
    return _unless_unfit(CompiledDrives, model)


@kept_with_model
def compiled_clocks(model: Model) -> CompiledClocks | None:
    """The clocks of a model in the core; None where they do not fit."""
    return _unless_unfit(CompiledClocks, model)


def _unless_unfit(make: Callable[[Model], _Made], model: Model) -> _Made | None:
    try:
        return make(model)
    except UnfitError:
        return None


def _nodes(model: Model) -> list[Node]:
    """The nodes of all runs, each once."""
    return list({node.name: node for run in model.runs for node in run.nodes}.values())


class _NodeTables:
    """Tables of some nodes: their forms, the number of each one's form, and `arrays` of their places and sizes."""

    def __init__(self, places: NodePlaces, nodes: Sequence[Node], forms: Sequence[NodeForm]) -> None:
        known: dict[NodeForm, int] = {}
        self.form = np.array([known.setdefault(form, len(known)) for form in forms], dtype=np.int32)
        self.forms = list(known)
        rows = np.array([places.places(node) for node in nodes], dtype=np.int32).reshape(-1, 4)
        self.sizes = np.array([form.sizes for form in self.forms], dtype=np.int32).reshape(-1, 4).T
        ports = [places.ports(node) for node in nodes]
        flat = [port for own in ports for port in own]
        self.arrays: dict[str, np.ndarray] = {
            "form": self.form,
            **dict(zip("xupd", rows.T, strict=True)),
            **dict(zip(("states", "inputs", "parameters", "discrete"), self.sizes, strict=True)),
            "ports": np.array([len(form.node.ports) for form in self.forms], dtype=np.int32),
            "port_first": np.cumsum([0, *map(len, ports)]).astype(np.int32),
            "port_span": np.array([span for span, _ in flat], dtype=np.int32),
            "port_end": np.array([end for _, end in flat], dtype=np.int32),
        }


@lru_cache(maxsize=64)
def _drive_address(form: NodeForm) -> tuple[int, bool]:
    """Where the kernel of a drive is, and whether forces can change its rates. Raises UnfitError."""
    kernel, tied = drive_kernel(form)
    return addresses_of(None, 1, lambda: [kernel])[0], tied


@lru_cache(maxsize=64)
def _response_address(form: NodeForm) -> int:
    """Where the kernel of a response is. Raises UnfitError."""
    return addresses_of(kernel_mark("response", form.key, form.weather), 1, lambda: [response_kernel(form).kernel])[0]
