"""The equilibrium of a line as a function of its parameters, for thousands of variants.

Variants whose loads stay in their spans are solved in batches (`statics.variants`), the others one by one.
"""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ropeway.components.errors import EquilibriumError, InputError
from ropeway.components.variable import Kind
from ropeway.systems.interrupts import stop_if_interrupted
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.solvers.array_outputs import has_groups, outputs_of_rows
from ropeway.systems.solvers.compiled_rows import compiled_outputs
from ropeway.systems.solvers.state_rows import StateRows
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium, require_compiled
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.settling import solve
from ropeway.systems.statics.stability import slack
from ropeway.systems.statics.variants import LineVariants, line_variants
from ropeway.systems.studies.sweeps.found_rows import NumberRows


@dataclass(frozen=True)
class LineStudy:
    """Called with parameters of a line by name, returns `outputs` of its equilibrium. `declared`: the line as bytes,
    which workers receive, and by which they find a model that they have assembled before; `compiled`: solved in the
    compiled core."""

    declared: bytes
    outputs: tuple[str, ...]
    compiled: bool = False

    def __call__(self, **parameters: float) -> dict[str, float]:
        """Outputs by name. Raises InputError, EquilibriumError."""
        found = self.at(parameters)
        place, values = found.model.y.index, found.outputs.tolist()
        return {name: values[place[name]] if name in place else found[name] for name in self.outputs}

    def at(self, parameters: dict[str, float]) -> Equilibrium:
        """The equilibrium with other parameters. Raises InputError, EquilibriumError."""
        model, start = _prepared(self.declared)
        return _variant(model, start, parameters, compiled=self.compiled)

    def _outputs(self, model: Model, rows: StateRows, which: np.ndarray) -> np.ndarray:
        """Outputs at `which` places (cases, outputs); their bits do not depend on the number of cases."""
        if not (self.compiled and has_groups(model)):
            return outputs_of_rows(model, rows, which, few=0)
        found = np.empty((len(rows), len(which)))
        compiled_outputs(model, which.tobytes()).write(rows, found)
        return found

    def rows(self, names: Sequence[str], values: np.ndarray) -> NumberRows:
        """Outputs of many variants, for values (cases, parameters) of the parameters `names`."""
        found, failures = np.full((len(values), len(self.outputs)), np.nan), dict[int, tuple[str, str]]()
        left = list(range(len(values)))
        model, start = _prepared(self.declared)
        many = _many(self.declared, tuple(names), self.compiled)
        if many is not None and start is not None:
            good, rows = many.solve(values)
            rest = LineState(model, start.point, start.runs, start.passed)
            slots = [rest.find(name) for name in self.outputs]
            shown = [i for i, (kind, _) in enumerate(slots) if kind is Kind.OUTPUT]
            found[:, shown] = self._outputs(model, rows, np.array([slots[i][1] for i in shown], dtype=int))
            for i, (kind, k) in enumerate(slots):
                if kind is not Kind.OUTPUT:
                    found[:, i] = rows.columns.vector(kind)[k]
            left = np.flatnonzero(~good).tolist()
        for i in left:
            stop_if_interrupted()
            try:
                one = self(**dict(zip(names, values[i].tolist(), strict=True)))
                found[i] = [one[name] for name in self.outputs]
            except Exception as error:  # noqa: BLE001  # a case that fails is a row
                found[i] = np.nan
                failures[i] = (type(error).__name__, str(error))
        return NumberRows(self.outputs, found, failures)


def line_study(
    model: Model, parameters: Sequence[str], outputs: Sequence[str] | None, *, compiled: bool = False
) -> LineStudy:
    """The study of a line; `outputs` by default all but those of the load slots, and the parameters. Raises
    UnknownNameError, InputError for a parameter or an output that it does not have."""
    state = LineState.cold(model)
    known = [name for name in model.y.names if name not in model.y.hidden and name not in parameters]
    names = known if outputs is None else list(outputs)
    for name in names:
        if name in parameters:
            raise InputError(f"{name} is a parameter and an output", "Leave it out of the outputs")
        state.find(name)
    state.set(dict.fromkeys(parameters, 1.0))  # only the names count here: any quantity can be 1
    if compiled:
        require_compiled(model)
    return LineStudy(pickle.dumps(model.system), tuple(names), compiled)


def line_units(model: Model, names: Sequence[str]) -> dict[str, str]:
    """Units of parameters and outputs."""
    state = LineState.cold(model)
    masses = {f"{load}.mass" for run in state.runs for load in run.loads.names}
    slots = {name: state.find(model.swaps.get(name, name)) for name in names if name not in masses}
    return {name: "kg" if name in masses else model.tables[slots[name][0]].units[slots[name][1]] for name in names}


def line_unit(model: Model, name: str) -> str:
    """Unit of a parameter. Raises UnknownNameError."""
    return line_units(model, [name])[name]


def line_mark(model: Model, study: LineStudy) -> bytes:
    """Identifies the study of a line: names and values of its variables, and the outputs."""
    tables = [(kind.value, table.names, table.values.tolist()) for kind, table in model.tables.items()]
    loads = [(run.loads.names, run.loads.mass.tolist(), run.loads.place.tolist()) for run in model.runs]
    return repr((tables, loads, study.outputs)).encode()


@lru_cache(maxsize=4)
def _prepared(declared: bytes) -> tuple[Model, Equilibrium | None]:
    """The assembled line, and the start of its variants: its own equilibrium, if it has one. Its travels count from the
    lengths that were declared, as those of the variants must."""
    state = LineState.cold(assemble(pickle.loads(declared)))
    try:
        solve(state)
    except EquilibriumError:
        return state.model, None
    return state.model, Equilibrium(state.model, state.point, tuple(state.runs), tuple(state.passed), state.held)


@lru_cache(maxsize=4)
def _many(declared: bytes, names: tuple[str, ...], compiled: bool) -> LineVariants | None:
    """The solver of many variants; None where they are solved one by one."""
    model, start = _prepared(declared)
    if start is None:
        return None
    return line_variants(LineState(model, start.point, start.runs, start.passed), names, compiled=compiled)


def _variant(model: Model, start: Equilibrium | None, parameters: dict[str, float], *, compiled: bool) -> Equilibrium:
    """The equilibrium with other parameters. It does not depend on the start: where it could, the line is solved from
    geometry. Raises InputError, EquilibriumError."""
    if start is not None:
        with suppress(EquilibriumError):
            found = equilibrium(model, start=start, parameters=parameters, compiled=compiled)
            if not slack(LineState(found.model, found.point, found.runs, found.passed)):
                return found
    return equilibrium(model, parameters=parameters, compiled=compiled)
