"""A carriage on a skyline."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

import numpy as np

from ropeway.components import check, laws
from ropeway.components.annotation_checks import Unbounded
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Vector, namespace, norm
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Component, Seat
from ropeway.components.errors import InputError
from ropeway.components.form import remade
from ropeway.components.inertia import Inertia
from ropeway.components.moving_node import (
    across_force,
    across_residuals,
    across_variables,
    energies,
    energy_outputs,
    inertial_force,
    motion_rates,
    motion_variables,
)
from ropeway.components.node import Node
from ropeway.components.smooth import sign, size
from ropeway.components.variable import Equations, Kind, Limit, MovingMass, Site, Variable
from ropeway.components.weather import drag_variables

Holding = Literal["bisector", "horizontal"]


@checked
@dataclass(frozen=True, kw_only=True)
class Carriage(Node):
    """A carriage on a skyline; its position follows from the balance of all forces on it.

    The skyline arrives at seat a and leaves at seat b. On a rolling carriage the skyline has the same tension on both
    sides, and `travel` is the length of skyline that has run through it. The ends for mainline, haulback and dropline
    may stay open.

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
        Whether it is clamped to the skyline: `travel` is then given.
    holding : {None, "bisector", "horizontal"}
        Direction of an ideal force that holds the carriage at its x instead of a mainline: along the bisector of the
        skyline's tangents, or horizontal; positive towards a.
    depth : float, default 0
        Distance from the skyline down to the lowest point of the load [m].
    drag_area : float, default 0
        Drag coefficient times area of carriage and load in the wind [m2].
    swing : float, default inf
        Angle of the dropline from the vertical beyond which a simulation with inertia reports the event "swing beyond
        limit" [rad].
    grip : float, default inf
        Largest difference of the skyline's tensions that the clamp of a clamped carriage holds [N]. Beyond it "clamp
        slips" is reported; with inertia the skyline then slips through the clamp against this force.

    Raises
    ------
    InputError
        A negative mass, payload, depth or area, a grip that is not positive, a grip without a clamp, or a clamped
        carriage with a holding force.

    Examples
    --------
    >>> rw.Carriage("carriage", mass=450.0, clamped=True).clamped
    True
    """

    hangs: ClassVar[bool] = True

    at: tuple[float, ...] = (0.0, 0.0, 0.0)
    mass: float
    payload: float = 0.0
    clamped: bool = False
    holding: Holding | None = None
    depth: float = 0.0
    drag_area: float = 0.0
    swing: Unbounded = math.inf
    grip: Unbounded = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        check.not_negative(self.mass, self.described, "mass", "kg")
        check.not_negative(self.payload, self.described, "payload", "kg")
        check.not_negative(self.depth, self.described, "depth", "m")
        check.not_negative(self.drag_area, self.described, "drag_area", "m2")
        check.positive(self.swing, self.described, "swing", "rad", infinite=True)
        check.positive(self.grip, self.described, "grip", "N", infinite=True)
        if self.slips and not self.clamped:
            raise InputError(f"{self.described} has a grip of {self.grip:g} N without a clamp", "Give clamped=True")
        if self.holding not in (None, "bisector", "horizontal"):
            raise InputError(
                f"{self.described}: holding is {self.holding!r}", 'Choose "bisector", "horizontal" or None'
            )
        if self.clamped and self.holding is not None:
            raise InputError(f"{self.described} is clamped and has a holding force", "The clamp holds it: omit holding")

    def with_inertia(self, inertia: Inertia) -> Component:
        return remade(self, MovingCarriage) if type(self) is Carriage else self

    @property
    def slips(self) -> bool:
        """Whether its clamp holds a limited force."""
        return math.isfinite(self.grip)

    def limits(self) -> tuple[Limit, ...]:
        return (Limit("clamp_force", "clamp slips", -self.grip, self.grip),) if self.slips else ()

    @property
    def a(self) -> Seat:
        """Where the skyline arrives."""
        return Seat(self, "a", travel="travel")

    @property
    def b(self) -> Seat:
        """Where the skyline leaves."""
        return Seat(self, "b", travel="travel")

    @property
    def mainline(self) -> Seat:
        """Where the mainline ends."""
        return Seat(self, "mainline", optional=True)

    @property
    def haulback(self) -> Seat:
        """Where the haulback ends."""
        return Seat(self, "haulback", optional=True)

    @property
    def dropline(self) -> Seat:
        """Where the dropline ends."""
        return Seat(self, "dropline", optional=True)

    @property
    def seats(self) -> tuple[Seat, ...]:
        return (self.a, self.b, self.mainline, self.haulback, self.dropline)

    def through(self, seat: Seat) -> Seat | None:
        return self.b if seat == self.a else None

    @property
    def balance(self) -> str | None:
        return "tension_law" if not self.clamped and self.holding is None else None

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        # The direction of an ideal holding force depends on the rope: the balance has no symmetric stiffness matrix.
        return () if self.holding is not None else tuple((axis, f"balance_{axis}") for axis in "xyz")

    def masses(self, read: Callable[[str], Any]) -> tuple[MovingMass, ...]:
        return tuple(MovingMass(axis, read("mass") + read("payload"), {f"balance_{axis}": 1.0}) for axis in "xyz")

    def structure(self, site: Site) -> Hashable:
        return (self.clamped, self.holding, self.slips)

    def variables(self, site: Site) -> tuple[Variable, ...]:
        par, alg, res, out = Kind.PARAMETER, Kind.ALGEBRAIC, Kind.RESIDUAL, Kind.OUTPUT
        x, y, z = self.at
        force, scale = site.force, 0.01 * site.force
        travel = "unstretched length of skyline that has run through"
        return (
            Variable("x", alg if self.holding is None else par, "m", "x of the carriage", x, 100.0),
            Variable("y", alg, "m", "y of the carriage", y, 100.0),
            Variable("z", alg, "m", "z of the carriage", z, 100.0),
            Variable("mass", par, "kg", "mass of the empty carriage", self.mass, 1000.0, range=NOT_NEGATIVE),
            Variable("payload", par, "kg", "mass of the payload", self.payload, 1000.0, range=NOT_NEGATIVE),
            *drag_variables(site, self.drag_area),
            Variable("travel", par if self.clamped else alg, "m", travel, 0.0, site.length),
            *([] if self.holding is None else [Variable("holding", alg, "N", "holding force", 0.0, force)]),
            *(Variable(f"balance_{axis}", res, "N", f"forces on the carriage, {axis}", 0.0, scale) for axis in "xyz"),
            *([] if self.clamped else [Variable("tension_law", res, "N", "skyline tension on both sides", 0.0, force)]),
            Variable("tension_a", out, "N", "skyline tension at the carriage, side a", nominal=force),
            Variable("tension_b", out, "N", "skyline tension at the carriage, side b", nominal=force),
            Variable("mainline_pull", out, "N", "tension of the mainline at the carriage", nominal=force),
            Variable("haulback_pull", out, "N", "tension of the haulback at the carriage", nominal=force),
            Variable("dropline_pull", out, "N", "tension of the dropline at the carriage", nominal=force),
            *((Variable("clamp_force", out, "N", "skyline tension b minus a", nominal=force),) if self.slips else ()),
        )

    def total(self, v: Any, a: Vector, b: Vector, lines: tuple[Vector, ...]) -> list[Any]:
        """Sum of all forces on the carriage: skyline, other ropes, ideal holding force, weight, wind [N]."""
        held = (0.0, 0.0, 0.0)
        if self.holding is not None:
            tension_a, tension_b = norm(a), norm(b)
            direction = [a[i] / tension_a - b[i] / tension_b for i in range(3)]
            if self.holding == "horizontal":
                direction[2] = 0.0 * direction[2]
            length = norm((direction[0], direction[1], direction[2]))
            held = (
                v.holding * direction[0] / length,
                v.holding * direction[1] / length,
                v.holding * direction[2] / length,
            )
        total = [a[i] + b[i] + sum(pull[i] for pull in lines) + held[i] for i in range(3)]
        total[2] = total[2] - (v.mass + v.payload) * v.gravity
        if v.weather is not None:
            total = [force + wind for force, wind in zip(total, v.weather.drag(v.drag_area), strict=True)]
        return total

    def line_outputs(self, v: Any) -> dict[str, Any]:
        """Tensions of the ropes at the carriage."""
        lines = {"mainline": v.mainline.force, "haulback": v.haulback.force, "dropline": v.dropline.force}
        tension_a, tension_b = norm(v.a.force), norm(v.b.force)
        return {
            "tension_a": tension_a,
            "tension_b": tension_b,
            **({"clamp_force": tension_b - tension_a} if self.slips else {}),
            **{f"{line}_pull": size(pull) for line, pull in lines.items()},
        }

    def equations(self, v: Any) -> Equations:
        total = self.total(v, v.a.force, v.b.force, (v.mainline.force, v.haulback.force, v.dropline.force))
        outputs = self.line_outputs(v)
        residuals = {f"balance_{axis}": total[i] for i, axis in enumerate("xyz")}
        if not self.clamped:
            residuals["tension_law"] = outputs["tension_b"] - outputs["tension_a"]
        return Equations(residuals=residuals, outputs=outputs)

    def _holding_force(self, v: Any, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """The ideal holding force in `laws`, from the unit vectors of the skyline's pulls on both sides, (3, ...)."""
        direction = a - b
        if self.holding == "horizontal":
            direction[2] = 0.0
        return np.asarray(v.holding * direction / laws.tension(direction))

    def laws(self, v: Any) -> dict[str, laws.Law]:
        ropes = [getattr(v, seat.name).force for seat in self.seats]
        held = laws.weight((v.mass + v.payload) * v.gravity) + laws.wind(v)
        if self.holding is not None:
            held = held + self._holding_force(v, *(rope / laws.tension(rope) for rope in ropes[:2]))
        found = {f"balance_{axis}": law for axis, law in laws.balance(*ropes, held).items()}
        if not self.clamped:
            found["tension_law"] = laws.ratio(ropes[0], ropes[1])
        return found


