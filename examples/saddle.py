"""The carriage over an intermediate support: the pull of the mainline on a point saddle and on shoes.

The corridor of examples/standing_skyline.py, with a haulback that holds the lines taut; the carriage with 2500 kg from
2 m before the jack to 3 m beyond it.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import ropeway as rw

SPACING = 0.05
"""Distance between the stations of the carriage [m]."""


def rig(radius: float) -> rw.SkylineRig:
    """The skyline with a jack whose shoe has a radius [m]."""
    return rw.standing_skyline(
        rw.Profile.from_csv(Path(__file__).parent / "corridor.csv"),
        headspar=rw.HeadSpar("head", station=0.0, height=15.0),
        supports=[rw.IntermediateSupport("jack", station=260.0, height=9.0, radius=radius)],
        tailspar=rw.TailSpar("tail", station=480.0, height=8.0),
        skyline=rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3),
        tension=70e3,
        mainline=(line := rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)),
        haulback=line,
        haulback_tension=5e3,
        carriage=rw.Carriage("carriage", mass=450.0),
    )


def main(folder: Path = Path("ropeway-saddle")) -> pd.DataFrame:
    """Prints the steepest change of the pull, writes the pulls and a picture into `folder`."""
    stations = np.arange(258.0, 263.001, SPACING)
    pulls = pd.DataFrame({"station": stations})
    for radius in (0.0, 0.5, 1.5, 3.0):
        pulls[f"{radius:g} m"] = rw.load_path(rig(radius), 2500.0, stations)["mainline_pull"] / 1e3
    steepest = pulls.drop(columns="station").diff().abs().max() / SPACING
    print("Steepest change of the mainline's pull [kN/m], by the radius of the shoe:")
    print(steepest.round(1).to_string())
    folder.mkdir(parents=True, exist_ok=True)
    rw.write_table(pulls, folder / "saddle.csv")
    picture(pulls).savefig(folder / "saddle.png", dpi=110)
    return pulls


def picture(pulls: pd.DataFrame) -> Figure:
    """Pull over station, a line for each radius."""
    figure = Figure(figsize=(9.0, 4.5), layout="constrained")
    axis = figure.subplots()
    for column in pulls.columns[1:]:
        point = column == "0 m"
        label = "a point" if point else f"shoe of {column} radius"
        axis.plot(
            pulls["station"], pulls[column], color="0.3" if point else None, ls="--" if point else "-", label=label
        )
    axis.axvline(260.0, color="tab:brown", lw=1.0, alpha=0.5)
    axis.annotate("jack", (260.0, 0.0), xycoords=("data", "axes fraction"), xytext=(4, 4), textcoords="offset points")
    axis.set_title("Mainline pull as the carriage with 2500 kg passes the jack")
    axis.set_xlabel("station of the carriage [m]")
    axis.set_ylabel("pull [kN]")
    axis.set_ylim(bottom=0.0)
    axis.grid(alpha=0.3)
    axis.legend()
    return figure


if __name__ == "__main__":
    main(*(Path(a) for a in sys.argv[1:2]))
