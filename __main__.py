"""The command line: demo, simulate a line, optimise its schedules, payload of a corridor, FMUs, ropes."""

from __future__ import annotations

from importlib.resources import as_file, files
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ropeway.fmu.command import app as fmu_commands
from ropeway.fmu.terminal import LoadMass, LoadSpacing, RopeName, Tension, errors_on_one_line

if TYPE_CHECKING:
    import pandas as pd

    from ropeway.systems.result import Result
    from ropeway.systems.studies.scheduling.plan import SchedulePlan

app = typer.Typer(
    help="Cable logging systems and material ropeways: statics and simulation.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # it would take [m/s] for a tag
)

app.add_typer(fmu_commands, name="fmu")

Out = Annotated[Path, typer.Option(help="Folder for tables and pictures; it is made if need be.")]
SafetyFactor = Annotated[float, typer.Option(help="Breaking load over safe working load.")]


@app.command()
def demo(out: Out = Path("ropeway-demo")) -> None:
    """Run ten minutes of an example: a mono-cable line of 24 spans, 2.4 km, with a 300 kg load every 50 m."""
    import ropeway as rw

    with errors_on_one_line(), as_file(files("ropeway.examples") / "line.csv") as supports:
        rope = rw.Rope.named("RHOL-IWRC 29")
        line = rw.monocable(rope, supports, tension=45e3, speed=1.0, load_mass=300.0, load_spacing=50.0)
        _report(rw.simulate(line, until=600.0, every=1.0), out)


@app.command()
def simulate(
    line: Annotated[
        Path,
        typer.Argument(
            help="Supports: CSV with columns name,x,y,z,kind (metres; kind: anchor, "
            "drum, idler, control, return), in the order of the rope."
        ),
    ],
    rope: RopeName = "RHOL-IWRC 29",
    tension: Tension = 45e3,
    speed: Annotated[float, typer.Option(help="Rope speed [m/s]; negative runs backwards.")] = 1.0,
    load_mass: LoadMass = 300.0,
    load_spacing: LoadSpacing = 50.0,
    until: Annotated[float, typer.Option(help="Length of the run [s].")] = 600.0,
    every: Annotated[float, typer.Option(help="Interval of the tables [s].")] = 1.0,
    safety_factor: SafetyFactor = 3.0,
    out: Out = Path("ropeway-out"),
) -> None:
    """Simulate a mono-cable line: tensions, events and pictures."""
    import ropeway as rw

    with errors_on_one_line():
        chosen = rw.Rope.named(rope, safety_factor=safety_factor)
        system = rw.monocable(
            chosen, line, tension=tension, speed=speed, load_mass=load_mass, load_spacing=load_spacing, name=line.stem
        )
        _report(rw.simulate(system, until=until, every=every), out)


@app.command()
def optimise(
    line: Annotated[Path, typer.Argument(help="Supports, as for `simulate`, with at least two control sheaves.")],
    rope: RopeName = "RHOL-IWRC 29",
    tension: Tension = 45e3,
    speed: Annotated[float, typer.Option(help="Rope speed [m/s].")] = 1.0,
    load_mass: LoadMass = 300.0,
    load_spacing: LoadSpacing = 50.0,
    until: Annotated[float, typer.Option(help="Length of the schedule [s].")] = 120.0,
    intervals: Annotated[int, typer.Option(help="Pieces of the schedule.")] = 60,
    minimise: Annotated[str, typer.Option(help="peak tension, tension deviation or energy.")] = "peak tension",
    force: Annotated[float, typer.Option(help="Largest force of a drive [N].")] = float("inf"),
    power: Annotated[float, typer.Option(help="Largest power of a drive [W].")] = float("inf"),
    settle: Annotated[
        float | None,
        typer.Option(
            help="When limits and objective begin to count [s]; by default 10 s or a quarter of the schedule."
        ),
    ] = None,
    safety_factor: SafetyFactor = 3.0,
    out: Out = Path("ropeway-schedule"),
) -> None:
    """Optimise how the control sheaves of a mono-cable line move: schedules, limits that bind, robustness."""
    import ropeway as rw

    with errors_on_one_line():
        chosen = rw.Rope.named(rope, safety_factor=safety_factor)
        system = rw.monocable(
            chosen, line, tension=tension, speed=speed, load_mass=load_mass, load_spacing=load_spacing, name=line.stem
        )
        limits = rw.ScheduleLimits(force=force, power=power)
        _report_plan(
            rw.optimise_schedule(system, until, minimise=minimise, limits=limits, intervals=intervals, settle=settle),
            out,
        )


