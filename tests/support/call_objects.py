"""Objects that valid calls of public callables take: ropes, lines, rigs, results, FMUs."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pandas as pd

import ropeway as rw
from support.drives import hydraulic_drive

ROPE = rw.Rope(mass_per_length=2.4, axial_stiffness=24e6, breaking_load=450e3, diameter=0.0254)
THIN = rw.Rope(mass_per_length=0.9, axial_stiffness=9e6, breaking_load=140e3)
MAP = rw.MapFrame.straight("EPSG:2056", (2600100.0, 1200200.0), (2600260.0, 1200320.0))
GROUND = rw.Profile([-20.0, 60.0, 130.0, 260.0], [14.0, 0.0, -6.0, -34.0], MAP)
HEAD = rw.HeadSpar("head", station=0.0, height=14.0)
TAIL = rw.TailSpar("tail", station=240.0, height=9.0)
CARRIAGE = rw.Carriage("carriage", mass=320.0)
STATIONS = [70.0, 150.0]
LOW_GROUND = rw.Profile([-20.0, 260.0], [-9.0, -6.0], MAP)
POSITIONS = {"carriage_x": [70.0, 150.0], "carriage_y": [0.0, 0.0], "carriage_z": [9.0, -2.0], "clearance": [8.0, 7.0]}
"""Of a rig's carriage."""


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
    return hydraulic_drive(displacement=1e-4, sheave_radius=0.4, pump_flow=2e-3, engine_power=3e4, inertia=400.0)


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


def cases() -> rw.LoadCases:
    return rw.load_cases(one_span(), [rw.Environment("calm"), rw.Environment("cold", temperature=-20.0)])


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
        "temperature": 5.0,
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
def grounded() -> rw.Equilibrium:
    """A line over its ground."""
    return rw.equilibrium(rw.monocable(ROPE, supports(), tension=22e3, terrain=LOW_GROUND))


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


def payloads(tension: float) -> rw.PayloadStudy:
    """Payloads of a corridor whose skyline has an uncertain tension."""
    parts = {k: v for k, v in rig_parts().items() if v is not None} | {"tension": tension}
    return rw.payload(rw.standing_skyline(GROUND, **parts), stations=STATIONS)


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


@cache
def fitted() -> rw.Fit:
    """A payload by two tensions."""
    table = pd.DataFrame({"station": STATIONS, "A": [110e3, 112e3]})
    columns = {"station": "station", "A": "headspar_tension"}
    return rw.fit(rig(), table, columns=columns, free="payload", sigma=500.0)


def watch() -> rw.Monitor:
    """A monitor of a line, before its first row."""
    return rw.monitor(line(), columns={"t": "time", "A": "c.tension_in"}, free="*.mass", sigma=100.0)


def guyed() -> rw.GuyedSpar:
    guys = tuple(
        rw.Guyline(f"g{k}", rope=THIN, at=(-14.0, 28.0 * k - 14.0, 0.0), pretension=9e3, stiffness=1e6)
        for k in range(2)
    )
    return rw.GuyedSpar("mast", height=12.0, foot=(0.0, 0.0), mass=800.0, guylines=guys, blocks=("mainline",))


def log() -> rw.Log:
    return rw.Log("log", mass=900.0, length=7.0)