@checked
@dataclass(frozen=True, kw_only=True)
class MovingCarriage(Carriage):
    """A carriage with the inertia of itself, its payload and its ropes; arguments as of a `Carriage`.

    It rolls on the skyline: the ends of the rope there move with it across the skyline's direction `along`, the chord
    from the support before to the one after at the start, and not along it. In a clamp with a `grip` the skyline slips
    where its inertia and the difference of its tensions exceed the grip; below it creeps.
    """

    inertial: ClassVar[bool] = True

    @property
    def a(self) -> Seat:
        return self._moving(super().a)

    @property
    def b(self) -> Seat:
        return self._moving(super().b)

    def _moving(self, seat: Seat) -> Seat:
        """A seat of the skyline, with the motion of the rope there."""
        if self.slips:
            return replace(seat, speed="slip_speed", acceleration="slip_acceleration")
        return seat if self.clamped else replace(seat, rates="skyline_")

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        return ()

    def limits(self) -> tuple[Limit, ...]:
        return (*super().limits(), Limit("dropline_angle", "swing beyond limit", high=self.swing))

    @property
    def _axes(self) -> str:
        """The axes along which it is free to move: an ideal holding force holds its x."""
        return "xyz" if self.holding is None else "yz"

    def structure(self, site: Site) -> Hashable:
        return super().structure(site)

    def variables(self, site: Site) -> tuple[Variable, ...]:
        own = super().variables(site)
        if self.slips:
            own = (*(v for v in own if v.name != "travel"), *_slip_variables(site, self.grip))
        places = {v.name: v for v in own if v.name in self._axes}
        dropped = Variable("dropped", Kind.DISCRETE, "1", "1: the payload has been dropped")
        rolling = () if self.clamped else across_variables("skyline")
        angle = Variable("dropline_angle", Kind.OUTPUT, "rad", "angle of the dropline from the vertical")
        return (
            *(v for v in own if v.name not in places),
            *motion_variables(places),
            *rolling,
            dropped,
            angle,
            *energy_outputs(),
        )

    def equations(self, v: Any) -> Equations:
        v.payload = v.payload * (1 - v.dropped)
        found, seats = super().equations(v), [seat.name for seat in self.seats]
        mass = v.mass + v.payload
        down = 1e-12 - v.dropline.force[2]  # an angle of zero where there is no dropline
        clamped = [] if self.clamped else ["a", "b"]
        whole = [name for name in seats if name not in clamped]
        balances = {
            f"balance_{axis}": found.residuals[f"balance_{axis}"]
            - inertial_force(v, axis, mass, whole)
            - across_force(v, axis, clamped)
            for axis in "xyz"
        }
        rolling = {} if self.clamped else across_residuals(v, "skyline", self._axes)
        slip_rates, slip = _slip(v) if self.slips else ({}, {})
        return replace(
            found,
            rates={**motion_rates(v, self._axes), **slip_rates},
            residuals={**found.residuals, **balances, **rolling, **slip},
            outputs={
                **found.outputs,
                **energies(v, mass, self._axes),
                "dropline_angle": namespace(down).atan2(size((v.dropline.force[0], v.dropline.force[1], 0.0)), down),
            },
        )


