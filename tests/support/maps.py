"""Lines and rigs on a map: the ground is a made profile, the coordinates are those of Swiss LV95 (EPSG:2056)."""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
MAINLINE = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)
START, END = (2600100.0, 1200200.0), (2600394.0, 1200592.0)
"""490 m on the map, azimuth atan(3/4)."""


def ground() -> rw.Profile:
    station = np.arange(0.0, 481.0, 4.0)
    frame = rw.MapFrame.straight("EPSG:2056", START, END)
    return rw.Profile(station, 846.0 - 0.27 * station + 9.0 * np.cos(station / 60.0), frame)


@cache
def rig() -> rw.SkylineRig:
    """A standing skyline between a guyed headspar and a tail tree with a tailhold beside the line."""
    guys = tuple(
        rw.Guyline(name, ROPE, at=(x, y, z), pretension=20e3)
        for name, x, y, z in (("g1", -22.0, 14.0, 857.0), ("g2", -22.0, -14.0, 857.0))
    )
    return rw.standing_skyline(
        ground(),
        headspar=rw.GuyedSpar("head", station=10.0, height=15.0, mass=900.0, guylines=guys),
        supports=[rw.IntermediateSupport("jack", station=250.0, height=11.0, label="Stütze 1")],
        tailspar=rw.TailSpar("tail", station=465.0, height=9.0, tailhold=rw.Tailhold("stump", at=(478.0, 6.0, 717.0))),
        skyline=ROPE,
        tension=80e3,
        mainline=MAINLINE,
        carriage=rw.Carriage("carriage", mass=350.0, depth=2.0),
    )


@cache
def path() -> pd.DataFrame:
    """A load path of the rig at three stations."""
    return rw.load_path(rig(), 1200.0, [90.0, 180.0, 350.0])


SUPPORTS = [
    ("valley", 0.0, 0.0, 866.0, "drum"),
    ("s1", 118.0, 6.0, 826.0, "idler"),
    ("c1", 221.0, -5.0, 800.0, "control"),
    ("s2", 345.0, 2.0, 782.0, "idler"),
    ("top", 460.0, 0.0, 739.0, "drum"),
]
"""Stations, offsets and heights of a line on the ground."""


def supports() -> pd.DataFrame:
    """Of a line, in map coordinates."""
    table = pd.DataFrame(SUPPORTS, columns=["name", "x", "y", "z", "kind"])
    table["easting"], table["northing"] = ground().map_frame.to_map(table["x"].to_numpy(), table["y"].to_numpy())
    return table.drop(columns=["x", "y"])


@cache
def line() -> rw.System:
    return rw.monocable(
        ROPE, supports(), tension=45e3, load_mass=180.0, load_spacing=45.0, crs="EPSG:2056", terrain=ground()
    )
