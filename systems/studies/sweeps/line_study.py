"""The equilibrium of a line as a function of its parameters, for thousands of variants."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache

from ropeway.components.errors import EquilibriumError, InputError
from ropeway.systems.modelling.assembly import assemble
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.statics.line_state import LineState
from ropeway.systems.statics.settling import solve
from ropeway.systems.statics.stability import slack


@dataclass(frozen=True)
class LineStudy:
    """Called with parameters of a line by name, returns `outputs` of its equilibrium. `declared`: the line as bytes,
    which workers receive, and by which they find a model that they have assembled before."""

    declared: bytes
    outputs: tuple[str, ...]

    def __call__(self, **parameters: float) -> dict[str, float]:
        """Outputs by name. Raises InputError, EquilibriumError."""
        model, start = _prepared(self.declared)
        found = _variant(model, start, parameters)
        place, values = found.model.y.index, found.outputs.tolist()
        return {name: values[place[name]] if name in place else found[name] for name in self.outputs}


def line_study(model: Model, parameters: Sequence[str], outputs: Sequence[str] | None) -> LineStudy:
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
    return LineStudy(pickle.dumps(model.system), tuple(names))


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


def _variant(model: Model, start: Equilibrium | None, parameters: dict[str, float]) -> Equilibrium:
    """The equilibrium with other parameters. It does not depend on the start: where it could, the line is solved from
    geometry. Raises InputError, EquilibriumError."""
    if start is not None:
        with suppress(EquilibriumError):
            found = equilibrium(model, start=start, parameters=parameters)
            if not slack(LineState(found.model, found.point, found.runs, found.passed)):
                return found
    return equilibrium(model, parameters=parameters)