@app.command()
def payload(
    corridor: Annotated[Path, typer.Argument(help="Ground of the corridor: CSV with columns station,elevation [m].")],
    skyline: Annotated[str, typer.Option(help="Name of the skyline; `ropeway ropes` lists them.")] = "RHOL-IWRC 29",
    mainline: Annotated[str | None, typer.Option(help="Name of the mainline; without one an ideal hold.")] = None,
    tension: Annotated[float, typer.Option(help="Tension of the bare skyline at the headspar [N].")] = 70e3,
    head: Annotated[float | None, typer.Option(help="Station of the headspar [m]; by default the first.")] = None,
    tail: Annotated[float | None, typer.Option(help="Station of the tailspar [m]; by default the last.")] = None,
    head_height: Annotated[float, typer.Option(help="Height of the headspar [m].")] = 15.0,
    tail_height: Annotated[float, typer.Option(help="Height of the tailspar [m].")] = 8.0,
    support: Annotated[list[str] | None, typer.Option(help="Intermediate support STATION:HEIGHT; repeat it.")] = None,
    carriage_mass: Annotated[float, typer.Option(help="Mass of the carriage [kg].")] = 450.0,
    load_depth: Annotated[float, typer.Option(help="From the skyline down to the load's lowest point [m].")] = 0.0,
    safety_factor: SafetyFactor = 3.0,
    clearance: Annotated[float, typer.Option(help="Least clearance under the load [m].")] = 1.0,
    spacing: Annotated[float, typer.Option(help="Distance between stations [m].")] = 10.0,
    out: Out = Path("ropeway-payload"),
) -> None:
    """Largest payload along a standing skyline, and what limits it."""
    import ropeway as rw
    from ropeway.systems.studies.corridor_report import payload_command

    with errors_on_one_line():
        study, paths = payload_command(
            corridor,
            skyline=rw.Rope.named(skyline),
            mainline=None if mainline is None else rw.Rope.named(mainline),
            tension=tension,
            head=head,
            tail=tail,
            head_height=head_height,
            tail_height=tail_height,
            supports=tuple(support or ()),
            carriage_mass=carriage_mass,
            load_depth=load_depth,
            safety_factor=safety_factor,
            clearance=clearance,
            spacing=spacing,
            out=out,
        )
        frame = study.frame
        rows = [[f"{r.station:.0f}", f"{r.payload:.0f}", str(r.limited_by)] for r in frame.itertuples()]
        _table(f"Payload along {corridor.stem}", ["station [m]", "payload [kg]", "limited by"], rows)
        worst = study.limiting
        typer.echo(f"Largest payload {study.payload:.0f} kg, limited at {worst.station:.0f} m by {worst.limited_by}.")
        typer.echo(f"Written to {paths[0].parent.resolve()}: {', '.join(p.name for p in paths)}")


@app.command()
def ropes() -> None:
    """List the named ropes."""
    import ropeway as rw

    table = rw.ropes()
    _table(
        "Named ropes",
        ["name", "diameter [mm]", "mass [kg/m]", "EA [MN]", "MBL [kN]", "source"],
        [
            [
                str(name),
                f"{r.diameter * 1e3:.2f}",
                f"{r.mass_per_length:.2f}",
                f"{r.axial_stiffness / 1e6:.1f}",
                f"{r.breaking_load / 1e3:.1f}",
                r.source,
            ]
            for name, r in zip(table.index, table.itertuples(), strict=True)
        ],
    )


