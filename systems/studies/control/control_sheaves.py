"""The control sheaves of a line, and copies of the line with other responses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ropeway.components.control_sheave import ControlSheave
from ropeway.components.errors import InputError
from ropeway.components.response import Response
from ropeway.systems.modelling.system import System


def control_sheaves(line: System) -> list[str]:
    """Names of a line's control sheaves. Raises InputError if there is none."""
    names = [name for name, c in line.components.items() if isinstance(c, ControlSheave)]
    if not names:
        raise InputError(f"{line.name!r} has no control sheave", "Put a ControlSheave into the line")
    return names


def scheduled_sheaves(line: System) -> list[str]:
    """As `control_sheaves`, of a line whose speeds are optimised. Raises InputError for a line in weather too."""
    if line.environment is not None:
        raise InputError(f"Schedules of {line.name!r} cannot be optimised in weather", "Optimise the line without it")
    return control_sheaves(line)


def with_responses(line: System, responses: Mapping[str, Response | None], precedence: str = "all at once") -> System:
    """The line with other responses at some of its control sheaves, by name."""
    other = line.copy()
    other.precedence = precedence
    for name, response in responses.items():
        sheave = other.components[name]
        if isinstance(sheave, ControlSheave):
            other.components[name] = replace(sheave, response=response)
    return other
