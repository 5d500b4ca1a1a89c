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
        CarriageOnShoe as CarriageOnShoe,
    )
    from ropeway.components import (
        ConstructionStretch as ConstructionStretch,
    )
    from ropeway.components import (
        ControlSheave as ControlSheave,
    )
    from ropeway.components import (
        DieselHydraulicUnit as DieselHydraulicUnit,
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
        HydraulicDrive as HydraulicDrive,
    )
    from ropeway.components import (
        HydraulicPowerUnit as HydraulicPowerUnit,
    )
    from ropeway.components import (
        IdealDrive as IdealDrive,
    )
    from ropeway.components import (
        IntermediateSupport as IntermediateSupport,
    )
    from ropeway.components import (
        Joint as Joint,
    )
    from ropeway.components import (
        Load as Load,
    )
    from ropeway.components import (
        Log as Log,
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
        SpringAnchor as SpringAnchor,
    )
    from ropeway.components import (
        Tailhold as Tailhold,
    )
    from ropeway.components import (
        TailSpar as TailSpar,
    )
    from ropeway.components import (
        TensionedReturn as TensionedReturn,
    )
    from ropeway.components import (
        ThresholdResponse as ThresholdResponse,
    )
    from ropeway.components import units as units
    from ropeway.components.component import Component as Component
    from ropeway.components.component import Energies as Energies
    from ropeway.components.component import Equations as Equations
    from ropeway.components.component import Kind as Kind
    from ropeway.components.component import Limit as Limit
    from ropeway.components.component import Node as Node
    from ropeway.components.component import RopeEnd as RopeEnd
    from ropeway.components.component import Seat as Seat
    from ropeway.components.component import Site as Site
    from ropeway.components.component import Variable as Variable
    from ropeway.components.drive import Drive as Drive
    from ropeway.components.drive import DriveMotion as DriveMotion
    from ropeway.components.errors import (
        EquilibriumError as EquilibriumError,
    )
    from ropeway.components.errors import (
        InfeasibleScheduleError as InfeasibleScheduleError,
    )
    from ropeway.components.errors import (
        InputError as InputError,
    )
    from ropeway.components.errors import (
        Interrupted as Interrupted,
    )
    from ropeway.components.errors import (
        OutOfReachError as OutOfReachError,
    )
    from ropeway.components.errors import (
        RopewayError as RopewayError,
    )
    from ropeway.components.errors import (
        RopewayWarning as RopewayWarning,
    )
    from ropeway.components.errors import (
        ScheduleError as ScheduleError,
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
    from ropeway.components.errors import (
        WorkerError as WorkerError,
    )
    from ropeway.components.errors import (
        WriteError as WriteError,
    )
    from ropeway.components.rope_catalogue import carriages as carriages
    from ropeway.components.rope_catalogue import ropes as ropes
    from ropeway.components.rope_catalogue import yarders as yarders
    from ropeway.components.table_writer import write_table as write_table
    from ropeway.components.terrain import Profile as Profile
    from ropeway.systems.dynamics.result import Result as Result
    from ropeway.systems.dynamics.simulation import simulate as simulate
    from ropeway.systems.exchange.study_inputs import StudyInputs as StudyInputs
    from ropeway.systems.modelling.assembly import assemble as assemble
    from ropeway.systems.modelling.component_functions import check_component as check_component
    from ropeway.systems.modelling.dae_model import Model as Model
    from ropeway.systems.modelling.intervention import Intervention as Intervention
    from ropeway.systems.modelling.system import System as System
    from ropeway.systems.rigs.endless import endless as endless
    from ropeway.systems.rigs.guylines import string_guylines as string_guylines
    from ropeway.systems.rigs.live_skyline import gravity_skyline as gravity_skyline
    from ropeway.systems.rigs.live_skyline import live_skyline as live_skyline
    from ropeway.systems.rigs.monocable import monocable as monocable
    from ropeway.systems.rigs.running_skyline import running_skyline as running_skyline
    from ropeway.systems.rigs.skyline_rig import SkylineRig as SkylineRig
    from ropeway.systems.rigs.skyline_rig import Turn as Turn
    from ropeway.systems.rigs.standing_skyline import standing_skyline as standing_skyline
    from ropeway.systems.statics.equilibrium import Equilibrium as Equilibrium
    from ropeway.systems.statics.equilibrium_solver import equilibrium as equilibrium
    from ropeway.systems.studies.control.objectives import objectives as objectives
    from ropeway.systems.studies.control.optimise_schedule import optimise_schedule as optimise_schedule
    from ropeway.systems.studies.control.receding_horizon import RecedingHorizon as RecedingHorizon
    from ropeway.systems.studies.control.receding_horizon import receding_horizon as receding_horizon
    from ropeway.systems.studies.control.scheduling.initial_schedules import balanced as balanced
    from ropeway.systems.studies.control.scheduling.limits import ScheduleLimits as ScheduleLimits
    from ropeway.systems.studies.control.scheduling.robustness import Disturbance as Disturbance
    from ropeway.systems.studies.control.scheduling.schedule_plan import SchedulePlan as SchedulePlan
    from ropeway.systems.studies.control.tune_response import TunedResponse as TunedResponse
    from ropeway.systems.studies.control.tune_response import tune_response as tune_response
    from ropeway.systems.studies.handbook.cable_stretch import UnstretchedLength as UnstretchedLength
    from ropeway.systems.studies.handbook.cable_stretch import fit_construction_stretch as fit_construction_stretch
    from ropeway.systems.studies.handbook.cable_stretch import stretched_position as stretched_position
    from ropeway.systems.studies.handbook.cable_stretch import unstretched_length as unstretched_length
    from ropeway.systems.studies.handbook.inextensible_catenary import CatenaryCurve as CatenaryCurve
    from ropeway.systems.studies.handbook.inextensible_catenary import (
        catenary_for_horizontal as catenary_for_horizontal,
    )
    from ropeway.systems.studies.handbook.inextensible_catenary import catenary_for_length as catenary_for_length
    from ropeway.systems.studies.handbook.inextensible_catenary import catenary_for_sag as catenary_for_sag
    from ropeway.systems.studies.handbook.inextensible_catenary import catenary_for_tension as catenary_for_tension
    from ropeway.systems.studies.handbook.lira_worksheet import lira_worksheet as lira_worksheet
    from ropeway.systems.studies.handbook.loaded_span import LoadedSpan as LoadedSpan
    from ropeway.systems.studies.handbook.longest_rope import longest_rope as longest_rope
    from ropeway.systems.studies.handbook.lyons_cases import twelve_cases as twelve_cases
    from ropeway.systems.studies.handbook.payload_comparison import compare_payload_methods as compare_payload_methods
    from ropeway.systems.studies.handbook.payload_comparison import method_errors as method_errors
    from ropeway.systems.studies.handbook.payload_exact import elastic_load as elastic_load
    from ropeway.systems.studies.handbook.payload_exact import exact_load as exact_load
    from ropeway.systems.studies.handbook.payload_methods import payload_for_tension as payload_for_tension
    from ropeway.systems.studies.handbook.payload_methods import tension_for_payload as tension_for_payload
    from ropeway.systems.studies.handbook.turk_solvers import SpanProblem as SpanProblem
    from ropeway.systems.studies.handbook.turk_solvers import solve_span as solve_span
    from ropeway.systems.studies.saved_files import load as load
    from ropeway.systems.studies.saved_files import run_study as run_study
    from ropeway.systems.studies.saved_files import save as save
    from ropeway.systems.studies.sensitivity.sensitivities import sensitivities as sensitivities
    from ropeway.systems.studies.skyline.inhaul import Inhaul as Inhaul
    from ropeway.systems.studies.skyline.inhaul import inhaul as inhaul
    from ropeway.systems.studies.skyline.load_path import load_path as load_path
    from ropeway.systems.studies.skyline.payload import PayloadStudy as PayloadStudy
    from ropeway.systems.studies.skyline.payload import payload as payload
    from ropeway.systems.studies.skyline.pretension import SetUp as SetUp
    from ropeway.systems.studies.skyline.pretension import set_up as set_up
    from ropeway.systems.studies.skyline.pretension import tension_history as tension_history
    from ropeway.systems.studies.skyline.support_layout import Candidate as Candidate
    from ropeway.systems.studies.skyline.support_layout import SupportPlan as SupportPlan
    from ropeway.systems.studies.skyline.support_layout import optimise_supports as optimise_supports
    from ropeway.systems.studies.skyline.support_layout import support_range as support_range
    from ropeway.systems.studies.sweeps.cases import latin_hypercube as latin_hypercube
    from ropeway.systems.studies.sweeps.sweep import sweep as sweep

_HOMES = {
    "ropeway.components": (
        "Anchor Block Carriage CarriageOnShoe ConstructionStretch ControlSheave DieselHydraulicUnit Drum "
        "Elastic GuyedSpar Guyline HeadSpar HydraulicDrive HydraulicPowerUnit IdealDrive IntermediateSupport "
        "Joint Load Log ProportionalResponse Rope Schedule Sheave Span SpringAnchor TailSpar Tailhold "
        "TensionedReturn ThresholdResponse"
    ),
    "ropeway.components.component": "Component Energies Equations Kind Limit Node RopeEnd Seat Site Variable",
    "ropeway.components.drive": "Drive DriveMotion",
    "ropeway.components.errors": (
        "EquilibriumError InfeasibleScheduleError InputError Interrupted OutOfReachError RopewayError "
        "RopewayWarning ScheduleError SimulationError SlackRopeError UnbalancedSystemError UnknownNameError "
        "WorkerError WriteError"
    ),
    "ropeway.components.rope_catalogue": "carriages ropes yarders",
    "ropeway.components.table_writer": "write_table",
    "ropeway.components.terrain": "Profile",
    "ropeway.systems.dynamics.result": "Result",
    "ropeway.systems.dynamics.simulation": "simulate",
    "ropeway.systems.exchange.study_inputs": "StudyInputs",
    "ropeway.systems.modelling.assembly": "assemble",
    "ropeway.systems.modelling.component_functions": "check_component",
    "ropeway.systems.modelling.dae_model": "Model",
    "ropeway.systems.modelling.intervention": "Intervention",
    "ropeway.systems.modelling.system": "System",
    "ropeway.systems.rigs.endless": "endless",
    "ropeway.systems.rigs.guylines": "string_guylines",
    "ropeway.systems.rigs.live_skyline": "gravity_skyline live_skyline",
    "ropeway.systems.rigs.monocable": "monocable",
    "ropeway.systems.rigs.running_skyline": "running_skyline",
    "ropeway.systems.rigs.skyline_rig": "SkylineRig Turn",
    "ropeway.systems.rigs.standing_skyline": "standing_skyline",
    "ropeway.systems.statics.equilibrium": "Equilibrium",
    "ropeway.systems.statics.equilibrium_solver": "equilibrium",
    "ropeway.systems.studies.control.objectives": "objectives",
    "ropeway.systems.studies.control.optimise_schedule": "optimise_schedule",
    "ropeway.systems.studies.control.receding_horizon": "RecedingHorizon receding_horizon",
    "ropeway.systems.studies.control.scheduling.initial_schedules": "balanced",
    "ropeway.systems.studies.control.scheduling.limits": "ScheduleLimits",
    "ropeway.systems.studies.control.scheduling.robustness": "Disturbance",
    "ropeway.systems.studies.control.scheduling.schedule_plan": "SchedulePlan",
    "ropeway.systems.studies.control.tune_response": "TunedResponse tune_response",
    "ropeway.systems.studies.handbook.cable_stretch": (
        "UnstretchedLength fit_construction_stretch stretched_position unstretched_length"
    ),
    "ropeway.systems.studies.handbook.inextensible_catenary": (
        "CatenaryCurve catenary_for_horizontal catenary_for_length catenary_for_sag catenary_for_tension"
    ),
    "ropeway.systems.studies.handbook.lira_worksheet": "lira_worksheet",
    "ropeway.systems.studies.handbook.loaded_span": "LoadedSpan",
    "ropeway.systems.studies.handbook.longest_rope": "longest_rope",
    "ropeway.systems.studies.handbook.lyons_cases": "twelve_cases",
    "ropeway.systems.studies.handbook.payload_comparison": "compare_payload_methods method_errors",
    "ropeway.systems.studies.handbook.payload_exact": "elastic_load exact_load",
    "ropeway.systems.studies.handbook.payload_methods": "payload_for_tension tension_for_payload",
    "ropeway.systems.studies.handbook.turk_solvers": "SpanProblem solve_span",
    "ropeway.systems.studies.saved_files": "load run_study save",
    "ropeway.systems.studies.sensitivity.sensitivities": "sensitivities",
    "ropeway.systems.studies.skyline.inhaul": "Inhaul inhaul",
    "ropeway.systems.studies.skyline.load_path": "load_path",
    "ropeway.systems.studies.skyline.payload": "PayloadStudy payload",
    "ropeway.systems.studies.skyline.pretension": "SetUp set_up tension_history",
    "ropeway.systems.studies.skyline.support_layout": "Candidate SupportPlan optimise_supports support_range",
    "ropeway.systems.studies.sweeps.cases": "latin_hypercube",
    "ropeway.systems.studies.sweeps.sweep": "sweep",
}
_MODULES = {"fmu": "ropeway.fmu", "units": "ropeway.components.units"}
_HOME = {name: module for module, names in _HOMES.items() for name in names.split()}

__version__ = "0.1.0"
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return import_module(_MODULES[name])
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'ropeway' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*globals(), *__all__]
