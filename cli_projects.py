"""Commands on project files: `ropeway new`, `ropeway compare`, and what a command's first argument stands for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ropeway.cli_options import errors_on_one_line, folder_for
from ropeway.components.errors import InputError
from ropeway.components.rounding import at_most
from ropeway.components.whole_files import whole

if TYPE_CHECKING:
    from ropeway.components.environment import Environment
    from ropeway.systems.studies.skyline.payload.study import PayloadStudy

Kind = Annotated[str, typer.Option(help="Kind: standing, live, gravity, running or monocable.")]


def new(
    path: Annotated[Path, typer.Argument(help="The project file to write, such as line.json.")], kind: Kind = "standing"
) -> None:
    """Write a commented project file to edit."""
    with errors_on_one_line():
        if kind not in TEMPLATES:
            raise InputError(f"There is no kind {kind!r}", f"Choose {', '.join(TEMPLATES)}")
        if path.exists():
            raise InputError(f"{path} exists", "Choose another name, or remove it first")
        with whole(path) as file:
            file.write_text(TEMPLATES[kind], encoding="utf-8", newline="\n")
        command = "simulate" if kind == "monocable" else "payload"
        typer.echo(f"Written to {path.resolve()}. Edit it, then: ropeway {command} {path}")


def compare(
    projects: Annotated[list[Path], typer.Argument(help="Project files of rigs, or archives of payload studies.")],
    safety_factor: Annotated[float, typer.Option(help="Minimum breaking load divided by safe working load.")] = 3.0,
    clearance: Annotated[float, typer.Option(help="Smallest clearance of the load above the ground [m].")] = 1.0,
    out: Annotated[Path, typer.Option(help="Folder for the table and the picture.")] = Path("ropeway-compare"),
) -> None:
    """Compare variants side by side: their payloads as a table and a picture."""
    import ropeway as rw
    from ropeway.systems.studies.skyline.payload.study import PayloadStudy

    with errors_on_one_line():
        folder_for(out)
        studies = []
        for path in projects:
            found = rw.load(path)
            studies.append(
                found if isinstance(found, PayloadStudy) else study_of(found, safety_factor, clearance, 10.0)
            )
        names = [path.stem for path in projects]
        comparison = rw.compare(*studies, names=names if len(set(names)) == len(names) else [str(p) for p in projects])
        comparison.to_csv(out / "comparison.csv")
        with whole(out / "comparison.png") as file:
            comparison.plot().savefig(file, dpi=110)
        for name, row in comparison.frame.iterrows():
            where = f"limited at {row['at_station']:.0f} m by {row['limited_by']}"
            typer.echo(f"{name}: {at_most(row['payload'])} kg, {where}")
        typer.echo(f"Written to {out.resolve()}: comparison.csv, comparison.png")


def is_project(path: Path) -> bool:
    """Whether an argument is a project file or an archive, not a table."""
    return path.suffix.lower() in (".json", ".zip")


def study_of(
    project: Any,
    safety_factor: float,
    clearance: float,
    spacing: float,
    *,
    environment: Environment | None = None,
    compiled: bool = False,
) -> PayloadStudy:
    """The payload study of what a project file holds. Raises InputError."""
    import ropeway as rw
    from ropeway.systems.studies.skyline.load_path import default_stations

    if isinstance(project, rw.StudyInputs) and project.study == "payload":
        if environment is not None:
            raise InputError("The project holds a study with its own arguments", "Give its weather in the file")
        study: PayloadStudy = rw.run_study(project)
        return study
    if not isinstance(project, rw.SkylineRig):
        raise InputError(f"The project holds a {type(project).__name__}", "Name a project file of a skyline rig")
    over_ground = None if project.terrain is None else clearance
    stations = default_stations(project, spacing)
    limits: dict[str, Any] = {"safety_factor": safety_factor, "clearance": over_ground, "stations": stations}
    return rw.payload(project, **limits, environment=environment, compiled=compiled)


_ROPES = """  // Ropes, from the certificate. A name of the catalogue (ropeway ropes) needs no entry.
  "ropes": {
    "main": {"mass_per_length": 0.73, "axial_stiffness": 8.0e6, "breaking_load": 120.0e3, "diameter": 0.0125}
  },
"""
_GROUND = """  // The ground: station [m] and elevation [m]; or the path of a table: "terrain": "corridor.csv".
  "terrain": {"type": "Profile", "station": [0, 120, 260, 400, 490], "elevation": [846, 792, 771, 733, 717]},
"""
_SPARS = """  // Spars stand on the ground at a station [m], height [m] to the top.
  "headspar": {"type": "HeadSpar", "name": "head", "station": 0, "height": 15},
  "tailspar": {"type": "TailSpar", "name": "tail", "station": 480, "height": 8},
"""
_SUPPORTS = """  // Intermediate supports, in the order of their stations; also radius [m] of the shoe, capacity [N].
  "supports": [
    {"type": "IntermediateSupport", "name": "jack", "station": 260, "height": 9}
  ],
"""
_CARRIAGE = """  // The carriage: mass [kg]; depth [m] from the skyline down to the lowest point of the load.
  "carriage": {"type": "Carriage", "name": "carriage", "mass": 450, "depth": 3}
}
"""
_HEAD = """// A project of ropeway. Lines that begin with two slashes are comments. Units are SI: m, kg, N, s.
{
  "ropeway": 1,
"""


def _skyline(kind: str, ropes: str, middle: str = "") -> str:
    names = f'  "kind": "{kind} skyline",\n  "name": "my {kind} skyline",\n'
    return "".join((_HEAD, names, _ROPES, ropes, _GROUND, _SPARS, middle, _CARRIAGE))


_CARRYING = """  // The skyline, and its tension [N] when bare, at the headspar.
  "skyline": "RHOL-IWRC 29",
  "tension": 70.0e3,
"""
_MAIN = '  // The mainline from the yarder to the carriage.\n  "mainline": "main",\n'
_MONOCABLE = (
    _HEAD
    + """  "kind": "monocable",
  "name": "my line",
  // A rope of the catalogue (ropeway ropes), or of a table of ropes in this file.
  "rope": "RHOL-IWRC 29",
  // Tension of the empty rope at the first support [N], speed [m/s], mass [kg] and spacing [m] of the loads.
  "tension": 45.0e3,
  "speed": 1.0,
  "load_mass": 300,
  "load_spacing": 50,
  // Supports in the order of the rope [m]; kind: anchor, drum, idler, control. Or a path: "supports": "line.csv".
  "supports": [
    ["name", "x", "y", "z", "kind"],
    ["valley", 0, 0, 0, "drum"],
    ["s1", 110, 0, 12, "idler"],
    ["c1", 215, 0, 25, "control"],
    ["s2", 320, 0, 41, "idler"],
    ["mountain", 430, 0, 52, "drum"]
  ]
}
"""
)
TEMPLATES: Mapping[str, str] = {
    "standing": _skyline("standing", _CARRYING + _MAIN, _SUPPORTS),
    "live": _skyline("live", _CARRYING + _MAIN, _SUPPORTS),
    "gravity": _skyline("gravity", _CARRYING + _MAIN),
    "running": _skyline(
        "running",
        "  // The haulback carries the carriage, at this tension [N] of its drum.\n"
        '  "haulback": "6x19 EEIP 25",\n  "tension": 60.0e3,\n' + _MAIN,
    ),
    "monocable": _MONOCABLE,
}
"""Commented project files by kind."""
