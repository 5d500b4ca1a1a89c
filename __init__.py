"""ropeway: cable logging systems and material ropeways as composable components.

    import ropeway as rw

Names are loaded when they are first used, so that the import itself is light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ropeway.components import (
        Anchor as Anchor,
    )
    from ropeway.components import (
        ConstructionStretch as ConstructionStretch,
    )
    from ropeway.components import (
        ControlSheave as ControlSheave,
    )
    from ropeway.components import (
        Drum as Drum,
    )
    from ropeway.components import (
        Elastic as Elastic,
    )
    from ropeway.components import (
        HydraulicDrive as HydraulicDrive,
    )
    from ropeway.components import (
        HydraulicPowerUnit as HydraulicPowerUnit,
    )
    from ropeway.components import (
        IdealDrive as IdealDrive,
    )
    from ropeway.components import (
        Load as Load,
    )
    from ropeway.components import (
        ProportionalResponse as ProportionalResponse,
    )
    from ropeway.components import (
        Rope as Rope,
    )
    from ropeway.components import (
        Schedule as Schedule,
    )
    from ropeway.components import (
        Sheave as Sheave,
    )
    from ropeway.components import (
        Span as Span,
    )
    from ropeway.components import (
        ThresholdResponse as ThresholdResponse,
    )
    from ropeway.components.errors import (
        EquilibriumError as EquilibriumError,
    )
    from ropeway.components.errors import (
        InputError as InputError,
    )
    from ropeway.components.errors import (
        RopewayError as RopewayError,
    )
    from ropeway.components.errors import (
        SimulationError as SimulationError,
    )
    from ropeway.components.errors import (
        SlackRopeError as SlackRopeError,
    )
    from ropeway.components.errors import (
        UnbalancedSystemError as UnbalancedSystemError,
    )
    from ropeway.components.errors import (
        UnknownNameError as UnknownNameError,
    )
    from ropeway.components.rope import ropes as ropes
    from ropeway.systems.assembly import assemble as assemble
    from ropeway.systems.equilibrium import Equilibrium as Equilibrium
    from ropeway.systems.equilibrium import equilibrium as equilibrium
    from ropeway.systems.intervention import Intervention as Intervention
    from ropeway.systems.model import Model as Model
    from ropeway.systems.result import Result as Result
    from ropeway.systems.rigs.monocable import monocable as monocable
    from ropeway.systems.simulation import simulate as simulate
    from ropeway.systems.system import System as System

_HOMES = {
    "ropeway.components": (
        "Anchor ConstructionStretch ControlSheave Drum Elastic HydraulicDrive HydraulicPowerUnit IdealDrive Load "
        "ProportionalResponse Rope Schedule Sheave Span ThresholdResponse"
    ),
    "ropeway.components.rope": "ropes",
    "ropeway.components.errors": (
        "EquilibriumError InputError RopewayError SimulationError SlackRopeError UnbalancedSystemError UnknownNameError"
    ),
    "ropeway.systems.assembly": "assemble",
    "ropeway.systems.equilibrium": "Equilibrium equilibrium",
    "ropeway.systems.intervention": "Intervention",
    "ropeway.systems.model": "Model",
    "ropeway.systems.result": "Result",
    "ropeway.systems.rigs.monocable": "monocable",
    "ropeway.systems.simulation": "simulate",
    "ropeway.systems.system": "System",
}
_HOME = {name: module for module, names in _HOMES.items() for name in names.split()}

__version__ = "0.1.0"
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'ropeway' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*globals(), *__all__]
