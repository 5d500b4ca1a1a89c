"""An object of every public class and valid arguments of every public function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pandas as pd
from scipy.stats import norm

import ropeway as rw
from ropeway.systems.studies.handbook.payload_methods import METHODS
from support.call_objects import (
    CARRIAGE,
    GROUND,
    HEAD,
    LOW_GROUND,
    MAP,
    POSITIONS,
    ROPE,
    STATIONS,
    TAIL,
    THIN,
    cases,
    drive,
    endless_supports,
    exported,
    fitted,
    fmu,
    folder,
    guyed,
    line,
    line_of_two,
    live_rig,
    log,
    new_rig,
    one_span,
    payloads,
    plan,
    response,
    rest,
    rig,
    rig_parts,
    run,
    supports,
)

LOADED = {"line": rw.LoadedSpan(180.0, 20.0, 0.1, 0.4), "weight": 23.5, "tension": 140e3}
CURVE = {"span": 120.0, "rise": -8.0}
HANGING = {"rope": ROPE, "horizontal": 40e3, "vertical": 9e3, "method": "elastic", "gravity": 9.8}


def instances() -> dict[str, Callable[[], Any]]:
    """An object of every public class; a constructor's arguments are its fields."""
    at = {"at": (3.0, 4.0)}
    return {
        "Anchor": lambda: rw.Anchor("a", **at),
        "Block": lambda: rw.Block("block", at=(3.0, 4.0), friction=0.01),
        "Candidate": lambda: rw.Candidate("tree", 80.0, (6.0, 8.0)),
        "Carriage": lambda: rw.Carriage("carriage", mass=300.0, payload=800.0),
        "CarriageOnShoe": lambda: rw.CarriageOnShoe(
            "carriage", mass=300.0, support=rw.IntermediateSupport("s", at=(9.0, 9.0), radius=3.0)
        ),
        "CatenaryCurve": lambda: rw.CatenaryCurve(120.0, -8.0, 900.0),
        "Combination": lambda: rw.Combination({"l1.mass": 1.0}, {"l1.mass": "kg"}, 40.0),
        "Comparison": lambda: rw.Comparison((), pd.DataFrame({"x": [1.0]})),
        "ConstructionStretch": lambda: rw.ConstructionStretch(0.03),
        "ControlSheave": lambda: rw.ControlSheave("c", drive=drive(), response=response(), **at),
        "DieselHydraulicUnit": lambda: rw.DieselHydraulicUnit(
            "unit", rated_power=9e4, rated_speed=230.0, inertia=4.0, displacement=1e-4, relief_pressure=3e7
        ),
        "Disturbance": lambda: rw.Disturbance("heavy", mass=1.1),
        "Drum": lambda: rw.Drum("drum", speed=0.5, **at),
        "Elastic": rw.Elastic,
        "EmergencyStops": lambda: rw.EmergencyStops(pd.DataFrame({"x": [1.0]}), ()),
        "Environment": lambda: rw.Environment(
            "iced", temperature=-20.0, ice_thickness=0.01, wind_pressure=250.0, wind_from=270.0
        ),
        "Equilibrium": rest,
        "Estimate": lambda: rw.Estimate(1.0, {"l1.mass": 90.0}, {"l1.mass": 4.0}, 3e4, 200.0, "a_c", {"A": 0.3}),
        "Fit": fitted,
        "GuyedSpar": guyed,
        "Guyline": lambda: guyed().guylines[0],
        "HeadSpar": lambda: HEAD,
        "HydraulicDrive": drive,
        "HydraulicPowerUnit": lambda: rw.HydraulicPowerUnit("unit", pump_flow=2e-3, engine_power=3e4),
        "IdealDrive": rw.IdealDrive,
        "Inhaul": lambda: rw.Inhaul(rig(), pd.DataFrame({"x": [1.0]}), pd.DataFrame({"x": [1.0]})),
        "IntermediateSupport": lambda: rw.IntermediateSupport("jack", station=125.0, height=8.0),
        "Intervention": lambda: rw.Intervention(1.0, "brake", "c"),
        "Inertia": lambda: rw.Inertia(nodes=2, damping=1e-3, zone=0.4),
        "Joint": lambda: rw.Joint("knot", mass=40.0, **at),
        "LoadCase": lambda: rw.LoadCase("cold", rw.Environment("cold", temperature=-20.0), "empty", 2.5),
        "LoadCases": cases,
        "Load": lambda: rw.Load("turn", 500.0),
        "LoadedSpan": lambda: rw.LoadedSpan(180.0, 20.0, 0.1, 0.4),
        "Log": log,
        "MapFrame": lambda: MAP,
        "Model": lambda: rest().model,
        "PayloadStudy": lambda: rw.PayloadStudy(rig(), pd.DataFrame({"x": [1.0]}), 3.0, 3.0, 1.0),
        "Modes": lambda: rw.modes(rest(), 0, 2),
        "Project": lambda: rw.Project(title="slope", place="valley"),
        "ProportionalResponse": response,
        "Reliability": lambda: rw.Reliability(
            "z", 3.0, True, 2.0, 0.02, 0.02, -0.1, pd.DataFrame({"importance": [1.0]}), 4
        ),
        "RecedingHorizon": lambda: rw.RecedingHorizon((), (), {}, run()),
        "Result": run,
        "Rope": lambda: ROPE,
        "SchedulePlan": plan,
        "ScheduleLimits": lambda: rw.ScheduleLimits(force=9e4, speed=(0.1, 2.0)),
        "SetUp": lambda: rw.SetUp(rig(), 200.0, 5e4, {}),
        "Sheave": lambda: rw.Sheave("s", friction=0.01, **at),
        "SkylineRig": rig,
        "Span": lambda: rw.Span("a_b", rope=ROPE, length=90.0),
        "SpanProblem": lambda: rw.SpanProblem(120.0, 4.0, 123.0, 30.0, 3e7, (40.0,), (900.0,)),
        "SpringAnchor": lambda: rw.SpringAnchor("a", stiffness=1e6, **at),
        "StudyInputs": lambda: rw.StudyInputs("payload", rig(), {"clearance": 1.0}),
        "SupportPlan": lambda: rw.SupportPlan(rig(), (), True, "", 80.0, 3),
        "TailSpar": lambda: TAIL,
        "Tailhold": lambda: rw.Tailhold("hold", at=(3.0, 4.0)),
        "TensionedReturn": lambda: rw.TensionedReturn("r", take_up=2e4, **at),
        "ThresholdResponse": lambda: rw.ThresholdResponse(low=1e4, high=3e4, increment=0.01),
        "TunedResponse": lambda: rw.TunedResponse(line(), response(), "all at once", 1.0, 2.0, pd.DataFrame()),
        "Turn": lambda: rw.Turn(log(), dropline=THIN, length=6.0),
        "Uncertain": lambda: rw.Uncertain({"a": norm(3.0, 1.0), "b": norm(5.0, 1.0)}, {("a", "b"): 0.3}),
        "UnstretchedLength": lambda: rw.unstretched_length(length=150.0, **HANGING),
        "fmu.ArchiveLimits": rw.fmu.ArchiveLimits,
        "fmu.Fmu": fmu,
        "fmu.FmuComponent": lambda: rw.fmu.component("part", exported(), ignore_events=True),
        "fmu.StepControl": lambda: rw.fmu.StepControl("Richardson"),
    }


