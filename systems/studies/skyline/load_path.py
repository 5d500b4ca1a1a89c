"""The load path: the carriage moved along all spans, station by station."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.environment import Environment
from ropeway.components.errors import InputError
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.rigs.skyline_rig import SkylineRig, studied_in
from ropeway.systems.studies.skyline.carriage_model import Solved
from ropeway.systems.studies.skyline.certified_states import certified
from ropeway.systems.studies.skyline.rope_tensions import warn_of_overload
from ropeway.systems.studies.skyline.station_row import station_row, units_of
from ropeway.systems.studies.skyline.station_solver import Stations


@checked
@interruptible
def load_path(
    rig: SkylineRig,
    payload: float,
    stations: Sequence[float] | np.ndarray | None = None,
    *,
    height: float | None = None,
    environment: Environment | None = None,
    compiled: bool = False,
) -> pd.DataFrame:
    """The path of the loaded carriage along all spans, with the tensions of all ropes.

    Parameters
    ----------
    rig : SkylineRig
        The skyline.
    payload : float
        Payload [kg].
    stations : sequence of float, shape (n,), optional
        Stations of the carriage [m]; by default every 5 m in all spans. At a support without a radius the carriage
        hangs 2 cm before it; at a support with a radius it is on the shoe.
    height : float, optional
        Height of the load over the ground [m], set by the yarder of a live or running skyline; with a log, height of
        the carriage.
    environment : Environment, optional
        Weather, instead of that of the rig.
    compiled : bool, default False
        Whether to solve in compiled code, which needs a C compiler at first use: the same results.

    Returns
    -------
    DataFrame
        One row per station; units in `attrs["units"]`. Columns, lengths in m and forces in N:

        - carriage_x, carriage_y, carriage_z; on a map carriage_easting and carriage_northing in the unit of the map;
          sag below the chord of its span, deflection [% of the span], span (from 1)
        - skyline_tension at the carriage, highest_tension of the skyline, headspar_tension, tailspar_tension,
          anchor_tension at the skyline's anchor
        - mainline_pull at the carriage (or the ideal holding force, positive towards the headspar), mainline_tension
          at its drum, mainline_highest; haulback_pull, haulback_tension, haulback_highest likewise
        - clearance of the load over the ground (of a log's lower end, or of its front while the rear drags),
          rope_clearance of the skyline; on a terrain mainline_clearance and haulback_clearance
        - `NAME_force` of each support, upward on the rope, negative where it lifts off; `NAME_break_angle` by which the
          skyline bends down over it [rad]
        - held_by: mainline, clamp (beyond the rest point the carriage is clamped to the skyline) or holding
        - for a guyed headspar spar_compression and spar_lean, for a guyed tailspar tailspar_compression and
          tailspar_lean, for each guyline the higher `NAME_tension` of its ends
        - for a log suspension (partial or full), ground_force, dropline_tension, front_clearance

    Raises
    ------
    InputError
        A station is outside the skyline, or the height cannot be set.
    EquilibriumError
        There is no equilibrium at a station.
    CompiledError, CompilerError, WriteError
        Of `compiled`: the core does not support this rig, has no compiler, or its cache cannot be written.

    Warns
    -----
    RopewayWarning
        A rope is above its minimum breaking load.

    Examples
    --------
    >>> rig = rw.standing_skyline(
    ...     None, headspar=rw.HeadSpar("head", at=(0.0, 15.0)), tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
    ...     skyline="RHOL-IWRC 29", tension=70e3, carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> rw.load_path(rig, 2000.0, [100.0, 200.0])[["deflection", "highest_tension"]].round(1)
       deflection  highest_tension
    0         4.0         163591.9
    1         4.0         163797.7
    """
    check.not_negative(payload, rig.name, "payload", "kg")
    if height is not None and not rig.kind.sets_height:
        raise InputError(f"{rig.name} cannot be lowered or raised", "Remove height, or use a live skyline")
    rig = studied_in(rig, environment)
    solver = Stations(rig, by_height=height is not None, compiled=compiled)
    positions, solved = stations_of(rig, stations), list[Solved]()

    def frame() -> pd.DataFrame:
        rows = [station_row(one, float(x)) for one, x in zip(certified(solved), positions, strict=False)]
        path = pd.DataFrame(rows)
        path.attrs["units"] = units_of(path)
        return path

    with keeping(frame):
        for x in positions:
            z = None if height is None else carriage_height(rig, float(x), height)
            solved.append(solver.solve(float(x), payload, z))
    found = frame()
    warn_of_overload(solved, positions)
    return found


def default_stations(rig: SkylineRig, spacing: float = 5.0) -> np.ndarray:
    """Stations about every `spacing` metres over all spans, without both ends. Raises InputError."""
    check.positive(spacing, rig.name, "spacing", "m")
    x0, x1 = rig.points[0, 0], rig.points[rig.spans, 0]
    check.count((x1 - x0) / spacing, rig.name, "stations", 100_000)
    return np.linspace(x0, x1, max(4, round((x1 - x0) / spacing) + 1))[1:-1]


def stations_of(rig: SkylineRig, stations: Sequence[float] | np.ndarray | None) -> np.ndarray:
    """The given stations [m], by default about every 5 m over all spans. Raises InputError."""
    if stations is None:
        return default_stations(rig)
    try:
        values = np.asarray(stations, dtype=float)
    except (TypeError, ValueError):
        values = np.empty((0, 0))
    if values.ndim != 1:
        raise InputError(f"{rig.name}: stations are {stations!r}", "Give a sequence of numbers [m]")
    if values.size == 0:
        raise InputError(f"{rig.name}: no stations", "Give at least one station between headspar and tailspar")
    for x in values:
        check.number(float(x), rig.name, "a station", "m")
        rig.span_of(float(x))
    return values


def carriage_height(rig: SkylineRig, station: float, height: float) -> float:
    """Height z [m] of the carriage with its load `height` over the ground. Raises InputError."""
    if rig.terrain is None:
        raise InputError(f"{rig.name} has no terrain", "Give it a Profile, which a height over the ground needs")
    return rig.terrain.elevation_at(station) + height + rig.carriage.depth
