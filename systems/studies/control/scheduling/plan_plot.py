"""A plan as a picture. matplotlib is imported when one is drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ropeway.components.notebook_figure import new_figure
from ropeway.components.rounding import at_least, at_most
from ropeway.systems.results.limit_lines import ABOVE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ropeway.systems.studies.control.scheduling.plan_data import PlanData


def plan_figure(plan: PlanData) -> Figure:
    """Speeds of the control sheaves, highest and lowest tension by plan and simulation, and drive forces."""
    figure = new_figure(figsize=(10.0, 9.2), layout="constrained")
    speeds, tensions, forces = figure.subplots(3, 1, sharex=True, height_ratios=[1.0, 1.4, 1.0])
    frame = plan.result.full_frame
    for name, schedule in plan.schedules.items():
        (line,) = speeds.plot(schedule.times, schedule.speeds, lw=1.3, label=name)
        force = frame[f"{name}.drive_force"] / 1e3
        forces.plot(frame.index, force, lw=1.0, color=line.get_color(), label=name)
    _tensions(tensions, plan)
    _force_limit(forces, plan)
    speeds.set_ylabel("speed [m/s]")
    forces.set(xlabel="time [s]", ylabel="drive force [kN]", xlim=(0.0, plan.until))
    for axis in (speeds, tensions, forces):
        axis.grid(alpha=0.3)
        axis.legend(ncols=6, fontsize="small", **ABOVE)
    figure.suptitle(f"{plan.line.name}: {', '.join(f'least {plan.objective_text(name)}' for name in plan.weights)}")
    return figure


def _tensions(axis: Axes, plan: PlanData) -> None:
    """Highest and lowest tension of all spans, simulated and planned, and the limits that the picture reaches."""
    pattern = r"\.tension_[ab]$"
    simulated, planned = (t.filter(regex=pattern) / 1e3 for t in (plan.result.full_frame, plan.predicted))
    highest, lowest = simulated.max(axis=1), simulated.min(axis=1)
    axis.fill_between(simulated.index, lowest, highest, alpha=0.2, lw=0, color="tab:blue")
    axis.plot(simulated.index, highest, lw=1.2, color="tab:blue", label="highest of all spans")
    axis.plot(simulated.index, lowest, lw=1.2, color="tab:cyan", label="lowest")
    whole = planned[planned.notna().all(axis=1)]
    for extreme, label in ((whole.max(axis=1), "planned"), (whole.min(axis=1), None)):
        axis.plot(whole.index, extreme, ".", ms=4, color="tab:orange", label=label)
    bottom, top = axis.get_ylim()
    low, high = plan.tension
    for value, text, style in (
        (low, f"least allowed {at_least(low / 1e3, 1)} kN", "--"),
        (high, f"most allowed {at_most(high / 1e3, 1)} kN", "-"),
    ):
        if bottom < value / 1e3 < top:
            axis.axhline(value / 1e3, color="tab:red", lw=1.0, ls=style, label=text)
    if plan.settle > 0.0:
        axis.axvline(plan.settle, color="0.5", lw=0.8, ls=":")
        axis.annotate(
            "tensions count in the objective from here",
            (plan.settle, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(3, -3),
            textcoords="offset points",
            fontsize="small",
            va="top",
        )
    axis.set_ylabel("tension [kN]")


def _force_limit(axis: Axes, plan: PlanData) -> None:
    """The limit of the drives' forces, where all have one and the picture reaches it."""
    force = plan.limits.force
    if not isinstance(force, (int, float)) or not np.isfinite(force):
        return
    bottom, top = axis.get_ylim()
    label: str | None = f"limit {at_most(force / 1e3, 2)} kN"
    for value in (force / 1e3, -force / 1e3):
        if bottom < value < top:
            axis.axhline(value, color="tab:red", lw=1.0, ls="--", label=label)
            label = None
