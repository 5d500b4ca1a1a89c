"""`ropeway cases`: a line or a rig in load cases from a table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ropeway.cli_options import LineOptions, errors_on_one_line, folder_for, grouped, require_defaults, require_paths
from ropeway.cli_plan import print_table
from ropeway.cli_projects import is_project
from ropeway.components.errors import InputError
from ropeway.components.rounding import at_least, at_most
from ropeway.components.table_writer import write_table
from ropeway.components.whole_files import whole

if TYPE_CHECKING:
    from ropeway.systems.modelling.system import System
    from ropeway.systems.rigs.skyline_rig import SkylineRig
    from ropeway.systems.studies.load_cases.study import LoadCases

_MOST = 24
"""Most cases that are printed: those that use most of the tension allowed."""


@grouped
def cases(
    line: LineOptions,
    table: Annotated[
        Path,
        typer.Argument(
            help="Load cases: CSV or Excel with a column name, and of temperature [degC], ice_thickness [m], "
            "wind_pressure [Pa], wind_from [degrees], loading, safety_factor those that are needed."
        ),
    ],
    loading: Annotated[
        list[str] | None,
        typer.Option(help="Loading of cases without one: empty, full, 'one side' or 'every second'; repeatable."),
    ] = None,
    rollers: Annotated[
        list[str] | None, typer.Option(help="Rollers of a support as NAME:NUMBER; repeat the option for more.")
    ] = None,
    payload: Annotated[float | None, typer.Option(help="Payload of a rig's loading full [kg].")] = None,
    safety_factor: Annotated[float, typer.Option(help="Minimum breaking load divided by safe working load.")] = 3.0,
    report: Annotated[Path | None, typer.Option(help="Write a report too, .html or .pdf.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for tables and the picture.")] = Path("ropeway-cases"),
) -> None:
    """Load cases of a line, or of the rig of a project file: tensions, forces on supports, and what governs them."""
    import ropeway as rw

    with errors_on_one_line():
        counts = _counts(rollers or [])
        of = _subject(line, safety_factor)
        folder_for(out)
        require_paths(report)
        study = rw.load_cases(of, table, loadings=loading, safety_factor=safety_factor, payload=payload)
        written = {
            "cases.csv": study.frame,
            "governing.csv": study.governing,
            "supports.csv": rw.support_table(study, rollers=counts),
        }
        for name, frame in written.items():
            write_table(frame, out / name)
        with whole(out / "cases.png") as file:
            study.plot().savefig(file, dpi=110)
        if report is not None:
            study.report(report)
        _print(study)
        typer.echo(f"Written to {out.resolve()}: {', '.join([*written, 'cases.png'])}")


def _subject(line: LineOptions, safety_factor: float) -> System | SkylineRig:
    """A line, or the rig of a project file. Raises InputError, UnknownNameError, SlackRopeError."""
    from ropeway.systems.rigs.skyline_rig import SkylineRig
    from ropeway.systems.studies.saved_files import load

    if is_project(line.line):
        found = load(line.line)
        if isinstance(found, SkylineRig):
            require_defaults(line, line.line)
            return found
        return line.system()
    return line.system(safety_factor)


def _counts(rollers: list[str]) -> dict[str, int]:
    """Numbers of rollers by support. Raises InputError."""
    found = {}
    for text in rollers:
        name, _, count = text.rpartition(":")
        if not name or not count.isdigit():
            raise InputError(f"Rollers {text!r} are not NAME:NUMBER", "Give for example s1:8")
        found[name] = int(count)
    return found


def _print(study: LoadCases) -> None:
    """Prints the cases that use most of the tension allowed."""
    frame = study.frame.sort_values("utilisation", ascending=False)
    rows = [
        [
            str(name),
            str(row["loading"]),
            at_least(row["highest_tension"] / 1e3, 1),
            str(row["span"]),
            at_most(row["safety"], 2),
            at_least(100.0 * row["utilisation"]),
            at_most(row["least_force"] / 1e3, 1)
            if "least_force" in row and row["least_force"] == row["least_force"]
            else "-",
        ]
        for name, row in frame.head(_MOST).iterrows()
    ]
    head = ["case", "loading", "tension [kN]", "span", "safety", "of allowed [%]", "least support force [kN]"]
    print_table(f"{study.of.name}: {len(frame)} load cases", head, rows)
    over = frame.index[frame["utilisation"] > 1.0 + 1e-9]
    if len(over):
        typer.echo(f"ropeway: warning: {len(over)} cases are above their allowed tension, first {over[0]!r}", err=True)
