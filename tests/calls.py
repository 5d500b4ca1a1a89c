"""A valid call of every public callable, for campaigns that spoil one argument at a time."""

from __future__ import annotations

import inspect
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

import ropeway as rw
from ropeway.components.component import Component, Node
from ropeway.components.response import Response
from ropeway.systems.studies.payload_methods import METHODS

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450e3, diameter=0.0254)
THIN = rw.Rope(mass_per_length=0.9, axial_stiffness=9e6, breaking_load=140e3)
GROUND = rw.Profile([-20.0, 60.0, 130.0, 260.0], [14.0, 0.0, -6.0, -34.0])
HEAD = rw.HeadSpar("head", station=0.0, height=14.0)
TAIL = rw.TailSpar("tail", station=240.0, height=9.0)
CARRIAGE = rw.Carriage("carriage", mass=320.0)
STATIONS = [70.0, 150.0]


class Call(NamedTuple):
    """A callable with arguments that it takes, by name; those of `self` are left alone."""

    function: Callable[..., Any]
    arguments: dict[str, Any]


def supports() -> pd.DataFrame:
    """A line of two spans over a control sheave, drum to drum."""
    rows = [("a", 0.0, 0.0, 8.0, "drum"), ("c", 90.0, 0.0, 12.0, "control"), ("b", 185.0, 0.0, 9.0, "drum")]
    return pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])


def endless_supports() -> pd.DataFrame:
    """An endless line of four spans."""
    rows = [
        ("w", 0.0, 0.0, 8.0, "control"),
        ("s", 90.0, 4.0, 12.0, "idler"),
        ("r", 180.0, 0.0, 9.0, "return"),
        ("t", 90.0, -4.0, 12.0, "idler"),
    ]
    return pd.DataFrame(rows, columns=["name", "x", "y", "z", "kind"])


def drive() -> rw.HydraulicDrive:
    return rw.HydraulicDrive(
        displacement=1e-4,
        gear_ratio=20.0,
        sheave_radius=0.4,
        relief_pressure=2.5e7,
        pump_flow=2e-3,
        engine_power=3e4,
        inertia=400.0,
    )


def response() -> rw.ProportionalResponse:
    return rw.ProportionalResponse(gain=1e-5, limit=0.1)


def line() -> rw.System:
    """A line of its own for each call."""
    return rw.monocable(ROPE, supports(), tension=22e3, speed=0.8, load_mass=90.0, load_spacing=33.0)


def one_span() -> rw.System:
    s = rw.System("one span")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 5.0)), rw.Anchor("b", at=(120.0, 9.0)), length=121.5)
    s.hang(rw.Load("turn", mass=700.0), span, at=40.0)
    return s


def rig_parts() -> dict[str, Any]:
    return {
        "headspar": HEAD,
        "tailspar": TAIL,
        "skyline": ROPE,
        "tension": 60e3,
        "mainline": THIN,
        "carriage": CARRIAGE,
        "supports": [rw.IntermediateSupport("jack", station=125.0, height=8.0)],
        "haulback": None,
        "haulback_tension": None,
        "haulback_block": None,
        "holding": "bisector",
        "turn": None,
        "name": "rig",
        "gravity": 9.81,
        "length": None,
    }


@cache
def rig() -> rw.SkylineRig:
    return rw.standing_skyline(GROUND, **{k: v for k, v in rig_parts().items() if v is not None})


@cache
def shod_rig() -> rw.SkylineRig:
    parts = {k: v for k, v in rig_parts().items() if v is not None}
    parts["supports"] = [rw.IntermediateSupport("jack", station=125.0, height=8.0, radius=3.0)]
    return rw.standing_skyline(GROUND, **parts)


@cache
def live_rig() -> rw.SkylineRig:
    return rw.live_skyline(GROUND, headspar=HEAD, tailspar=TAIL, skyline=ROPE, tension=60e3, carriage=CARRIAGE)


@cache
def new_rig() -> rw.SkylineRig:
    """A rig whose skyline still has its construction stretch."""
    rope = replace(ROPE, stretch=rw.ConstructionStretch())
    return rw.live_skyline(GROUND, headspar=HEAD, tailspar=TAIL, skyline=rope, tension=60e3, carriage=CARRIAGE)


