"""ropeway: cable logging systems and material ropeways as composable components.

    import ropeway as rw

Names are loaded when they are first used, so that the import itself is light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ropeway.components import (
        Anchor as Anchor,
        ConstructionStretch as ConstructionStretch,
        ControlSheave as ControlSheave,
        Drum as Drum,
        Elastic as Elastic,
        Load as Load,
        Rope as Rope,
        Schedule as Schedule,
        Sheave as Sheave,
        Span as Span,
    )
    from ropeway.components.errors import (
        EquilibriumError as EquilibriumError,
        InputError as InputError,
        RopewayError as RopewayError,
        SimulationError as SimulationError,
        SlackRopeError as SlackRopeError,
        UnbalancedSystemError as UnbalancedSystemError,
        UnknownNameError as UnknownNameError,
    )
    from ropeway.systems.assembly import assemble as assemble
    from ropeway.systems.equilibrium import Equilibrium as Equilibrium, equilibrium as equilibrium
    from ropeway.systems.model import Model as Model
    from ropeway.systems.system import System as System

_HOMES = {
    "ropeway.components": ("Anchor ConstructionStretch ControlSheave Drum Elastic Load Rope Schedule Sheave Span"),
    "ropeway.components.errors": (
        "EquilibriumError InputError RopewayError SimulationError SlackRopeError UnbalancedSystemError UnknownNameError"
    ),
    "ropeway.systems.assembly": "assemble",
    "ropeway.systems.equilibrium": "Equilibrium equilibrium",
    "ropeway.systems.model": "Model",
    "ropeway.systems.system": "System",
}
_HOME = {name: module for module, names in _HOMES.items() for name in names.split()}

__version__ = "0.1.0"
__all__ = sorted(_HOME)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'ropeway' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*globals(), *__all__]
