"""A hydraulic power unit that feeds several drives: pump flow and engine power are shared."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

from ropeway.components import check
from ropeway.components.argument_checks import checked
from ropeway.components.check import POSITIVE
from ropeway.components.component import Component, Port
from ropeway.components.smooth import clip_above
from ropeway.components.variable import Equations, Kind, Site, Variable


@checked
@dataclass(frozen=True)
class HydraulicPowerUnit(Component):
    """A pump and an engine that several drives share.

    If the drives demand more than the pump flow or the engine power, each receives the same fraction of its demand. The
    limits of each drive apply as well.

    Parameters
    ----------
    name : str
        Identifier; dotted names of results begin with it.
    pump_flow : float
        Total flow [m3/s].
    engine_power : float
        Total power [W].

    Raises
    ------
    InputError
        A value that is not positive.

    Examples
    --------
    >>> rw.HydraulicPowerUnit("unit", pump_flow=4e-3, engine_power=30e3).pump_flow
    0.004
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
            Variable("flow_demand", out, "m3/s", "flow demand of the drives", nominal=1e-3),
            Variable("power_demand", out, "W", "power demand of the drives", nominal=1e4),
            Variable("flow_share", out, "1", "fraction of its flow demand that each drive receives"),
            Variable("power_share", out, "1", "fraction of its power demand that each driving drive receives"),
        )

    def equations(self, v: Any) -> Equations:
        """`v.flow` and `v.power` are the sums of the demands."""
        return Equations(
            outputs={
                "flow_demand": v.flow,
                "power_demand": v.power,
                "flow_share": clip_above(v.pump_flow / (v.flow + 1e-3 * v.pump_flow), 1.0),
                "power_share": clip_above(v.engine_power / (v.power + 1e-3 * v.engine_power), 1.0),
            }
        )
