"""An idler sheave, and the forces of the rope on any sheave."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ropeway.components import check, laws
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import Vector, norm
from ropeway.components.check import NOT_NEGATIVE
from ropeway.components.component import Component, Seat
from ropeway.components.form import remade
from ropeway.components.inertia import Inertia
from ropeway.components.moving_node import energy_outputs
from ropeway.components.node import Node
from ropeway.components.smooth import angle_between, sign
from ropeway.components.variable import Equations, Kind, Limit, MovingMass, Site, Variable


@checked
@dataclass(frozen=True)
class Wheel(Node):
    """A support that a rope runs over, from seat a to seat b.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float
        Position, (x, z) or (x, y, z) [m].
    hold_down : bool, default False
        Whether the rope runs below the sheave, which presses it down. Otherwise lift-off is reported where the support
        pulls the rope down.
    label : str, optional
        Text in pictures and messages; by default the name.
    """

    hold_down: bool = False

    @property
    def a(self) -> Seat:
        """Where the rope arrives."""
        return Seat(self, "a", travel="travel")

    @property
    def b(self) -> Seat:
        """Where the rope leaves."""
        return Seat(self, "b", travel="travel")

    @property
    def seats(self) -> tuple[Seat, ...]:
        return (self.a, self.b)

    def through(self, seat: Seat) -> Seat | None:
        return self.b if seat == self.a else None

    def limits(self) -> tuple[Limit, ...]:
        return () if self.hold_down else (Limit("support_force", "lift-off", low=0.0),)

    def wheel_outputs(self, site: Site) -> tuple[Variable, ...]:
        """Outputs of any sheave."""
        out, force = Kind.OUTPUT, site.force
        return (
            Variable("tension_in", out, "N", "tension of the incoming rope", nominal=force),
            Variable("tension_out", out, "N", "tension of the outgoing rope", nominal=force),
            Variable("differential_tension", out, "N", "outgoing minus incoming tension", nominal=force),
            Variable("bearing_load", out, "N", "resultant of the rope's forces on the sheave", nominal=force),
            Variable("support_force", out, "N", "upward force of the support on the rope", nominal=force),
            Variable("wrap", out, "rad", "wrap angle of the rope"),
        )

    @staticmethod
    def wheel_equations(v: Any) -> dict[str, Any]:
        """Values of `wheel_outputs`."""
        pull_in, pull_out = v.a.force, v.b.force
        pull: Vector = (pull_in[0] + pull_out[0], pull_in[1] + pull_out[1], pull_in[2] + pull_out[2])
        t_in, t_out = norm(pull_in), norm(pull_out)
        return {
            "tension_in": t_in,
            "tension_out": t_out,
            "differential_tension": t_out - t_in,
            "bearing_load": norm(pull),
            "support_force": -pull[2],
            "wrap": angle_between((-pull_in[0], -pull_in[1], -pull_in[2]), pull_out),
        }


def held_variables() -> tuple[Variable, Variable]:
    """Discrete variables of an idler: whether a load stands on it, and at which travel."""
    return (
        Variable("held", Kind.DISCRETE, "1", "1: a load that cannot pass stands on the sheave"),
        Variable("held_travel", Kind.DISCRETE, "m", "travel at which the load stands on the sheave"),
    )


def tension_law(v: Any, t_in: Any, t_out: Any) -> Any:
    """Residual of an idler: equal tensions, or the travel at which a load stands on it."""
    # One newton per millimetre scales the residual of the travel like that of the tensions.
    return (1 - v.held) * (t_out - t_in) + v.held * (v.travel - v.held_travel) * 1e3


def free_or_held(v: Any, by: np.ndarray | float = 1.0) -> laws.Law:
    """Law of an idler: tensions in the ratio `by`, or the travel at which a load stands on it."""
    free, held = laws.ratio(v.a.force, v.b.force, by), v.held > 0.0
    if not held.any():
        return free
    standing = (v.travel - v.held_travel) * 1e3  # one newton per millimetre, as in the residual
    return laws.Law(np.where(held, standing, free.miss), free.size)


@checked
@dataclass(frozen=True)
class Sheave(Wheel):
    """An idler sheave; without friction the tension is equal on both sides.

    With friction the tension ratio is exp(friction * wrap) in the direction of the driven speed, smooth through zero
    speed, where it is one: T_out - T_in = friction * N with N = 2 T sin(wrap/2), integrated. Without friction the model
    has no parameter `friction`. A load that is pushed back from both sides of a hold-down sheave stays on it: `held` =
    1 keeps the travel at `held_travel`, and the tensions are independent.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float
        Position, (x, z) or (x, y, z) [m].
    hold_down : bool, default False
        Whether the rope runs below the sheave, which presses it down. Otherwise lift-off is reported where the support
        pulls the rope down.
    friction : float, default 0
        Bearing friction referred to the rope: bearing coefficient times axle radius over sheave radius.
    inertia : float, default 0
        Rotating inertia referred to the rope, in simulations with inertia [kg].
    label : str, optional
        Text in pictures and messages; by default the name.

    Raises
    ------
    InputError
        An invalid name, position, friction or inertia.

    Examples
    --------
    >>> rw.Sheave("s1", at=(90.0, 8.0), friction=0.02).friction
    0.02
    """

    role: ClassVar[str] = "idler sheave"

    friction: float = 0.0
    inertia: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check.not_negative(self.friction, self.described, "friction")
        check.not_negative(self.inertia, self.described, "inertia", "kg")

    def with_inertia(self, inertia: Inertia) -> Component:
        return remade(self, MovingSheave) if type(self) is Sheave else self

    @property
    def balance(self) -> str | None:
        return "tension_law"

    def masses(self, read: Callable[[str], Any]) -> tuple[MovingMass, ...]:
        return (MovingMass("travel", self.inertia, {"tension_law": 1.0}),)

    def structure(self, site: Site) -> Hashable:
        return self.friction > 0.0

    def variables(self, site: Site) -> tuple[Variable, ...]:
        described = "bearing friction referred to the rope"
        friction_var = Variable("friction", Kind.PARAMETER, "1", described, self.friction, range=NOT_NEGATIVE)
        return (
            *self.place(),
            *((friction_var,) if self.friction > 0.0 else ()),
            Variable("travel", Kind.ALGEBRAIC, "m", "unstretched length of rope that has run over", 0.0, site.length),
            *held_variables(),
            Variable("tension_law", Kind.RESIDUAL, "N", "tensions on both sides", 0.0, site.force),
            *self.wheel_outputs(site),
        )

    def equations(self, v: Any) -> Equations:
        outputs = self.wheel_equations(v)
        t_in, t_out = outputs["tension_in"], outputs["tension_out"]
        if self.friction > 0.0:
            t_in = t_in * (v.friction * outputs["wrap"] * sign(v.b.speed, 0.01)).exp()
        return Equations(residuals={"tension_law": tension_law(v, t_in, t_out)}, outputs=outputs)

    def laws(self, v: Any) -> dict[str, laws.Law]:
        by: np.ndarray | float = 1.0
        if self.friction > 0.0:
            by = np.exp(v.friction * laws.wrap(v.a.force, v.b.force) * np.tanh(v.b.speed / 0.01))
        return {"tension_law": free_or_held(v, by)}


class MovingWheel(Wheel):
    """What idlers and return wheels with inertia share: the rope over them has a speed, and no tension balances its
    travel."""

    inertial: ClassVar[bool] = True

    @property
    def a(self) -> Seat:
        return moving_seat(super().a)

    @property
    def b(self) -> Seat:
        return moving_seat(super().b)

    @property
    def balance(self) -> str | None:
        return None


@checked
@dataclass(frozen=True)
class MovingSheave(MovingWheel, Sheave):
    """An idler sheave that the rope accelerates; arguments as of a `Sheave`.

    What each metre of rope carries in and out, T + T^2/2EA, is the force on the rope's travel: with the plain tension
    the stiffness of a line is not symmetric, and its energy drifts.
    """

    def structure(self, site: Site) -> Hashable:
        return self.friction > 0.0

    def variables(self, site: Site) -> tuple[Variable, ...]:
        return (
            *inertial_law(super().variables(site)),
            *travel_variables(),
            Variable("inertia", Kind.PARAMETER, "kg", "rotating inertia", self.inertia, 100.0, range=NOT_NEGATIVE),
            Variable("lost", Kind.STATE, "J", "energy lost in the bearing", nominal=1e3),
            *energy_outputs(hangs=False),
        )

    def equations(self, v: Any) -> Equations:
        outputs = self.wheel_equations(v)
        lost = 0.0 * v.rope_speed
        if self.friction > 0.0:
            ratio = (v.friction * outputs["wrap"] * sign(v.rope_speed, 0.01)).exp()
            lost = outputs["tension_in"] * (ratio - 1)
        pull = v.b.carried - v.a.carried - lost
        inertia = v.inertia * v.rope_acceleration + v.a.along + v.b.along
        return Equations(
            rates={"travel": v.rope_speed, "rope_speed": v.rope_acceleration, "lost": lost * v.rope_speed},
            residuals={"tension_law": inertia - pull},
            outputs={**outputs, "kinetic_energy": v.inertia / 2 * v.rope_speed**2},
        )


def moving_seat(seat: Seat) -> Seat:
    """A seat over which the rope moves as `travel_variables` say."""
    return replace(seat, speed="rope_speed", acceleration="rope_acceleration")


def inertial_law(variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
    """Variables of a wheel without inertia that it has with inertia too; forces are scaled like those on loads."""
    moved = ("travel", "held", "held_travel")
    law = ("tension_law", "tension_kept")
    kept = (v for v in variables if v.name not in moved)
    return tuple(replace(v, nominal=0.01 * v.nominal) if v.name in law else v for v in kept)


def travel_variables() -> tuple[Variable, ...]:
    """Motion of the rope over a node that it accelerates."""
    return (
        Variable("travel", Kind.STATE, "m", "unstretched length of rope that has run over", kept_at_rest=True),
        Variable("rope_speed", Kind.STATE, "m/s", "speed of the unstretched rope", kept_at_rest=True, rate_of="travel"),
        Variable("rope_acceleration", Kind.ALGEBRAIC, "m/s2", "acceleration of the unstretched rope"),
    )
