"""A skyline rig in time: the carriage pulled by the mainline's drum, over its supports, with payloads picked up,
hoisted on or lost on the way."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.check import Range
from ropeway.components.errors import EquilibriumError, InputError, Interrupted, RopewayError, SimulationError
from ropeway.components.table_writer import Tabular
from ropeway.systems.dynamics.result import Result
from ropeway.systems.dynamics.simulation import simulate
from ropeway.systems.interrupts import interruptible, keeping
from ropeway.systems.reporting.blocks import Section
from ropeway.systems.reporting.document import Project, ReportOptions, write_report
from ropeway.systems.reporting.style import Units
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.solvers.newton import Point, newton_of, outputs_of
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.studies.skyline.carriage_model import Place, Solved, SpanModel, span_model
from ropeway.systems.studies.skyline.carriage_route import Places, require_pulled
from ropeway.systems.studies.skyline.limits import LoadLimits, margins_of
from ropeway.systems.studies.skyline.station_row import StationRow, station_row, units_of
from ropeway.systems.studies.skyline.station_solver import NEAR, SIDE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class CarriageEvent(NamedTuple):
    """Something that happened to the carriage: time [s], what, and where [m]."""

    time: float
    event: str
    station: float


FASTEST = Range(0.0, 100.0, above=True)
"""Speeds of a carriage [m/s]; more is a mistake of units."""


@checked
@dataclass(frozen=True, eq=False)
class Inhaul(Tabular):
    """A run of the carriage, as `rw.inhaul` returns it.

    Parameters
    ----------
    rig : SkylineRig
        The skyline.
    frame : DataFrame
        One row every interval (index time [s]), none while the carriage rests at a saddle: the columns of
        `rw.load_path`, and payload [kg], carriage_speed [m/s], drum_power of the mainline and haulback_power [W,
        positive: the drum drives, negative: it brakes].
    events : DataFrame
        Columns time, event, station: supports reached and left, changes of the payload, and at the rows "beyond" a
        limit of `rw.payload`: a tension its safe working load, a spar or support its capacity, lift-off.
    """

    rig: SkylineRig
    frame: pd.DataFrame
    events: pd.DataFrame

    def __repr__(self) -> str:
        return f"<Inhaul of {self.rig.name!r}: {len(self.frame)} rows, {len(self.events)} events>"

    def report(
        self,
        path: str | Path,
        *,
        project: Project | None = None,
        units: Units = "metric",
        labels: Mapping[str, str] | None = None,
        more: Sequence[Section] = (),
    ) -> Path:
        """Write the report of the run: the moving carriage, tensions, powers and events.

        Parameters
        ----------
        path : str or Path
            HTML, or PDF by a browser's print; needs the extra `report`.
        project : Project, optional
            Title, place, client, author and a remark.
        units : {"metric", "imperial"}, default "metric"
        labels : mapping, optional
            Words in place of those of `ropeway.systems.reporting.labels.ENGLISH`, by key.
        more : sequence of Section, optional
            Sections of your own after the others.

        Returns
        -------
        Path

        Raises
        ------
        InputError
            The name of the file, an option, or a missing package or browser.
        WriteError
            The file could not be written.
        """
        from ropeway.systems.studies.skyline.reporting.path_report import inhaul_sections

        options = ReportOptions(project, units, labels, more)
        style = options.style
        return write_report(path, self.rig.name, inhaul_sections(self.rig, self.frame, self.events, style), options)

    def plot(self) -> Figure:
        """Station of the carriage, tensions and powers over time.

        Returns
        -------
        Figure
            The tensions against the safe working loads.
        """
        from ropeway.systems.studies.skyline.inhaul_plot import inhaul_figure

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
) -> Inhaul:
    """The carriage pulled from one station to another by the mainline's drum.

    The rig needs a real mainline; one that the carriage cannot outrun: where the mainline would go slack the run stops,
    as the carriage has to be braked by a haulback there. At a point saddle the carriage changes spans as soon as the
    mainline's length allows; on a support with a radius it rolls over the shoe, unless the stretch of a long mainline
    changes by more than the length of the shoe: then it runs over the shoe at once.

    Parameters
    ----------
    rig : SkylineRig
        The skyline, with a mainline.
    payload : float
        At the start [kg].
    start, end : float
        Stations of the carriage [m].
    speed : float, default 3.0
        Of the mainline at its drum, above zero [m/s of unstretched rope].
    every : float, default 1.0
        Interval of the rows [s].
    changes : sequence of (float, float), default ()
        Time [s], and payload from then on [kg]: a turn picked up, or lost.
    tolerance : float, default 1e-8
        Relative, of the integration.

    Returns
    -------
    Inhaul
        Rows and events.

    Raises
    ------
    InputError
        The rig has no mainline, or a value is out of its range.
    SimulationError
        The carriage stops on the way; `result` holds the run up to there.

    Examples
    --------
    >>> rig = rw.standing_skyline(
    ...     None, headspar=rw.HeadSpar("head", at=(0.0, 40.0)), tailspar=rw.TailSpar("tail", at=(200.0, 0.0)),
    ...     skyline="RHOL-IWRC 29", tension=60e3, mainline="6x19 EEIP 19", carriage=rw.Carriage("carriage", mass=450.0),
    ... )
    >>> inhaul(rig, payload=1500.0, start=100.0, end=91.0)
    <Inhaul of 'standing skyline': 5 rows, 0 events>
    """
    check.number(speed, rig.name, "speed", "m/s", FASTEST)
    check.positive(every, rig.name, "every", "s")
    check.count(abs(end - start) / speed / every, rig.name, "records")
    check.not_negative(payload, rig.name, "payload", "kg")
    require_pulled(rig)
    if rig.turn is not None and rig.turn.log.moving not in (0.0, np.sign(end - start)):
        raise InputError(f"{rig.turn.log.described} moves the other way", "Give it moving=-1 for inhaul, 1 for outhaul")
    last = 0.0
    for when, mass in changes:
        check.not_negative(mass, rig.name, "payload", "kg")
        if not when > last:
            raise InputError(f"{rig.name}: changes of the payload at {when:g} s after {last:g} s", "Sort them by time")
        last = when
    for station in (start, end):
        rig.span_of(station)
    run = _Run(rig, float(payload), every, list(changes), tolerance)
    try:
        with keeping(run.result):
            run.go(float(start), float(end), speed if end < start else -speed)
    except EquilibriumError as error:
        raise SimulationError(error.cause, error.remedy, run.time, run.result()) from error
    except SimulationError as error:
        raise SimulationError(error.cause, error.remedy, run.time + (error.time or 0.0), run.result()) from error
    return run.result()


class _Run:
    """One run, span by span; rows and events are appended."""

    def __init__(
        self, rig: SkylineRig, payload: float, every: float, changes: list[tuple[float, float]], tolerance: float
    ) -> None:
        self.rig, self.payload, self.every, self.changes, self.tolerance = rig, payload, every, changes, tolerance
        self.time = 0.0
        self.rows: list[StationRow] = []
        self.events: list[CarriageEvent] = []
        self.margins = margins_of(rig, LoadLimits(rig.skyline.safety_factor))
        self.beyond: set[str] = set()

    def result(self) -> Inhaul:
        frame = pd.DataFrame(self.rows)
        if len(frame):
            frame = frame.set_index("time")
        frame.attrs["units"] = {
            **units_of(frame),
            "carriage_speed": "m/s",
            "drum_power": "W",
            "haulback_power": "W",
            "time": "s",
        }
        return Inhaul(self.rig, frame, pd.DataFrame(self.events, columns=list(CarriageEvent._fields)))

    def go(self, start: float, end: float, speed: float) -> None:
        """speed: of the drum, positive winds in."""
        way = -1 if speed > 0.0 else 1
        first = self.places.placed(start)
        at, eq = first.at, first.at.rest(first.point)
        self.record(at, eq, speed)
        try:
            last = self.places.placed(end).at.place
        except EquilibriumError:  # with this payload; it may be another by then
            last = Place(self.rig.span_of(end))
        while at.place != last:
            eq = self.through(at, eq, partial(self.border, at, last, way), speed)
            beyond = self.next(at, last, way)
            try:
                at, eq = beyond, self.over(at, beyond, eq, way, speed)
            except EquilibriumError as error:
                self.record(at, eq, speed)
                raise self.stopped(eq, speed, error) from error
        eq = self.through(at, eq, lambda: end, speed)
        self.record(at, eq, speed)

    @property
    def places(self) -> Places:
        """The places of the carriage with its present payload."""
        return Places(self.rig, self.payload)

    def next(self, at: SpanModel, last: Place, way: int) -> SpanModel:
        """The next place that the carriage comes through."""
        places = self.places
        order = places.in_order()
        beyond = span_model(self.rig, order[order.index(at.place) + way])
        while beyond.place != last and not (places.laid(beyond) and (beyond.on is None or self.rolls(beyond.on))):
            beyond = span_model(self.rig, order[order.index(beyond.place) + way])
        return beyond

    def rolls(self, k: int) -> bool:
        """Whether the carriage rolls over the shoe of support k, or on to it until the mainline holds it no more."""
        try:
            return self.places.rolls(k)
        except EquilibriumError:
            return True

    def border(self, at: SpanModel, last: Place, way: int) -> float:
        """Where the carriage goes over to the next place with the payload that it has by then [m]."""
        return self.places.border(at, self.next(at, last, way), way)

    def through(self, at: SpanModel, eq: Equilibrium, target: Callable[[], float], speed: float) -> Equilibrium:
        """On to a station of the same place, stopping where the payload changes. Raises EquilibriumError where the
        carriage comes no further."""
        while True:
            reached, stop = self.towards(at, eq, target, speed)
            needed = self.places.paid_out(at, eq.point) - self.places.paid_out(at, reached)
            duration = needed / speed
            change = self.changes[0][0] - self.time if self.changes else np.inf
            if duration > 0.0:
                eq = self.integrate(at, eq, min(duration, change), speed)
            if change > duration and stop is not None:
                self.record(at, eq, speed)
                raise self.stopped(eq, speed, stop) from stop
            if change > duration:
                return eq
            self.record(at, eq, speed)
            self.payload = self.changes.pop(0)[1]
            self.events.append(
                CarriageEvent(self.time, f"payload {self.payload:g} kg", eq[f"{self.rig.carriage.name}.x"])
            )
            point = eq.point.copy()
            at.load(point, self.payload)
            newton_of(at.model).solve(point)
            eq = at.rest(point)
            self.record(at, eq, speed)

    def towards(
        self, at: SpanModel, eq: Equilibrium, target: Callable[[], float], speed: float
    ) -> tuple[Point, EquilibriumError | None]:
        """The equilibrium at a station of the same place; or as far on the way there as there is one, and what stops
        the carriage."""
        try:
            return self.places.solve(at, target(), eq.point), None
        except EquilibriumError as error:
            stop = error
        reached, low = eq.point, eq[f"{self.rig.carriage.name}.x"]
        high = float(self.rig.points[at.span + (speed < 0.0), 0])
        while abs(high - low) > NEAR:
            middle = 0.5 * (low + high)
            try:
                found = self.places.placed(middle)
            except EquilibriumError as error:
                high, stop = middle, error
                continue
            if found.at.place == at.place:
                reached, low = found.point, middle
            else:
                high = middle
        return reached, stop

    def stopped(self, eq: Equilibrium, speed: float, why: RopewayError) -> EquilibriumError:
        """What is said of a carriage that comes no further: that the mainline would have to push a little beyond,
        where it is that."""
        x, way = eq[f"{self.rig.carriage.name}.x"], -1 if speed > 0.0 else 1
        first, last = self.rig.points[[0, self.rig.spans], 0]
        for ahead in (NEAR, 1.0, 3.0):
            if first < x + way * ahead < last:
                try:
                    self.places.placed(x + way * ahead)
                except EquilibriumError as error:
                    why = error
                    break
        cause = f"The carriage of {self.rig.name!r} comes no further than station {x:.6g} m. {why.cause}"
        return EquilibriumError(cause, why.remedy)

    def integrate(self, at: SpanModel, eq: Equilibrium, duration: float, speed: float) -> Equilibrium:
        """Some seconds on; a log takes the ground under it in pieces, each before it comes to the next vertex."""
        ground = self.rig.terrain
        if at.log is None or ground is None:
            return self.integrate_smooth(at, eq, duration, speed)
        # Both vertices of a segment say the same of its middle: half of the shortest one on each side is free.
        most = 0.25 * float(np.diff(ground.station).min()) / abs(speed)
        count = max(1, int(np.ceil(duration / most)))
        for _ in range(count):
            point = eq.point.copy()
            at.ground_under(point)
            eq = self.integrate_smooth(at, at.rest(point), duration / count, speed)
        return eq

    def integrate_smooth(self, at: SpanModel, eq: Equilibrium, duration: float, speed: float) -> Equilibrium:
        """Some seconds on equations that do not change; rows on the grid of the whole run."""
        if duration < 1e-9:
            return eq
        try:
            result = simulate(
                at.model,
                until=duration,
                every=min(self.every, duration, self.pace(at, duration, speed)),
                inputs={"mainline.speed": -speed},
                start=eq,
                tolerance=self.tolerance,
                progress=False,
            )
        except Interrupted as interrupted:
            if isinstance(interrupted.result, Result):
                self.record_all(at, interrupted.result, speed)
            raise
        except SimulationError as error:
            if not isinstance(error.result, Result):
                raise
            self.record_all(at, error.result, speed)
            last = error.result.at(float(error.result.times[-1]))
            self.record(at, last, speed, self.time + last.point.t)
            why = self.stopped(last, speed, error)
            raise SimulationError(why.cause, why.remedy, error.time) from error
        self.record_all(at, result, speed)
        self.time += duration
        return at.rest(result.at(duration).point)

    def record_all(self, at: SpanModel, result: Result, speed: float) -> None:
        """Rows of a stretch that begins now, on the grid of the whole run."""
        last = float(result.times[-1])
        first = self.every * (np.floor(self.time / self.every + 1e-9) + 1.0)
        for t in np.arange(first, self.time + last + 1e-9, self.every):
            self.record(at, result.at(min(t - self.time, last)), speed, float(t))

    def pace(self, at: SpanModel, duration: float, speed: float) -> float:
        """Longest step [s]: the balance turns fast on a shoe, and where a log drags over a vertex of the ground."""
        if at.log is not None:
            return 0.1 / abs(speed)
        return duration / 40.0 if at.on is not None else duration

    def over(self, at: SpanModel, beyond: SpanModel, eq: Equilibrium, way: int, speed: float) -> Equilibrium:
        """Over to the next place: at once where the mainline is long or short enough for it, else after the drum has
        run on while the carriage rests on a point saddle."""
        name = self.rig.carriage.name
        support = self.rig.supports[min(at.span, beyond.span)]
        x = eq[f"{name}.x"]
        if support.radius == 0.0:
            x = float(self.rig.points[min(at.span, beyond.span) + 1, 0]) + way * SIDE
        elif at.on is None and beyond.on is None and at.span != beyond.span:
            x = self.places.edge(min(at.span, beyond.span), way)
        have = self.places.paid_out(at, eq.point)
        point = self.places.solve(beyond, x) if support.radius > 0.0 else self.places.first(beyond, x, way, have)
        need = self.places.paid_out(beyond, point)
        wait = (have - need) / speed
        if at.on is None and (beyond.on is not None or at.span != beyond.span):
            self.events.append(CarriageEvent(self.time, f"reaches {support.name}", eq[f"{name}.x"]))
        if wait >= 0.0 and abs(beyond.read(point, beyond.axes[0]) - x) < NEAR:
            self.time += wait
        else:  # the mainline is longer or shorter than the next place asks for: the carriage runs ahead
            index = beyond.model.p.index
            run = beyond.model.runs[beyond.roles.index("mainline")]
            point.p[index[f"{run.spans[0].name}.length_start"]] += have - need
            newton_of(beyond.model).solve(point)
            beyond.check.require(point)
        if beyond.on is None and (at.on is not None or at.span != beyond.span):
            self.events.append(CarriageEvent(self.time, f"leaves {support.name}", float(point.z[beyond.axes[0][1]])))
        return beyond.rest(point)

    def record(self, at: SpanModel, eq: Equilibrium, speed: float, time: float | None = None) -> None:
        """Writes a row down, once for each time and payload. Raises EquilibriumError where the mainline hangs
        slack."""
        at.check.require(eq.point)
        now = self.time if time is None else time
        if self.rows:
            before = self.rows[-1]
            if abs(float(before["time"]) - now) < 1e-9 and (before["payload"], before["span"]) == (
                self.payload,
                at.span + 1,
            ):
                return
        outputs = outputs_of(at.model)(*eq.point.arguments)[0].copy()
        solved = Solved(at, eq.point, outputs, "mainline")
        name = self.rig.carriage.name
        values = station_row(solved, solved[f"{name}.x"])
        beyond = {limit for limit, margin in self.margins.items() if margin(solved) < 0.0}
        for limit in sorted(beyond - self.beyond):
            self.events.append(CarriageEvent(now, f"beyond {limit}", solved[f"{name}.x"]))
        self.beyond = beyond
        point = eq.point.copy()
        point.u[:] = 0.0
        if "mainline.speed" in at.model.u.index:
            point.u[at.model.u.index["mainline.speed"]] = -speed
        solution = newton_of(at.model).solve(point, slope=np.zeros(len(point.u)))
        rates = np.zeros(len(point.z)) if solution is None else solution
        main = self.rig.mainline
        index = at.model.z.index
        pull = solved["mainline.rope_tension"]
        drum = speed * (main.strain.potential(pull) if main is not None else 0.0)
        haul = 0.0
        if "haulback.travel" in index and "haulback.rope_tension" in at.model.y.index:
            rope = self.rig.skyline if self.rig.haulback is None else self.rig.haulback
            haul = -rates[index["haulback.travel"]] * rope.strain.potential(solved["haulback.rope_tension"])
        self.rows.append(
            {
                "time": now,
                **values,
                "payload": self.payload,
                "carriage_speed": float(rates[index[f"{name}.x"]]),
                "drum_power": float(drum),
                "haulback_power": float(haul),
            }
        )
