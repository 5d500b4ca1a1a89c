"""Control sheaves that keep a mono-cable line in its tension range: eight pictures on one page.

    python examples/turk_responses.py [folder]

After the subjects of Turk's chapters 3 to 6 (1988). His figures 6 to 18 and their data are not available, so line,
loads, responses and drives are our own. The line is `line.csv` (24 spans, 4 control sheaves),
its empty rope at 45 kN; loads of 300, 100, 500, 200, 600 kg, a missing one and 450 kg have a spacing of 50 m. It
starts full and out of its range of 44 to 66 kN. Draws `turk_responses.png` and prints a table of the variants.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

import ropeway as rw

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
SUPPORTS = Path(__file__).with_name("line.csv")
MASSES = (300.0, 100.0, 500.0, 200.0, 600.0, 0.0, 450.0)
LOW, HIGH = 44e3, 66e3
BASE = {"increment": 0.005, "period": 1.0, "delay": 0.0, "initiation": -2000.0, "hold": 3.0}
DRIVE = rw.HydraulicDrive(
    displacement=45e-6,
    gear_ratio=20.0,
    sheave_radius=0.5,
    relief_pressure=250e5,
    pump_flow=2.4e-3,
    engine_power=30e3,
    inertia=800.0,
)
UNTIL, SETTLED, TOP = 300.0, 100.0, 78.0
CROSSED = 540.0
"""Time at which the single load has crossed the spans from c1 to c2 [s]."""
SHADES = ("#9ecae1", "#4292c6", "#08519c", "#08203f")
COLOURS = ("#08519c", "#e08214", "#5b8c2a", "#b5482a", "#7b4ea3")
SPAN, GROUP = "s6_s7", ("c1", "s5", "s6", "s7", "s8", "c2")


@lru_cache(maxsize=1)
def without() -> rw.Result:
    """The line without responses."""
    return _simulate(response=None)


@lru_cache(maxsize=64)
def variant(precedence: str = "all at once", *, hydraulic: bool = False, **change: float) -> rw.Result:
    """The line with the responses of BASE, with changes."""
    response = rw.ThresholdResponse(low=LOW, high=HIGH, **{**BASE, **change})
    return _simulate(response=response, precedence=precedence, drive=DRIVE if hydraulic else None)


def _simulate(**settings: Any) -> rw.Result:
    line = rw.monocable(ROPE, SUPPORTS, tension=45e3, load_mass=MASSES, load_spacing=50.0, **settings)
    return rw.simulate(line, until=UNTIL, every=1.0)


@lru_cache(maxsize=4)
def crossing(mass: float) -> tuple[rw.Result, pd.DataFrame]:
    """A single load that crosses the spans from c1 to c2, and its position at each record."""
    line = rw.monocable(ROPE, SUPPORTS, tension=45e3, load_mass=(0.0, 0.0, mass) + (0.0,) * 9, load_spacing=940.0)
    result = rw.simulate(line, until=CROSSED, every=2.0)
    places = []
    for i in range(len(result.records)):
        loads = result.record(i).loads
        places.append(loads.loc[loads["mass"] > 0.0, ["span", "x", "z"]].iloc[0])
    return result, pd.DataFrame(places, index=result.full_frame.index)


def figures(result: rw.Result) -> dict[str, float]:
    """Highest and lowest tension at the control sheaves once settled, time outside the range, actions."""
    frame = result.full_frame
    tension = frame.filter(regex=r"^c\d\.tension_(in|out)$")
    settled = tension[frame.index >= SETTLED]
    outside = ((tension > HIGH) | (tension < LOW)).any(axis=1)
    return {
        "highest [kN]": settled.max(axis=None) / 1e3,
        "lowest [kN]": settled.min(axis=None) / 1e3,
        "outside [s]": np.trapezoid(outside.astype(float), frame.index),
        "actions": int((result.events["event"] == "response").sum()),
    }


def lines() -> dict[str, dict[str, rw.Result]]:
    """The runs of each panel, by label."""
    slow = 0.002
    orders = ("all at once", "worst first", "neighbours locked out", "upstream first", "downstream first")
    return {
        "increment": {f"{1e3 * i:.0f} mm/s": variant(increment=i) for i in (0.002, 0.005, 0.01, 0.02)},
        "initiation": {f"{i / 1e3:+.0f} kN" if i else "0 kN": variant(initiation=i) for i in (-2000.0, 0.0, 2000.0)},
        "period, delay": {
            f"{p:.0f} s, {d:.0f} s": variant(increment=slow, period=p, delay=d)
            for p, d in ((1.0, 0.0), (4.0, 0.0), (1.0, 3.0), (1.0, 6.0))
        },
        "precedence": {order: variant(order, increment=0.01, period=2.0) for order in orders},
    }


def main(folder: Path) -> None:
    """Prints the drive and the table, draws the page."""
    folder.mkdir(parents=True, exist_ok=True)
    print(
        f"Hydraulic drive: relief valve opens at {DRIVE.relief_force / 1e3:.1f} kN, "
        f"full flow at {DRIVE.top_speed:.2f} m/s, engine {DRIVE.engine_power / 1e3:.0f} kW"
    )
    panels = lines()
    rows = {("no response", ""): figures(without())}
    rows |= {(name, label): figures(run) for name, runs in panels.items() for label, run in runs.items()}
    rows["hydraulic drive", ""] = figures(variant(hydraulic=True))
    table = pd.DataFrame.from_dict(rows, orient="index").astype({"actions": int})
    table.index = pd.MultiIndex.from_tuples(table.index)
    print(f"\nControl sheaves; highest and lowest from {SETTLED:.0f} s, the rest over {UNTIL:.0f} s")
    print(table.round(1).to_string())
    print(f"\nPower of the hydraulic drives [kW, MJ]\n{_power().round(2).to_string()}")
    _draw(folder / "turk_responses.png", panels)


def _power() -> pd.DataFrame:
    return variant(hydraulic=True).power() / [1e3, 1e3, 1e3, 1e6, 1e6]


def _draw(path: Path, panels: Mapping[str, Mapping[str, rw.Result]]) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 15.0), layout="constrained")
    grid = figure.add_gridspec(4, 2)
    inner = grid[0, 0].subgridspec(2, 1, hspace=0.02)
    top = figure.add_subplot(inner[0])
    _span(top, figure.add_subplot(inner[1], sharex=top))
    notes = {
        "increment": "(c) Increment of speed: response magnitude",
        "initiation": "(d) Initiation: beyond the limit (+) or ahead of it (-)",
        "period, delay": "(e) Period and delay: response speed (increment 2 mm/s)",
        "precedence": "(f) Precedence (increment 10 mm/s, period 2 s)",
    }
    _path(figure.add_subplot(grid[0, 1]))
    for place, (name, title) in enumerate(notes.items()):
        axis = figure.add_subplot(grid[1 + place // 2, place % 2])
        _tension(axis, panels[name], SHADES if name == "increment" else COLOURS)
        for label, colour in zip(panels[name], COLOURS, strict=False):
            if name == "initiation":
                axis.axhline(HIGH / 1e3 + float(label.split()[0]), color=colour, lw=0.9, ls=":")
        axis.legend(fontsize=8, title_fontsize=8, frameon=False, loc="lower right", ncols=3, title=name)
        _finish(axis, title, "tension out of c1 [kN]")
    _differential(figure.add_subplot(grid[3, 0]))
    _powers(figure.add_subplot(grid[3, 1]))
    base = f"increment {1e3 * BASE['increment']:.0f} mm/s, period {BASE['period']:.0f} s, no delay"
    figure.suptitle(
        "Responses of control sheaves on a mono-cable line of 24 spans\n"
        "after the subjects of Turk (1988, chapters 3 to 6), own data\n"
        f"Unless stated: {base}, initiation {BASE['initiation'] / 1e3:.0f} kN, hold {BASE['hold']:.0f} s; "
        "green: tension range",
        fontsize=12,
    )
    figure.savefig(path, dpi=110)


def _span(top: Axes, bottom: Axes) -> None:
    """Tensions at the ends of a span and the rope in it while a load crosses the group of spans."""
    result, place = crossing(300.0)
    frame, nodes = result.full_frame, _points(result)
    for end, colour in (("b", COLOURS[1]), ("a", COLOURS[0])):
        name = SPAN.split("_")["ab".index(end)]
        top.plot(place["x"], frame[f"{SPAN}.tension_{end}"] / 1e3, color=colour, lw=1.5, label=f"at {name}")
    length = frame[f"{SPAN}.length"]
    bottom.plot(place["x"], length, color="0.2", lw=1.5)
    top.tick_params(labelbottom=False)
    for axis in (top, bottom):
        axis.axvspan(*(nodes[n][0] for n in SPAN.split("_")), color="0.92", zorder=0)
        _supports(axis, nodes)
    top.set_ylim(45.5, 54.5)
    bottom.set_ylim(87.53, 87.66)
    top.legend(fontsize=8, frameon=False, loc="upper left", ncols=2)
    _finish(top, f"(a) Ends and rope of span {SPAN.replace('_', '-')} while one load of 300 kg passes", "tension [kN]")
    _finish(bottom, "", "unstretched [m]", "place of the load x [m]")


def _path(axis: Axes) -> None:
    """Paths of loads of different mass, and the empty rope."""
    result, _ = crossing(300.0)
    nodes = _points(result)
    points = np.array([nodes[n] for n in GROUP])
    empty = rw.equilibrium(rw.monocable(ROPE, SUPPORTS, tension=45e3))
    rope = pd.concat([empty.profile(f"{a}_{b}", 60) for a, b in pairwise(GROUP)])
    axis.plot(rope["x"], rope["z"] - np.interp(rope["x"], *points.T), color="0.5", lw=1.0, ls="--", label="empty rope")
    for mass, colour in zip((100.0, 300.0, 600.0), SHADES[:3], strict=True):
        place = crossing(mass)[1]
        height = place["z"] - np.interp(place["x"], *points.T)
        axis.plot(place["x"], height, color=colour, lw=1.5, label=f"{mass:.0f} kg")
    axis.axhline(0.0, color="0.3", lw=0.8)
    _supports(axis, nodes)
    axis.legend(fontsize=8, frameon=False, loc="lower right", ncols=4)
    axis.set_ylim(-4.3, 0.3)
    _finish(axis, "(b) Path of one load from c1 to c2", "height above the chord [m]", "place of the load x [m]")


def _points(result: rw.Result) -> dict[str, tuple[float, float]]:
    """x and z of the supports."""
    run = result.model.runs[0]
    return {node.name: (x, z) for node, (x, _, z) in zip(run.nodes, run.points, strict=True)}


def _supports(axis: Axes, nodes: Mapping[str, tuple[float, float]]) -> None:
    for name in GROUP:
        axis.axvline(nodes[name][0], color="0.75", lw=0.8, zorder=0)
    axis.set_xlim(nodes[GROUP[0]][0], nodes[GROUP[-1]][0])


def _tension(axis: Axes, runs: Mapping[str, rw.Result], colours: tuple[str, ...]) -> None:
    frame = without().full_frame
    axis.axhspan(LOW / 1e3, HIGH / 1e3, color="#e6f2e0", zorder=0)
    axis.plot(frame.index, frame["c1.tension_out"] / 1e3, color="0.75", lw=3.0, label="no response")
    for (label, run), colour in zip(runs.items(), colours, strict=False):
        frame = run.full_frame
        tension = frame["c1.tension_out"] / 1e3
        axis.plot(frame.index, tension, color=colour, lw=1.3, label=label)
        note: dict[str, Any] = {"color": colour, "fontsize": 8, "va": "top"}
        if tension.max() > TOP:
            axis.annotate(f"{label}: to {tension.max():.0f} kN", (tension.idxmax() + 26.0, TOP - 0.5), **note)
        if run.events.query("event == 'response' and component == 'c1'").empty:
            axis.annotate(f"{label}: c1 never acts", (UNTIL / 3.0, TOP - 0.5), **note)
    axis.set(xlim=(0.0, UNTIL), ylim=(34.0, TOP))


def _differential(axis: Axes) -> None:
    run, still = variant(hydraulic=True).full_frame, without().full_frame
    for name, colour in zip(("c1", "c2", "c3", "c4"), COLOURS, strict=False):
        column = f"{name}.differential_tension"
        axis.plot(run.index, run[column] / 1e3, color=colour, lw=1.3, label=name)
        axis.plot(still.index, still[column] / 1e3, color=colour, lw=0.8, alpha=0.5, ls="--")
    axis.plot([], [], color="0.5", lw=0.8, ls="--", label="no response")
    axis.legend(fontsize=8, frameon=False, loc="lower right", ncols=5)
    axis.set(xlim=(0.0, UNTIL), ylim=(-40.0, 30.0))
    _finish(axis, "(g) Differential tension, out less in (hydraulic drives)", "differential tension [kN]")


def _powers(axis: Axes) -> None:
    frame, energy = variant(hydraulic=True).full_frame, _power()
    for name, colour in zip(("c1", "c2", "c3", "c4"), COLOURS, strict=False):
        label = f"{name}: {energy.loc[name, 'pulled']:.1f} MJ pulled, {energy.loc[name, 'recovered']:.1f} recovered"
        axis.plot(frame.index, frame[f"{name}.power"] / 1e3, color=colour, lw=1.3, label=label)
    total = frame.filter(regex=r"^c\d\.power$").sum(axis=1)
    axis.plot(frame.index, total / 1e3, color="0.2", lw=1.3, ls="--", label="all four")
    axis.legend(fontsize=8, frameon=False, loc="lower right", ncols=2)
    axis.set(xlim=(0.0, UNTIL), ylim=(-36.0, 27.0))
    _finish(axis, "(h) Power into the rope (hydraulic drives)", "power [kW]")


def _finish(axis: Axes, title: str, y: str, x: str = "time [s]") -> None:
    axis.set_title(title, loc="left", fontsize=10.5)
    axis.set_ylabel(y)
    if axis.xaxis.get_tick_params().get("labelbottom", True):
        axis.set_xlabel(x)
    axis.grid(alpha=0.25)
    axis.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path.cwd())
