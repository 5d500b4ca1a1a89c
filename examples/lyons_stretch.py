"""Lyons' Figure 2: the average-tension method for a rope with construction stretch.

    python examples/lyons_stretch.py [folder]

Lyons (2008), International Journal of Forest Engineering 19(1): 29-35. Draws `lyons_stretch.png` and prints the
error where the tension is a third of the breaking load, and one rope's unstretched length by all three methods.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import ropeway as rw
from ropeway.systems.studies.handbook.cable_stretch import unstretched_length
from ropeway.systems.studies.handbook.lyons_cases import CASES, locus_phi, psi_average, psi_construction, twelve_cases


def main(folder: Path | None = None) -> Path:
    """Print the table and write the picture; returns its path."""
    print("Average tension over exact, where the tension at support A is a third of the breaking load")
    print(f"{'case':>4} {'beta':>9} {'tau':>5} {'slope':>6} {'phi':>7} {'ratio':>9}  possible")
    for case in CASES[4:]:
        phi = float(locus_phi(case.tau, case.slope))
        ratio = float(_ratio(case.beta, case.tau, case.slope, phi))
        word = "yes" if case.possible else "no"
        print(f"{case.number:4d} {case.beta:9.2e} {case.tau:5.0f} {case.slope:6.1f} {phi:7.2f} {ratio:9.6f}  {word}")

    rope = rw.Rope(mass_per_length=2.4, axial_stiffness=24.0e6, breaking_load=450.3e3, stretch=rw.ConstructionStretch())
    print("\n250 m of a new 1 in rope, H = 140 kN, V_A = 20 kN")
    for method in ("average tension", "elastic", "elastic and construction"):
        found = unstretched_length(rope, length=250.0, horizontal=140e3, vertical=20e3, method=method)
        print(f"  {method:25s} {float(found):9.4f} m unstretched, {float(found.tension_b) / 1e3:.2f} kN at B")
    return _draw(Path.cwd() if folder is None else folder)


def _ratio(beta: float, tau: float, slope: float, phi: np.ndarray | float) -> np.ndarray:
    chi = np.asarray(phi) / slope
    return psi_average(beta, phi, chi) / psi_construction(beta, phi, chi, tau)


def _draw(folder: Path) -> Path:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    axes, zoom = figure.subplots(1, 2, width_ratios=(4, 3))
    phi = np.geomspace(0.2, 100.0, 600)
    table = twelve_cases(phi)
    pairs = ((5, 9), (6, 10), (7, 11), (8, 12))
    colours = ("#1b6ca8", "#5b8c2a", "#b5482a", "#8a5a9e")
    words = ("50 m, slope 20 % at A", "50 m, 100 %", "300 m, 20 %", "300 m, 100 %")
    for pair, colour, word in zip(pairs, colours, words, strict=True):
        for number in pair:
            case = CASES[number - 1]
            rows = table[table["case"] == number]
            whole = rows["utilisation"] <= 1.0
            style = "-" if case.possible else ":"
            for panel in (axes, zoom):
                label = f"case {number}: {word}" + ("" if case.possible else " (not possible)")
                panel.plot(
                    rows["phi"][whole], 100 * (rows["ratio"][whole] - 1), style, color=colour, label=label, lw=1.8
                )
            last = rows[whole].iloc[-1]
            if case.possible and last["phi"] < 99.0:
                axes.plot(last["phi"], 100 * (last["ratio"] - 1), "x", color=colour, ms=8, mew=2)
    reach = np.geomspace(0.2, 3.0, 60)
    for tau, beta in ((62.0, 2.94e-4), (377.0, 4.90e-5)):
        for share, panels in ((1.0 / 3.0, (axes, zoom)), (0.5, (axes,))):
            place = locus_phi(tau, reach, share=share)
            for panel in panels:
                panel.plot(place, 100 * (_locus_ratio(beta, tau, reach, place) - 1), "--", color="0.35", lw=1.2)
    axes.text(0.23, 0.43, "tension at A a third of MBL", color="0.35", fontsize=9)
    axes.text(0.23, 1.0, "tension at A half of MBL", color="0.35", fontsize=9)
    axes.annotate("breaks (x)", (12.4, 4.02), (2.6, 4.05), color="0.25", fontsize=9, va="center",
                  arrowprops={"arrowstyle": "-", "color": "0.6"})  # fmt: skip
    axes.set(
        xscale="log",
        xlim=(0.2, 100),
        ylim=(-0.1, 4.4),
        xlabel=r"vertical force at A over the rope's weight, $\phi = V_A/W$",
    )
    axes.set_ylabel("average-tension length above the exact one  [%]")
    axes.set_title("Up to the breaking load", loc="left", fontsize=11)
    zoom.set(
        xscale="log",
        xlim=(0.2, 100),
        ylim=(-0.02, 0.6),
        xlabel=r"vertical force at A over the rope's weight, $\phi = V_A/W$",
    )
    zoom.set_title("Up to a third of it: 0.44 to 0.46 %", loc="left", fontsize=11)
    for panel in (axes, zoom):
        panel.grid(alpha=0.25)
        panel.spines[["top", "right"]].set_visible(False)
    axes.legend(fontsize=8, frameon=False, loc="upper left", bbox_to_anchor=(0.0, 0.86))
    figure.suptitle(
        "A new rope's unstretched length without its construction stretch (Lyons 2008, Figure 2)", fontsize=12
    )
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "lyons_stretch.png"
    figure.savefig(path, dpi=130)
    return path


def _locus_ratio(beta: float, tau: float, slope: np.ndarray, phi: np.ndarray) -> np.ndarray:
    return psi_average(beta, phi, phi / slope) / psi_construction(beta, phi, phi / slope, tau)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