def watched() -> dict[str, Any]:
    """Arguments of a monitor."""
    return {
        "line": line(), "columns": {"t": "time", "A": "c.tension_in"}, "free": ["*.mass"], "sigma": 100.0,
        "prior": {"*.mass": (90.0, 30.0)}, "drift": {"*.mass": 0.1},
    }  # fmt: skip


def functions() -> dict[str, Callable[[], dict[str, Any]]]:
    """Arguments of every public function, and of the constructors that are not their fields."""
    payload = {"rig": rig(), "payload": 900.0}
    optional = {"target": 3e4, "settle": 1.0, "start": None, "progress": False}
    ends = {"headspar": HEAD, "tailspar": TAIL, "mainline": THIN, "carriage": CARRIAGE, "name": "rig", "gravity": 9.81}
    ends["temperature"] = 5.0
    cold = {"environment": rw.Environment("cold", temperature=-20.0)}
    return {
        "Profile": lambda: {"station": [0.0, 50.0, 120.0], "elevation": [3.0, 5.0, -4.0], "map_frame": MAP},
        "Schedule": lambda: {"times": [0.0, 4.0], "speeds": [0.5, 1.0]},
        "System": lambda: {
            "name": "line", "gravity": 9.8, "precedence": "worst first", "terrain": GROUND, "temperature": 5.0,
        },
        "assemble": lambda: {"system": one_span(), "slots": None},
        "balanced": lambda: {"line": line()},
        "catenary_for_horizontal": lambda: {**CURVE, "horizontal": 30e3, "weight": 30.0},
        "catenary_for_length": lambda: {**CURVE, "length": 123.0},
        "catenary_for_sag": lambda: {**CURVE, "sag": 4.0, "at": 0.4},
        "catenary_for_sights": lambda: {
            "span": 460.29627, "left": (0.0, 1.497), "right": (2.607, 1.204),
            "points": [(0.0638, 1.4832), (0.2397, 1.3959)],
        },
        "catenary_for_tension": lambda: {**CURVE, "tension": 30e3, "weight": 30.0},
        "check_component": lambda: {"component": rw.Anchor("a", at=(3.0, 4.0))},
        "compare_payload_methods": lambda: {
            "span": 190.0, "deflection": 22.0, "chord_slopes": (0.0, 0.15), "rope": ROPE, "tension": 150e3,
            "carriage_mass": 140.0, "carriage": 0.5, "as_printed": False, "gravity": 9.8,
        },
        "elastic_load": lambda: {**LOADED, "strain": ROPE.strain, "joint": "rolling", "pull_slope": 0.1},
        "endless": lambda: {
            "rope": ROPE, "supports": endless_supports(), "tension": 22e3, "speed": 0.9, "load_mass": 90.0,
            "load_spacing": 40.0, "take_up": None, "drive": None, "name": "ring", "gravity": 9.8,
            "crs": None, "terrain": LOW_GROUND, "clearance": 1.0, "temperature": 5.0, "load_drag_area": 0.5,
        },
        "emergency_stop": lambda: {
            "line": line(), "decelerations": [2.0], "settle": 0.5, "every": 0.1, "start": None,
            "inputs": {"c.speed": 0.6}, "inertia": rw.Inertia(), "progress": False, "compiled": False,
        },
        "equilibrium": lambda: {
            "system": one_span(), "given": {"a_b.tension_b": 30e3}, "solve_for": "turn.mass",
            "parameters": {"a_b.mass_per_length": 2.5}, "start": None, "compiled": False, **cold,
        },
        "exact_load": lambda: {**LOADED, "joint": "clamped", "pull_slope": 0.0},
        "fit": lambda: {
            "system": rig(), "measured": pd.DataFrame({"station": STATIONS, "A": [110e3, 112e3]}),
            "columns": {"station": "station", "A": "headspar_tension"}, "free": ["payload"], "sigma": 500.0,
            "bounds": {"payload": (0.0, 9000.0)}, "prior": {"payload": (1000.0, 500.0)}, "loss": "huber",
        },
        "monitor": watched,
        "Monitor": watched,
        "fit_construction_stretch": lambda: {"safety_factors": [8.0, 5.0, 3.0], "elongations": [0.001, 0.002, 0.005]},
        "gravity_skyline": lambda: {"terrain": GROUND, **ends, "skyline": ROPE, "tension": 60e3, "length": None},
        "inhaul": lambda: {
            **payload, "start": 40.0, "end": 44.0, "speed": 3.0, "every": 0.5, "changes": (), "tolerance": 1e-7,
            "inertia": rw.Inertia(), "compiled": False,
        },
        "latin_hypercube": lambda: {"bounds": {"p": (1.0, 2.0)}, "samples": 5, "seed": 1},
        "lira_worksheet": lambda: {**LOADED, "carriage_weight": 900.0, "strain": ROPE.strain, "readings": None},
        "live_skyline": lambda: {"terrain": GROUND, **rig_parts()},
        "standing_skyline": lambda: {"terrain": GROUND, **rig_parts()},
        "running_skyline": lambda: {"terrain": GROUND, **ends, "haulback": ROPE, "tension": 60e3},
        "load_path": lambda: {**payload, "stations": STATIONS, "height": None, "compiled": False, **cold},
        "load_cases": lambda: {
            "of": one_span(), "cases": [rw.Environment("calm")], "loadings": ["full"], "safety_factor": 2.5,
            "payload": None, "stations": None,
        },
        "support_table": lambda: {
            "of": one_span(), "cases": [rw.Environment("calm")], "rollers": {"a": 2}, "payload": None, "stations": None,
        },
        "stringing_table": lambda: {
            "of": ROPE, "temperatures": [-20.0, 15.0], "span": 120.0, "rise": 4.0, "tension": 30e3, "length": None,
            "strung": 10.0, "gravity": 9.8,
        },
        "load": lambda: {"path": rw.save(one_span(), folder() / "one.json"), "components": []},
        "load_path_report": lambda: {
            "rig": rig(), "payload": 900.0, "frame": rw.load_path(rig(), 900.0, stations=[70.0]),
            "path": folder() / "path.html",
        },
        "longest_rope": lambda: {
            "stations": [0.0, 50.0, 120.0], "elevations": [0.0, -9.0, 2.0], "headspar": (0.0, 9.0),
            "tailspar": (120.0, 8.0), "clearance": 1.0,
        },
        "method_errors": lambda: {
            "rope": ROPE, "span": 190.0, "tension": 150e3, "slopes": [0.0, 0.1], "deflections": [0.1],
            "carriages": [0.5], "methods": ["rigid link"], "gravity": 9.8,
        },
        "monocable": lambda: {
            "rope": ROPE, "supports": supports(), "tension": 22e3, "speed": 0.8, "load_mass": [90.0, 0.0],
            "load_spacing": 33.0, "name": "line", "drive": drive(), "response": {"c": response()},
            "precedence": "all at once", "gravity": 9.8, "crs": None, "terrain": LOW_GROUND, "clearance": 1.0,
            "temperature": 5.0, "load_drag_area": 0.5,
        },
        "modes": lambda: {"eq": rest(), "nodes": 2, "count": 3, "damping": 1e-3},
        "objectives": lambda: {"result": run(), "settle": 1.0, "target": 3e4},
        "optimise_schedule": lambda: {
            "line": line_of_two(), "until": 6.0, "minimise": {"energy": 1.0}, "limits": rw.ScheduleLimits(),
            "intervals": 3, "lead": "c", "trim": response(), "warm_start": None, "compiled": False,
            **optional,
        },
        "receding_horizon": lambda: {
            "line": line_of_two(), "until": 6.0, "horizon": 6.0, "every": 3.0, "minimise": "energy",
            "limits": rw.ScheduleLimits(), "intervals": 4, "lead": "c", "compiled": False, **optional,
        },
        "optimise_supports": lambda: {
            "rig": rig(), "candidates": [rw.Candidate("tree", 110.0, (7.0,))], "payload": 500.0, "clearance": 0.5,
            "rope_clearance": 0.0, "safety_factor": 3.0, "stations": STATIONS, "most": 1, "compiled": False,
        },
        "payload": lambda: {
            "rig": rig(), "safety_factor": 3.0, "clearance": 0.5, "rope_clearance": 0.0, "stations": [150.0],
            "mainline_safety_factor": 3.0, "lift_off": True, **cold, "saddle_angle": (-0.2, 1.2), "roller_force": 60e3,
            "rollers": {"jack": 2}, "compiled": False,
        },
        "payload_for_tension": lambda: {
            "method": METHODS["rigid link"], "line": LOADED["line"], "rope": ROPE, "tension": 150e3,
            "carriage_mass": 140.0, "gravity": 9.8,
        },
        "tension_for_payload": lambda: {
            "method": METHODS["rigid link"], "line": LOADED["line"], "rope": ROPE, "payload": 2500.0,
            "carriage_mass": 140.0, "gravity": 9.8,
        },
        "carriages": dict,
        "compare": lambda: {"names": ["a", "b"], "safety_factor": 3.0, "clearance": None},
        "places": lambda: {"of": rig()},
        "export_gis": lambda: {
            "what": rig(), "path": folder() / "rig.kml", "stations": pd.DataFrame(POSITIONS), "view": "plan"
        },
        "ropes": dict,
        "yarders": dict,
        "run_study": lambda: {"inputs": rw.StudyInputs("equilibrium", one_span())},
        "save": lambda: {"value": one_span(), "path": folder() / "saved.json"},
        "sensitivities": lambda: {
            "solution": rig(), "of": "sag", "to": ["payload"], "payload": 500.0, "stations": [150.0], "height": None,
            "compiled": False,
        },
        "set_up": lambda: {
            "rig": live_rig(), "station": 150.0, "payload": 500.0, "tension": 60e3, "deflection": None,
            "compiled": False, **cold,
        },
        "tension_history": lambda: {"rig": new_rig(), "turns": [(150.0, 500.0)]},
        "simulate": lambda: {
            "system": line(), "until": 2.0, "every": 1.0, "inputs": {"c.speed": 0.6}, "start": None,
            "tolerance": 1e-5, "interventions": [rw.Intervention(1.0, "brake", "c")], "stop_at": (),
            "progress": False, "compiled": False, "inertia": None, **cold,
        },
        "solve_span": lambda: {
            "problem": rw.SpanProblem(120.0, 4.0, 123.0, 30.0, 3e7), "method": "Newton-Raphson",
            "start": (9e3, 2e3), "damped": True, "unknowns": "horizontal and vertical", "tolerance": 1e-9, "limit": 40,
        },
        "stretched_position": lambda: {**HANGING, "stations": 40.0},
        "unstretched_length": lambda: {**HANGING, "length": 150.0},
        "string_guylines": lambda: {"system": rw.System("yard"), "spar": guyed()},
        "support_range": lambda: {"start": 40.0, "end": 90.0, "spacing": 25.0, "heights": (6.0, 8.0)},
        "assured_payload": lambda: {
            "study": payloads, "inputs": rw.Uncertain({"tension": norm(60e3, 2e3)}), "confidence": 0.5, "samples": 2,
            "seed": 1, "workers": 1, "progress": False,
        },
        "exceedance": lambda: {
            "table": pd.DataFrame({"pull": [1.0, 2.0, 3.0]}), "above": {"pull": 2.5}, "below": None, "confidence": 0.9,
        },
        "reliability": lambda: {
            "study": one_span(), "inputs": rw.Uncertain({"turn.mass": norm(700.0, 50.0)}), "output": "a_b.tension_a",
            "above": 50e3, "below": None, "workers": 1,
        },
        "sobol_indices": lambda: {
            "study": one_span(), "inputs": rw.Uncertain({"turn.mass": norm(700.0, 50.0)}),
            "outputs": ["a_b.tension_a"], "samples": 4, "seed": 0, "workers": 1, "progress": False,
        },
        "sweep": lambda: {
            "study": one_span(), "parameters": {"turn.mass": [500.0, 600.0]}, "outputs": ["a_b.tension_a"],
            "workers": 1, "path": None, "progress": False, "compiled": False,
        },
        "tune_response": lambda: {
            "line": line(), "response": response(), "over": {"gain": (1e-6, 1e-5)}, "minimise": "energy",
            "until": 3.0, "every": 1.0, "sheaves": ["c"], "generations": 1, "population": 4, "seed": 0,
            "workers": 1, "compiled": False, **optional,
        },
        "twelve_cases": lambda: {"phi": [0.1, 0.2]},
        "write_table": lambda: {"table": pd.DataFrame({"x": [1.0]}), "path": folder() / "table.csv"},
        "fmu.CoSimulation": lambda: {
            "step": 0.5, "master": "Gauss-Seidel", "tolerance": 1e-8, "iterations": 30, "iterated": True,
            "control": None,
        },
        "fmu.Slave": lambda: {"fmu": fmu(), "name": "one", "kind": "CoSimulation", "tolerance": 1e-8},
        "fmu.component": lambda: {"name": "part", "fmu": exported(), "parameters": {}, "ignore_events": True},
        "fmu.export": lambda: {
            "system": one_span(), "path": folder() / "again.fmu", "fmi": "3.0", "inputs": None, "outputs": None,
            "parameters": None, "platforms": (), "tolerance": 1e-6, "station": None, "payload": None,
            "emergency_stop": None, "inertia": None,
        },
        "fmu.run_report": lambda: {
            "frame": pd.DataFrame({"a.x": [0.0, 1.0]}, index=pd.Index([0.0, 1.0], name="time")),
            "path": folder() / "fmu.html",
        },
        "fmu.load": lambda: {
            "path": exported(), "isolated": False, "timeout": 9.0, "limits": rw.fmu.ArchiveLimits(),
        },
    }  # fmt: skip