@cache
def rest() -> rw.Equilibrium:
    return rw.equilibrium(line())


@cache
def run() -> rw.Result:
    return rw.simulate(line(), 4.0, every=0.5)


@cache
def plan() -> rw.SchedulePlan:
    return rw.optimise_schedule(line_of_two(), 6.0, intervals=3, settle=1.0)


def line_of_two() -> rw.System:
    """A line whose second control sheave can be planned."""
    table = supports()
    table.loc[2.0] = ("d", 185.0, 0.0, 9.0, "control")
    table.loc[3.0] = ("e", 270.0, 0.0, 6.0, "drum")
    return rw.monocable(ROPE, table.drop_duplicates("x"), tension=22e3, load_mass=90.0, load_spacing=33.0)


@cache
def folder() -> Path:
    return Path(tempfile.mkdtemp())


@cache
def corridor() -> Path:
    path = folder() / "corridor.csv"
    path.write_text("station,elevation\n0,4\n60,1\n130,-9\n")
    return path


@cache
def speeds() -> Path:
    return rw.Schedule([0.0, 4.0], [0.5, 1.0]).to_csv(folder() / "speeds.csv")


@cache
def exported() -> Path:
    return rw.fmu.export(one_span(), folder() / "span.fmu")


@cache
def exported_line() -> Path:
    return rw.fmu.export(line(), folder() / "line.fmu")


@cache
def fmu() -> rw.fmu.Fmu:
    return rw.fmu.load(exported())


def guyed() -> rw.GuyedSpar:
    guys = tuple(
        rw.Guyline(f"g{k}", rope=THIN, at=(-14.0, 28.0 * k - 14.0, 0.0), pretension=9e3, stiffness=1e6)
        for k in range(2)
    )
    return rw.GuyedSpar("mast", height=12.0, foot=(0.0, 0.0), mass=800.0, guylines=guys, blocks=("mainline",))


def log() -> rw.Log:
    return rw.Log("log", mass=900.0, length=7.0)


LOADED = {"line": rw.LoadedSpan(180.0, 20.0, 0.1, 0.4), "weight": 23.5, "tension": 140e3}
CURVE = {"span": 120.0, "rise": -8.0}
HANGING = {"rope": ROPE, "horizontal": 40e3, "vertical": 9e3, "method": "elastic", "gravity": 9.8}


def _instances() -> dict[str, Callable[[], Any]]:
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
        "ConstructionStretch": lambda: rw.ConstructionStretch(0.03),
        "ControlSheave": lambda: rw.ControlSheave("c", drive=drive(), response=response(), **at),
        "DieselHydraulicUnit": lambda: rw.DieselHydraulicUnit(
            "unit", rated_power=9e4, rated_speed=230.0, inertia=4.0, displacement=1e-4, relief_pressure=3e7
        ),
        "Disturbance": lambda: rw.Disturbance("heavy", mass=1.1),
        "Drum": lambda: rw.Drum("drum", speed=0.5, **at),
        "Elastic": rw.Elastic,
        "Equilibrium": rest,
        "GuyedSpar": guyed,
        "Guyline": lambda: guyed().guylines[0],
        "HeadSpar": lambda: HEAD,
        "HydraulicDrive": drive,
        "HydraulicPowerUnit": lambda: rw.HydraulicPowerUnit("unit", pump_flow=2e-3, engine_power=3e4),
        "IdealDrive": rw.IdealDrive,
        "Inhaul": lambda: rw.Inhaul(rig(), pd.DataFrame({"x": [1.0]}), pd.DataFrame({"x": [1.0]})),
        "IntermediateSupport": lambda: rw.IntermediateSupport("jack", station=125.0, height=8.0),
        "Intervention": lambda: rw.Intervention(1.0, "brake", "c"),
        "Load": lambda: rw.Load("turn", 500.0),
        "LoadedSpan": lambda: rw.LoadedSpan(180.0, 20.0, 0.1, 0.4),
        "Log": log,
        "Model": lambda: rest().model,
        "PayloadStudy": lambda: rw.PayloadStudy(rig(), pd.DataFrame({"x": [1.0]}), 3.0, 3.0, 1.0),
        "ProportionalResponse": response,
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
        "SupportPlan": lambda: rw.SupportPlan(rig(), (), True, "", 80.0, 3),
        "TailSpar": lambda: TAIL,
        "Tailhold": lambda: rw.Tailhold("hold", at=(3.0, 4.0)),
        "TensionedReturn": lambda: rw.TensionedReturn("r", take_up=2e4, **at),
        "ThresholdResponse": lambda: rw.ThresholdResponse(low=1e4, high=3e4, increment=0.01),
        "TunedResponse": lambda: rw.TunedResponse(line(), response(), "all at once", 1.0, 2.0, pd.DataFrame()),
        "Turn": lambda: rw.Turn(log(), dropline=THIN, length=6.0),
        "UnstretchedLength": lambda: rw.unstretched_length(length=150.0, **HANGING),
        "fmu.Fmu": fmu,
        "fmu.FmuComponent": lambda: rw.fmu.component("part", exported(), ignore_events=True),
        "fmu.StepControl": lambda: rw.fmu.StepControl("Richardson"),
    }


