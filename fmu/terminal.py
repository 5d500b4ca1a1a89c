"""What commands share: options of a line, and how they tell of a wrong input."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

from ropeway.components.errors import RopewayError

RopeName = Annotated[str, typer.Option(help="Name of a rope; `ropeway ropes` lists them.")]
Tension = Annotated[float, typer.Option(help="Tension of the empty rope at the first support [N].")]
LoadMass = Annotated[float, typer.Option(help="Mass of each load [kg].")]
LoadSpacing = Annotated[float, typer.Option(help="Rope between two loads [m].")]


@contextmanager
def errors_on_one_line() -> Iterator[None]:
    """A wrong input ends with exit code 1 and one line; anything else is a bug and shows its traceback."""
    try:
        yield
    except (RopewayError, OSError) as error:
        typer.echo(f"ropeway: {' '.join(str(error).split())}", err=True)
        raise typer.Exit(1) from error
