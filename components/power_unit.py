"""A hydraulic power unit that feeds several drives: pump flow and engine power are shared."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.check import POSITIVE
from ropeway.components.component import Component, Equations, Kind, Port, Site, Variable
from ropeway.components.smooth import clip_above


@checked
@dataclass(frozen=True)
class HydraulicPowerUnit(Component):
    """One pump and engine for several drives. pump_flow [m3/s] and engine_power [W] in all.

    While the drives ask for less they get what they ask for; beyond, each gets the same part of its demand.
    Each drive's own limits hold besides. Raises InputError.
    """

    pump_flow: float
    engine_power: float

    def __post_init__(self) -> None:
        super().__post_init__()
        owner = f"HydraulicPowerUnit {self.name!r}"
        check.positive(self.pump_flow, owner, "pump_flow", "m3/s")
        check.positive(self.engine_power, owner, "engine_power", "W")

    @property
    def ports(self) -> tuple[Port, ...]:
        return ()

    @property
    def sums(self) -> tuple[str, ...]:
        return ("flow", "power")

    def structure(self, site: Site) -> Hashable:
        return ()

    def variables(self, site: Site) -> tuple[Variable, ...]:
        par, out = Kind.PARAMETER, Kind.OUTPUT
        return (
            Variable("pump_flow", par, "m3/s", "largest flow of the pump", self.pump_flow, 1e-3, range=POSITIVE),
            Variable("engine_power", par, "W", "largest power of the engine", self.engine_power, 1e4, range=POSITIVE),
            Variable("flow_demand", out, "m3/s", "flow that the drives ask for", nominal=1e-3),
            Variable("power_demand", out, "W", "power that the drives ask for", nominal=1e4),
            Variable("flow_share", out, "1", "part of the flow asked for that each drive gets"),
            Variable("power_share", out, "1", "part of the power asked for that each driving drive gets"),
        )

    def equations(self, v: Any) -> Equations:
        """`v.flow` and `v.power` are the sums of what the drives ask for."""
        return Equations(
            outputs={
                "flow_demand": v.flow,
                "power_demand": v.power,
                "flow_share": clip_above(v.pump_flow / (v.flow + 1e-3 * v.pump_flow), 1.0),
                "power_share": clip_above(v.engine_power / (v.power + 1e-3 * v.engine_power), 1.0),
            }
        )
