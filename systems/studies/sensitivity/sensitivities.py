"""Exact derivatives of results, as newtons per kilogram, per metre of support height, per newton of pretension.

At rest they follow from the equations by implicit differentiation; along a simulation from the linearised
equations (`forward_sensitivity`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.components.variable import Kind
from ropeway.systems.dynamics.result import Result
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.results.column_labels import Labels
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import still
from ropeway.systems.statics.line_state import find
from ropeway.systems.studies.sensitivity.forward_sensitivity import ForwardSensitivity
from ropeway.systems.studies.sensitivity.linearisation import tangent_of
from ropeway.systems.studies.sensitivity.perturbations import Varied


@checked
@interruptible
def sensitivities(solution: Equilibrium | Result, *, of: str | Sequence[str], to: str | Sequence[str]) -> pd.DataFrame:
    """Exact derivatives of results by parameters.

    All else is held, unstretched lengths too; loads stay at their places on the rope. Along a simulation travel counts
    from the start, an input that is a Schedule is raised as a whole, and a step of a threshold response does not change
    with the tension that caused it, only with its size.

    Parameters
    ----------
    solution : Equilibrium or Result
        Where to differentiate.
    of : str or sequence of str
        Outputs, variables or quantities of loads ("l1.z").
    to : str or sequence of str
        Parameters ("s3.z"), lengths ("a_b.length"), inputs ("c1.speed"), initial states, masses of loads ("l1.mass"),
        or "head.pretension": the tension of the empty rope at its first support, with the lengths and the tensions of
        drums that follow from it.

    Returns
    -------
    DataFrame
        In SI units of the one per SI unit of the other; `attrs["units"]` and `attrs["per"]` have them. Of an
        equilibrium: a row for each of `of`, a column for each of `to`. Of a simulation: a row for each time of the
        frame, columns (of, to); NaN where a load is not on the line.

    Raises
    ------
    UnknownNameError
    InputError
        For a simulation in which a load stands on a sheave, or with an emergency stop.

    Examples
    --------
    >>> frame = rw.sensitivities(rw.equilibrium(line), of="c1.tension_in", to=["l8.mass", "c1.z"])
    >>> frame.loc["c1.tension_in"].round(2).to_dict()
    {'l8.mass': 1.57, 'c1.z': 99.58}
    """
    wanted, varied = ([v] if isinstance(v, str) else list(v) for v in (of, to))
    if not wanted or not varied:
        raise InputError("sensitivities has nothing to derive", "Name at least one result and one parameter")
    frame = (
        _at_rest(solution, wanted, varied) if isinstance(solution, Equilibrium) else _in_time(solution, wanted, varied)
    )
    model = solution.model
    frame.attrs["units"] = Labels({name: _unit(model, name) for name in wanted})
    frame.attrs["per"] = Labels({name: _unit(model, name) for name in varied})
    return frame


def _at_rest(line: Equilibrium, wanted: Sequence[str], varied: Sequence[str]) -> pd.DataFrame:
    line = still(line)
    moved = Varied.of(line, varied)
    places = [find(line.model, line.runs, line.passed, name) for name in wanted]
    d = moved.discrete(line.model, line.runs, line.passed, line.point)
    found = tangent_of(line.model).solve(line.point, moved.x, moved.u, moved.p, d)
    outputs = tangent_of(line.model).outputs(line.point, found)
    rows = [outputs[k] if kind is Kind.OUTPUT else found.vector(kind)[k] for kind, k in places]
    return pd.DataFrame(rows, index=pd.Index(wanted, name="of"), columns=pd.Index(varied, name="to"))


def _in_time(result: Result, wanted: Sequence[str], varied: Sequence[str]) -> pd.DataFrame:
    happened = {event.event for event in result.noted}
    if found := happened & {"load held", "emergency stop"}:
        raise InputError(f"The run has the event {' and '.join(sorted(found))}", "End the run before it")
    forward = ForwardSensitivity(result, Varied.of(result.record(0), varied))
    rows = []
    for i in range(len(result.records)):
        line = forward.step(i)
        if result.on_grid[i]:
            rows.append(forward.read(line, wanted))
    columns = pd.MultiIndex.from_product([wanted, varied], names=["of", "to"])
    index = pd.Index(result.times[result.on_grid], name="time")
    return pd.DataFrame(np.array(rows).reshape(len(rows), -1), index=index, columns=columns)


def _unit(model: Model, name: str) -> str:
    """Unit of a variable, of a load's quantity or of a pretension."""
    for table in model.tables.values():
        if name in table.index:
            return table.units[table.index[name]]
    return {"mass": "kg", "pretension": "N"}.get(name.rpartition(".")[2], "m")
