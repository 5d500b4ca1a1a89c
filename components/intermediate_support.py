"""An intermediate support: a jack with a saddle."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ropeway.components import check, laws, shoe
from ropeway.components.argument_checks import checked
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Seat
from ropeway.components.sheave import Wheel
from ropeway.components.smooth import sign
from ropeway.components.spar import Standing
from ropeway.components.variable import Equations, Kind, Limit, Site, Variable


@checked
@dataclass(frozen=True, kw_only=True)
class IntermediateSupport(Standing, Wheel):
    """A jack that carries the skyline in a saddle.

    Without friction the tension is equal on both sides. With friction the tension ratio is exp(friction * wrap) against
    the direction of sliding (capstan equation). It builds up smoothly within `slip` metres of travel from the rest
    position. A saddle with a radius is a circular shoe in the vertical plane of the line. The rope wraps it, and a
    carriage rolls over it without a jump of its pull.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    hold_down : bool, default False
        Whether the rope runs below the sheave, which presses it down. Otherwise lift-off is reported where the support
        pulls the rope down.
    at : tuple of float, optional
        Position, (x, z) or (x, y, z) [m]; or give station and height.
    label : str, optional
        Text in pictures and messages; by default the name.
    station : float, optional
        Station on a terrain [m].
    height : float, optional
        Height above the ground [m].
    capacity : float, optional
        Largest resultant of the ropes that it can carry [N].
    friction : float, default 0
        Friction coefficient of the rope in the saddle.
    slip : float, default 0.005
        Travel in which friction builds up [m].
    rest : float, default 0
        Travel at which the rope was at rest [m].
    radius : float, default 0
        Radius of the shoe [m]; 0: a point.
    slope : float, optional
        Slope of the shoe at its middle, rise over run; by default along the bisector of the chords in a rig, else
        level.

    Raises
    ------
    InputError
        An invalid value, or no position.

    Examples
    --------
    >>> rw.IntermediateSupport("jack", station=150.0, height=9.0, radius=1.5).radius
    1.5
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
        """Where the skyline arrives."""
        return replace(super().a, offset="a") if self.radius > 0.0 else super().a

    @property
    def b(self) -> Seat:
        """Where the skyline leaves."""
        return replace(super().b, offset="b") if self.radius > 0.0 else super().b

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
        friction_vars = (
            Variable(
                "friction", Kind.PARAMETER, "1", "friction of the rope in the saddle", self.friction, range=NOT_NEGATIVE
            ),
            Variable("slip", Kind.PARAMETER, "m", "travel in which friction builds up", self.slip, range=POSITIVE),
            Variable("grip", Kind.PARAMETER, "m", "travel at which the rope was at rest", self.rest, site.length),
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
            *(friction_vars if self.friction > 0.0 else ()),
            Variable("travel", Kind.ALGEBRAIC, "m", "unstretched length of rope that has run over", 0.0, site.length),
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
            sides = (("a", v.a, shoe.towards_a(normal), 1), ("b", v.b, shoe.towards_b(normal), -1))
            for name, seat, along, way in sides:
                turn = shoe.turn(seat.force, normal, along)
                found = shoe.side(turn, normal, along, v.radius, seat)
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