def _functions() -> dict[str, Callable[[], dict[str, Any]]]:
    """Arguments of every public function, and of the constructors that are not their fields."""
    payload = {"rig": rig(), "payload": 900.0}
    optional = {"target": 3e4, "settle": 1.0, "start": None, "progress": False}
    ends = {"headspar": HEAD, "tailspar": TAIL, "mainline": THIN, "carriage": CARRIAGE, "name": "rig", "gravity": 9.81}
    return {
        "Profile": lambda: {"station": [0.0, 50.0, 120.0], "elevation": [3.0, 5.0, -4.0]},
        "Schedule": lambda: {"times": [0.0, 4.0], "speeds": [0.5, 1.0]},
        "System": lambda: {"name": "line", "gravity": 9.8, "precedence": "worst first"},
        "assemble": lambda: {"system": one_span(), "slots": None},
        "balanced": lambda: {"line": line()},
        "catenary_for_horizontal": lambda: {**CURVE, "horizontal": 30e3, "weight": 30.0},
        "catenary_for_length": lambda: {**CURVE, "length": 123.0},
        "catenary_for_sag": lambda: {**CURVE, "sag": 4.0, "at": 0.4},
        "catenary_for_tension": lambda: {**CURVE, "tension": 30e3, "weight": 30.0},
        "compare_payload_methods": lambda: {
            "span": 190.0, "deflection": 22.0, "chord_slopes": (0.0, 0.15), "rope": ROPE, "tension": 150e3,
            "carriage_mass": 140.0, "carriage": 0.5, "as_printed": False, "gravity": 9.8,
        },
        "elastic_load": lambda: {**LOADED, "strain": ROPE.strain, "joint": "rolling", "pull_slope": 0.1},
        "endless": lambda: {
            "rope": ROPE, "supports": endless_supports(), "tension": 22e3, "speed": 0.9, "load_mass": 90.0,
            "load_spacing": 40.0, "take_up": None, "drive": None, "name": "ring", "gravity": 9.8,
        },
        "equilibrium": lambda: {
            "system": one_span(), "given": {"a_b.tension_b": 30e3}, "solve_for": "turn.mass",
            "parameters": {"a_b.mass_per_length": 2.5}, "start": None,
        },
        "exact_load": lambda: {**LOADED, "joint": "clamped", "pull_slope": 0.0},
        "fit_construction_stretch": lambda: {"safety_factors": [8.0, 5.0, 3.0], "elongations": [0.001, 0.002, 0.005]},
        "gravity_skyline": lambda: {"terrain": GROUND, **ends, "skyline": ROPE, "tension": 60e3, "length": None},
        "inhaul": lambda: {
            **payload, "start": 40.0, "end": 44.0, "speed": 3.0, "every": 0.5, "changes": (), "tolerance": 1e-7,
        },
        "latin_hypercube": lambda: {"bounds": {"p": (1.0, 2.0)}, "samples": 5, "seed": 1},
        "lira_worksheet": lambda: {**LOADED, "carriage_weight": 900.0, "strain": ROPE.strain, "readings": None},
        "live_skyline": lambda: {"terrain": GROUND, **rig_parts()},
        "standing_skyline": lambda: {"terrain": GROUND, **rig_parts()},
        "running_skyline": lambda: {"terrain": GROUND, **ends, "haulback": ROPE, "tension": 60e3},
        "load_path": lambda: {**payload, "stations": STATIONS, "height": None},
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
            "precedence": "all at once", "gravity": 9.8,
        },
        "objectives": lambda: {"result": run(), "settle": 1.0, "target": 3e4},
        "optimise_schedule": lambda: {
            "line": line_of_two(), "until": 6.0, "minimise": {"energy": 1.0}, "limits": rw.ScheduleLimits(),
            "intervals": 3, "lead": "c", "trim": response(), "warm_start": None, **optional,
        },
        "receding_horizon": lambda: {
            "line": line_of_two(), "until": 6.0, "horizon": 6.0, "every": 3.0, "minimise": "energy",
            "limits": rw.ScheduleLimits(), "intervals": 4, "lead": "c", **optional,
        },
        "optimise_supports": lambda: {
            "rig": rig(), "candidates": [rw.Candidate("tree", 110.0, (7.0,))], "payload": 500.0, "clearance": 0.5,
            "rope_clearance": 0.0, "safety_factor": 3.0, "stations": STATIONS, "most": 1,
        },
        "payload": lambda: {
            "rig": rig(), "safety_factor": 3.0, "clearance": 0.5, "rope_clearance": 0.0, "stations": [150.0],
            "mainline_safety_factor": 3.0, "lift_off": True,
        },
        "payload_for_tension": lambda: {
            "method": METHODS["rigid link"], "line": LOADED["line"], "rope": ROPE, "tension": 150e3,
            "carriage_mass": 140.0, "gravity": 9.8,
        },
        "tension_for_payload": lambda: {
            "method": METHODS["rigid link"], "line": LOADED["line"], "rope": ROPE, "payload": 2500.0,
            "carriage_mass": 140.0, "gravity": 9.8,
        },
        "ropes": dict,
        "sensitivities": lambda: {"solution": rest(), "of": "c.tension_in", "to": ["a_c.mass_per_length"]},
        "set_up": lambda: {"rig": live_rig(), "station": 150.0, "payload": 500.0, "tension": 60e3, "deflection": None},
        "tension_history": lambda: {"rig": new_rig(), "turns": [(150.0, 500.0)]},
        "simulate": lambda: {
            "system": line(), "until": 2.0, "every": 1.0, "inputs": {"c.speed": 0.6}, "start": None,
            "tolerance": 1e-5, "interventions": [rw.Intervention(1.0, "brake", "c")], "stop_at": (),
            "progress": False,
        },
        "solve_span": lambda: {
            "problem": rw.SpanProblem(120.0, 4.0, 123.0, 30.0, 3e7), "method": "Newton-Raphson",
            "start": (9e3, 2e3), "damped": True, "unknowns": "horizontal and vertical", "tolerance": 1e-9, "limit": 40,
        },
        "stretched_position": lambda: {**HANGING, "stations": 40.0},
        "unstretched_length": lambda: {**HANGING, "length": 150.0},
        "string_guylines": lambda: {"system": rw.System("yard"), "spar": guyed()},
        "support_range": lambda: {"start": 40.0, "end": 90.0, "spacing": 25.0, "heights": (6.0, 8.0)},
        "sweep": lambda: {
            "study": one_span(), "parameters": {"turn.mass": [500.0, 600.0]}, "outputs": ["a_b.tension_a"],
            "workers": 1, "path": None, "progress": False,
        },
        "tune_response": lambda: {
            "line": line(), "response": response(), "over": {"gain": (1e-6, 1e-5)}, "minimise": "energy",
            "until": 3.0, "every": 1.0, "sheaves": ["c"], "generations": 1, "population": 4, "seed": 0,
            "workers": 1, **optional,
        },
        "twelve_cases": lambda: {"phi": [0.1, 0.2]},
        "fmu.CoSimulation": lambda: {
            "step": 0.5, "master": "Gauss-Seidel", "tolerance": 1e-8, "iterations": 30, "iterated": True,
            "control": None,
        },
        "fmu.Slave": lambda: {"fmu": fmu(), "name": "one", "kind": "CoSimulation", "tolerance": 1e-8},
        "fmu.component": lambda: {"name": "part", "fmu": exported(), "parameters": {}, "ignore_events": True},
        "fmu.export": lambda: {
            "system": one_span(), "path": folder() / "again.fmu", "fmi": "3.0", "inputs": None, "outputs": None,
            "parameters": None, "platforms": (), "tolerance": 1e-6, "station": None, "payload": None,
        },
        "fmu.load": lambda: {"path": exported()},
    }  # fmt: skip