_CREEP = 1e-4
"""Speed at which a clamp holds three quarters of its grip [m/s]: its force is smooth through zero speed."""


def _slip_variables(site: Site, grip: float) -> tuple[Variable, ...]:
    """Motion of the skyline through a clamp that slips."""
    state = Kind.STATE
    return (
        Variable("travel", state, "m", "unstretched length of skyline that has slipped through", kept_at_rest=True),
        Variable("slip_speed", state, "m/s", "speed of the skyline in the clamp", kept_at_rest=True, rate_of="travel"),
        Variable("slip_acceleration", Kind.ALGEBRAIC, "m/s2", "acceleration of the skyline in the clamp"),
        Variable("slip", Kind.RESIDUAL, "N", "forces on the skyline in the clamp", nominal=0.01 * site.force),
        Variable("grip", Kind.PARAMETER, "N", "force that the clamp holds", grip, site.force, range=POSITIVE),
        Variable("lost", state, "J", "energy lost in the clamp", nominal=1e3),
    )


def _slip(v: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Rates and residual of `_slip_variables`."""
    held = v.grip * sign(v.slip_speed, _CREEP)
    rates = {"travel": v.slip_speed, "slip_speed": v.slip_acceleration, "lost": held * v.slip_speed}
    return rates, {"slip": v.a.along + v.b.along + held - (v.b.carried - v.a.carried)}
