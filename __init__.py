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
        Block as Block,
    )
    from ropeway.components import (
        Carriage as Carriage,
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
        GuyedSpar as GuyedSpar,
    )
    from ropeway.components import (
        Guyline as Guyline,
    )
    from ropeway.components import (
        HeadSpar as HeadSpar,
    )
    from ropeway.components import (
        IntermediateSupport as IntermediateSupport,
    )
    from ropeway.components import (
        Load as Load,
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
        SpringAnchor as SpringAnchor,
    )
    from ropeway.components import (
        Tailhold as Tailhold,
    )
    from ropeway.components import (
        TailSpar as TailSpar,
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
    from ropeway.systems.model import Model as Model
    from ropeway.systems.result import Result as Result
    from ropeway.systems.rigs.guylines import string_guylines as string_guylines
    from ropeway.systems.rigs.live_skyline import gravity_skyline as gravity_skyline
    from ropeway.systems.rigs.live_skyline import live_skyline as live_skyline
    from ropeway.systems.rigs.monocable import monocable as monocable
    from ropeway.systems.rigs.running_skyline import running_skyline as running_skyline
    from ropeway.systems.rigs.skyline import SkylineRig as SkylineRig
    from ropeway.systems.rigs.standing_skyline import standing_skyline as standing_skyline
    from ropeway.systems.simulation import simulate as simulate
    from ropeway.systems.studies.load_path import load_path as load_path
    from ropeway.systems.studies.payload import PayloadStudy as PayloadStudy
    from ropeway.systems.studies.payload import payload as payload
    from ropeway.systems.studies.set_up import SetUp as SetUp
    from ropeway.systems.studies.set_up import set_up as set_up
    from ropeway.systems.studies.set_up import tension_history as tension_history
    from ropeway.systems.studies.terrain import Profile as Profile
    from ropeway.systems.system import System as System

_HOMES = {
    "ropeway.components": (
        "Anchor Block Carriage ConstructionStretch ControlSheave Drum Elastic GuyedSpar Guyline HeadSpar "
        "IntermediateSupport Load Rope Schedule Sheave Span SpringAnchor TailSpar Tailhold"
    ),
    "ropeway.components.rope": "ropes",
    "ropeway.components.errors": (
        "EquilibriumError InputError RopewayError SimulationError SlackRopeError UnbalancedSystemError UnknownNameError"
    ),
    "ropeway.systems.assembly": "assemble",
    "ropeway.systems.equilibrium": "Equilibrium equilibrium",
    "ropeway.systems.model": "Model",
    "ropeway.systems.result": "Result",
    "ropeway.systems.rigs.monocable": "monocable",
    "ropeway.systems.simulation": "simulate",
    "ropeway.systems.rigs.guylines": "string_guylines",
    "ropeway.systems.rigs.live_skyline": "gravity_skyline live_skyline",
    "ropeway.systems.rigs.running_skyline": "running_skyline",
    "ropeway.systems.rigs.skyline": "SkylineRig",
    "ropeway.systems.rigs.standing_skyline": "standing_skyline",
    "ropeway.systems.studies.load_path": "load_path",
    "ropeway.systems.studies.payload": "PayloadStudy payload",
    "ropeway.systems.studies.set_up": "SetUp set_up tension_history",
    "ropeway.systems.studies.terrain": "Profile",
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
