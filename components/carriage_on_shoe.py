"""A carriage on the shoe of an intermediate support."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ropeway.components import laws, shoe
from ropeway.components.argument_checks import checked
from ropeway.components.carriage import Carriage
from ropeway.components.catenary import norm
from ropeway.components.check import POSITIVE
from ropeway.components.component import Seat
from ropeway.components.errors import InputError
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.variable import Equations, Kind, Limit, MovingMass, Site, Variable


@checked
@dataclass(frozen=True, kw_only=True)
class CarriageOnShoe(Carriage):
    """A carriage in contact with the shoe of a support without friction; both are one node of the skyline.

    On either side the skyline leaves at the carriage, or it lies on the shoe beyond the carriage and leaves the shoe
    tangentially. The contact acts in both directions: where `shoe_force`, the force of the shoe on the carriage, is
    negative, the carriage has lifted off. The outputs of the support are included.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float, default (0, 0, 0)
        Initial guess of its position, (x, z) or (x, y, z) [m].
    label : str, optional
        Text in pictures and messages; by default the name.
    mass : float
        Mass of the empty carriage [kg].
    payload : float, default 0
        Mass of the payload [kg].
    clamped : bool, default False
        Whether it is clamped to the skyline.
    holding : {None, "bisector", "horizontal"}
        Direction of an ideal holding force, as of a `Carriage`.
    depth : float, default 0
        Distance from the skyline down to the lowest point of the load [m].
    drag_area : float, default 0
        Drag coefficient times area of carriage and load in the wind [m2].
    swing : float, default inf
        Largest angle of the dropline in a simulation with inertia, as of a `Carriage` [rad].
    grip : float, default inf
        Force that the clamp of a clamped carriage holds, as of a `Carriage` [N]; it is not reported on a shoe.
    support : IntermediateSupport
        The support; its saddle has a radius and no friction.
    mainline_on_roller : bool, default False
        Whether the mainline, from the side of smaller x, lies on a roller with the arc of the shoe.

    Raises
    ------
    InputError
        The support has no radius, or friction; or invalid values of a `Carriage`.

    Examples
    --------
    >>> jack = rw.IntermediateSupport("jack", at=(120.0, -2.0), radius=1.5)
    >>> rw.CarriageOnShoe("carriage", mass=450.0, support=jack).support.radius
    1.5
    """

    hangs: ClassVar[bool] = False

    support: IntermediateSupport
    mainline_on_roller: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.support.radius <= 0.0 or self.support.friction > 0.0:
            raise InputError(f"{self.support.described} has no smooth shoe", "Give it a radius and no friction")

    @property
    def a(self) -> Seat:
        """Where the skyline arrives."""
        return replace(super().a, offset="a")

    @property
    def b(self) -> Seat:
        """Where the skyline leaves."""
        return replace(super().b, offset="b")

    @property
    def mainline(self) -> Seat:
        """Where the mainline ends."""
        return replace(super().mainline, offset="mainline" if self.mainline_on_roller else None)

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        return ()  # the shoe guides it

    def masses(self, read: Callable[[str], Any]) -> tuple[MovingMass, ...]:
        x, z = (read(axis) - read(f"centre_{axis}") for axis in "xz")
        along = shoe.towards_a((x / read("radius"), z / read("radius")))
        mass = read("mass") + read("payload")
        return tuple(MovingMass(axis, mass, {"balance": part}) for axis, part in zip("xz", along, strict=True))

    def limits(self) -> tuple[Limit, ...]:
        return (Limit("shoe_force", "carriage off its shoe", low=0.0), *self.support.limits())

    def structure(self, site: Site) -> Hashable:
        return (self.clamped, self.holding, self.slips, self.mainline_on_roller)

    def variables(self, site: Site) -> tuple[Variable, ...]:
        par, res, out, force = Kind.PARAMETER, Kind.RESIDUAL, Kind.OUTPUT, site.force
        centre_x, centre_z = self.support.centre
        own = [
            replace(v, kind=par) if v.name == "y" else v
            for v in super().variables(site)
            if not v.name.startswith("balance_")
        ]
        return (
            *own,
            Variable("radius", par, "m", "radius of the shoe", self.support.radius, range=POSITIVE),
            Variable("centre_x", par, "m", "x of the shoe's centre", centre_x, 100.0),
            Variable("centre_z", par, "m", "z of the shoe's centre", centre_z, 100.0),
            Variable("contact", res, "m", "the carriage is on the shoe"),
            Variable("balance", res, "N", "forces on the carriage along the shoe", 0.0, 0.01 * force),
            *(v for side in self._sides for v in shoe.side_variables(side)),
            Variable("shoe_force", out, "N", "force of the shoe on the carriage", nominal=force),
            *(
                Variable(f"pull_{axis}", out, "N", f"force of carriage and ropes on the support, {axis}", nominal=force)
                for axis in "xyz"
            ),
            *self.support.wheel_outputs(site),
        )

    @property
    def _sides(self) -> tuple[str, ...]:
        return ("a", "b", "mainline") if self.mainline_on_roller else ("a", "b")

    def equations(self, v: Any) -> Equations:
        x, z = v.x - v.centre_x, v.z - v.centre_z
        normal = (x / v.radius, z / v.radius)
        acting = {"a": v.a.force, "b": v.b.force, "mainline": v.mainline.force}
        residuals = {"contact": (x * x + z * z - v.radius**2) / (2.0 * v.radius)}
        for name in self._sides:
            seat = getattr(v, name)
            along = shoe.towards_b(normal) if name == "b" else shoe.towards_a(normal)
            below = shoe.turn(seat.force, normal, along)
            laid = shoe.side(shoe.contact_angle(below), normal, along, v.radius, seat)
            residuals.update(shoe.side_residuals(v, name, laid, -1 if name == "b" else 1))
            acting[name] = shoe.pull(norm(seat.force), laid.turn - below, normal, along)
        total = self.total(v, acting["a"], acting["b"], (acting["mainline"], v.haulback.force, v.dropline.force))
        along = shoe.towards_a(normal)
        residuals["balance"] = total[0] * along[0] + total[2] * along[1]
        pressed = -(total[0] * normal[0] + total[2] * normal[1])
        if not self.clamped:
            residuals["tension_law"] = norm(v.b.force) - norm(v.a.force)
        # Load on the shoe: the carriage, and the rope that lies on it.
        on = [v.a.force[i] - acting["a"][i] + v.b.force[i] - acting["b"][i] for i in range(3)]
        load = (on[0] - pressed * normal[0], on[1], on[2] - pressed * normal[1])
        roller = [v.mainline.force[i] - acting["mainline"][i] for i in range(3)]
        wheel = IntermediateSupport.wheel_equations(v)
        return Equations(
            residuals=residuals,
            outputs={
                **self.line_outputs(v),
                **wheel,
                "shoe_force": pressed,
                **{f"pull_{axis}": load[i] + roller[i] for i, axis in enumerate("xyz")},
                "bearing_load": norm(load),
                "support_force": -load[2],
            },
        )

    def laws(self, v: Any) -> dict[str, laws.Law]:
        here = (v.x - v.centre_x, v.z - v.centre_z)
        found = {"contact": laws.Law(np.hypot(*here) - v.radius, v.radius)}
        for name in self._sides:
            found.update(shoe.laws_of_side(v, name, here, free=True))
        # The forces of the shoe, on the carriage and on the ropes, pass through its centre.
        pulls, moment = [laws.weight((v.mass + v.payload) * v.gravity) + laws.wind(v)], np.zeros(1)
        for seat in self.seats:
            pulls.append(getattr(v, seat.name).force)
            if seat.offset is not None:
                x, z = getattr(v, f"{seat.offset}_x"), getattr(v, f"{seat.offset}_z")
                moment = moment + shoe.moment((x, z), pulls[-1])
        if self.holding is not None:
            pulls.append(self._holding_on_shoe(v, here))
        total, size = sum(pulls[1:], pulls[0]), sum((laws.tension(f) for f in pulls), np.zeros(1))
        found["balance"] = laws.Law((moment + shoe.moment(here, total)) / v.radius, size)
        if not self.clamped:
            found["tension_law"] = laws.ratio(v.a.force, v.b.force)
        return found

    def _holding_on_shoe(self, v: Any, here: tuple[Any, Any]) -> np.ndarray:
        """The ideal holding force, from the tangents of the ropes at the carriage."""
        directions = []
        for name, side in (("a", -1.0), ("b", 1.0)):
            force = getattr(v, name).force
            on_it = np.stack([side * here[1], 0.0 * here[0], -side * here[0]]) / v.radius
            laid = np.abs(getattr(v, f"{name}_rope")) > 1e-9 * v.radius
            directions.append(np.where(laid, on_it, force / laws.tension(force)))
        return self._holding_force(v, *directions)
