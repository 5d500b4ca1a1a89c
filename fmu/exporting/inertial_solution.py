"""A system with inertia in an FMU: kernels of its components and their tables, and those of its loads near supports."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ropeway.systems.dynamics.inertia import inertial_state as slots, support_zones as zones
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.native.c_tables import Tables
from ropeway.systems.native.inertial_library import INTEGERS, KERNELS, NUMBERS
from ropeway.systems.solvers.kernels.inertial_tables import tables_of

_DISTANCES = {
    "PAST": zones.PAST,
    "NEAR": zones.NEAR,
    "BEYOND": zones.BEYOND,
    "EARLY": zones.EARLY,
    "JOINED": slots.JOINED,
}
"""How events of loads near supports are located, by their names in ropeway_zones.c."""
_ROOM = ("y", "value", "kernel", "dense", "pivot", "band", "room")
"""What a point of the core needs room for."""


class InertialSolution:
    """A model with inertia in the compiled core. Raises UnfitError where it does not fit."""

    def __init__(self, model: Model) -> None:
        self.tables = tables_of(model)

    @cached_property
    def sources(self) -> dict[str, str]:
        """A file in C for each kernel."""
        kernels = [kernel for form in self.tables.kernels for kernel in form.sources.values()]
        return {f"{name}.c": text for name, text in kernels}


def fill_inertial(tables: Tables, solution: InertialSolution | None, model: Model) -> None:
    """Writes the tables of a system with inertia, or empty ones."""
    tables.size("INERTIAL", int(solution is not None))
    for name in _ROOM:
        tables.size(f"CORE_{name.upper()}", max(1, 1 if solution is None else solution.tables.room[name]))
    _core(tables, solution)
    _slots(tables, model)
    tables.size("ZONE", 0.0 if model.inertia is None else model.inertia.zone)
    for name, distance in _DISTANCES.items():
        tables.size(f"ZONE_{name}", distance)


def _core(tables: Tables, solution: InertialSolution | None) -> None:
    """ri_line."""
    if solution is None:
        tables.structure("ri_line", "core", {"nx": "0"})
        return
    found = solution.tables
    fields = {name: str(size) for name, size in found.sizes.items()}
    for name in INTEGERS:
        tables.integers(f"core_{name}", found.integers[name])
    for name in NUMBERS:
        tables.numbers(f"core_{name}", found.numbers[name])
    for name in KERNELS:
        tables.kernels(f"core_{name}", [form.sources[name][0] for form in found.kernels])
    fields |= {name: f"rw_core_{name}" for name in (*INTEGERS, *NUMBERS, *KERNELS)}
    tables.structure("ri_line", "core", fields)


def _slots(tables: Tables, model: Model) -> None:
    """Places of the slots' motion in the vectors: of each support those of the span after it."""
    names = ("place", "velocity", "pull", "acceleration", "station", "tied", "joined", "lost")
    cells: dict[str, list[int]] = {name: [] for name in names}
    parameters: dict[str, list[int]] = {"mass_per_length": [], "damping": []}
    most, count = 0, 0
    for r, (run, layout) in enumerate(zip(model.runs, model.layouts, strict=True)):
        most, count = max(most, *layout.slots.count), count + int(layout.slots.count.sum()) + 2
        motion, stations = slots.slot_motions(model)[r], slots.slot_outputs(model, r)
        for name, own in cells.items():
            found = np.atleast_2d(stations if name == "station" else getattr(motion, name))
            own += [*found.T.ravel().tolist(), *[0] * len(found)]  # the last support of a run has no span
        for name, own in parameters.items():
            own += [*(model.p.index.get(f"{span.name}.{name}", 0) for span in run.spans), 0]
    for name, own in cells.items():
        tables.integers(f"slot_{name}", own)
    for name, own in parameters.items():
        tables.integers(name, own)
    tables.size("SLOTS", int(most))
    tables.size("NTH", 2 * count + 1)
