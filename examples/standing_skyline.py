"""A standing skyline over one intermediate support: load path, payload by station, and their picture.

Uphill yarding on a corridor of 480 m: a yarder's spar of 15 m, a jack of 9 m on the spur at 260 m, a tail tree.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import ropeway as rw


def main(folder: Path = Path("ropeway-skyline")) -> rw.PayloadStudy:
    """Prints the load path and the payloads, writes the table and the picture into `folder`."""
    rig = rw.standing_skyline(
        rw.Profile.from_csv(Path(__file__).parent / "corridor.csv"),
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        supports=[rw.IntermediateSupport("jack", station=260.0, height=9.0)],
        tailspar=rw.TailSpar("tail", station=480.0, height=8.0),
        skyline=rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3),
        tension=70e3,
        mainline=rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3),
        carriage=rw.Carriage("carriage", mass=450.0, depth=3.0),
    )
    path = rw.load_path(rig, payload=2500.0, stations=[50, 100, 150, 200, 300, 350, 400, 450])
    shown = ["station", "carriage_z", "skyline_tension", "mainline_pull", "deflection", "clearance", "jack_force"]
    print("Load path with 2500 kg:")
    print(path[shown].round(1).to_string(index=False))

    study = rw.payload(rig, safety_factor=3.0, clearance=1.0)
    worst = study.limiting
    print(f"\nLargest payload {math.floor(study.payload)} kg, limited at {worst.station:.0f} m by {worst.limited_by}.")
    folder.mkdir(parents=True, exist_ok=True)
    study.to_csv(folder / "payload.csv")
    study.plot().savefig(folder / "payload.png", dpi=110)
    return study


if __name__ == "__main__":
    main(*(Path(a) for a in sys.argv[1:2]))
