"""The places of a carriage in order (spans and shoes), and the stations between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq, newton

from ropeway.components.errors import EquilibriumError, InputError
from ropeway.systems.rigs.rope_paths import roller_name
from ropeway.systems.rigs.skyline_rig import STEEPEST, SkylineRig
from ropeway.systems.solvers.points import Point
from ropeway.systems.studies.skyline.carriage_model import Place, Solved, SpanModel, StationCase, span_model
from ropeway.systems.studies.skyline.root_selection import physical_state
from ropeway.systems.studies.skyline.starting_points import off_shoe
from ropeway.systems.studies.skyline.station_solver import SIDE, Stations

EDGE = 1e-3
"""Length of rope off the shoe [m] at which a carriage leaves it."""

TOUCH = 0.5 * EDGE
"""Length of rope between carriage and shoe [m] at which the carriage rolls onto it: less than `EDGE`, so that it does
not alternate."""


@dataclass(frozen=True)
class Places:
    """The places of a rig's carriage with a payload [kg], solved in compiled code or not."""

    rig: SkylineRig
    payload: float
    compiled: bool = False

    def model(self, place: Place) -> SpanModel:
        """The model of a place."""
        return span_model(self.rig, place, compiled=self.compiled)

    def rolls(self, k: int) -> bool:
        """Whether the carriage rolls over the shoe of support k as the mainline's drum turns. It jumps over the shoe if
        the stretch of a long mainline changes by more than the length of the shoe."""
        return _rolls(self, k)

    def in_order(self) -> list[Place]:
        """All places of the carriage in the order of their stations."""
        found = []
        for k in range(self.rig.spans):
            found.append(Place(k))
            if k < len(self.rig.supports) and self.rig.supports[k].radius > 0.0:
                found += [Place(k, rollers=k + 1), Place(k, k)]
        return found

    def placed(self, x: float) -> Solved:
        """The carriage at a station. Raises EquilibriumError where the mainline would have to push."""
        found = Stations(self.rig, compiled=self.compiled).solve(x, self.payload)
        if found.held_by != "mainline":
            raise EquilibriumError(
                f"At station {x:g} m the mainline of {self.rig.name!r} would have to push",
                "Give it a haulback with a higher tension",
            )
        return found

    def on_shoe(self, k: int, x: float) -> Solved:
        """The carriage held on the shoe of support k."""
        at = self.model(Place(k, k))
        point = physical_state(at, StationCase(x, self.payload))
        return Solved(at, point, at.outputs(point), "mainline")

    def solve(self, at: SpanModel, x: float, near: Point | None = None) -> Point:
        """The equilibrium at a station. Near a shoe the initial guess is the carriage held on it."""
        k = self.rig.shoe_near(x) if at.on is None else None
        if k is not None and abs(x - self.rig.supports[k].centre[0]) < STEEPEST * self.rig.supports[k].radius:
            near = off_shoe(at, self.on_shoe(k, x))
        return physical_state(at, StationCase(x, self.payload), [] if near is None else [near])

    def first(self, at: SpanModel, x: float, direction: int, paid: float) -> Point:
        """The equilibrium past a point saddle, at station x. Where the mainline would have to push there, the first
        equilibrium further on in `direction` that the mainline holds: the one nearest to its `paid` length [m]. Raises
        EquilibriumError."""
        try:
            return self.solve(at, x)
        except EquilibriumError as error:
            failure = error
        low, high = at.reach
        best: Point | None = None
        for ahead in np.geomspace(2.0 * SIDE, 0.5 * (high - low), 16):
            try:
                point = self.solve(at, x + direction * float(ahead), best)
            except EquilibriumError:
                if best is not None:
                    break
                continue
            if best is not None and abs(self.paid_out(at, point) - paid) > abs(self.paid_out(at, best) - paid):
                break
            best = point
        if best is None:
            raise failure
        return best

    def edge(self, k: int, side: int) -> float:
        """Station at which the carriage leaves the shoe of support k, before (-1) or after (1) its middle [m]."""
        return _edge(self, k, side)

    def touch(self, at: SpanModel, k: int) -> float:
        """Station at which the carriage rolls from a span onto the shoe of support k [m]."""
        side = -1 if at.span == k else 1
        edge, free = self.edge(k, side), at.model.y.index[f"{at.free_span(k)}.length"]

        def gap(x: float) -> float:
            return float(at.outputs(self.solve(at, x))[free]) - TOUCH

        return float(newton(gap, edge, x1=edge + 0.1 * side * EDGE, tol=1e-11))

    def laid(self, at: SpanModel) -> bool:
        """Whether the carriage passes a place. The mainline touches a roller ahead of the carriage only if it sags
        enough."""
        k = at.span
        if at.place.rollers is None:
            return True
        return self.on_shoe(k, self.edge(k, -1))[f"{self.rig.carriage.name}.mainline_rope"] > 0.0

    def border(self, at: SpanModel, following: SpanModel, direction: int) -> float:
        """Station at which the carriage changes from one place to the next [m]."""
        k = min(at.span, following.span)
        if self.rig.supports[k].radius <= 0.0:
            return float(self.rig.points[k + 1, 0] - direction * SIDE)
        if at.on is not None:
            return self.edge(k, direction)
        if following.on is not None or at.span != following.span:
            return self.touch(at, k)
        rolled = at if at.place.rollers is not None else following
        roller, low = roller_name(self.rig.supports[k]), self.edge(k, -1)

        def roller_contact(x: float) -> float:
            point = self.solve(rolled, x)
            found = Solved(rolled, point, rolled.outputs(point), "mainline")
            return found[f"{roller}.a_rope"] - found[f"{roller}.b_rope"]

        reach = 0.02 * self.rig.supports[k].radius
        while roller_contact(low - reach) > 0.0:
            reach *= 1.5
        return float(brentq(roller_contact, low - reach, low, xtol=1e-8))

    def paid_out(self, at: SpanModel, point: Point) -> float:
        """Unstretched length of the mainline [m], including rope on rollers."""
        layout = at.model.layouts[at.roles.index("mainline")]
        return float(point.p[layout.length_start].sum() + layout.travel.read(point.x, point.z)[0])


@lru_cache(maxsize=64)
def _rolls(places: Places, k: int) -> bool:
    at = places.model(Place(k, k))
    steps = np.linspace(places.edge(k, -1), places.edge(k, 1), 13)
    return bool(
        np.all(
            np.diff([places.paid_out(at, physical_state(at, StationCase(float(x), places.payload))) for x in steps])
            > 0.0
        )
    )


@lru_cache(maxsize=64)
def _edge(places: Places, k: int, side: int) -> float:
    support = places.rig.supports[k]
    middle, *_ = support.at
    # The arc of the shoe ends at its circle's edge; the carriage leaves it well before.
    limit = 0.99 * STEEPEST * support.radius + side * (support.centre[0] - middle)

    def off(x: float) -> float:
        return places.on_shoe(k, x).off_shoe - EDGE

    if off(middle) > 0.0:
        raise EquilibriumError(f"The skyline lifts off the shoe of {support.name!r}", "Raise it, or reduce the tension")
    reach = 0.05 * support.radius
    while off(middle + side * reach) < 0.0 and reach < limit:
        reach = min(1.5 * reach, limit)
    return float(brentq(off, middle, middle + side * reach, xtol=1e-10))


def require_pulled(rig: SkylineRig) -> None:
    """Raises InputError for a rig without a mainline that pulls the carriage."""
    if rig.mainline is None or rig.carriage.clamped:
        raise InputError(f"{rig.name} has no mainline to pull with", "Give it mainline= and a rolling carriage")
