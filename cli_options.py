"""Code that commands share: groups of options, folders, errors and warnings."""

from __future__ import annotations

import inspect
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO, get_type_hints

import typer

from ropeway.components.errors import InputError, RopewayError, RopewayWarning, WriteError

if TYPE_CHECKING:
    from ropeway.components.environment import Environment
    from ropeway.systems.modelling.system import System

INTERRUPTED = 130
"""Exit code after Ctrl-C, as in shells."""


@dataclass(frozen=True)
class LineOptions:
    """A mono-cable line."""

    line: Annotated[
        Path,
        typer.Argument(
            help="Supports: CSV or Excel with columns name,x,y,z,kind (metres; kind: anchor, "
            "drum, idler, control, return), in the order of the rope; or a project file of a line."
        ),
    ]
    rope: Annotated[str, typer.Option(help="Name of the rope; `ropeway ropes` lists them.")] = "RHOL-IWRC 29"
    tension: Annotated[float, typer.Option(help="Tension of the empty rope at the first support [N].")] = 45e3
    speed: Annotated[float, typer.Option(help="Speed of the rope [m/s]; negative: backwards.")] = 1.0
    load_mass: Annotated[float, typer.Option(help="Mass of each load [kg].")] = 300.0
    load_spacing: Annotated[float, typer.Option(help="Length of rope between two loads [m].")] = 50.0
    catalogue: Annotated[Path | None, typer.Option(help="A table of ropes of your own, CSV, Excel or TOML.")] = None

    def system(self, safety_factor: float = 3.0) -> System:
        """The line. Raises InputError, UnknownNameError, SlackRopeError."""
        from ropeway.components.rope import Rope
        from ropeway.systems.modelling.system import System
        from ropeway.systems.rigs.monocable import monocable
        from ropeway.systems.studies.saved_files import load

        if self.line.suffix.lower() == ".json":
            found = load(self.line)
            if not isinstance(found, System):
                raise InputError(f"{self.line} holds a {type(found).__name__}", "Name a project file of a line")
            require_defaults(self, self.line, safety_factor)
            return found
        own = None if self.catalogue is None else str(self.catalogue)
        return monocable(
            Rope.named(self.rope, safety_factor=safety_factor, catalogue=own),
            self.line,
            tension=self.tension,
            speed=self.speed,
            load_mass=self.load_mass,
            load_spacing=self.load_spacing,
            name=self.line.stem,
        )


@dataclass(frozen=True)
class WeatherOptions:
    """Weather; without an option the ropes stand in none, at the temperature at which they were strung."""

    temperature: Annotated[float | None, typer.Option(help="Temperature of the ropes [degrees C].")] = None
    ice: Annotated[float, typer.Option(help="Thickness of ice on the ropes [m].")] = 0.0
    wind_pressure: Annotated[float, typer.Option(help="Dynamic pressure of the wind [Pa].")] = 0.0
    wind_from: Annotated[
        float, typer.Option(help="Direction that the wind comes from, clockwise from grid north or +y [degrees].")
    ] = 0.0

    def environment(self) -> Environment | None:
        """The weather; None without an option. Raises InputError."""
        from ropeway.components.environment import Environment

        if self == WeatherOptions():
            return None
        return Environment(
            "weather",
            temperature=self.temperature,
            ice_thickness=self.ice,
            wind_pressure=self.wind_pressure,
            wind_from=self.wind_from,
        )


def require_defaults(options: Any, project: Path, safety_factor: float = 3.0) -> None:
    """Raises InputError for options that would not count, as a project file has its own values."""
    values = {f.name: (getattr(options, f.name), f.default) for f in fields(options) if f.default is not MISSING}
    given = [name for name, (value, default) in values.items() if value not in (default, [])]
    given += [] if safety_factor == 3.0 else ["safety_factor"]
    if given:
        names = ", ".join(f"--{name.replace('_', '-')}" for name in given)
        raise InputError(f"{project} is a project file with values of its own", f"Edit it, and leave out {names}")


def require_paths(*reports: Path | None, gis: Sequence[Path] = ()) -> None:
    """Raises InputError, WriteError where a report or a map file cannot be written, before a study is run."""
    from ropeway.systems.exchange.gis import require_gis_path
    from ropeway.systems.reporting.document import require_report_path

    for report in reports:
        if report is not None:
            require_report_path(report)
    for path in gis:
        require_gis_path(path)


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """A command for Typer; each parameter that is a dataclass becomes an option for each of its fields."""
    parameters: list[inspect.Parameter] = []
    groups: dict[str, Any] = {}
    for name, parameter in inspect.signature(command, eval_str=True).parameters.items():
        if is_dataclass(parameter.annotation):
            groups[name] = parameter.annotation
            hints = get_type_hints(parameter.annotation, include_extras=True)
            parameters += [_option(field, hints[field.name]) for field in fields(parameter.annotation)]
        else:
            parameters.append(parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY))

    def flat(**values: Any) -> None:
        for name, kind in groups.items():
            values[name] = kind(**{field.name: values.pop(field.name) for field in fields(kind)})
        command(**values)

    flat.__name__, flat.__doc__ = command.__name__, command.__doc__
    flat.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    vars(flat)["__signature__"] = inspect.Signature(parameters)
    return flat


def _option(field: Field[Any], hint: Any) -> inspect.Parameter:
    default = inspect.Parameter.empty if field.default is MISSING else field.default
    return inspect.Parameter(field.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hint)


@contextmanager
def errors_on_one_line() -> Iterator[None]:
    """Shows errors and warnings as one line each.

    An error ends the command with exit code 1, Ctrl-C with 130. Any other exception is a bug and shows its traceback.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("always", RopewayWarning)
            warnings.showwarning = _show_warning
            yield
    except KeyboardInterrupt as error:
        typer.echo("ropeway: interrupted", err=True)
        raise typer.Exit(INTERRUPTED) from error
    except BrokenPipeError as error:
        # The reader closed the pipe. The buffers are discarded, so that no error follows at the exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(1) from error
    except RopewayError as error:
        typer.echo(f"ropeway: {_line(error)}", err=True)
        raise typer.Exit(1) from error
    except OSError as error:
        typer.echo(f"ropeway: {error.filename or 'file'}: {error.strerror or error}", err=True)
        raise typer.Exit(1) from error


def folder_for(path: Path) -> Path:
    """The folder for results, created if it does not exist. Raises WriteError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if path.is_file() else error.strerror or str(error)
        raise WriteError(f"{path} cannot be used as a folder: {reason}", "Choose another with --out") from error
    return path


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    typer.echo(f"ropeway: warning: {_line(message)}", err=True)


def _line(message: object) -> str:
    return " ".join(str(message).split())
