"""Load cases of a line or a rig: environments and loadings, and which of them governs what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.reported import Reported
from ropeway.systems.reporting.style import Style
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.load_cases.case_tables import summary
from ropeway.systems.studies.load_cases.data import CasesData
from ropeway.systems.studies.load_cases.line_states import line_states
from ropeway.systems.studies.load_cases.line_tables import line_tables
from ropeway.systems.studies.load_cases.load_case import Cases, resolved
from ropeway.systems.studies.load_cases.loadings import STANDARD, Masses, require_loadings
from ropeway.systems.studies.load_cases.rig_states import payload_of, require_payloads, rig_states, rig_stations
from ropeway.systems.studies.load_cases.rig_tables import rig_tables
from ropeway.systems.studies.skyline.station_row import station_row, units_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False, repr=False)
class LoadCases(CasesData, Reported):
    """All load cases of a line or a rig, as `rw.load_cases` returns them.

    Parameters
    ----------
    of : System or SkylineRig
        The line or rig.
    cases : tuple of LoadCase
        The cases.
    frame : DataFrame
        A row for each case, index case: loading, temperature [degC], ice_thickness [m], wind_pressure [Pa] and
        wind_from [deg]; of the rope that uses most of its allowed tension its name, the span, highest_tension [N],
        safety (minimum breaking load over it), safety_factor (as asked), utilisation (the second over the first);
        lowest_tension [N] of all ropes; highest_bearing_load and least_force [N] of supports, and where they are; on a
        terrain least_clearance [m] of ropes and loads, and where it is.
    tensions : DataFrame
        A row for each case and rope.
    supports : DataFrame
        A row for each case and rope at a support, in the columns of `rw.support_table`.
    clearances : DataFrame or None
        A row for each case and span; None without a terrain.
    states : dict
        For each case by its name the line at rest, an `Equilibrium`; or the load path of the rig, a frame.

    Examples
    --------
    >>> cold = rw.Environment("cold", temperature=-20.0)
    >>> cases = rw.load_cases(span, [rw.Environment("calm"), cold])
    >>> len(cases.cases)
    2
    """

    def plot(self) -> Figure:
        """One page: elevation, sag and plan, tensions, and forces on supports.

        Bars show how much of the allowed tension each case uses; for each support the range of its vertical force is in
        the colours of the cases that set its ends.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ropeway.systems.studies.load_cases.plot import cases_figure

        return cases_figure(self)

    def _report_title(self, style: Style) -> str:
        return self.of.name

    def _report_sections(self, style: Style) -> Sequence[Section]:
        from ropeway.systems.studies.load_cases.report import sections_of

        return sections_of(self, style)


@checked
@interruptible
def load_cases(
    of: System | Model | SkylineRig,
    cases: Cases,
    *,
    loadings: Sequence[str] | Mapping[str, Masses | str] | None = None,
    safety_factor: float | None = None,
    payload: float | None = None,
    stations: Sequence[float] | np.ndarray | None = None,
) -> LoadCases:
    """Solve a line or a rig in environments and loadings: tensions, forces on supports and clearances in one table.

    A line is at rest with its loads where they are; a rig is solved with its carriage at stations along the corridor.

    Parameters
    ----------
    of : System, Model or SkylineRig
        The line or rig.
    cases : sequence of Environment or LoadCase, DataFrame, str or Path
        Environments, which are combined with all `loadings`, and load cases, which have one; or a table of them, a CSV
        or Excel file, with columns name, and those that are needed of temperature, ice_thickness, ice_density,
        wind_pressure, wind_speed, wind_from, air_density, loading, safety_factor.
    loadings : sequence of str, or mapping, optional
        Of environments: names of standard loadings, "empty", "full", "one side" (up to the support where the rope turns
        back, or up to its middle), "every second" (load missing); or a mapping of names to those, to the masses of the
        loads [kg] (one number; a sequence in order from the foremost load and repeated; by name of the load), or for a
        rig to a payload [kg]. By default all standard ones, where a line has loads; of a rig "empty" and "full".
    safety_factor : float, optional
        Least ratio of minimum breaking load to highest tension, where a case has none; by default that of each rope.
    payload : float, optional
        Of the rig's loading "full" [kg]; by default that of its carriage.
    stations : sequence of float, optional
        Stations of the carriage [m]; by default about 20, and both sides of each support.

    Returns
    -------
    LoadCases

    Raises
    ------
    InputError, UnknownNameError
        A case named twice, an unknown loading, wind or ice on a rope without a diameter.
    EquilibriumError
        With the name of the case that has no equilibrium.

    Examples
    --------
    >>> cold = rw.Environment("cold", temperature=-20.0)
    >>> cases = rw.load_cases(span, [rw.Environment("calm"), cold])
    >>> cases.governing.shape[0] > 0
    True
    """
    if safety_factor is not None:
        check.positive(safety_factor, "load_cases", "safety_factor")
    if isinstance(of, SkylineRig):
        return _of_rig(of, cases, loadings, safety_factor, payload, stations)
    if payload is not None or stations is not None:
        raise InputError("payload and stations are those of a rig", "Leave them out, or give a rig")
    system = of.system if isinstance(of, Model) else of
    own, names = _own(loadings, STANDARD if system.hung or system.feeds else ("empty",))
    found = resolved(cases, names, safety_factor)
    require_loadings([case.loading for case in found], own)
    states = line_states(system, found, own)
    tables = line_tables(found, states)
    by_name = {case.name: line for case, line in zip(found, states, strict=True)}
    return LoadCases(system, found, summary(found, system.temperature, tables), *tables, states=by_name)


def _of_rig(
    rig: SkylineRig,
    cases: Cases,
    loadings: Sequence[str] | Mapping[str, Masses | str] | None,
    safety_factor: float | None,
    payload: float | None,
    stations: Sequence[float] | np.ndarray | None,
) -> LoadCases:
    """The cases of a rig."""
    full = rig.carriage.payload if payload is None else payload
    check.not_negative(full, rig.name, "payload", "kg")
    given, names = _own(loadings, ("empty", "full"))
    own = require_payloads(rig, given)
    found, where = resolved(cases, names, safety_factor), rig_stations(rig, stations)
    payloads = [payload_of(rig, case.loading, own, full) for case in found]
    states = rig_states(rig, found, payloads, where)
    tables = rig_tables(rig, found, states, where)
    paths: dict[str, Any] = {}
    for case, solved in zip(found, states, strict=True):
        path = pd.DataFrame([station_row(one, float(x)) for one, x in zip(solved, where, strict=True)])
        path.attrs["units"] = units_of(path)
        paths[case.name] = path
    return LoadCases(rig, found, summary(found, rig.temperature, tables), *tables, states=paths)


def _own(
    loadings: Sequence[str] | Mapping[str, Masses | str] | None, default: Sequence[str]
) -> tuple[dict[str, Masses], list[str]]:
    """Masses of the user's own loadings, and the names of all. Raises InputError."""
    if loadings is None:
        return {}, list(default)
    if isinstance(loadings, str) or not len(loadings):
        raise InputError(f"loadings is {loadings!r}", 'Give names, such as ["empty", "full"], or a mapping')
    if not isinstance(loadings, Mapping):
        return {}, list(loadings)
    own: dict[str, Masses] = {}
    names = []
    for name, masses in loadings.items():
        if isinstance(masses, str):
            names.append(masses)
        else:
            own[name] = masses
            names.append(name)
    return own, names
