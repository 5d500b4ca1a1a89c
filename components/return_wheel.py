"""The return wheel of an endless rope, with a counterweight or a hydraulic take-up."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropeway.components import check, laws
from ropeway.components.argument_checks import checked
from ropeway.components.check import NOT_NEGATIVE, POSITIVE
from ropeway.components.component import Component
from ropeway.components.errors import InputError
from ropeway.components.form import remade
from ropeway.components.inertia import Inertia
from ropeway.components.moving_node import energy_outputs
from ropeway.components.sheave import (
    MovingWheel,
    Wheel,
    free_or_held,
    held_variables,
    inertial_law,
    tension_law,
    travel_variables,
)
from ropeway.components.variable import Energies, Equations, Kind, Site, Variable


@checked
@dataclass(frozen=True)
class TensionedReturn(Wheel):
    """A return wheel without friction on a slide, pulled by a constant take-up force.

    The wheel is a point: both parts of the rope end on its axle. A load that both sides push back stays on the wheel,
    as on a `Sheave`.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    at : tuple of float
        Position at zero slide, (x, z) or (x, y, z) [m].
    hold_down : bool, default False
        Whether the rope runs below the sheave, which presses it down. Otherwise lift-off is reported where the support
        pulls the rope down.
    direction : tuple of float, default (1, 0, 0)
        Direction of the take-up force, (x, y, z).
    take_up : float
        Force of the counterweight or the hydraulic cylinder [N].
    mass : float, default 0
        Mass of wheel, slide and counterweight, in simulations with inertia [kg].
    inertia : float, default 0
        Rotating inertia referred to the rope, in simulations with inertia [kg].
    label : str, optional
        Text in pictures and messages; by default the name.

    Raises
    ------
    InputError
        A force that is not positive, or an invalid direction.

    Examples
    --------
    >>> rw.TensionedReturn("return", at=(400.0, 20.0), take_up=90e3).take_up
    90000.0
    """

    direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    take_up: float = 0.0
    mass: float = 0.0
    inertia: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check.not_negative(self.mass, self.described, "mass", "kg")
        check.not_negative(self.inertia, self.described, "inertia", "kg")
        check.positive(self.take_up, self.described, "take_up", "N")
        if len(self.direction) != 3:
            raise InputError(f"{self.described}: direction has {len(self.direction)} components", "Give (x, y, z)")
        for value in self.direction:
            check.number(value, self.described, "a component of direction")
        if not any(self.direction):
            raise InputError(f"{self.described}: direction is zero", "Give the direction of the take-up force")

    def with_inertia(self, inertia: Inertia) -> Component:
        return remade(self, MovingReturn) if type(self) is TensionedReturn else self

    @property
    def balance(self) -> str | None:
        return "tension_law"

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        return (("slide", "drawn"),)

    def structure(self, site: Site) -> Hashable:
        return ()

    def variables(self, site: Site) -> tuple[Variable, ...]:
        par, alg, res = Kind.PARAMETER, Kind.ALGEBRAIC, Kind.RESIDUAL
        size = sum(d * d for d in self.direction) ** 0.5
        return (
            *(
                Variable(f"home_{x}", par, "m", f"{x} at zero slide", a, 100.0)
                for x, a in zip("xyz", self.position, strict=True)
            ),
            *(
                Variable(f"way_{x}", par, "1", f"direction of the take-up, {x}", d / size)
                for x, d in zip("xyz", self.direction, strict=True)
            ),
            Variable("take_up", par, "N", "force of the take-up", self.take_up, site.force, range=POSITIVE),
            *(
                Variable(x, alg, "m", f"{x} coordinate of the wheel", a, 100.0)
                for x, a in zip("xyz", self.position, strict=True)
            ),
            Variable("slide", alg, "m", "displacement of the wheel along its direction"),
            Variable("travel", alg, "m", "unstretched length of rope that has run over", 0.0, site.length),
            *held_variables(),
            *(Variable(f"guide_{x}", res, "m", f"the wheel is on its slide, {x}", 0.0, 1.0) for x in "xyz"),
            Variable("drawn", res, "N", "rope and take-up balance along the slide", 0.0, site.force),
            Variable("tension_law", res, "N", "tensions on both sides", 0.0, site.force),
            *self.wheel_outputs(site),
        )

    def equations(self, v: Any) -> Equations:
        outputs = self.wheel_equations(v)
        way, at = (v.way_x, v.way_y, v.way_z), (v.x, v.y, v.z)
        home = (v.home_x, v.home_y, v.home_z)
        pull = sum((v.a.force[i] + v.b.force[i]) * way[i] for i in range(3))
        return Equations(
            residuals={
                **{f"guide_{axis}": at[i] - home[i] - v.slide * way[i] for i, axis in enumerate("xyz")},
                "drawn": pull + v.take_up,
                **self._tension_law(v, outputs),
            },
            outputs=outputs,
        )

    def _tension_law(self, v: Any, outputs: dict[str, Any]) -> dict[str, Any]:
        return {"tension_law": tension_law(v, outputs["tension_in"], outputs["tension_out"])}

    def energies(self, read: Callable[[str], Any]) -> Energies:
        return Energies(supplied=self.take_up * read("slide"))

    def laws(self, v: Any) -> dict[str, laws.Law]:
        way, pull = np.stack([v.way_x, v.way_y, v.way_z]), v.a.force + v.b.force
        at, home = np.stack([v.x, v.y, v.z]), np.stack([v.home_x, v.home_y, v.home_z])
        off, metre = at - home - v.slide * way, np.ones_like(v.slide)
        return {
            **{f"guide_{axis}": laws.Law(off[i], metre) for i, axis in enumerate("xyz")},
            "drawn": laws.Law(np.sum(pull * way, axis=0) + v.take_up, v.take_up),
            "tension_law": free_or_held(v),
        }


@checked
@dataclass(frozen=True)
class MovingReturn(MovingWheel, TensionedReturn):
    """A return wheel with the inertia of its rope, its slide and itself; arguments as of a `TensionedReturn`."""

    @property
    def free(self) -> tuple[tuple[str, str], ...]:
        return ()

    def structure(self, site: Site) -> Hashable:
        return ()

    def variables(self, site: Site) -> tuple[Variable, ...]:
        par, state, alg, res = Kind.PARAMETER, Kind.STATE, Kind.ALGEBRAIC, Kind.RESIDUAL
        return (
            *(v for v in inertial_law(super().variables(site)) if v.name != "slide"),
            *travel_variables(),
            Variable("mass", par, "kg", "mass of wheel and slide", self.mass, 100.0, range=NOT_NEGATIVE),
            Variable("inertia", par, "kg", "rotating inertia", self.inertia, 100.0, range=NOT_NEGATIVE),
            Variable("slide", state, "m", "displacement of the wheel along its direction"),
            Variable("slide_speed", state, "m/s", "speed of the wheel along its direction", rate_of="slide"),
            Variable("slide_acceleration", alg, "m/s2", "acceleration of the wheel along its direction"),
            *(Variable(f"velocity_{x}", alg, "m/s", f"velocity, {x}") for x in "xyz"),
            *(Variable(f"acceleration_{x}", alg, "m/s2", f"acceleration, {x}") for x in "xyz"),
            *(Variable(f"guide_velocity_{x}", res, "m/s", f"the wheel moves along its slide, {x}") for x in "xyz"),
            *(Variable(f"guide_rate_{x}", res, "m/s2", f"the wheel speeds up along its slide, {x}") for x in "xyz"),
            *energy_outputs(hangs=False),
        )

    def _tension_law(self, v: Any, outputs: dict[str, Any]) -> dict[str, Any]:
        inertia = v.inertia * v.rope_acceleration + v.a.along + v.b.along
        return {"tension_law": inertia - (v.b.carried - v.a.carried)}

    def equations(self, v: Any) -> Equations:
        found = super().equations(v)
        ways = {"x": v.way_x, "y": v.way_y, "z": v.way_z}
        moving = {
            **{f"guide_velocity_{x}": getattr(v, f"velocity_{x}") - v.slide_speed * w for x, w in ways.items()},
            **{f"guide_rate_{x}": getattr(v, f"acceleration_{x}") - v.slide_acceleration * w for x, w in ways.items()},
        }
        dragged = sum((v.a.inertia[i] + v.b.inertia[i]) * w for i, w in enumerate(ways.values()))
        return Equations(
            rates={
                "travel": v.rope_speed,
                "rope_speed": v.rope_acceleration,
                "slide": v.slide_speed,
                "slide_speed": v.slide_acceleration,
            },
            residuals={
                **found.residuals,
                **moving,
                "drawn": found.residuals["drawn"] - v.mass * v.slide_acceleration - dragged,
            },
            outputs={
                **found.outputs,
                "kinetic_energy": (v.mass * v.slide_speed**2 + v.inertia * v.rope_speed**2) / 2,
            },
        )
