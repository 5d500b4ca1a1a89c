"""A model with inertia in the compiled core: its points and how they move (see `systems/native/inertial.h`)."""

from __future__ import annotations

import ctypes

import numpy as np

from ropeway.components.errors import CompiledError
from ropeway.systems.modelling.dae_model import Model, kept_with_model
from ropeway.systems.native.inertial_library import (
    INTEGERS,
    KERNELS,
    NUMBERS,
    SystemPoint,
    SystemRun,
    SystemTables,
    inertial_library,
)
from ropeway.systems.solvers.kernels.inertial_tables import tables_of
from ropeway.systems.solvers.line_sections import UnfitError
from ropeway.systems.solvers.points import Point

_TRACED, _STEPS = 200_000, (16, 200)
"""Numbers that a point keeps of how it has moved, and least and largest number of steps."""


class InertialCore:
    """The compiled equations of a model. `tables` stays as it is: each thread has a point of its own."""

    def __init__(self, model: Model) -> None:
        found = tables_of(model)
        self.model, self.core, self.tables, self.room = model, inertial_library(), SystemTables(), found.room
        self._kept: list[np.ndarray] = []
        for name, size in found.sizes.items():
            setattr(self.tables, name, size)
        for name in INTEGERS:
            self._keep(name, found.integers[name])
        for name in NUMBERS:
            self._keep(name, np.ascontiguousarray(found.numbers[name], dtype=float))
        for name in KERNELS:
            self._keep(name, np.array([form.addresses[name] for form in found.kernels], dtype=np.uint64))

    def _keep(self, name: str, values: np.ndarray) -> None:
        self._kept.append(values)
        setattr(self.tables, name, values.ctypes.data)


@kept_with_model
def inertial_core(model: Model) -> InertialCore:
    """The compiled core of a model with inertia. Raises CompilerError, WriteError, CompiledError where it does not
    fit."""
    try:
        return InertialCore(model)
    except UnfitError as reason:
        cause = f"The compiled core cannot simulate {model.name!r}: {reason}"
        raise CompiledError(cause, "Leave out compiled=True") from reason


class CorePoint:
    """A point of a model in the core, and its rates `x_rate` (nx,) and `z_rate` (nz,) [per s], which the core finds.
    `trace` has a row for the start and the end of each step of the last move: time, states, algebraic variables, and
    rates of the states."""

    def __init__(self, core: InertialCore) -> None:
        self.core, model = core, core.model
        self.x_rate, self.z_rate, self.u_rate = (np.zeros(len(table)) for table in (model.x, model.z, model.u))
        self.point = SystemPoint(step=-1.0)
        room = {name: np.zeros(max(n, 1), np.int32 if name == "pivot" else float) for name, n in core.room.items()}
        rates = {"x_rate": self.x_rate, "z_rate": self.z_rate, "u_rate": self.u_rate}
        self._room = list(room.values())
        width = 1 + 2 * len(model.x) + len(model.z)
        self.trace = np.zeros((int(np.clip(_TRACED // width, *_STEPS)), width))
        for name, array in {**rates, **room}.items():
            setattr(self.point, name, array.ctypes.data)

    def put(self, point: Point, u_rate: np.ndarray) -> None:
        """Sets the point, which the core changes in place, and the rates of its inputs."""
        self._vectors = point.vectors
        for name, array in zip("xzupd", self._vectors, strict=True):
            setattr(self.point, name, array.ctypes.data)
        self.u_rate[:] = u_rate

    def solve(self) -> int:
        """Solves the algebraic variables in place, with all rates; returns 0, or why it failed."""
        return int(self.core.core.ri_solve(ctypes.byref(self.core.tables), ctypes.byref(self.point)))

    def move(self, run: SystemRun) -> int:
        """Moves the point in place; returns 0, or why it failed."""
        address = (ctypes.byref(part) for part in (self.core.tables, self.point, run))
        return int(self.core.core.ri_move(*address))
