"""A running skyline on the first span of the corridor: haulback and mainline carry the load together.

The haulback goes over the carriage to a tail block on the spur and back to the carriage; the yarder sets its tension so
that the turn just clears the ground.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

import ropeway as rw


def main(folder: Path = Path("ropeway-running")) -> rw.PayloadStudy:
    """Prints payloads and tensions by station, writes table and picture into `folder`."""
    line = rw.Rope(mass_per_length=1.4, axial_stiffness=14e6, breaking_load=256.3e3, name="6x19 EEIP 19")
    rig = rw.running_skyline(
        rw.Profile.from_csv(Path(__file__).parent / "corridor.csv"),
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        tailspar=rw.TailSpar("tail", station=260.0, height=9.0),
        haulback=line,
        mainline=line,
        tension=50e3,
        carriage=rw.Carriage("carriage", mass=600.0, depth=4.0),
    )
    study = rw.payload(rig, safety_factor=3.0, clearance=1.0, stations=np.arange(15.0, 250.0, 5.0))
    shown = ["station", "payload", "limited_by", "haulback_tension", "mainline_tension", "deflection"]
    print(study.frame[shown].iloc[::5].round(1).to_string(index=False))
    worst = study.limiting
    print(f"\nLargest payload {math.floor(study.payload)} kg, limited at {worst.station:.0f} m by {worst.limited_by}.")
    folder.mkdir(parents=True, exist_ok=True)
    study.to_csv(folder / "running.csv")
    study.plot().savefig(folder / "running.png", dpi=110)
    return study


if __name__ == "__main__":
    main(*(Path(a) for a in sys.argv[1:2]))
