"""`ropeway fmu export LINE.csv -o line.fmu`, `ropeway fmu info X.fmu`, `ropeway fmu run X.fmu --until 60`,
`ropeway fmu ssp run YARD.ssp`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

import pandas as pd
import typer

from ropeway.cli_options import LineOptions, errors_on_one_line, grouped
from ropeway.components.table_writer import write_table

if TYPE_CHECKING:
    from ropeway.fmu.cosimulation.cosimulation import CoSimulation

app = typer.Typer(help="FMUs: export a line, describe an FMU, run an FMU.", no_args_is_help=True, rich_markup_mode=None)

ssp = typer.Typer(help="System structures (SSP): run a system of FMUs.", no_args_is_help=True, rich_markup_mode=None)
app.add_typer(ssp, name="ssp")

File = Annotated[Path, typer.Argument(help="An FMU.")]


@app.command("export")
@grouped
def export_line(
    line: LineOptions,
    out: Annotated[Path, typer.Option("--out", "-o", help="The FMU to write.")] = Path("line.fmu"),
    fmi: Annotated[str, typer.Option(help="FMI version: 2.0 or 3.0.")] = "2.0",
    platform: Annotated[
        list[str] | None, typer.Option(help="Platform of a binary; repeat the option for more.")
    ] = None,
) -> None:
    """Export a mono-cable line as an FMU."""
    from ropeway.fmu.exporting.export import export

    with errors_on_one_line():
        path = export(line.system(), out, cast(Literal["2.0", "3.0"], fmi), platforms=tuple(platform or ("host",)))
        typer.echo(f"Written to {path.resolve()} ({path.stat().st_size / 1e3:.0f} kB)")


@app.command()
def info(file: File) -> None:
    """Describe an FMU: inputs, outputs and parameters."""
    from ropeway.fmu.importing.fmu_file import load

    with errors_on_one_line():
        fmu = load(file)
        typer.echo(f"{fmu.name}: FMI {fmu.fmi}, {', '.join(fmu.kinds)}; binaries: {', '.join(fmu.platforms) or 'none'}")
        for causality in ("input", "output", "parameter"):
            chosen = fmu.variables[fmu.variables["causality"] == causality]
            typer.echo(f"\n{len(chosen)} of causality {causality}")
            for name, row in chosen.iterrows():
                start = "" if row["start"] is None else f" = {row['start']}"
                typer.echo(f"  {name}{start} [{row['unit'] or '-'}]  {row['description']}")


@app.command()
def run(
    file: File,
    until: Annotated[float, typer.Option(help="End of the run [s].")],
    step: Annotated[float, typer.Option(help="Communication step [s].")] = 0.1,
    out: Annotated[Path, typer.Option("--out", "-o", help="The table to write.")] = Path("result.csv"),
    start: Annotated[
        list[str] | None, typer.Option(help="A start value as name=value; repeat the option for more.")
    ] = None,
    isolated: Annotated[bool, typer.Option("--isolated", help="Run it in a process of its own.")] = False,
    every: Annotated[float | None, typer.Option(help="Time between two rows [s]; by default each step.")] = None,
    scenario: Annotated[
        Path | None, typer.Option(help="A table of changes: time, variable (as fmu.NAME), value.")
    ] = None,
) -> None:
    """Run an FMU (Co-Simulation or Model Exchange) and write its outputs as a table."""
    from ropeway.components.errors import InputError
    from ropeway.fmu.cosimulation.cosimulation import CoSimulation
    from ropeway.fmu.importing.fmu_file import load
    from ropeway.fmu.importing.variable_types import from_text

    with errors_on_one_line():
        _require_writable(out)
        fmu = load(file)
        values = {}
        for text in start or []:
            name, equals, value = text.partition("=")
            if not equals:
                raise InputError(f"{text!r} is not name=value", "Write name=value")
            values[name] = from_text(fmu.entry(name), value)
        master = CoSimulation(step)
        master.add("fmu", fmu, start=values, isolated=isolated)
        _run(master, out, until, every=every, scenario=scenario)


@ssp.command("run")
def run_structure(
    file: Annotated[Path, typer.Argument(help="A system structure, .ssp or .ssd.")],
    until: Annotated[
        float | None, typer.Option(help="End of the run [s]; by default that of its default experiment.")
    ] = None,
    step: Annotated[float | None, typer.Option(help="Communication step [s]; by default its own.")] = None,
    isolated: Annotated[bool, typer.Option("--isolated", help="Run each FMU in a process of its own.")] = False,
    out: Annotated[Path, typer.Option("--out", "-o", help="The table to write.")] = Path("result.csv"),
) -> None:
    """Run a system of FMUs and write its outputs as a table."""
    from ropeway.components.errors import InputError
    from ropeway.fmu.cosimulation.cosimulation import CoSimulation

    with errors_on_one_line():
        _require_writable(out)
        master = CoSimulation.from_ssp(file, step=step, isolated=isolated or None)
        end = master.stop_time if until is None else until
        if end is None:
            raise InputError(f"{file} has no end of the run", "Give it with --until")
        _run(master, out, end, start_time=master.start_time)


def _require_writable(out: Path) -> None:
    """Raises InputError."""
    from ropeway.components.errors import InputError

    if not out.parent.is_dir():
        raise InputError(f"There is no folder {out.parent}", "Create it, or choose another")
    if out.is_dir():
        raise InputError(f"{out} is a folder", "Give the name of a file with --out")


def _run(master: CoSimulation, out: Path, until: float, **how: Any) -> None:
    """Runs a co-simulation and writes its table, after a failure that of the rows so far."""
    from ropeway.components.errors import Interrupted
    from ropeway.fmu.errors import FmuRunError

    try:
        typer.echo(_table(master.run(until, **how), out))
    except (FmuRunError, Interrupted) as error:
        if isinstance(error.result, pd.DataFrame) and len(error.result):
            typer.echo(_table(error.result, out), err=True)
        raise


def _table(frame: pd.DataFrame, out: Path) -> str:
    """Writes the outputs of a run with their units; returns a message."""
    named = frame.rename(columns=lambda name: name.removeprefix("fmu."))
    named.attrs = {"units": {name.removeprefix("fmu."): unit for name, unit in frame.attrs["units"].items()}}
    write_table(named, out)
    return f"{len(named)} rows of {len(named.columns)} outputs written to {out.resolve()}"
