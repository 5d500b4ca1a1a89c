"""What commands share: options of a line, folders, and how they show errors and warnings."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, TextIO

import typer

from ropeway.components.errors import RopewayError, RopewayWarning, WriteError

INTERRUPTED = 130
"""Exit code after Ctrl-C, as of shells."""

RopeName = Annotated[str, typer.Option(help="Name of the rope; `ropeway ropes` lists them.")]
Tension = Annotated[float, typer.Option(help="Tension of the empty rope at the first support [N].")]
LoadMass = Annotated[float, typer.Option(help="Mass of each load [kg].")]
LoadSpacing = Annotated[float, typer.Option(help="Length of rope between two loads [m].")]


@contextmanager
def errors_on_one_line() -> Iterator[None]:
    """Shows errors and warnings as one line each. An error ends the command with exit code 1, Ctrl-C with 130; anything
    else is a bug and shows its traceback."""
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
        # The reader has gone. What is left in the buffers goes nowhere, so that no error follows at the exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(1) from error
    except RopewayError as error:
        typer.echo(f"ropeway: {_line(error)}", err=True)
        raise typer.Exit(1) from error
    except OSError as error:
        typer.echo(f"ropeway: {error.filename or 'file'}: {error.strerror or error}", err=True)
        raise typer.Exit(1) from error


def folder_for(path: Path) -> Path:
    """The folder for results, made if it does not exist. Raises WriteError."""
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
