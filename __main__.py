"""The command line: demo, simulation of a line, schedules, payload of a corridor, FMUs, ropes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib.resources import as_file, files
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ropeway import cli_cases, cli_options, cli_projects
from ropeway.cli_options import LineOptions, WeatherOptions, errors_on_one_line, folder_for, grouped
from ropeway.cli_plan import print_table, report_plan
from ropeway.components.errors import Interrupted, SimulationError
from ropeway.components.rounding import at_least, at_most
from ropeway.components.table_writer import write_table
from ropeway.components.whole_files import whole
from ropeway.fmu.cli import app as fmu_commands

if TYPE_CHECKING:
    from ropeway.systems.dynamics.result import Result
    from ropeway.systems.studies.skyline.payload.command import CorridorRequest

app = typer.Typer(
    help="Cable logging systems and material ropeways: statics and simulation.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # it would read [m/s] as a tag
)

app.add_typer(fmu_commands, name="fmu")
app.command()(cli_projects.new)
app.command()(cli_projects.compare)
app.command()(cli_cases.cases)
cache_commands = typer.Typer(help="Compiled libraries that are kept.", no_args_is_help=True, rich_markup_mode=None)
app.add_typer(cache_commands, name="cache")


def _show_version(asked: bool) -> None:
    if asked:
        from ropeway import __version__

        typer.echo(f"ropeway {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Cable logging systems and material ropeways: statics and simulation."""


Out = Annotated[Path, typer.Option(help="Folder for tables and pictures; created if it does not exist.")]
Report = Annotated[Path | None, typer.Option(help="Write a report too, .html or .pdf; needs the extra `report`.")]
Catalogue = Annotated[Path | None, typer.Option(help="A table of ropes of your own, CSV, Excel or TOML.")]
Compiled = Annotated[bool, typer.Option("--compiled", help="Solve in compiled code; needs a C compiler.")]
SafetyFactor = Annotated[float, typer.Option(help="Minimum breaking load divided by safe working load.")]


_FILES = ("tensions.csv", "events.csv", "tensions.png", "line.png")
"""Files of a simulation in its folder."""


@app.command()
def demo(out: Out = Path("ropeway-demo")) -> None:
    """Simulate ten minutes of an example: a mono-cable line of 24 spans, 2.4 km, with a 300 kg load every 50 m."""
    import ropeway as rw

    with errors_on_one_line(), as_file(files("ropeway.examples") / "line.csv") as supports:
        rope = rw.Rope.named("RHOL-IWRC 29")
        line = rw.monocable(rope, supports, tension=45e3, speed=1.0, load_mass=300.0, load_spacing=50.0)
        _simulate(lambda: rw.simulate(line, until=600.0, every=1.0), out)


@app.command()
@grouped
def simulate(
    line: LineOptions,
    weather: WeatherOptions,
    until: Annotated[float, typer.Option(help="Duration of the run [s].")] = 600.0,
    every: Annotated[float, typer.Option(help="Time between two rows of the tables [s].")] = 1.0,
    safety_factor: SafetyFactor = 3.0,
    report: Report = None,
    out: Out = Path("ropeway-out"),
    compiled: Compiled = False,
) -> None:
    """Simulate a mono-cable line: tensions, events and pictures."""
    import ropeway as rw

    with errors_on_one_line():
        system, environment = line.system(safety_factor), weather.environment()
        how: dict[str, Any] = {"until": until, "every": every, "compiled": compiled, "environment": environment}
        _simulate(lambda: rw.simulate(system, **how), out, report)


