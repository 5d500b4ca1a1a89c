"""The largest payload along a corridor, and the governing limit at each station."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.environment import Environment
from ropeway.components.errors import InputError
from ropeway.components.rounding import at_most
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.reported import Reported
from ropeway.systems.reporting.style import Style
from ropeway.systems.results.support_rows import require_rollers
from ropeway.systems.rigs.skyline_rig import SkylineRig, studied_in
from ropeway.systems.studies.skyline.limits import LoadLimits
from ropeway.systems.studies.skyline.load_path import stations_of
from ropeway.systems.studies.skyline.payload.data import PayloadData
from ropeway.systems.studies.skyline.payload.search import PayloadSearch
from ropeway.systems.studies.skyline.station_row import StationRow, units_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@checked
@dataclass(frozen=True, eq=False)
class PayloadStudy(PayloadData, Reported):
    """The largest payload by station, as `rw.payload` returns it.

    A payload of 0 with limited_by is a valid result: even the empty carriage exceeds that limit. "rest point": a
    running skyline's carriage would run back from the station. "haulback tension": the haulback cannot support more at
    any depth.

    Parameters
    ----------
    rig : SkylineRig
        The skyline.
    frame : DataFrame
        One row per station: station [m], payload [kg], limited_by, and the columns of `rw.load_path` under that
        payload.
    safety_factor : float
        Safety factor of the skyline.
    mainline_safety_factor : float
        Safety factor of the other ropes.
    clearance : float or None
        Requested clearance [m].
    saddle_angle : (float, float), optional
        Least and largest break angle over a saddle [rad].
    roller_force : float, optional
        Largest force on a roller of a support [N].

    Examples
    --------
    >>> rig = rw.standing_skyline(
    ...     None, headspar=rw.HeadSpar("head", at=(0.0, 15.0)), tailspar=rw.TailSpar("tail", at=(300.0, -20.0)),
    ...     skyline="RHOL-IWRC 29", tension=70e3, carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> rw.payload(rig, stations=[100.0, 150.0])
    <PayloadStudy of 'standing skyline': 2689 kg, limited at 150 m by skyline tension>
    """

    def __repr__(self) -> str:
        worst = self.limiting
        return (
            f"<PayloadStudy of {self.rig.name!r}: {at_most(self.payload)} kg, limited at {worst['station']:g} m by "
            f"{worst['limited_by']}{self._unhauled}>"
        )

    @property
    def _unhauled(self) -> str:
        count = len(self.not_hauled)
        return f", but not hauled at {count} of {len(self.frame)} stations" if count else ""

    def _report_title(self, style: Style) -> str:
        return self.rig.name

    def _report_sections(self, style: Style) -> Sequence[Section]:
        from ropeway.systems.studies.skyline.payload.report import sections_of

        return sections_of(self, style)

    def plot(self) -> Figure:
        """The corridor to scale with the load path, the payload by station, and the tensions.

        Returns
        -------
        Figure
            Figure with payloads in the colour of the governing limit, and tensions against safe working loads.
        """
        from ropeway.systems.studies.skyline.payload.plot import payload_figure

        return payload_figure(self)


@checked
@interruptible
def payload(
    rig: SkylineRig,
    *,
    safety_factor: float = 3.0,
    clearance: float | None = None,
    rope_clearance: float = 0.0,
    stations: Sequence[float] | np.ndarray | None = None,
    mainline_safety_factor: float | None = None,
    lift_off: bool = True,
    saddle_angle: tuple[float, float] | None = None,
    roller_force: float | None = None,
    rollers: Mapping[str, int] | None = None,
    environment: Environment | None = None,
    compiled: bool = False,
) -> PayloadStudy:
    """Find the largest payload at stations along a corridor within all limits.

    Limits are the tensions of all ropes, the clearances, known capacities of spars, supports and tailhold, and
    lift-off. A live, gravity or running skyline with a clearance is lowered at each station to that clearance, but not
    below the lowest position of the empty carriage or the skyline's own clearance. With a log the skyline is not
    lowered.

    Parameters
    ----------
    rig : SkylineRig
        The skyline.
    safety_factor : float, default 3.0
        Least ratio of minimum breaking load to highest tension of the skyline.
    clearance : float, optional
        Least height of the load over the ground [m]; for a log, of its front.
    rope_clearance : float, default 0.0
        Least height of the loaded skyline over the ground between headspar and tailspar [m]. It counts only with
        `clearance`.
    stations : sequence of float, shape (n,), optional
        Stations [m]; by default about every 5 m.
    mainline_safety_factor : float, optional
        Safety factor of mainline, haulback, dropline and guylines; by default `safety_factor`.
    lift_off : bool, default True
        Whether the skyline must stay in its saddles, and a guyed spar on its foot.
    saddle_angle : (float, float), optional
        Least and largest angle by which the skyline bends down over a saddle, with the carriage at any of the stations
        [rad].
    roller_force : float, optional
        Largest force of the skyline on a roller of a support [N].
    rollers : mapping of str to int, optional
        Number of rollers under the skyline at supports, for `roller_force`; 1 by default.
    environment : Environment, optional
        Weather, instead of that of the rig.
    compiled : bool, default False
        Whether to solve in compiled code, which needs a C compiler at first use: the same result.

    Returns
    -------
    PayloadStudy
        The payloads and their limits.

    Raises
    ------
    InputError
        A station is outside the skyline, or a clearance is given without a terrain.
    CompiledError, CompilerError, WriteError
        Of `compiled`: the core does not support this rig, has no compiler, or its cache cannot be written.

    Examples
    --------
    >>> rig = rw.live_skyline(
    ...     rw.Profile([0.0, 150.0, 300.0], [0.0, -30.0, -10.0]), tension=70e3, skyline="RHOL-IWRC 29",
    ...     headspar=rw.HeadSpar("head", station=0.0, height=15.0),
    ...     tailspar=rw.TailSpar("tail", station=300.0, height=5.0),
    ...     mainline="6x19 EEIP 19", carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> study = rw.payload(rig, clearance=2.0, stations=[100.0, 150.0])
    >>> study.frame["limited_by"].tolist()
    ['skyline tension', 'skyline tension']
    """
    check.positive(safety_factor, rig.name, "safety_factor")
    others = safety_factor if mainline_safety_factor is None else mainline_safety_factor
    check.positive(others, rig.name, "mainline_safety_factor")
    if clearance is not None:
        check.number(clearance, rig.name, "clearance", "m")
        if rig.terrain is None:
            raise InputError(f"{rig.name} has no terrain for a clearance", "Give it a Profile, or remove clearance")
    check.number(rope_clearance, rig.name, "rope_clearance", "m")
    rig = studied_in(rig, environment)
    where = stations_of(rig, stations)
    _require_saddle_limits(rig, saddle_angle, roller_force, rollers)
    saddles = (saddle_angle, roller_force, rollers or {})
    bounds = LoadLimits(safety_factor, others, clearance, rope_clearance, lift_off, *saddles)
    search = PayloadSearch(rig, bounds, compiled=compiled)
    rows: list[StationRow] = []
    row = cache(search.at)  # a station can be asked for twice

    def study() -> PayloadStudy:
        frame = pd.DataFrame(rows)
        frame.attrs["units"] = units_of(frame)
        return PayloadStudy(rig, frame, safety_factor, others, clearance, saddle_angle, roller_force)

    with keeping(lambda: study().frame):
        for x in where:
            rows.append(row(float(x)))
    return study()


def _require_saddle_limits(
    rig: SkylineRig,
    saddle_angle: tuple[float, float] | None,
    roller_force: float | None,
    rollers: Mapping[str, int] | None,
) -> None:
    """Raises InputError, UnknownNameError."""
    if saddle_angle is not None:
        least, most = saddle_angle
        check.number(least, rig.name, "the least saddle_angle", "rad")
        if not max(least, 0.0) < most < math.pi:
            raise InputError(
                f"{rig.name}: saddle_angle is from {least:g} to {most:g} rad", "Give the least one first, in radians"
            )
    if roller_force is not None:
        check.positive(roller_force, rig.name, "roller_force", "N")
    require_rollers(rollers, [support.name for support in rig.supports])