def _report(result: Result, out: Path) -> None:
    """Prints a summary; writes tensions, events and pictures."""
    out.mkdir(parents=True, exist_ok=True)
    frame, events, rope = result.frame, result.events, result.runs[0].rope
    tensions = result.full_frame.filter(regex=r"\.(tension_in|tension_out|rope_tension)$")
    ends = result.full_frame.filter(regex=r"\.tension_[ab]$")
    driven = [n for n in result.runs[0].nodes if n.drive_speed is not None or n.kept_tension is not None]
    names = [c for n in driven for c in tensions.columns if c.startswith(f"{n.name}.")]
    _table(
        f"{result.model.name}: {len(result.runs[0].spans)} spans, {result.times[-1]:g} s",
        ["tension [kN]", "lowest", "mean", "highest"],
        [[c, *(f"{v / 1e3:.1f}" for v in (tensions[c].min(), frame[c].mean(), tensions[c].max()))] for c in names],
    )
    place = ends.max().idxmax()
    typer.echo(
        f"Highest tension {ends.max().max() / 1e3:.1f} kN at {place} (t = {ends[place].idxmax():.1f} s); "
        f"SWL {rope.safe_working_load / 1e3:.1f} kN, MBL {rope.breaking_load / 1e3:.1f} kN. "
        f"Lowest {ends.min().min() / 1e3:.1f} kN."
    )
    counts = events["event"].value_counts()
    typer.echo("Events: " + (", ".join(f"{n} {name}" for name, n in counts.items()) or "none"))
    tensions_table = _with_units(
        frame.filter(regex=r"\.(tension_in|tension_out|rope_tension|tension_a|tension_b)$"), result
    )
    tensions_table.to_csv(out / "tensions.csv", float_format="%.3f")
    events.to_csv(out / "events.csv", index=False)
    result.plot().savefig(out / "tensions.png", dpi=130)
    result.plot_line(time=float(result.times[-1]) / 2.0).savefig(out / "line.png", dpi=130)
    typer.echo(f"Written to {out.resolve()}: tensions.csv, events.csv, tensions.png, line.png")


def _report_plan(plan: SchedulePlan, out: Path) -> None:
    """Prints what a plan brings; writes schedules, limits, robustness and a picture."""
    from ropeway.systems.studies.scheduling.limits import UNITS

    out.mkdir(parents=True, exist_ok=True)
    units = {"peak tension": ("kN", 1e3), "tension deviation": ("kN", 1e3), "energy": ("kJ", 1e3)}
    rows = [
        [f"{name} [{unit}]", f"{plan.balanced[name] / scale:.2f}", f"{plan.objectives[name] / scale:.2f}"]
        for name, (unit, scale) in units.items()
    ]
    _table(f"From {plan.settle:g} s on, simulated", ["", "sheaves in balance", "optimised"], rows)
    gap = plan.gap
    typer.echo(
        f"{len(plan.report.rounds)} rounds, {plan.report.seconds:.0f} s; plan and simulation are "
        f"{1e3 * gap.crossing_time:.2g} ms (crossings) and {gap.peak_tension:.2g} N (peak) apart"
    )
    limits = [
        [limit, at, f"{r.bound:g} {UNITS[limit]}".rstrip(), f"{r.cost:.3g}"]
        for (limit, at), r in zip(plan.active.index, plan.active.itertuples(), strict=True)
    ]
    cost = f"cost [{'J' if 'energy' in plan.weights else 'N'} per unit]"
    _table("Limits that bind, and what a unit of them costs", ["limit", "at", "bound", cost], limits)
    robust = plan.robustness()
    over = (robust.xs("over plan", axis=1, level=1) * 100.0).round(2) + 0.0  # no -0.00
    _table(
        "Highest tension over the plan's, when the line is not as planned [%]",
        ["", *over.columns],
        [[str(case), *(f"{v:.2f}" for v in values)] for case, values in zip(over.index, over.to_numpy(), strict=True)],
    )
    plan.to_csv(out / "schedule.csv")
    plan.active.to_csv(out / "limits.csv")
    robust.to_csv(out / "robustness.csv")
    plan.plot().savefig(out / "schedule.png", dpi=130)
    typer.echo(f"Written to {out.resolve()}: schedule.csv, limits.csv, robustness.csv, schedule.png")


def _with_units(frame: pd.DataFrame, result: Result) -> pd.DataFrame:
    units = result.full_frame.attrs["units"]
    return frame.rename(columns={c: f"{c} [{units[c]}]" for c in frame.columns}).rename_axis("time [s]")


def _table(title: str, columns: list[str], rows: list[list[str]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    for i, column in enumerate(columns):
        table.add_column(column, justify="left" if i == 0 else "right")
    for row in rows:
        table.add_row(*row)
    Console(markup=False).print(table)


if __name__ == "__main__":
    app()