@dataclass(frozen=True)
class PlanOptions:
    """A schedule of the control sheaves."""

    until: Annotated[float, typer.Option(help="Duration of the schedule [s].")] = 120.0
    intervals: Annotated[int, typer.Option(help="Number of intervals of the schedule.")] = 60
    minimise: Annotated[str, typer.Option(help="Objective to minimise: peak tension, tension deviation or energy.")] = (
        "peak tension"
    )
    force: Annotated[float, typer.Option(help="Largest force of a drive [N].")] = float("inf")
    power: Annotated[float, typer.Option(help="Largest power of a drive [W].")] = float("inf")
    settle: Annotated[
        float | None,
        typer.Option(
            help="Time from which tensions count in the objective [s]; by default 10 s or a quarter of the "
            "schedule. Energy counts over the whole schedule, and limits hold from the beginning."
        ),
    ] = None
    compiled: Compiled = False


@app.command()
@grouped
def optimise(
    line: LineOptions,
    plan: PlanOptions,
    safety_factor: SafetyFactor = 3.0,
    report: Report = None,
    out: Out = Path("ropeway-schedule"),
) -> None:
    """Optimise the speeds of the control sheaves of a mono-cable line: schedules, active limits, robustness.

    The line needs at least two control sheaves.
    """
    import ropeway as rw

    with errors_on_one_line():
        system, limits = line.system(safety_factor), rw.ScheduleLimits(force=plan.force, power=plan.power)
        folder_for(out)
        cli_options.require_paths(report)
        found = rw.optimise_schedule(
            system,
            plan.until,
            limits=limits,
            minimise=plan.minimise,
            intervals=plan.intervals,
            settle=plan.settle,
            compiled=plan.compiled,
        )
        report_plan(found, out, report)


@dataclass(frozen=True)
class SkylineOptions:
    """Ropes and spars of a skyline."""

    skyline: Annotated[str, typer.Option(help="Name of the skyline; `ropeway ropes` lists them.")] = "RHOL-IWRC 29"
    mainline: Annotated[
        str | None,
        typer.Option(help="Name of the mainline; otherwise an ideal holding force acts at each station."),
    ] = None
    tension: Annotated[float, typer.Option(help="Tension of the bare skyline at the headspar [N].")] = 70e3
    head: Annotated[float | None, typer.Option(help="Station of the headspar [m]; by default the first.")] = None
    tail: Annotated[float | None, typer.Option(help="Station of the tailspar [m]; by default the last.")] = None
    head_height: Annotated[float, typer.Option(help="Height of the headspar [m].")] = 15.0
    tail_height: Annotated[float, typer.Option(help="Height of the tailspar [m].")] = 8.0
    support: Annotated[
        list[str] | None, typer.Option(help="Intermediate support as STATION:HEIGHT [m]; repeat the option for more.")
    ] = None
    kind: Annotated[str, typer.Option(help="Kind of rig: standing, live, gravity or running.")] = "standing"
    start: Annotated[
        str | None, typer.Option(help="Where the corridor begins on a raster, as EASTING,NORTHING in its system.")
    ] = None
    end: Annotated[str | None, typer.Option(help="Where the corridor ends on a raster.")] = None
    catalogue: Catalogue = None


@dataclass(frozen=True)
class PayloadOptions:
    """Carriage, limits and stations of a payload study."""

    carriage_mass: Annotated[float, typer.Option(help="Mass of the carriage [kg].")] = 450.0
    load_depth: Annotated[
        float, typer.Option(help="Distance from the skyline down to the lowest point of the load [m].")
    ] = 0.0
    safety_factor: SafetyFactor = 3.0
    clearance: Annotated[float, typer.Option(help="Smallest clearance of the load above the ground [m].")] = 1.0
    spacing: Annotated[float, typer.Option(help="Distance between stations [m].")] = 10.0
    compiled: Compiled = False


