"""The path of a skyline's carriage over its supports: one model of all its places, and the transitions between them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from typing import NamedTuple

import casadi as ca
import numpy as np

from ropeway.components import check, shoe
from ropeway.components.errors import EquilibriumError, InputError
from ropeway.components.rounding import at_least
from ropeway.fmu.exporting.switched_model import Read, SwitchedModel, SwitchedPart
from ropeway.systems.modelling.model_tables import Limits, VariableTable
from ropeway.systems.rigs.rig_builder import with_supports
from ropeway.systems.rigs.skyline_rig import SkylineRig
from ropeway.systems.solvers.points import Point
from ropeway.systems.statics.line_state import LineState, span_rope
from ropeway.systems.studies.skyline.carriage_model import Place, SpanModel, span_model
from ropeway.systems.studies.skyline.carriage_route import EDGE, TOUCH, Places, require_pulled
from ropeway.systems.studies.skyline.load_path import default_stations
from ropeway.systems.studies.skyline.payload.remarks import haulback_that_hauls
from ropeway.systems.studies.skyline.rig_check import SLACK
from ropeway.systems.studies.skyline.station_solver import SIDE

PENETRATION = 1e-7
"""Penetration at which a mainline makes contact with a roller [m]."""


@dataclass(frozen=True)
class PassageMargin:
    """Distance of the carriage from a transition to the place `target`; it becomes negative there.

    Without a target the carriage cannot go on. `event`: what happens there.
    """

    target: Place | None
    event: str
    of: Callable[[Read], ca.SX]


class Passage(NamedTuple):
    """Transition at a margin: number of the next place, or -1; event; jump of the unknowns, (nz,)."""

    to: int
    event: str
    jump: np.ndarray


class Corridor:
    """All places that a rig's carriage passes with a payload [kg], as one model.

    `rest`: the equilibrium at the start, at a station [m, by default the middle of the first span], with the model of
    its place; `state`: the same with the united model. Raises InputError, EquilibriumError.
    """

    def __init__(self, rig: SkylineRig, station: float | None = None, payload: float | None = None) -> None:
        mass = rig.carriage.payload if payload is None else payload
        check.not_negative(mass, rig.name, "payload", "kg")
        if station is None:
            station = 0.5 * (rig.stands[0].at[0] + rig.stands[1].at[0])
        rig.span_of(station)
        try:
            self._build(rig, station, mass)
        except EquilibriumError as error:
            tension = haulback_that_hauls(rig, default_stations(rig, 10.0), mass)
            if tension is None or tension <= (rig.haulback_tension or 0.0):
                raise
            remedy = f"A haulback tension of {at_least(tension / 1e3, 1)} kN holds the carriage at all stations"
            raise EquilibriumError(error.cause, remedy, error.component) from error

    def _build(self, rig: SkylineRig, station: float, mass: float) -> None:
        self.rig, self._places = rig, Places(rig, mass)
        self._require_pullable()
        placed = self._places.placed(station)
        at, self.rest = placed.at, placed.at.rest(placed.point)
        self._zero: dict[tuple[str, str, str], float] = {}
        start = self._zeroed(at, self.rest.point)
        self._masses = (mass, 0.0, *(mass + share * rig.carriage.mass for share in (1.0, 3.0, 10.0)))
        self._rolls = [self._places.rolls(k) for k in range(len(rig.supports))]
        self.order = [p for p in self._places.in_order() if p == at.place or self._comes_through(p)]
        for k, rolls in enumerate(self._rolls):
            if not rolls:
                self._require_run_over(k, at.place)
        self.margins = {place: tuple(self._margins(span_model(rig, place))) for place in self.order}
        """Margins of each place, in order."""
        borders = {
            (place, margin.target): self._border(place, margin.target)
            for place, margins in self.margins.items()
            for margin in margins
            if margin.target is not None
        }
        points = {target: after for (_, target), (_, after) in borders.items()}
        points[at.place] = start
        models = [span_model(rig, place) for place in self.order]
        parts = [SwitchedPart(one.model, points[one.place], self._shows(one)) for one in models]
        self.united = SwitchedModel(parts, f"{rig.carriage.name}.place", self._limits)
        self.state = LineState(self.united.model, self.united.point(self.order.index(at.place)), (), ())
        self.passages = [[self._passage(place, m, borders) for m in margins] for place, margins in self.margins.items()]

    @property
    def count(self) -> int:
        """Largest number of margins of a place."""
        return max(len(margins) for margins in self.margins.values())

    @property
    def mean_span(self) -> float:
        """Mean width of a span [m]."""
        return (self.rig.stands[-1].at[0] - self.rig.stands[0].at[0]) / self.rig.spans

    @cached_property
    def function(self) -> ca.Function:
        """(t, x, z, u, p, d) -> margins of the active place."""
        return self.united.switched("margins", self.margin_functions)

    @cached_property
    def margin_functions(self) -> list[ca.Function]:
        """Of each place (t, x, z, u, p, d) -> its margins, padded with large values."""
        by_model = dict(zip((part.model for part in self.united.parts), self.margins.values(), strict=True))

        def values(part: SwitchedPart, read: Read) -> list[ca.SX]:
            found = [margin.of(read) for margin in by_model[part.model]]
            return found + [ca.SX(1.0)] * (self.count - len(found))

        return self.united.cases("margins", values)

    def _passage(
        self, place: Place, margin: PassageMargin, borders: dict[tuple[Place, Place], tuple[Point, Point]]
    ) -> Passage:
        if margin.target is None:
            return Passage(-1, margin.event, np.zeros(len(self.united.model.z)))
        to = self.order.index(margin.target)
        before, after = (
            self.united.unknowns(self.united.parts[i], point.z)
            for i, point in zip((self.order.index(place), to), borders[place, margin.target], strict=True)
        )
        return Passage(to, margin.event, after - before)

    def _require_pullable(self) -> None:
        """Raises InputError unless the carriage can be pulled along the whole corridor."""
        rig = self.rig
        require_pulled(rig)
        if rig.turn is not None and rig.terrain is not None:
            log = rig.turn.log.described
            raise InputError(
                f"{log} drags over varying ground, which an FMU does not support", "Export the rig without its turn"
            )
        for support in rig.supports:
            if support.radius <= 0.0:
                raise InputError(
                    f"The path of a carriage over the point saddle of {support.name!r} is discontinuous",
                    "Give the support a radius, for example 1.5 m",
                )

    def _zeroed(self, at: SpanModel, point: Point) -> Point:
        """A point whose travels have the same zero in all places, so that they are continuous."""
        m, found = at.model, point.copy()
        for run, layout, role in zip(m.runs, m.layouts, at.roles, strict=True):
            keys = [(role or run.name, node.name, seat.name) for node, seat in zip(run.nodes, run.seats, strict=True)]
            rope = layout.start(point.p) - layout.travel.read(point.x, point.z)
            rope += self._zero.get(keys[-1], rope[-1]) - rope[-1]
            zero = np.array([self._zero.setdefault(key, float(r)) for key, r in zip(keys, rope, strict=True)])
            found.p[layout.length_start] = np.diff(zero)
            layout.travel.write(zero - rope, found.x, found.z)
        return found

    def _require_run_over(self, k: int, start: Place) -> None:
        """Raises InputError unless the carriage runs over support k at once in both directions.

        For a shoe that the carriage does not roll over.
        """
        places, shoe_of = self._places, self.rig.supports[k].name
        sides = [span_model(self.rig, self._to(k, way)) for way in (-1, 1)]
        paid = [
            [places.paid_out(at, places.solve(at, x)) for x in (places.touch(at, k), places.edge(k, way))]
            for at, way in zip(sides, (-1, 1), strict=True)
        ]
        if start.on == k or paid[0][0] <= paid[1][1] or paid[1][0] >= paid[0][1]:
            raise InputError(
                f"The carriage neither rolls over the shoe of {shoe_of!r} nor runs over it at once",
                f"{self._radius_that_rolls(k)}, or start the carriage elsewhere",
            )

    def _radius_that_rolls(self, k: int) -> str:
        """Remedy: the first of several radii with which the carriage rolls over the shoe of support k."""
        supports = self.rig.supports
        for radius in (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0):
            if radius <= supports[k].radius:
                continue
            shod = [replace(s, radius=radius if i == k else s.radius, slope=None) for i, s in enumerate(supports)]
            try:
                if Places(with_supports(self.rig, shod), self._places.payload).rolls(k):
                    return f"It rolls with a radius of {radius:g} m"
            except (EquilibriumError, InputError):
                continue
        return "Give the support another radius"

    def _to(self, k: int, way: int) -> Place:
        """The place behind the shoe of support k, in direction `way`."""
        rolled = Place(k, rollers=k + 1)
        if way > 0:
            return Place(k + 1)
        return rolled if self._places.laid(span_model(self.rig, rolled)) else Place(k)

    def _comes_through(self, place: Place) -> bool:
        """Whether the carriage passes a place, with its payload or empty."""
        if place.on is not None:
            return self._rolls[place.on]
        return any(Places(self.rig, mass).laid(span_model(self.rig, place)) for mass in self._masses[:2])

    def _border(self, place: Place, target: Place) -> tuple[Point, Point]:
        """The points of both places at a transition, with the payload.

        Another mass is used if the transition exists only with that one.
        """
        at, beyond = span_model(self.rig, place), span_model(self.rig, target)
        way = 1 if self.order.index(target) > self.order.index(place) else -1
        last: EquilibriumError | None = None
        for mass in self._masses:
            places = Places(self.rig, mass)
            try:
                there = here = places.border(at, beyond, way)
                if at.on is None and beyond.on is None and at.span != beyond.span:
                    there = places.edge(min(at.span, beyond.span), way)
                points = [self._zeroed(one, places.solve(one, x)) for one, x in ((at, here), (beyond, there))]
            except EquilibriumError as error:
                last = error
                continue
            for one, point in zip((at, beyond), points, strict=True):
                one.load(point, self._places.payload)
            return points[0], points[1]
        raise last or EquilibriumError("The carriage does not reach the transition", "Check its supports")

    def _margins(self, at: SpanModel) -> Iterator[PassageMargin]:
        if at.on is not None:
            yield from self._off_shoe(at.on)
        else:
            yield from self._in_span(at)
        carriage = self.rig.carriage.name

        def taut(read: Read) -> ca.SX:
            turns = []
            for span in at.check.taut:
                across, down, up = (read(f"{span}.{q}") for q in ("horizontal", "vertical_a", "vertical_b"))
                turns.append(ca.asinh(up / (across + 1e-9)) + ca.asinh(down / (across + 1e-9)))
            return SLACK - reduce(ca.fmax, turns)

        yield PassageMargin(None, f"a line of {carriage} is slack", taut)
        spans = [span.name for run in at.model.runs for span in run.spans]
        yield PassageMargin(
            None, "no rope is left in a span", lambda read: reduce(ca.fmin, [read(f"{s}.length") for s in spans])
        )

    def _off_shoe(self, k: int) -> Iterator[PassageMargin]:
        """Margins on the shoe of support k, on either side."""
        carriage, support = self.rig.carriage.name, self.rig.supports[k]

        def off(read: Read, side: int) -> ca.SX:
            """As `Solved.off_shoe`; the carriage leaves on its own side of the middle only."""
            loose = -read(f"{carriage}.shoe_force") / read(f"{carriage}.tension_a") * read(f"{carriage}.radius")
            return ca.fmax(EDGE - loose, -side * (read(f"{carriage}.x") - support.at[0]))

        def lies(read: Read) -> ca.SX:
            return read(f"{carriage}.mainline_rope") - PENETRATION

        rolled, event = Place(k, rollers=k + 1), f"leaves {support.name}"
        if rolled in self.order:
            yield PassageMargin(Place(k), event, lambda read: ca.fmax(off(read, -1), lies(read)))
            yield PassageMargin(rolled, event, lambda read: ca.fmax(off(read, -1), -lies(read)))
        else:
            yield PassageMargin(Place(k), event, lambda read: off(read, -1))
        yield PassageMargin(Place(k + 1), event, lambda read: off(read, 1))

    def _in_span(self, at: SpanModel) -> Iterator[PassageMargin]:
        """Margins in a span: the shoes at its ends, and contact of the mainline with the roller before the carriage."""
        rig, k, rolled = self.rig, at.span, Place(at.span, rollers=at.span + 1)
        carriage, supports = rig.carriage.name, rig.supports
        end = f"{carriage} is at the end of its path"

        if at.place == rolled:
            roller = f"{supports[k].name}_mainline"
            event = f"mainline leaves the roller of {supports[k].name}"
            yield PassageMargin(Place(k), event, lambda read: read(f"{roller}.a_rope") - read(f"{roller}.b_rope"))
        elif k > 0:
            yield self._touch(at, k - 1, -1)
        else:
            yield PassageMargin(None, end, lambda read: read(f"{carriage}.x") - rig.stands[0].at[0] - SIDE)
        if k < len(supports):
            yield self._touch(at, k, 1)
            if at.place != rolled and rolled in self.order:
                event = f"mainline lies on the roller of {supports[k].name}"
                yield PassageMargin(rolled, event, self._over_roller(at, k))
        else:
            yield PassageMargin(None, end, lambda read: rig.stands[-1].at[0] - read(f"{carriage}.x") - SIDE)

    def _touch(self, at: SpanModel, k: int, way: int) -> PassageMargin:
        """Margin to the shoe of support k, which the carriage rolls onto or runs over."""
        target, what = (Place(k, k), "reaches") if self._rolls[k] else (self._to(k, way), "runs over")
        event = f"{what} {self.rig.supports[k].name}"
        return PassageMargin(target, event, lambda read: read(f"{at.free_span(k)}.length") - TOUCH)

    def _over_roller(self, at: SpanModel, k: int) -> Callable[[Read], ca.SX]:
        """Distance of the mainline above the roller of support k [m]."""
        run = at.model.runs[at.roles.index("mainline")]
        span, carriage, support = run.spans[-1].name, self.rig.carriage.name, self.rig.supports[k]

        def clear(read: Read) -> ca.SX:
            end = tuple(read(f"{carriage}.{axis}") - c for axis, c in zip("xz", support.centre, strict=True))
            force = (read(f"{span}.force_x"), read(f"{span}.force_y"), read(f"{span}.vertical_b"))
            rope = span_rope(at.model, run, len(run.spans) - 1, read)
            return shoe.clearance((end[0], end[1]), force, *rope, support.radius) + PENETRATION

        return clear

    def _shows(self, at: SpanModel) -> dict[str, tuple[str, ...]]:
        """Outputs of a place: a carriage on a shoe has those of both, a rope those of all its spans."""
        carriage = self.rig.carriage.name
        shows: dict[str, tuple[str, ...]] = {
            name: (name,) for name in at.model.y.names if name not in at.model.y.hidden
        }
        if at.on is not None:
            own = [name.partition(".")[2] for name in shows if name.startswith(f"{carriage}.")]
            shows |= {f"{self.rig.supports[at.on].name}.{quantity}": (f"{carriage}.{quantity}",) for quantity in own}
        for run, role in zip(at.model.runs, at.roles, strict=True):
            if role:
                shows[f"{role}.utilisation"] = tuple(f"{span.name}.utilisation" for span in run.spans)
        return shows

    def _limits(self, y: VariableTable) -> Limits:
        """Limits of the outputs that all places have, and of each rope."""
        at = span_model(self.rig, self.order[0])
        known = at.model.limits
        rows = [
            (y.index[at.model.y.names[output]], *rest)
            for output, *rest in zip(known.output, known.low, known.high, known.events, known.components, strict=True)
            if at.model.y.names[output] in y.index
        ]
        for run, role in zip(at.model.runs, at.roles, strict=True):
            if role:
                rows += [
                    (y.index[f"{role}.{limit.output}"], limit.low, limit.high, limit.event, role)
                    for limit in run.spans[0].limits()
                ]
        output, low, high, events, components = zip(*rows, strict=True)
        return Limits(np.array(output, int), np.array(low), np.array(high), tuple(events), tuple(components))