def _methods() -> dict[str, Callable[[], Call]]:
    """A call of every method that takes arguments."""

    def strung() -> tuple[rw.System, tuple[rw.Span, ...]]:
        s = rw.System("line")
        nodes = rw.Anchor("a", at=(0.0, 0.0)), rw.Sheave("m", at=(60.0, 3.0)), rw.Anchor("b", at=(110.0, 0.0))
        return s, s.string(ROPE, *nodes, length=112.0)

    def on_line(name: str, /, **arguments: Any) -> Call:
        s, spans = strung()
        given = {key: spans if value is ... else value for key, value in arguments.items()}
        return Call(getattr(s, name), given)

    def connecting() -> Call:
        s = rw.System("line")
        span, anchor = s.add(rw.Span("x_y", rope=ROPE, length=90.0)), s.add(rw.Anchor("x", at=(0.0, 0.0)))
        return Call(s.connect, {"one": span.a, "other": anchor.rope})

    def cosimulation(name: str, /, **arguments: Any) -> Call:
        master = rw.fmu.CoSimulation(step=0.5)
        if name != "add":
            master.add("span", exported())
            master.add("line", exported_line())
        return Call(getattr(master, name), arguments)

    def slave(name: str, /, **arguments: Any) -> Call:
        one = rw.fmu.Slave(fmu())
        if name != "enter":
            one.enter(0.0, {})
            one.leave()
        return Call(getattr(one, name), arguments)

    schedule, curve = rw.Schedule([0.0, 4.0], [0.5, 1.0]), rw.CatenaryCurve(120.0, -8.0, 900.0)
    problem = rw.SpanProblem(120.0, 4.0, 123.0, 30.0, 3e7)
    stretch = {"axial_stiffness": 24e6, "breaking_load": 450e3}
    return {
        "Candidate.support": lambda: Call(rw.Candidate("tree", 80.0, (6.0,)).support, {"height": 6.0}),
        **{
            f"CatenaryCurve.{name}": lambda name=name, key=key: Call(getattr(curve, name), {key: 0.3})
            for name, key in (("forces", "weight"), ("height", "x"), ("sag", "x"), ("slope", "x"), ("station", "slope"))
        },
        "ConstructionStretch.strain": lambda: Call(rw.ConstructionStretch().strain, dict(stretch)),
        "Elastic.strain": lambda: Call(rw.Elastic().strain, dict(stretch)),
        "Component.output": lambda: Call(rw.Sheave("s", at=(0.0, 0.0)).output, {"name": "wrap"}),
        "Component.input": lambda: Call(rw.Drum("d", at=(0.0, 0.0)).input, {"name": "speed"}),
        "Disturbance.schedules": lambda: Call(
            rw.Disturbance("late", sheave="c", delay=1.0).schedules, {"planned": {"c": schedule}}
        ),
        "Disturbance.start": lambda: Call(rw.Disturbance("heavy", mass=1.1).start, {"planned": rest()}),
        "Equilibrium.__getitem__": lambda: Call(rest().__getitem__, {"name": "c.tension_in"}),
        "Equilibrium.points": lambda: Call(rest().points, {"r": 0}),
        "Equilibrium.profile": lambda: Call(rest().profile, {"span": "a_c", "stations": [0.0, 20.0]}),
        "GuyedSpar.block": lambda: Call(guyed().block, {"rope": "mainline"}),
        "GuyedSpar.guy": lambda: Call(guyed().guy, {"name": "g1"}),
        "Profile.chord_slope": lambda: Call(GROUND.chord_slope, {"start": 0.0, "end": 90.0}),
        "Profile.clearance_of_line": lambda: Call(GROUND.clearance_of_line, {"points": [(0.0, 30.0), (90.0, 20.0)]}),
        "Profile.elevation_at": lambda: Call(GROUND.elevation_at, {"station": 40.0}),
        "Profile.elevations": lambda: Call(GROUND.elevations, {"stations": np.array([40.0, 50.0])}),
        "Profile.from_csv": lambda: Call(rw.Profile.from_csv, {"path": corridor()}),
        "Profile.from_dem": lambda: Call(
            rw.Profile.from_dem,
            {
                "path": folder() / "none.tif", "start": (0.0, 0.0), "end": (90.0, 0.0), "spacing": 5.0,
                "band": 1, "unit": "m", "nodata": None, "largest_jump": 3.0,
            },
        ),
        "Profile.resampled": lambda: Call(GROUND.resampled, {"spacing": 10.0}),
        "Profile.slope_at": lambda: Call(GROUND.slope_at, {"station": 40.0}),
        "Profile.vertex_at": lambda: Call(GROUND.vertex_at, {"station": 40.0}),
        "Result.at": lambda: Call(run().at, {"time": 1.5}),
        "Result.plot": lambda: Call(run().plot, {"components": ["c"]}),
        "Result.plot_line": lambda: Call(run().plot_line, {"time": 1.0, "ground": GROUND}),
        "Result.record": lambda: Call(run().record, {"i": 1}),
        "Result.to_csv": lambda: Call(run().to_csv, {"path": folder() / "run.csv"}),
        "Result.to_parquet": lambda: Call(run().to_parquet, {"path": folder() / "run.parquet"}),
        "Rope.from_construction": lambda: Call(
            rw.Rope.from_construction,
            {
                "construction": "6x19 IWRC", "diameter": 0.02, "grade": 1960.0, "modulus": 9e10,
                "stretch": rw.Elastic(), "safety_factor": 3.0,
            },
        ),
        "Rope.named": lambda: Call(
            rw.Rope.named, {"name": "6x19 EEIP 19", "stretch": rw.Elastic(), "safety_factor": 3.0}
        ),
        "Schedule.at": lambda: Call(schedule.at, {"time": 1.0}),
        "Schedule.from_csv": lambda: Call(rw.Schedule.from_csv, {"path": speeds(), "column": "speed"}),
        "Schedule.later": lambda: Call(schedule.later, {"by": 1.0, "until": 4.0}),
        "Schedule.on": lambda: Call(schedule.on, {"times": [0.0, 1.0]}),
        "Schedule.require": lambda: Call(schedule.require, {"time": 1.0}),
        "Schedule.to_csv": lambda: Call(schedule.to_csv, {"path": folder() / "speeds.csv"}),
        "SchedulePlan.at": lambda: Call(plan().at, {"time": 1.0}),
        "SchedulePlan.robustness": lambda: Call(
            plan().robustness, {"disturbances": [rw.Disturbance("heavy", mass=1.02)], "settle": 1.0}
        ),
        "SchedulePlan.told": lambda: Call(plan().told, {"name": "energy"}),
        "SchedulePlan.to_csv": lambda: Call(plan().to_csv, {"path": folder() / "plan.csv"}),
        "SkylineRig.chord": lambda: Call(rig().chord, {"span": 0, "station": 70.0}),
        "SkylineRig.on_shoe_start": lambda: Call(
            shod_rig().on_shoe_start, {"on": 0, "station": 125.0, "payload": 500.0}
        ),
        "SkylineRig.shoe_near": lambda: Call(rig().shoe_near, {"station": 125.0}),
        "SkylineRig.span_of": lambda: Call(rig().span_of, {"station": 70.0}),
        "SkylineRig.start": lambda: Call(rig().start, {"span": 0, "station": 70.0, "payload": 500.0, "height": None}),
        "SkylineRig.system": lambda: Call(
            rig().system, {"span": 0, "station": 70.0, "payload": 500.0, "on": None, "rollers": None}
        ),
        "SpanProblem.reach": lambda: Call(problem.reach, {"horizontal": 9e3, "vertical": 2e3}),
        "SpanProblem.stretched": lambda: Call(problem.stretched, {"horizontal": 9e3, "vertical": 2e3}),
        "System.add": lambda: Call(rw.System().add, {"component": rw.Sheave("s", at=(0.0, 0.0))}),
        "System.connect": connecting,
        "System.feed": lambda: on_line("feed", spans=..., spacing=20.0, masses=[90.0, 0.0]),
        "System.hang": lambda: on_line("hang", load=rw.Load("turn", 90.0), spans=..., at=30.0),
        "System.origin": lambda: on_line("origin", name="a", text="at {}"),
        "System.string": lambda: Call(
            lambda one, other, **how: rw.System().string(how.pop("rope"), one, other, **how),
            {
                "rope": ROPE, "one": rw.Anchor("a", at=(0.0, 0.0)), "other": rw.Anchor("b", at=(60.0, 3.0)),
                "length": 62.0, "tension": None, "name": "main",
            },
        ),
        "Turn.under": lambda: Call(
            rw.Turn(log(), dropline=THIN, length=6.0).under,
            {"x": 40.0, "y": 0.0, "z": 20.0, "mass": 600.0, "ground": GROUND},
        ),
        "fmu.CoSimulation.add": lambda: cosimulation(
            "add", name="span", participant=exported(), kind="CoSimulation", start={}
        ),
        "fmu.CoSimulation.connect": lambda: cosimulation("connect", source="span.a.tension", target="line.c.speed"),
        "fmu.CoSimulation.run": lambda: cosimulation("run", until=1.0, start_time=0.0, inputs={}, progress=False),
        "fmu.Fmu.names": lambda: Call(fmu().names, {"causality": "output"}),
        "fmu.Fmu.variable": lambda: Call(fmu().variable, {"name": "a.tension"}),
        "fmu.Fmu.entry": lambda: Call(fmu().entry, {"name": "a.tension"}),
        "fmu.Fmu.values": lambda: Call(fmu().values, {"given": {"turn.mass": 700.0}}),
        "fmu.Fmu.shaped": lambda: Call(fmu().shaped, {"structure": {}}),
        "fmu.Slave.read": lambda: slave("read", names=["a.tension"]),
        "fmu.Slave.derivatives": lambda: slave("derivatives", outputs=["a.tension"], inputs={"turn.mass": 700.0}),
        "fmu.Slave.enter": lambda: slave("enter", start=0.0, values={}, stop=2.0),
        "fmu.Slave.get": lambda: slave("get", names=["a.tension"]),
        "fmu.Slave.set": lambda: slave("set", values={}),
        "fmu.Slave.step": lambda: slave("step", size=0.5, start={}, end={}),
    }  # fmt: skip


