"""A point where ropes meet: ropes in series, bridles and nets."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from ropeway.components import check, laws
from ropeway.components.argument_checks import checked
from ropeway.components.check import NOT_NEGATIVE
from ropeway.components.component import Component, Seat
from ropeway.components.form import remade
from ropeway.components.inertia import Inertia
from ropeway.components.moving_node import energies, energy_outputs, inertial_force, motion_rates, motion_variables
from ropeway.components.node import Node
from ropeway.components.variable import Equations, Kind, MovingMass, Site, Variable


@checked
@dataclass(frozen=True)
class Joint(Node):
    """A shackle, ring or knot held by its ropes only; its position follows from the balance of forces and weight.

    Each rope that is strung to it, or connected to `rope`, takes an end of its own. After Broughton and Ndumbaro (1994)
    and Peyrot and Goulois (1979), who assemble cable nets from exact catenaries at such points.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float
        Initial guess of its position, (x, z) or (x, y, z) [m].
    mass : float, default 0
        Mass of the joint and of anything fixed to it [kg].
    ends : int, default 8
        Largest number of rope ends.
    label : str, optional
        Text in pictures and messages; by default the name.

    Raises
    ------
    InputError
        A negative mass, or fewer than two ends.

    Examples
    --------
    >>> s = rw.System("bridle")
    >>> knot = s.add(rw.Joint("knot", at=(50.0, -20.0), mass=800.0))
    >>> for name, x in (("p", 0.0), ("q", 100.0)):
    ...     spans = s.string(rope, rw.Anchor(name, at=(x, 0.0)), knot, length=55.0)
    >>> print(f"{rw.equilibrium(s)['knot.z']:.2f} m")
    -22.84 m
    """

    interchangeable: ClassVar[bool] = True

    mass: float = 0.0
    ends: int = 8

    def __post_init__(self) -> None:
        super().__post_init__()
        check.not_negative(self.mass, self.described, "mass", "kg")
        check.index(self.ends - 2, 98, self.described, "ends less 2")

    def with_inertia(self, inertia: Inertia) -> Component:
        return remade(self, MovingJoint) if type(self) is Joint else self

    @property
    def rope(self) -> Seat:
        """A seat for a rope end."""
        return self.seats[0]

    @property
    def seats(self) -> tuple[Seat, ...]:
        return tuple(Seat(self, f"end_{i + 1}", optional=True) for i in range(self.ends))

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        return tuple((axis, f"balance_{axis}") for axis in "xyz")

    def masses(self, read: Callable[[str], Any]) -> tuple[MovingMass, ...]:
        return tuple(MovingMass(axis, read("mass"), {f"balance_{axis}": 1.0}) for axis in "xyz")

    def structure(self, site: Site) -> Hashable:
        return self.ends

    def variables(self, site: Site) -> tuple[Variable, ...]:
        return (
            *(
                Variable(axis, Kind.ALGEBRAIC, "m", f"{axis} of the joint", value, 100.0)
                for axis, value in zip("xyz", self.position, strict=True)
            ),
            Variable("mass", Kind.PARAMETER, "kg", "mass of the joint", self.mass, 1000.0, range=NOT_NEGATIVE),
            *(
                Variable(f"balance_{axis}", Kind.RESIDUAL, "N", f"forces on the joint, {axis}", 0.0, site.force)
                for axis in "xyz"
            ),
        )

    def equations(self, v: Any) -> Equations:
        pulls = [getattr(v, seat.name).force for seat in self.seats]
        total = [sum(pull[i] for pull in pulls) for i in range(3)]
        total[2] = total[2] - v.mass * v.gravity
        return Equations(residuals={f"balance_{axis}": total[i] for i, axis in enumerate("xyz")})

    def laws(self, v: Any) -> dict[str, laws.Law]:
        pulls = [getattr(v, seat.name).force for seat in self.seats]
        found = laws.balance(*pulls, laws.weight(v.mass * v.gravity))
        return {f"balance_{axis}": law for axis, law in found.items()}


@checked
@dataclass(frozen=True)
class MovingJoint(Joint):
    """A joint with its inertia and that of its ropes; arguments as of a `Joint`."""

    inertial: ClassVar[bool] = True

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        return ()

    def structure(self, site: Site) -> Hashable:
        return self.ends

    def variables(self, site: Site) -> tuple[Variable, ...]:
        own = super().variables(site)
        places = {v.name: v for v in own if v.name in "xyz"}
        return (*(v for v in own if v.name not in places), *motion_variables(places), *energy_outputs())

    def equations(self, v: Any) -> Equations:
        found, seats = super().equations(v), [seat.name for seat in self.seats]
        balances = {
            f"balance_{axis}": found.residuals[f"balance_{axis}"] - inertial_force(v, axis, v.mass, seats)
            for axis in "xyz"
        }
        return replace(found, rates=motion_rates(v, "xyz"), residuals=balances, outputs=energies(v, v.mass, "xyz"))
