"""Slaves as they are declared: FMU, start values, steps of their own; and the units of their connections."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from ropeway.components import check, units
from ropeway.components.errors import InputError
from ropeway.fmu.errors import FmuVariableError
from ropeway.fmu.importing.fmu_file import Fmu
from ropeway.fmu.importing.variable_types import Value


@dataclass(frozen=True)
class Participant:
    """A slave of a co-simulation; `open`: inputs that need a value; `step`: its own step [s], if not the master's."""

    fmu: Fmu
    kind: str
    start: Mapping[str, Value]
    open: tuple[str, ...] = ()
    step: float | None = None


def started(fmu: Fmu, name: str, start: Mapping[str, object]) -> tuple[Fmu, dict[str, Value]]:
    """The FMU resized by structural parameters among its start values, and the other start values.

    Raises InputError, FmuVariableError.
    """
    structural = [key for key in start if key in fmu.entries and fmu.entry(key).causality == "structuralParameter"]
    if structural:
        fmu = fmu.shaped(fmu.values({key: start[key] for key in structural}))
    for key, value in start.items():
        if key in fmu.entries and fmu.entry(key).kind == "Real":
            check.number(value, f"Slave {name!r}", key)
    values = fmu.values(start)
    for key in start:
        for entry in fmu.arrays.get(key, (key,)):
            row = fmu.variable(entry)
            if row["causality"] == "output" and pd.isna(row["start"]):
                raise FmuVariableError(f"{key!r} of {fmu.path.name} is calculated", "Give parameters and inputs", key)
    return fmu, {key: value for key, value in values.items() if key not in structural}


def conversion(source: Fmu, output: str, target: Fmu, entry: str) -> tuple[float, float]:
    """Factor and offset from one unit to another. Raises FmuVariableError."""
    first, second = source.variable(output), target.variable(entry)
    one, other = str(first["unit"]), str(second["unit"])
    differences = bool(first["relative"]), bool(second["relative"])
    try:
        return units.conversion(one, other, source.units, target.units, differences=differences)
    except InputError as error:
        raise FmuVariableError(
            f"{output!r} of {source.path.name} is in {one}, {entry!r} of {target.path.name} in {other}: {error.cause}",
            error.remedy,
            entry,
        ) from error
