"""A drum at an end of a rope: it pays out and winds in."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from ropeway.components import check, laws
from ropeway.components.argument_checks import checked
from ropeway.components.catenary import norm
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Component, Seat
from ropeway.components.control_sheave import Speed, check_speed
from ropeway.components.errors import InputError
from ropeway.components.form import remade
from ropeway.components.inertia import Inertia
from ropeway.components.moving_node import energy_outputs
from ropeway.components.node import Node
from ropeway.components.schedule import Schedule
from ropeway.components.sheave import inertial_law, moving_seat, travel_variables
from ropeway.components.variable import Equations, Kind, MovingMass, Site, Variable


@checked
@dataclass(frozen=True)
class Drum(Node):
    """An end of a rope that stores rope.

    Travel counts from a to b: at the start of a rope a positive travel pays out, at its end it winds in.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float
        Position, (x, z) or (x, y, z) [m].
    speed : float, Schedule or None, default 0
        Commanded speed [m/s]; None: an input of the model.
    tension : float, optional
        Constant tension that the drum holds instead of a speed [N].
    inertia : float, default 0
        Inertia of a drum that holds a tension, referred to the rope, in simulations with inertia [kg].
    label : str, optional
        Text in pictures and messages; by default the name.

    Raises
    ------
    InputError
        An invalid value, or both speed and tension.

    Examples
    --------
    >>> rw.Drum("mainline", at=(0.0, 3.0), tension=20e3).tension
    20000.0
    """

    role: ClassVar[str] = "drum"

    speed: Speed = 0.0
    tension: float | None = None
    inertia: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check.not_negative(self.inertia, self.described, "inertia", "kg")
        check_speed(self.speed, self.described)
        if self.tension is not None:
            check.positive(self.tension, self.described, "tension", "N")
            if self.speed != 0.0:
                raise InputError(f"{self.described} has a speed and a tension", "Give one of them")

    def with_inertia(self, inertia: Inertia) -> Component:
        return remade(self, MovingDrum) if type(self) is Drum else self

    @property
    def rope(self) -> Seat:
        """Where the rope leaves the drum."""
        return Seat(self, "rope", travel="travel")

    @property
    def seats(self) -> tuple[Seat, ...]:
        return (self.rope,)

    @property
    def drive_speed(self) -> str | None:
        return "speed" if self.tension is None else None

    @property
    def set_tension(self) -> float | None:
        return self.tension

    @property
    def balance(self) -> str | None:
        return None if self.tension is None else "tension_kept"

    def masses(self, read: Callable[[str], Any]) -> tuple[MovingMass, ...]:
        return (MovingMass("travel", self.inertia, {"tension_kept": 1.0}),)

    def structure(self, site: Site) -> Hashable:
        return self.tension is None

    def variables(self, site: Site) -> tuple[Variable, ...]:
        pull = Variable("rope_tension", Kind.OUTPUT, "N", "tension of the rope at the drum", nominal=site.force)
        travel = "unstretched length of rope paid out (at a rope's start) or wound in (at its end)"
        if self.tension is None:
            return (
                *self.place(),
                Variable("speed", Kind.INPUT, "m/s", "commanded speed of the unstretched rope"),
                Variable("travel", Kind.STATE, "m", travel, kept_at_rest=True),
                pull,
            )
        return (
            *self.place(),
            Variable("tension", Kind.PARAMETER, "N", "constant tension", self.tension, site.force, range=POSITIVE),
            Variable("travel", Kind.ALGEBRAIC, "m", travel, 0.0, site.length),
            Variable("tension_kept", Kind.RESIDUAL, "N", "the drum holds its tension", 0.0, site.force),
            pull,
        )

    def equations(self, v: Any) -> Equations:
        pull = norm(v.rope.force)
        if self.tension is None:
            return Equations(rates={"travel": v.speed}, outputs={"rope_tension": pull})
        return Equations(residuals={"tension_kept": pull - v.tension}, outputs={"rope_tension": pull})

    def laws(self, v: Any) -> dict[str, laws.Law]:
        if self.tension is None:
            return {}
        return {"tension_kept": laws.Law(laws.tension(v.rope.force) - v.tension, v.tension)}


@checked
@dataclass(frozen=True)
class MovingDrum(Drum):
    """A drum with the inertia of its rope, and its own where it holds a tension; arguments as of a `Drum`."""

    inertial: ClassVar[bool] = True

    @property
    def rope(self) -> Seat:
        if self.tension is not None:
            return moving_seat(super().rope)
        return replace(super().rope, speed="speed", acceleration="speed_rate")

    @property
    def balance(self) -> None:
        return None

    def structure(self, site: Site) -> Hashable:
        return self.tension is None

    def driver(self, name: str) -> float | Schedule | None:
        return 0.0 if name == "speed_rate" else super().driver(name)

    def variables(self, site: Site) -> tuple[Variable, ...]:
        own = super().variables(site)
        work = Variable("work", Kind.STATE, "J", "work of the drum on the rope", nominal=1e3)
        if self.tension is None:
            return (*own, Variable("speed_rate", Kind.INPUT, "m/s2", "rate of the speed", rate_of="speed"), work)
        return (
            *inertial_law(own),
            *travel_variables(),
            Variable("inertia", Kind.PARAMETER, "kg", "inertia of the drum", self.inertia, 100.0, range=NOT_NEGATIVE),
            work,
            *energy_outputs(hangs=False),
        )

    def equations(self, v: Any) -> Equations:
        found = super().equations(v)
        carried, along, side = v.rope.carried, v.rope.along, v.rope.side
        if self.tension is None:
            power = v.speed * (along - side * carried)
            return replace(found, rates={**found.rates, "work": power})
        pull = found.outputs["rope_tension"]
        kept = v.tension * (1 + v.tension * (carried - pull) / pull**2)  # what the rope carries at that tension
        inertia = v.inertia * v.rope_acceleration + along
        return Equations(
            rates={
                "travel": v.rope_speed,
                "rope_speed": v.rope_acceleration,
                "work": -side * kept * v.rope_speed,
            },
            residuals={"tension_kept": inertia - side * (carried - kept)},
            outputs={**found.outputs, "kinetic_energy": v.inertia / 2 * v.rope_speed**2},
        )
