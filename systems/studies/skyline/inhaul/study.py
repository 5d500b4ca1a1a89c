"""A skyline rig over time: the mainline's drum pulls the carriage over its supports; payloads are picked up or lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.check import Range
from ropeway.components.errors import EquilibriumError, InputError, SimulationError
from ropeway.components.inertia import Inertia
from ropeway.components.table_writer import Tabular
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.reported import Reported
from ropeway.systems.reporting.style import Style
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.studies.skyline.carriage_route import require_pulled
from ropeway.systems.studies.skyline.inhaul.carriage_run import CarriageRun

if TYPE_CHECKING:
    from matplotlib.figure import Figure


FASTEST = Range(0.0, 100.0, above=True)
"""Highest plausible speed of a carriage [m/s]; a higher one is probably an error of units."""


@checked
@dataclass(frozen=True, eq=False)
class Inhaul(Tabular, Reported):
    """A run of the carriage, as `rw.inhaul` returns it.

    Parameters
    ----------
    rig : SkylineRig
        The skyline.
    frame : DataFrame
        One row per interval (index time [s]), except while the carriage waits at a saddle: the columns of
        `rw.load_path`, payload [kg], carriage_speed [m/s], drum_power of the mainline and haulback_power [W; positive:
        the drum drives, negative: it brakes].
    events : DataFrame
        Columns time, event, station: supports reached and left, changes of the payload, and rows "beyond" a limit of
        `rw.payload` (safe working load, capacity of a spar or support, lift-off).

    Examples
    --------
    >>> run = rw.inhaul(rig, payload=1000.0, start=200.0, end=195.0, every=1.0)
    >>> print(f"{run.frame['mainline_tension'].max() / 1e3:.1f} kN")
    2.2 kN
    """

    rig: SkylineRig
    frame: pd.DataFrame
    events: pd.DataFrame

    def __repr__(self) -> str:
        return f"<Inhaul of {self.rig.name!r}: {len(self.frame)} rows, {len(self.events)} events>"

    def _report_title(self, style: Style) -> str:
        return self.rig.name

    def _report_sections(self, style: Style) -> Sequence[Section]:
        from ropeway.systems.studies.skyline.reporting.path_report import inhaul_sections

        return inhaul_sections(self.rig, self.frame, self.events, style)

    def plot(self) -> Figure:
        """Station of the carriage, tensions and powers over time.

        Returns
        -------
        Figure
            The tensions against the safe working loads.
        """
        from ropeway.systems.studies.skyline.inhaul.plot import inhaul_figure

        return inhaul_figure(self.rig, self.frame, self.events)


@checked
@interruptible
def inhaul(
    rig: SkylineRig,
    *,
    payload: float,
    start: float,
    end: float,
    speed: float = 3.0,
    every: float = 1.0,
    changes: Sequence[tuple[float, float]] = (),
    tolerance: float = 1e-8,
    inertia: Inertia | None = None,
    compiled: bool = False,
) -> Inhaul:
    """Pull the carriage from one station to another with the mainline's drum.

    The rig needs a real mainline. The run stops where the mainline would go slack; a haulback must brake the carriage
    there. At a point saddle the carriage changes spans as soon as the mainline's length allows. On a support with a
    radius it rolls over the shoe. If the stretch of a long mainline changes by more than the length of the shoe, the
    carriage jumps over it.

    Parameters
    ----------
    rig : SkylineRig
        The rig, with a mainline.
    payload : float
        Payload at the start [kg].
    start, end : float
        First and last station of the carriage [m].
    speed : float, default 3.0
        Speed of the mainline at its drum, above zero [m/s of unstretched rope].
    every : float, default 1.0
        Interval of the rows [s].
    changes : sequence of (float, float), default ()
        Times [s] and payloads from then on [kg]: turns picked up or lost.
    tolerance : float, default 1e-8
        Relative tolerance of the integration; with inertia 1e-6 is enough.
    inertia : Inertia, optional
        The inertia of carriage, payload and ropes, without rope nodes: the carriage swings after a change of the
        payload. It comes to each span in balance, with the ropes at their speeds; a carriage on a shoe and a log stay
        in balance. The mainline's drum keeps its speed.
    compiled : bool, default False
        Whether to solve in compiled code, which needs a C compiler at first use: the same result.

    Returns
    -------
    Inhaul
        Rows and events.

    Raises
    ------
    InputError
        The rig has no mainline, a value is out of range, or rope nodes.
    SimulationError
        The carriage stops before `end`; `result` holds the run up to this point.
    CompiledError, CompilerError, WriteError
        Of `compiled`: the core does not support this rig, has no compiler, or its cache cannot be written.

    Examples
    --------
    >>> rig = rw.standing_skyline(
    ...     None, headspar=rw.HeadSpar("head", at=(0.0, 40.0)), tailspar=rw.TailSpar("tail", at=(200.0, 0.0)),
    ...     skyline="RHOL-IWRC 29", tension=60e3, mainline="6x19 EEIP 19", carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> rw.inhaul(rig, payload=1500.0, start=100.0, end=91.0)
    <Inhaul of 'standing skyline': 5 rows, 0 events>
    """
    check.number(speed, rig.name, "speed", "m/s", FASTEST)
    check.positive(every, rig.name, "every", "s")
    check.count(abs(end - start) / speed / every, rig.name, "records")
    check.not_negative(payload, rig.name, "payload", "kg")
    _require_run(rig, start, end, changes)
    if inertia is not None and inertia.nodes:
        raise InputError(
            f"{rig.name}: Inertia(nodes={inertia.nodes}) in an inhaul", "Use nodes=0: each rope is one catenary there"
        )
    run = CarriageRun(rig, float(payload), every, list(changes), tolerance, compiled=compiled, inertia=inertia)

    def result() -> Inhaul:
        return Inhaul(rig, run.frame(), run.event_frame())

    try:
        with keeping(result):
            run.go(float(start), float(end), speed if end < start else -speed)
    except EquilibriumError as error:
        raise SimulationError(error.cause, error.remedy, run.time, result()) from error
    except SimulationError as error:
        raise SimulationError(error.cause, error.remedy, run.time + (error.time or 0.0), result()) from error
    return result()


def _require_run(rig: SkylineRig, start: float, end: float, changes: Sequence[tuple[float, float]]) -> None:
    """Raises InputError for a rig that cannot haul between the stations, and for changes out of order."""
    require_pulled(rig)
    if rig.turn is not None and rig.turn.log.moving not in (0.0, np.sign(end - start)):
        raise InputError(
            f"{rig.turn.log.described} moves the opposite way", "Give it moving=-1 for inhaul, 1 for outhaul"
        )
    last = 0.0
    for when, mass in changes:
        check.not_negative(mass, rig.name, "payload", "kg")
        if not when > last:
            raise InputError(f"{rig.name}: changes of the payload at {when:g} s after {last:g} s", "Sort them by time")
        last = when
    for station in (start, end):
        rig.span_of(station)
