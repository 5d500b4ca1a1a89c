"""What the command line prints and writes of a schedule plan, and its tables."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ropeway.components.rounding import at_least
from ropeway.components.table_writer import write_table
from ropeway.components.whole_files import whole

if TYPE_CHECKING:
    import pandas as pd

    from ropeway.systems.studies.control.scheduling.schedule_plan import SchedulePlan


def report_plan(plan: SchedulePlan, out: Path, report: Path | None) -> None:
    """Writes schedules, active limits, robustness, a picture and the report; prints the objectives."""
    robust = plan.robustness()
    plan.to_csv(out / "schedule.csv")
    for name, table in (("limits.csv", plan.active), ("robustness.csv", robust)):
        write_table(table, out / name)
    with whole(out / "schedule.png") as file:
        plan.plot().savefig(file, dpi=130)
    if report is not None:
        plan.report(report)
    _print_plan(plan, robust)
    typer.echo(f"Written to {out.resolve()}: schedule.csv, limits.csv, robustness.csv, schedule.png")


def _print_plan(plan: SchedulePlan, robust: pd.DataFrame) -> None:
    """Prints objectives beside those of constant speed, limits, and robustness."""
    from ropeway.systems.studies.control.scheduling.limits import UNITS

    units = {"peak tension": ("kN", 1e3), "tension deviation": ("kN", 1e3), "energy": ("kJ", 1e3)}
    runs = {"constant speed": plan.constant, "sheaves in balance": plan.balanced, "optimised": plan.objectives}
    shown = {name: values for name, values in runs.items() if values is not None}
    rows = [
        [f"{name} [{unit}]", *(at_least(values[name] / scale, 2) for values in shown.values())]
        for name, (unit, scale) in units.items()
    ]
    title = f"Simulated: tensions from {plan.settle:g} s on, energy from 0 to {plan.until:g} s"
    print_table(title, ["", *shown], rows)
    gap = plan.gap
    typer.echo(
        f"{len(plan.history.rounds)} rounds, {plan.history.seconds:.0f} s; plan and simulation differ by "
        f"{1e3 * gap.crossing_time:.2g} ms in the times of crossings, {gap.peak_tension:.2g} N in the highest tension"
    )
    limits = [
        [limit, at, f"{r.bound:g} {UNITS[limit]}".rstrip(), f"{r.cost:.3g}"]
        for (limit, at), r in zip(plan.active.index, plan.active.itertuples(), strict=True)
    ]
    cost = f"cost [{'J' if 'energy' in plan.weights else 'N'} per unit]"
    print_table("Active limits, and the cost of a unit of each", ["limit", "at", "bound", cost], limits)
    over = (robust.xs("over plan", axis=1, level=1) * 100.0).round(2) + 0.0  # no -0.00
    print_table(
        "Highest tension above that of the plan, for lines that differ from the plan [%]",
        ["", *over.columns],
        [[str(case), *(f"{v:.2f}" for v in values)] for case, values in zip(over.index, over.to_numpy(), strict=True)],
    )


def print_table(title: str, columns: list[str], rows: list[list[str]]) -> None:
    """Prints a table, the first column to the left."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    for i, column in enumerate(columns):
        table.add_column(column, justify="left" if i == 0 else "right")
    for row in rows:
        table.add_row(*row)
    Console(markup=False).print(table)
