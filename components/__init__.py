"""Floor 1: what a thing is. One component a file, physics only."""

from ropeway.components.anchor import Anchor
from ropeway.components.control_sheave import ControlSheave
from ropeway.components.drive import HydraulicDrive, IdealDrive
from ropeway.components.drum import Drum
from ropeway.components.load import Load
from ropeway.components.power_unit import HydraulicPowerUnit
from ropeway.components.response import ProportionalResponse, ThresholdResponse
from ropeway.components.return_wheel import TensionedReturn
from ropeway.components.rope import CONSTRUCTIONS, ConstructionStretch, Elastic, Rope
from ropeway.components.schedule import Schedule
from ropeway.components.sheave import Sheave
from ropeway.components.span import Span

__all__ = [
    "CONSTRUCTIONS",
    "Anchor",
    "ConstructionStretch",
    "ControlSheave",
    "Drum",
    "Elastic",
    "HydraulicDrive",
    "HydraulicPowerUnit",
    "IdealDrive",
    "Load",
    "ProportionalResponse",
    "Rope",
    "Schedule",
    "Sheave",
    "Span",
    "TensionedReturn",
    "ThresholdResponse",
]