@app.command()
@grouped
def payload(
    corridor: Annotated[
        Path,
        typer.Argument(
            help="Ground of the corridor: CSV or Excel with columns station,elevation [m]; a raster of elevations, "
            "with --start and --end; or a project file of a rig."
        ),
    ],
    rig: SkylineOptions,
    limits: PayloadOptions,
    weather: WeatherOptions,
    report: Annotated[
        list[Path] | None,
        typer.Option(help="Write a report too, .html or .pdf; repeat the option for both. Needs the extra `report`."),
    ] = None,
    gis: Annotated[
        list[Path] | None,
        typer.Option(help="Write a map file too: .gpkg, .geojson, .dxf, .kml or .gpx; repeat the option for more."),
    ] = None,
    out: Out = Path("ropeway-payload"),
) -> None:
    """Calculate the largest payload at stations along a skyline, and its limits.

    A project file has its own rig: of the options only those of limits, stations and weather count, others are refused.
    """
    import ropeway as rw
    from ropeway.systems.studies.skyline.payload.command import payload_command, write_payload

    with errors_on_one_line():
        folder_for(out)
        cli_options.require_paths(*(report or ()), gis=gis or ())
        if cli_projects.is_project(corridor):
            cli_options.require_defaults(rig, corridor)
            project = rw.load(corridor)
            study = cli_projects.study_of(
                project,
                limits.safety_factor,
                limits.clearance,
                limits.spacing,
                environment=weather.environment(),
                compiled=limits.compiled,
            )
            paths = write_payload(study, out)
        else:
            study, paths = payload_command(_request(corridor, rig, limits, weather), out)
        for path in report or ():
            study.report(path)
        for path in gis or ():
            rw.export_gis(study, path)
        frame = study.frame
        rows = [[f"{r.station:.0f}", at_most(float(r.payload)), str(r.limited_by)] for r in frame.itertuples()]
        print_table(f"Payload along {corridor.stem}", ["station [m]", "payload [kg]", "limited by"], rows)
        worst = study.limiting
        typer.echo(
            f"Largest payload {at_most(study.payload)} kg, limited at {worst.station:.0f} m by {worst.limited_by}."
        )
        for remark in study.remarks:
            typer.echo(f"{remark}.")
        typer.echo(f"Written to {paths[0].parent.resolve()}: {', '.join(p.name for p in paths)}")


def _request(corridor: Path, rig: SkylineOptions, limits: PayloadOptions, weather: WeatherOptions) -> CorridorRequest:
    """What the options ask for. Raises InputError, UnknownNameError."""
    from ropeway.components.rope import Rope
    from ropeway.systems.studies.skyline.payload.command import CorridorRequest

    own = None if rig.catalogue is None else str(rig.catalogue)
    return CorridorRequest(
        corridor=corridor,
        skyline=Rope.named(rig.skyline, catalogue=own),
        mainline=None if rig.mainline is None else Rope.named(rig.mainline, catalogue=own),
        tension=rig.tension,
        head=rig.head,
        tail=rig.tail,
        head_height=rig.head_height,
        tail_height=rig.tail_height,
        supports=tuple(rig.support or ()),
        kind=rig.kind,
        start=rig.start,
        end=rig.end,
        environment=weather.environment(),
        **asdict(limits),
    )


@app.command()
def ropes(
    catalogue: Catalogue = None,
    search: Annotated[str, typer.Option(help="Only ropes with this text in their name.")] = "",
) -> None:
    """List the ropes of the catalogue, those of a table of yours first."""
    import ropeway as rw

    with errors_on_one_line():
        table = rw.ropes() if catalogue is None else rw.ropes(catalogue)
    table = table[table.index.str.contains(search, case=False, regex=False)]
    print_table(
        "Ropes of the catalogue",
        ["name", "diameter [mm]", "mass [kg/m]", "EA [MN]", "MBL [kN]", "source"],
        [
            [
                str(name),
                f"{r.diameter * 1e3:.2f}",
                f"{r.mass_per_length:.2f}",
                f"{r.axial_stiffness / 1e6:.1f}",
                at_most(r.breaking_load / 1e3, 1),
                str(r.source).partition(";")[0],
            ]
            for name, r in zip(table.index, table.itertuples(), strict=True)
        ],
    )


