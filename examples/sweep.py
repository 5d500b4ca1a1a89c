"""Ten thousand variants of a mono-cable line: other loads, and deviations of the supports.

    python examples/sweep.py [folder] [variants]

The line is `line.csv` (24 spans), its rope strung at 45 kN and full of loads every 50 m. In each variant every load has
a mass of its own between 100 and 500 kg, and every idler stands up to 0.5 m higher or lower, the rope as long as it was
strung. Draws `sweep.png`: the tensions along the line, and the highest of each variant.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pandas as pd

import ropeway as rw

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=230e3)
SUPPORTS = Path(__file__).with_name("line.csv")
VARIANTS = 10_000


def main(folder: Path, variants: int) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    supports = pd.read_csv(SUPPORTS)
    line = rw.monocable(ROPE, supports, tension=45e3, load_mass=300.0, load_spacing=50.0)
    drawn = rw.equilibrium(line)
    bounds = {f"{load}.mass": (100.0, 500.0) for load in drawn.loads["load"]}
    idlers = supports[supports["kind"] == "idler"]
    bounds |= {f"{s.name}.z": (s.z - 0.5, s.z + 0.5) for s in idlers.itertuples(index=False)}
    spans = [span.name for span in drawn.runs[0].spans]
    names = [f"{span}.tension_{end}" for span in spans for end in "ab"]
    cases = rw.latin_hypercube(bounds, variants)
    table = rw.sweep(line, cases, outputs=names)
    failed = table["error"].ne("")
    print(f"{len(table):,} variants of {len(bounds)} parameters, {failed.sum()} without an equilibrium")
    tension = table.loc[~failed, names] / 1e3
    shares = tension.quantile([0.0, 0.05, 0.5, 0.95, 1.0]).T
    peak = tension.max(axis=1)
    working = ROPE.safe_working_load / 1e3
    print(shares.loc[[shares[1.0].idxmax(), shares[0.0].idxmin()]].round(1).rename_axis("tension [kN]").to_string())
    print(f"Highest tension of a variant: {peak.min():.1f} to {peak.max():.1f} kN")
    print(f"Above the safe working load of {working:.1f} kN: {(peak > working).mean():.1%} of the variants")
    places = [k for k in range(len(spans)) for _ in "ab"]
    stations = [x for a, b in zip(supports["x"][:-1], supports["x"][1:], strict=True) for x in (a, b)]
    _draw(folder / "sweep.png", shares.assign(x=stations, span=places), supports, drawn.frame["value"][names], peak)


def _draw(path: Path, shares: pd.DataFrame, supports: pd.DataFrame, drawn: pd.Series, peak: pd.Series) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 7.0), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=(2.0, 1.0), width_ratios=(2.0, 1.0))
    axis = figure.add_subplot(grid[0, :])
    axis.fill_between(shares["x"], shares[0.0], shares[1.0], color="#c6dbef", lw=0.0, label="all variants")
    axis.fill_between(shares["x"], shares[0.05], shares[0.95], color="#6baed6", lw=0.0, label="nine of ten")
    axis.plot(shares["x"], shares[0.5], color="#08306b", lw=1.5, label="median")
    axis.plot(shares["x"], drawn.to_numpy() / 1e3, color="#e08214", lw=1.2, ls="--", label="as drawn, 300 kg each")
    working = ROPE.safe_working_load / 1e3
    axis.axhline(working, color="#b5482a", lw=1.2, label="safe working load")
    axis.legend(fontsize=9, frameon=False, ncols=5, loc="upper left")
    axis.set(ylabel="tension [kN]", xlim=(shares["x"].min(), shares["x"].max()))
    axis.set_ylim(top=axis.get_ylim()[1] * 1.06)
    axis.set_title(f"Tension along the line in {len(peak):,} variants", loc="left", fontsize=11)
    ground = figure.add_subplot(grid[1, 0], sharex=axis)
    ground.plot(supports["x"], supports["z"], color="0.3", lw=1.0)
    for kind, marker in (("control", "s"), ("idler", "o")):
        at = supports[supports["kind"] == kind]
        ground.plot(at["x"], at["z"], marker, ms=5.0, color="0.3", mfc="white", label=kind)
    ground.legend(fontsize=9, frameon=False)
    ground.set(xlabel="x [m]", ylabel="support [m]")
    highest = figure.add_subplot(grid[1, 1])
    highest.hist(peak, bins=50, color="#6baed6")
    highest.axvline(working, color="#b5482a", lw=1.2)
    highest.set(xlabel="highest tension [kN]", ylabel="variants")
    for each in (axis, ground, highest):
        each.grid(alpha=0.25)
        each.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    folder, variants = (*sys.argv[1:3], *(".", str(VARIANTS))[len(sys.argv) - 1 :])
    main(Path(folder), int(variants))
