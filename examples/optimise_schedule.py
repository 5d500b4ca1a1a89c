"""Control sheaves of a mono-cable line: constant speed, a threshold response, optimised schedules.

    python examples/optimise_schedule.py [folder]

The line is `line.csv` (24 spans, 4 control sheaves) with loads of 100 to 500 kg every 51 m, and starts with its control
sheaves in balance. A minute at 1 m/s: at constant speed, with a threshold response, and with schedules for each of
the three objectives, within 3 kN and 3 kW at each drive. Prints the objectives, the active limits, and the robustness
of the schedules for lines that differ from the plan, open loop and with a trim; draws `optimise_schedule.png`.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

import ropeway as rw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
SUPPORTS = Path(__file__).with_name("line.csv")
MASSES = tuple(np.random.default_rng(7).uniform(100.0, 500.0, 60).round())
LIMITS = rw.ScheduleLimits(force=3e3, power=3e3)
THRESHOLD = rw.ThresholdResponse(low=40e3, high=48e3, increment=0.015, hold=0.0, limit=0.15)
OBJECTIVES = ("peak tension", "tension deviation", "energy")
INTERVALS = 30
UNTIL, SETTLE, RECOVERED = 60.0, 10.0, 20.0
"""End of the runs; start of the evaluation of tensions, and for a line that starts out of balance [s]. Energy counts
over the whole run."""


def line(response: rw.ThresholdResponse | None = None) -> rw.System:
    """The line; with a response at all control sheaves except the first, which has the line's speed."""
    responses = None if response is None else dict.fromkeys(("c2", "c3", "c4"), response)
    return rw.monocable(ROPE, SUPPORTS, tension=42e3, load_mass=MASSES, load_spacing=51.0, response=responses)


def without_plan(response: rw.ThresholdResponse | None) -> rw.Result:
    """The line at constant speed, or with a response."""
    start = rw.balanced(line(response))
    return rw.simulate(start.model, UNTIL, every=0.5, start=start)


def plans() -> dict[str, rw.SchedulePlan]:
    """The best schedule for each objective."""
    start = rw.balanced(line())
    return {
        name: rw.optimise_schedule(
            line(), UNTIL, minimise=name, limits=LIMITS, intervals=INTERVALS, start=start, settle=SETTLE
        )
        for name in OBJECTIVES
    }


def row(result: rw.Result, target: float) -> dict[str, float]:
    """The objectives, and the largest drive force and power."""
    frame = result.full_frame
    found = rw.objectives(result, settle=SETTLE, target=target)
    return {
        "highest tension [kN]": found["peak tension"] / 1e3,
        "deviation [N]": found["tension deviation"],
        "energy [kJ]": found["energy"] / 1e3,
        "drive force [kN]": frame.filter(regex=r"^c\d\.drive_force$").abs().max(axis=None) / 1e3,
        "drive power [kW]": frame.filter(regex=r"^c\d\.power$").abs().max(axis=None) / 1e3,
    }


def main(folder: Path = Path("ropeway-schedule")) -> pd.DataFrame:
    """Prints the tables, draws the page; returns the first table."""
    best = plans()
    target = best["tension deviation"].target
    runs = {"constant speed": without_plan(None), "threshold response": without_plan(THRESHOLD)}
    runs |= {f"least {name}": plan.result for name, plan in best.items()}
    table = pd.DataFrame.from_dict({name: row(run, target) for name, run in runs.items()}, orient="index")
    print(
        f"Simulated: tensions from {SETTLE:.0f} s on, deviation from {target / 1e3:.2f} kN; "
        f"energy and the drives over all {UNTIL:.0f} s"
    )
    print(table.round(2).to_string())
    for name, plan in best.items():
        gap, report = plan.gap, plan.history
        print(
            f"\nLeast {name}: {len(report.rounds)} rounds, {report.seconds:.0f} s; "
            f"simulation and plan {1e3 * gap.crossing_time:.2g} ms (crossings), {gap.peak_tension:.2g} N (peak) apart"
        )
        print(plan.active.head(4).round(3).to_string() if len(plan.active) else "No active limit")
    robust = best["peak tension"].robustness(settle=RECOVERED)
    print(f"\nHighest tension over the plan's from {RECOVERED:.0f} s on, for lines that differ from the plan [%]")
    over = robust.xs("over plan", axis=1, level=1) * 100.0
    print(over.round(2).to_string())
    folder.mkdir(parents=True, exist_ok=True)
    for name, plan in best.items():
        plan.to_csv(folder / f"{name.replace(' ', '_')}.csv")
    picture(runs, best, over).savefig(folder / "optimise_schedule.png", dpi=110)
    return table


def picture(runs: dict[str, rw.Result], best: dict[str, rw.SchedulePlan], over: pd.DataFrame) -> Figure:
    """Highest tensions, energies, schedules and robustness on one page."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 12.0), layout="constrained")
    figure.suptitle("A mono-cable line of 24 spans with 4 control sheaves, loads of 100 to 500 kg at 51 m")
    grid = figure.add_gridspec(4, 3, height_ratios=[1.4, 1.1, 1.1, 1.1])
    tension, power = figure.add_subplot(grid[0, :]), figure.add_subplot(grid[1, :])
    for name, run in runs.items():
        frame = run.full_frame
        highest = frame.filter(regex=r"\.tension_[ab]$").max(axis=1)
        tension.plot(frame.index, highest / 1e3, lw=1.2, label=name)
        given = frame.filter(regex=r"^c\d\.power$").clip(lower=0.0).sum(axis=1)
        power.plot(frame.index, given / 1e3, lw=1.2, label=name)
    tension.set(ylabel="highest tension\nof all spans [kN]", title="Simulated")
    tension.legend(fontsize="small", ncols=3)
    power.set(ylabel="power given by\nthe drives [kW]", xlabel="time [s]")
    power.set_ylim(bottom=0.0)
    schedules = [figure.add_subplot(grid[2, k]) for k in range(3)]
    for axis, (name, plan) in zip(schedules, best.items(), strict=True):
        for sheave, schedule in plan.schedules.items():
            axis.plot(schedule.times, schedule.speeds, lw=1.2, label=sheave)
        axis.set(title=f"Schedule: least {name}", xlabel="time [s]", ylim=(0.84, 1.16))
    schedules[0].set_ylabel("speed [m/s]")
    schedules[0].legend(fontsize="small", ncols=2)
    bars, place = figure.add_subplot(grid[3, :]), np.arange(len(over))
    for shift, kind, colour in ((-0.2, "open loop", "tab:red"), (0.2, "trimmed", "tab:green")):
        bars.barh(place + shift, over[kind], height=0.38, color=colour, label=kind)
    bars.set_yticks(place, list(over.index))
    bars.invert_yaxis()
    bars.axvline(0.0, color="0.3", lw=0.8)
    bars.axvline(2.0, color="0.3", lw=0.8, ls=":")
    bars.set(title="Least peak tension, when the line is not as planned", xlabel="highest tension over the plan's [%]")
    bars.legend(fontsize="small")
    for axis in (tension, power, *schedules, bars):
        axis.grid(alpha=0.3)
    for axis in (tension, power):
        axis.set_xlim(0.0, UNTIL)
    return figure


if __name__ == "__main__":
    main(*(Path(a) for a in sys.argv[1:2]))
