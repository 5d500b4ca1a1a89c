"""How commands tell of a wrong input."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import typer

from ropeway.components.errors import RopewayError


@contextmanager
def errors_on_one_line() -> Iterator[None]:
    """A wrong input ends with exit code 1 and one line; anything else is a bug and shows its traceback."""
    try:
        yield
    except (RopewayError, OSError) as error:
        typer.echo(f"ropeway: {' '.join(str(error).split())}", err=True)
        raise typer.Exit(1) from error
