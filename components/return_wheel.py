"""The return wheel of an endless rope, with a counterweight or a hydraulic take-up."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropeway.components import check, laws
from ropeway.components.argument_checks import checked
from ropeway.components.check import POSITIVE
from ropeway.components.errors import InputError
from ropeway.components.sheave import Wheel, free_or_held, held_variables, tension_law
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

    def __post_init__(self) -> None:
        super().__post_init__()
        check.positive(self.take_up, self.described, "take_up", "N")
        if len(self.direction) != 3:
            raise InputError(f"{self.described}: direction has {len(self.direction)} components", "Give (x, y, z)")
        for value in self.direction:
            check.number(value, self.described, "a component of direction")
        if not any(self.direction):
            raise InputError(f"{self.described}: direction is zero", "Give the direction of the take-up force")

    @property
    def balance(self) -> str:
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
                "tension_law": tension_law(v, outputs["tension_in"], outputs["tension_out"]),
            },
            outputs=outputs,
        )

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
