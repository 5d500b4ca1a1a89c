"""Exact derivatives of results, as newtons per kilogram, per metre of support height, per newton of pretension.

At rest, and with a rig's carriage at a station, they follow from the equations by implicit differentiation; along a
simulation from the linearised equations (`forward_sensitivity`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.systems.dynamics.result import Result
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model, in_code
from ropeway.systems.results.column_labels import Labels
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.solvers.points import Slot
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import still
from ropeway.systems.statics.line_state import find
from ropeway.systems.studies.sensitivity.forward_sensitivity import ForwardSensitivity
from ropeway.systems.studies.sensitivity.linearisation import LinearState, tangent_of
from ropeway.systems.studies.sensitivity.perturbations import Varied
from ropeway.systems.studies.sensitivity.rig_sensitivities import rig_sensitivities


@checked
@interruptible
def sensitivities(
    solution: Equilibrium | Result | SkylineRig,
    *,
    of: str | Sequence[str],
    to: str | Sequence[str],
    payload: float | None = None,
    stations: Sequence[float] | np.ndarray | None = None,
    height: float | None = None,
    compiled: bool = False,
) -> pd.DataFrame:
    """Exact derivatives of results by parameters.

    All else is held, unstretched lengths too; loads stay at their places on the rope. Along a simulation travel counts
    from the start, an input that is a Schedule is raised as a whole, and a step of a threshold response does not change
    with the tension that caused it, only with its size.

    Parameters
    ----------
    solution : Equilibrium, Result or SkylineRig
        Where to differentiate; of a rig the load path.
    of : str or sequence of str
        Outputs, variables or quantities of loads ("l1.z"). Of a rig: columns of its load path but clearances
        ("skyline_tension"), or quantities of its model ("carriage.z").
    to : str or sequence of str
        Parameters ("s3.z"), lengths ("a_b.length"), inputs ("c1.speed"), initial states, masses of loads ("l1.mass"),
        or of the rope that begins at a support: "head.pretension", the tension of the empty rope there, with the
        lengths and the tensions of drums that follow from it; "head.axial_stiffness", "head.mass_per_length". Of a rig:
        "station", "payload", "height"; "length" of the skyline or "tension" of the bare skyline; "axial_stiffness" and
        "mass_per_length" of "skyline", "mainline" or "haulback"; and parameters of its model ("tail.z").
    payload : float, optional
        Of a rig [kg]; by default that of its carriage.
    stations : sequence of float, shape (n,), optional
        Of a rig, as for `load_path`.
    height : float, optional
        Of a rig, as for `load_path`; to="height" is then the height z of the carriage.
    compiled : bool, default False
        Whether to solve in compiled code, which needs a C compiler at first use: the same result.

    Returns
    -------
    DataFrame
        In SI units of the one per SI unit of the other; `attrs["units"]` and `attrs["per"]` have them. Of an
        equilibrium: a row for each of `of`, a column for each of `to`. Of a simulation: a row for each time of the
        frame, columns (of, to); NaN where a load is not on the line. Of a rig: a row for each station, columns (of,
        to).

    Raises
    ------
    UnknownNameError
    InputError
        For a simulation in which a load stands on a sheave, or with an emergency stop; payload, stations or height
        without a rig.
    EquilibriumError
        A rig has no equilibrium at a station.
    CompiledError, CompilerError, WriteError
        Of `compiled`: the core does not support this system, has no compiler, or its cache cannot be written.

    Examples
    --------
    >>> frame = rw.sensitivities(rw.equilibrium(line), of="c1.tension_in", to=["l8.mass", "c1.z"])
    >>> frame.loc["c1.tension_in"].round(2).to_dict()
    {'l8.mass': 1.57, 'c1.z': 99.58}
    """
    wanted, varied = ([v] if isinstance(v, str) else list(v) for v in (of, to))
    if not wanted or not varied:
        raise InputError("sensitivities has nothing to derive", "Name at least one result and one parameter")
    if isinstance(solution, SkylineRig):
        load = solution.carriage.payload if payload is None else payload
        return rig_sensitivities(solution, wanted, varied, load, stations, height, compiled=compiled)
    if (payload, stations, height) != (None, None, None):
        raise InputError("payload, stations and height are those of a rig", "Leave them out, or give a rig")
    if isinstance(solution, Equilibrium):
        frame = _at_rest(solution, wanted, varied, compiled=compiled)
    else:
        frame = _in_time(solution, wanted, varied, compiled=compiled)
    model = solution.model
    frame.attrs["units"] = Labels({name: unit_of(model, name) for name in wanted})
    frame.attrs["per"] = Labels({name: unit_of(model, name) for name in varied})
    return frame


def _at_rest(line: Equilibrium, wanted: Sequence[str], varied: Sequence[str], *, compiled: bool) -> pd.DataFrame:
    line = still(line)
    line = replace(line, model=in_code(line.model, compiled=compiled))
    state = linearised(line, Varied.of(line, varied))
    rows = [state.rates(name) for name in wanted]
    return pd.DataFrame(rows, index=pd.Index(wanted, name="of"), columns=pd.Index(varied, name="to"))


def linearised(line: Equilibrium, varied: Varied) -> LinearState:
    """An equilibrium with its derivatives. Raises EquilibriumError."""
    tangent, discrete = tangent_of(line.model), varied.discrete(line.model, line.runs, line.passed, line.point)
    found = tangent.solve(line.point, varied.x, varied.u, varied.p, discrete)

    def slot(name: str) -> Slot:
        return find(line.model, line.runs, line.passed, name)

    return LinearState(line.__getitem__, slot, tangent.outputs(line.point, found), found)


def _in_time(result: Result, wanted: Sequence[str], varied: Sequence[str], *, compiled: bool) -> pd.DataFrame:
    happened = {event.event for event in result.noted}
    if found := happened & {"load held", "emergency stop"}:
        raise InputError(f"The run has the event {' and '.join(sorted(found))}", "End the run before it")
    forward = ForwardSensitivity(result, Varied.of(result.record(0), varied), compiled=compiled)
    rows = []
    for i in range(len(result.records)):
        line = forward.step(i)
        if result.on_grid[i]:
            rows.append(forward.read(line, wanted))
    columns = pd.MultiIndex.from_product([wanted, varied], names=["of", "to"])
    index = pd.Index(result.times[result.on_grid], name="time")
    return pd.DataFrame(np.array(rows).reshape(len(rows), -1), index=index, columns=columns)


def unit_of(model: Model, name: str) -> str:
    """Unit of a variable, of a load's quantity or of a pretension."""
    for table in model.tables.values():
        if name in table.index:
            return table.units[table.index[name]]
    known = {"mass": "kg", "pretension": "N", "axial_stiffness": "N", "mass_per_length": "kg/m"}
    return known.get(name.rpartition(".")[2], "m")
