"""An intermediate support: a jack with a saddle."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

from ropeway.components import check
from ropeway.components.component import Equations, Kind, Limit, Site, Variable
from ropeway.components.sheave import Wheel
from ropeway.components.smooth import sign
from ropeway.components.spar import Standing


@dataclass(frozen=True, kw_only=True)
class IntermediateSupport(Standing, Wheel):
    """A jack that carries the skyline in a saddle. Frictionless: equal tension on both sides.

    friction: coefficient of the rope in the saddle. The tension ratio is then exp(friction * wrap) against the
    way in which the rope has slid (capstan), reached smoothly within `slip` metres of travel from where the
    rope lay at rest, which was at a travel of `rest` metres. Raises InputError.
    """

    friction: float = 0.0
    slip: float = 0.005
    rest: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check.not_negative(self.friction, self.label, "friction")
        check.positive(self.slip, self.label, "slip", "m")
        check.number(self.rest, self.label, "rest", "m")

    @property
    def balance(self) -> str:
        return "tension_law"

    def limits(self) -> tuple[Limit, ...]:
        carried = () if self.capacity is None else (Limit("bearing_load", "above capacity", high=self.capacity),)
        return (*super().limits(), *carried)

    def structure(self, site: Site) -> Hashable:
        return (IntermediateSupport, self.friction > 0.0)

    def variables(self, site: Site) -> tuple[Variable, ...]:
        rough = (
            Variable("friction", Kind.PARAMETER, "1", "friction of the rope in the saddle", self.friction),
            Variable("slip", Kind.PARAMETER, "m", "travel in which friction builds up", self.slip),
            Variable("grip", Kind.PARAMETER, "m", "travel at which the rope lay at rest", self.rest, site.length),
        )
        return (
            *self.place(),
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
        return Equations(residuals={"tension_law": t_out - t_in}, outputs=outputs)
