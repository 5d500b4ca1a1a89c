"""A valid call of every public method that takes arguments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import norm

import ropeway as rw
from support.call_objects import (
    GROUND,
    MAP,
    ROPE,
    THIN,
    cases,
    corridor,
    exported,
    exported_line,
    fitted,
    fmu,
    folder,
    grounded,
    guyed,
    line,
    log,
    plan,
    rest,
    rig,
    run,
    shod_rig,
    speeds,
    watch,
)


class Call(NamedTuple):
    """A callable with valid arguments by name, without `self`."""

    function: Callable[..., Any]
    arguments: dict[str, Any]


def methods() -> dict[str, Callable[[], Call]]:
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

    def structure() -> Call:
        path = cosimulation("to_ssp", path=folder() / "read.ssp").function(folder() / "read.ssp")
        return Call(rw.fmu.CoSimulation.from_ssp, {"path": path, "step": 0.5, "isolated": False, "limits": None})

    def slave(name: str, /, **arguments: Any) -> Call:
        one = rw.fmu.Slave(fmu())
        if name != "enter":
            one.enter(0.0, {})
            one.leave()
        return Call(getattr(one, name), arguments)

    changes = pd.DataFrame(columns=["time", "variable", "value"])
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
        "Environment.is_calm": lambda: Call(rw.Environment("calm").is_calm, {"strung": 15.0}),
        "Equilibrium.__getitem__": lambda: Call(rest().__getitem__, {"name": "c.tension_in"}),
        "Equilibrium.points": lambda: Call(rest().points, {"r": 0}),
        "Equilibrium.profile": lambda: Call(rest().profile, {"span": "a_c", "stations": [0.0, 20.0]}),
        "GuyedSpar.block": lambda: Call(guyed().block, {"rope": "mainline"}),
        "GuyedSpar.guy": lambda: Call(guyed().guy, {"name": "g1"}),
        "Equilibrium.heights_over_ground": lambda: Call(grounded().heights_over_ground, {"points": 21}),
        "Fit.intervals": lambda: Call(fitted().intervals, {"confidence": 0.9}),
        "Fit.report": lambda: Call(fitted().report, {"path": folder() / "fit.html"}),
        "Monitor.follow": lambda: Call(watch().follow, {"rows": [{"t": 0.0, "A": 22e3}]}),
        "Monitor.update": lambda: Call(watch().update, {"row": {"t": 0.0, "A": 22e3}}),
        "Modes.plot": lambda: Call(rw.modes(rest(), 2, 3).plot, {"k": 2}),
        "MapFrame.straight": lambda: Call(
            rw.MapFrame.straight,
            {"crs": "EPSG:2056", "start": (2.6e6, 1.2e6), "end": (2.6001e6, 1.2e6), "heights": "LN02"},
        ),
        "MapFrame.through": lambda: Call(
            rw.MapFrame.through,
            {
                "crs": "EPSG:2056", "easting": np.array([2.6e6, 2.6001e6]), "northing": np.array([1.2e6, 1.2e6]),
                "heights": "",
            },
        ),
        "MapFrame.to_map": lambda: Call(MAP.to_map, {"x": 40.0, "y": 3.0}),
        "MapFrame.to_local": lambda: Call(MAP.to_local, {"easting": 2600140.0, "northing": 1200210.0}),
        "MapFrame.to_degrees": lambda: Call(MAP.to_degrees, {"x": 40.0, "y": 3.0}),
        "Profile.chord_slope": lambda: Call(GROUND.chord_slope, {"start": 0.0, "end": 90.0}),
        "Profile.clearance_of_line": lambda: Call(GROUND.clearance_of_line, {"points": [(0.0, 30.0), (90.0, 20.0)]}),
        "Profile.elevation_at": lambda: Call(GROUND.elevation_at, {"station": 40.0}),
        "Profile.elevations": lambda: Call(GROUND.elevations, {"stations": np.array([40.0, 50.0])}),
        "Profile.from_csv": lambda: Call(rw.Profile.from_csv, {"path": corridor()}),
        "Profile.from_dem": lambda: Call(
            rw.Profile.from_dem,
            {
                "path": folder() / "none.tif", "start": (0.0, 0.0), "end": (90.0, 0.0), "spacing": 5.0,
                "band": 1, "unit": "m", "nodata": None, "largest_jump": 3.0, "crs": "EPSG:2056",
            },
        ),
        "Profile.from_points": lambda: Call(
            rw.Profile.from_points,
            {"points": [[2.6e6, 1.2e6, 800.0], [2.6001e6, 1.2e6, 790.0]], "crs": "EPSG:2056", "straight": False},
        ),
        "Profile.resampled": lambda: Call(GROUND.resampled, {"spacing": 10.0}),
        "Profile.slope_at": lambda: Call(GROUND.slope_at, {"station": 40.0}),
        "Profile.vertex_at": lambda: Call(GROUND.vertex_at, {"station": 40.0}),
        "Result.at": lambda: Call(run().at, {"time": 1.5}),
        "Result.plot": lambda: Call(run().plot, {"components": ["c"]}),
        "Result.plot_line": lambda: Call(run().plot_line, {"time": 1.0, "ground": GROUND}),
        "Result.record": lambda: Call(run().record, {"i": 1}),
        "Inhaul.report": lambda: Call(
            rw.inhaul(rig(), payload=900.0, start=44.0, end=40.0).report, {"path": folder() / "inhaul.html"}
        ),
        "LoadCases.report": lambda: Call(cases().report, {"path": folder() / "cases.html"}),
        "PayloadStudy.report": lambda: Call(
            rw.payload(rig(), stations=[150.0]).report, {"path": folder() / "payload.html"}
        ),
        "Result.animate": lambda: Call(run().animate, {"path": folder() / "run.gif", "frames": 2, "rate": 10}),
        "SkylineRig.plot": lambda: Call(rig().plot, {"view": "elevation"}),
        "System.plot": lambda: Call(line().plot, {"view": "3d"}),
        "Result.report": lambda: Call(run().report, {"path": folder() / "run.html"}),
        "SchedulePlan.report": lambda: Call(plan().report, {"path": folder() / "plan.html"}),
        "Rope.from_construction": lambda: Call(
            rw.Rope.from_construction,
            {
                "construction": "6x19 IWRC", "diameter": 0.02, "grade": 1960.0, "modulus": 9e10,
                "stretch": rw.Elastic(), "safety_factor": 3.0,
            },
        ),
        "Rope.named": lambda: Call(
            rw.Rope.named,
            {"name": "6x19 EEIP 19", "stretch": rw.Elastic(), "safety_factor": 3.0, "catalogue": None},
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
        "SchedulePlan.objective_text": lambda: Call(plan().objective_text, {"name": "energy"}),
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
        "SkylineRig.in_weather": lambda: Call(
            rig().in_weather, {"environment": rw.Environment("cold", temperature=-9.0)}
        ),
        "System.add": lambda: Call(rw.System().add, {"component": rw.System("inner"), "name": "part"}),
        "System.connect": connecting,
        "System.feed": lambda: on_line("feed", spans=..., spacing=20.0, masses=[90.0, 0.0], drag_area=0.5),
        "System.in_weather": lambda: Call(line().in_weather, {"environment": rw.Environment("cold", temperature=-9.0)}),
        "System.hang": lambda: on_line("hang", load=rw.Load("turn", 90.0), spans=..., at=30.0),
        "System.origin": lambda: on_line("origin", name="a", text="at {}"),
        "System.string": lambda: Call(
            lambda one, other, **how: rw.System().string(how.pop("rope"), one, other, **how),
            {
                "rope": ROPE, "one": rw.Anchor("a", at=(0.0, 0.0)), "other": rw.Anchor("b", at=(60.0, 3.0)),
                "length": 62.0, "tension": None, "name": "main",
            },
        ),
        "Uncertain.cases": lambda: Call(
            rw.Uncertain({"a": norm(3.0, 1.0)}).cases, {"samples": 4, "method": "sobol", "seed": 3}
        ),
        "Uncertain.normal": lambda: Call(rw.Uncertain.normal, {"means": {"a": 3.0}, "covariance": [[2.0]]}),
        "Uncertain.values": lambda: Call(
            rw.Uncertain({"a": norm(3.0, 1.0)}).values, {"scores": np.array([[0.5], [1.0]])}
        ),
        "Turn.under": lambda: Call(
            rw.Turn(log(), dropline=THIN, length=6.0).under,
            {"x": 40.0, "y": 0.0, "z": 20.0, "mass": 600.0, "ground": GROUND},
        ),
        "fmu.CoSimulation.add": lambda: cosimulation(
            "add", name="span", participant=exported(), kind="CoSimulation", start={}, isolated=False,
            timeout=9.0, step=0.5,
        ),
        "fmu.CoSimulation.connect": lambda: cosimulation(
            "connect",
            source="span.a.tension",
            target="line.c.speed",
            factor=2.0,
            offset=0.5,
            convert_units=False,
            mapping=None,
        ),
        "fmu.CoSimulation.from_ssp": structure,
        "fmu.CoSimulation.to_ssp": lambda: cosimulation(
            "to_ssp", path=folder() / "yard.ssp", until=1.0, start_time=0.0, embed=False
        ),
        "fmu.CoSimulation.run": lambda: cosimulation(
            "run", until=1.0, start_time=0.0, inputs={}, progress=False, scenario=changes,
            outputs=["span.a.tension"], every=0.5, pace=100.0,
        ),
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