@cache_commands.command("info")
def cache_information() -> None:
    """Show where compiled libraries are kept, how many there are, and their size."""
    from ropeway.systems.native.binary_cache import cache_info

    found = cache_info()
    typer.echo(f"{found.libraries} libraries, {found.size / 1e6:.1f} MB, in {found.folder}")


@cache_commands.command("clear")
def clear() -> None:
    """Remove all compiled libraries that are kept: they are compiled again when they are needed."""
    from ropeway.systems.native.binary_cache import cache_folder, clear_cache

    with errors_on_one_line():
        typer.echo(f"{clear_cache()} libraries removed from {cache_folder()}")


def _simulate(run: Callable[[], Result], out: Path, report: Path | None = None) -> None:
    """Runs a simulation, writes its tables and pictures, and prints a summary.

    After an error or interrupt the results up to then are written.
    """
    from ropeway.systems.dynamics.result import Result

    folder_for(out)
    cli_options.require_paths(report)
    try:
        result = run()
    except (Interrupted, SimulationError) as error:
        if isinstance(error.result, Result) and len(error.result.frame):
            _write(error.result, out)
            typer.echo(f"ropeway: the first {error.result.times[-1]:.6g} s are in {out.resolve()}", err=True)
        raise
    written = _write(result, out)
    if report is not None:
        result.report(report)
    _report(result)
    typer.echo(f"Written to {out.resolve()}: {', '.join(written)}")


def _write(result: Result, out: Path) -> list[str]:
    """Writes tensions, events and pictures; returns the names of the files."""
    tensions, events, over_time, line = (out / f"{name}" for name in _FILES)
    columns = result.frame.filter(regex=r"\.(tension_in|tension_out|rope_tension|tension_a|tension_b)$")
    write_table(columns, tensions)
    write_table(result.events, events)
    with whole(over_time) as file:
        result.plot().savefig(file, dpi=130)
    with whole(line) as file:
        result.plot_line(time=float(result.times[-1]) / 2.0).savefig(file, dpi=130)
    return list(_FILES)


def _report(result: Result) -> None:
    """Prints a summary: tensions at the drives, highest and lowest tension, events."""
    frame, events, rope = result.frame, result.events, result.runs[0].rope
    tensions = result.full_frame.filter(regex=r"\.(tension_in|tension_out|rope_tension)$")
    ends = result.full_frame.filter(regex=r"\.tension_[ab]$")
    driven = [n for n in result.runs[0].nodes if n.drive_speed is not None or n.set_tension is not None]
    names = [c for n in driven for c in tensions.columns if c.startswith(f"{n.name}.")]
    print_table(
        f"{result.model.name}: {len(result.runs[0].spans)} spans, {result.times[-1]:g} s",
        ["tension [kN]", "lowest", "mean", "highest"],
        [
            [
                c,
                at_most(tensions[c].min() / 1e3, 1),
                f"{frame[c].mean() / 1e3:.1f}",
                at_least(tensions[c].max() / 1e3, 1),
            ]
            for c in names
        ],
    )
    place, highest = ends.max().idxmax(), float(ends.max().max())
    typer.echo(
        f"Highest tension {at_least(highest / 1e3, 1)} kN at {place} (t = {ends[place].idxmax():.1f} s); "
        f"SWL {at_most(rope.safe_working_load / 1e3, 1)} kN, MBL {at_most(rope.breaking_load / 1e3, 1)} kN. "
        f"Lowest {at_most(ends.min().min() / 1e3, 1)} kN."
    )
    if highest > rope.breaking_load >= ends.iloc[0].max():  # at rest the equilibrium has warned
        typer.echo("ropeway: warning: the highest tension is above the minimum breaking load of the rope", err=True)
    elif rope.breaking_load >= highest > rope.safe_working_load:
        typer.echo("ropeway: warning: the highest tension is above the safe working load of the rope", err=True)
    counts = events["event"].value_counts()
    typer.echo("Events: " + (", ".join(f"{n} {name}" for name, n in counts.items()) or "none"))


if __name__ == "__main__":
    app()
