"""A run of a carriage, integrated place by place, with rows on one time grid and events."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd

from ropeway.components.errors import EquilibriumError, Interrupted, RopewayError, SimulationError
from ropeway.components.inertia import Inertia
from ropeway.systems.dynamics.result import Result
from ropeway.systems.dynamics.simulation import simulate
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.equilibrium import Equilibrium
from ropeway.systems.statics.line_state import span_rope
from ropeway.systems.studies.skyline.carriage_model import Place, Solved, SpanModel
from ropeway.systems.studies.skyline.carriage_route import Places
from ropeway.systems.studies.skyline.inhaul import moving_carriage as moving
from ropeway.systems.studies.skyline.limits import LoadLimits, margins_of
from ropeway.systems.studies.skyline.station_row import StationRow, station_row, units_of
from ropeway.systems.studies.skyline.station_solver import NEAR, SIDE


class CarriageEvent(NamedTuple):
    """An event of the carriage: time [s], description, and station [m]."""

    time: float
    event: str
    station: float


class CarriageRun:
    """One run of the carriage, place by place; rows and events are appended. With inertia `moving` is the state of the
    carriage that swings in its present place, None where it has just come there."""

    def __init__(
        self,
        rig: SkylineRig,
        payload: float,
        every: float,
        changes: list[tuple[float, float]],
        tolerance: float,
        *,
        compiled: bool,
        inertia: Inertia | None = None,
    ) -> None:
        self.inertia = inertia
        self.moving: Equilibrium | None = None
        self.rig, self.payload, self.every, self.changes, self.tolerance = rig, payload, every, changes, tolerance
        self.compiled = compiled
        self.time = 0.0
        self.rows: list[StationRow] = []
        self.events: list[CarriageEvent] = []
        self.margins = margins_of(rig, LoadLimits(rig.skyline.safety_factor))
        self.exceeded: set[str] = set()

    def frame(self) -> pd.DataFrame:
        """The rows so far, index time [s]."""
        frame = pd.DataFrame(self.rows)
        if len(frame):
            frame = frame.set_index("time")
        more = {"carriage_speed": "m/s", "drum_power": "W", "haulback_power": "W", "time": "s"}
        frame.attrs["units"] = {**units_of(frame), **more}
        return frame

    def event_frame(self) -> pd.DataFrame:
        """The events so far: time, event, station."""
        return pd.DataFrame(self.events, columns=list(CarriageEvent._fields))

    def go(self, start: float, end: float, speed: float) -> None:
        """Runs the carriage from one station to another. `speed` of the drum is positive for winding in."""
        direction = -1 if speed > 0.0 else 1
        first = self.places.placed(start)
        at, eq = first.at, first.at.rest(first.point)
        self.record(at, eq, speed)
        try:
            last = self.places.placed(end).at.place
        except EquilibriumError:  # the payload at the end may differ
            last = Place(self.rig.span_of(end))
        while at.place != last:
            eq = self.through(at, eq, partial(self.border, at, last, direction), speed)
            following = self.next(at, last, direction)
            try:
                at, eq = following, self.over(at, following, eq, direction, speed)
            except EquilibriumError as error:
                self.record(at, eq, speed)
                raise self.stopped(eq, speed, error) from error
        eq = self.through(at, eq, lambda: end, speed)
        self.record(at, eq, speed)

    @property
    def places(self) -> Places:
        """The places of the carriage with its present payload."""
        return Places(self.rig, self.payload, self.compiled)

    def next(self, at: SpanModel, last: Place, direction: int) -> SpanModel:
        """The next place on the carriage's route."""
        places = self.places
        order = places.in_order()
        following = places.model(order[order.index(at.place) + direction])
        while following.place != last and not (
            places.laid(following) and (following.on is None or self.rolls(following.on))
        ):
            following = places.model(order[order.index(following.place) + direction])
        return following

    def rolls(self, k: int) -> bool:
        """Whether the carriage rolls over the shoe of support k, or onto it as far as the mainline holds it."""
        try:
            return self.places.rolls(k)
        except EquilibriumError:
            return True

    def border(self, at: SpanModel, last: Place, direction: int) -> float:
        """Station at which the carriage changes to the next place, for its current payload [m]."""
        return self.places.border(at, self.next(at, last, direction), direction)

    def through(self, at: SpanModel, eq: Equilibrium, target: Callable[[], float], speed: float) -> Equilibrium:
        """Integrates to a station of the same place and applies changes of the payload on the way. Raises
        EquilibriumError where the carriage stops."""
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
            if self.moving is not None:
                self.moving = moving.loaded(self.moving, at, self.payload)
            self.record(at, eq, speed)

    def towards(
        self, at: SpanModel, eq: Equilibrium, target: Callable[[], float], speed: float
    ) -> tuple[Point, EquilibriumError | None]:
        """The equilibrium at a station of the same place; or the farthest one towards it, and the error that stops the
        carriage."""
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

    def stopped(self, eq: Equilibrium, speed: float, reason: RopewayError) -> EquilibriumError:
        """The error of a carriage that stops. If the mainline would have to push just ahead, the error says so."""
        x, direction = eq[f"{self.rig.carriage.name}.x"], -1 if speed > 0.0 else 1
        first, last = self.rig.points[[0, self.rig.spans], 0]
        for ahead in (NEAR, 1.0, 3.0):
            if first < x + direction * ahead < last:
                try:
                    self.places.placed(x + direction * ahead)
                except EquilibriumError as error:
                    reason = error
                    break
        cause = f"The carriage of {self.rig.name!r} stops at station {x:.6g} m. {reason.cause}"
        return EquilibriumError(cause, reason.remedy)

    def integrate(self, at: SpanModel, eq: Equilibrium, duration: float, speed: float) -> Equilibrium:
        """Integrates over a duration [s]. The ground under a log is updated in steps shorter than the distance between
        vertices."""
        ground = self.rig.terrain
        if at.log is None or ground is None:
            return self.integrate_smooth(at, eq, duration, speed)
        # Both vertices of a segment describe the same ground at its middle, so half of the shortest segment is
        # paid on each side.
        most = 0.25 * float(np.diff(ground.station).min()) / abs(speed)
        count = max(1, int(np.ceil(duration / most)))
        for _ in range(count):
            point = eq.point.copy()
            at.ground_under(point)
            eq = self.integrate_smooth(at, at.rest(point), duration / count, speed)
        return eq

    def integrate_smooth(self, at: SpanModel, eq: Equilibrium, duration: float, speed: float) -> Equilibrium:
        """Integrates over a duration [s] in which the equations do not change; rows on the grid of the whole run."""
        if duration < 1e-9:
            return eq
        try:
            result = simulate(
                at.model,
                until=duration,
                every=min(self.every, duration, self.pace(at, duration, speed)),
                inputs={"mainline.speed": -speed},
                start=self.moving or eq,
                tolerance=self.tolerance,
                progress=False,
                compiled=self.compiled and self.inertia is not None,
                inertia=self.inertia,
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
            reason = self.stopped(last, speed, error)
            raise SimulationError(reason.cause, reason.remedy, error.time) from error
        self.record_all(at, result, speed)
        end = result.at(duration)
        self.time += duration
        if self.inertia is None:
            return at.rest(end.point)
        self.moving = end
        return at.rest(moving.come_to_rest(at, end))

    def record_all(self, at: SpanModel, result: Result, speed: float) -> None:
        """Appends the rows of a section that begins now, on the grid of the whole run."""
        last = float(result.times[-1])
        first = self.every * (np.floor(self.time / self.every + 1e-9) + 1.0)
        for t in np.arange(first, self.time + last + 1e-9, self.every):
            self.record(at, result.at(min(t - self.time, last)), speed, float(t))

    def pace(self, at: SpanModel, duration: float, speed: float) -> float:
        """Longest output interval [s]: the balance changes fast on a shoe, and where a log drags over a vertex of the
        ground."""
        if at.log is not None:
            return 0.1 / abs(speed)
        return duration / 40.0 if at.on is not None else duration

    def over(self, at: SpanModel, following: SpanModel, eq: Equilibrium, direction: int, speed: float) -> Equilibrium:
        """Changes to the next place. The carriage waits on a point saddle while the drum runs, unless the mainline's
        length already allows the next place."""
        name, self.moving = self.rig.carriage.name, None
        support = self.rig.supports[min(at.span, following.span)]
        x = eq[f"{name}.x"]
        if support.radius == 0.0:
            x = float(self.rig.points[min(at.span, following.span) + 1, 0]) + direction * SIDE
        elif at.on is None and following.on is None and at.span != following.span:
            x = self.places.edge(min(at.span, following.span), direction)
        paid = self.places.paid_out(at, eq.point)
        point = (
            self.places.solve(following, x)
            if support.radius > 0.0
            else self.places.first(following, x, direction, paid)
        )
        required = self.places.paid_out(following, point)
        delay = (paid - required) / speed
        if at.on is None and (following.on is not None or at.span != following.span):
            self.events.append(CarriageEvent(self.time, f"reaches {support.name}", eq[f"{name}.x"]))
        if delay >= 0.0 and abs(following.read(point, following.axes[0]) - x) < NEAR:
            self.time += delay
        else:  # the mainline's length already suits a station further on: the carriage jumps ahead
            index = following.model.p.index
            run = following.model.runs[following.roles.index("mainline")]
            point.p[index[f"{run.spans[0].name}.length_start"]] += paid - required
            newton_of(following.model).solve(point)
            following.check.require(point)
        if following.on is None and (at.on is not None or at.span != following.span):
            self.events.append(CarriageEvent(self.time, f"leaves {support.name}", float(point.z[following.axes[0][1]])))
        return following.rest(point)

    def record(self, at: SpanModel, eq: Equilibrium, speed: float, time: float | None = None) -> None:
        """Appends a row, at most one per time and payload. Raises EquilibriumError if the mainline is slack."""
        if time is None and self.moving is not None:
            eq = self.moving
        now = self.time if time is None else time
        if self.rows:
            before = self.rows[-1]
            if abs(float(before["time"]) - now) < 1e-9 and (before["payload"], before["span"]) == (
                self.payload,
                at.span + 1,
            ):
                return
        solved, rate = moving.seen(at, eq) if eq.model.inertia is not None else self.balanced(at, eq, speed)
        name = self.rig.carriage.name
        values = station_row(solved, solved[f"{name}.x"])
        exceeded = {limit for limit, margin in self.margins.items() if margin(solved) < 0.0}
        for limit in sorted(exceeded - self.exceeded):
            self.events.append(CarriageEvent(now, f"beyond {limit}", solved[f"{name}.x"]))
        self.exceeded = exceeded
        drum = speed * _carried(solved, "mainline", solved["mainline.rope_tension"])
        haulback_power = 0.0
        if "haulback.travel" in at.model.z.index and "haulback.rope_tension" in at.model.y.index:
            role = "skyline" if self.rig.haulback is None else "haulback"
            haulback_power = -rate("haulback.travel") * _carried(solved, role, solved["haulback.rope_tension"])
        self.rows.append(
            {
                "time": now,
                **values,
                "payload": self.payload,
                "carriage_speed": float(rate(f"{name}.x")),
                "drum_power": float(drum),
                "haulback_power": float(haulback_power),
            }
        )

    def balanced(self, at: SpanModel, eq: Equilibrium, speed: float) -> tuple[Solved, moving.Rate]:
        """A state in balance as rows read it, and its rates. Raises EquilibriumError if the mainline is slack."""
        at.check.require(eq.point)
        solved = Solved(at, eq.point, at.outputs(eq.point), "mainline")
        point = eq.point.copy()
        point.u[at.model.u.shared :] = 0.0  # all speeds, not the weather
        if "mainline.speed" in at.model.u.index:
            point.u[at.model.u.index["mainline.speed"]] = -speed
        rates = newton_of(at.model).solve(point, slope=np.zeros(len(point.u)))
        return solved, lambda name: 0.0 if rates is None else float(rates[at.model.z.index[name]])


def _carried(solved: Solved, role: str, tension: float) -> float:
    """Energy that each metre of a rope carries at a tension [N]; 0 without the rope."""
    at = solved.at
    if role not in at.roles:
        return 0.0
    rope = span_rope(at.model, at.model.runs[at.roles.index(role)], 0, solved.__getitem__)
    return float(rope.strain.potential(tension))
