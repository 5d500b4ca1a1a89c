"""The table that supports are built from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.errors import InputError
from ropeway.systems.interrupts import interruptible
from ropeway.systems.modelling.dae_model import Model
from ropeway.systems.modelling.system import System
from ropeway.systems.results.support_rows import require_rollers, roller_force
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.studies.load_cases.line_tables import supports_at_rest
from ropeway.systems.studies.load_cases.load_case import Cases
from ropeway.systems.studies.load_cases.rig_states import rig_path, rig_stations
from ropeway.systems.studies.load_cases.rig_tables import rig_supports
from ropeway.systems.studies.load_cases.study import LoadCases, load_cases


@checked
@interruptible
def support_table(
    of: System | Model | Equilibrium | SkylineRig | LoadCases,
    cases: LoadCases | Cases | None = None,
    *,
    rollers: Mapping[str, int] | None = None,
    payload: float | None = None,
    stations: Sequence[float] | np.ndarray | None = None,
) -> pd.DataFrame:
    """Forces and angles of the ropes at all supports, in all load cases.

    Parameters
    ----------
    of : System, Model, Equilibrium, SkylineRig or LoadCases
        A line, a rig, an equilibrium, or their load cases.
    cases : LoadCases, or as for `rw.load_cases`, optional
        Load cases of the line or rig; by default it stands in no weather.
    rollers : mapping of str to int, optional
        Number of rollers at supports, which share the wrap angle equally; 1 by default.
    payload : float, optional
        Payload of a rig [kg]; by default that of its carriage.
    stations : sequence of float, optional
        Stations of a rig's carriage [m]; by default about 20, and both sides of each support.

    Returns
    -------
    DataFrame
        A row for each case and each rope at a support; where several ropes meet also one for "all". Units in
        `attrs["units"]`; `rw.write_table` writes it. Columns:

        - case; support, kind, rope; of a rig over several stations extreme ("highest bearing load", "least vertical
          force" or "largest break angle") and the station at which the support is in that state: all other values of
          the row are those of the same state
        - angle_in and angle_out: slopes of the rope in its direction before and after the support; deflection: by how
          much it bends down; turn: in plan, to the left; wrap: between both directions; break_angle: deflection over a
          saddle [rad]
        - tension_in, tension_out, differential_tension; drive_force of a control sheave on the rope [N]
        - resultant_x, resultant_y, resultant_z of the rope on the support; vertical_force, downwards;
          horizontal_force; bearing_load, the size of the resultant; roller_force on each roller [N]
        - least_force: of a rig at all stations, vertical and towards the support; lift_off_reserve: factor by which the
          rope's tension can grow (of a hold-down: fall) until it leaves the support, at least at all stations

    Raises
    ------
    InputError, UnknownNameError
        An unknown support, or arguments that do not belong together.
    EquilibriumError
        There is no equilibrium.

    Examples
    --------
    >>> s = rw.System("line")
    >>> ends = rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(200.0, 0.0))
    >>> _ = s.string("RHOL-IWRC 29", ends[0], rw.Sheave("s", at=(100.0, 8.0)), ends[1], length=201.0)
    >>> rw.support_table(s, rollers={"s": 4})["vertical_force"].round(0).tolist()
    [532.0, 5796.0, 532.0]
    """
    if isinstance(of, (LoadCases, Equilibrium)) and cases is not None:
        raise InputError("of has load cases, or weather, of its own", "Leave out cases, or give a line or a rig")
    if isinstance(of, LoadCases):
        frame = of.supports.copy()
    elif isinstance(cases, LoadCases):
        frame = cases.supports.copy()
    elif cases is None or isinstance(of, Equilibrium):
        frame = _alone(of, payload, stations)
    else:
        frame = load_cases(of, cases, payload=payload, stations=stations).supports
    require_rollers(rollers, list(dict.fromkeys(frame["support"])))
    count = frame["support"].map(rollers or {}).fillna(1.0).to_numpy(float)
    frame["roller_force"] = roller_force(frame["bearing_load"].to_numpy(), frame["wrap"].to_numpy(), count)
    return frame


def _alone(
    of: System | Model | Equilibrium | SkylineRig, payload: float | None, stations: Sequence[float] | np.ndarray | None
) -> pd.DataFrame:
    """The table without load cases. Raises InputError, EquilibriumError."""
    if isinstance(of, SkylineRig):
        mass = of.carriage.payload if payload is None else payload
        check.not_negative(mass, of.name, "payload", "kg")
        where = rig_stations(of, stations)
        return rig_supports(rig_path(of, mass, where), where)
    if payload is not None or stations is not None:
        raise InputError("payload and stations are those of a rig", "Leave them out, or give a rig")
    line = of if isinstance(of, Equilibrium) else equilibrium(of)
    return supports_at_rest([line]).drop(columns="state")
