"""The public names of ropeway, and where they are defined."""

from . import fmu as fmu, units as units
from .components.anchor import Anchor as Anchor, SpringAnchor as SpringAnchor
from .components.carriage import Carriage as Carriage
from .components.carriage_on_shoe import CarriageOnShoe as CarriageOnShoe
from .components.component import Component as Component, RopeEnd as RopeEnd, Seat as Seat
from .components.control_sheave import ControlSheave as ControlSheave
from .components.diesel_unit import DieselHydraulicUnit as DieselHydraulicUnit
from .components.drive import Drive as Drive, DriveMotion as DriveMotion, IdealDrive as IdealDrive
from .components.drum import Drum as Drum
from .components.environment import Environment as Environment
from .components.errors import (
    CompiledError as CompiledError,
    CompilerError as CompilerError,
    DesignPointError as DesignPointError,
    EquilibriumError as EquilibriumError,
    FitError as FitError,
    InfeasibleScheduleError as InfeasibleScheduleError,
    InputError as InputError,
    Interrupted as Interrupted,
    OutOfReachError as OutOfReachError,
    RopewayError as RopewayError,
    RopewayWarning as RopewayWarning,
    ScheduleError as ScheduleError,
    SimulationError as SimulationError,
    SlackRopeError as SlackRopeError,
    UnbalancedSystemError as UnbalancedSystemError,
    UnknownNameError as UnknownNameError,
    WorkerError as WorkerError,
    WriteError as WriteError,
)
from .components.guyed_spar import GuyedSpar as GuyedSpar, Guyline as Guyline
from .components.hydraulic_drive import HydraulicDrive as HydraulicDrive
from .components.inertia import Inertia as Inertia
from .components.intermediate_support import IntermediateSupport as IntermediateSupport
from .components.joint import Joint as Joint
from .components.load import Load as Load
from .components.log import Log as Log
from .components.map_frame import MapFrame as MapFrame
from .components.node import Node as Node
from .components.power_unit import HydraulicPowerUnit as HydraulicPowerUnit
from .components.response import ProportionalResponse as ProportionalResponse, ThresholdResponse as ThresholdResponse
from .components.return_wheel import TensionedReturn as TensionedReturn
from .components.rope import (
    ConstructionStretch as ConstructionStretch,
    Elastic as Elastic,
    Rope as Rope,
)
from .components.rope_catalogue import carriages as carriages, ropes as ropes, yarders as yarders
from .components.schedule import Schedule as Schedule
from .components.sheave import Sheave as Sheave
from .components.span import Span as Span
from .components.spar import Block as Block, HeadSpar as HeadSpar, Tailhold as Tailhold, TailSpar as TailSpar
from .components.table_writer import write_table as write_table
from .components.terrain import Profile as Profile
from .components.variable import (
    Energies as Energies,
    Equations as Equations,
    Kind as Kind,
    Limit as Limit,
    MovingMass as MovingMass,
    Site as Site,
    Variable as Variable,
)
from .systems.dynamics.result import Result as Result
from .systems.dynamics.simulation import simulate as simulate
from .systems.exchange.gis import export_gis as export_gis
from .systems.exchange.places import places as places
from .systems.exchange.study_inputs import StudyInputs as StudyInputs
from .systems.modelling.assembly import assemble as assemble
from .systems.modelling.component_functions import check_component as check_component
from .systems.modelling.dae_model import Model as Model
from .systems.modelling.intervention import Intervention as Intervention
from .systems.modelling.system import System as System
from .systems.reporting.document import Project as Project
from .systems.rigs.endless import endless as endless
from .systems.rigs.guylines import string_guylines as string_guylines
from .systems.rigs.live_skyline import gravity_skyline as gravity_skyline, live_skyline as live_skyline
from .systems.rigs.monocable import monocable as monocable
from .systems.rigs.running_skyline import running_skyline as running_skyline
from .systems.rigs.skyline_rig import SkylineRig as SkylineRig
from .systems.rigs.standing_skyline import standing_skyline as standing_skyline
from .systems.rigs.stringing_table import stringing_table as stringing_table
from .systems.rigs.turn import Turn as Turn
from .systems.statics.equilibrium import Equilibrium as Equilibrium
from .systems.statics.equilibrium_solver import equilibrium as equilibrium
from .systems.studies.comparison import Comparison as Comparison, compare as compare
from .systems.studies.control.objectives import objectives as objectives
from .systems.studies.control.optimise_schedule import optimise_schedule as optimise_schedule
from .systems.studies.control.receding_horizon import (
    RecedingHorizon as RecedingHorizon,
    receding_horizon as receding_horizon,
)
from .systems.studies.control.scheduling.initial_schedules import balanced as balanced
from .systems.studies.control.scheduling.limits import ScheduleLimits as ScheduleLimits
from .systems.studies.control.scheduling.robustness import Disturbance as Disturbance
from .systems.studies.control.scheduling.schedule_plan import SchedulePlan as SchedulePlan
from .systems.studies.control.tune_response import TunedResponse as TunedResponse, tune_response as tune_response
from .systems.studies.fitting.fit import fit as fit
from .systems.studies.fitting.fit_result import Fit as Fit
from .systems.studies.fitting.information import Combination as Combination
from .systems.studies.fitting.monitor import Estimate as Estimate, Monitor as Monitor, monitor as monitor
from .systems.studies.handbook.cable_stretch import (
    UnstretchedLength as UnstretchedLength,
    fit_construction_stretch as fit_construction_stretch,
    stretched_position as stretched_position,
    unstretched_length as unstretched_length,
)
from .systems.studies.handbook.inextensible_catenary import (
    CatenaryCurve as CatenaryCurve,
    catenary_for_horizontal as catenary_for_horizontal,
    catenary_for_length as catenary_for_length,
    catenary_for_sag as catenary_for_sag,
    catenary_for_tension as catenary_for_tension,
)
from .systems.studies.handbook.lira_worksheet import lira_worksheet as lira_worksheet
from .systems.studies.handbook.loaded_span import LoadedSpan as LoadedSpan
from .systems.studies.handbook.longest_rope import longest_rope as longest_rope
from .systems.studies.handbook.lyons_cases import twelve_cases as twelve_cases
from .systems.studies.handbook.payload_comparison import (
    compare_payload_methods as compare_payload_methods,
    method_errors as method_errors,
)
from .systems.studies.handbook.payload_exact import elastic_load as elastic_load, exact_load as exact_load
from .systems.studies.handbook.payload_methods import (
    payload_for_tension as payload_for_tension,
    tension_for_payload as tension_for_payload,
)
from .systems.studies.handbook.sighted_span import catenary_for_sights as catenary_for_sights
from .systems.studies.handbook.turk_solvers import SpanProblem as SpanProblem, solve_span as solve_span
from .systems.studies.inertia.emergency_stop import (
    EmergencyStops as EmergencyStops,
    emergency_stop as emergency_stop,
)
from .systems.studies.inertia.modes import Modes as Modes, modes as modes
from .systems.studies.load_cases.load_case import LoadCase as LoadCase
from .systems.studies.load_cases.study import LoadCases as LoadCases, load_cases as load_cases
from .systems.studies.load_cases.support_table import support_table as support_table
from .systems.studies.saved_files import load as load, run_study as run_study, save as save
from .systems.studies.sensitivity.sensitivities import sensitivities as sensitivities
from .systems.studies.skyline.inhaul.study import Inhaul as Inhaul, inhaul as inhaul
from .systems.studies.skyline.load_path import load_path as load_path
from .systems.studies.skyline.payload.study import PayloadStudy as PayloadStudy, payload as payload
from .systems.studies.skyline.pretension import SetUp as SetUp, set_up as set_up, tension_history as tension_history
from .systems.studies.skyline.reporting.path_report import load_path_report as load_path_report
from .systems.studies.skyline.support_layout import (
    Candidate as Candidate,
    SupportPlan as SupportPlan,
    optimise_supports as optimise_supports,
    support_range as support_range,
)
from .systems.studies.sweeps.cases import latin_hypercube as latin_hypercube
from .systems.studies.sweeps.sweep import sweep as sweep
from .systems.studies.uncertainty.assured_payload import assured_payload as assured_payload
from .systems.studies.uncertainty.exceedance import exceedance as exceedance
from .systems.studies.uncertainty.reliability import Reliability as Reliability, reliability as reliability
from .systems.studies.uncertainty.sobol_indices import sobol_indices as sobol_indices
from .systems.studies.uncertainty.uncertain import Uncertain as Uncertain

__version__: str
