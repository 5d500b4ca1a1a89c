"""A guyed spar of a skyline: decrease of the skyline's tension as the spar leans.

Four guylines with pretensions of 5, 20 and 50 kN, on rigid anchors and on stumps with 2 kN/mm.
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
    rw.write_table(table, folder / "guyed_spar.csv")
    picture(paths).savefig(folder / "guyed_spar.png", dpi=110)
    return table


def picture(paths: dict[tuple[float, float], pd.DataFrame]) -> Figure:
    """Lean along the corridor, and tensions of the guylines where those at the back are highest."""
    figure = Figure(figsize=(10.0, 7.0), layout="constrained")
    grid = figure.add_gridspec(2, 3)
    lean = figure.add_subplot(grid[0, :])
    bars = [figure.add_subplot(grid[1, k]) for k in range(3)]
    colours = {5e3: "tab:blue", 20e3: "tab:orange", 50e3: "tab:green"}
    for (pretension, stiffness), path in paths.items():
        rigid = stiffness == math.inf
        label = f"{pretension / 1e3:.0f} kN, {'rigid anchors' if rigid else 'anchors 2 kN/mm'}"
        colour, style = colours[pretension], "-" if rigid else "--"
        lean.plot(path["station"], path["spar_lean"] * 1e3, lw=1.3, label=label, color=colour, ls=style)
        worst = path.loc[path["guy1_tension"].idxmax()]
        place = list(colours).index(pretension) + (-0.2 if rigid else 0.2)
        for axis, column in zip(bars, ("guy1_tension", "guy3_tension", "highest_tension"), strict=True):
            hatch = None if rigid else "//"
            bar = axis.bar(place, worst[column] / 1e3, 0.38, color=colour, hatch=hatch, edgecolor="white")
            axis.bar_label(bar, fmt="%.1f", fontsize="small")
    lean.set_title("Guyed spar of 15 m under a skyline with 3 t: pretension of the guylines and their anchors")
    lean.set(ylabel="lean of the top [mm]", xlabel="station of the carriage [m]")
    lean.set_ylim(bottom=0.0)
    lean.legend(fontsize="small", ncols=2, loc="lower center")
    lean.grid(alpha=0.3)
    for axis, title in zip(bars, ("back guyline", "front guyline", "skyline"), strict=True):
        axis.set_title(f"{title}, where the back guylines pull most", fontsize="small")
        axis.set_xticks(range(3), [f"{p / 1e3:.0f} kN" for p in colours])
        axis.set_xlabel("pretension (hatched: anchors 2 kN/mm)")
        axis.margins(y=0.12)
        axis.grid(axis="y", alpha=0.3)
    bars[0].set_ylabel("tension [kN]")
    return figure


if __name__ == "__main__":
    main(*(Path(a) for a in sys.argv[1:2]))
