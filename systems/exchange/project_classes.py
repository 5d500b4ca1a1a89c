"""Classes that project files name without a module: the parts of systems and rigs."""

from __future__ import annotations

from collections.abc import Mapping

from ropeway.components.anchor import Anchor, SpringAnchor
from ropeway.components.carriage import Carriage
from ropeway.components.carriage_on_shoe import CarriageOnShoe
from ropeway.components.control_sheave import ControlSheave
from ropeway.components.diesel_unit import DieselHydraulicUnit
from ropeway.components.drive import IdealDrive
from ropeway.components.drum import Drum
from ropeway.components.environment import Environment
from ropeway.components.ground import Ground
from ropeway.components.guyed_spar import GuyedSpar, Guyline
from ropeway.components.hydraulic_drive import HydraulicDrive
from ropeway.components.inertia import Inertia
from ropeway.components.intermediate_support import IntermediateSupport
from ropeway.components.joint import Joint
from ropeway.components.load import Load
from ropeway.components.log import Log
from ropeway.components.map_frame import MapFrame
from ropeway.components.plan_axis import PlanAxis
from ropeway.components.power_unit import HydraulicPowerUnit
from ropeway.components.response import ProportionalResponse, ThresholdResponse
from ropeway.components.return_wheel import TensionedReturn
from ropeway.components.rope import ConstructionStretch, Elastic, Rope
from ropeway.components.sheave import Sheave
from ropeway.components.span import Span
from ropeway.components.spar import Block, HeadSpar, Tailhold, TailSpar
from ropeway.components.terrain import Profile
from ropeway.systems.modelling.intervention import Intervention
from ropeway.systems.rigs.turn import Turn

CLASSES: Mapping[str, type] = {
    cls.__name__: cls
    for cls in (
        Anchor, Block, Carriage, CarriageOnShoe, ConstructionStretch, ControlSheave, DieselHydraulicUnit, Drum,
        Elastic, Environment, Ground, GuyedSpar, Guyline, HeadSpar, HydraulicDrive, HydraulicPowerUnit, IdealDrive,
        Inertia, IntermediateSupport, Intervention, Joint, Load, Log, MapFrame, PlanAxis, Profile,
        ProportionalResponse, Rope, Sheave, Span, SpringAnchor, TailSpar, Tailhold, TensionedReturn, ThresholdResponse,
        Turn,
    )
}  # fmt: skip
