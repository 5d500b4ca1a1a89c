"""A guyed spar under a skyline: how much the skyline's tension falls as the spar leans into it.

Four guylines at 5, 20 and 50 kN of pretension, on rigid anchors and on stumps that give 0.5 mm per kN.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

import ropeway as rw

ANCHORS = {"guy1": (-22.0, -13.0), "guy2": (-22.0, 13.0), "guy3": (10.0, -22.0), "guy4": (10.0, 22.0)}


def rig(pretension: float, stiffness: float) -> rw.SkylineRig:
    """A standing skyline of one span with a guyed headspar."""
    guy = rw.Rope(mass_per_length=2.0, axial_stiffness=20e6, breaking_load=380e3)
    guys = tuple(
        rw.Guyline(name, rope=guy, at=(x, y, 845.0), pretension=pretension, stiffness=stiffness)
        for name, (x, y) in ANCHORS.items()
    )
    return rw.standing_skyline(
        rw.Profile.from_csv(Path(__file__).parent / "corridor.csv"),
        headspar=rw.GuyedSpar("head", station=0.0, height=15.0, mass=3000.0, guylines=guys),
        tailspar=rw.TailSpar("tail", station=260.0, height=9.0),
        skyline=rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3),
        tension=70e3,
        mainline=rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3),
        carriage=rw.Carriage("carriage", mass=450.0),
    )


def main(folder: Path = Path("ropeway-guyed")) -> pd.DataFrame:
    """Prints the comparison, writes it and a picture of tensions along the corridor into `folder`."""
    rows = []
    paths = {}
    for stiffness in (math.inf, 2e6):
        for pretension in (5e3, 20e3, 50e3):
            path = rw.load_path(rig(pretension, stiffness), 3000.0)
            worst = path.loc[path["highest_tension"].idxmax()]
            rows.append(
                {
                    "pretension [kN]": pretension / 1e3,
                    "anchors [kN/mm]": stiffness / 1e6,
                    "skyline [kN]": worst["highest_tension"] / 1e3,
                    "lean [mm]": worst["spar_lean"] * 1e3,
                    "guy1 [kN]": worst["guy1_tension"] / 1e3,
                    "guy3 [kN]": worst["guy3_tension"] / 1e3,
                    "compression [kN]": worst["spar_compression"] / 1e3,
                }
            )
            paths[pretension, stiffness] = path
    table = pd.DataFrame(rows)
    print(table.round(1).to_string(index=False))
    folder.mkdir(parents=True, exist_ok=True)
    table.to_csv(folder / "guyed_spar.csv", index=False)
    picture(paths).savefig(folder / "guyed_spar.png", dpi=110)
    return table


def picture(paths: dict[tuple[float, float], pd.DataFrame]) -> Figure:
    """Guyline tensions and lean along the corridor."""
    figure = Figure(figsize=(10.0, 7.0), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    colours = {5e3: "tab:blue", 20e3: "tab:orange", 50e3: "tab:green"}
    for (pretension, stiffness), path in paths.items():
        style = "-" if stiffness == math.inf else "--"
        label = f"{pretension / 1e3:.0f} kN, {'rigid anchors' if stiffness == math.inf else 'anchors 2 kN/mm'}"
        top.plot(path["station"], path["spar_lean"] * 1e3, color=colours[pretension], ls=style, lw=1.3, label=label)
        bottom.plot(path["station"], path["guy1_tension"] / 1e3, color=colours[pretension], ls=style, lw=1.3)
        bottom.plot(path["station"], path["guy3_tension"] / 1e3, color=colours[pretension], ls=style, lw=0.8)
    top.set_title("Guyed spar of 15 m under a skyline with 3 t: pretension of the guylines and their anchors")
    top.set_ylabel("lean of the top [mm]")
    top.legend(fontsize="small", ncols=2)
    bottom.set_ylabel("guyline tension [kN]\n(thick: back, thin: front)")
    bottom.set_xlabel("station of the carriage [m]")
    for axis in (top, bottom):
        axis.grid(alpha=0.3)
        axis.set_ylim(bottom=0.0)
    return figure


if __name__ == "__main__":
    main(*(Path(a) for a in sys.argv[1:2]))