@cache
def calls() -> Mapping[str, Callable[[], Call]]:
    """A valid call by name; each is made anew, as a call may change what it is given."""
    table = dict(_methods())
    for name, make in _instances().items():
        table[name] = lambda make=make: Call(type(make()), _fields(make()))
    for name, arguments in _functions().items():
        table[name] = lambda name=name, arguments=arguments: Call(public(name), arguments())
    return table


def public(name: str) -> Any:
    """A public name's object."""
    return getattr(rw.fmu, name[4:]) if name.startswith("fmu.") else getattr(rw, name)


def _fields(thing: Any) -> dict[str, Any]:
    return {f.name: getattr(thing, f.name) for f in fields(thing) if f.init}


def public_names() -> list[str]:
    """All names of the root and of `rw.fmu` that can be called, without the errors."""
    names = [*rw.__all__, *(f"fmu.{name}" for name in rw.fmu.__all__)]
    return [n for n in names if not (isinstance(public(n), type) and issubclass(public(n), BaseException))]


PROTOCOL = {name for base in (Component, Node, Response) for name in vars(base)} - {"output", "input"}
"""Methods that the library calls on components, with its own objects."""
INSIDE = {
    "wheel_equations", "wheel_outputs", "line_outputs", "total", "placed", "require_above", "own_variables", "demand",
    "motion", "block_out", "driver", "outputs", "clearance", "travels", "forget", "restore",
}  # fmt: skip
"""Methods that take the library's own intermediate objects."""


def public_methods() -> Iterator[str]:
    """All methods of public classes that take arguments from a user."""
    for name in public_names():
        kind = public(name)
        if not isinstance(kind, type):
            continue
        for method, raw in vars(kind).items():
            function = getattr(raw, "__func__", raw)
            hidden = method.startswith("_") and method != "__getitem__"
            if hidden or method in PROTOCOL | INSIDE or not inspect.isfunction(function):
                continue
            if len(inspect.signature(function).parameters) > (not isinstance(raw, staticmethod)):
                yield f"{name}.{method}"
