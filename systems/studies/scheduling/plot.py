"""A plan as a picture. matplotlib is imported when one is drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ropeway.systems.studies.scheduling.plan import SchedulePlan


def plan_figure(plan: SchedulePlan) -> Figure:
    """Speeds of the control sheaves, highest and lowest tension by plan and simulation, and drive forces."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 8.5), layout="constrained")
    speeds, tensions, forces = figure.subplots(3, 1, sharex=True, height_ratios=[1.0, 1.4, 1.0])
    frame = plan.result.full_frame
    for name, schedule in plan.schedules.items():
        (line,) = speeds.plot(schedule.times, schedule.speeds, lw=1.3, label=name)
        forces.plot(frame.index, frame[f"{name}.drive_force"] / 1e3, lw=1.0, color=line.get_color())
    pattern = r"\.tension_[ab]$"
    simulated, planned = (t.filter(regex=pattern) / 1e3 for t in (frame, plan.predicted))
    tensions.fill_between(frame.index, simulated.min(axis=1), simulated.max(axis=1), alpha=0.3, lw=0)
    tensions.plot(frame.index, simulated.max(axis=1), lw=1.2, color="tab:blue", label="simulated, all spans")
    whole = planned[planned.notna().all(axis=1)]
    for extreme in (whole.max(axis=1), whole.min(axis=1)):
        tensions.plot(whole.index, extreme, ".", ms=4, color="tab:red", label="planned" if extreme.max() else None)
    tensions.axvline(plan.settle, color="0.5", lw=0.8, ls=":")
    from_here = (plan.settle, tensions.get_ylim()[1])
    tensions.annotate(
        "limits count from here", from_here, xytext=(3, -3), textcoords="offset points", fontsize="small", va="top"
    )
    _limits(tensions, plan)
    speeds.set(ylabel="speed [m/s]", title="Schedule: " + " + ".join(f"least {name}" for name in plan.weights))
    speeds.legend(ncols=6, fontsize="small")
    tensions.set_ylabel("tension [kN]")
    handles, labels = tensions.get_legend_handles_labels()
    unique = pd.Series(handles, index=labels).groupby(level=0).first()
    tensions.legend(list(unique), list(unique.index), fontsize="small", ncols=3, loc="upper right")
    forces.set(xlabel="time [s]", ylabel="drive force [kN]", xlim=(0.0, plan.until))
    for axis in (speeds, tensions, forces):
        axis.grid(alpha=0.3)
    return figure


def _limits(axis: Axes, plan: SchedulePlan) -> None:
    """The tension limits, where the picture reaches them."""
    bottom, top = axis.get_ylim()
    for value in plan.tension:
        if bottom < value / 1e3 < top:
            axis.axhline(value / 1e3, color="tab:red", lw=1.0, ls="--")
