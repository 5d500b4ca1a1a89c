"""An intermediate support: a jack with a saddle."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ropeway.components import check, laws, shoe
from ropeway.components.argument_checks import checked
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Equations, Kind, Limit, Seat, Site, Variable
from ropeway.components.sheave import Wheel
from ropeway.components.smooth import sign
from ropeway.components.spar import Standing


@checked
@dataclass(frozen=True, kw_only=True)
class IntermediateSupport(Standing, Wheel):
    """A jack that carries the skyline in a saddle. Frictionless: equal tension on both sides.

    friction: coefficient of the rope in the saddle. The tension ratio is then exp(friction * wrap) against the
    way in which the rope has slid (capstan), reached smoothly within `slip` metres of travel from where the
    rope lay at rest, which was at a travel of `rest` metres.

    radius: of the saddle's shoe [m], an arc in the vertical plane of the line with its middle at the support's
    place, where it has a `slope` (rise over run; in a rig by default along the bisector of the chords, alone
    level). The rope wraps it and a carriage rolls over it, so that its pull does not jump. 0: a point.
    Raises InputError.
    """

    friction: float = 0.0
    slip: float = 0.005
    rest: float = 0.0
    radius: float = 0.0
    slope: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check.not_negative(self.friction, self.described, "friction")
        check.positive(self.slip, self.described, "slip", "m")
        check.number(self.rest, self.described, "rest", "m")
        check.not_negative(self.radius, self.described, "radius", "m")
        if self.slope is not None:
            check.number(self.slope, self.described, "slope")

    @property
    def a(self) -> Seat:
        return replace(super().a, offset="a" if self.radius > 0.0 else None)

    @property
    def b(self) -> Seat:
        return replace(super().b, offset="b" if self.radius > 0.0 else None)

    @property
    def centre(self) -> tuple[float, float]:
        """Centre of the shoe (x, z) [m]."""
        normal = shoe.normal_at(self.slope or 0.0)
        return (self.at[0] - self.radius * normal[0], self.at[2] - self.radius * normal[1])

    @property
    def balance(self) -> str:
        return "tension_law"

    def limits(self) -> tuple[Limit, ...]:
        carried = () if self.capacity is None else (Limit("bearing_load", "above capacity", high=self.capacity),)
        return (*super().limits(), *carried)

    def structure(self, site: Site) -> Hashable:
        return (self.friction > 0.0, self.radius > 0.0)

    def variables(self, site: Site) -> tuple[Variable, ...]:
        rough = (
            Variable(
                "friction", Kind.PARAMETER, "1", "friction of the rope in the saddle", self.friction, range=NOT_NEGATIVE
            ),
            Variable("slip", Kind.PARAMETER, "m", "travel in which friction builds up", self.slip, range=POSITIVE),
            Variable("grip", Kind.PARAMETER, "m", "travel at which the rope lay at rest", self.rest, site.length),
        )
        arc = (
            Variable("radius", Kind.PARAMETER, "m", "radius of the shoe", self.radius, range=POSITIVE),
            Variable("slope", Kind.PARAMETER, "1", "slope of the shoe at its middle", self.slope or 0.0),
            *shoe.side_variables("a"),
            *shoe.side_variables("b"),
        )
        return (
            *self.place(),
            *(arc if self.radius > 0.0 else ()),
            *(rough if self.friction > 0.0 else ()),
            Variable("travel", Kind.ALGEBRAIC, "m", "unstretched rope that has run over", 0.0, site.length),
            Variable("tension_law", Kind.RESIDUAL, "N", "tensions on both sides", 0.0, site.force),
            *self.wheel_outputs(site),
        )

    def equations(self, v: Any) -> Equations:
        outputs = self.wheel_equations(v)
        t_in, t_out = outputs["tension_in"], outputs["tension_out"]
        if self.friction > 0.0:
            t_in = t_in * (v.friction * outputs["wrap"] * sign(v.travel - v.grip, v.slip)).exp()
        residuals = {"tension_law": t_out - t_in}
        if self.radius > 0.0:
            normal = shoe.normal_at(v.slope)
            ways = (("a", v.a, shoe.towards_a(normal), 1), ("b", v.b, shoe.towards_b(normal), -1))
            for name, seat, along, way in ways:
                turn = shoe.turn(seat.force, normal, along)
                found = shoe.side(turn, normal, along, v.radius, seat.force, seat.carried)
                residuals.update(shoe.side_residuals(v, name, found, way))
        return Equations(residuals=residuals, outputs=outputs)

    def laws(self, v: Any) -> dict[str, laws.Law]:
        by = 1.0
        if self.friction > 0.0:
            by = np.exp(v.friction * laws.wrap(v.a.force, v.b.force) * np.tanh((v.travel - v.grip) / v.slip))
        found = {"tension_law": laws.ratio(v.a.force, v.b.force, by)}
        if self.radius > 0.0:
            steep = np.arctan(v.slope)
            middle = (-v.radius * np.sin(steep), v.radius * np.cos(steep))
            found.update(shoe.laws_of_side(v, "a", middle))
            found.update(shoe.laws_of_side(v, "b", middle))
        return found
